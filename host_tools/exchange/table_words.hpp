// What somebody writes of a baked motion in a few words, on a command line or where it is asked.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "host_tools/exchange/baked_table.hpp"

namespace inbetween {

/// "24", "24000/1001": both numbers 1..1 000 000, the quotient at most 1000. Nothing otherwise, as of 23.976.
std::optional<FrameRate> frame_rate_of_word(std::string_view word);

/// "tz=dolly", and "tz=-dolly" for an axis that goes the other way; "tz=-" for a column that is of no axis;
/// "pan" for a column and an axis of one name. The last = counts: an axis has none in its name.
struct AxisWord {
  std::string column, axis;
  bool is_reversed = false;
  bool is_left_out = false;
};
std::optional<AxisWord> axis_word_of(std::string_view text);

/// "deg" of every column that it fits, "tz=cm" of one. "rig" is the unit in which the axis counts in its rig.
struct UnitWord {
  std::optional<std::string> column = {};
  MoveUnit unit = MoveUnit::of_rig;
};
std::optional<UnitWord> unit_word_of(std::string_view text);
std::optional<MoveUnit> move_unit_of_word(std::string_view word);

/// "Pan=1500,-0.1deg": the axis is at 0 at count 1500, and a count further at -0.1 degrees. What is a
/// distance is never 0.
struct CountWord {
  std::string column;
  double zero = 0;
  double count = 1;
  MoveUnit unit = MoveUnit::of_rig;
};
std::optional<CountWord> count_word_of(std::string_view text);

std::optional<UpAxis> up_axis_of_word(std::string_view word);
/// "centre" and "boundary".
std::optional<ShutterPhase> phase_of_word(std::string_view word);
std::string_view to_string(ShutterPhase phase);

}  // namespace inbetween
