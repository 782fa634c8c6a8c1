#pragma once

#include "inbetween/base/precision.hpp"

/// Changes one speed to another with bounded acceleration and jerk.

namespace inbetween {

/// How quickly a speed may change: magnitudes.
struct RampLimits {
  double acceleration = 0;  ///< unit/s^2
  double jerk = 0;          ///< unit/s^3
};

/// The state of a ramp. `distance` counts from its start or, in its last jerk phase, from its end, so that it
/// ends there exactly.
struct RampState {
  double distance = 0;
  bool to_end = false;
  double velocity = 0;
  double acceleration = 0;
};

/// The quickest change from a velocity and an acceleration to a constant velocity. It has three phases:
/// constant jerk up to the peak acceleration, constant acceleration if the peak is the limit, and constant
/// jerk down to acceleration 0. Signs are the caller's. Method: the speed that is reached if the acceleration
/// is merely released gives the direction, and the area under the acceleration gives its peak: peak^2 = jerk
/// gain + a^2 / 2.
class SpeedRamp {
 public:
  SpeedRamp() = default;
  /// `acceleration` is within the limits.
  static SpeedRamp between(double from_velocity, double acceleration, double to_velocity,
                           const RampLimits& limits);
  /// The speed that remains if the acceleration goes to 0 in the quickest way.
  static double released(double velocity, double acceleration, double jerk);

  [[nodiscard]] double seconds() const { return jerk_s_ + constant_s_ + release_s_; }
  /// How far it moves meanwhile, signed.
  [[nodiscard]] double distance() const { return distance_; }
  [[nodiscard]] double to_velocity() const { return to_velocity_; }
  /// The state at so many seconds after the start, 0..seconds(). O(1).
  [[nodiscard]] RampState at(double seconds) const;

 private:
  [[nodiscard]] RampState first_phase_at(double seconds) const;

  double from_velocity_ = 0;
  double from_acceleration_ = 0;
  double to_velocity_ = 0;
  double jerk_ = 0;  ///< in the first phase, signed; the last phase has the opposite
  double peak_ = 0;  ///< acceleration between the jerk phases, signed
  double jerk_s_ = 0;
  double constant_s_ = 0;
  double release_s_ = 0;
  double distance_ = 0;
};

}  // namespace inbetween
