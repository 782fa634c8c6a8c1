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
  const Real most = limits.acceleration;
  const Real missing = to_velocity - released(from_velocity, acceleration, limits.jerk);
  const Real sign = std::copysign(Real{1}, missing == 0 ? acceleration : missing);
  const Real a = sign * acceleration;
  const Real gain = sign * (to_velocity - from_velocity);
  SpeedRamp ramp;
  Real peak = std::sqrt(std::max(limits.jerk * gain + a * a / 2, Real{0}));
  if (peak > most) {
    peak = most;
    ramp.straight_s_ = std::max((gain - (most * most - a * a / 2) / limits.jerk) / most, Real{0});
  }
  ramp.from_velocity_ = from_velocity;
  ramp.from_acceleration_ = acceleration;
  ramp.to_velocity_ = to_velocity;
  ramp.jerk_ = sign * limits.jerk;
  ramp.peak_ = sign * peak;
  ramp.bend_s_ = std::max((peak - a) / limits.jerk, Real{0});
  ramp.release_s_ = peak / limits.jerk;
  const RampState<Real> bent = ramp.bend_at(ramp.bend_s_);
  const Real y = ramp.straight_s_;
  const Real z = ramp.release_s_;
  ramp.way_ =
      bent.way + (bent.velocity + ramp.peak_ * y / 2) * y + (to_velocity - ramp.jerk_ * z * z / 6) * z;
  return ramp;
}

template <Precise Real>
RampState<Real> SpeedRamp<Real>::bend_at(Real seconds) const {
  const Real t = seconds;
  const Real gained = jerk_ * t;
  return {.way = (from_velocity_ + (from_acceleration_ / 2 + gained / 6) * t) * t,
          .to_end = false,
          .velocity = from_velocity_ + (from_acceleration_ + gained / 2) * t,
          .acceleration = from_acceleration_ + gained};
}

template <Precise Real>
RampState<Real> SpeedRamp<Real>::at(Real seconds) const {
  if (seconds < bend_s_) return bend_at(seconds);
  const Real left = this->seconds() - seconds;
  if (left <= release_s_) {
    const Real a = jerk_ * left;
    return {.way = -(to_velocity_ - a * left / 6) * left,
            .to_end = true,
            .velocity = to_velocity_ - a * left / 2,
            .acceleration = a};
  }
  const RampState<Real> bent = bend_at(bend_s_);
  const Real y = seconds - bend_s_;
  return {.way = bent.way + (bent.velocity + peak_ * y / 2) * y,
          .to_end = false,
          .velocity = bent.velocity + peak_ * y,
          .acceleration = peak_};
}

template class SpeedRamp<double>;
template class SpeedRamp<float>;

}  // namespace inbetween
