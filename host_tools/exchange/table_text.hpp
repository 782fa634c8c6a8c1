// Rows of numbers in a text: lines, words and numbers with their places, whatever the locale is; and the
// same, written.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/exchange/baked_table.hpp"

namespace inbetween {

/// Between the words of a line.
inline constexpr std::string_view table_blanks = " \t";

struct TextLine {
  std::uint32_t number = 0;
  std::string_view text;  // without blanks at its end
};

/// A word and the column at which it begins, in code points from 1.
struct TextWord {
  std::string_view text;
  std::uint32_t column = 0;
};

/// Takes the lines of a text one by one: they end with LF, CRLF or CR. Refers to the text.
class TextLines {
 public:
  /// A byte order mark is passed over. Throws InputError at the file where it has more than max_baked_bytes
  /// bytes, and where one of them is 0 (UTF-16, or no text at all).
  TextLines(std::string_view text, const std::string& file);
  /// Nothing behind the last line.
  std::optional<TextLine> next();

 private:
  std::string_view rest_;
  std::uint32_t number_ = 0;
};

/// The words of a line, with any of `blanks` between them. Nothing where it has more than `most`.
std::optional<std::vector<TextWord>> words_of(std::string_view line, std::size_t most,
                                              std::string_view blanks = table_blanks);

/// A finite number with a point, of at most max_magnitude; a plus before it is accepted. Throws InputError at
/// `place`, and says what is wrong: a decimal comma, a number that is none, one that is too large.
double table_number(std::string_view word, const Place& place);
/// The same of a whole number, 12 or 12.0, from `min` to `max`.
std::int64_t table_whole_number(std::string_view word, const Place& place, std::int64_t min,
                                std::int64_t max);

/// Digits behind the point of a number; nothing where it has an exponent.
std::optional<std::int32_t> decimals_of(std::string_view word);
/// A column has as many as the row with the most; nothing once a number had an exponent.
void take_decimals(std::string_view word, bool is_first, BakedColumn& column);

/// A row that is wrong takes its place all the same: those behind it are judged by themselves.
void keep_place_of_row(std::uint32_t line, BakedTable& table);

/// Takes the number of the frame of the next row: the first one, or one more than the row before has. Throws
/// InputError at `place` where frames are missing, or come again.
void take_frame(std::int64_t frame, const Place& place, BakedTable& table);

/// Adds rows of numbers to the columns of a table, as many as there are columns in it.
class RowTaker {
 public:
  explicit RowTaker(BakedTable& table) : table_(table) {}
  /// Throws InputError at the line where the row has more or fewer words than the table has columns, or is
  /// one too many, and at the word that is no number.
  void take(std::uint32_t line, const std::vector<TextWord>& words);
  /// Columns without names, "column 1" and so on.
  void name_columns(std::size_t count);

 private:
  BakedTable& table_;
};

/// Rows without a name or a frame, each with as many numbers as the first: the lines that are left. `comment`
/// begins a line that says nothing ("" where no such line is accepted). Throws InputError as RowTaker does,
/// and at an empty line between two rows.
void take_bare_rows(TextLines& lines, std::string_view comment, BakedTable& table);

/// How numbers are written: with a point, without an exponent, never "-0.000".
struct TableWriting {
  std::int32_t decimals = 6;  // 0..12
};
std::string fixed_number(double value, std::int32_t decimals);

/// Refuses a table that no writer can write: check_table(), and a number that is not finite. Throws
/// InputError.
void check_written(const BakedTable& table, const TableWriting& writing = {});
/// The column of this name, in capitals or small letters. Throws InputError where there is none; `example`
/// says what it is for.
const BakedColumn& written_column(const BakedTable& table, std::string_view name, std::string_view format);

}  // namespace inbetween
