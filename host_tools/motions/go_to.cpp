#include "host_tools/motions/go_to.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host_tools/check/check.hpp"
#include "host_tools/loop/manual_motion.hpp"
#include "host_tools/motions/jog.hpp"
#include "host_tools/motions/lone_axis.hpp"
#include "host_tools/reference/axis_positions.hpp"
#include "host_tools/rig/rig_watch.hpp"
#include "host_tools/text/diagnostics.hpp"

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
  if (share <= transit_share) return;
  for (const GoTarget& target : targets) {
    const RigAxis& axis = rig.axes[target.axis];
    const double stands = positions[target.axis];
    if (stands >= axis.min && stands <= axis.max) continue;
    throw InputError(
        axis.place,
        fmt::format("{} stands at {:.10g} {}, outside its limits {}, and comes in at --speed {:g} at "
                    "most; leave out --speed",
                    named(axis), stands, to_string(axis.unit), range_in_words(axis), transit_share));
  }
}

/// From where the axes stand, which are on.
SetupEnd move(RigSession& session, const std::vector<GoTarget>& away, RigReference& reference, double share,
              const GoOptions& options) {
  SetupEnd end{.positions = session.positions()};
  Transit transit(session.rig(), away, end.positions, share);
  if (!options.session.audience.confirm(transit.describe("these axes move together:"))) {
    end.reason = "nobody agreed, and nothing has moved";
    return end;
  }
  refuse_changed_rig(session.rig().path, options.session.audience.rig_has_changed);
  reference.about_to_move(transit.axes());
  ManualMotion play(session.loop(), transit.loop_spec(), "going there", transit.ticks());
  const DisarmAtEnd disarm(session);
  const ActEnd played = session.perform(play, transit.ticks());
  end.is_done = played.begun && play.is_done();
  if (end.is_done) {
    end.reason = "the axes are there";
  } else {
    end.reason = reason_of(session, played.begun ? "stopped on the way" : played.begun.error().what);
  }
  const std::string unreached = session.rest();
  if (end.is_done && !unreached.empty()) end = {.is_done = false, .reason = unreached};
  end.positions = session.positions();
  return end;
}

SetupEnd not_switched_on(const RigSession& session) {
  return {.reason = reason_of(session, "the drives were not switched on")};
}

SetupEnd go(RigSession& session, const std::vector<GoTarget>& targets, RigReference& reference,
            const GoOptions& options) {
  if (!session.arm()) return not_switched_on(session);
  std::vector<GoTarget> away = targets;
  std::erase_if(away, [&](const GoTarget& to) { return session.positions()[to.axis] == to.position; });
  if (away.empty()) {
    return {.is_done = true, .reason = "the axes are there already", .positions = session.positions()};
  }
  refuse_to_hurry(session.rig(), away, session.positions(), options.share);
  return move(session, away, reference, options.share, options);
}

SetupEnd move_by(RigSession& session, std::size_t axis, double distance, RigReference& reference,
                 const GoOptions& options) {
  if (!session.arm()) return not_switched_on(session);
  const RigAxis& of = session.rig().axes[axis];
  const double from = session.positions()[axis];
  const double to = from + distance;
  const bool is_referenced = reference.is_referenced(axis);
  if (is_referenced && (to < of.min || to > of.max)) {
    throw LimitError(of.place,
                     fmt::format("{} stands at {:.10g} {} and would go to {:.10g}, outside its limits "
                                 "{}; write another distance, such as {:g}",
                                 named(of), from, to_string(of.unit), to, range_in_words(of), -distance));
  }
  return move(session, {{.axis = axis, .position = to}}, reference,
              options.share * (is_referenced ? 1 : unreferenced_jog_share), options);
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

SetupEnd go_by(const RigFile& rig, std::size_t axis, double distance, RigReference& reference,
               const GoOptions& options) {
  if (!reference.is_referenced(axis)) {
    return use_alone(rig, axis, reference, options.session, [&](RigSession& session, RigReference& unknown) {
      return move_by(session, 0, distance, unknown, options);
    });
  }
  RigSession session(rig, reference, options.session);
  return end_of(session, [&] { return move_by(session, axis, distance, reference, options); });
}

}  // namespace inbetween
