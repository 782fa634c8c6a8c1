#include "host_tools/motions/home.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host_tools/loop/manual_motion.hpp"
#include "host_tools/motions/go_to.hpp"
#include "host_tools/motions/rig_homing.hpp"
#include "host_tools/plan/move_rolls.hpp"
#include "host_tools/reference/axis_positions.hpp"
#include "host_tools/rig/rig_watch.hpp"
#include "host_tools/rig_model/rig_motors.hpp"
#include "host_tools/text/diagnostics.hpp"

namespace inbetween {
namespace {

bool has_home(const RigAxis& axis) {
  return axis.home || axis.drive_home;
}

void refuse_fast_homing(const RigFile& rig, const std::vector<std::size_t>& axes) {
  for (const std::size_t a : axes) {
    const RigAxis& axis = rig.axes[a];
    const double max_fast = jitter_share * axis.max_velocity;
    const double fast = axis.home ? axis.home->fast : axis.drive_home->fast;
    if (fast <= max_fast) continue;
    throw InputError(axis.home ? axis.home->place : axis.drive_home->place,
                     fmt::format("axis {} homes at {:g} {}/s, and with --allow-jitter at {:g} at most; lower "
                                 "`fast`, or give the program its real-time rights",
                                 in_quotes(axis.name), fast, to_string(axis.unit), max_fast));
  }
}

SetupEnd home_armed(RigSession& session, const std::vector<std::size_t>& axes, RigReference& reference) {
  const RigFile& rig = session.rig();
  std::vector<AxisLimits> limits;
  limits.reserve(axes.size());
  for (const std::size_t a : axes) {
    limits.push_back(limits_of(slow_enough_everywhere(rig.axes[a])));
    reference.is_lost(a, "its homing was not done");
  }
  RigHoming<RigInputs> homing(rig, axes, session.lines(),
                              {.positions = session.positions(),
                               .drives = session.loop().drive_states(),
                               .tick_seconds = session.tick_seconds(),
                               .delay_ns = session.delay_ns()});
  ManualMotion play(session.loop(),
                    {.source = source_of(homing),
                     .drive_of = axes,
                     .limits = limits,
                     .tick_seconds = session.tick_seconds()},
                    "homing");
  const DisarmAtEnd disarm(session);
  reference.about_to_move(axes);
  const ActEnd played = session.perform(play);
  SetupEnd end{.is_done = played.begun && play.is_done() && homing.is_done(), .reason = "the axes are home"};
  if (!played.begun) {
    end.reason = played.begun.error().what;
  } else if (!end.is_done) {
    end.reason = homing.reason();
    if (end.reason.empty()) end.reason = reason_of(session, "stopped before its end");
  }
  const std::string unreached = session.rest();
  if (end.is_done && !unreached.empty()) end = {.is_done = false, .reason = unreached};
  end.positions = session.positions();
  for (std::size_t i = 0; end.is_done && i < axes.size(); ++i) {
    end.positions[axes[i]] += homing.shift(i);
    reference.stands_at(axes[i], end.positions[axes[i]]);
  }
  return end;
}

/// What to do instead, as a command that takes such an axis.
std::string remedy_without_home(const RigFile& rig, const RigAxis& axis) {
  if (axis.reference == Reference::by_drive) {
    return fmt::format("its drive says where it is, and inbetween goto --rig {} {}={:g} brings it there",
                       rig.path, axis.name, std::clamp(0.0, axis.min, axis.max));
  }
  const bool has_zero = axis.min <= 0 && axis.max >= 0;
  return fmt::format(
      "bring it to its mark with inbetween jog --rig {} {}, and say so with inbetween goto --rig {} {}",
      rig.path, axis.name, rig.path,
      has_zero ? fmt::format("--set-zero {}", axis.name)
               : fmt::format("--stands-at {}={:g}", axis.name, axis.min));
}

/// All of `axes`, which are home then.
SetupEnd home_all(const RigFile& rig, const std::vector<std::size_t>& axes, RigReference& reference,
                  const SessionOptions& options) {
  // Drives that home by themselves come first, one after the other, while no other drive has power.
  SessionOptions others = options;
  std::vector<std::size_t> by_switch;
  SetupEnd end{
      .is_done = true, .reason = "the axes are home", .positions = std::vector<double>(rig.axes.size())};
  for (const std::size_t a : axes) {
    if (rig.axes[a].home) by_switch.push_back(a);
    if (!rig.axes[a].drive_home) continue;
    SetupEnd homed = home_by_drive(rig, a, reference, options);
    if (!homed.is_done) return homed;
    end.positions[a] = homed.positions[a];
    others.standing.erase(rig.axes[a].name);
  }
  if (by_switch.empty()) return end;
  RigSession session(rig, reference, others);
  return end_of(session, [&]() -> SetupEnd {
    if (!session.arm()) return {.reason = reason_of(session, "the drives were not switched on")};
    refuse_changed_rig(rig.path, options.audience.rig_has_changed);
    return home_armed(session, by_switch, reference);
  });
}

/// Those of `axes` that park, from where they are home. In a session of its own: the drives count from the
/// homes only when they are placed anew. Whoever let them home has agreed to where the rig says that they
/// park.
SetupEnd park(const RigFile& rig, const std::vector<std::size_t>& axes, RigReference& reference,
              SessionOptions options, const SetupEnd& home) {
  std::vector<GoTarget> targets;
  for (const std::size_t a : axes) {
    options.standing.erase(rig.axes[a].name);
    if (rig.axes[a].park) targets.push_back({.axis = a, .position = *rig.axes[a].park});
  }
  if (targets.empty()) return home;
  options.audience.confirm = [](const std::string&) { return true; };
  SetupEnd end = go_to(rig, targets, reference, {.session = options});
  end.reason = end.is_done ? home.reason + ", and parked" : home.reason + ", but not parked: " + end.reason;
  if (end.positions.empty()) end.positions = home.positions;
  return end;
}

}  // namespace

std::vector<std::size_t> home_axes(const RigFile& rig, const std::vector<std::string>& names) {
  std::vector<bool> wanted(rig.axes.size(), names.empty());
  for (const std::string& name : names) {
    const std::size_t a = axis_named(rig, name);
    if (!has_home(rig.axes[a])) {
      throw InputError(rig.axes[a].place, fmt::format("axis {} has no home switch; {}", in_quotes(name),
                                                      remedy_without_home(rig, rig.axes[a])));
    }
    wanted[a] = true;
  }
  std::vector<std::size_t> axes;
  for (std::size_t a = 0; a < rig.axes.size(); ++a) {
    if (wanted[a] && has_home(rig.axes[a])) axes.push_back(a);
  }
  if (axes.empty()) {
    throw InputError({rig.path, 0, 0}, fmt::format("no axis of the rig has a home switch; for axis {}, {}",
                                                   in_quotes(rig.axes.front().name),
                                                   remedy_without_home(rig, rig.axes.front())));
  }
  return axes;
}

SetupEnd home(const RigFile& rig, const std::vector<std::size_t>& axes, RigReference& reference,
              const SessionOptions& options) {
  if (options.allow_jitter) refuse_fast_homing(rig, axes);
  const SetupEnd end = home_all(rig, axes, reference, options);
  return end.is_done ? park(rig, axes, reference, options, end) : end;
}

}  // namespace inbetween
