// Reads the keys of a track.
#pragma once

#include <cstdint>
#include <vector>

#include "host_tools/files/move_file.hpp"
#include "host_tools/files/toml_value.hpp"

namespace inbetween {

/// Reads `unit` and `wrap` of a track, whose axes are known.
void read_counting(const TomlTable& table, MoveTrack& track);

/// Reads the keys of a track, of which axes, spline, units and wraps are known, in a move of so many frames.
void read_keys(const TomlTable& table, std::int32_t frames, MoveTrack& track);

}  // namespace inbetween
