// Neighbouring keys between which a path turns on the spot, because they are far nearer to each other than to
// the next.
#pragma once

#include <cstddef>
#include <vector>

#include "host_tools/move_model/move_file.hpp"

namespace inbetween {

/// Two neighbouring keys that are nearly in one place.
struct NearKeys {
  std::size_t first = 0;    ///< the key before the segment between them
  double distance = 0;      ///< as the track counts it: weighted; of keys in the world in metres
  double times_nearer = 0;  ///< than the nearer of their other neighbours
};

/// Keys so many times nearer to each other than to their neighbours are named: between them a path turns on
/// the spot, and 0.1 mm asked for 19 535 frames. Cure.KeysThatAreNearlyInOnePlaceAreNamedWithTheirDistance.
inline constexpr double min_times_nearer = 50;

/// All such keys of a track whose path goes by distance and is not straight between keys, in their order. The
/// positions are settled. Keys in one place are none of them: the path passes both at once.
std::vector<NearKeys> near_keys(const MoveTrack& track);

}  // namespace inbetween
