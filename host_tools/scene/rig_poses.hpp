// The axes of a rig whose tip goes where a scene has a node.
#pragma once

#include "host_tools/exchange/baked_table.hpp"
#include "host_tools/joints/kinematics.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "host_tools/scene/scene_poses.hpp"

namespace inbetween {

/// A column for every axis that moves the tip, in its unit in the rig; on every row the tip is at the pose,
/// with its rotation, within 1e-9 m and 1e-9 rad. The first row has the solution nearest to the middle of
/// the ranges and inside them if there is one, each other one that nearest to the row before, so that no axis
/// jumps to another one. Rows outside a range are not refused here (rows_move_of does, with all of them).
/// Throws InputError at the first row that the tip cannot have, with its frame and how near the rig comes,
/// and where nothing moves the tip. O(rows * axes^3).
BakedTable axes_of_poses(const RigFile& rig, const Kinematics& kinematics, const Tip& tip,
                         const SceneFile& scene, const SceneRows& rows);

/// How far the tip of a rig is from a pose.
struct PoseMiss {
  double place_m = 0;
  double turn_rad = 0;
};
PoseMiss miss_of(const Pose& found, const Pose& wanted);

}  // namespace inbetween
