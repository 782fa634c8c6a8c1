#include "host_tools/motions/go_to.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "host_tools/check/check.hpp"
#include "host_tools/files/diagnostics.hpp"
#include "host_tools/loop/manual_motion.hpp"
#include "host_tools/reference/axis_positions.hpp"
#include "host_tools/rig/rig_watch.hpp"

namespace inbetween {

std::vector<GoTarget> go_targets(const RigFile& rig, const std::map<std::string, double>& positions) {
  std::vector<GoTarget> targets;
  for (const auto& [name, position] : positions) {
    const std::size_t a = axis_named(rig, name);
    const RigAxis& axis = rig.axes[a];
    if (position < axis.min || position > axis.max) {
      throw LimitError(axis.place,
                       fmt::format("axis {} would go to {} {}, outside its limits {}; go to a position "
                                   "between them",
                                   in_quotes(name), position, to_string(axis.unit), range_in_words(axis)));
    }
    targets.push_back({.axis = a, .position = position});
  }
  std::ranges::sort(targets, {}, &GoTarget::axis);
  return targets;
}

namespace {

/// Nobody knows what lies beyond the limits of an axis.
void refuse_to_hurry(const RigFile& rig, const std::vector<GoTarget>& targets,
                     const std::vector<double>& positions, double share) {
  if (share <= slow_share) return;
  for (const GoTarget& target : targets) {
    const RigAxis& axis = rig.axes[target.axis];
    const double stands = positions[target.axis];
    if (stands >= axis.min && stands <= axis.max) continue;
    throw InputError(
        axis.place,
        fmt::format("{} stands at {:.10g} {}, outside its limits {}, and comes in at --speed {:g} at "
                    "most; leave out --speed",
                    named(axis), stands, to_string(axis.unit), range_in_words(axis), slow_share));
  }
}

SetupEnd go(RigSession& session, const std::vector<GoTarget>& targets, RigReference& reference,
            const GoOptions& options) {
  SetupEnd end;
  if (!session.arm()) {
    end.reason = reason_of(session, "the drives were not switched on");
    return end;
  }
  end.positions = session.positions();
  std::vector<GoTarget> away = targets;
  std::erase_if(away, [&](const GoTarget& to) { return end.positions[to.axis] == to.position; });
  if (away.empty()) {
    end.is_done = true;
    end.reason = "the axes are there already";
    return end;
  }
  refuse_to_hurry(session.rig(), away, end.positions, options.share);
  SlowWay way(session.rig(), away, end.positions, options.share);
  if (!options.session.audience.confirm(way.describe("these axes move together:"))) {
    end.reason = "nobody agreed, and nothing has moved";
    return end;
  }
  refuse_changed_rig(session.rig().path, options.session.audience.rig_has_changed);
  reference.about_to_move(way.axes());
  ManualMotion play(session.loop(), way.loop_spec(), "going there", way.ticks());
  const DisarmAtEnd disarm(session);
  const ActEnd played = session.perform(play, way.ticks());
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
