#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/setpoint.hpp"

/// Backlash: a gear follows its motor only after the play between its teeth has been crossed. The motor goes
/// so much further whenever its axis goes the other way, and takes a fixed time to get there.

namespace inbetween {

/// The play of a gear, and how it is taken up. Illegal values are refused by whoever reads them: `ticks` is
/// at least 1, the others are finite.
struct Backlash {
  /// What is added to the motor while the axis moves against the approach, signed: below 0 where the approach
  /// is up the motor. Nothing is added while it moves with the approach.
  double distance = 0;
  bool approach_is_up = true;  ///< the direction in which the axis moves when it approaches
  std::int32_t ticks = 1;      ///< that a take-up lasts
  /// In axis units: so far must the axis come back before it goes the other way. A count of the drive: what
  /// the motor would not make is no reason to cross the play.
  double min_return = 0;
};

/// The largest velocity, acceleration and jerk of a take-up of `distance` in `seconds`: 15/8, 10/sqrt(3) and
/// 60 times distance / seconds^n, those of s^3 (10 - 15 s + 6 s^2).
constexpr std::array<double, 3> take_up_peaks(double distance, double seconds) {
  const double size = distance < 0 ? -distance : distance;
  return {1.875 * size / seconds, 5.773502691896258 * size / (seconds * seconds),
          60 * size / (seconds * seconds * seconds)};
}

/// What is added to a motor to cross the play of its gear.
///
/// Method. Each take-up is the same polynomial of degree 5 in time, from rest to rest with acceleration 0 at
/// both ends, and is not interrupted: if the axis turns again meanwhile, the return begins when it is over.
/// So whatever the axis does, the motor never does more than the axis and take_up_peaks beside each other,
/// which is what a certificate needs. (A filter that follows the direction with limits of its own, as
/// LinuxCNC has it, promises its velocity and acceleration, and no jerk.) While the axis rests, only what a
/// turn before has left to do is done, and nothing moves by being switched on.
///
/// It begins as if the axis had approached.
class TakeUp {
 public:
  TakeUp() = default;
  TakeUp(const Backlash& backlash, double tick_seconds)
      : backlash_(backlash),
        is_up_(backlash.approach_is_up),
        seconds_(static_cast<double>(backlash.ticks) * tick_seconds),
        tick_(backlash.ticks) {}

  /// One tick later the axis is at `position`. O(1).
  Setpoint follow(double position) {
    turn(position);
    if (!is_crossing() && is_owed()) {
      from_ = to_;
      to_ = target();
      tick_ = 0;
    }
    if (is_crossing()) ++tick_;
    return now();
  }
  /// Setpoints have ceased: it stays where it is. The axis may be moved meanwhile, and begins anew from where
  /// it then is.
  void halt() {
    from_ = to_ = now().position;
    tick_ = backlash_.ticks;
    has_place_ = has_moved_ = false;
  }
  /// What is added in this tick.
  [[nodiscard]] Setpoint now() const {
    if (!is_crossing()) return {.position = to_};
    const double distance = to_ - from_;
    const double s = static_cast<double>(tick_) / static_cast<double>(backlash_.ticks);
    const double left = 1 - s;
    return {.position = from_ + distance * (s * s * s * (10 + s * (6 * s - 15))),
            .velocity = distance / seconds_ * (30 * s * s * left * left),
            .acceleration = distance / (seconds_ * seconds_) * (60 * s * left * (left - s))};
  }
  /// The motor still crosses the play, or will in the next tick.
  [[nodiscard]] bool is_under_way() const { return is_crossing() || is_owed(); }

 private:
  [[nodiscard]] bool is_crossing() const { return tick_ < backlash_.ticks; }
  [[nodiscard]] bool is_owed() const { return has_moved_ && target() != to_; }
  [[nodiscard]] double target() const {
    return is_up_ == backlash_.approach_is_up ? 0.0 : backlash_.distance;
  }
  /// `furthest_` is the furthest position in the direction in which the axis goes.
  void turn(double position) {
    if (!has_place_) {
      has_place_ = true;
      furthest_ = position;
    }
    const double ahead = is_up_ ? position - furthest_ : furthest_ - position;
    if (ahead < 0 && -ahead > backlash_.min_return) {
      is_up_ = !is_up_;
    } else if (!(ahead > 0)) {
      return;
    }
    furthest_ = position;
    has_moved_ = true;
  }

  Backlash backlash_;
  bool is_up_ = true;
  bool has_place_ = false;
  bool has_moved_ = false;  ///< since setpoints came
  double furthest_ = 0;
  double seconds_ = 1;
  double from_ = 0, to_ = 0;
  std::int32_t tick_ = 1;
};

}  // namespace inbetween
