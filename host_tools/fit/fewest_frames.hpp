// The number of frames that a move needs at least on its rig, whatever its speed curves are.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

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
/// Each axis takes its time for a stretch of the path, and the slowest axis counts. Its velocity is
/// max_velocity at most, and no more than max_acceleration gives it on the path from where it was at rest
/// last, and takes from it on the path to where it is at rest next: v^2 <= 2 a w. An axis is at rest where it
/// turns round, because a step of the velocity is not allowed. Every axis is at an end of the move where the
/// drawn curve rests; an end that is passed at a speed may be reached by a roll. Holds add nothing. All sums
/// are rounded down.
///
/// Cost: 64 points per segment and axis.
FewestFrames fewest_frames(const Plan& plan);

/// A frame on which the move has to be at a place of its path, from which it goes on `hold` frames later.
struct Meeting {
  std::int32_t key = 0;
  std::int32_t frame = 0;
  std::int32_t hold = 0;
  bool rests = false;
};

/// The keys of a track that have a frame, and its ends. The track has locked keys.
std::vector<Meeting> meetings_of(const Plan& plan, std::size_t track);

/// The stretch between two neighbouring keys with a frame, or such a key and an end of the move, that needs
/// more frames than there are.
struct ShortStretch {
  std::int32_t begin_key = 0;
  std::int32_t end_key = 0;
  std::int32_t begin_frame = 0;  ///< behind its hold
  std::int32_t end_frame = 0;
  double needed = 0;     ///< frames, at least
  std::size_t axis = 0;  ///< as of FewestFrames
  bool by_acceleration = false;
};

/// The stretch of a track that misses the largest share of its frames: as long as it is met on these frames,
/// no speed curve fits. Proven as fewest_frames() is, from one lock to the next; the motion rests at a hold
/// and at a key that eases. Nothing where no stretch is too short, which proves nothing. The plan has a rig.
std::optional<ShortStretch> shortest_stretch(const Plan& plan, std::size_t track);

/// The shortest time, in seconds, for a distance from rest, or to rest.
double seconds_from_rest(double distance, const RigAxis& limits);

}  // namespace inbetween
