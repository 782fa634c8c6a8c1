#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/result.hpp"
#include "inbetween/base/setpoint.hpp"
#include "inbetween/loop/ports.hpp"
#include "inbetween/loop/tick_chain.hpp"
#include "inbetween/steps/edge_instant.hpp"
#include "inbetween/steps/step_generator.hpp"
#include "inbetween/steps/step_merge.hpp"

/// Stepper drives behind STEP, DIR and ENABLE lines as the motion loop sees them.

namespace inbetween {

/// Plays the instants of one chip at their times, on hardware or in simulation. Nothing waits.
template <class Sink>
concept StepSink = requires(Sink& sink, const Sink& seen, const EdgeInstant& instant) {
  /// False: the sink will not play the instant.
  { sink.push(instant) } -> std::convertible_to<bool>;
  /// Drops every instant that has not been played.
  sink.discard();
  { seen.waiting() } -> std::convertible_to<std::uint64_t>;
  /// An instant was later than the rig allows.
  { seen.is_too_late() } -> std::convertible_to<bool>;
  /// The chip has gone.
  { seen.has_ended() } -> std::convertible_to<bool>;
};

/// One axis on a chip. Owned by the caller, as the room for its edges is: StepGenerator::max_edges().
struct StepLane {
  StepGenerator generator;
  std::span<StepEdge> edges;
  double told = 0;  ///< its last setpoint, kept by the port
};

/// The axes of one chip: lanes first_lane .. first_lane + lanes of the port, in the order of `merge`.
template <StepSink Sink>
struct StepChip {
  Sink* sink = nullptr;
  StepMerge merge;
  std::span<const StepLines> wires;  ///< one for each of its lanes, as `merge` was made of
  std::size_t first_lane = 0;
  std::size_t lanes = 0;
  std::uint64_t enable_mask = 0;    ///< the ENABLE lines
  std::uint64_t enable_levels = 0;  ///< of those lines, while the drives are on
  std::span<EdgeInstant> instants;  ///< room for as many as the lanes have edges
};

struct StepPortTiming {
  std::int32_t rate_hz = 0;  ///< of the loop
  /// The time from a tick of the loop to the first moment of the motion that it has written. A lead of one
  /// tick keeps the axes in step with CAN drives that interpolate over a tick (CiA 402, cyclic synchronous
  /// position).
  std::int64_t lead_ns = 0;
  /// A tick of the loop that is later than this leaves a gap in the steps that no motor follows.
  std::int64_t max_late_ns = 0;
};

/// The lasting faults of a lane's steps. They end when the lane is placed anew.
struct StepLaneState {
  bool has_failed = false;      ///< more steps than the rate permits: the lane gets no more steps
  bool has_lost_steps = false;  ///< the motor did not get steps that were counted: it stands elsewhere
};

/// A DrivePort: axis i is lane i. It counts open loop: the position of a drive is that of the steps put out.
///
/// The motion from a setpoint to the next begins `lead_ns` after the tick in which it is written, tick after
/// tick without a gap. Without setpoints all waiting edges are dropped at once, even within a pulse; if any
/// waited, the position is lost too. Such a drive has no ramp: quick_stop() does the same.
template <StepSink Sink>
class StepPort {
 public:
  /// Refers to the caller's memory. Errors: wrong_count (the chips do not have all lanes, each once and in
  /// order; `states` or `lists` has not one for each), out_of_range (a time that is not above 0),
  /// capacity with axis (room for edges or instants).
  static Result<StepPort> make(std::span<StepLane> lanes, std::span<StepChip<Sink>> chips,
                               std::span<StepLaneState> states, std::span<std::span<const StepEdge>> lists,
                               const StepPortTiming& timing) {
    std::size_t next = 0;
    for (const StepChip<Sink>& chip : chips) {
      if (chip.first_lane != next || chip.sink == nullptr || chip.wires.size() != chip.lanes) {
        return wrong_lanes();
      }
      std::size_t edges = 0;
      for (; next < std::min(chip.first_lane + chip.lanes, lanes.size()); ++next) {
        edges += lanes[next].edges.size();
        if (lanes[next].edges.size() >= lanes[next].generator.max_edges()) continue;
        return Error{.code = ErrorCode::capacity,
                     .what = "too little room for the edges of a tick",
                     .remedy = "give as much as StepGenerator::max_edges says",
                     .axis = static_cast<std::int32_t>(next)};
      }
      if (chip.instants.size() < edges) {
        return Error{.code = ErrorCode::capacity,
                     .what = "too little room for the instants of a chip",
                     .remedy = "give one for each edge of its axes",
                     .needed = static_cast<std::int64_t>(edges)};
      }
    }
    if (next != lanes.size() || states.size() != lanes.size() || lists.size() != lanes.size()) {
      return wrong_lanes();
    }
    if (timing.rate_hz <= 0 || timing.lead_ns <= 0 || timing.max_late_ns <= 0) {
      return Error{.code = ErrorCode::out_of_range,
                   .what = "a time of the step port is not above 0",
                   .remedy = "give the rate of the loop, a lead and the latest edge"};
    }
    return StepPort(lanes, chips, states, lists, timing);
  }

  void read(std::span<DriveState> states, std::int64_t now_ns) {
    now_ns_ = now_ns;
    has_time_ = true;
    if (is_to_switch_on_) switch_on();
    bool is_there = true;
    bool is_in_time = !is_late_;
    for (const StepChip<Sink>& chip : chips_) {
      is_there = is_there && !chip.sink->has_ended() && !has_refused_;
      is_in_time = is_in_time && !chip.sink->is_too_late();
    }
    for (std::size_t i = 0; i < lanes_.size(); ++i) {
      states[i].actual = position(i);
      states[i].is_on = is_enabled_ && now_ns >= enabled_at_ns_;
      states[i].condition = DriveCondition::fine;
      if (!is_in_time || states_[i].has_failed) states[i].condition = DriveCondition::cannot_follow;
      if (!is_there) states[i].condition = DriveCondition::unreachable;
    }
  }

  void write(std::span<const Setpoint> setpoints, std::int64_t now_ns) {
    if (setpoints.empty() || !is_enabled_) {
      cease();
      return;
    }
    advance(now_ns);
    for (std::size_t i = 0; i < lanes_.size(); ++i) lists_[i] = edges_to(i, setpoints[i]);
    for (const StepChip<Sink>& chip : chips_) {
      const Result<std::size_t> count =
          chip.merge.merge(chain_.start_ns(), lists_.subspan(chip.first_lane, chip.lanes), chip.instants);
      // The generators keep the order and the times that the merge asks for, and the room is enough: it does
      // not refuse.
      if (!count) has_refused_ = true;
      for (std::size_t i = 0; count && i < *count; ++i) push(chip, chip.instants[i]);
    }
  }

  void enable() {
    for (std::size_t i = 0; i < lanes_.size(); ++i) {
      // The present place of a lane is a valid setpoint for it, to the step.
      static_cast<void>(lanes_[i].generator.place(position(i)));
      states_[i].has_failed = false;
    }
    is_late_ = false;
    is_enabled_ = true;
    chain_.end();
    is_to_switch_on_ = true;
    // Before the first read nobody knows what time it is.
    if (has_time_) switch_on();
  }
  void disable() {
    cease();
    is_enabled_ = false;
    is_to_switch_on_ = false;
    if (has_time_) set_lines(false);
  }
  void quick_stop() { cease(); }

  /// The position in axis units by the steps that were put out. If they are at the last setpoint, within half
  /// a step, it is that setpoint.
  [[nodiscard]] double position(std::size_t lane) const {
    const StepGenerator& generator = lanes_[lane].generator;
    const double told = lanes_[lane].told;
    const double told_steps = std::floor(told * generator.spec().steps_per_unit + 0.5);
    if (told_steps == static_cast<double>(generator.count())) return told;
    return static_cast<double>(generator.count()) / generator.spec().steps_per_unit;
  }
  /// Tells that the axis is at `position`, whatever was counted, because it was homed or somebody said so.
  /// Call it only while the axis rests. Errors: those of StepGenerator::place.
  Status place(std::size_t lane, double position) {
    if (const Status placed = lanes_[lane].generator.place(position); !placed) return placed;
    lanes_[lane].told = position;
    states_[lane] = {};
    return Done{};
  }
  [[nodiscard]] std::span<const StepLaneState> lane_states() const { return states_; }
  /// The times at which the motion of the last setpoints is played. It does not run without setpoints.
  [[nodiscard]] const TickChain& chain() const { return chain_; }
  /// The number of ticks of the loop that came too late for the steps at their start.
  [[nodiscard]] std::uint64_t gaps() const { return gaps_; }

 private:
  StepPort(std::span<StepLane> lanes, std::span<StepChip<Sink>> chips, std::span<StepLaneState> states,
           std::span<std::span<const StepEdge>> lists, const StepPortTiming& timing)
      : lanes_(lanes),
        chips_(chips),
        states_(states),
        lists_(lists),
        chain_(timing.rate_hz, timing.lead_ns),
        max_late_ns_(timing.max_late_ns) {}

  static Error wrong_lanes() {
    return {.code = ErrorCode::wrong_count,
            .what = "the chips do not have every axis once, in order",
            .remedy = "list the axes chip by chip, with a state and a list of edges for each"};
  }

  void advance(std::int64_t now_ns) {
    if (!chain_.is_running()) {
      chain_.begin(std::max(now_ns + chain_.lead_ns(), enabled_at_ns_));
      return;
    }
    const std::int64_t late_ns = chain_.next(now_ns);
    if (late_ns > 0) ++gaps_;
    if (late_ns > max_late_ns_) is_late_ = true;
  }

  std::span<const StepEdge> edges_to(std::size_t i, const Setpoint& setpoint) {
    if (states_[i].has_failed) return {};
    const Result<std::size_t> count = lanes_[i].generator.advance(setpoint, lanes_[i].edges);
    if (!count) {
      states_[i] = {.has_failed = true, .has_lost_steps = true};
      return {};
    }
    lanes_[i].told = setpoint.position;
    return lanes_[i].edges.first(*count);
  }

  void push(const StepChip<Sink>& chip, const EdgeInstant& instant) {
    if (!chip.sink->push(instant)) has_refused_ = true;
  }

  /// Puts out no more steps; those that waited were counted.
  void cease() {
    if (!chain_.is_running()) return;
    for (const StepChip<Sink>& chip : chips_) {
      const bool loses = chip.sink->waiting() > 0;
      chip.sink->discard();
      for (std::size_t i = 0; loses && i < chip.lanes; ++i)
        states_[chip.first_lane + i].has_lost_steps = true;
    }
    chain_.end();
  }

  void switch_on() {
    is_to_switch_on_ = false;
    enabled_at_ns_ = now_ns_ + chain_.lead_ns();
    set_lines(true);
  }

  /// Sets ENABLE, and the other lines as their generators have them: a dropped edge may have left a pulse on.
  void set_lines(bool on) {
    for (const StepChip<Sink>& chip : chips_) {
      EdgeInstant instant{.at_ns = now_ns_ + chain_.lead_ns(),
                          .levels = on ? chip.enable_levels : ~chip.enable_levels & chip.enable_mask,
                          .mask = chip.enable_mask};
      for (std::size_t i = 0; i < chip.lanes; ++i) {
        const std::uint64_t dir = std::uint64_t{1} << static_cast<unsigned>(chip.wires[i].dir);
        instant.mask |= dir | std::uint64_t{1} << static_cast<unsigned>(chip.wires[i].step);
        if (lanes_[chip.first_lane + i].generator.direction()) instant.levels |= dir;
      }
      push(chip, instant);
    }
  }

  std::span<StepLane> lanes_;
  std::span<StepChip<Sink>> chips_;
  std::span<StepLaneState> states_;
  std::span<std::span<const StepEdge>> lists_;
  TickChain chain_;
  std::int64_t max_late_ns_;
  std::int64_t now_ns_ = 0;
  std::int64_t enabled_at_ns_ = 0;
  std::uint64_t gaps_ = 0;
  bool has_time_ = false;         ///< now_ns_ is one
  bool is_to_switch_on_ = false;  ///< enabled before that
  bool is_enabled_ = false;
  bool is_late_ = false;      ///< a gap was longer than allowed
  bool has_refused_ = false;  ///< an instant found no room or no chip
};

}  // namespace inbetween
