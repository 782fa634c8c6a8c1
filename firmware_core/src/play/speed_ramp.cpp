#include "inbetween/play/speed_ramp.hpp"

#include <algorithm>
#include <cmath>

namespace inbetween {

double SpeedRamp::released(double velocity, double acceleration, double jerk) {
  return velocity + acceleration * (std::fabs(acceleration) / (2 * jerk));
}

SpeedRamp SpeedRamp::between(double from_velocity, double acceleration, double to_velocity,
                             const RampLimits& limits) {
  const double max_acceleration = limits.acceleration;
  const double missing = to_velocity - released(from_velocity, acceleration, limits.jerk);
  const double sign = std::copysign(1.0, missing == 0 ? acceleration : missing);
  const double a = sign * acceleration;
  const double gain = sign * (to_velocity - from_velocity);
  SpeedRamp ramp;
  double peak = std::sqrt(std::max(limits.jerk * gain + a * a / 2, 0.0));
  if (peak > max_acceleration) {
    peak = max_acceleration;
    ramp.constant_s_ = std::max(
        (gain - (max_acceleration * max_acceleration - a * a / 2) / limits.jerk) / max_acceleration, 0.0);
  }
  ramp.from_velocity_ = from_velocity;
  ramp.from_acceleration_ = acceleration;
  ramp.to_velocity_ = to_velocity;
  ramp.jerk_ = sign * limits.jerk;
  ramp.peak_ = sign * peak;
  ramp.jerk_s_ = std::max((peak - a) / limits.jerk, 0.0);
  ramp.release_s_ = peak / limits.jerk;
  const RampState after_jerk = ramp.first_phase_at(ramp.jerk_s_);
  const double y = ramp.constant_s_;
  const double z = ramp.release_s_;
  ramp.distance_ = after_jerk.distance + (after_jerk.velocity + ramp.peak_ * y / 2) * y +
                   (to_velocity - ramp.jerk_ * z * z / 6) * z;
  return ramp;
}

RampState SpeedRamp::first_phase_at(double seconds) const {
  const double t = seconds;
  const double gained = jerk_ * t;
  return {.distance = (from_velocity_ + (from_acceleration_ / 2 + gained / 6) * t) * t,
          .to_end = false,
          .velocity = from_velocity_ + (from_acceleration_ + gained / 2) * t,
          .acceleration = from_acceleration_ + gained};
}

RampState SpeedRamp::at(double seconds) const {
  if (seconds < jerk_s_) return first_phase_at(seconds);
  const double left = this->seconds() - seconds;
  if (left <= release_s_) {
    const double a = jerk_ * left;
    return {.distance = -(to_velocity_ - a * left / 6) * left,
            .to_end = true,
            .velocity = to_velocity_ - a * left / 2,
            .acceleration = a};
  }
  const RampState after_jerk = first_phase_at(jerk_s_);
  const double y = seconds - jerk_s_;
  return {.distance = after_jerk.distance + (after_jerk.velocity + peak_ * y / 2) * y,
          .to_end = false,
          .velocity = after_jerk.velocity + peak_ * y,
          .acceleration = peak_};
}

}  // namespace inbetween
