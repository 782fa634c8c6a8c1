// The pre-roll and post-roll that a move needs on its rig.
#pragma once

#include <span>
#include <vector>

#include "host_tools/rig_model/rig_file.hpp"
#include "inbetween/limits/limits.hpp"
#include "inbetween/limits/played_motion.hpp"

namespace inbetween {

/// The limits that a rig file gives an axis, as the core takes them.
AxisLimits limits_of(const RigAxis& axis);

/// The rolls of every axis of all tracks, track after track. Empty if the move is at rest there, or if there
/// is an obstacle.
struct PlannedRolls {
  std::vector<RollAxis> before, after;
  std::vector<RollObstacle> obstacles;
};

/// join_rolls() with memory from the heap. Throws SolverError.
PlannedRolls plan_rolls(std::span<const Track> tracks, std::span<const Trajectory> trajectories,
                        std::span<const AxisLimits> limits, const WholeFrames& part);

}  // namespace inbetween
