#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/result.hpp"
#include "inbetween/can/cia402_bus.hpp"
#include "inbetween/can/cia402_drive.hpp"
#include "inbetween/can/drive_finding.hpp"
#include "inbetween/can/frame.hpp"
#include "inbetween/loop/ports.hpp"

/// CiA 402 drives on any number of buses as the drives of a rig (DrivePort).

namespace inbetween::can {

/// A bus interface. Nothing waits.
template <class Link>
concept FrameLink = requires(Link& link, std::span<Frame> in, std::span<const Frame> out,
                             std::int64_t now_ns) {
  /// false: bus off, link down, gone. Until it is opened again, even where the bus comes back.
  { link.is_up() } -> std::convertible_to<bool>;
  /// Takes the frames that have arrived, at most in.size(), and says how many.
  { link.receive(in, now_ns) } -> std::convertible_to<std::size_t>;
  /// How many were taken, from the first on. The others are lost: nothing is ever sent later.
  { link.send(out) } -> std::convertible_to<std::size_t>;
  /// Throws away what waits, in both directions where that can be; how many frames that were.
  { link.drain() } -> std::convertible_to<std::size_t>;
};

/// The notes of the port about one drive.
struct PortDrive {
  DriveFindings seen;        ///< have been reported as a DriveCondition
  bool may_connect = false;  ///< the wish to be switched on allows one set-up
  bool may_enable = false;   ///< and one switching on: nothing resumes by itself
};

/// One bus of a rig. Refers to the caller's memory.
template <FrameLink Link>
struct Cia402Lane {
  Cia402Bus* bus = nullptr;
  Link* link = nullptr;
  std::span<std::int32_t> targets;  ///< one for each drive of the bus
  std::span<PortDrive> drives;      ///< one for each drive of the bus
  std::span<Frame> frames;          ///< at least frames_per_read; in a tick no more are taken
};

/// Feedback, heartbeat, EMCY and an SDO answer of every drive in one tick, and some that are not meant for
/// us.
constexpr std::size_t frames_per_read(std::size_t drives) {
  return 4 * drives + 16;
}

/// The drive of an axis of the rig, and its scale.
template <Precise Real>
struct Cia402Axis {
  std::size_t lane = 0;
  std::size_t drive = 0;     ///< on its bus
  Real counts_per_unit = 1;  ///< not 0; negative turns the direction round
  /// The place of the axis, for a drive that counts from wherever it is switched on. Taken when it first
  /// follows; none: its count 0 is position 0.
  std::optional<Real> stands_at = {};
  std::int64_t zero_counts = 0;  ///< the count of position 0, kept by the port
};

/// The operator may see these counters of a lane. They only grow.
struct LaneCounters {
  std::uint32_t unsent = 0;   ///< frames that the link did not take
  std::uint32_t floods = 0;   ///< reads in which more had arrived than is taken in a tick
  std::uint32_t drained = 0;  ///< stale frames thrown away before the drives were switched on
};

/// How many ticks in a row may have frames that the link did not take (docs/faults.md 13).
inline constexpr std::int32_t unsent_ticks_limit = 3;

/// Per tick and bus: one bounded read, then SYNC, the targets, the host's heartbeat and at most one service
/// frame in one send. O(axes + frames), no allocation.
///
/// A fault of a drive is reported once when it is found, and then as long as it lasts while the drive
/// follows targets: a drive that is off can be switched on again, which finds out for itself.
template <Precise Real, FrameLink Link>
class Cia402Port {
 public:
  static constexpr std::size_t max_lanes = 8;

  /// Errors: wrong_count (no lane, more than max_lanes, memory that does not fit a bus), out_of_range with
  /// axis (no such lane or drive, a scale of 0).
  static Result<Cia402Port> make(std::span<const Cia402Lane<Link>> lanes, std::span<Cia402Axis<Real>> axes) {
    if (lanes.empty() || lanes.size() > max_lanes) {
      return Error{.code = ErrorCode::wrong_count,
                   .what = "a rig has no bus, or more than its port can serve",
                   .remedy = "use 1 to 8 buses"};
    }
    for (const Cia402Lane<Link>& lane : lanes) {
      const std::size_t drives = lane.bus->drives().size();
      if (lane.targets.size() == drives && lane.drives.size() == drives &&
          lane.frames.size() >= frames_per_read(drives)) {
        continue;
      }
      return Error{.code = ErrorCode::wrong_count,
                   .what = "a bus has not the memory for its drives",
                   .remedy = "give it a target and a PortDrive for each, and frames_per_read() frames"};
    }
    for (std::size_t i = 0; i < axes.size(); ++i) {
      const Cia402Axis<Real>& axis = axes[i];
      if (axis.lane < lanes.size() && axis.drive < lanes[axis.lane].bus->drives().size() &&
          axis.counts_per_unit != 0) {
        continue;
      }
      return Error{.code = ErrorCode::out_of_range,
                   .what = "an axis has no drive, or a scale of 0",
                   .remedy = "name one of the drives of its bus",
                   .axis = static_cast<std::int32_t>(i)};
    }
    return Cia402Port(lanes, axes);
  }

  void read(std::span<DriveState<Real>> states, std::int64_t now_ns) {
    now_ns_ = now_ns;
    for (std::size_t l = 0; l < lanes_.size(); ++l) {
      const Cia402Lane<Link>& lane = lanes_[l];
      const std::size_t count = lane.link->receive(lane.frames, now_ns);
      if (count == lane.frames.size()) ++counters_[l].floods;
      for (const Frame& frame : lane.frames.first(count)) lane.bus->receive(frame, now_ns);
    }
    for (std::size_t i = 0; i < axes_.size(); ++i) states[i] = state_of_axis(i);
  }

  void write(std::span<const Setpoint<Real>> setpoints, std::int64_t now_ns) {
    now_ns_ = now_ns;
    const bool has_targets = !setpoints.empty() && take_targets(setpoints);
    if (wants_on_ && all_are_set_up()) switch_on();
    if (lets_go_ && none_may_have_power()) {
      for_each_drive([&](Cia402Drive& drive) { drive.leave(now_ns); });
    }
    for (std::size_t l = 0; l < lanes_.size(); ++l) {
      const Cia402Lane<Link>& lane = lanes_[l];
      if (wants_on_) bring_up(lane);
      const auto targets =
          has_targets ? std::span<const std::int32_t>(lane.targets) : std::span<const std::int32_t>();
      const Result<std::size_t> count = lane.bus->tick(now_ns, targets, lane.frames);
      if (!count) continue;  // make() has seen to it that there is room
      const std::size_t sent = lane.link->send(lane.frames.first(*count));
      counters_[l].unsent += static_cast<std::uint32_t>(*count - sent);
      unsent_ticks_[l] = sent < *count ? unsent_ticks_[l] + 1 : 0;
      if (unsent_ticks_[l] >= unsent_ticks_limit) was_unsent_[l] = true;
    }
  }

  void enable() {
    for (std::size_t l = 0; l < lanes_.size(); ++l) {
      const Cia402Lane<Link>& lane = lanes_[l];
      counters_[l].drained += static_cast<std::uint32_t>(lane.link->drain());
      unsent_ticks_[l] = 0;
      was_unsent_[l] = false;
      for (std::size_t d = 0; d < lane.drives.size(); ++d) {
        lane.bus->drives()[d].acknowledge();
        lane.drives[d] = {.seen = {}, .may_connect = true, .may_enable = true};
      }
    }
    is_out_of_range_ = false;
    lets_go_ = false;
    wants_on_ = true;
  }
  void disable() {
    wants_on_ = false;
    lets_go_ = true;
    for_each_drive([&](Cia402Drive& drive) { drive.disable(now_ns_); });
  }
  void quick_stop() {
    wants_on_ = false;
    for_each_drive([&](Cia402Drive& drive) { drive.quick_stop(now_ns_); });
  }

  /// The axis is at `position`, whatever its drive counts, from now on. Only while no setpoint follows: the
  /// next would be a jump by the difference. O(1).
  void place(std::size_t axis, Real position) {
    const Real counts = std::floor(position * axes_[axis].counts_per_unit + Real(0.5));
    axes_[axis].zero_counts = held_counts(drive_of(axes_[axis])) - static_cast<std::int64_t>(counts);
  }

  [[nodiscard]] const LaneCounters& counters(std::size_t lane) const { return counters_[lane]; }
  /// Several ticks in a row had frames that the link did not take, since the drives were switched on.
  [[nodiscard]] bool is_unsent(std::size_t lane) const { return was_unsent_[lane]; }
  /// The drive of an axis, for whoever wants to know what is wrong.
  [[nodiscard]] const Cia402Drive& drive(std::size_t axis) const { return drive_of(axes_[axis]); }

 private:
  Cia402Port(std::span<const Cia402Lane<Link>> lanes, std::span<Cia402Axis<Real>> axes)
      : lanes_(lanes), axes_(axes) {}

  [[nodiscard]] Cia402Drive& drive_of(const Cia402Axis<Real>& axis) const {
    return lanes_[axis.lane].bus->drives()[axis.drive];
  }
  template <class Action>
  void for_each_drive(Action&& action) {
    for (const Cia402Lane<Link>& lane : lanes_) {
      for (Cia402Drive& drive : lane.bus->drives()) action(drive);
    }
  }

  /// Tells where an axis is. While a drive that is switched on waits for its first target, that is the place
  /// where it is held, even if the axis sags: the first target goes on from that place.
  [[nodiscard]] static std::int64_t held_counts(const Cia402Drive& drive) {
    const bool is_held = drive.phase() == DrivePhase::following && !drive.is_commanded();
    return is_held ? drive.target() : drive.feedback().actual;
  }

  [[nodiscard]] DriveState<Real> state_of_axis(std::size_t i) {
    Cia402Axis<Real>& axis = axes_[i];
    const Cia402Drive& drive = drive_of(axis);
    if (drive.phase() == DrivePhase::following && axis.stands_at) {
      place(i, *axis.stands_at);
      axis.stands_at.reset();
    }
    return {.actual = static_cast<Real>(held_counts(drive) - axis.zero_counts) / axis.counts_per_unit,
            .is_on = drive.phase() == DrivePhase::following,
            .is_leaving = lanes_[axis.lane].link->is_up() && drive.is_leaving(),
            .condition = condition_of(axis)};
  }

  [[nodiscard]] DriveCondition condition_of(const Cia402Axis<Real>& axis) {
    const Cia402Lane<Link>& lane = lanes_[axis.lane];
    const Cia402Drive& drive = drive_of(axis);
    if (!lane.link->is_up()) return DriveCondition::unreachable;
    DriveCondition worst = is_out_of_range_ ? DriveCondition::unreachable : DriveCondition::fine;
    if (unsent_ticks_[axis.lane] >= unsent_ticks_limit)
      worst = std::max(worst, DriveCondition::cannot_follow);
    PortDrive& known = lane.drives[axis.drive];
    for (std::size_t f = 0; f < drive_findings; ++f) {
      const auto finding = static_cast<DriveFinding>(f);
      const bool is_new = drive.findings().has(finding) && !known.seen.has(finding);
      const bool lasts = drive.phase() == DrivePhase::following && drive.lasting().has(finding);
      if (is_new || lasts) worst = std::max(worst, condition_of(words_of(finding).reaction));
    }
    known.seen = drive.findings();
    return worst;
  }
  static constexpr DriveCondition condition_of(DriveReaction reaction) {
    switch (reaction) {
      case DriveReaction::refuse:
      case DriveReaction::controlled_stop:
      case DriveReaction::controlled_stop_then_quick:
        return DriveCondition::cannot_follow;
      case DriveReaction::quick_stop:
      case DriveReaction::cease_setpoints:
        break;
    }
    return DriveCondition::unreachable;
  }

  /// In counts, to the nearest. False, and nothing is sent, where one is beyond what a drive can count to.
  bool take_targets(std::span<const Setpoint<Real>> setpoints) {
    for (std::size_t i = 0; i < axes_.size(); ++i) {
      const Real counts = std::floor(setpoints[i].position * axes_[i].counts_per_unit + Real(0.5)) +
                          static_cast<Real>(axes_[i].zero_counts);
      constexpr auto max_counts = static_cast<Real>(std::numeric_limits<std::int32_t>::max() - 128);
      if (!(std::fabs(counts) <= max_counts)) {
        is_out_of_range_ = true;
        return false;
      }
      lanes_[axes_[i].lane].targets[axes_[i].drive] = static_cast<std::int32_t>(counts);
    }
    return true;
  }

  void bring_up(const Cia402Lane<Link>& lane) {
    for (std::size_t d = 0; d < lane.drives.size(); ++d) {
      const DrivePhase phase = lane.bus->drives()[d].phase();
      const bool is_away = phase == DrivePhase::off || phase >= DrivePhase::disabled;
      if (!is_away || !lane.drives[d].may_connect) continue;
      lane.drives[d].may_connect = !lane.bus->drives()[d].connect(now_ns_);
    }
  }
  /// Those whose bus is down are not waited for: nobody can tell them anything.
  [[nodiscard]] bool none_may_have_power() const {
    return std::ranges::none_of(lanes_, [](const Cia402Lane<Link>& lane) {
      return lane.link->is_up() && std::ranges::any_of(lane.bus->drives(), [](const Cia402Drive& drive) {
               return drive.phase() == DrivePhase::disabling;
             });
    });
  }
  /// None is switched on before all can be.
  [[nodiscard]] bool all_are_set_up() const {
    for (const Cia402Lane<Link>& lane : lanes_) {
      for (const Cia402Drive& drive : lane.bus->drives()) {
        if (drive.phase() < DrivePhase::idle || drive.phase() > DrivePhase::stopping) return false;
      }
    }
    return true;
  }
  void switch_on() {
    for (const Cia402Lane<Link>& lane : lanes_) {
      for (std::size_t d = 0; d < lane.drives.size(); ++d) {
        Cia402Drive& drive = lane.bus->drives()[d];
        const bool is_off = drive.phase() == DrivePhase::idle || drive.phase() == DrivePhase::stopping;
        if (is_off && lane.drives[d].may_enable) lane.drives[d].may_enable = !drive.enable(now_ns_);
      }
    }
  }

  std::span<const Cia402Lane<Link>> lanes_;
  std::span<Cia402Axis<Real>> axes_;
  std::array<LaneCounters, max_lanes> counters_{};
  std::array<std::int32_t, max_lanes> unsent_ticks_{};
  std::array<bool, max_lanes> was_unsent_{};
  std::int64_t now_ns_ = 0;
  bool wants_on_ = false;
  bool lets_go_ = false;          ///< the drives are switched off, and then let go together
  bool is_out_of_range_ = false;  ///< a setpoint was: setpoints cease
};

}  // namespace inbetween::can
