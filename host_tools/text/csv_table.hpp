// Reads a table of comma-separated values whose first row names the columns.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/text/diagnostics.hpp"

namespace inbetween {

/// A row and the line of the file on which it begins.
struct CsvRow {
  std::uint32_t line = 0;
  std::vector<std::string> fields;     // without the spaces around them
  std::vector<std::uint32_t> columns;  // of the line, where each field begins; a quoted one at its quote
};

struct CsvTable {
  std::string path;
  std::vector<std::string> columns;
  std::vector<CsvRow> rows;  // each with a field for every column

  [[nodiscard]] Place place_of(const CsvRow& row) const { return {path, row.line, 0}; }
};

/// Takes the rows of a text one by one, so that a long table needs the memory of one row. Reads RFC 4180:
/// fields with a separator, a quote or a line break stand in quotes. A byte order mark, LF in place of CRLF
/// and empty lines are accepted. Refers to the text and to `path`, which stands in places.
class CsvReader {
 public:
  /// `separator` stands between fields: a comma, a semicolon or a tab.
  CsvReader(std::string_view text, const std::string& path, char separator = ',');

  /// Takes the first row, which names the columns: every row behind it must have as many fields. Throws
  /// InputError at the file where no row is there.
  void read_columns();
  /// Empty without read_columns().
  [[nodiscard]] const std::vector<std::string>& columns() const { return columns_; }

  /// The next row takes the place of `row`; false behind the last one. Throws InputError at the line where a
  /// row has more or fewer fields than there are columns, or more than `max_fields`, where a quote is not
  /// closed, or where text stands behind a closing one. O(bytes of the row).
  bool next(CsvRow& row, std::size_t max_fields = static_cast<std::size_t>(-1));

 private:
  bool take(CsvRow& row, std::size_t max_fields);
  bool take_field(const CsvRow& row, std::string& field);
  void refuse_more_behind_quote() const;
  void take_quoted(std::uint32_t first_line, std::string& field);
  [[nodiscard]] std::size_t end_of_field() const;
  [[nodiscard]] std::size_t begin_of_field() const;
  void begin_line(const char* begin);
  std::uint32_t column_of(const char* place);

  std::string_view rest_;
  const std::string& path_;
  char separator_;
  std::string_view blanks_;  // what is passed over around a field
  std::uint32_t line_ = 1;
  const char* counted_ = nullptr;  // the columns of the line are counted up to here
  std::uint32_t column_ = 1;
  std::vector<std::string> columns_;
};

/// All rows at once. Throws InputError as a CsvReader does. O(bytes).
CsvTable parse_csv(std::string_view text, const std::string& path);

/// A field of a column as a finite number, at most max_magnitude; decimals have a point. Throws InputError at
/// `place`, with the name of the column.
double csv_number(const std::string& column, const std::string& field, const Place& place);
/// The same of a row of a table.
double csv_number(const CsvTable& table, const CsvRow& row, std::size_t column);

/// A field with a comma or a quote is quoted as RFC 4180 says.
std::string csv_field(const std::string& text);

}  // namespace inbetween
