#pragma once

#include <span>

#include "inbetween/base/result.hpp"
#include "inbetween/limits/roll.hpp"
#include "inbetween/trajectory/trajectory.hpp"

/// A pre-roll or post-roll as a trajectory.

namespace inbetween {

/// The rolls of some axes, as they are: one piece, because a quartic has a quintic's ends and is that
/// quintic. It joins the trajectory of the move with its position, velocity and acceleration to the last bit,
/// and has no velocity and no acceleration at its other end.
///
/// Errors: wrong_count (no axis, or no bucket), capacity (pieces: 1; values: 6 for each axis). O(axes).
Result<Trajectory> roll_trajectory(std::span<const RollAxis> rolls, const TrajectoryMemory& memory);

}  // namespace inbetween
