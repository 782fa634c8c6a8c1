// Reads what a track and its keys say of the world: space, aim, elbow, near, distance; at, aim, roll.
#pragma once

#include <cstddef>

#include "host_tools/files/move_file.hpp"
#include "host_tools/files/toml_value.hpp"

namespace inbetween {

/// The fields of the track. Its axes are read.
void read_space(const TomlTable& table, MoveTrack& track);

/// The coordinates of key `index` of a track in space, which has as many as the first key.
void read_space_position(const TomlTable& table, std::size_t index, MoveTrack& track, MoveKey& key);

/// Of a key of a track that is not in space.
void refuse_space_fields(const TomlTable& table);

}  // namespace inbetween
