#include "host_tools/rig_model/rig_dragonframe_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>

namespace inbetween {
namespace {

constexpr std::array<std::string_view, 1> dragonframe_fields = {"steps_per_unit"};
/// Both protocols number motors up to here.
constexpr std::size_t max_dragonframe_axes = 32;
/// The host counts in 32 bits with a sign. Half of them are for where it places its own 0.
constexpr double max_steps = 1'073'741'823;

/// Steps of an axis from one end of its range to the other.
double read_steps(const TomlValue& value, const RigAxis& axis) {
  const double steps = value.number();
  if (steps == 0) value.refuse("is 0; write how many steps of the host make one unit of the axis");
  const double furthest = std::max(std::fabs(axis.min), std::fabs(axis.max));
  if (std::fabs(steps) * furthest > max_steps) {
    value.refuse(fmt::format("is {:g}, and {:g} {} would be more steps than 32 bits hold; write {:g} at most",
                             steps, furthest, to_string(axis.unit), max_steps / furthest));
  }
  return steps;
}

}  // namespace

std::optional<RigDragonframe> read_dragonframe(const TomlTable& rig, std::span<const RigAxis> axes) {
  const auto value = rig.optional("dragonframe");
  if (!value) return std::nullopt;
  const TomlTable table(value->table(), "the section dragonframe", dragonframe_fields);
  if (axes.size() > max_dragonframe_axes) {
    value->refuse(fmt::format("is in a rig of {} axes, and Dragonframe numbers motors up to {}; leave it out",
                              axes.size(), max_dragonframe_axes));
  }
  const std::string example = fmt::format("steps_per_unit = {{ {} = 100.0 }}", axes.front().name);
  const TomlValue steps = table.required("steps_per_unit", example);
  RigDragonframe dragonframe{.steps_per_unit = std::vector<double>(axes.size()), .place = value->place()};
  for (const auto& [key, node] : steps.table()) {
    const std::string name(std::string_view{key});
    const TomlValue one(node, "steps_per_unit." + name);
    const auto axis = std::ranges::find(axes, name, &RigAxis::name);
    if (axis == axes.end()) one.refuse("is of no axis of the rig; write the name of one");
    dragonframe.steps_per_unit.at(static_cast<std::size_t>(axis - axes.begin())) = read_steps(one, *axis);
  }
  for (std::size_t a = 0; a < axes.size(); ++a) {
    if (dragonframe.steps_per_unit[a] != 0) continue;
    steps.refuse(
        fmt::format("has no number for axis {}; add {} = 100.0, say", in_quotes(axes[a].name), axes[a].name));
  }
  return dragonframe;
}

}  // namespace inbetween
