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

/// Finding out where the axes are, by a switch each.

namespace inbetween {

/// How an axis finds its switch. Ways and speeds are magnitudes in axis units and unit/s.
template <Precise Real>
struct HomingSpec {
  bool towards_max = false;  ///< the switch is in the direction of rising positions
  Real at = 0;               ///< the position where it closes, approached from the other side
  Real fast = 0;             ///< to find it; the axis overruns the switch by the way of a stop from this
  Real slow = 0;             ///< to measure it: this and nothing else decides how well it is repeated
  Real search = 0;           ///< look for it no further than this
  Real leave = 0;            ///< an axis that starts on it moves off no further than this
  Real back_off = 0;         ///< so far before its edge it has opened: more than its hysteresis
  SwitchSettings home = {};
};

/// What an axis and its lines tell on a tick.
struct HomingInput {
  bool level = false;      ///< of the line of the home switch, read after the events
  bool limit_hit = false;  ///< a limit switch that is not the home switch
  bool drive_fault = false;
};

/// One axis on the way to its switch: fast towards it, a stop behind it, back, slowly towards it again. It is
/// referenced by where it was commanded to be at the time of the first edge of the slow approach: what it
/// lags behind is the same each time. An axis that starts on its switch leaves it first. Refers to the axis.
///
/// Every motion is one of FreeAxis with its limits and at no more than `fast`; how far it goes is bounded, so
/// that the homing ends whatever the switch does.
template <Precise Real>
class AxisHoming {
 public:
  /// Errors: not_finite; out_of_range (a way or speed that is not above 0, fast above the velocity of the
  /// axis, slow above fast; the switch settings).
  static Result<AxisHoming> make(const HomingSpec<Real>& spec, FreeAxis<Real>& axis);

  [[nodiscard]] HomingPhase phase() const { return phase_; }
  /// Why it failed; none otherwise.
  [[nodiscard]] HomingFailure failure() const { return failure_; }
  /// To add to the positions that it has now, once it is referenced.
  [[nodiscard]] Real shift() const { return shift_; }
  [[nodiscard]] const SwitchInput& home_switch() const { return switch_; }
  [[nodiscard]] const FreeAxis<Real>& axis() const { return *axis_; }

 private:
  template <Precise>
  friend class Homing;

  AxisHoming(const HomingSpec<Real>& spec, const SwitchInput& input, FreeAxis<Real>& axis)
      : spec_(spec), switch_(input), axis_(&axis) {}

  [[nodiscard]] Status can_begin(const HomingInput& input) const;
  [[nodiscard]] Real reach() const;
  [[nodiscard]] Real spike_way() const;
  void begin(std::int64_t now_ns, const HomingInput& input);
  void observe(std::int64_t now_ns, const HomingInput& input, std::span<const LineEvent> events);
  [[nodiscard]] HomingFailure fault(const HomingInput& input) const;
  void locate_edge();
  void apply(HomingSignal signal);
  void act(HomingAction action);
  void mark();
  void fail(HomingFailure failure);
  void go_to(Real position, Real speed);
  void halt();
  [[nodiscard]] bool is_moving() const;
  /// `way` towards the switch.
  [[nodiscard]] Real towards(Real way) const { return spec_.towards_max ? way : -way; }

  HomingSpec<Real> spec_;
  SwitchInput switch_;
  FreeAxis<Real>* axis_;
  SetpointTrail<Real> trail_;
  HomingPhase phase_ = HomingPhase::waiting;
  HomingFailure failure_ = HomingFailure::none;
  Real start_ = 0;
  Real edge_ = 0;  ///< where the last first edge was ...
  std::int64_t located_ns_ = 0;
  bool is_located_ = false;  ///< ... if that is known
  Real mark_ = 0;            ///< where the last edge was that turned out to be one
  Real shift_ = 0;
};

enum class HomingState : std::uint8_t {
  waiting,  ///< not begun
  moving,   ///< some axis is on its way
  done,     ///< every axis is referenced
  failed,   ///< every axis rests, and one or more are not referenced
};

/// Several axes at once. If one fails all of them stop: what has not been referenced by then is not. Refers
/// to the caller's axes.
///
/// The caller keeps unreferenced axes out of everything else, sends the setpoints, and when an axis is
/// referenced adds AxisHoming::shift() to its coordinates: FreeAxis::place and FreeAxis::set_range, because
/// the range of an axis is made as wide as its homing here and stays so.
template <Precise Real>
class Homing {
 public:
  /// The setpoints of a tick are reached `delay_ns` after it, which is at least a tick.
  Homing(std::span<AxisHoming<Real>> axes, std::int64_t delay_ns) : axes_(axes), delay_ns_(delay_ns) {}

  /// Begins with all axes, from where they rest. Errors, all with axis and nothing begun: out_of_range (it is
  /// under way already; the axis moves, is on a limit switch, or its drive has a fault; the positions on the
  /// way cannot be computed), wrong_count (not an input for every axis; without axis).
  Status start(std::int64_t now_ns, std::span<const HomingInput> inputs);
  /// Once a tick, at `now_ns`: an input for every axis, the events of all lines since the last tick in the
  /// order of their times, and room for a setpoint of every axis; otherwise the program ends. O(axes x
  /// events), no allocation.
  HomingState tick(std::int64_t now_ns, std::span<const HomingInput> inputs,
                   std::span<const LineEvent> events, std::span<Setpoint<Real>> out);
  /// The operator's wish: all axes slow down. Afterwards `failed`, unless all are referenced.
  void stop();
  /// For axes that are not sent their setpoints any more: at rest at once, and not referenced.
  void halt();

  [[nodiscard]] HomingState state() const;
  [[nodiscard]] std::span<const AxisHoming<Real>> axes() const { return axes_; }
  /// The axis whose failure has stopped the others. -1: none; the operator has no axis.
  [[nodiscard]] std::int32_t failed_axis() const { return failed_axis_; }

 private:
  void stop_all_for(HomingFailure failure);

  std::span<AxisHoming<Real>> axes_;
  std::int64_t delay_ns_;
  std::int32_t failed_axis_ = -1;
};

extern template class AxisHoming<double>;
extern template class AxisHoming<float>;
extern template class Homing<double>;
extern template class Homing<float>;

}  // namespace inbetween
