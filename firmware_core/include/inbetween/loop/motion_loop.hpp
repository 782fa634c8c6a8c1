#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "inbetween/base/result.hpp"
#include "inbetween/limits/limits.hpp"
#include "inbetween/limits/played_motion.hpp"
#include "inbetween/loop/ports.hpp"
#include "inbetween/loop/supervisor.hpp"
#include "inbetween/play/free_source.hpp"
#include "inbetween/play/playhead.hpp"

/// The loop that moves a rig, on hardware and in simulation: read, update, write, once a tick.

namespace inbetween {

/// The axes of a rig and the move that it is to make. Refers to the caller's memory.
struct LoopSpec {
  const PlayedMotion* move = nullptr;
  Playhead* playhead = nullptr;
  std::span<const std::size_t> drive_of;  ///< for every axis of the move
  std::span<const AxisLimits> limits;     ///< for every axis of the move
  double tick_seconds = 1.0 / 250;
  /// Some axes may rest while a frame is shot in motion: the focus, say, while the slide passes it. They have
  /// a playhead of their own, on the same move and stop bounds, which goes on from frame to frame between the
  /// exposures; `is_still` says which of all axes they are, and is empty without it. The loop plays and stops
  /// both playheads.
  Playhead* still = nullptr;
  std::span<const bool> is_still = {};
  /// The size of a count of the drive in axis units, for every axis of the move: two positions that are no
  /// further apart are one place. Empty: 0.
  std::span<const double> counts = {};
};

/// Axes that move without a move, to set the rig up. Refers to the caller's memory.
struct FreeSpec {
  FreeSource source;
  std::span<const std::size_t> drive_of;  ///< for every axis of the source
  std::span<const AxisLimits> limits;     ///< for every axis of the source
  double tick_seconds = 1.0 / 250;
};

/// Drives that can be told what the motor behind the calibration of an axis does (MotorPort::plan_motor).
template <class Drives>
concept PlansMotors = requires(Drives& drives, std::size_t drive, const Setpoint& setpoint) {
  drives.plan_motor(drive, setpoint, setpoint);
};

/// The memory of a motion loop, owned by the caller.
struct LoopMemory {
  std::span<DriveState> states;   ///< drives
  std::span<Setpoint> setpoints;  ///< drives
  std::span<Setpoint> next;       ///< axes of the move
  std::span<AxisMotion> motions;  ///< axes of the move
};

/// How far from where a move starts an axis may stand: what its acceleration covers in a tick. A drive rests
/// on whole counts, so that a count is never too far.
constexpr double start_tolerance(double max_acceleration, double tick_seconds, double count) {
  constexpr double rounding = 1e-6;
  return std::max(max_acceleration * tick_seconds * tick_seconds, count * (1 + rounding));
}

/// What a tick brought about.
struct LoopTick {
  SupervisorState state = SupervisorState::disarmed;
  PlayheadEvent event = PlayheadEvent::none;
  bool lost_time = false;  ///< it came too late to be made up for: the rig slows down
};

/// Axes in no move keep the setpoint that they had when the drives were switched on: their actual position.
///
/// Late ticks: the playhead goes on by as many ticks as have passed if that takes no axis further than
/// max_velocity allows within one tick. Otherwise the lost time stays lost and the rig slows down on the path
/// (never a burst; docs/faults.md 36). Where a late tick brings about something (the move ends, a shutter
/// opens) the rig is where that happened, and goes on from there.
template <DrivePort Drives, LinePort Lines>
class MotionLoop {
 public:
  /// `memory` has room for the drives and for the axes of every move that will be loaded.
  MotionLoop(Drives& drives, Lines& lines, const LoopMemory& memory)
      : drives_(&drives), lines_(&lines), memory_(memory) {}

  /// The move that `start` will begin. Errors: wrong_state (a move is running), out_of_range (it has motors
  /// behind a calibration, and the drives cannot play them), wrong_count (drive_of, limits or memory are not
  /// as many as the axes).
  Status load(const LoopSpec& spec) {
    const std::size_t axes = spec.move->axis_count();
    const std::size_t still = spec.still != nullptr ? axes : 0;
    if (const Status possible = can_load(spec.drive_of.size(), spec.limits.size(), axes); !possible) {
      return possible;
    }
    const bool counts = spec.counts.empty() || spec.counts.size() == axes;
    if (spec.is_still.size() != still || !counts || memory_.motions.size() < axes) {
      return too_few(axes);
    }
    if constexpr (!PlansMotors<Drives>) {
      if (!spec.move->motors().empty()) {
        return Error{.code = ErrorCode::out_of_range,
                     .what = "the drives cannot play the motors of the move",
                     .remedy = "give the loop drives with a MotorPort"};
      }
    }
    free_ = {};
    spec_ = spec;
    return Done{};
  }

  /// Axes that move without a move: after `begin` the loop asks their source for setpoints, once a tick
  /// however late it is, until `finish`. Errors: those for a move.
  Status load(const FreeSpec& spec) {
    if (const Status possible = can_load(spec.drive_of.size(), spec.limits.size(), spec.drive_of.size());
        !possible) {
      return possible;
    }
    spec_ = {};
    spec_.drive_of = spec.drive_of;
    spec_.limits = spec.limits;
    spec_.tick_seconds = spec.tick_seconds;
    free_ = spec.source;
    return Done{};
  }

  /// Takes a request of the operator, or an event outside the drives. False: refused in this state.
  bool post(SupervisorEvent event) {
    if (event == SupervisorEvent::start) return static_cast<bool>(start(Direction::forward));
    return apply(event);
  }

  /// Begins the move from the frame on which the playhead rests. Errors: those of `begin`; wrong_state
  /// (no move, or nothing more to play).
  Status start(Direction direction) {
    if (const Status possible = can_begin(); !possible) return possible;
    if (has_free()) {
      return Error{.code = ErrorCode::wrong_state, .what = "there is no move to start", .remedy = "load one"};
    }
    if (const Status can_play = spec_.playhead->play(direction); !can_play) return can_play;
    if (spec_.still != nullptr) {
      if (const Status can_play = spec_.still->play(direction); !can_play) return can_play;
    }
    lines_->begin();
    apply(SupervisorEvent::start);
    return Done{};
  }

  /// From now on the rig follows the playhead, which rests and is told by others what to do. Errors:
  /// wrong_state (nothing loaded, not ready), no_solution with axis (the axis is not where the playhead is:
  /// within what max_acceleration covers in a tick, or a count if that is more).
  Status begin() {
    if (const Status possible = can_begin(); !possible) return possible;
    lines_->begin();
    apply(SupervisorEvent::start);
    return Done{};
  }

  /// Ends what was begun, though the playhead is not at the end of the time line: ready again. Errors:
  /// wrong_state (it does not run, or moves).
  Status finish() {
    if (state_ != SupervisorState::running || !is_resting()) {
      return Error{.code = ErrorCode::wrong_state,
                   .what = "the rig does not rest on the path",
                   .remedy = "wait until it does"};
    }
    apply(SupervisorEvent::finished);
    return Done{};
  }

  /// `ticks` have passed since the last call, usually 1, and it is `now_ns` on a monotonic clock. O(axes), no
  /// allocation.
  LoopTick tick(std::int32_t ticks, std::int64_t now_ns) {
    LoopTick result;
    read(now_ns);
    if (is_moving()) has_free() ? advance_free(now_ns, result) : advance(ticks, result);
    drives_->write(
        sends_setpoints() ? std::span<const Setpoint>(memory_.setpoints) : std::span<const Setpoint>(),
        now_ns);
    result.state = state_;
    return result;
  }

  [[nodiscard]] SupervisorState state() const { return state_; }
  /// Whether drives are told setpoints: not before they are on, nor after power was lost.
  [[nodiscard]] bool sends_setpoints() const {
    return is_moving() || state_ == SupervisorState::ready || state_ == SupervisorState::latched;
  }
  /// The setpoints of the last tick, a drive each.
  [[nodiscard]] std::span<const Setpoint> setpoints() const { return memory_.setpoints; }
  [[nodiscard]] std::span<const DriveState> drive_states() const { return memory_.states; }

 private:
  [[nodiscard]] bool is_moving() const {
    return state_ == SupervisorState::running || state_ == SupervisorState::stopping;
  }
  [[nodiscard]] bool has_free() const { return free_.of != nullptr; }
  [[nodiscard]] bool is_resting() const {
    if (has_free()) return free_.is_resting(free_.of);
    return spec_.playhead->is_resting() && (spec_.still == nullptr || spec_.still->is_resting());
  }
  [[nodiscard]] Setpoint& setpoint(std::size_t axis) { return memory_.setpoints[spec_.drive_of[axis]]; }

  void read(std::int64_t now_ns) {
    drives_->read(memory_.states, now_ns);
    lines_->read(now_ns);
    const auto any = [&](DriveCondition condition) {
      return std::ranges::any_of(memory_.states,
                                 [&](const DriveState& drive) { return drive.condition == condition; });
    };
    if (lines_->emergency_stop() || any(DriveCondition::unreachable)) {
      apply(SupervisorEvent::power_lost);
    } else if (any(DriveCondition::cannot_follow)) {
      apply(SupervisorEvent::drive_fault);
    } else if (is_moving() && lines_->limit_hit()) {
      apply(SupervisorEvent::stop);
    } else if (state_ == SupervisorState::faulted) {
      apply(SupervisorEvent::cleared);
    } else if (state_ == SupervisorState::enabling &&
               std::ranges::all_of(memory_.states, &DriveState::is_on)) {
      apply(SupervisorEvent::enabled);
    }
  }

  static Error too_few(std::size_t axes) {
    return {.code = ErrorCode::wrong_count,
            .what = "the loop has not a drive, limits and memory for every axis of the move",
            .remedy = "give as many as the move has axes",
            .needed = static_cast<std::int64_t>(axes)};
  }
  [[nodiscard]] Status can_load(std::size_t drives, std::size_t limits, std::size_t axes) const {
    if (is_moving()) {
      return Error{.code = ErrorCode::wrong_state, .what = "a move is running", .remedy = "stop it first"};
    }
    if (drives != axes || limits != axes || memory_.next.size() < axes) return too_few(axes);
    return Done{};
  }

  [[nodiscard]] Status can_begin() {
    if ((spec_.move == nullptr && !has_free()) || state_ != SupervisorState::ready) {
      return Error{.code = ErrorCode::wrong_state,
                   .what = "the rig is not ready for a move",
                   .remedy = "load one, arm the rig and wait until its drives are on"};
    }
    // A source tells where it is when it is asked to go on: the first setpoint is held against the drives
    // then.
    if (has_free()) return Done{};
    look_ahead(*spec_.playhead, spec_.still);
    for (std::size_t d = 0; d < spec_.move->axis_count(); ++d) {
      const double off = std::fabs(memory_.next[d].position - setpoint(d).position);
      const double count = spec_.counts.empty() ? 0.0 : spec_.counts[d];
      if (off <= start_tolerance(spec_.limits[d].max_acceleration(), spec_.tick_seconds, count)) continue;
      return Error{.code = ErrorCode::no_solution,
                   .what = "the axis is not where the move starts",
                   .remedy = "go to the start slowly first",
                   .axis = static_cast<std::int32_t>(d)};
    }
    return Done{};
  }

  /// A source that begins elsewhere than the drives stand moves nothing.
  void advance_free(std::int64_t now_ns, LoopTick& result) {
    const std::size_t axes = spec_.drive_of.size();
    free_.tick(free_.of, now_ns, memory_.next);
    if (jumps(axes)) {
      result.lost_time = true;
      halt();
      apply(SupervisorEvent::drive_fault);
    } else {
      for (std::size_t d = 0; d < axes; ++d) setpoint(d) = memory_.next[d];
    }
    if (state_ == SupervisorState::stopping && is_resting()) apply(SupervisorEvent::rested);
  }

  void advance(std::int32_t ticks, LoopTick& result) {
    if (ticks == 1) {
      advance_by_one(result);
    } else if (!makes_up(ticks, result)) {
      result.lost_time = true;
      apply(SupervisorEvent::stop);
      advance_by_one(result);
    }
    for (std::size_t d = 0; d < spec_.move->axis_count(); ++d) setpoint(d) = memory_.next[d];
    plan_motors();
    if (result.event == PlayheadEvent::finished) apply(SupervisorEvent::finished);
    if (state_ == SupervisorState::stopping && is_resting()) apply(SupervisorEvent::rested);
  }
  void advance_by_one(LoopTick& result) {
    result.event = spec_.playhead->tick();
    if (spec_.still != nullptr) spec_.still->tick();
    look_ahead(*spec_.playhead, spec_.still);
  }
  /// Goes on by so many ticks. False, and nothing has changed, where an axis would jump.
  bool makes_up(std::int32_t ticks, LoopTick& result) {
    Playhead ahead = *spec_.playhead;
    std::optional<Playhead> still_ahead;
    if (spec_.still != nullptr) still_ahead = *spec_.still;
    PlayheadEvent event = PlayheadEvent::none;
    for (std::int32_t i = 0; i < ticks && event == PlayheadEvent::none; ++i) {
      event = ahead.tick();
      if (still_ahead) still_ahead->tick();
    }
    look_ahead(ahead, still_ahead ? &*still_ahead : nullptr);
    if (jumps(spec_.move->axis_count())) return false;
    result.event = event;
    *spec_.playhead = ahead;
    if (still_ahead) *spec_.still = *still_ahead;
    return true;
  }
  void plan_motors() {
    if constexpr (PlansMotors<Drives>) {
      for (const PlayedMotor& motor : spec_.move->motors()) {
        const bool is_still = spec_.still != nullptr && spec_.is_still[motor.axis];
        const Playhead& playhead = is_still ? *spec_.still : *spec_.playhead;
        drives_->plan_motor(spec_.drive_of[motor.axis], setpoint(motor.axis),
                            played_by(playhead, spec_.move->motion_of(motor, playhead.time())));
      }
    }
  }
  /// The rate at which the playhead plays may change (chain rule).
  static Setpoint played_by(const Playhead& playhead, const AxisMotion& motion) {
    const double rate = playhead.rate();
    return {.position = motion.position,
            .velocity = motion.velocity * rate,
            .acceleration = motion.acceleration * rate * rate + motion.velocity * playhead.rate_change()};
  }
  /// The setpoints where the playheads are: the axes that stand still are where they have a time of their
  /// own.
  void look_ahead(const Playhead& playhead, const Playhead* still) {
    look_at(playhead, still == nullptr ? std::span<const bool>() : spec_.is_still, false);
    if (still != nullptr) look_at(*still, spec_.is_still, true);
  }
  /// For all axes, or for those that are still or are not.
  void look_at(const Playhead& playhead, std::span<const bool> is_still, bool wanted) {
    spec_.move->motion(playhead.time(), memory_.motions);
    for (std::size_t d = 0; d < spec_.move->axis_count(); ++d) {
      if (!is_still.empty() && is_still[d] != wanted) continue;
      memory_.next[d] = played_by(playhead, memory_.motions[d]);
    }
  }
  /// Whether an axis would go further in this tick than its max_velocity allows. One that goes exactly as
  /// fast as that does not: its positions are rounded, near 0 as coarsely as where it came from. What comes
  /// too late goes twice as far.
  [[nodiscard]] bool jumps(std::size_t axes) {
    constexpr double rounding = 4 * std::numeric_limits<double>::epsilon();
    constexpr double rounding_of_motion = 1e-3;
    for (std::size_t d = 0; d < axes; ++d) {
      const double from = setpoint(d).position;
      const double to = memory_.next[d].position;
      const double distance = spec_.limits[d].max_velocity() * spec_.tick_seconds;
      const double rounded = rounding * (std::fabs(from) + std::fabs(to)) + rounding_of_motion * distance;
      if (std::fabs(to - from) > distance + rounded) return true;
    }
    return false;
  }

  void halt() {
    if (has_free()) free_.halt(free_.of);
    if (spec_.playhead != nullptr) spec_.playhead->halt();
    if (spec_.still != nullptr) spec_.still->halt();
  }

  bool apply(SupervisorEvent event) {
    const SupervisorStep step = supervise(state_, event);
    state_ = step.state;
    switch (step.action) {
      case SupervisorAction::refuse:
        return false;
      case SupervisorAction::enable:
        drives_->enable();
        break;
      case SupervisorAction::disable:
        halt();
        drives_->disable();
        break;
      case SupervisorAction::hold_actual:
        for (std::size_t i = 0; i < memory_.states.size(); ++i) {
          memory_.setpoints[i] = {.position = memory_.states[i].actual};
        }
        break;
      case SupervisorAction::slow_down:
        if (has_free()) free_.stop(free_.of);
        if (spec_.playhead != nullptr) spec_.playhead->stop();
        if (spec_.still != nullptr) spec_.still->stop();
        break;
      case SupervisorAction::quick_stop:
        halt();
        drives_->quick_stop();
        break;
      case SupervisorAction::cease_setpoints:
        halt();
        break;
      case SupervisorAction::play:
      case SupervisorAction::none:
        break;
    }
    return true;
  }

  Drives* drives_;
  Lines* lines_;
  LoopMemory memory_;
  LoopSpec spec_;
  FreeSource free_;
  SupervisorState state_ = SupervisorState::disarmed;
};

}  // namespace inbetween
