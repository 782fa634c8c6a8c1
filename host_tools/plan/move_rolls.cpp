#include "host_tools/plan/move_rolls.hpp"

#include <optional>

#include "host_tools/plan/solved_track.hpp"

namespace inbetween {
AxisLimits limits_of(const RigAxis& axis) {
  return value_or_throw(AxisLimits::make({.min = axis.min,
                                          .max = axis.max,
                                          .max_velocity = axis.max_velocity,
                                          .max_acceleration = axis.max_acceleration,
                                          .max_jerk = axis.max_jerk,
                                          .max_acceleration_step = axis.max_acceleration_step,
                                          .stop_acceleration = axis.stop_acceleration,
                                          .stop_jerk = axis.stop_jerk}));
}

PlannedRolls plan_rolls(std::span<const Track> tracks, std::span<const Trajectory> trajectories,
                        std::span<const AxisLimits> limits, const WholeFrames& part) {
  std::vector<AxisMotion> joints(limits.size());
  PlannedRolls planned{.before = std::vector<RollAxis>(limits.size()),
                       .after = std::vector<RollAxis>(limits.size()),
                       .obstacles = {}};
  const JoinedRolls joined =
      value_or_throw(join_rolls(tracks, trajectories, limits, part, {joints, planned.before, planned.after}));
  if (joined.rolls.before.empty()) planned.before.clear();
  if (joined.rolls.after.empty()) planned.after.clear();
  for (const std::optional<RollObstacle>& obstacle : joined.obstacles) {
    if (obstacle) planned.obstacles.push_back(*obstacle);
  }
  return planned;
}

}  // namespace inbetween
