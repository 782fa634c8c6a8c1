// The network of a track: its drawn curves, its keys, and what is wrong with them in the words of its file.
#pragma once

#include "host_tools/move_model/move_file.hpp"
#include "host_tools/plan/network.hpp"
#include "host_tools/plan/solved_track.hpp"

namespace inbetween {

/// Gives the keys that leave out a drawn axis the position that the curve has on their frame. Positions are
/// in the units of the rig. A second time changes nothing. Throws InputError at the point of a curve that
/// cannot be.
void settle_left_out(MoveTrack& track);

/// The path of a network, with the keys, frames and rests of `spec`. Throws SolverError for the keys;
/// InputError at a key that is not on the drawn curve of its axis, at the point of a curve that cannot be,
/// and at the network where it has more than max_network_segments segments.
NetworkPath network_of(const MoveTrack& track, const TrackSpec& spec);

}  // namespace inbetween
