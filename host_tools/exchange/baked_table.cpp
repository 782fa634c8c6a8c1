#include "host_tools/exchange/baked_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>

#include "host_tools/text/spelling.hpp"

namespace inbetween {
namespace {

constexpr double max_rows_a_second = 1'000;  // as `fps` of a move

void ask_of_columns(const BakedTable& table, std::vector<TableQuestion>& questions) {
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    const BakedColumn& column = table.columns[i];
    if (column.unit || column.is_in_counts) continue;
    questions.push_back(
        {TableAsks::unit, i, fmt::format("in what unit does {} count?", in_quotes(column.name))});
  }
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    if (!table.columns[i].is_in_counts) continue;
    questions.push_back(
        {TableAsks::count, i,
         fmt::format("which count of {} is the 0 of its axis, how far is it to the next, and in what unit?",
                     in_quotes(table.columns[i].name))});
  }
}

/// How far two printed times may be off from what a rate makes of them.
double room_of(const BakedTable& table, double seconds) {
  constexpr double rounding = 1e-12;  // of sums of a million steps, in last bits
  return 2 * table.seconds_rounding + rounding * std::fabs(seconds);
}

/// Of rows that have times: as far from each other as the first two are.
void check_even(const BakedTable& table) {
  const std::vector<double>& seconds = table.seconds;
  const std::size_t last = seconds.size() - 1;
  const double step = (seconds[last] - seconds[0]) / static_cast<double>(last);
  for (std::size_t row = 1; row <= last; ++row) {
    if (!(seconds[row] > seconds[row - 1])) {
      throw InputError(table.place_of(row),
                       fmt::format("{} s are not behind {} s of the row before; sort the rows, or leave out "
                                   "those that are there twice",
                                   seconds[row], seconds[row - 1]));
    }
  }
  const double first_step = seconds[1] - seconds[0];
  const double room = room_of(table, seconds[last]);
  for (std::size_t row = 1; row <= last; ++row) {
    const double expected = seconds[0] + step * static_cast<double>(row);
    const double apart = seconds[row] - seconds[row - 1];
    const bool is_even = std::fabs(seconds[row] - expected) <= room || std::fabs(apart - first_step) <= room;
    if (is_even) continue;
    throw InputError(table.place_of(row),
                     fmt::format("the row is {:.6g} s behind the row before, and the second row is {:.6g} s "
                                 "behind the first; write all rows at one rate",
                                 apart, first_step));
  }
}

}  // namespace

Place BakedTable::place_of(std::size_t row) const {
  return {file, row < lines.size() ? lines[row] : 0, 0};
}

const BakedColumn& named_column(const BakedTable& table, const std::string& name,
                                const std::string& missing) {
  const auto found = std::ranges::find(table.columns, name, &BakedColumn::name);
  if (found != table.columns.end()) return *found;
  std::vector<std::string_view> names;
  for (const BakedColumn& column : table.columns) names.push_back(column.name);
  const auto meant = probably_meant(name, names);
  throw InputError({table.file}, meant ? fmt::format("{}; did you mean {}?", missing, in_quotes(*meant))
                                       : fmt::format("{}; name one of {}", missing, comma_separated(names)));
}

std::string to_string(const FrameRate& fps) {
  if (fps.denominator == 1) return fmt::format("{}", fps.numerator);
  return fmt::format("{}/{}", fps.numerator, fps.denominator);
}

bool is_about(double decimal, const FrameRate& fps) {
  constexpr double off = 0.005;  // half a hundredth: rates are written with two decimals or more
  return std::fabs(decimal - fps.frames_per_second()) <= off;
}

void take_rate(double rate, const Place& place, BakedTable& table) {
  if (!(rate > 0) || rate > max_rows_a_second) {
    throw InputError(place, fmt::format("{} frames a second are none; write a rate above 0, at most {:g}",
                                        rate, max_rows_a_second));
  }
  if (rate == std::floor(rate)) {
    table.fps = FrameRate{static_cast<std::int32_t>(rate), 1};
  } else {
    table.about_fps = rate;
  }
}

std::vector<TableQuestion> questions_of(const BakedTable& table) {
  std::vector<TableQuestion> questions;
  if (!table.fps) {
    questions.push_back({TableAsks::fps,
                         {},
                         table.about_fps ? fmt::format("the file says about {} frames a second; which exact "
                                                       "rate is that, as \"24000/1001\" is about 23.976?",
                                                       *table.about_fps)
                                         : std::string("how many rows does a second have?")});
  }
  if (!table.has_names) questions.push_back({TableAsks::names, {}, "which axis is each column?"});
  ask_of_columns(table, questions);
  if (table.is_in_space && !table.up) {
    questions.push_back({TableAsks::up_axis, {}, "which coordinate points up, y or z?"});
  }
  if (table.has_euler_angles) {
    questions.push_back({TableAsks::rotation_order,
                         {},
                         "about which axes do the angles turn, one after the other: ZXY, say?"});
  }
  if (table.has_exposures && !table.phase) {
    questions.push_back({TableAsks::phase,
                         {},
                         "is a row the middle of the exposure of its frame (centre), or the boundary before "
                         "it, where the shutter is closed (boundary)?"});
  }
  return questions;
}

void check_table(const BakedTable& table) {
  if (table.columns.empty()) {
    throw InputError({table.file}, "the file has no column of positions; add one for each axis");
  }
  std::map<std::string, std::size_t> names;
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    const BakedColumn& column = table.columns[i];
    const auto [earlier, is_new] = names.emplace(column.name, i);
    if (!is_new) {
      throw InputError({table.file}, fmt::format("columns {} and {} are both called {}; rename one of them",
                                                 earlier->second + 1, i + 1, in_quotes(column.name)));
    }
    if (column.values.size() == table.rows()) continue;
    throw InputError({table.file},
                     fmt::format("{} has {}, and {} has {}; write one for each frame", in_quotes(column.name),
                                 counted(static_cast<std::int64_t>(column.values.size()), "position"),
                                 in_quotes(table.columns.front().name), table.rows()));
  }
  if (table.rows() < 2) {
    throw InputError({table.file}, fmt::format("the file has {}; a motion has two or more",
                                               counted(static_cast<std::int64_t>(table.rows()), "row")));
  }
  if (!table.seconds.empty()) check_even(table);
}

void check_seconds(const BakedTable& table, const FrameRate& fps) {
  for (std::size_t row = 1; row < table.seconds.size(); ++row) {
    const double expected = static_cast<double>(row) * fps.denominator / fps.numerator;
    const double found = table.seconds[row] - table.seconds[0];
    if (std::fabs(found - expected) <= room_of(table, table.seconds[row])) continue;
    throw InputError(table.place_of(row),
                     fmt::format("the row is {:.6g} s behind the first, and at {} rows a second it would be "
                                 "{:.6g} s; give the rate of the file",
                                 found, to_string(fps), expected));
  }
}

}  // namespace inbetween
