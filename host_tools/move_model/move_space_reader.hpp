// Reads what a track and its keys say of the world: space, aim, elbow, near, distance; at, aim, roll.
#pragma once

#include <array>
#include <cstddef>

#include "host_tools/move_model/move_file.hpp"
#include "host_tools/text/toml_value.hpp"

namespace inbetween {

/// The fields of the track. Its axes are read.
void read_space(const TomlTable& table, MoveTrack& track);

/// The coordinates of key `index` of a track in space, which has as many as the first key.
void read_space_position(const TomlTable& table, std::size_t index, MoveTrack& track, MoveKey& key);

/// The places of a key of a row of points, as many as the row has. Its drawn curves are read.
void read_row_position(const TomlTable& table, const MoveTrack& track, MoveKey& key);

/// A coordinate in the world, and where it stands in the file.
struct WorldNumber {
  double metres = 0;
  Place place;
};
/// Three numbers of a file. Throws InputError at one that is no place of a rig.
std::array<WorldNumber, world_coordinates> read_world_place(const TomlValue& value, MoveUnit unit);
/// The same of one number, that stands at `place`.
double world_metres(double number, MoveUnit unit, const Place& place);

/// Of a key of a track that is not in space.
void refuse_space_fields(const TomlTable& table);

}  // namespace inbetween
