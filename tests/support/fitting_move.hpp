// Random moves on rigs that they fit (RapidCheck).
#pragma once

#include <optional>

#include "host_tools/check/check.hpp"
#include "host_tools/plan/plan.hpp"

namespace inbetween {

struct FittingMove {
  Plan plan;
  CheckReport report;
};

/// A regular move and a rig near it, each of whose limits is 102 to max_percent % of the peak. Nothing where
/// the move is beyond a rig or does not fit. With parts, half of them are any part of a move, which fits with
/// its rolls.
std::optional<FittingMove> fitting_move(int max_percent, bool with_parts = false);

/// The same move, or part of it, on the same rig, but a stop may use no more than the motion: what is no stop
/// is held to that.
Plan without_stop_limits(const Plan& plan);

}  // namespace inbetween
