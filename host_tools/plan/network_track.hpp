// The network of a track: its drawn curves, its keys, and what is wrong with them in the words of its file.
#pragma once

#include "host_tools/joints/kinematics.hpp"
#include "host_tools/move_model/move_file.hpp"
#include "host_tools/plan/network.hpp"
#include "host_tools/plan/solved_track.hpp"
#include "host_tools/plan/tracked_aim.hpp"
#include "host_tools/rig_model/rig_file.hpp"

namespace inbetween {

/// Gives the keys that leave out a drawn axis the position that the curve has on their frame. Positions are
/// in the units of the rig. A second time changes nothing. Throws InputError at the point of a curve that
/// cannot be.
void settle_left_out(MoveTrack& track);

/// The path of a network, with the keys, frames and rests of `spec`. Throws SolverError for the keys;
/// InputError at a key that is not on the drawn curve of its axis, at the point of a curve that cannot be,
/// and at the network where it has more than max_network_segments segments.
CubicsOverFrames network_of(const MoveTrack& track, const TrackSpec& spec);

/// The axes of a track whose row is of points in space, with the keys, frames and rests of `spec`: x, y and z
/// of them are three networks (network.hpp), and of every point the axes that move it are solved over time.
/// Throws what network_of() and tracked_path() throw, and InputError where an axis moves two points or none.
TrackedPath axes_of_points(const MoveTrack& track, const TrackSpec& spec, const Kinematics& kinematics,
                           const RigFile& rig);

}  // namespace inbetween
