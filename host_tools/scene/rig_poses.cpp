#include "host_tools/scene/rig_poses.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "host_tools/joints/tip_solver.hpp"
#include "host_tools/scene/pose_descent.hpp"

namespace inbetween {
namespace {

/// A level y axis and the roll from there: what TipTarget::roll is.
double roll_of(const Rotation3& tip) {
  const double flat = std::hypot(tip.x.x, tip.x.y);
  // Straight up or down there is no level: y itself is taken for it.
  if (flat == 0) return 0;
  const Vector3 level{-tip.x.y / flat, tip.x.x / flat, 0};
  return std::atan2(dot(tip.y, cross(tip.x, level)), dot(tip.y, level));
}

TipTarget target_of(const Pose& pose) {
  constexpr double ahead_m = 1;
  return {.position = pose.position,
          .aim = pose.position + pose.rotation.x * ahead_m,
          .roll = roll_of(pose.rotation)};
}

std::vector<std::size_t> axes_that_move(const RigFile& rig, const Kinematics& kinematics, const Tip& tip) {
  std::vector<std::size_t> axes;
  for (std::size_t a = 0; a < rig.axes.size(); ++a)
    if (kinematics.tree().moves(static_cast<std::int32_t>(a), tip.link)) axes.push_back(a);
  if (axes.empty())
    throw InputError({rig.path}, fmt::format("no axis moves {}; name another tip with --tip", tip.name));
  return axes;
}

}  // namespace

PoseMiss miss_of(const Pose& found, const Pose& wanted) {
  const Vector3 apart = found.position - wanted.position;
  return {std::hypot(apart.x, apart.y, apart.z), rotation_angle(found.rotation, wanted.rotation)};
}

BakedTable axes_of_poses(const RigFile& rig, const Kinematics& kinematics, const Tip& tip,
                         const SceneFile& scene, const SceneRows& rows) {
  const std::vector<std::size_t> axes = axes_that_move(rig, kinematics, tip);
  BakedTable table{.file = scene.file};
  table.fps = rows.fps;
  table.first_frame = rows.first_frame;
  table.has_exposures = false;
  table.warnings = scene.warnings;
  std::vector<TipAxis> sought;
  for (const std::size_t a : axes) {
    const RigAxis& axis = rig.axes[a];
    table.columns.push_back({.name = axis.name, .unit = as_move_unit(axis.unit)});
    sought.push_back({.axis = a, .min = axis.min, .max = axis.max, .near = axis.min / 2 + axis.max / 2});
  }
  const TipSolver solver(kinematics, tip.link, sought);
  PoseDescent descent(kinematics, tip.link, axes);
  std::vector<double> positions;
  constexpr double max_m = 1e-9, max_rad = 1e-9;  // far below what a rig can do
  const auto is_there = [&](const PoseMiss& miss) {
    return miss.place_m <= max_m && miss.turn_rad <= max_rad;
  };
  for (std::size_t row = 0; row < rows.poses.size(); ++row) {
    const Pose& wanted = rows.poses[row];
    if (row == 0) positions = solver.solve_from_ranges(target_of(wanted)).positions;
    std::vector<double> found = positions;
    descent.descend(wanted, found);
    PoseMiss miss = miss_of(descent.pose(found), wanted);
    if (!is_there(miss) && row > 0) {  // the solver knows other ways there
      found = solver.solve(target_of(wanted), positions).positions;
      descent.descend(wanted, found);
      miss = miss_of(descent.pose(found), wanted);
    }
    positions = std::move(found);
    if (!is_there(miss)) {
      throw InputError(
          {scene.file},
          fmt::format("on frame {} the rig comes no nearer to the scene than {:.3g} mm and {:.3g} "
                      "degrees; put the scene elsewhere with --place, --turn and --scale, or map "
                      "single columns with --axis",
                      rows.first_frame + static_cast<std::int64_t>(row), miss.place_m * 1000,
                      miss.turn_rad * 180 / std::numbers::pi));
    }
    for (std::size_t i = 0; i < axes.size(); ++i) table.columns[i].values.push_back(positions[i]);
  }
  check_table(table);
  return table;
}

}  // namespace inbetween
