#pragma once

#include "inbetween/base/precision.hpp"

/// From one speed to another, with bounded acceleration and jerk.

namespace inbetween {

/// How quickly a speed may change: magnitudes.
template <Precise Real>
struct RampLimits {
  Real acceleration = 0;  ///< unit/s^2
  Real jerk = 0;          ///< unit/s^3
};

/// Where a ramp is: `way` from its start or, in its last bend, from its end, so that it ends there exactly.
template <Precise Real>
struct RampState {
  Real way = 0;
  bool to_end = false;
  Real velocity = 0;
  Real acceleration = 0;
};

/// The quickest change from a velocity and acceleration to another velocity that is then even: a bend to the
/// greatest acceleration, a straight stretch if that is the limit, and a bend to none; signs are the
/// caller's. Method: the speed that is reached if the acceleration is merely released tells the direction,
/// and the area under the acceleration its peak: peak^2 = jerk gain + a^2 / 2.
template <Precise Real>
class SpeedRamp {
 public:
  SpeedRamp() = default;
  /// `acceleration` is within the limits.
  static SpeedRamp between(Real from_velocity, Real acceleration, Real to_velocity,
                           const RampLimits<Real>& limits);
  /// The speed that remains if the acceleration is brought to nothing at once.
  static Real released(Real velocity, Real acceleration, Real jerk);

  [[nodiscard]] Real seconds() const { return bend_s_ + straight_s_ + release_s_; }
  /// How far it moves meanwhile, signed.
  [[nodiscard]] Real way() const { return way_; }
  [[nodiscard]] Real to_velocity() const { return to_velocity_; }
  /// So many seconds after its start, 0..seconds(). O(1).
  [[nodiscard]] RampState<Real> at(Real seconds) const;

 private:
  [[nodiscard]] RampState<Real> bend_at(Real seconds) const;

  Real from_velocity_ = 0;
  Real from_acceleration_ = 0;
  Real to_velocity_ = 0;
  Real jerk_ = 0;  ///< of the first bend, signed; the last has the opposite
  Real peak_ = 0;  ///< acceleration of the straight stretch, signed
  Real bend_s_ = 0;
  Real straight_s_ = 0;
  Real release_s_ = 0;
  Real way_ = 0;
};

extern template class SpeedRamp<double>;
extern template class SpeedRamp<float>;

}  // namespace inbetween
