// Axes of a rig go to positions, together and slowly.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "host_tools/loop/rig_session.hpp"
#include "host_tools/motions/transit.hpp"

namespace inbetween {

/// The targets that `positions`, by the names of the axes, ask for. Throws InputError for an axis that the
/// rig does not have, LimitError for a position outside its limits.
std::vector<GoTarget> go_targets(const RigFile& rig, const std::map<std::string, double>& positions);

struct GoOptions {
  /// The axes may use this share of their limits of velocity, acceleration and jerk: above 0, up to 1.
  double share = transit_share;
  SessionOptions session = {};
};

/// Switches the rig on, asks the audience, goes there from wherever the axes stand (Transit), and switches it
/// off. Axes that are there already do not move.
///
/// Throws InputError where a target is unreferenced (nothing has been opened then) or the rig file has
/// changed since it was read, and what RigSession and RigReference throw.
SetupEnd go_to(const RigFile& rig, const std::vector<GoTarget>& targets, RigReference& reference,
               const GoOptions& options);

/// The same for one axis, by `distance` from where it stands. One that does not know where it is has no
/// limits, gets a tenth of the share, and moves alone: nothing is sent to other drives (lone_axis.hpp).
/// Throws LimitError where another would leave its limits.
SetupEnd go_by(const RigFile& rig, std::size_t axis, double distance, RigReference& reference,
               const GoOptions& options);

}  // namespace inbetween
