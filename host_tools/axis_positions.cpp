#include "host_tools/axis_positions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>

#include "host_tools/command.hpp"
#include "host_tools/diagnostics.hpp"

namespace inbetween {

std::optional<double> number_of(std::string_view text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(number)) return std::nullopt;
  return number;
}

std::map<std::string, double> positions_of(const std::vector<std::string>& texts,
                                           const std::string& argument) {
  std::map<std::string, double> positions;
  for (const std::string& text : texts) {
    const std::size_t sign = text.rfind('=');
    const auto position =
        sign == std::string::npos ? std::nullopt : number_of(std::string_view(text).substr(sign + 1));
    if (!position) {
      throw UsageError(fmt::format("{} {}: not a position; write AXIS=POSITION, for example pan=-20",
                                   argument, in_quotes(text)));
    }
    if (!positions.emplace(text.substr(0, sign), *position).second) {
      throw UsageError(fmt::format("{} {}: the axis has a position already", argument, in_quotes(text)));
    }
  }
  return positions;
}

std::size_t axis_named(const RigFile& rig, const std::string& name) {
  std::vector<std::string> names;
  names.reserve(rig.axes.size());
  for (std::size_t a = 0; a < rig.axes.size(); ++a) {
    if (rig.axes[a].name == name) return a;
    names.push_back(rig.axes[a].name);
  }
  throw InputError({rig.path, 0, 0},
                   fmt::format("the rig {} has no axis {}; name one of {}", in_quotes(rig.name),
                               in_quotes(name), comma_separated(names)));
}

double parked(const RigAxis& axis) {
  return std::clamp(0.0, axis.min, axis.max);
}

std::vector<double> standing_positions(const RigFile& rig, std::vector<double> positions,
                                       const std::map<std::string, double>& said) {
  for (const auto& [name, position] : said) positions[axis_named(rig, name)] = position;
  return positions;
}

}  // namespace inbetween
