#include "host_tools/scene/rig_poses.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "host_tools/joints/tip_solver.hpp"

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

/// Where the axes put the link that is sought, with all others at 0, which do not move it.
Pose pose_of(const Kinematics& kinematics, const Tip& tip, std::span<const std::size_t> axes,
             const std::vector<double>& positions) {
  std::vector<double> coordinates(kinematics.tree().coordinate_count(), 0);
  for (std::size_t i = 0; i < axes.size(); ++i) coordinates[axes[i]] = positions[i];
  std::vector<Pose> poses(kinematics.tree().joints().size());
  if (!kinematics.tree().poses(coordinates, poses)) return {};
  return poses[static_cast<std::size_t>(tip.link)];
}

}  // namespace

PoseMiss miss_of(const Pose& found, const Pose& wanted) {
  const Vector3 apart = found.position - wanted.position;
  return {std::hypot(apart.x, apart.y, apart.z), angle_between(found.rotation, wanted.rotation)};
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
  std::vector<double> positions;
  // The solver stops at max_miss; where it is weaker this is still far below what a rig can do.
  constexpr double max_m = 1e-9, max_rad = 1e-9;
  for (std::size_t row = 0; row < rows.poses.size(); ++row) {
    const TipTarget target = target_of(rows.poses[row]);
    TipSolution solution = row == 0 ? solver.solve_from_ranges(target) : solver.solve(target, positions);
    const PoseMiss miss = miss_of(pose_of(kinematics, tip, axes, solution.positions), rows.poses[row]);
    if (miss.place_m > max_m || miss.turn_rad > max_rad) {
      throw InputError(
          {scene.file},
          fmt::format("on frame {} the rig comes no nearer to the scene than {:.3g} mm and {:.3g} "
                      "degrees; put the scene elsewhere with --place, --turn and --scale, or map "
                      "single columns with --axis",
                      rows.first_frame + static_cast<std::int64_t>(row), miss.place_m * 1000,
                      miss.turn_rad * 180 / std::numbers::pi));
    }
    positions = std::move(solution.positions);
    for (std::size_t i = 0; i < axes.size(); ++i) table.columns[i].values.push_back(positions[i]);
  }
  check_table(table);
  return table;
}

}  // namespace inbetween
