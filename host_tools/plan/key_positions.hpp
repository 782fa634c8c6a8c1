// The positions of keys as the core takes them: in the units of the rig, and going on over whole turns.
#pragma once

#include <cstddef>
#include <optional>

#include "host_tools/move_model/move_file.hpp"
#include "host_tools/rig_model/rig_file.hpp"

namespace inbetween {

/// The unit in which an axis of a track counts without a rig: that of the first key that gives it one.
std::optional<AxisUnit> unit_without_rig(const MoveTrack& track, std::size_t axis);

/// Converts every key to the units of the rig, or without one of unit_without_rig, and takes every axis with
/// a wrap the way round that its keys say: positions go on, by multiples of the wrap. A closed path returns
/// to its first key by the `way` of that key; MoveTrack::lap tells how far beyond it. Units, wraps and ways
/// are done then, so that a second time changes nothing. The same of the drawn curves of a network, and a key
/// that leaves out a drawn axis gets its position from there.
///
/// Throws InputError at the key: a length for an angle or the reverse; without a rig, keys of one axis with
/// and without a unit; a direction that is not within one turn; half a turn without a way.
void settle_positions(MoveFile& move, const std::optional<RigFile>& rig);

}  // namespace inbetween
