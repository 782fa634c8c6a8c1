// The parts of the reader of a move, each written in a file of its own: keys, space, network, table, cues.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "host_tools/move_model/move_file.hpp"
#include "host_tools/text/toml_value.hpp"

namespace inbetween {

// move_key_reader.cpp

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

// move_space_reader.cpp: what a track and its keys say of the world

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

// move_network_reader.cpp: what makes a track a network, and the CSV files that `drawn` names

/// Points of a drawn curve.
inline constexpr std::size_t max_drawn_points = max_keys;

/// The fields of a track in a move of so many frames. Axes, spline, timing, kinetic, units and wraps are
/// read. A CSV file is beside the move file; `read` reads it. Throws InputError at a field that a network
/// cannot have, and at the field, or the line of the CSV file, that is no curve over the frames of the move.
void read_network(const TomlTable& table, std::int32_t frames, const TextReader& read, MoveTrack& track);

/// Every key has a frame, the first 0, the last that of the move, each later than the one before. Throws
/// InputError at the key.
void check_network_keys(const MoveTrack& track, std::int32_t frames);

/// The file that a field names, which stands beside that of the move. Throws InputError at a name with a
/// folder.
std::string path_beside(const TomlValue& value);
/// The unit of a column "tip (mm)", as `plan --csv` names the columns of the axis "tip"; nothing where the
/// column is another. A column "tip" counts as `otherwise`.
std::optional<MoveUnit> unit_of_column(const std::string& column, const std::string& axis,
                                       MoveUnit otherwise);

// move_table_reader.cpp: a track whose motion is a CSV file

/// The field `table` of a track in a move of so many frames, and `unit`; axes and rest are read. The rows
/// are read one by one from what `read` gives, of max_table_bytes at most. Throws InputError at a field that
/// says anything else of the motion, and at the line of the file where the rows are none of the move.
/// O(bytes).
void read_table(const TomlTable& table, std::int32_t frames, const TextReader& read, MoveTrack& track);

// move_cue_reader.cpp

/// Reads the fields `cue`, `clapper` and `start` into `move`, whose frames and rate have been read. Throws
/// InputError at the first mistake. Two pulses of a line that overlap or touch are a mistake.
void read_cues(const TomlTable& table, MoveFile& move);

}  // namespace inbetween
