// Reads what makes a track a network: network, places, drawn, and the CSV files that `drawn` names.
#pragma once

#include <cstdint>

#include "host_tools/move_model/move_file.hpp"
#include "host_tools/text/toml_value.hpp"

namespace inbetween {

/// Points of a drawn curve.
inline constexpr std::size_t max_drawn_points = max_keys;

/// The fields of a track in a move of so many frames. Axes, spline, timing, kinetic, units and wraps are
/// read. A CSV file is beside the move file. Throws InputError at a field that a network cannot have, and at
/// the field, or the line of the CSV file, that is no curve over the frames of the move.
void read_network(const TomlTable& table, std::int32_t frames, MoveTrack& track);

/// Every key has a frame, the first 0, the last that of the move, each later than the one before. Throws
/// InputError at the key.
void check_network_keys(const MoveTrack& track, std::int32_t frames);

}  // namespace inbetween
