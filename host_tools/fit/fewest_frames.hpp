// How many frames a move needs at least on its rig, whatever its speed curves.
#pragma once

#include <cstddef>
#include <cstdint>

#include "host_tools/plan/plan.hpp"

namespace inbetween {

struct FewestFrames {
  std::int32_t frames = 1;
  std::size_t axis =
      0;  ///< of the rig: the one in the way (by velocity: the one that is so for most of the time)
  bool by_acceleration = false;
};

/// The plan has a rig. In fewer frames no speed curve fits, with whatever number of control values: no motion
/// that passes along the whole path of every track without going back and breaks no limit that check()
/// judges. Proven, but not sharp: from max_velocity and max_acceleration alone.
///
/// Velocity: every stretch of the path takes at least |way of an axis| / max_velocity of it, for the axis for
/// which that is most. Acceleration: where an axis turns round it stands still, because no step of a velocity
/// is allowed; so does every axis at an end of the move at which the drawn curve rests (an end that is passed
/// at a speed may be reached by a roll). Between two such places it takes at least the time of the quickest
/// motion from rest to rest over the way between them: full acceleration, full velocity, full deceleration;
/// the sum of these is taken for every axis. Holds count for nothing. All sums are rounded down.
///
/// Cost: 64 points per segment and axis.
FewestFrames fewest_frames(const Plan& plan);

}  // namespace inbetween
