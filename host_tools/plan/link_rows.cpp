#include "host_tools/plan/link_rows.hpp"

#include <fmt/format.h>

#include <cstddef>

namespace inbetween {
namespace {

void refuse_unplaced(const Plan& plan, const Status& placed) {
  if (placed) return;
  const auto axis = static_cast<std::size_t>(placed.error().axis);
  throw InputError(plan.place_of(axis), fmt::format("axis {}: {}; {}", in_quotes(plan.axes()[axis].name),
                                                    placed.error().what, placed.error().remedy));
}

}  // namespace

LinkRows::LinkRows(const Plan& plan, PlanRows rows)
    : plan_(plan),
      line_(plan, rows),
      columns_(plan.axes().size()),
      coordinates_(plan.axes().size()),
      links_(plan.kinematics()->links().size()) {
  for (std::size_t a = 0; a < columns_.size(); ++a) {
    if (plan.axes()[a].track) columns_[a].emplace(plan, plan.axes()[a], rows);
  }
}

const std::vector<LinkMotion>& LinkRows::at(std::int64_t row) {
  if (row_ == row) return links_;
  for (std::size_t a = 0; a < columns_.size(); ++a) {
    if (!columns_[a]) continue;
    const AxisMotion motion = columns_[a]->motion(row);
    coordinates_[a] = {columns_[a]->position(row), motion.velocity, motion.acceleration};
  }
  refuse_unplaced(plan_, plan_.kinematics()->tree().motion(coordinates_, links_));
  row_ = row;
  return links_;
}

std::vector<Pose> link_poses(const Plan& plan, const FrameTime& when) {
  std::vector<double> coordinates(plan.axes().size());
  for (std::size_t a = 0; a < coordinates.size(); ++a) {
    const PlanAxis& axis = plan.axes()[a];
    if (!axis.track) continue;
    coordinates[a] = plan.motion().trajectories()[*axis.track].motion_of(axis.track_axis, when).position;
  }
  std::vector<Pose> poses(plan.kinematics()->links().size());
  refuse_unplaced(plan, plan.kinematics()->tree().poses(coordinates, poses));
  return poses;
}

}  // namespace inbetween
