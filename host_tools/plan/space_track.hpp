// Tracks whose distance is that of a tip of the rig in space: the axes follow keys in the world, or the tip
// follows keys of the axes.
#pragma once

#include <span>
#include <vector>

#include "host_tools/files/move_file.hpp"
#include "host_tools/files/rig_file.hpp"
#include "host_tools/joints/kinematics.hpp"
#include "host_tools/plan/followed_path.hpp"
#include "inbetween/timing/track.hpp"

namespace inbetween {

/// Makes a point of every link at which a track looks (MoveSpace::fixed_aim), so that a second time changes
/// nothing. Throws InputError where the rig has no such tip or link, or where the link moves: `held` has, for
/// each axis of the rig, its position if the move says that it stays there.
void settle_aims(MoveFile& move, const Kinematics* kinematics, std::span<const std::optional<double>> held);

/// Of the rows of a drawn path in space: the coordinates of the keys, then those of a fixed aim.
std::vector<double> space_row(const MoveSpace& space, const MoveKey& key);
/// What of them is the distance: the way of the link, or of the point at which it looks where only that is
/// drawn.
std::vector<double> space_weights(const MoveSpace& space);

/// The axes of a track whose keys are in the world. `drawn` is the track through them. Throws InputError at
/// the key before the place with frame, distance along the path and axis: out of reach, beyond the range of
/// an axis, a singular place, a place where the solution would have to jump.
FollowedPath axes_in_space(const MoveTrack& track, const Track<double>& drawn, const Kinematics& kinematics,
                           const RigFile& rig);

/// The way of a tip along a path of axes.
FollowedPath tip_of_axes(const MoveTrack& track, const Path<double>& drawn, const Kinematics& kinematics,
                         const RigFile& rig);

}  // namespace inbetween
