#include "host_tools/reference/axis_positions.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host_tools/text/diagnostics.hpp"

namespace inbetween {

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
