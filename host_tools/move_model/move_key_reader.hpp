// Reads the keys of a track.
#pragma once

#include <cstdint>
#include <optional>

#include "host_tools/move_model/move_file.hpp"
#include "host_tools/text/toml_value.hpp"

namespace inbetween {

/// What a track or a key says of how corners are rounded.
struct CornerFields {
  std::optional<std::int32_t> overlap;  // frames
  std::optional<double> round;          // weighted distance
};

/// Reads `overlap` and `round` of a track or a key; spline, timing and kinetic of the track are known.
CornerFields read_corner_fields(const TomlTable& table, const MoveTrack& track);

/// Reads `unit` and `wrap` of a track, whose axes are known.
void read_counting(const TomlTable& table, MoveTrack& track);

/// Reads the keys of a track, of which axes, spline, units and wraps are known, in a move of so many frames.
void read_keys(const TomlTable& table, std::int32_t frames, MoveTrack& track);

}  // namespace inbetween
