// Axes that follow a link over time: it keeps looking at another one while a track moves that one, or it is
// drawn over time.
//
// Where the link is drawn follows from the place on its path, and where it looks from the time, also while
// the path is at rest. So the axes are a path over time: solved at even steps of it, with cubics between
// them.
#pragma once

#include <cstdint>
#include <vector>

#include "host_tools/plan/link_in_time.hpp"

namespace inbetween {

/// A path of the axes whose parameter is time between the frames of the keys.
struct TrackedPath {
  FollowedPath path;
  std::vector<std::int32_t> key_frames;  // the whole frame that is nearest to each key
  std::int32_t steps_per_frame = 0;
};

/// The fewest with which a frame has a step inside: what only its frames show would bend between them.
inline constexpr std::int32_t min_steps_per_frame = 2;

/// `drawn` is the track through the keys, `aim` the path of the link that is looked at, or null. The steps
/// are `first_steps_per_frame`, and twice as many until the bounds are small. Refuses, besides what
/// AxesInSpace refuses: motion that steps between the ends of the move, axes that are left free, two keys
/// nearest to one frame, a path whose bounds do not become small enough.
///
/// The bounds are proven: between two steps the drawn place is within J h^3 / 4 of the cubic that has its
/// places and velocities at both, and its velocity within J h^2 / 4 (J bounds its third derivative by time, h
/// is the step); the same holds for the point that is looked at; tip_deviation bounds the rest.
TrackedPath tracked_path(const MoveTrack& track, const Track& drawn, LinkInTime* aim,
                         const Kinematics& kinematics, const RigFile& rig,
                         std::int32_t first_steps_per_frame = min_steps_per_frame);

}  // namespace inbetween
