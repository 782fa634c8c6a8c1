#include "host_tools/cli/run_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstddef>
#include <cstring>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "host_tools/text/csv_table.hpp"
#include "host_tools/text/diagnostics.hpp"

namespace inbetween {
namespace {

/// Takes the number before the next comma off the text; nothing where there is none.
std::optional<double> take_number(std::string_view& text) {
  const std::string_view cell = text.substr(0, text.find(','));
  text.remove_prefix(std::min(cell.size() + 1, text.size()));
  double number = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), number);
  if (error != std::errc() || end != cell.data() + cell.size()) return std::nullopt;
  return number;
}

struct LastTick {
  double number = -1;
  std::vector<std::optional<double>> told;
};

/// A line of the record: tick, seconds, state, frame, and for each axis what it was told and where it was.
bool take_tick(std::string_view line, bool has_frames, RunPlot& plot, LastTick& last) {
  const std::optional<double> number = take_number(line);
  const std::optional<double> seconds = take_number(line);
  take_number(line);  // the state is words
  if (has_frames) take_number(line);
  if (!number || !seconds) return false;
  const bool is_next = *number == last.number + 1;
  for (std::size_t a = 0; a < plot.axes.size(); ++a) {
    const std::optional<double> told = take_number(line);
    const std::optional<double> actual = take_number(line);
    if (!actual) return false;
    RunPlotAxis& axis = plot.axes[a];
    if (told) axis.commanded.push_back({*seconds, *told});
    if (!axis.commanded.empty()) axis.actual.push_back({*seconds, *actual});
    // At the beginning of a tick a drive answers the setpoint before.
    if (told && is_next && last.told[a]) axis.following_error.push_back({*seconds, *last.told[a] - *actual});
    last.told[a] = told;
  }
  last.number = *number;
  return line.empty();
}

constexpr std::array<std::string_view, 3> first_columns{"tick", "seconds", "state"};
constexpr std::string_view no_record =
    "this is no record of inbetween run; name one that --record has written";

/// Says which line of a record is wrong, and why.
[[noreturn]] void refuse(const std::string& record, std::int64_t line, std::string_view what) {
  throw std::runtime_error(fmt::format("{}:{}: error: {}", record, line, what));
}

/// Makes the axes that the first line names. Returns whether it has a column of frames.
bool take_head(const std::string& line, const std::string& record, RunPlot& plot) {
  const std::vector<std::string> columns =
      line.empty() ? std::vector<std::string>() : parse_csv(line, record).columns;
  if (columns.size() < first_columns.size() + 2 ||
      !std::equal(first_columns.begin(), first_columns.end(), columns.begin())) {
    refuse(record, 1, no_record);
  }
  const std::size_t of_axes = columns.size() - first_columns.size();
  const bool has_frames = of_axes % 2 == 1;  // every axis has two
  for (std::size_t c = first_columns.size() + (has_frames ? 1 : 0); c < columns.size(); c += 2) {
    if (columns[c + 1] != columns[c] + " actual") refuse(record, 1, no_record);
    plot.axes.push_back({.name = columns[c], .unit = ""});
  }
  return has_frames;
}

void take_units(const RigFile& rig, const std::string& record, RunPlot& plot) {
  for (RunPlotAxis& axis : plot.axes) {
    const auto on_rig = std::ranges::find(rig.axes, axis.name, &RigAxis::name);
    if (on_rig == rig.axes.end()) {
      refuse(record, 1,
             fmt::format("the rig {} has no axis {}; name the rig that was recorded", in_quotes(rig.name),
                         in_quotes(axis.name)));
    }
    axis.unit = to_string(on_rig->unit);
  }
}

}  // namespace

ReadRecord read_record(const std::string& record, const RigFile* rig) {
  std::ifstream file(record);
  if (!file) {
    throw std::runtime_error(fmt::format("{}: error: cannot be read: {}; name a record that is there", record,
                                         std::strerror(errno)));
  }
  ReadRecord read;
  std::string line;
  std::getline(file, line);
  const bool has_frames = take_head(line, record, read.plot);
  if (rig != nullptr) take_units(*rig, record, read.plot);
  LastTick last{.told = std::vector<std::optional<double>>(read.plot.axes.size())};
  // A line without an end was cut off when the disk was full.
  while (std::getline(file, line) && !file.eof()) {
    if (!take_tick(line, has_frames, read.plot, last)) refuse(record, read.ticks + 2, no_record);
    ++read.ticks;
  }
  return read;
}

}  // namespace inbetween
