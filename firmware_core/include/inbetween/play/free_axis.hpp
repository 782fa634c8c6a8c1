#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/result.hpp"
#include "inbetween/base/setpoint.hpp"
#include "inbetween/play/speed_ramp.hpp"

/// An axis that moves without a drawn move: to set up, to look for its switch, to go to a place.

namespace inbetween {

/// What a free axis may do, in axis units and seconds: magnitudes, except for min and max. Where the rig
/// limits no jerk the caller says how soon the acceleration may be there (jerk = acceleration / seconds):
/// without any limit a stop would be a step of the force.
template <Precise Real>
struct FreeAxisLimits {
  Real velocity = 0;      ///< unit/s
  Real acceleration = 0;  ///< unit/s^2
  Real jerk = 0;          ///< unit/s^3
  Real min = 0;           ///< soft limits: it moves and rests between them
  Real max = 0;
};

/// One axis, moved by velocity or to a position, with bounded velocity, acceleration and jerk.
///
/// Method: every command makes the whole motion until rest at once: the quickest ramp to a speed, that speed
/// for a while, the quickest ramp to rest (seven phases of even jerk at most). What is driven ends at the
/// soft limit ahead, so that no tick has to notice it. Ticks evaluate this in closed form from where it
/// begins or, in the last bend, from where it ends: nothing accumulates, jerk may change anywhere within a
/// tick, and it rests on its target to the last bit. From rest to rest this is the quickest motion within the
/// limits. Where there is not the way for the speed, the highest that fits is found by bisection, on the
/// command, not on the tick.
///
/// From any state on the way the stop rests no further than the motion that it breaks off, so that the soft
/// limits hold whatever is commanded when. An axis outside of them (unreferenced, or moved by hand) can only
/// be moved towards the inside, and is never further outside than it was.
template <Precise Real>
class FreeAxis {
 public:
  /// At rest at `position`, which may be outside the soft limits; ticks are `tick_seconds` apart.
  /// Errors: not_finite, out_of_range (a limit or tick_seconds that is not above 0, min >= max, a stop from
  /// full speed that is longer than Precision<Real>::largest).
  static Result<FreeAxis> make(const FreeAxisLimits<Real>& limits, Real position, Real tick_seconds);

  /// To a velocity, signed, which it keeps until the soft limit ahead makes it stop; 0 is stop(). The
  /// velocity that it has been told already changes nothing. Errors: not_finite; out_of_range (faster than
  /// the limit; at or beyond the soft limit in that direction).
  Status drive(Real velocity);
  /// To a position, exactly, at no more than the velocity of the limits. From any state: where it is too fast
  /// to rest there it comes back. Errors: not_finite; out_of_range (outside the soft limits).
  Status go_to(Real position) { return go_to(position, limits_.velocity); }
  /// At no more than `speed` > 0, once it has slowed down to it. Errors: also out_of_range (faster than the
  /// limit, not above 0).
  Status go_to(Real position, Real speed);
  /// To rest, as soon as the limits allow. Always possible.
  void stop();
  /// At rest at once, where it is. Only for an axis that is not sent its setpoints any more.
  void halt();
  /// At rest at a position without having moved there. Errors: not_finite, out_of_range (not resting).
  Status place(Real position);
  /// Other soft limits. Errors: not_finite, out_of_range (not resting; min >= max).
  Status set_range(Real min, Real max);

  /// One tick later. O(1).
  Setpoint<Real> tick();

  [[nodiscard]] const Setpoint<Real>& state() const { return state_; }
  [[nodiscard]] Real position() const { return state_.position; }
  [[nodiscard]] bool is_resting() const { return activity_ == Activity::resting; }
  /// Where it comes to rest if nothing else is commanded.
  [[nodiscard]] Real end() const { return end_; }
  /// What a stop would take from here, signed and in seconds.
  [[nodiscard]] Real stop_distance() const { return stop_ramp().way(); }
  [[nodiscard]] Real stop_seconds() const { return stop_ramp().seconds(); }
  /// The highest velocity v within the limits for which a stop takes no longer, at whatever moment between
  /// commands to drive at up to v in either direction it comes: also while the speed still rises. 0 where
  /// `seconds` is not above 0.
  [[nodiscard]] Real velocity_that_stops_within(Real seconds) const;
  [[nodiscard]] const FreeAxisLimits<Real>& limits() const { return limits_; }

 private:
  enum class Activity : std::uint8_t { resting, driving, travelling, stopping };

  FreeAxis(const FreeAxisLimits<Real>& limits, Real position, Real tick_seconds)
      : limits_(limits), tick_s_(tick_seconds), from_(position), end_(position) {
    state_.position = position;
  }

  [[nodiscard]] RampLimits<Real> ramp() const { return {limits_.acceleration, limits_.jerk}; }
  [[nodiscard]] SpeedRamp<Real> stop_ramp() const;
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
  SpeedRamp<Real> rise_;  ///< to the even speed, which may be slower than that at the start
  SpeedRamp<Real> fall_;  ///< to rest
  Real even_s_ = 0;
  Real from_;  ///< where it began ...
  Real risen_ = 0;
  Real end_;  ///< ... and where it will rest
  std::int64_t ticks_ = 0;
};

/// Several axes that share their ticks and nothing else. Refers to the caller's axes.
template <Precise Real>
class FreeMotion {
 public:
  explicit FreeMotion(std::span<FreeAxis<Real>> axes) : axes_(axes) {}

  /// One tick later. `out` has room for every axis; otherwise the program ends.
  void tick(std::span<Setpoint<Real>> out);
  /// Each axis by itself: they are on no common path.
  void stop();
  void halt();
  [[nodiscard]] bool is_resting() const;
  [[nodiscard]] std::span<FreeAxis<Real>> axes() const { return axes_; }

 private:
  std::span<FreeAxis<Real>> axes_;
};

extern template class FreeAxis<double>;
extern template class FreeAxis<float>;
extern template class FreeMotion<double>;
extern template class FreeMotion<float>;

}  // namespace inbetween
