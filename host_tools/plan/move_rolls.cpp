#include "host_tools/plan/move_rolls.hpp"

#include <array>
#include <utility>

#include "host_tools/plan/solved_track.hpp"

namespace inbetween {
AxisLimits<double> limits_of(const RigAxis& axis) {
  return value_or_throw(AxisLimits<double>::make({.min = axis.min,
                                                  .max = axis.max,
                                                  .max_velocity = axis.max_velocity,
                                                  .max_acceleration = axis.max_acceleration,
                                                  .max_jerk = axis.max_jerk,
                                                  .max_acceleration_step = axis.max_acceleration_step,
                                                  .stop_acceleration = axis.stop_acceleration,
                                                  .stop_jerk = axis.stop_jerk}));
}

PlannedRolls plan_rolls(std::span<const Track<double>> tracks, std::span<const Trajectory> trajectories,
                        std::span<const AxisLimits<double>> limits, const WholeFrames& part) {
  PlannedRolls rolls;
  std::vector<AxisMotion<double>> joints(limits.size());
  for (const auto& [end, axes] :
       {std::pair(RollEnd::before, &rolls.before), std::pair(RollEnd::after, &rolls.after)}) {
    if (!joints_of_part(tracks, trajectories, part, end, joints)) continue;
    const RollRequest<double> request{.end = end,
                                      .joint_frame = end == RollEnd::before ? part.first : part.last,
                                      .fps = tracks.front().frame_rate(),
                                      .joints = joints,
                                      .limits = limits};
    if (const auto obstacle = value_or_throw(roll_obstacle(request))) {
      const double position = joints[static_cast<std::size_t>(obstacle->axis)].position;
      rolls.obstacles.push_back({end, *obstacle, position});
      continue;
    }
    const RollSpan span{end, request.joint_frame, value_or_throw(roll_frames(request)), request.fps};
    for (const AxisMotion<double>& joint : joints) {
      axes->push_back(value_or_throw(RollAxis<double>::make(span, joint)));
    }
  }
  return rolls;
}

}  // namespace inbetween
