#include "host_tools/text/csv_table.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <optional>
#include <system_error>
#include <utility>

#include "host_tools/text/toml_source.hpp"
#include "host_tools/text/toml_value.hpp"

namespace inbetween {
namespace {

std::string without_blanks(std::string_view field) {
  const std::size_t begin = field.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return "";
  return std::string(field.substr(begin, field.find_last_not_of(" \t") - begin + 1));
}

/// Takes the rows of a text one by one.
class CsvReader {
 public:
  CsvReader(std::string_view text, const std::string& path) : rest_(text), path_(path) {
    if (rest_.starts_with(byte_order_mark)) rest_.remove_prefix(byte_order_mark.size());
  }

  /// Nothing behind the last row.
  std::optional<CsvRow> next() {
    while (!rest_.empty()) {
      CsvRow row{.line = line_, .fields = {}};
      while (add_field(row)) {
      }
      if (row.fields.size() > 1 || !row.fields.front().empty()) return row;
    }
    return std::nullopt;
  }

 private:
  /// Whether another field follows in the row.
  bool add_field(CsvRow& row) {
    const std::size_t begin = rest_.find_first_not_of(" \t");
    if (begin != std::string_view::npos && rest_[begin] == '"') {
      rest_.remove_prefix(begin + 1);
      row.fields.push_back(quoted(row.line));
      refuse_more_behind_quote();
    } else {
      row.fields.push_back(without_blanks(rest_.substr(0, rest_.find_first_of(",\r\n"))));
    }
    const std::size_t end = rest_.find_first_of(",\r\n");
    if (end == std::string_view::npos) {
      rest_ = {};
      return false;
    }
    const bool is_comma = rest_[end] == ',';
    const bool is_pair = rest_.substr(end).starts_with("\r\n");
    rest_.remove_prefix(end + (is_pair ? 2 : 1));
    if (!is_comma) ++line_;
    return is_comma;
  }

  void refuse_more_behind_quote() const {
    const std::size_t next = rest_.find_first_not_of(" \t");
    if (next == std::string_view::npos || rest_.find_first_of(",\r\n") == next) return;
    throw InputError({path_, line_, 0}, "text stands behind a closing quote; write a comma between them");
  }

  /// A quote within the field is written twice.
  std::string quoted(std::uint32_t first_line) {
    std::string field;
    for (;;) {
      const std::size_t end = rest_.find('"');
      if (end == std::string_view::npos) {
        throw InputError({path_, first_line, 0}, "a quote is not closed; close it, or remove it");
      }
      for (const char c : rest_.substr(0, end)) line_ += c == '\n' ? 1 : 0;
      field += rest_.substr(0, end);
      rest_.remove_prefix(end + 1);
      if (!rest_.starts_with('"')) return field;
      field += '"';
      rest_.remove_prefix(1);
    }
  }

  std::string_view rest_;
  const std::string& path_;
  std::uint32_t line_ = 1;
};

}  // namespace

CsvTable parse_csv(std::string_view text, const std::string& path) {
  CsvReader reader(text, path);
  CsvTable table{.path = path, .columns = {}, .rows = {}};
  std::optional<CsvRow> row = reader.next();
  if (!row) throw InputError({path, 0, 0}, "the file is empty; its first row names the columns");
  table.columns = std::move(row->fields);
  while ((row = reader.next())) {
    if (row->fields.size() != table.columns.size()) {
      throw InputError(
          table.place_of(*row),
          fmt::format(
              "the row has {}, and the first row names {}; write one field for each column, a decimal "
              "with a point",
              counted(static_cast<std::int64_t>(row->fields.size()), "field"), table.columns.size()));
    }
    table.rows.push_back(std::move(*row));
  }
  return table;
}

double csv_number(const CsvTable& table, const CsvRow& row, std::size_t column) {
  const std::string& field = row.fields[column];
  double number = 0;
  const char* const end = field.data() + field.size();
  const auto [stopped, error] = std::from_chars(field.data(), end, number);
  if (error == std::errc() && stopped == end && std::abs(number) <= max_magnitude) return number;
  throw InputError(table.place_of(row), fmt::format("{} is {}; write a number such as 12.5",
                                                    in_quotes(table.columns[column]), in_quotes(field)));
}

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

}  // namespace inbetween
