#include "host_tools/exchange/nuke_chan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

#include "host_tools/exchange/wrong_rows.hpp"
#include "host_tools/text/ini_sections.hpp"

namespace inbetween {
namespace {

constexpr std::array<std::string_view, 7> chan_columns = {"tx", "ty", "tz", "rx", "ry", "rz", "vfov"};
constexpr std::size_t chan_lengths = 3;  // the first columns; the others are angles

void begin_chan_columns(std::size_t words, const Place& place, BakedTable& table) {
  if (words != chan_columns.size() && words != chan_columns.size() + 1) {
    throw InputError(place,
                     fmt::format("the row has {}; write frame tx ty tz rx ry rz, and vfov for a camera",
                                 counted(static_cast<std::int64_t>(words), "number")));
  }
  for (std::size_t i = 0; i + 1 < words; ++i) {
    BakedColumn& column = table.columns.emplace_back();
    column.name = chan_columns[i];
    if (i >= chan_lengths) column.unit = MoveUnit::deg;
  }
}

}  // namespace

BakedTable read_nuke_chan(std::string_view text, const std::string& file) {
  BakedTable table{.file = file};
  table.is_in_space = true;
  table.has_euler_angles = true;
  TextLines lines(text, file);
  RowTaker rows(table);
  WrongRows wrong(file);
  while (const std::optional<TextLine> line = lines.next()) {
    auto words = words_of(line->text, max_table_columns);
    const Place place{file, line->number, 0};
    if (words && (words->empty() || words->front().text.starts_with('#'))) continue;
    if (!words || table.columns.empty())
      begin_chan_columns(words ? words->size() : max_table_columns, place, table);
    const Place at_frame{file, line->number, words->front().column};
    const auto take = [&] {
      take_frame(table_whole_number(words->front().text, at_frame, -max_table_frame, max_table_frame),
                 at_frame, table);
      words->erase(words->begin());
      rows.take(line->number, *words);
    };
    wrong.judge(take, [&] { keep_place_of_row(line->number, table); });
  }
  wrong.refuse();
  check_table(table);
  return table;
}

std::string write_nuke_chan(const BakedTable& table, const TableWriting& writing) {
  check_written(table, writing);
  std::vector<const BakedColumn*> columns;
  for (const std::string_view name : chan_columns) {
    const bool is_there = std::ranges::any_of(
        table.columns, [&](const BakedColumn& column) { return lower_case(column.name) == name; });
    if (!is_there && name == chan_columns.back()) continue;
    columns.push_back(&written_column(table, name, "a .chan file"));
    const bool is_angle = columns.size() > chan_lengths;
    if (!is_angle || columns.back()->unit == MoveUnit::deg) continue;
    throw InputError({table.file}, fmt::format("{} is not in degrees, as it is in a .chan file; convert it",
                                               in_quotes(columns.back()->name)));
  }
  std::string text;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    text += fmt::format("{}", table.first_frame.value_or(1) + static_cast<std::int64_t>(row));
    for (const BakedColumn* column : columns) {
      text += '\t' + fixed_number(column->values[row], writing.decimals);
    }
    text += '\n';
  }
  return text;
}

}  // namespace inbetween
