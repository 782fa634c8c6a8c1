// Rows of a table as a move that can be edited: few keys and a drawn speed curve, or few keys on frames.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "host_tools/fit/keys_on_frames.hpp"
#include "host_tools/move_model/move_file.hpp"

namespace inbetween {

/// A row on each frame of a move.
struct RowsToFit {
  std::vector<std::string> axes;  ///< their names
  RowsOnFrames table;
  WrittenFrameRate fps;
};

struct RowFit {
  MoveFile move;              ///< named nothing; every axis is in a track
  std::vector<double> worst;  ///< of each axis: the largest miss of a row by what the move plays
  std::size_t numbers = 0;    ///< in its keys, frames and speed curves
};

/// Every axis alone is fitted in both ways, and axes share a track where that takes fewer numbers: two axes
/// that are driven by one speed curve have its values once. Of all that is tried the move with the fewest
/// numbers is taken. Each miss is that of the solved move, on every frame, and at most the tolerance.
///
/// Paths with a speed curve are looked for up to 2 000 rows, and tracks of several axes up to 50 000 numbers
/// in all. Throws std::runtime_error where an axis needs more than 10 000 keys. Cost: seconds for six axes
/// and 300 rows; of longer tables that of keys_on_frames() for each axis.
RowFit fit_rows(const RowsToFit& rows, const std::function<void(double share)>& progress);

}  // namespace inbetween
