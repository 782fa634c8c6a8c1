// Where the speed shall touch 0 at eased keys that have no frame of their own.
#pragma once

#include <optional>

#include "host_tools/fit/fitted_track.hpp"

namespace inbetween {

/// The track with a speed curve that shares out the frames between its eased keys as the limits need them:
/// each stretch between two keys where it rests gets frames in proportion to the time that its slowest axis
/// takes from rest to rest, with the speed of the smoothest such motion (Flash and Hogan 1985, minimum jerk).
/// Keys with a frame or a hold keep their frames. Nothing if every eased key has a frame, or if the keys have
/// no such curve.
///
/// The drawn curve says only roughly when such a key is met: it does not slow down there.
std::optional<Plan> with_eases_shared_out(const FittedTrack& fitted);

}  // namespace inbetween
