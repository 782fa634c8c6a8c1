// The speed curve of a track as the author means it: through its values if he says so, and eased at its ends.
#pragma once

#include <cstdint>
#include <vector>

#include "host_tools/move_model/move_file.hpp"
#include "inbetween/timing/speed_profile.hpp"

namespace inbetween {

/// Control values 0..100 of a track with a drawn speed, in a move of so many frames: those of the file, or
/// with `through` those of the curve that passes through them, with the ends of the track; then brought from
/// rest within ease_in frames and to rest within ease_out, or within one drawn span at an end that rests
/// without saying how long. Between the two the curve is as drawn, exactly. It is given twice as many values,
/// which does not change it, as often as the requests need, up to max_lock_values.
///
/// Throws InputError at the request where the curve through the values goes below 0, or where an end takes
/// fewer frames than a curve of so many values can show.
std::vector<double> drawn_curve(const MoveTrack& track, std::int32_t frames);

/// A periodic track has no ends: its last control value is its first.
CurveEnds ends_of(const MoveTrack& track);

}  // namespace inbetween
