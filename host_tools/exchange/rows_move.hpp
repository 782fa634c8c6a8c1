// A move that plays the rows of a table as they are: a move file, and a CSV file of rows beside it.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "host_tools/exchange/baked_table.hpp"
#include "host_tools/rig_model/rig_file.hpp"

namespace inbetween {

struct RowsMove {
  std::string name;
  FrameRate fps;
  std::vector<std::string> axes;               // of the rig
  std::vector<std::vector<double>> positions;  // of each axis, on the frames 0..N, in its unit in the rig
  std::vector<std::string> comments = {};      // where it comes from
  std::vector<std::string> warnings = {};      // what was done with the rows

  [[nodiscard]] std::size_t frames() const { return positions.empty() ? 0 : positions.front().size() - 1; }
};

/// `table` has the axes of the rig in their units (imported_table). Row k is on frame k, where rows are at
/// the boundary before their frame, or at moments. Where they are in the middle of exposures, half a frame
/// later, the frames are between them: on the cubic through four rows, and half a frame beyond the first and
/// the last row on the straight line through two; the move then has as many frames as rows. Exact for cubics
/// but for the two ends. Throws WrongRowsError with the line of every row on which an axis is outside its
/// range, and InputError at the file where a rate is above 1000 or the cubic leaves the range. O(rows *
/// axes).
RowsMove rows_move_of(const BakedTable& table, const RigFile& rig, const std::string& name);

/// "192 frames of pan, tilt at 24 fps, 8.000 s".
std::string summary_of(const RowsMove& move);

/// The move file. `rows` is the name of the file that rows_text_of makes, in the same folder.
std::string move_text_of(const RowsMove& move, const std::string& rows);

/// `frame,pan,tilt`, then a row a frame; numbers read back exactly. Throws InputError at `rows`, the name of
/// the file, where it would have more than max_table_bytes, the bound of a table.
std::string rows_text_of(const RowsMove& move, const std::string& rows);

}  // namespace inbetween
