#include "host_tools/exchange/kuper_ascii.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host_tools/exchange/wrong_rows.hpp"
#include "host_tools/text/ini_sections.hpp"

namespace inbetween {
namespace {

constexpr std::string_view kuper_head = "the first line names the axes; write it as in Axes = vTrack, vPan";

/// The text behind "Axes =".
std::string_view kuper_names(const TextLine& line, const std::string& file) {
  const std::size_t equals = line.text.find('=');
  if (equals == line.text.npos || lower_case(trimmed(line.text.substr(0, equals))) != "axes") {
    throw InputError({file, line.number, 1}, std::string(kuper_head));
  }
  return line.text.substr(equals + 1);
}

void take_kuper_names(const TextLine& line, BakedTable& table) {
  std::string_view rest = kuper_names(line, table.file);
  for (bool is_last = false; !is_last;) {
    const std::size_t comma = rest.find(',');
    is_last = comma == rest.npos;
    const std::string_view name = trimmed(rest.substr(0, comma));
    if (name.empty()) {
      throw InputError(
          {table.file, line.number, 0},
          fmt::format("axis {} has no name; write one between the commas", table.columns.size() + 1));
    }
    if (table.columns.size() == max_table_columns) {
      throw InputError({table.file, line.number, 0},
                       fmt::format("the line names more than {} axes; leave some out", max_table_columns));
    }
    table.columns.push_back({.name = std::string(name)});
    if (!is_last) rest.remove_prefix(comma + 1);
  }
}

void take_kuper_row(const TextLine& line, RowTaker& rows, BakedTable& table) {
  const auto words = words_of(line.text, max_table_columns + 1, " \t,");
  const bool is_right = words && words->size() == table.columns.size();
  if (!is_right && line.text.find(',') != line.text.npos) {
    throw InputError({table.file, line.number, 0},
                     fmt::format("the row has not one number for each of {}; write them with blanks between, "
                                 "and a decimal with a point",
                                 counted(static_cast<std::int64_t>(table.columns.size()), "axis name")));
  }
  rows.take(line.number, words.value_or(std::vector<TextWord>(max_table_columns + 1)));
}

}  // namespace

BakedTable read_kuper_ascii(std::string_view text, const std::string& file) {
  BakedTable table{.file = file};
  TextLines lines(text, file);
  std::optional<TextLine> line = lines.next();
  while (line && line->text.empty()) line = lines.next();
  if (!line) throw InputError({file}, "the file is empty; " + std::string(kuper_head));
  take_kuper_names(*line, table);
  RowTaker rows(table);
  WrongRows wrong(file);
  while ((line = lines.next())) {
    if (line->text.empty()) continue;
    wrong.judge([&] { take_kuper_row(*line, rows, table); }, [&] { keep_place_of_row(line->number, table); });
  }
  wrong.refuse();
  check_table(table);
  return table;
}

std::string write_kuper_ascii(const BakedTable& table, const TableWriting& writing) {
  check_written(table, writing);
  std::string text = "Axes = ";
  for (const BakedColumn& column : table.columns) {
    const bool is_plain = column.name.find_first_of(",\r\n") == std::string::npos && !column.name.empty() &&
                          trimmed(column.name) == column.name;
    if (!is_plain) {
      throw InputError({table.file}, fmt::format("{} cannot be a name in a Kuper file, where commas and line "
                                                 "ends are between names; rename it",
                                                 in_quotes(column.name)));
    }
    if (&column != &table.columns.front()) text += ", ";
    text += column.name;
  }
  text += "\r\n";
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const char* between = "";
    for (const BakedColumn& column : table.columns) {
      text += between + fmt::format("{:>10}", fixed_number(column.values[row], writing.decimals));
      between = " ";
    }
    text += "\r\n";
  }
  return text;
}

}  // namespace inbetween
