// The slow way of a rig from where it stands to where a move starts.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "host_tools/plan/plan.hpp"

namespace inbetween {

/// Of an axis' limits of velocity, acceleration and jerk, what the way to the start may use.
inline constexpr double approach_share = 0.1;

/// From `actual`, a position for every axis of the rig, to the first position of the plan: all axes together
/// on a straight line, from rest to rest, in the fewest frames within approach_share of the limits. It can be
/// stopped as any move can, within the stop limits of the rig. Nothing where every axis of the plan stands
/// there already, within what its acceleration covers in a tick (MotionLoop::begin).
///
/// Throws InputError at the place of an axis that stands outside its limits.
std::optional<Plan> plan_approach(const Plan& plan, std::span<const double> actual);

/// For somebody who has to agree: what moves from where to where, and how long it takes. Lines, without a
/// newline at the end.
std::string describe_approach(const Plan& approach);

}  // namespace inbetween
