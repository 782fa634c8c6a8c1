// Tracks whose distance is that of a tip of the rig in space: the axes follow keys in the world, or the tip
// follows keys of the axes.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "host_tools/joints/kinematics.hpp"
#include "host_tools/move_model/move_file.hpp"
#include "host_tools/plan/followed_path.hpp"
#include "host_tools/plan/tracked_aim.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "inbetween/timing/track.hpp"

namespace inbetween {

/// What a move says of an axis of the rig.
struct AxisInMove {
  std::optional<std::size_t> track;  // that moves it, or says where it stays
  std::optional<double> held;        // it stays there
};

/// The link at which a track looks (MoveSpace::aim_node). Throws InputError where the rig has none of that
/// name.
std::int32_t link_of(const MoveSpace& space, const Kinematics& kinematics);

/// Makes a point (MoveSpace::fixed_aim) of every link at which a track looks, if it stays where it is, so
/// that a second time changes nothing. MoveSpace::aim_node remains where another track moves the link. Throws
/// InputError where the rig has no such tip or link, or where what moves the link is in no track, in the same
/// track, or in one that itself looks at a link that moves.
void settle_aims(MoveFile& move, const Kinematics* kinematics, std::span<const AxisInMove> axes);

/// Of the rows of a drawn path in space: the coordinates of the keys, then those of a fixed aim.
std::vector<double> space_row(const MoveSpace& space, const MoveKey& key);
/// What of them is the distance: the path of the link, or of the point at which it looks where only that is
/// drawn.
std::vector<double> space_weights(const MoveSpace& space);

/// The axes of a track whose keys are in the world. `drawn` is the track through them. Throws InputError at
/// the key before the place with frame, distance along the path and axis: out of reach, beyond the range of
/// an axis, a singular place, a place where the solution would have to jump.
FollowedPath axes_in_space(const MoveTrack& track, const Track& drawn, const Kinematics& kinematics,
                           const RigFile& rig);

/// The same of a track that looks at a link while other tracks move it: MoveSpace::aim_node is there.
/// `driven` says by which solved track each axis of the rig moves.
TrackedPath axes_looking_at(const MoveTrack& track, const Track& drawn, const Kinematics& kinematics,
                            const RigFile& rig, std::vector<DrivenCoordinate> driven);

/// The path of a tip along a path of axes.
FollowedPath tip_of_axes(const MoveTrack& track, const Path& drawn, const Kinematics& kinematics,
                         const RigFile& rig);

}  // namespace inbetween
