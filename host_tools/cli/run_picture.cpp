#include "host_tools/cli/run_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <vector>

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

/// A line of the record: tick, seconds, state, and for each axis what it was told and where it was.
bool take_tick(std::string_view line, RunPlot& plot, LastTick& last) {
  const std::optional<double> number = take_number(line);
  const std::optional<double> seconds = take_number(line);
  take_number(line);  // the state is words
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
  return true;
}

}  // namespace

RunPlot run_plot_of(const std::string& record, const RigFile& rig) {
  RunPlot plot;
  for (const RigAxis& axis : rig.axes) {
    plot.axes.push_back({.name = axis.name, .unit = std::string(to_string(axis.unit))});
  }
  std::ifstream file(record);
  std::string line;
  LastTick last{.told = std::vector<std::optional<double>>(plot.axes.size())};
  std::getline(file, line);
  for (std::int64_t number = 2; std::getline(file, line); ++number) {
    if (!take_tick(line, plot, last)) {
      throw std::runtime_error(
          fmt::format("{}:{}: error: this is no line of a record of this rig; name another file for --record",
                      record, number));
    }
  }
  return plot;
}

}  // namespace inbetween
