#include "host_tools/scene/axis_rows.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "inbetween/trajectory/bounds.hpp"

namespace inbetween {
namespace {

/// |f - line| <= h^2/8 max|f''| (the error of linear interpolation); a velocity that steps by J inside adds a
/// roof of h/4 J at most.
double off_a_line(double seconds, double acceleration, double velocity_steps) {
  return seconds * seconds / 8 * acceleration + seconds / 4 * velocity_steps;
}

/// The sizes of the steps of velocity of every axis inside a stretch, one after another.
std::vector<double> velocity_steps(const Trajectory& trajectory, const FrameTime& from, const FrameTime& to) {
  std::vector<double> sums(trajectory.axis_count(), 0);
  std::vector<TrajectoryStep> steps(trajectory.axis_count());
  for (const TrajectoryBreak& at : trajectory.breaks()) {
    if (at.time <= from || to <= at.time || at.time == trajectory.begin()) continue;
    steps_at(trajectory, at, steps);
    for (std::size_t a = 0; a < sums.size(); ++a) sums[a] += std::fabs(steps[a].velocity);
  }
  return sums;
}

/// Of every axis of a trajectory between two rows, added to `off`, which begins with the first of them.
void take_offs(const Trajectory& trajectory, const FrameTime& from, const FrameTime& to, double seconds,
               std::span<std::vector<double>> off) {
  const FrameTime begin = std::max(from, trajectory.begin(), std::less<>());
  const FrameTime end = std::min(to, trajectory.end(), std::less<>());
  if (!(begin < end)) {
    for (std::vector<double>& of_axis : off) of_axis.push_back(0);
    return;
  }
  std::vector<AxisPeaks> peaks(trajectory.axis_count());
  bound_trajectory(trajectory, begin, end, peaks);
  const std::vector<double> steps = velocity_steps(trajectory, begin, end);
  for (std::size_t a = 0; a < peaks.size(); ++a) {
    double most = off_a_line(seconds, peaks[a].acceleration.value, steps[a]);
    // Behind its end it rests: a kink of the velocity with which it arrives.
    if (end < to) most += seconds / 4 * peaks[a].velocity.value;
    off[a].push_back(most);
  }
}

}  // namespace

AxisRows rows_of_plan(const Plan& plan, const PlanTableOptions& options) {
  if (options.has_rolls) {
    throw InputError({plan.move().name},
                     "a scene has the frames of the move; leave out the pre-roll and the post-roll");
  }
  BakedTable table = table_of_plan(plan, options);
  AxisRows result{.name = plan.move().name,
                  .fps = *table.fps,
                  .first_frame = table.first_frame.value_or(0),
                  .rows = table.rows(),
                  .axes = {}};
  const PlayedMotion& motion = plan.motion();
  std::vector<std::vector<double>> off(motion.axis_count());
  const double seconds = 1 / result.fps.frames_per_second();
  for (std::size_t row = 0; row + 1 < result.rows; ++row) {
    const FrameTime from = time_of_plan_row(plan, options, static_cast<std::int64_t>(row));
    const FrameTime to = time_of_plan_row(plan, options, static_cast<std::int64_t>(row) + 1);
    std::size_t axis = 0;
    for (const Trajectory& trajectory : motion.trajectories()) {
      take_offs(trajectory, from, to, seconds, std::span(off).subspan(axis, trajectory.axis_count()));
      axis += trajectory.axis_count();
    }
  }
  for (const PlanAxis& axis : plan.axes()) {
    if (!axis.track) continue;
    BakedColumn& column = table.columns[result.axes.size()];
    result.axes.push_back(
        {.name = axis.name, .positions = std::move(column.values), .off = std::move(off[axis.move_axis])});
  }
  return result;
}

}  // namespace inbetween
