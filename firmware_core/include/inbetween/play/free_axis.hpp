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
template <Precise Real>
struct FreeAxisLimits {
  Real velocity = 0;      ///< unit/s
  Real acceleration = 0;  ///< unit/s^2
  Real jerk = 0;          ///< unit/s^3
  Real min = 0;           ///< soft limits: it moves and rests between them
  Real max = 0;
  Real stop_share = 1;  ///< of acceleration and jerk, what a stop may use; at least 1
};

/// One axis, moved by velocity or to a position, with bounded velocity, acceleration and jerk.
///
/// Method: every command plans the whole motion until rest at once: the quickest ramp to a speed, that speed
/// for a while, the quickest ramp to rest (at most seven phases of constant jerk). A driven motion ends at
/// the soft limit ahead, so that no tick has to watch for it. Ticks evaluate the plan in closed form, from
/// its start or, in the last jerk phase, from its end. Therefore no error accumulates, the jerk may change
/// anywhere within a tick, and the axis rests on its target to the last bit. From rest to rest this is the
/// quickest motion within the limits. If the way is too short for the speed, the command (not the tick) finds
/// the highest speed that fits by bisection.
///
/// A stop never rests further than the motion that it interrupts, so that the soft limits hold for every
/// command at every moment. An axis outside its soft limits (unreferenced, or moved by hand) moves only
/// towards the inside, and is never further outside than it was.
template <Precise Real>
class FreeAxis {
 public:
  /// Makes an axis at rest at `position`, which may be outside the soft limits. Ticks are `tick_seconds`
  /// apart. Errors: not_finite, out_of_range (a limit or tick_seconds that is not above 0, min >= max, a stop
  /// from full speed that is longer than Precision<Real>::largest; a stop_share below 1).
  static Result<FreeAxis> make(const FreeAxisLimits<Real>& limits, Real position, Real tick_seconds);

  /// Drives at a signed velocity until the soft limit ahead stops the axis; 0 is stop(). The velocity that is
  /// commanded already changes nothing. Errors: not_finite; out_of_range (faster than the limit; at or beyond
  /// the soft limit in that direction).
  Status drive(Real velocity);
  /// Goes exactly to a position, at most at the velocity of the limits, from any state. An axis that is too
  /// fast to rest there comes back. Errors: not_finite; out_of_range (outside the soft limits).
  Status go_to(Real position) { return go_to(position, limits_.velocity); }
  /// Goes to a position at most at `speed` > 0, once it has slowed down to it. Errors: also out_of_range
  /// (faster than the limit, not above 0).
  Status go_to(Real position, Real speed);
  /// Stops as soon as the limits allow. This is always possible.
  void stop();
  /// Puts the axis at rest at once, where it is. Use it only for an axis whose setpoints are no longer sent.
  void halt();
  /// Sets the position of an axis at rest without a motion. Errors: not_finite, out_of_range (not resting).
  Status place(Real position);
  /// Sets other soft limits. Errors: not_finite, out_of_range (not resting; min >= max).
  Status set_range(Real min, Real max);

  /// One tick later. O(1).
  Setpoint<Real> tick();

  [[nodiscard]] const Setpoint<Real>& state() const { return state_; }
  [[nodiscard]] Real position() const { return state_.position; }
  [[nodiscard]] bool is_resting() const { return activity_ == Activity::resting; }
  /// The position where it comes to rest if no other command follows.
  [[nodiscard]] Real end() const { return end_; }
  /// The way (signed) and the seconds that a stop from here takes.
  [[nodiscard]] Real stop_distance() const { return stop_ramp().way(); }
  [[nodiscard]] Real stop_seconds() const { return stop_ramp().seconds(); }
  /// The highest velocity v within the limits from which a stop takes at most `seconds`. This holds at every
  /// moment while drive commands of at most v in either direction follow each other, also while the speed
  /// still rises. 0 if `seconds` is not above 0.
  [[nodiscard]] Real velocity_that_stops_within(Real seconds) const;
  [[nodiscard]] const FreeAxisLimits<Real>& limits() const { return limits_; }

 private:
  enum class Activity : std::uint8_t { resting, driving, travelling, stopping };

  FreeAxis(const FreeAxisLimits<Real>& limits, Real position, Real tick_seconds)
      : limits_(limits), tick_s_(tick_seconds), from_(position), end_(position) {
    state_.position = position;
  }

  [[nodiscard]] RampLimits<Real> ramp() const { return {limits_.acceleration, limits_.jerk}; }
  [[nodiscard]] SpeedRamp<Real> ramp_to_rest(const RampLimits<Real>& limits) const;
  [[nodiscard]] SpeedRamp<Real> stop_ramp() const {
    return ramp_to_rest({limits_.stop_share * limits_.acceleration, limits_.stop_share * limits_.jerk});
  }
  [[nodiscard]] Real way_over(Real velocity) const;
  [[nodiscard]] Real top_speed(Real direction, Real speed, Real room) const;
  void head_for(Real position, Real speed, Activity activity);
  [[nodiscard]] Setpoint<Real> at(Real seconds) const;
  [[nodiscard]] Real inside(Real position) const;
  void rest_at(Real position);

  FreeAxisLimits<Real> limits_;
  Real tick_s_;
  Setpoint<Real> state_;
  Activity activity_ = Activity::resting;
  Real driven_ = 0;  ///< the velocity commanded, while driving

  // The motion under way.
  SpeedRamp<Real> rise_;  ///< to the constant speed, which may be below the speed at the start
  SpeedRamp<Real> fall_;  ///< to rest
  Real even_s_ = 0;
  Real from_;  ///< where it began ...
  Real risen_ = 0;
  Real end_;  ///< ... and where it will rest
  std::int64_t ticks_ = 0;
};

extern template class FreeAxis<double>;
extern template class FreeAxis<float>;

}  // namespace inbetween
