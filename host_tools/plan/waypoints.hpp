// The places along a path that timing knows: its keys, and where it turns back between them.
#pragma once

#include <cstdint>
#include <vector>

#include "inbetween/timing/track.hpp"

namespace inbetween {

struct Waypoint {
  double distance = 0;       ///< along the path
  std::int32_t key = 0;      ///< the key, or the key before it
  std::int32_t segment = 0;  ///< of the path, that begins at the key, or in which it is
  bool is_key = true;
  bool is_corner = false;  ///< the direction of the path changes at once: a corner, or the path back
};

/// In order of distance, from the first key to the end of the path. Keys in one place are corners together or
/// not at all. The seam of a closed path may be a corner as well. `track` has a speed curve, whichever.
std::vector<Waypoint> waypoints_of(const Track& track);

}  // namespace inbetween
