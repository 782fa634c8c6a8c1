// A rig as a scene: every link of its URDF file is a node in its parent, and its joint moves it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host_tools/joints/kinematics.hpp"
#include "host_tools/scene/animated_scene.hpp"
#include "host_tools/scene/axis_rows.hpp"

namespace inbetween {

/// The tip that carries the camera: the one that is named, that of the lens, or the only one. Throws
/// InputError, which lists them, where none is named and there are several.
const Tip& camera_tip(const RigFile& rig, const Kinematics& kinematics,
                      const std::optional<std::string>& named);

struct RigScene {
  AnimatedScene scene;
  std::vector<std::string> told;  ///< axes that are in no track, and where their joints are
};

/// The camera is a node under `tip`, which looks along its x axis with z up; the lens is that of the rig, if
/// it is at this tip. Positions are exact up to the rounding of double on every row. Between two rows slerp
/// turns a joint as a straight line of its angle does, so that all that is off is AxisRow::off, times the
/// lever arm of each joint: AnimatedScene::between is the largest sum. Throws InputError where an axis that
/// moves the tip is in no track, and where a joint turns half a turn or more between two rows, which slerp
/// would turn the other way. O(rows * links).
RigScene scene_of_rig(const RigFile& rig, const Kinematics& kinematics, const Tip& tip, const AxisRows& rows);

}  // namespace inbetween
