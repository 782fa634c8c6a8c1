// A rig file for the robot of a URDF file, to be simulated until real drives are written into it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/joints/urdf_file.hpp"
#include "host_tools/rig_model/move_unit.hpp"

namespace inbetween {

/// What a URDF file does not say.
struct UrdfRigChoices {
  std::int32_t rate_hz = 0;
  /// The time in which an axis comes from rest to max_velocity: its acceleration. Left open without one.
  std::optional<double> reach_s = {};
  MoveUnit angle = MoveUnit::deg;        // or rad, turn
  MoveUnit length = MoveUnit::mm;        // or m
  std::vector<std::string> joints = {};  // those that are axes; empty: all that move
};

struct UrdfRig {
  std::string text;
  std::vector<std::string> axes = {};
  std::vector<std::string> held = {};  // joints that move and are no axis
  std::vector<std::string> open = {};  // "shoulder: max_acceleration", to be filled in before it is a rig
  std::vector<std::string> tips = {};
};

/// Each joint that moves and mimics no other is an axis of its name; fixed ones and those that mimic are
/// none. Limits are those of <limit>, rounded inward in their last decimal. What is not there is a comment
/// with a question mark, so that the rig is refused until somebody has answered it: a range that has no room
/// or no end, a velocity of 0, accelerations without `reach_s`. The drive of each axis is a pipe that goes
/// nowhere and without `no_watchdog`: it is accepted with --sim only. Tips are the links at the ends that an
/// axis moves, `max_rig_tips` at most; the others are a comment. `urdf` is the path of the file from the
/// folder of the rig. Throws InputError at the joint where a name has a blank, which a pipe cannot name, a
/// joint that is named is none that may be an axis, or more than max_rig_axes are axes. O(joints^2) at worst.
UrdfRig rig_of_urdf(const UrdfFile& file, const std::string& urdf, const UrdfRigChoices& choices);

}  // namespace inbetween
