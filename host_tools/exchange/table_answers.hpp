// What somebody says of a baked motion where its file says nothing, and the motion with it.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/exchange/baked_table.hpp"

namespace inbetween {

/// A column and the axis that it is.
struct ColumnAnswer {
  std::string column;                 // its name in the table
  std::string axis;                   // its name from then on
  std::optional<MoveUnit> unit = {};  // in which it counts, or, where it has counts, its axis
  std::optional<double> count = {};   // how far a count is, in `unit`; negative where they run backwards
  double zero = 0;                    // the count at which the axis is at 0
  bool is_reversed = false;  // the axis goes the other way: y of a file with z up is -z of one with y up
};

struct TableAnswers {
  std::optional<FrameRate> fps = {};
  std::vector<ColumnAnswer> columns = {};  // what is not named here is left out, with a warning
  std::optional<UpAxis> up = {};
  std::optional<std::string> rotation_order = {};  // "ZXY"
  std::optional<ShutterPhase> phase = {};
};

/// The table with what was said: its columns are those of the answers, in their order and with the names of
/// their axes, counts are positions, and nothing is left to be asked. Throws InputError at the file where a
/// question has no answer (it names all of them), an answer is not what the file says, a column is not there
/// (it names the one that was probably meant) or is named twice, and at the line where the rows are at
/// another rate.
BakedTable answered_table(BakedTable table, const TableAnswers& answers);

/// The three axes in any order, each once: "XYZ", "zxy".
bool is_rotation_order(std::string_view order);

}  // namespace inbetween
