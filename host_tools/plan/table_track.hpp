// The curves of a table: every axis through its rows.
#pragma once

#include <cstddef>
#include <optional>

#include "host_tools/move_model/move_file.hpp"
#include "host_tools/plan/row_spline.hpp"

namespace inbetween {

/// The path of a track with a table, whose positions are in the units of the rig. Every axis is the C2 cubic
/// spline over the frames of its rows (row_spline.hpp): cubics in time, which are played as they are, so that
/// every row is met. The knots are parts of the whole move, from its first key to its last.
///
/// An axis rests at an end of the move, with velocity and acceleration 0, where its first two rows, or its
/// last two, are equal; or where `rest` of the track says so. Elsewhere its acceleration is 0 there and its
/// velocity what the rows say, so that a roll joins. Unlike with keys nothing rests between two equal rows
/// inside: a table rounds what it was made of, and each of its flat steps would be a stop.
///
/// O(rows * axes); 32 bytes for each row and axis.
CubicsOverFrames table_path(const MoveTrack& track);

/// The first row in which an axis of the track is outside low..high; nothing where none is.
std::optional<std::size_t> row_outside(const MoveTrack& track, std::size_t axis, double low, double high);

}  // namespace inbetween
