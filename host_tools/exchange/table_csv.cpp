#include "host_tools/exchange/table_csv.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <system_error>
#include <utility>
#include <vector>

#include "host_tools/exchange/wrong_rows.hpp"
#include "host_tools/text/csv_table.hpp"
#include "host_tools/text/ini_sections.hpp"

namespace inbetween {
namespace {

constexpr std::array<std::string_view, 2> csv_frame_names = {"frame", "tick"};
constexpr std::array<std::string_view, 3> csv_seconds_names = {"seconds", "time_s", "seconds [s]"};
constexpr std::string_view csv_separators = ",;\t";

/// The characters that may separate and stand in the first line, outside of quotes.
std::string separators_in_first_line(std::string_view text) {
  std::string found;
  bool is_quoted = false;
  bool is_empty = true;
  for (const char c : text) {
    if (c == '"') is_quoted = !is_quoted;
    if (!is_quoted && (c == '\n' || c == '\r')) {
      if (!is_empty) break;
      continue;
    }
    is_empty = is_empty && table_blanks.find(c) != table_blanks.npos;
    if (is_quoted || csv_separators.find(c) == csv_separators.npos) continue;
    if (found.find(c) == std::string::npos) found += c;
  }
  return found;
}

char separator_of(std::string_view text, const std::string& file, const CsvReading& reading) {
  if (reading.separator) return *reading.separator;
  std::string found = separators_in_first_line(text);
  if (reading.has_decimal_commas) std::erase(found, ',');
  if (found.empty()) return reading.has_decimal_commas ? ';' : ',';
  if (found.size() == 1) return found.front();
  throw InputError({file, 1, 0},
                   "the first row has more than one of comma, semicolon and tab; say which of them separates "
                   "columns, and whether decimals have commas");
}

struct NameAndUnit {
  std::string name;
  std::optional<MoveUnit> unit = {};
};

std::optional<MoveUnit> unit_of_word(std::string_view word) {
  if (word == "unit") return MoveUnit::of_rig;  // of an axis that counts in nothing else
  const auto found = std::ranges::find(move_unit_words, word);
  if (found == move_unit_words.end()) return std::nullopt;
  return static_cast<MoveUnit>(found - move_unit_words.begin() + 1);
}

/// "PAN [deg]" and "PAN (deg)". Parentheses may be part of a name, and brackets may not.
NameAndUnit name_and_unit(std::string_view field, const Place& place) {
  for (const auto& [open, close] : {std::pair('[', ']'), std::pair('(', ')')}) {
    const std::size_t begin = field.rfind(open);
    if (!field.ends_with(close) || begin == field.npos) continue;
    const std::string_view word = trimmed(field.substr(begin + 1, field.size() - begin - 2));
    const std::optional<MoveUnit> unit = unit_of_word(word);
    if (unit) return {std::string(trimmed(field.substr(0, begin))), unit};
    if (open == '(') break;
    throw InputError(place, fmt::format("{} is no unit; write one of {}, unit", in_quotes(word),
                                        comma_separated(move_unit_words)));
  }
  return {std::string(field)};
}

class TableCsvReader {
 public:
  TableCsvReader(std::string_view text, const std::string& file, const CsvReading& reading)
      : reading_(reading),
        separator_(separator_of(text, file, reading)),
        rows_(text, file, separator_),
        table_{.file = file} {}

  BakedTable read() {
    const std::optional<CsvRow> first = next();
    if (!first) throw InputError({table_.file}, "the file is empty; its first row names the columns");
    const bool is_named = has_names(*first);
    for (std::size_t i = 0; i < first->fields.size(); ++i) take_name(*first, i, is_named);
    table_.has_names = is_named;
    if (table_.columns.empty()) check_table(table_);  // says so
    if (!is_named) take(*first);
    WrongRows wrong(table_.file);
    while (const std::optional<CsvRow> row = next())
      wrong.judge([&] { take(*row); }, [&] { keep_place_of_row(row->line, table_); });
    wrong.refuse();
    // Each may be off by half of its last digit.
    table_.seconds_rounding = seconds_decimals_ ? 0.5 * std::pow(10.0, -*seconds_decimals_) : 0;
    check_table(table_);
    return std::move(table_);
  }

 private:
  std::optional<CsvRow> next() {
    CsvRow row;
    if (!rows_.next(row, max_table_columns)) return std::nullopt;
    return row;
  }
  [[nodiscard]] Place place_of(const CsvRow& row, std::size_t field) const {
    return {table_.file, row.line, row.columns[field]};
  }
  [[nodiscard]] bool is_frame(std::string_view name) const {
    if (reading_.frame_column) return name == *reading_.frame_column;
    return std::ranges::find(csv_frame_names, lower_case(name)) != csv_frame_names.end();
  }
  [[nodiscard]] bool is_seconds(std::string_view name) const {
    if (reading_.seconds_column) return name == *reading_.seconds_column;
    return std::ranges::find(csv_seconds_names, lower_case(name)) != csv_seconds_names.end();
  }

  bool has_names(const CsvRow& row) const {
    std::size_t numbers = 0;
    for (const std::string& field : row.fields) {
      if (is_frame(field) || is_seconds(field)) return true;
      std::string word = field;
      if (reading_.has_decimal_commas) std::ranges::replace(word, ',', '.');
      if (is_number_word(word)) ++numbers;
    }
    if (numbers == 0 || numbers == row.fields.size()) return numbers == 0;
    throw InputError({table_.file, row.line, 0},
                     "the first row has names and numbers; write the names of all columns, or only numbers");
  }

  void take_name(const CsvRow& row, std::size_t field, bool is_named) {
    const std::string& name = row.fields[field];
    if (is_named && name.empty()) {
      throw InputError(place_of(row, field), fmt::format("column {} has no name; write one", field + 1));
    }
    if (is_named && is_frame(name)) {
      refuse_second(frame_, row, field);
      frame_ = field;
    } else if (is_named && is_seconds(name)) {
      refuse_second(seconds_, row, field);
      seconds_ = field;
    } else if (is_named) {
      NameAndUnit read = name_and_unit(name, place_of(row, field));
      if (read.name.empty()) {
        throw InputError(place_of(row, field),
                         fmt::format("{} is a unit and no name; write the axis before it", in_quotes(name)));
      }
      table_.columns.push_back({.name = std::move(read.name), .unit = read.unit});
    } else {
      table_.columns.push_back({.name = fmt::format("column {}", field + 1)});
    }
    fields_ = field + 1;
  }
  void refuse_second(const std::optional<std::size_t>& earlier, const CsvRow& row, std::size_t field) const {
    if (!earlier) return;
    throw InputError(
        place_of(row, field),
        fmt::format("column {} says already which row it is; leave out one of the two", *earlier + 1));
  }

  double number(const CsvRow& row, std::size_t field, std::string& word) const {
    word = row.fields[field];
    const Place place = place_of(row, field);
    if (reading_.has_decimal_commas) {
      if (word.find('.') != std::string::npos) {
        throw InputError(place,
                         fmt::format("{} has a point, and decimals of this file have commas; write 12,5",
                                     in_quotes(word)));
      }
      std::ranges::replace(word, ',', '.');
    } else if (separator_ != ',' && std::ranges::count(word, ',') == 1) {
      throw InputError(place, fmt::format("{} has a comma in it; write a decimal with a point, or state that "
                                          "decimals have commas",
                                          in_quotes(word)));
    }
    return table_number(word, place);
  }

  void take(const CsvRow& row) {
    if (row.fields.size() != fields_) {
      throw InputError({table_.file, row.line, 0},
                       fmt::format("the row has {}, and the first row has {}; write one for each column, a "
                                   "decimal with a point",
                                   counted(static_cast<std::int64_t>(row.fields.size()), "field"), fields_));
    }
    if (frame_) take_frame_of(row);
    if (table_.rows() >= max_table_rows) {
      throw InputError({table_.file, row.line, 0},
                       fmt::format("the file has more than {} rows; write it in parts", max_table_rows));
    }
    std::string word;
    std::size_t column = 0;
    for (std::size_t field = 0; field < fields_; ++field) {
      if (field == frame_) continue;
      const double value = number(row, field, word);
      if (field == seconds_) {
        table_.seconds.push_back(value);
        // An exponent has digits too, and a time with one is not rounded to decimals.
        const std::int32_t decimals = decimals_of(word).value_or(17);
        seconds_decimals_ = std::max(seconds_decimals_.value_or(0), decimals);
        continue;
      }
      BakedColumn& to = table_.columns[column++];
      take_decimals(word, to.values.empty(), to);
      to.values.push_back(value);
    }
    table_.lines.push_back(row.line);
  }

  void take_frame_of(const CsvRow& row) {
    const Place place = place_of(row, *frame_);
    std::string word;
    number(row, *frame_, word);
    const std::int64_t frame = table_whole_number(word, place, -max_table_frame, max_table_frame);
    if (reading_.fills_gaps && table_.first_frame && table_.rows() > 0) fill_up_to(frame, row);
    take_frame(frame, place, table_);
  }

  /// The rows between the last one and `frame`, on a line to `row`.
  void fill_up_to(std::int64_t frame, const CsvRow& row) {
    const std::int64_t last = *table_.first_frame + static_cast<std::int64_t>(table_.rows()) - 1;
    const std::int64_t missing = frame - last - 1;
    if (missing <= 0) return;
    if (static_cast<std::size_t>(missing) > max_table_rows - table_.rows()) {
      throw InputError(
          {table_.file, row.line, 0},
          fmt::format("with the frames that are missing the file has more than {} rows; write it in "
                      "parts",
                      max_table_rows));
    }
    std::string word;
    std::size_t column = 0;
    for (std::size_t field = 0; field < fields_; ++field) {
      if (field == frame_) continue;
      std::vector<double>& values = field == seconds_ ? table_.seconds : table_.columns[column++].values;
      const double from = values.back();
      const double to = number(row, field, word);
      for (std::int64_t i = 1; i <= missing; ++i) {
        const double share = static_cast<double>(i) / static_cast<double>(missing + 1);
        values.push_back((1 - share) * from + share * to);
      }
    }
    table_.lines.insert(table_.lines.end(), static_cast<std::size_t>(missing), row.line);
    table_.warnings.push_back({{table_.file, row.line, 0},
                               fmt::format("{} before frame {} were missing, and lie on a line now",
                                           counted(missing, "frame"), frame)});
  }

  CsvReading reading_;
  char separator_;
  CsvReader rows_;
  BakedTable table_;
  std::optional<std::size_t> frame_ = {}, seconds_ = {};
  std::size_t fields_ = 0;
  std::optional<std::int32_t> seconds_decimals_ = {};
};

/// As RFC 4180 says, and so that no reader takes it for another separator, or strips it.
std::string csv_name(const std::string& name) {
  const std::string quoted = csv_field(name);
  const bool is_plain = name.find_first_of(";\t") == std::string::npos && trimmed(name) == name;
  return quoted != name || is_plain ? quoted : '"' + name + '"';
}

/// A name that comes back as it is.
void check_csv_name(const BakedTable& table, const BakedColumn& column) {
  const std::string lower = lower_case(column.name);
  const bool is_other = std::ranges::find(csv_frame_names, lower) != csv_frame_names.end() ||
                        std::ranges::find(csv_seconds_names, lower) != csv_seconds_names.end();
  const bool ends_as_unit = column.name.ends_with(']') || name_and_unit(column.name, {table.file}).unit;
  if (!is_other && !ends_as_unit && !column.name.empty() && trimmed(column.name) == column.name) return;
  throw InputError({table.file},
                   fmt::format("{} would be read as something else in a CSV file; rename the axis",
                               in_quotes(column.name)));
}

}  // namespace

bool is_number_word(std::string_view word) {
  if (word.starts_with('+') && !word.starts_with("+-")) word.remove_prefix(1);
  double number = 0;
  const auto [stopped, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  return error != std::errc::invalid_argument && stopped == word.data() + word.size();
}

BakedTable read_table_csv(std::string_view text, const std::string& file, const CsvReading& reading) {
  const TextLines checked(text, file);  // how long it is, and what is no text
  return TableCsvReader(text, file, reading).read();
}

std::string write_table_csv(const BakedTable& table, const TableWriting& writing) {
  check_written(table, writing);
  std::string text = "frame";
  for (const BakedColumn& column : table.columns) {
    check_csv_name(table, column);
    const bool is_of_rig = column.unit == MoveUnit::of_rig;
    const std::string unit = column.unit ? (is_of_rig ? "unit" : std::string(to_string(*column.unit))) : "";
    text += ',' + csv_name(unit.empty() ? column.name : column.name + " [" + unit + "]");
  }
  text += '\n';
  for (std::size_t row = 0; row < table.rows(); ++row) {
    text += fmt::format("{}", table.first_frame.value_or(0) + static_cast<std::int64_t>(row));
    for (const BakedColumn& column : table.columns) {
      text += ',' + fixed_number(column.values[row], writing.decimals);
    }
    text += '\n';
  }
  return text;
}

}  // namespace inbetween
