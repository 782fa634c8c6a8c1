#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/result.hpp"
#include "inbetween/can/drive_finding.hpp"
#include "inbetween/can/drive_phase.hpp"
#include "inbetween/loop/axis_watch.hpp"
#include "inbetween/loop/ports.hpp"

/// Drives of one protocol, on any number of buses, as the drives of a rig (DrivePort). docs/new-drive.md says
/// what a protocol has to bring.

namespace inbetween::can {

/// An interface to a bus with frames of this type. Nothing waits.
template <class Link, class Frame>
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

/// One drive as its host sees it: set up, switched on, given a target every tick, watched. Nothing waits;
/// every call is O(1). Its phases and findings are the same for all protocols.
///
/// `Place` is what the drive counts its positions in, `Target` what it is sent. The requests connect, enable,
/// disable, leave and quick_stop return false where the phase does not allow them (drive_phase.hpp).
template <class Drive>
concept BusDrive = requires(Drive& drive, const Drive& known, std::int64_t now_ns, typename Drive::Place zero,
                            double unit) {
  { drive.connect(now_ns) } -> std::convertible_to<bool>;
  { drive.enable(now_ns) } -> std::convertible_to<bool>;
  { drive.disable(now_ns) } -> std::convertible_to<bool>;
  { drive.leave(now_ns) } -> std::convertible_to<bool>;
  { drive.quick_stop(now_ns) } -> std::convertible_to<bool>;
  /// Takes the power away at once, whether the axis rests or not; otherwise it does what disable does.
  { drive.cut(now_ns) } -> std::convertible_to<bool>;
  { known.may_have_power() } -> std::convertible_to<bool>;
  /// Somebody has seen the findings. Those whose cause lasts come back with the next tick.
  drive.acknowledge();
  { known.phase() } -> std::convertible_to<DrivePhase>;
  { known.findings() } -> std::convertible_to<DriveFindings>;
  { known.lasting() } -> std::convertible_to<DriveFindings>;
  { known.first_finding() } -> std::convertible_to<std::optional<DriveFinding>>;
  { known.is_leaving() } -> std::convertible_to<bool>;
  /// Tells where the axis is. While a drive that is switched on waits for its first target, that is the
  /// place where it is held, even if the axis sags: the first target goes on from that place.
  { known.held_place() } -> std::convertible_to<typename Drive::Place>;
  /// The nearest place of the drive.
  { Drive::place_of(unit) } -> std::convertible_to<typename Drive::Place>;
  /// A position and a velocity in units of the drive, counted from `zero`. Nothing where the drive cannot
  /// be told to go there.
  { Drive::target_of(unit, unit, zero) } -> std::convertible_to<std::optional<typename Drive::Target>>;
};

/// The host's side of one bus, on which all frames are of one type. Only tick() sends, so that the drives
/// stop by themselves as soon as nobody calls it.
template <class Bus>
concept DriveBus = BusDrive<typename Bus::Drive> &&
    requires(Bus& bus, const typename Bus::Frame& frame, std::int64_t now_ns,
             std::span<const typename Bus::Drive::Target> targets, std::span<typename Bus::Frame> frames) {
  { bus.drives() } -> std::convertible_to<std::span<typename Bus::Drive>>;
  /// A frame that has arrived. Those of others are no concern of ours.
  bus.receive(frame, now_ns);
  /// A target for each drive, or none at all: then nothing is sent that keeps a drive moving. Returns how
  /// many frames were put into `frames`, at most frames_per_tick(drives).
  { bus.tick(now_ns, targets, frames) } -> std::convertible_to<Result<std::size_t>>;
  { Bus::frames_per_tick(std::size_t{}) } -> std::convertible_to<std::size_t>;
};

/// The notes of the port about one drive.
struct PortDrive {
  DriveFindings seen;        ///< have been reported as a DriveCondition
  bool may_connect = false;  ///< the request to be switched on allows one set-up
  bool may_enable = false;   ///< and one switching on: nothing resumes by itself
  bool has_forgotten =
      false;  ///< it has started anew since it was connected first; nobody can acknowledge that
};

/// One bus of a rig. Refers to the caller's memory.
template <DriveBus Bus, FrameLink<typename Bus::Frame> Link>
struct BusLane {
  Bus* bus = nullptr;
  Link* link = nullptr;
  std::span<typename Bus::Drive::Target> targets;  ///< one for each drive of the bus
  std::span<PortDrive> drives;                     ///< one for each drive of the bus
  std::span<typename Bus::Frame> frames;           ///< at least frames_per_read; in a tick no more are taken
};

/// Four reports and answers of every drive in one tick, and some that are not meant for us.
constexpr std::size_t frames_per_read(std::size_t drives) {
  return 4 * drives + 16;
}

/// The drive of an axis of the rig, and its scale. Without a watch nothing but its drive looks after it.
template <DriveBus Bus>
struct BusAxis {
  std::size_t lane = 0;
  std::size_t drive = 0;  ///< on its bus
  double scale = 1;       ///< units of the drive per axis unit, not 0; negative turns the direction round
  /// The place of the axis, for a drive that counts from wherever it is switched on. Taken when it first
  /// follows; none: the place 0 of the drive is position 0.
  std::optional<double> stands_at = {};
  typename Bus::Drive::Place zero = {};  ///< the place of position 0, kept by the port
  std::optional<AxisWatch> watch = {};
  // Kept by the port.
  OwnStop own_stop = OwnStop::none;
  bool had_power = false;
  std::optional<double> speed_without_power = {};  ///< it still moved, in units/s, when its power went
};

/// The operator may see these counters of a lane. They only grow.
struct LaneCounters {
  std::uint32_t unsent = 0;   ///< frames that the link did not take
  std::uint32_t floods = 0;   ///< reads in which more had arrived than is taken in a tick
  std::uint32_t drained = 0;  ///< stale frames thrown away before the drives were switched on
};

/// How many ticks in a row may have frames that the link did not take (docs/faults.md 13).
inline constexpr std::int32_t unsent_ticks_limit = 3;

/// Per tick and bus: one bounded read, then whatever the bus sends in a tick in one send. O(axes + frames),
/// no allocation.
///
/// A fault of a drive is reported once when it is found, and then as long as it lasts while the drive
/// follows targets: a drive that is off can be switched on again, which finds out for itself.
///
/// A drive that is too far from its target is stopped alone and at once. It loses its power if it gets away
/// all the same (AxisWatch), or does not answer.
template <DriveBus Bus, FrameLink<typename Bus::Frame> Link>
class BusPort {
 public:
  using Drive = typename Bus::Drive;
  using Lane = BusLane<Bus, Link>;
  using Axis = BusAxis<Bus>;
  static constexpr std::size_t max_lanes = 8;

  /// Errors: wrong_count (no lane, more than max_lanes, memory that does not fit a bus), out_of_range with
  /// axis (no such lane or drive, a scale of 0).
  static Result<BusPort> make(std::span<const Lane> lanes, std::span<Axis> axes) {
    if (lanes.empty() || lanes.size() > max_lanes) {
      return Error{.code = ErrorCode::wrong_count,
                   .what = "a rig has no bus, or more than its port can serve",
                   .remedy = "use 1 to 8 buses"};
    }
    for (const Lane& lane : lanes) {
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
      const Axis& axis = axes[i];
      if (axis.lane < lanes.size() && axis.drive < lanes[axis.lane].bus->drives().size() && axis.scale != 0) {
        continue;
      }
      return Error{.code = ErrorCode::out_of_range,
                   .what = "an axis has no drive, or a scale of 0",
                   .remedy = "name one of the drives of its bus",
                   .axis = static_cast<std::int32_t>(i)};
    }
    return BusPort(lanes, axes);
  }

  void read(std::span<DriveState> states, std::int64_t now_ns) {
    now_ns_ = now_ns;
    for (std::size_t l = 0; l < lanes_.size(); ++l) {
      const Lane& lane = lanes_[l];
      const std::size_t count = lane.link->receive(lane.frames, now_ns);
      if (count == lane.frames.size()) ++counters_[l].floods;
      for (const typename Bus::Frame& frame : lane.frames.first(count)) lane.bus->receive(frame, now_ns);
    }
    for (std::size_t i = 0; i < axes_.size(); ++i) states[i] = state_of_axis(i);
  }

  void write(std::span<const Setpoint> setpoints, std::int64_t now_ns) {
    now_ns_ = now_ns;
    const bool has_targets = !setpoints.empty() && take_targets(setpoints);
    if (!has_targets) tell_nothing();
    if (wants_on_ && may_switch_on_ && is_set_up()) switch_on();
    if (lets_go_ && none_may_have_power()) {
      for_each_drive([&](Drive& drive) { drive.leave(now_ns); });
    }
    for (std::size_t l = 0; l < lanes_.size(); ++l) {
      const Lane& lane = lanes_[l];
      if (wants_on_) bring_up(lane);
      using Targets = std::span<const typename Drive::Target>;
      const Result<std::size_t> count =
          lane.bus->tick(now_ns, has_targets ? Targets(lane.targets) : Targets(), lane.frames);
      if (!count) continue;  // make() has seen to it that there is room
      const std::size_t sent = lane.link->send(lane.frames.first(*count));
      counters_[l].unsent += static_cast<std::uint32_t>(*count - sent);
      unsent_ticks_[l] = sent < *count ? unsent_ticks_[l] + 1 : 0;
      if (unsent_ticks_[l] >= unsent_ticks_limit) was_unsent_[l] = true;
    }
  }

  void enable() {
    for (std::size_t l = 0; l < lanes_.size(); ++l) {
      const Lane& lane = lanes_[l];
      counters_[l].drained += static_cast<std::uint32_t>(lane.link->drain());
      unsent_ticks_[l] = 0;
      was_unsent_[l] = false;
      for (std::size_t d = 0; d < lane.drives.size(); ++d) {
        lane.bus->drives()[d].acknowledge();
        lane.drives[d] = {.seen = {},
                          .may_connect = true,
                          .may_enable = true,
                          .has_forgotten = lane.drives[d].has_forgotten};
      }
    }
    for (Axis& axis : axes_) {
      axis.own_stop = OwnStop::none;
      axis.speed_without_power.reset();
      if (axis.watch) axis.watch->reset();
    }
    is_out_of_range_ = false;
    lets_go_ = false;
    wants_on_ = true;
  }
  void disable() {
    wants_on_ = false;
    lets_go_ = true;
    for_each_drive([&](Drive& drive) { drive.disable(now_ns_); });
  }
  void quick_stop() {
    wants_on_ = false;
    for_each_drive([&](Drive& drive) { drive.quick_stop(now_ns_); });
  }

  /// StopsOne. The others go on.
  void stop_one(std::size_t axis, OwnStop how) {
    Axis& of = axes_[axis];
    if (how <= of.own_stop) return;
    of.own_stop = how;
    if (how == OwnStop::cut) {
      note_speed(of);
      drive_of(of).cut(now_ns_);
      return;
    }
    drive_of(of).quick_stop(now_ns_);
    if (of.watch) of.watch->begin_stop();
  }

  /// The axis is at `position`, whatever its drive counts, from now on. Only while no setpoint follows: the
  /// next would be a jump by the difference. O(1).
  void place(std::size_t axis, double position) {
    Axis& placed = axes_[axis];
    placed.zero = drive_of(placed).held_place() - Drive::place_of(position * placed.scale);
  }

  /// None is switched on before all can be.
  [[nodiscard]] bool is_set_up() const {
    for (const Lane& lane : lanes_) {
      for (const Drive& drive : lane.bus->drives()) {
        if (drive.phase() < DrivePhase::idle || drive.phase() > DrivePhase::stopping) return false;
      }
    }
    return true;
  }
  /// false: the drives are set up and wait, for those of another port, say.
  void let_switch_on(bool may) { may_switch_on_ = may; }

  [[nodiscard]] const LaneCounters& counters(std::size_t lane) const { return counters_[lane]; }
  /// Several ticks in a row had frames that the link did not take, since the drives were switched on.
  [[nodiscard]] bool is_unsent(std::size_t lane) const { return was_unsent_[lane]; }
  /// The drive of an axis may count from elsewhere than before: it has started anew, or may have.
  [[nodiscard]] bool has_forgotten(std::size_t axis) const {
    return lanes_[axes_[axis].lane].drives[axes_[axis].drive].has_forgotten;
  }
  [[nodiscard]] OwnStop own_stop(std::size_t axis) const { return axes_[axis].own_stop; }
  /// How fast the axis still moved when its power went, in units/s; nothing if it rested.
  [[nodiscard]] std::optional<double> speed_without_power(std::size_t axis) const {
    return axes_[axis].speed_without_power;
  }
  /// The drive of an axis, for whoever wants to know what is wrong.
  [[nodiscard]] const Drive& drive(std::size_t axis) const { return drive_of(axes_[axis]); }

 private:
  BusPort(std::span<const Lane> lanes, std::span<Axis> axes) : lanes_(lanes), axes_(axes) {}

  [[nodiscard]] Drive& drive_of(const Axis& axis) const {
    return lanes_[axis.lane].bus->drives()[axis.drive];
  }
  template <class Action>
  void for_each_drive(Action&& action) {
    for (const Lane& lane : lanes_) {
      for (Drive& drive : lane.bus->drives()) action(drive);
    }
  }

  [[nodiscard]] DriveState state_of_axis(std::size_t i) {
    Axis& axis = axes_[i];
    const Drive& drive = drive_of(axis);
    if (drive.phase() == DrivePhase::following && axis.stands_at) {
      place(i, *axis.stands_at);
      axis.stands_at.reset();
    }
    const double actual = static_cast<double>(drive.held_place() - axis.zero) / axis.scale;
    if (axis.watch) look_at(axis, drive, actual);
    const DriveCondition condition = condition_of(axis);
    watch_over(i);
    return {.actual = actual,
            .is_on = drive.phase() == DrivePhase::following,
            .is_leaving = drive.is_leaving() && lanes_[axis.lane].link->is_up(),
            .is_in_position = !axis.watch || axis.watch->is_in_position(),
            .own_stop = axis.own_stop,
            .condition = condition};
  }
  void look_at(Axis& axis, const Drive& drive, double actual) {
    axis.watch->look(actual, now_ns_);
    const bool has_power = drive.may_have_power();
    if (axis.had_power && !has_power) note_speed(axis);
    axis.had_power = has_power;
  }
  /// Its power goes.
  static void note_speed(Axis& axis) {
    const bool is_new = axis.watch && axis.watch->moves() && !axis.speed_without_power;
    if (is_new) axis.speed_without_power = axis.watch->speed();
  }
  /// After its findings are known.
  void watch_over(std::size_t i) {
    const Axis& axis = axes_[i];
    const Drive& drive = drive_of(axis);
    const bool is_too_far = drive.phase() == DrivePhase::following && stops_alone(drive.findings());
    if (is_too_far) stop_one(i, OwnStop::stopped);
    if (axis.own_stop != OwnStop::stopped) return;
    const bool gets_away = axis.watch && axis.watch->gets_away();
    if (gets_away || drive.findings().has(DriveFinding::quick_stop_ignored)) stop_one(i, OwnStop::cut);
  }

  [[nodiscard]] DriveCondition condition_of(const Axis& axis) {
    const Lane& lane = lanes_[axis.lane];
    const Drive& drive = drive_of(axis);
    if (!lane.link->is_up()) return DriveCondition::unreachable;
    DriveCondition worst = is_out_of_range_ ? DriveCondition::unreachable : DriveCondition::fine;
    if (unsent_ticks_[axis.lane] >= unsent_ticks_limit)
      worst = std::max(worst, DriveCondition::cannot_follow);
    PortDrive& known = lane.drives[axis.drive];
    DriveFindings reported = drive.findings().without(known.seen);
    // One that was stopped alone and does not answer loses its power, and the others go on.
    if (axis.own_stop == OwnStop::stopped) reported = reported.without(DriveFinding::quick_stop_ignored);
    if (drive.phase() == DrivePhase::following) reported.add(drive.lasting());
    known.seen = drive.findings();
    known.has_forgotten = known.has_forgotten || loses_reference(known.seen);
    while (!reported.empty()) {
      worst = std::max(worst, condition_of(words_of(reported.take()).reaction));
    }
    return worst;
  }
  static constexpr DriveCondition condition_of(DriveReaction reaction) {
    switch (reaction) {
      case DriveReaction::refuse:
      case DriveReaction::controlled_stop:
      case DriveReaction::own_stop:
        return DriveCondition::cannot_follow;
      case DriveReaction::quick_stop:
      case DriveReaction::cease_setpoints:
        break;
    }
    return DriveCondition::unreachable;
  }

  void tell_nothing() {
    for (Axis& axis : axes_) {
      if (axis.watch) axis.watch->tell_nothing();
    }
  }
  /// False, and nothing is sent, where one is beyond what a drive can be told.
  bool take_targets(std::span<const Setpoint> setpoints) {
    for (std::size_t i = 0; i < axes_.size(); ++i) {
      Axis& axis = axes_[i];
      const auto target =
          Drive::target_of(setpoints[i].position * axis.scale, setpoints[i].velocity * axis.scale, axis.zero);
      if (!target) {
        is_out_of_range_ = true;
        return false;
      }
      lanes_[axis.lane].targets[axis.drive] = *target;
      if (axis.watch) axis.watch->tell(setpoints[i].position);
    }
    return true;
  }

  void bring_up(const Lane& lane) {
    for (std::size_t d = 0; d < lane.drives.size(); ++d) {
      const DrivePhase phase = lane.bus->drives()[d].phase();
      const bool is_away = phase == DrivePhase::off || phase >= DrivePhase::disabled;
      if (!is_away || !lane.drives[d].may_connect) continue;
      lane.drives[d].may_connect = !lane.bus->drives()[d].connect(now_ns_);
    }
  }
  /// Those whose bus is down are not waited for: nobody can tell them anything.
  [[nodiscard]] bool none_may_have_power() const {
    return std::ranges::none_of(lanes_, [](const Lane& lane) {
      return lane.link->is_up() && std::ranges::any_of(lane.bus->drives(), [](const Drive& drive) {
               return drive.phase() == DrivePhase::disabling;
             });
    });
  }
  void switch_on() {
    for (const Lane& lane : lanes_) {
      for (std::size_t d = 0; d < lane.drives.size(); ++d) {
        Drive& drive = lane.bus->drives()[d];
        const bool is_off = drive.phase() == DrivePhase::idle || drive.phase() == DrivePhase::stopping;
        if (is_off && lane.drives[d].may_enable) lane.drives[d].may_enable = !drive.enable(now_ns_);
      }
    }
  }

  std::span<const Lane> lanes_;
  std::span<Axis> axes_;
  std::array<LaneCounters, max_lanes> counters_{};
  std::array<std::int32_t, max_lanes> unsent_ticks_{};
  std::array<bool, max_lanes> was_unsent_{};
  std::int64_t now_ns_ = 0;
  bool wants_on_ = false;
  bool may_switch_on_ = true;
  bool lets_go_ = false;          ///< the drives are switched off, and then let go together
  bool is_out_of_range_ = false;  ///< a setpoint was: setpoints cease
};

}  // namespace inbetween::can
