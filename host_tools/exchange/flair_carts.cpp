#include "host_tools/exchange/flair_carts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "host_tools/exchange/wrong_rows.hpp"
#include "host_tools/text/ini_sections.hpp"

namespace inbetween {
namespace {

constexpr std::array<std::string_view, 7> flair_columns = {"XV", "YV", "ZV", "XT", "YT", "ZT", "ROLL"};
constexpr std::size_t flair_lengths = 6;  // the first columns; the last one is an angle
constexpr std::string_view flair_kind_example = "DATA_TYPE CARTS_RAW MRMC_COORDS IN_CENTIMETRES";

/// The words of the next line that says something.
struct FlairLine {
  std::uint32_t number = 0;
  std::vector<TextWord> words;
};

class FlairReader {
 public:
  FlairReader(std::string_view text, const std::string& file) : lines_(text, file), table_{.file = file} {}

  BakedTable read() {
    read_kind();
    read_points();
    read_heading();
    for (std::int64_t i = 0; i < points_; ++i) read_row();
    wrong_.refuse();
    if (const auto more = next(); more) {
      table_.warnings.push_back(
          {place_of(*more), fmt::format("what stands behind {} rows is not read; POINTS "
                                        "says that there are no more",
                                        points_)});
    }
    table_.is_in_space = true;
    table_.up = UpAxis::z;
    check_table(table_);
    return std::move(table_);
  }

 private:
  [[nodiscard]] Place place_of(const FlairLine& line, std::size_t word = 0) const {
    return {table_.file, line.number, word < line.words.size() ? line.words[word].column : 0};
  }

  std::optional<FlairLine> next() {
    while (const std::optional<TextLine> line = lines_.next()) {
      auto words = words_of(line->text, max_table_columns);
      if (!words) {
        throw InputError({table_.file, line->number, 0},
                         fmt::format("the line has more than {} words; leave some out", max_table_columns));
      }
      if (words->empty() || words->front().text.starts_with('#')) continue;
      return FlairLine{line->number, std::move(*words)};
    }
    return std::nullopt;
  }
  FlairLine required(std::string_view example) {
    std::optional<FlairLine> line = next();
    if (!line) throw InputError({table_.file}, fmt::format("the file ends here; write {}", example));
    return std::move(*line);
  }
  static bool is(const TextWord& word, std::string_view name) {
    return lower_case(word.text) == lower_case(name);
  }

  void read_kind() {
    const FlairLine line = required(flair_kind_example);
    const auto& words = line.words;
    if (words.size() != 4 || !is(words[0], "DATA_TYPE") || !is(words[1], "CARTS_RAW") ||
        !is(words[2], "MRMC_COORDS")) {
      throw InputError(place_of(line), fmt::format("this is not how Flair's Cartesian points begin; write {}",
                                                   flair_kind_example));
    }
    if (is(words[3], "IN_METRES")) {
      unit_ = MoveUnit::m;
    } else if (!is(words[3], "IN_CENTIMETRES")) {
      throw InputError(place_of(line, 3), fmt::format("{} is no unit; write IN_CENTIMETRES or IN_METRES",
                                                      in_quotes(words[3].text)));
    }
  }

  void read_points() {
    const FlairLine line = required("POINTS 240 SPEED 24");
    const auto& words = line.words;
    if (words.size() != 4 || !is(words[0], "POINTS") || !is(words[2], "SPEED")) {
      throw InputError(place_of(line),
                       "here stands how many rows there are, and the rate; write POINTS 240 SPEED 24");
    }
    points_ =
        table_whole_number(words[1].text, place_of(line, 1), 2, static_cast<std::int64_t>(max_table_rows));
    take_rate(table_number(words[3].text, place_of(line, 3)), place_of(line, 3), table_);
  }

  void read_heading() {
    const FlairLine line = required("FRAME XV YV ZV XT YT ZT ROLL");
    for (std::size_t i = 0; i < line.words.size(); ++i) {
      if (is(line.words[i], "FRAME")) {
        if (frame_) throw InputError(place_of(line, i), "FRAME is there twice; name each column once");
        frame_ = i;
        continue;
      }
      table_.columns.push_back({.name = name_of(line.words[i].text)});
    }
    if (!frame_)
      throw InputError(place_of(line), "the column FRAME is missing; write its number before each row");
    for (const std::string_view name : flair_columns) {
      const auto found = std::ranges::find(table_.columns, name, &BakedColumn::name);
      if (found == table_.columns.end()) {
        throw InputError(
            {table_.file, line.number, 0},
            fmt::format("the column {} is missing; write FRAME {}", name, fmt::join(flair_columns, " ")));
      }
      found->unit = name == flair_columns.back() ? MoveUnit::deg : unit_;
    }
  }
  /// Those of the format in capitals.
  static std::string name_of(std::string_view heading) {
    const auto known = std::ranges::find_if(
        flair_columns, [&](std::string_view name) { return lower_case(name) == lower_case(heading); });
    return std::string(known == flair_columns.end() ? heading : *known);
  }

  void read_row() {
    std::optional<FlairLine> line = next();
    if (!line) {
      throw InputError({table_.file},
                       fmt::format("the file has {}, and POINTS says {}; correct POINTS, or write "
                                   "the rows that are missing",
                                   counted(static_cast<std::int64_t>(table_.rows()), "row"), points_));
    }
    wrong_.judge([&] { take_row(*line); }, [&] { keep_place_of_row(line->number, table_); });
  }

  void take_row(FlairLine& line) {
    for (TextWord& word : line.words) {
      if (word.text.ends_with(',')) word.text.remove_suffix(1);
    }
    if (line.words.size() != table_.columns.size() + 1) {
      throw InputError({table_.file, line.number, 0},
                       fmt::format("the row has {}, and the heading names {}; write one for each column",
                                   counted(static_cast<std::int64_t>(line.words.size()), "number"),
                                   table_.columns.size() + 1));
    }
    const Place at_frame = place_of(line, *frame_);
    take_frame(table_whole_number(line.words[*frame_].text, at_frame, -max_table_frame, max_table_frame),
               at_frame, table_);
    line.words.erase(line.words.begin() + static_cast<std::ptrdiff_t>(*frame_));
    RowTaker(table_).take(line.number, line.words);
  }

  TextLines lines_;
  BakedTable table_;
  WrongRows wrong_{table_.file};
  MoveUnit unit_ = MoveUnit::cm;
  std::int64_t points_ = 0;
  std::optional<std::size_t> frame_ = {};
};

/// The unit of all positions.
MoveUnit flair_unit(const BakedTable& table, const std::vector<const BakedColumn*>& columns) {
  const std::optional<MoveUnit> unit = columns.front()->unit;
  for (std::size_t i = 0; i < flair_lengths; ++i) {
    const bool is_right = unit == columns[i]->unit && (unit == MoveUnit::cm || unit == MoveUnit::m);
    if (!is_right) {
      throw InputError({table.file},
                       fmt::format("{} is not in the unit of all; give all positions in cm, or in m",
                                   in_quotes(columns[i]->name)));
    }
  }
  return *unit;
}

/// 25, and 23.976 for 24000/1001.
std::string flair_speed(const FrameRate& fps) {
  return fps.denominator == 1 ? to_string(fps) : fmt::format("{:.3f}", fps.frames_per_second());
}

}  // namespace

BakedTable read_flair_carts(std::string_view text, const std::string& file) {
  return FlairReader(text, file).read();
}

std::string write_flair_carts(const BakedTable& table, const TableWriting& writing) {
  check_written(table, writing);
  std::vector<const BakedColumn*> columns;
  columns.reserve(flair_columns.size());
  for (const std::string_view name : flair_columns) {
    columns.push_back(&written_column(table, name, "a Flair file"));
  }
  const MoveUnit unit = flair_unit(table, columns);
  if (columns.back()->unit != MoveUnit::deg) {
    throw InputError({table.file}, "\"ROLL\" is not in degrees, as it is in a Flair file; convert it");
  }
  if (table.up != UpAxis::z) {
    throw InputError({table.file},
                     "z is up in a Flair file; say which coordinate is up, and turn y up to z up");
  }
  if (!table.fps) throw InputError({table.file}, "a Flair file has a rate; say how many rows a second has");
  std::string text = fmt::format("DATA_TYPE  CARTS_RAW  MRMC_COORDS  {}\nPOINTS {}  SPEED {}\nFRAME",
                                 unit == MoveUnit::m ? "IN_METRES" : "IN_CENTIMETRES", table.rows(),
                                 flair_speed(*table.fps));
  for (const std::string_view name : flair_columns) text += fmt::format(" {:>10}", name);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    text += fmt::format("\n{:>4}", table.first_frame.value_or(1) + static_cast<std::int64_t>(row));
    for (const BakedColumn* column : columns) {
      // Numbers that fill their width have a blank before them all the same.
      text += fmt::format(" {:>10}", fixed_number(column->values[row], writing.decimals));
    }
  }
  return text + "\n";
}

}  // namespace inbetween
