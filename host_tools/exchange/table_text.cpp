#include "host_tools/exchange/table_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>

#include "host_tools/exchange/wrong_rows.hpp"
#include "host_tools/text/ini_sections.hpp"
#include "host_tools/text/toml_source.hpp"
#include "host_tools/text/toml_value.hpp"

namespace inbetween {
namespace {

constexpr std::int32_t max_decimals = 12;  // of a millimetre: smaller than an atom

bool continues_code_point(char byte) {
  return (static_cast<unsigned char>(byte) & 0xc0U) == 0x80U;
}

/// What is wrong with a word that is no number, and what to do.
std::string fault_of_number(std::string_view word) {
  const std::string shown = in_quotes(word);
  if (word.find(',') != word.npos) {
    return fmt::format("{} has a comma in it; write a decimal with a point, such as 12.5", shown);
  }
  const std::string lower = lower_case(word);
  for (const std::string_view none : {"nan", "inf"}) {
    if (lower.find(none) != std::string::npos) {
      return fmt::format("{} is no position; have the program that wrote it correct this frame", shown);
    }
  }
  return fmt::format("{} is no number from -{:g} to {:g}; write one such as 12.5", shown, max_magnitude,
                     max_magnitude);
}

}  // namespace

TextLines::TextLines(std::string_view text, const std::string& file) : rest_(text) {
  if (text.size() > max_baked_bytes) {
    throw InputError({file}, fmt::format("the file has {} bytes; write it in parts of at most {}",
                                         text.size(), max_baked_bytes));
  }
  if (text.find('\0') != text.npos) {
    throw InputError({file}, "the file has bytes that are zero, as no text in UTF-8 has; save it as UTF-8");
  }
  if (rest_.starts_with(byte_order_mark)) rest_.remove_prefix(byte_order_mark.size());
}

std::optional<TextLine> TextLines::next() {
  if (rest_.empty()) return std::nullopt;
  const std::size_t end = std::min(rest_.find_first_of("\r\n"), rest_.size());
  std::string_view line = rest_.substr(0, end);
  const bool is_pair = rest_.substr(end).starts_with("\r\n");
  rest_.remove_prefix(std::min(end + (is_pair ? 2 : 1), rest_.size()));
  line = line.substr(0, line.find_last_not_of(table_blanks) + 1);
  return TextLine{++number_, line};
}

std::optional<std::vector<TextWord>> words_of(std::string_view line, std::size_t most,
                                              std::string_view blanks) {
  std::vector<TextWord> words;
  std::uint32_t column = 1;
  std::size_t counted_bytes = 0;
  std::size_t at = 0;
  while ((at = line.find_first_not_of(blanks, at)) != line.npos) {
    if (words.size() == most) return std::nullopt;
    for (; counted_bytes < at; ++counted_bytes) column += continues_code_point(line[counted_bytes]) ? 0U : 1U;
    const std::size_t end = std::min(line.find_first_of(blanks, at), line.size());
    words.push_back({line.substr(at, end - at), column});
    at = end;
  }
  return words;
}

double table_number(std::string_view word, const Place& place) {
  std::string_view digits = word;
  if (digits.starts_with('+') && !digits.starts_with("+-")) digits.remove_prefix(1);
  double number = 0;
  const char* const end = digits.data() + digits.size();
  const auto [stopped, error] = std::from_chars(digits.data(), end, number);
  if (error == std::errc() && stopped == end && std::fabs(number) <= max_magnitude) return number;
  throw InputError(place, fault_of_number(word));
}

std::int64_t table_whole_number(std::string_view word, const Place& place, std::int64_t min,
                                std::int64_t max) {
  const double number = table_number(word, place);
  if (number == std::floor(number) && number >= static_cast<double>(min) &&
      number <= static_cast<double>(max)) {
    return static_cast<std::int64_t>(number);
  }
  throw InputError(place,
                   fmt::format("{} is no whole number from {} to {}; write one", in_quotes(word), min, max));
}

std::optional<std::int32_t> decimals_of(std::string_view word) {
  if (word.find_first_of("eE") != word.npos) return std::nullopt;
  const std::size_t point = word.find('.');
  return point == word.npos ? 0 : static_cast<std::int32_t>(word.size() - point - 1);
}

void take_decimals(std::string_view word, bool is_first, BakedColumn& column) {
  const std::optional<std::int32_t> decimals = decimals_of(word);
  if (is_first || !decimals) {
    column.decimals = decimals;
  } else if (column.decimals) {
    column.decimals = std::max(*column.decimals, *decimals);
  }
}

void take_frame(std::int64_t frame, const Place& place, BakedTable& table) {
  if (!table.first_frame) table.first_frame = frame;
  const std::int64_t expected = *table.first_frame + static_cast<std::int64_t>(table.rows());
  if (frame == expected) return;
  table.first_frame = frame - static_cast<std::int64_t>(table.rows());  // the rows behind go on from here
  throw InputError(
      place,
      frame > expected
          ? fmt::format("frame {} follows frame {}; write the frames between them", frame, expected - 1)
          : fmt::format("frame {} follows frame {}; sort the rows, each frame once", frame, expected - 1));
}

void keep_place_of_row(std::uint32_t line, BakedTable& table) {
  table.lines.push_back(line);
  const std::size_t rows = table.lines.size();
  for (BakedColumn& column : table.columns) column.values.resize(rows, 0);
  if (!table.seconds.empty()) table.seconds.resize(rows, table.seconds.back());
}

void RowTaker::name_columns(std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    table_.columns.push_back({.name = fmt::format("column {}", i + 1)});
  }
  table_.has_names = false;
}

void RowTaker::take(std::uint32_t line, const std::vector<TextWord>& words) {
  const Place place{table_.file, line, 0};
  if (words.size() != table_.columns.size()) {
    throw InputError(place,
                     fmt::format("the row has {}, and the table has {}; write one number for each column",
                                 counted(static_cast<std::int64_t>(words.size()), "number"),
                                 counted(static_cast<std::int64_t>(table_.columns.size()), "column")));
  }
  if (table_.rows() == max_table_rows) {
    throw InputError(place, fmt::format("the file has more than {} rows; write it in parts", max_table_rows));
  }
  for (std::size_t i = 0; i < words.size(); ++i) {
    BakedColumn& column = table_.columns[i];
    const double value = table_number(words[i].text, {table_.file, line, words[i].column});
    take_decimals(words[i].text, column.values.empty(), column);
    column.values.push_back(value);
  }
  table_.lines.push_back(line);
}

void take_bare_rows(TextLines& lines, std::string_view comment, BakedTable& table) {
  RowTaker rows(table);
  WrongRows wrong(table.file);
  std::uint32_t empty_line = 0;  // the first one behind a row
  while (const std::optional<TextLine> line = lines.next()) {
    if (line->text.empty()) {
      if (empty_line == 0) empty_line = line->number;
      continue;
    }
    if (!comment.empty() &&
        line->text.substr(line->text.find_first_not_of(table_blanks)).starts_with(comment)) {
      continue;
    }
    if (empty_line != 0 && !table.lines.empty()) {
      throw InputError(
          {table.file, empty_line, 0},
          "the line is empty, and rows follow it; write the frame that is missing, or remove the line");
    }
    empty_line = 0;
    const auto words = words_of(line->text, max_table_columns);
    if (!words) {
      throw InputError({table.file, line->number, 0},
                       fmt::format("the row has more than {} numbers; leave out what is no axis of the rig",
                                   max_table_columns));
    }
    if (table.columns.empty()) rows.name_columns(words->size());
    wrong.judge([&] { rows.take(line->number, *words); }, [&] { keep_place_of_row(line->number, table); });
  }
  wrong.refuse();
}

std::string fixed_number(double value, std::int32_t decimals) {
  std::string text = fmt::format("{:.{}f}", value, decimals);
  const bool is_zero = text.find_first_not_of("-0.") == std::string::npos;
  if (is_zero && text.starts_with('-')) text.erase(0, 1);
  return text;
}

void check_written(const BakedTable& table, const TableWriting& writing) {
  if (writing.decimals < 0 || writing.decimals > max_decimals) {
    throw InputError({table.file}, fmt::format("{} decimals cannot be written; ask for 0 to {}",
                                               writing.decimals, max_decimals));
  }
  check_table(table);
  for (const BakedColumn& column : table.columns) {
    const auto bad = std::ranges::find_if(column.values,
                                          [](double value) { return !(std::fabs(value) <= max_magnitude); });
    if (bad == column.values.end()) continue;
    throw InputError(table.place_of(static_cast<std::size_t>(bad - column.values.begin())),
                     fmt::format("{} is at {} there, which is no position; correct the motion",
                                 in_quotes(column.name), *bad));
  }
}

const BakedColumn& written_column(const BakedTable& table, std::string_view name, std::string_view format) {
  for (const BakedColumn& column : table.columns) {
    if (lower_case(column.name) == lower_case(name)) return column;
  }
  throw InputError({table.file}, fmt::format("there is no column {}, which {} has; name the axis that it is",
                                             in_quotes(name), format));
}

}  // namespace inbetween
