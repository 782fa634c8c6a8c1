#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/result.hpp"
#include "inbetween/base/setpoint.hpp"
#include "inbetween/homing/homing_table.hpp"
#include "inbetween/homing/line_event.hpp"
#include "inbetween/homing/setpoint_trail.hpp"
#include "inbetween/homing/switch_input.hpp"
#include "inbetween/play/free_axis.hpp"

/// Finds out where the axes are. Each axis has a home switch.

namespace inbetween {

/// The parameters of the search for a switch. Distances and speeds are magnitudes in axis units and unit/s.
struct HomingSpec {
  bool towards_max = false;  ///< the switch is in the direction of rising positions
  double at = 0;             ///< the position where it closes, approached from the other side
  double fast =
      0;  ///< speed of the search; the axis overruns the switch by the distance of a stop from this speed
  double slow = 0;      ///< speed of the measurement: it alone decides how exactly the place is repeated
  double search = 0;    ///< the longest distance of the search
  double leave = 0;     ///< the longest distance off the switch, for an axis that starts on it
  double back_off = 0;  ///< the switch is open this far before its edge: more than its hysteresis
  SwitchSettings home = {};
};

/// The inputs of an axis on a tick.
struct HomingInput {
  bool level = false;      ///< of the line of the home switch, read after the events
  bool limit_hit = false;  ///< a limit switch that is not the home switch
  bool drive_fault = false;
};

/// Moves one axis to its switch: fast towards it, a stop behind it, back, slowly towards it again. The
/// reference is the commanded position at the time of the first edge of the slow approach, because the lag of
/// the axis is the same each time. An axis that starts on its switch leaves it first. Refers to the axis.
///
/// Every motion is one of FreeAxis, within its limits and at most at `fast`. Every distance is bounded, so
/// that the homing ends whatever the switch does.
class AxisHoming {
 public:
  /// Errors: not_finite; out_of_range (a distance or speed that is not above 0, fast above the velocity of
  /// the axis, slow above fast; the switch settings).
  static Result<AxisHoming> make(const HomingSpec& spec, FreeAxis& axis);

  [[nodiscard]] HomingPhase phase() const { return phase_; }
  /// The reason of a failure; none otherwise.
  [[nodiscard]] HomingFailure failure() const { return failure_; }
  /// The amount to add to the positions that the axis has now, once it is referenced.
  [[nodiscard]] double shift() const { return shift_; }
  [[nodiscard]] const SwitchInput& home_switch() const { return switch_; }
  [[nodiscard]] const FreeAxis& axis() const { return *axis_; }

 private:
  friend class Homing;

  AxisHoming(const HomingSpec& spec, const SwitchInput& input, FreeAxis& axis)
      : spec_(spec), switch_(input), axis_(&axis) {}

  [[nodiscard]] Status can_begin(const HomingInput& input) const;
  [[nodiscard]] double reach() const;
  [[nodiscard]] double spike_distance() const;
  void begin(std::int64_t now_ns, const HomingInput& input);
  void observe(std::int64_t now_ns, const HomingInput& input, std::span<const LineEvent> events);
  [[nodiscard]] HomingFailure fault(const HomingInput& input) const;
  void locate_edge();
  void apply(HomingSignal signal);
  void act(HomingAction action);
  void mark();
  void fail(HomingFailure failure);
  void go_to(double position, double speed);
  void halt();
  [[nodiscard]] bool is_moving() const;
  /// `distance` towards the switch.
  [[nodiscard]] double towards(double distance) const { return spec_.towards_max ? distance : -distance; }

  HomingSpec spec_;
  SwitchInput switch_;
  FreeAxis* axis_;
  SetpointTrail trail_;
  HomingPhase phase_ = HomingPhase::waiting;
  HomingFailure failure_ = HomingFailure::none;
  double start_ = 0;
  double edge_ = 0;  ///< position of the latest first edge ...
  std::int64_t located_ns_ = 0;
  bool is_located_ = false;  ///< ... if that is known
  double mark_ = 0;          ///< position of the latest edge that was no noise
  double shift_ = 0;
};

enum class HomingState : std::uint8_t {
  waiting,  ///< not begun
  moving,   ///< some axis is on its way
  done,     ///< every axis is referenced
  failed,   ///< every axis rests, and one or more are not referenced
};

/// Homes several axes at once. If one fails, all of them stop, and an axis that is not referenced by then
/// stays unreferenced. Refers to the caller's axes.
///
/// The caller sends the setpoints and uses unreferenced axes for nothing else. When an axis is referenced,
/// the caller adds AxisHoming::shift() to its coordinates with FreeAxis::place and FreeAxis::set_range:
/// homing makes the range of an axis as wide as its distances, and leaves it so.
class Homing {
 public:
  /// The axes reach the setpoints of a tick `delay_ns` after it; that is at least a tick.
  Homing(std::span<AxisHoming> axes, std::int64_t delay_ns) : axes_(axes), delay_ns_(delay_ns) {}

  /// Begins with all axes, from where they rest. Errors, all with axis; then nothing has begun: wrong_state
  /// (it is under way already; the axis moves, is on a limit switch, or its drive has a fault), out_of_range
  /// (the positions on the way cannot be computed), wrong_count (not an input for every axis; without axis).
  Status start(std::int64_t now_ns, std::span<const HomingInput> inputs);
  /// The caller calls this once a tick, at `now_ns`, with an input for every axis, the events of all lines
  /// since the last tick in the order of their times, and room for a setpoint of every axis; otherwise the
  /// program ends. O(axes x events), no allocation.
  HomingState tick(std::int64_t now_ns, std::span<const HomingInput> inputs,
                   std::span<const LineEvent> events, std::span<Setpoint> out);
  /// Stops all axes because the operator wants it. The state is then `failed`, unless all axes are
  /// referenced.
  void stop();
  /// Puts all axes at rest at once, not referenced, because their setpoints are no longer sent.
  void halt();

  [[nodiscard]] HomingState state() const;
  [[nodiscard]] std::span<const AxisHoming> axes() const { return axes_; }
  /// The axis whose failure has stopped the others. -1: none; a stop by the operator has no axis.
  [[nodiscard]] std::int32_t failed_axis() const { return failed_axis_; }

 private:
  void stop_all_for(HomingFailure failure);

  std::span<AxisHoming> axes_;
  std::int64_t delay_ns_;
  std::int32_t failed_axis_ = -1;
};

}  // namespace inbetween
