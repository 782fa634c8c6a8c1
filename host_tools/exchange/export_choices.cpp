#include "host_tools/exchange/export_choices.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "host_tools/exchange/flair_carts.hpp"
#include "host_tools/exchange/kuper_ascii.hpp"
#include "host_tools/exchange/table_text.hpp"

namespace inbetween {
namespace {

/// How many of `to` one of `from` is; nothing where one is a length and the other is not.
std::optional<double> ratio_of_units(MoveUnit from, MoveUnit to) {
  if (from == to) return 1;
  if (from == MoveUnit::of_rig || to == MoveUnit::of_rig) return std::nullopt;
  for (const AxisUnit base : {AxisUnit::mm, AxisUnit::deg}) {
    const auto one = converted(1, from, base);
    const auto other = converted(1, to, base);
    if (one && other) return *one / *other;
  }
  return std::nullopt;
}

const BakedColumn& axis_column(const BakedTable& table, const std::string& name) {
  return named_column(table, name, fmt::format("no axis {} moves", in_quotes(name)));
}

std::vector<BakedColumn> chosen_columns(const BakedTable& table, const std::vector<AxisWord>& axes) {
  if (axes.empty()) return table.columns;
  std::vector<BakedColumn> columns;
  for (const AxisWord& word : axes) {
    if (word.is_left_out) {
      throw InputError({table.file}, fmt::format("column {} would be of no axis; name one, or leave it out",
                                                 in_quotes(word.column)));
    }
    BakedColumn& column = columns.emplace_back(axis_column(table, word.axis));
    column.name = word.column;
    if (!word.is_reversed) continue;
    for (double& value : column.values) value = 0 - value;  // and 0 stays 0
  }
  return columns;
}

void convert_column(BakedColumn& column, MoveUnit wanted, const std::string& file) {
  const auto ratio = ratio_of_units(column.unit.value_or(MoveUnit::of_rig), wanted);
  if (!ratio) {
    throw InputError({file},
                     fmt::format("{} counts in {}, which is not converted to {}; choose another unit",
                                 in_quotes(column.name), to_string(column.unit.value_or(MoveUnit::of_rig)),
                                 to_string(wanted)));
  }
  if (*ratio != 1) {
    for (double& value : column.values) value *= *ratio;
  }
  column.unit = wanted;
}

void convert_columns(BakedTable& table, const ExportChoices& choices) {
  for (BakedColumn& column : table.columns) {
    const auto own = std::ranges::find_if(
        choices.units, [&](const UnitWord& word) { return word.column && *word.column == column.name; });
    if (own != choices.units.end()) {
      if (own->unit != MoveUnit::of_rig) convert_column(column, own->unit, table.file);
      continue;
    }
    for (const UnitWord& word : choices.units) {
      const bool fits = !word.column && word.unit != MoveUnit::of_rig &&
                        ratio_of_units(column.unit.value_or(MoveUnit::of_rig), word.unit);
      if (fits) convert_column(column, word.unit, table.file);
    }
  }
  for (const CountWord& word : choices.counts) {
    const auto column = std::ranges::find(table.columns, word.column, &BakedColumn::name);
    if (column == table.columns.end()) continue;
    if (word.unit != MoveUnit::of_rig) convert_column(*column, word.unit, table.file);
    for (double& value : column->values) value = word.zero + value / word.count;
    column->unit.reset();
    column->is_in_counts = true;
  }
}

void check_words(const BakedTable& table, const ExportChoices& choices) {
  std::vector<std::string_view> names;
  for (const BakedColumn& column : table.columns) names.push_back(column.name);
  const auto check = [&](const std::string& name) {
    if (std::ranges::find(names, name) != names.end()) return;
    throw InputError({table.file}, fmt::format("the file would have no column {}; name one of {}",
                                               in_quotes(name), comma_separated(names)));
  };
  for (const UnitWord& word : choices.units) {
    if (word.column) check(*word.column);
  }
  for (const CountWord& word : choices.counts) check(word.column);
}

/// What a format holds.
struct Holds {
  bool rate = false, names = false, units = false, frames = false;
};
constexpr std::array<Holds, exchange_format_words.size()> held_by_format = {{
    {.names = true, .units = true, .frames = true},                // csv
    {},                                                            // raw-move
    {.names = true, .units = true, .frames = true},                // arcm
    {.names = true, .units = true, .frames = true},                // arcx
    {.names = true},                                               // kuper
    {.rate = true, .names = true, .units = true, .frames = true},  // flair
    {.names = true},                                               // maya-mov: as a comment
    {.names = true, .frames = true},                               // nuke-chan
    {.rate = true, .names = true},                                 // servo-json
    {.names = true},                                               // record
}};

/// Angles of a .chan file are in degrees.
std::string units_in_words(const BakedTable& table, bool is_chan) {
  std::vector<std::string> words;
  for (const BakedColumn& column : table.columns) {
    const bool is_fixed = is_chan && ratio_of_units(MoveUnit::deg, column.unit.value_or(MoveUnit::of_rig));
    if (column.is_in_counts || is_fixed) continue;
    words.push_back(fmt::format("{} in {}", column.name, to_string(column.unit.value_or(MoveUnit::of_rig))));
  }
  return comma_separated(words);
}

std::int32_t decimals_of_format(ExchangeFormat format, std::optional<std::int32_t> decimals) {
  if (decimals) return *decimals;
  if (format == ExchangeFormat::kuper) return kuper_decimals;
  return format == ExchangeFormat::flair ? flair_decimals : TableWriting{}.decimals;
}

}  // namespace

BakedTable exported_table(const BakedTable& table, const ExportChoices& choices) {
  BakedTable result = table;
  result.columns = chosen_columns(table, choices.axes);
  result.up = choices.up;
  for (const BakedColumn& column : table.columns) {
    const bool is_there = choices.axes.empty() ||
                          std::ranges::find(choices.axes, column.name, &AxisWord::axis) != choices.axes.end();
    if (is_there) continue;
    result.warnings.push_back(
        {{table.file},
         fmt::format("axis {} is not in the file: no --axis names it", in_quotes(column.name))});
  }
  check_words(result, choices);
  convert_columns(result, choices);
  check_table(result);
  return result;
}

std::vector<std::string> losses_of(ExchangeFormat format, const BakedTable& table,
                                   std::optional<std::int32_t> decimals) {
  const Holds holds = held_by_format.at(static_cast<std::size_t>(format));
  std::vector<std::string> losses;
  const auto lose = [&](std::string line) { losses.push_back(std::move(line)); };
  if (!holds.rate && table.fps) lose(fmt::format("no rate: {} rows a second", to_string(*table.fps)));
  const bool is_about = format == ExchangeFormat::flair && table.fps && table.fps->denominator != 1;
  if (is_about) lose(fmt::format("no exact rate: {} is written as a decimal", to_string(*table.fps)));
  if (!holds.names) {
    std::vector<std::string> names;
    for (const BakedColumn& column : table.columns) names.push_back(column.name);
    lose("no names: the columns are " + comma_separated(names));
  }
  const std::string units = units_in_words(table, format == ExchangeFormat::nuke_chan);
  if (!holds.units && !units.empty()) lose("no units: " + units);
  if (format == ExchangeFormat::nuke_chan) lose("no order of the rotations, and not which coordinate is up");
  if (!holds.frames)
    lose(fmt::format("no frame numbers: the first row is frame {}", table.first_frame.value_or(0)));
  lose(fmt::format("no phase: {}", table.phase == ShutterPhase::exposure_centre
                                       ? "a row is the middle of the exposure of its frame (centre)"
                                       : "a row is the boundary before its frame (boundary)"));
  if (format == ExchangeFormat::servo_json) {
    lose("no parts of a count: positions are rounded to whole numbers");
  } else {
    lose(fmt::format("no more than {} decimals", decimals_of_format(format, decimals)));
  }
  return losses;
}

}  // namespace inbetween
