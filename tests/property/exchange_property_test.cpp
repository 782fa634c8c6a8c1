// Every format brings back what was written into it, to the digits that it prints, and no damaged file is
// read as anything else than rows of finite numbers.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "host_tools/exchange/exchange_format.hpp"
#include "host_tools/exchange/record_table.hpp"
#include "host_tools/exchange/table_csv.hpp"
#include "host_tools/text/toml_value.hpp"
#include "tests/support/property.hpp"

namespace inbetween {
namespace exchange_property_test {

constexpr std::array written_formats = {
    ExchangeFormat::csv,   ExchangeFormat::raw_move, ExchangeFormat::arc_move,  ExchangeFormat::kuper,
    ExchangeFormat::flair, ExchangeFormat::maya_mov, ExchangeFormat::nuke_chan, ExchangeFormat::servo_json};

int whole(std::mt19937_64& random, int low, int high) {
  return std::uniform_int_distribution<int>(low, high)(random);
}

/// Of any size, also whole, 0, and so small that few digits show it.
double random_value(std::mt19937_64& random) {
  const double value =
      std::uniform_real_distribution<double>(-1, 1)(random) * std::pow(10.0, whole(random, -8, 8));
  switch (whole(random, 0, 5)) {
    case 0:
      return std::round(value);
    case 1:
      return whole(random, 0, 1) == 0 ? 0.0 : -0.0;
    default:
      return value;
  }
}

BakedColumn random_column(std::mt19937_64& random, std::string name, std::size_t rows) {
  BakedColumn column{.name = std::move(name)};
  for (std::size_t row = 0; row < rows; ++row) column.values.push_back(random_value(random));
  return column;
}

std::vector<std::string> names_of(ExchangeFormat format, std::mt19937_64& random) {
  if (format == ExchangeFormat::flair) return {"ROLL", "XV", "YV", "ZV", "XT", "YT", "ZT"};
  if (format == ExchangeFormat::nuke_chan) {
    std::vector<std::string> names = {"tx", "ty", "tz", "rx", "ry", "rz"};
    if (whole(random, 0, 1) == 0) names.emplace_back("vfov");
    return names;
  }
  std::vector<std::string> names;
  const int count = whole(random, 1, 9);
  const std::vector<std::string> odd = {"pan (left)", "\"quoted\"", "über & <unter>",
                                        "two words",  "a;b",        "x'y"};
  for (int i = 0; i < count; ++i) {
    names.push_back(fmt::format("{} {}", odd[static_cast<std::size_t>(whole(random, 0, 5))], i));
    if (format == ExchangeFormat::csv && whole(random, 0, 3) == 0) names.back() = fmt::format("a,\nb\t{}", i);
  }
  return names;
}

BakedTable random_table(ExchangeFormat format, std::mt19937_64& random) {
  BakedTable table{.file = "table"};
  const auto rows = static_cast<std::size_t>(whole(random, 2, 30));
  const std::vector<std::string> names = names_of(format, random);
  const MoveUnit lengths = whole(random, 0, 1) == 0 ? MoveUnit::cm : MoveUnit::m;
  for (const std::string& name : names) {
    BakedColumn& column = table.columns.emplace_back(random_column(random, name, rows));
    const bool is_length = name.size() == 2 && name != "rx" && name != "ry" && name != "rz";
    if (format == ExchangeFormat::flair) column.unit = is_length ? lengths : MoveUnit::deg;
    if (format == ExchangeFormat::nuke_chan && !is_length) column.unit = MoveUnit::deg;
    if (format == ExchangeFormat::csv) column.unit = static_cast<MoveUnit>(whole(random, 0, 8));
    if (format == ExchangeFormat::arc_move) column.unit = MoveUnit::inch;
  }
  table.fps = FrameRate{whole(random, 1, 120), 1};
  table.first_frame = whole(random, -1000, 1000);
  table.up = UpAxis::z;
  return table;
}

/// How far a number may be off that was written with so many decimals.
double printed_precision(double value, int decimals) {
  return 0.5 * std::pow(10.0, -decimals) * (1 + 1e-9) + 4e-16 * std::fabs(value);
}

const BakedColumn& column_of(const BakedTable& table, const BakedTable& original, std::size_t index) {
  if (!table.has_names) return table.columns.at(index);
  const auto found = std::ranges::find(table.columns, original.columns[index].name, &BakedColumn::name);
  RC_ASSERT(found != table.columns.end());
  return *found;
}

TEST(ExchangeProperty, WhatIsWrittenIsReadToThePrintedDigits) {
  check_property(8'000, [](std::uint64_t seed) {
    std::mt19937_64 random(seed);
    const ExchangeFormat format = *rc::gen::elementOf(written_formats);
    const BakedTable table = random_table(format, random);
    const int decimals = format == ExchangeFormat::servo_json ? 0 : whole(random, 0, 12);
    const std::string text = write_baked_table(format, table, decimals);
    RC_LOG() << to_string(format) << "\n" << text;
    const BakedTable back = read_baked_table(format, text, "file");
    RC_ASSERT(back.columns.size() == table.columns.size());
    RC_ASSERT(back.rows() == table.rows());
    for (std::size_t i = 0; i < table.columns.size(); ++i) {
      const BakedColumn& column = column_of(back, table, i);
      for (std::size_t row = 0; row < table.rows(); ++row) {
        const double value = table.columns[i].values[row];
        RC_ASSERT(std::fabs(column.values[row] - value) <= printed_precision(value, decimals));
      }
      if (back.has_names && table.columns[i].unit) RC_ASSERT(column.unit == table.columns[i].unit);
    }
    if (back.first_frame) RC_ASSERT(back.first_frame == table.first_frame);
    if (back.fps) RC_ASSERT(back.fps == table.fps);
  });
}

TEST(ExchangeProperty, AFormatIsKnownByWhatItWrites) {
  check_property(2'000, [](std::uint64_t seed) {
    std::mt19937_64 random(seed);
    const ExchangeFormat format = *rc::gen::elementOf(written_formats);
    const std::string text = write_baked_table(format, random_table(format, random));
    RC_LOG() << text;
    const std::array<const char*, 10> extensions = {"csv", "txt", "arcm", "arcx", "txt",
                                                    "txt", "mov", "chan", "json", "csv"};
    const std::string file = std::string("a.") + extensions.at(static_cast<std::size_t>(format));
    try {
      RC_ASSERT(exchange_format_of(file, text) == format);
    } catch (const InputError&) {
      // Seven whole numbers that begin with 1 and 2 may be a .chan file with another name.
      RC_ASSERT(format == ExchangeFormat::raw_move);
    }
  });
}

/// A character away, another in its place, one more, or the end cut off.
std::string damaged(std::string text, std::mt19937_64& random) {
  constexpr std::string_view letters = "0123456789.,-+eE \t\n\r\"#<>{}[]:=naN";
  const int times = whole(random, 1, 4);
  for (int i = 0; i < times && !text.empty(); ++i) {
    const auto at = std::uniform_int_distribution<std::size_t>(0, text.size() - 1)(random);
    const char letter = letters[std::uniform_int_distribution<std::size_t>(0, letters.size() - 1)(random)];
    switch (whole(random, 0, 8)) {
      case 0:
        text.resize(at);
        break;
      case 1:
      case 2:
      case 3:
        text.erase(at, 1);
        break;
      case 4:
      case 5:
        text.insert(at, 1, letter);
        break;
      default:
        text[at] = letter;
    }
  }
  return text;
}

void assert_sound(const BakedTable& table) {
  RC_ASSERT(table.rows() >= 2);
  for (const BakedColumn& column : table.columns) {
    RC_ASSERT(column.values.size() == table.rows());
    for (const double value : column.values) RC_ASSERT(std::fabs(value) <= max_magnitude);
  }
  RC_ASSERT(table.lines.empty() || table.lines.size() == table.rows());
  RC_ASSERT(table.seconds.empty() || table.seconds.size() == table.rows());
}

TEST(ExchangeProperty, ADamagedFileIsATableOrARefusalAtALineOfIt) {
  check_property(20'000, [](std::uint64_t seed) {
    std::mt19937_64 random(seed);
    const ExchangeFormat format = *rc::gen::elementOf(written_formats);
    const std::string text = damaged(write_baked_table(format, random_table(format, random), 3), random);
    RC_LOG() << text;
    const auto lines = 2 + static_cast<std::uint32_t>(
                               std::ranges::count_if(text, [](char c) { return c == '\n' || c == '\r'; }));
    try {
      assert_sound(read_baked_table(format, text, "file"));
    } catch (const InputError& error) {
      RC_ASSERT(error.place().file == "file");
      RC_ASSERT(error.place().line <= lines);
      RC_ASSERT(error.message().find(';') != std::string::npos || error.message().find("not valid XML") == 0);
    }
  });
}

TEST(ExchangeProperty, ARecordIsReadToItsLastBit) {
  check_property(2'000, [](std::uint64_t seed) {
    std::mt19937_64 random(seed);
    const int axes = whole(random, 1, 5);
    const int before = whole(random, 0, 5);
    const int played = whole(random, 2, 60);
    const int rate = whole(random, 1, 1000);
    std::string text = "tick,seconds,state,frame";
    for (int a = 0; a < axes; ++a) text += fmt::format(",axis {0},axis {0} actual", a);
    std::vector<std::vector<double>> told(static_cast<std::size_t>(axes));
    for (int tick = 0; tick < before + played + 3; ++tick) {
      const bool is_played = tick >= before && tick < before + played;
      text += fmt::format("\n{},{:.6f},moving,{}", tick, static_cast<double>(tick) / rate,
                          is_played ? fmt::format("{:.6f}", tick * 0.1) : "");
      for (std::vector<double>& axis : told) {
        const double value = random_value(random);
        if (is_played) axis.push_back(value);
        text += is_played ? fmt::format(",{},{}", value, random_value(random)) : fmt::format(",,{}", value);
      }
    }
    RC_LOG() << text;
    const BakedTable table = read_record_table(text + "\n", "file");
    RC_ASSERT(table.columns.size() == told.size());
    for (std::size_t a = 0; a < told.size(); ++a) RC_ASSERT(table.columns[a].values == told[a]);
    if (table.fps) RC_ASSERT(*table.fps == (FrameRate{rate, 1}));
  });
}

}  // namespace exchange_property_test
}  // namespace inbetween
