// When a place of a path is passed.
#pragma once

#include "inbetween/timing/track.hpp"

namespace inbetween {

/// The frame at which a distance is reached, between whole frames. `track` has a speed curve, which is
/// searched by bisection.
double frame_of_distance(const Track& track, const TwoSum& distance);

/// The frame at which a place of the path is passed, whatever times the track.
double frame_of_place(const Track& track, const PathPoint& place);

}  // namespace inbetween
