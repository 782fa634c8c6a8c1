#include "host_tools/text/csv_table.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <system_error>
#include <utility>

#include "host_tools/text/toml_source.hpp"
#include "host_tools/text/toml_value.hpp"

namespace inbetween {
namespace {

std::string_view without_blanks(std::string_view field, std::string_view blanks) {
  const std::size_t begin = field.find_first_not_of(blanks);
  if (begin == std::string_view::npos) return {};
  return field.substr(begin, field.find_last_not_of(blanks) - begin + 1);
}

}  // namespace

CsvReader::CsvReader(std::string_view text, const std::string& path, char separator)
    : rest_(text), path_(path), separator_(separator), blanks_(separator == '\t' ? " " : " \t") {
  if (rest_.starts_with(byte_order_mark)) rest_.remove_prefix(byte_order_mark.size());
  begin_line(rest_.data());
}

void CsvReader::read_columns() {
  CsvRow first;
  if (!next(first)) throw InputError({path_, 0, 0}, "the file is empty; its first row names the columns");
  columns_ = std::move(first.fields);
}

bool CsvReader::next(CsvRow& row, std::size_t max_fields) {
  if (!take(row, max_fields)) return false;
  if (columns_.empty() || row.fields.size() == columns_.size()) return true;
  throw InputError(
      {path_, row.line, 0},
      fmt::format("the row has {}, and the first row names {}; write one field for each column, a decimal "
                  "with a point",
                  counted(static_cast<std::int64_t>(row.fields.size()), "field"), columns_.size()));
}

/// Whether there is another row. Its fields take the memory of those that `row` has.
bool CsvReader::take(CsvRow& row, std::size_t max_fields) {
  while (!rest_.empty()) {
    row.line = line_;
    row.columns.clear();
    std::size_t count = 0;
    bool has_more = true;
    while (has_more) {
      if (count == max_fields) {
        throw InputError(
            {path_, row.line, 0},
            fmt::format("the row has more than {} fields; leave out what is not needed", max_fields));
      }
      if (count == row.fields.size()) row.fields.emplace_back();
      row.columns.push_back(column_of(rest_.data() + begin_of_field()));
      has_more = take_field(row, row.fields[count++]);
    }
    row.fields.resize(count);
    if (count > 1 || !row.fields.front().empty()) return true;
  }
  return false;
}

/// Of the next separator or line end; the size of the text where there is none. Byte by byte: a field is
/// short, and find_first_of() takes twice as long.
std::size_t CsvReader::end_of_field() const {
  std::size_t end = 0;
  while (end < rest_.size() && rest_[end] != separator_ && rest_[end] != '\n' && rest_[end] != '\r') ++end;
  return end;
}

/// Of what is no blank; 0 where only blanks are left.
std::size_t CsvReader::begin_of_field() const {
  const std::size_t begin = rest_.find_first_not_of(blanks_);
  return begin == std::string_view::npos ? 0 : begin;
}

void CsvReader::begin_line(const char* begin) {
  counted_ = begin;
  column_ = 1;
}

/// Every byte of a line is counted once, however many fields it has.
std::uint32_t CsvReader::column_of(const char* place) {
  for (; counted_ < place; ++counted_) {
    const bool continues_a_character = (static_cast<unsigned char>(*counted_) & 0xc0U) == 0x80U;
    if (!continues_a_character) ++column_;
  }
  return column_;
}

/// Whether another field follows in the row.
bool CsvReader::take_field(const CsvRow& row, std::string& field) {
  const std::size_t begin = begin_of_field();
  if (!rest_.empty() && rest_[begin] == '"') {
    rest_.remove_prefix(begin + 1);
    take_quoted(row.line, field);
    refuse_more_behind_quote();
    rest_.remove_prefix(end_of_field());
  } else {
    const std::size_t end = end_of_field();
    field = without_blanks(rest_.substr(0, end), blanks_);
    rest_.remove_prefix(end);
  }
  if (rest_.empty()) return false;
  const bool is_separator = rest_.front() == separator_;
  rest_.remove_prefix(rest_.starts_with("\r\n") ? 2 : 1);
  if (is_separator) return true;
  ++line_;
  begin_line(rest_.data());
  return false;
}

void CsvReader::refuse_more_behind_quote() const {
  const std::size_t next = rest_.find_first_not_of(blanks_);
  if (next == std::string_view::npos || end_of_field() == next) return;
  throw InputError({path_, line_, 0}, fmt::format("text stands behind a closing quote; write {} between them",
                                                  separator_ == ',' ? "a comma" : "a separator"));
}

/// A quote within the field is written twice.
void CsvReader::take_quoted(std::uint32_t first_line, std::string& field) {
  field.clear();
  for (;;) {
    const std::size_t end = rest_.find('"');
    if (end == std::string_view::npos) {
      throw InputError({path_, first_line, 0}, "a quote is not closed; close it, or remove it");
    }
    for (std::size_t i = 0; i < end; ++i) {
      if (rest_[i] != '\n') continue;
      ++line_;
      begin_line(rest_.data() + i + 1);
    }
    field += rest_.substr(0, end);
    rest_.remove_prefix(end + 1);
    if (!rest_.starts_with('"')) return;
    field += '"';
    rest_.remove_prefix(1);
  }
}

CsvTable parse_csv(std::string_view text, const std::string& path) {
  CsvReader reader(text, path);
  reader.read_columns();
  CsvTable table{.path = path, .columns = reader.columns(), .rows = {}};
  for (CsvRow row; reader.next(row);) table.rows.push_back(row);
  return table;
}

double csv_number(const std::string& column, const std::string& field, const Place& place) {
  double number = 0;
  const char* const end = field.data() + field.size();
  const auto [stopped, error] = std::from_chars(field.data(), end, number);
  if (error == std::errc() && stopped == end && std::abs(number) <= max_magnitude) return number;
  throw InputError(place,
                   fmt::format("{} is {}; write a number such as 12.5", in_quotes(column), in_quotes(field)));
}

double csv_number(const CsvTable& table, const CsvRow& row, std::size_t column) {
  return csv_number(table.columns[column], row.fields[column], table.place_of(row));
}

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

}  // namespace inbetween
