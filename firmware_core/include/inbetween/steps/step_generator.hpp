#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>

#include "inbetween/base/fixed_vector.hpp"
#include "inbetween/base/precision.hpp"
#include "inbetween/base/result.hpp"
#include "inbetween/base/setpoint.hpp"

/// The edges on the STEP and DIR lines of one axis, from the exact motion between two ticks.

namespace inbetween {

/// The minimum times of a stepper driver's input, from its data sheet, each from 1 ns to 1 s. Both times of
/// DIR are kept on the far side of the pulse, so that they hold whichever edge of STEP the driver acts on.
struct StepTiming {
  std::int64_t pulse_ns = 0;      ///< STEP high at least so long
  std::int64_t pause_ns = 0;      ///< STEP low at least so long
  std::int64_t dir_setup_ns = 0;  ///< from a change of DIR to STEP rising, and to the next change of DIR
  std::int64_t dir_hold_ns = 0;   ///< from STEP falling to a change of DIR

  friend bool operator==(const StepTiming&, const StepTiming&) = default;
};

/// The shortest time from one rising edge of STEP to the next.
constexpr std::int64_t min_period_ns(const StepTiming& timing) {
  return timing.pulse_ns + timing.pause_ns;
}

/// A position in steps is position * steps_per_unit.
struct StepSpec {
  double steps_per_unit = 0;  ///< negative where DIR high moves towards smaller positions; not 0
  StepTiming timing;
  double max_step_rate = 0;  ///< steps/s, above 0
  std::int64_t tick_ns = 0;  ///< 1 us to 1 s
};

/// Positions reach this many steps from 0. A double resolves 1/64 of a step there: beyond, the steps of a
/// slow motion would come in bunches and its direction would flutter.
inline constexpr double max_step_position = 140737488355328.0;

/// Checks that the timing permits the step rate, and that the step rate permits a velocity (unit/s). Planning
/// calls it. In the error `needed` is the other number of the comparison, in whole steps/s: the highest rate
/// that the timing permits, rounded down, or the rate that max_velocity needs, rounded up. Errors:
/// not_finite, out_of_range.
Status check_step_rate(const StepSpec& spec, double max_velocity);

enum class StepLine : std::uint8_t { step, dir };

/// One line of one axis changes. DIR high: the count grows.
struct StepEdge {
  std::int64_t at_ns = 0;  ///< from the start of the tick; 0 <= at_ns < tick_ns
  StepLine line{};
  bool level = false;  ///< after it

  friend bool operator==(const StepEdge&, const StepEdge&) = default;
};

/// The delays that the minimum times have caused so far.
struct StepDelays {
  std::int64_t late_steps = 0;       ///< steps that came later than their crossing
  std::int64_t longest_ns = 0;       ///< the longest delay of them
  std::int64_t cancelled_pairs = 0;  ///< steps that waited until the motion came back, and their returns

  friend bool operator==(const StepDelays&, const StepDelays&) = default;
};

/// Follows the motion of one axis and counts its steps.
///
/// Between two ticks the axis moves on the quintic that joins their setpoints. Its count is floor(x + 1/2),
/// where x is the position in steps: the count becomes k + 1 when x reaches k + 1/2, and k again when x falls
/// below it. Every such crossing, also on both sides of a turning point, is a step at its time, rounded to a
/// nanosecond. (A mere touch of k + 1/2 at a turning point may be two steps or none.)
///
/// The count at a tick is that of its setpoint, from the exact product of position and steps_per_unit, and
/// the steps between two ticks add up to it. So no error ever accumulates: after any run, count() + waiting()
/// is the rounded position of the last setpoint.
///
/// The minimum times are always kept. A step that comes too early is delayed until they are met, if need be
/// beyond the end of the tick; it then waits for the next call. A step that still waits when the motion
/// crosses back is cancelled together with its return. DIR changes as soon as the next step is known to need
/// it: after the hold of the last step, in the tick of that next step or of the turn before it. So a step
/// behind a turn is late only if it follows the last step, or the start of its tick, more closely than the
/// timing permits.
///
/// Accuracy of a crossing: rounding of the position, over the speed there. With positions below 2^31
/// steps that is 1 us at 0.25 steps/s. StepGeneratorProperties hold it.
///
/// No allocation, no clock. Cost of a tick: O(1 + steps), a few dozen multiplications a step; in a tick with
/// a turning point as much as for ten steps more.
class StepGenerator {
 public:
  /// The number of steps that may wait at once. More wait only if the motion turns faster than the timing of
  /// DIR permits.
  static constexpr std::size_t max_waiting = 32;

  /// Makes a generator at rest at position 0, with both lines low. Errors: not_finite; out_of_range (a figure
  /// of the spec outside its domain, a max_step_rate that check_step_rate refuses, or above 2^20 steps a
  /// tick).
  static Result<StepGenerator> make(const StepSpec& spec);

  /// Tells that the axis rests at `position`, in units: the count becomes that of the position without a
  /// step. Waiting steps are dropped; the lines stay as they are, and the minimum times run on. Call it only
  /// while the axis stands still. Errors: not_finite, out_of_range (beyond max_step_position).
  Status place(double position);

  /// The largest number of edges in a tick: `out` of advance() has that size or more.
  [[nodiscard]] std::size_t max_edges() const;

  /// Advances by one tick, to `end`: writes the edges of the tick in the order of time and returns their
  /// number. Errors: not_finite; out_of_range (a position beyond max_step_position, or more steps than
  /// max_step_rate permits in a tick: `needed` is how many); capacity (`out`, or more steps wait than
  /// max_waiting). Then nothing has changed and `out` means nothing: count() is still where the motor stands.
  /// Planning prevents this (check_step_rate), so it is a fault. The caller makes a controlled stop of the
  /// rig; this axis gets no more steps, and since it may have been fast, it is unreferenced until it is
  /// homed.
  Result<std::size_t> advance(const Setpoint& end, std::span<StepEdge> out);

  /// The steps put out so far, with sign: rising edges of STEP, those of the last call included.
  [[nodiscard]] std::int64_t count() const { return state_.count; }
  /// The steps that the motion has made and STEP has not, with sign.
  [[nodiscard]] std::int64_t waiting() const {
    const auto steps = static_cast<std::int64_t>(state_.waiting_since_ns.size());
    return state_.waiting_up ? steps : -steps;
  }
  [[nodiscard]] const StepDelays& delays() const { return state_.delays; }
  /// The level of DIR at the end of the last tick.
  [[nodiscard]] bool direction() const { return state_.direction; }
  [[nodiscard]] const StepSpec& spec() const { return spec_; }

 private:
  StepGenerator(const StepSpec& spec, std::int32_t max_steps) : spec_(spec), max_steps_(max_steps) {}

  /// Times are from the start of the tick.
  struct State {
    Setpoint at;
    std::int64_t count = 0;
    StepDelays delays;
    std::int64_t may_rise_ns = 0;  ///< no rising edge of STEP before
    std::int64_t may_turn_ns = 0;  ///< no change of DIR before
    std::int64_t falls_at_ns = 0;  ///< if STEP is high
    bool is_high = false;
    bool direction = false;
    bool waiting_up = false;
    /// The times of the crossings, oldest first, all in one direction.
    FixedVector<std::int64_t, max_waiting> waiting_since_ns;
  };
  class Writer;

  StepSpec spec_;
  std::int32_t max_steps_;  ///< the steps that max_step_rate permits in a tick
  State state_;
};

}  // namespace inbetween
