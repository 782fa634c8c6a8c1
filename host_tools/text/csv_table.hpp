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
  std::vector<std::string> fields;  // without the spaces around them
};

struct CsvTable {
  std::string path;
  std::vector<std::string> columns;
  std::vector<CsvRow> rows;  // each with a field for every column

  [[nodiscard]] Place place_of(const CsvRow& row) const { return {path, row.line, 0}; }
};

/// Reads RFC 4180: fields with a comma, a quote or a line break stand in quotes. A byte order mark, LF in
/// place of CRLF and empty lines are accepted. `path` stands in places. Throws InputError at the line where a
/// row has more or fewer fields than the first, or where a quote is not closed, and at the file where no row
/// is there. O(bytes).
CsvTable parse_csv(std::string_view text, const std::string& path);

/// A field as a finite number, at most max_magnitude; decimals have a point. Throws InputError at the row,
/// with the name of the column.
double csv_number(const CsvTable& table, const CsvRow& row, std::size_t column);

/// A field with a comma or a quote is quoted as RFC 4180 says.
std::string csv_field(const std::string& text);

}  // namespace inbetween
