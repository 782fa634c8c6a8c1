// Networks whose row is of points in space: each point is the place of a tip, and the joints follow.
#pragma once

#include "host_tools/joints/kinematics.hpp"
#include "host_tools/move_model/move_file.hpp"
#include "host_tools/plan/solved_track.hpp"
#include "host_tools/plan/tracked_aim.hpp"
#include "host_tools/rig_model/rig_file.hpp"

namespace inbetween {

/// The axes of a track whose row is of points in space, with the keys, frames and rests of `spec`: x, y and z
/// of them are three networks (network.hpp), and of every point the axes that move it are solved over time.
/// Throws what network_of() and tracked_path() throw, and InputError where an axis moves two points or none.
TrackedPath axes_of_points(const MoveTrack& track, const TrackSpec& spec, const Kinematics& kinematics,
                           const RigFile& rig);

}  // namespace inbetween
