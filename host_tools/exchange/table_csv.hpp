// Tables of comma-separated values, with the names that anybody gives to columns.
//
// There is no standard for motion in CSV. A row a frame; the first row names the columns, or has numbers
// where nothing is named. `plan --csv` is read too. Columns: `frame` (or `tick`), the number of the row;
// `seconds` (or `time_s`); every other is an axis: PAN, PAN [deg], PAN (deg).
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "host_tools/exchange/table_text.hpp"

namespace inbetween {

/// What somebody says of a file.
struct CsvReading {
  std::optional<char> separator = {};  // ',', ';' or a tab; otherwise the only one of the first row
  bool has_decimal_commas = false;     // 12,5; the separator is then no comma
  bool fills_gaps = false;             // frames that are missing lie on a line between their neighbours
  std::optional<std::string> frame_column = {};    // another name for `frame`
  std::optional<std::string> seconds_column = {};  // another name for `seconds`
};

/// Frames ascend by one, unless gaps are filled. Throws InputError at line and column: where nobody can tell
/// the separator, a decimal has a comma that nobody stated, frames are missing, a unit is none. O(bytes).
BakedTable read_table_csv(std::string_view text, const std::string& file, const CsvReading& reading = {});

/// `frame,PAN [deg],...`, from frame `first_frame` of the table or 0; LF ends a row. Throws InputError where
/// the table cannot be written, or a name would be read as a unit, a number or the frame.
std::string write_table_csv(const BakedTable& table, const TableWriting& writing = {});

/// Whether somebody meant a number with it, also one that is refused: NaN, 1e999.
bool is_number_word(std::string_view word);

}  // namespace inbetween
