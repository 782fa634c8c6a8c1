#pragma once

#include <cstddef>
#include <cstdint>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/result.hpp"
#include "inbetween/base/setpoint.hpp"
#include "inbetween/play/speed_ramp.hpp"

/// Moves an axis without a drawn move: to set it up, to look for its switch, to go to a place.

namespace inbetween {

/// The limits of a free axis in axis units and seconds. They are magnitudes, except min and max. If the rig
/// limits no jerk, the caller chooses the seconds in which the acceleration builds up (jerk = acceleration /
/// seconds): without any limit a stop would be a step of the force.
struct FreeAxisLimits {
  double velocity = 0;      ///< unit/s
  double acceleration = 0;  ///< unit/s^2
  double jerk = 0;          ///< unit/s^3
  double min = 0;           ///< soft limits: it moves and rests between them
  double max = 0;
  double stop_share = 1;  ///< of acceleration and jerk, what a stop may use; at least 1
};

/// One axis, moved by velocity or to a position, with bounded velocity, acceleration and jerk.
///
/// Method: every command plans the whole motion until rest at once: the quickest ramp to a speed, that speed
/// for a while, the quickest ramp to rest (at most seven phases of constant jerk). A driven motion ends at
/// the soft limit ahead, so that no tick has to watch for it. Ticks evaluate the plan in closed form, from
/// its start or, in the last jerk phase, from its end. Therefore no error accumulates, the jerk may change
/// anywhere within a tick, and the axis rests on its target to the last bit. From rest to rest this is the
/// quickest motion within the limits. If the distance is too short for the speed, the command (not the tick)
/// finds the highest speed that fits by bisection.
///
/// A stop never rests further than the motion that it interrupts, so that the soft limits hold for every
/// command at every moment. An axis outside its soft limits (unreferenced, or moved by hand) moves only
/// towards the inside, and is never further outside than it was.
class FreeAxis {
 public:
  /// Makes an axis at rest at `position`, which may be outside the soft limits. Ticks are `tick_seconds`
  /// apart. Errors: not_finite, out_of_range (a limit or tick_seconds that is not above 0, min >= max, a stop
  /// from full speed that is longer than Precision::largest; a stop_share below 1).
  static Result<FreeAxis> make(const FreeAxisLimits& limits, double position, double tick_seconds);

  /// Drives at a signed velocity until the soft limit ahead stops the axis; 0 is stop(). The velocity that is
  /// commanded already changes nothing. Errors: not_finite; out_of_range (faster than the limit; at or beyond
  /// the soft limit in that direction).
  Status drive(double velocity);
  /// Goes exactly to a position, at most at the velocity of the limits, from any state. An axis that is too
  /// fast to rest there comes back. Errors: not_finite; out_of_range (outside the soft limits).
  Status go_to(double position) { return go_to(position, limits_.velocity); }
  /// Goes to a position at most at `speed` > 0, once it has slowed down to it. Errors: also out_of_range
  /// (faster than the limit, not above 0).
  Status go_to(double position, double speed);
  /// Stops as soon as the limits allow. This is always possible.
  void stop();
  /// Puts the axis at rest at once, where it is. Use it only for an axis whose setpoints are no longer sent.
  void halt();
  /// Sets the position of an axis at rest without a motion. Errors: not_finite, out_of_range (beyond
  /// Precision::largest), wrong_state (not resting).
  Status place(double position);
  /// Sets other soft limits. Errors: not_finite, out_of_range (min >= max), wrong_state
  /// (not resting).
  Status set_range(double min, double max);

  /// One tick later. O(1).
  Setpoint tick();

  [[nodiscard]] const Setpoint& state() const { return state_; }
  [[nodiscard]] double position() const { return state_.position; }
  [[nodiscard]] bool is_resting() const { return activity_ == Activity::resting; }
  /// The position where it comes to rest if no other command follows.
  [[nodiscard]] double end() const { return end_; }
  /// The distance (signed) and the seconds that a stop from here takes.
  [[nodiscard]] double stop_distance() const { return stop_ramp().distance(); }
  [[nodiscard]] double stop_seconds() const { return stop_ramp().seconds(); }
  [[nodiscard]] const FreeAxisLimits& limits() const { return limits_; }

 private:
  enum class Activity : std::uint8_t { resting, driving, travelling, stopping };

  FreeAxis(const FreeAxisLimits& limits, double position, double tick_seconds)
      : limits_(limits), tick_s_(tick_seconds), from_(position), end_(position) {
    state_.position = position;
  }

  [[nodiscard]] RampLimits ramp() const { return {limits_.acceleration, limits_.jerk}; }
  [[nodiscard]] SpeedRamp ramp_to_rest(const RampLimits& limits) const;
  [[nodiscard]] SpeedRamp stop_ramp() const {
    return ramp_to_rest({limits_.stop_share * limits_.acceleration, limits_.stop_share * limits_.jerk});
  }
  [[nodiscard]] double distance_over(double velocity) const;
  [[nodiscard]] double top_speed(double direction, double speed, double room) const;
  void head_for(double position, double speed, Activity activity);
  [[nodiscard]] Setpoint at(double seconds) const;
  [[nodiscard]] double inside(double position) const;
  void rest_at(double position);

  FreeAxisLimits limits_;
  double tick_s_;
  Setpoint state_;
  Activity activity_ = Activity::resting;
  double driven_ = 0;  ///< the velocity commanded, while driving

  // The motion under way.
  SpeedRamp rise_;  ///< to the constant speed, which may be below the speed at the start
  SpeedRamp fall_;  ///< to rest
  double even_s_ = 0;
  double from_;  ///< where it began ...
  double risen_ = 0;
  double end_;  ///< ... and where it will rest
  std::int64_t ticks_ = 0;
};

}  // namespace inbetween
