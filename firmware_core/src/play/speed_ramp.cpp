#include "inbetween/play/speed_ramp.hpp"

#include <algorithm>
#include <cmath>

namespace inbetween {

template <Precise Real>
Real SpeedRamp<Real>::released(Real velocity, Real acceleration, Real jerk) {
  return velocity + acceleration * (std::fabs(acceleration) / (2 * jerk));
}

template <Precise Real>
SpeedRamp<Real> SpeedRamp<Real>::between(Real from_velocity, Real acceleration, Real to_velocity,
                                         const RampLimits<Real>& limits) {
  const Real max_acceleration = limits.acceleration;
  const Real missing = to_velocity - released(from_velocity, acceleration, limits.jerk);
  const Real sign = std::copysign(Real{1}, missing == 0 ? acceleration : missing);
  const Real a = sign * acceleration;
  const Real gain = sign * (to_velocity - from_velocity);
  SpeedRamp ramp;
  Real peak = std::sqrt(std::max(limits.jerk * gain + a * a / 2, Real{0}));
  if (peak > max_acceleration) {
    peak = max_acceleration;
    ramp.constant_s_ = std::max(
        (gain - (max_acceleration * max_acceleration - a * a / 2) / limits.jerk) / max_acceleration, Real{0});
  }
  ramp.from_velocity_ = from_velocity;
  ramp.from_acceleration_ = acceleration;
  ramp.to_velocity_ = to_velocity;
  ramp.jerk_ = sign * limits.jerk;
  ramp.peak_ = sign * peak;
  ramp.jerk_s_ = std::max((peak - a) / limits.jerk, Real{0});
  ramp.release_s_ = peak / limits.jerk;
  const RampState<Real> after_jerk = ramp.first_phase_at(ramp.jerk_s_);
  const Real y = ramp.constant_s_;
  const Real z = ramp.release_s_;
  ramp.way_ = after_jerk.way + (after_jerk.velocity + ramp.peak_ * y / 2) * y +
              (to_velocity - ramp.jerk_ * z * z / 6) * z;
  return ramp;
}

template <Precise Real>
RampState<Real> SpeedRamp<Real>::first_phase_at(Real seconds) const {
  const Real t = seconds;
  const Real gained = jerk_ * t;
  return {.way = (from_velocity_ + (from_acceleration_ / 2 + gained / 6) * t) * t,
          .to_end = false,
          .velocity = from_velocity_ + (from_acceleration_ + gained / 2) * t,
          .acceleration = from_acceleration_ + gained};
}

template <Precise Real>
RampState<Real> SpeedRamp<Real>::at(Real seconds) const {
  if (seconds < jerk_s_) return first_phase_at(seconds);
  const Real left = this->seconds() - seconds;
  if (left <= release_s_) {
    const Real a = jerk_ * left;
    return {.way = -(to_velocity_ - a * left / 6) * left,
            .to_end = true,
            .velocity = to_velocity_ - a * left / 2,
            .acceleration = a};
  }
  const RampState<Real> after_jerk = first_phase_at(jerk_s_);
  const Real y = seconds - jerk_s_;
  return {.way = after_jerk.way + (after_jerk.velocity + peak_ * y / 2) * y,
          .to_end = false,
          .velocity = after_jerk.velocity + peak_ * y,
          .acceleration = peak_};
}

template class SpeedRamp<double>;
template class SpeedRamp<float>;

}  // namespace inbetween
