// The number of frames that a move needs at least on its rig, whatever its speed curves are.
#pragma once

#include <cstddef>
#include <cstdint>

#include "host_tools/plan/plan.hpp"

namespace inbetween {

struct FewestFrames {
  std::int32_t frames = 1;
  std::size_t axis = 0;  ///< the axis of the rig that needs the time; by velocity, the one that needs it for
                         ///< the longest part
  bool by_acceleration = false;
};

/// The plan has a rig. No speed curve fits in fewer frames, however many control values it has: every motion
/// that passes the whole path of every track without going back would break a limit that check() judges. This
/// is proven, but it is not sharp: it uses max_velocity and max_acceleration only.
///
/// Velocity: each axis takes at least |way| / max_velocity for a stretch of the path, and the slowest axis
/// counts. Acceleration: an axis stands still where it turns round, because a step of the velocity is not
/// allowed. Every axis stands still at an end of the move where the drawn curve rests; an end that is passed
/// at a speed may be reached by a roll. The way between two such places takes at least the time of the
/// quickest motion from rest to rest: full acceleration, full velocity, full deceleration. These times are
/// added up for every axis. Holds add nothing. All sums are rounded down.
///
/// Cost: 64 points per segment and axis.
FewestFrames fewest_frames(const Plan& plan);

/// The shortest time, in seconds, for a distance of which `ends_at_rest` ends (0 to 2) are at rest.
double quickest(double distance, const RigAxis& limits, int ends_at_rest);

}  // namespace inbetween
