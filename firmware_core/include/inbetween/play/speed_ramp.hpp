#pragma once

#include "inbetween/base/precision.hpp"

/// Changes one speed to another with bounded acceleration and jerk.

namespace inbetween {

/// How quickly a speed may change: magnitudes.
template <Precise Real>
struct RampLimits {
  Real acceleration = 0;  ///< unit/s^2
  Real jerk = 0;          ///< unit/s^3
};

/// The state of a ramp. `way` counts from its start or, in its last jerk phase, from its end, so that it ends
/// there exactly.
template <Precise Real>
struct RampState {
  Real way = 0;
  bool to_end = false;
  Real velocity = 0;
  Real acceleration = 0;
};

/// The quickest change from a velocity and an acceleration to a constant velocity. It has three phases:
/// constant jerk up to the peak acceleration, constant acceleration if the peak is the limit, and constant
/// jerk down to acceleration 0. Signs are the caller's. Method: the speed that is reached if the acceleration
/// is merely released gives the direction, and the area under the acceleration gives its peak: peak^2 = jerk
/// gain + a^2 / 2.
template <Precise Real>
class SpeedRamp {
 public:
  SpeedRamp() = default;
  /// `acceleration` is within the limits.
  static SpeedRamp between(Real from_velocity, Real acceleration, Real to_velocity,
                           const RampLimits<Real>& limits);
  /// The speed that remains if the acceleration goes to 0 in the quickest way.
  static Real released(Real velocity, Real acceleration, Real jerk);

  [[nodiscard]] Real seconds() const { return jerk_s_ + constant_s_ + release_s_; }
  /// How far it moves meanwhile, signed.
  [[nodiscard]] Real way() const { return way_; }
  [[nodiscard]] Real to_velocity() const { return to_velocity_; }
  /// The state at so many seconds after the start, 0..seconds(). O(1).
  [[nodiscard]] RampState<Real> at(Real seconds) const;

 private:
  [[nodiscard]] RampState<Real> first_phase_at(Real seconds) const;

  Real from_velocity_ = 0;
  Real from_acceleration_ = 0;
  Real to_velocity_ = 0;
  Real jerk_ = 0;  ///< in the first phase, signed; the last phase has the opposite
  Real peak_ = 0;  ///< acceleration between the jerk phases, signed
  Real jerk_s_ = 0;
  Real constant_s_ = 0;
  Real release_s_ = 0;
  Real way_ = 0;
};

extern template class SpeedRamp<double>;
extern template class SpeedRamp<float>;

}  // namespace inbetween
