#include "host_tools/motions/go_to.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <utility>

#include "host_tools/check/check.hpp"
#include "host_tools/files/diagnostics.hpp"
#include "host_tools/loop/manual_motion.hpp"
#include "host_tools/motions/free_axes.hpp"
#include "host_tools/plan/move_rolls.hpp"
#include "host_tools/reference/axis_positions.hpp"
#include "host_tools/rig/rig_watch.hpp"

namespace inbetween {
namespace {

/// Some axes of a rig on their way, as a motion loop takes them.
struct Way {
  std::vector<std::size_t> drive_of;
  std::vector<AxisLimits<double>> limits;
  std::vector<FreeAxis<double>> axes;
  std::vector<double> from;
  std::int64_t ticks = 0;  ///< until the last of them rests
};

std::int64_t ticks_to_rest(FreeAxis<double> axis) {
  std::int64_t ticks = 0;
  for (; !axis.is_resting(); ++ticks) axis.tick();
  return ticks;
}

Way way_to(const RigSession& session, const std::vector<GoTarget>& targets, double share) {
  Way way;
  for (const GoTarget& target : targets) {
    const double from = session.positions()[target.axis];
    if (from == target.position) continue;
    const RigAxis& axis = session.rig().axes[target.axis];
    FreeAxis<double> free = free_axis_of(axis, free_limits_of(axis, share), from, session.tick_seconds());
    // Its limits let it go wherever they do, so that only a fault of this program is refused.
    if (const Status going = free.go_to(target.position); !going) throw std::logic_error(going.error().what);
    way.drive_of.push_back(target.axis);
    way.limits.push_back(limits_of(axis));
    way.from.push_back(from);
    way.ticks = std::max(way.ticks, ticks_to_rest(free));
    way.axes.push_back(free);
  }
  return way;
}

std::string describe(const RigSession& session, const Way& way, double share) {
  std::string words = "these axes move, each by itself:";
  for (std::size_t i = 0; i < way.axes.size(); ++i) {
    const RigAxis& axis = session.rig().axes[way.drive_of[i]];
    words += fmt::format("\n  {:<16}{:>12.3f} -> {:.3f} {}", axis.name, way.from[i], way.axes[i].end(),
                         to_string(axis.unit));
  }
  return words + fmt::format("\nthey are there in {:.1f} s, at {:g} % of their limits at most",
                             static_cast<double>(way.ticks) * session.tick_seconds(), share * 100);
}

}  // namespace

std::vector<GoTarget> go_targets(const RigFile& rig, const std::map<std::string, double>& positions) {
  std::vector<GoTarget> targets;
  for (const auto& [name, position] : positions) {
    const std::size_t a = axis_named(rig, name);
    const RigAxis& axis = rig.axes[a];
    if (position < axis.min || position > axis.max) {
      throw LimitError(axis.place,
                       fmt::format("axis {} would go to {} {}, outside its limits {}..{}; go to a "
                                   "position between them",
                                   in_quotes(name), position, to_string(axis.unit), axis.min, axis.max));
    }
    targets.push_back({.axis = a, .position = position});
  }
  std::ranges::sort(targets, {}, &GoTarget::axis);
  return targets;
}

namespace {

SetupEnd go(RigSession& session, const std::vector<GoTarget>& targets, RigReference& reference,
            const GoOptions& options) {
  SetupEnd end;
  if (!session.arm()) {
    end.reason = reason_of(session, "the drives were not switched on");
    return end;
  }
  Way way = way_to(session, targets, options.share);
  end.positions = session.positions();
  if (way.axes.empty()) {
    end.is_done = true;
    end.reason = "the axes are there already";
    return end;
  }
  if (!options.session.audience.confirm(describe(session, way, options.share))) {
    end.reason = "nobody agreed, and nothing has moved";
    return end;
  }
  refuse_changed_rig(session.rig().path, options.session.audience.rig_has_changed);
  reference.about_to_move(way.drive_of);
  FreeAxes axes(std::move(way.axes));
  ManualMotion play(session.loop(),
                    {.source = source_of<double>(axes),
                     .drive_of = way.drive_of,
                     .limits = way.limits,
                     .tick_seconds = session.tick_seconds()},
                    way.ticks);
  const DisarmAtEnd disarm(session);
  const ActEnd played = session.perform(act_of(play), way.ticks);
  end.is_done = played.begun && play.is_done();
  if (end.is_done) {
    end.reason = "the axes are there";
  } else {
    end.reason = reason_of(session, played.begun ? "stopped on the way" : played.begun.error().what);
  }
  session.rest();
  end.positions = session.positions();
  return end;
}

}  // namespace

SetupEnd go_to(const RigFile& rig, const std::vector<GoTarget>& targets, RigReference& reference,
               const GoOptions& options) {
  std::vector<std::size_t> wanted;
  wanted.reserve(targets.size());
  for (const GoTarget& target : targets) wanted.push_back(target.axis);
  reference.refuse_unreferenced(wanted);
  RigSession session(rig, reference, options.session);
  return end_of(session, [&] { return go(session, targets, reference, options); });
}

}  // namespace inbetween
