#include "host_tools/rig_model/rig_lens_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace inbetween {
namespace {

constexpr std::array<std::string_view, 5> lens_fields = {"focal_length_mm", "sensor_mm", "resolution_px",
                                                         "distance_m", "tip"};
// Wider than any lens, sensor and stage: a slip of a unit is outside them.
constexpr double max_focal_length_mm = 10'000;
constexpr double max_sensor_mm = 1'000;
constexpr std::int64_t max_resolution_px = 100'000;
constexpr double max_distance_m = 10'000;

double above_zero(const TomlValue& value, double max) {
  const double number = value.number(0, max);
  if (number == 0) value.refuse("is 0; write a number above 0");
  return number;
}

/// Width and height.
std::array<TomlValue, 2> read_pair(const TomlTable& table, std::string_view field, std::string_view example) {
  const TomlValue value = table.required(field, example);
  const std::vector<TomlValue> pair = value.list(2);
  if (pair.size() != 2) value.refuse(fmt::format("has one number; write {}, width and height", example));
  return {pair[0], pair[1]};
}

std::string read_lens_tip(const TomlTable& table, const RigKinematics& kinematics) {
  const auto names = [&] {
    std::vector<std::string> all;
    for (const RigTip& tip : kinematics.tips) all.push_back(in_quotes(tip.name));
    return comma_separated(all);
  };
  const auto value = table.optional("tip");
  if (!value) {
    if (kinematics.tips.size() == 1) return kinematics.tips.front().name;
    throw InputError(table.place(),
                     fmt::format("the lens does not say at which tip it is; write tip = {}, one of {}",
                                 in_quotes(kinematics.tips.front().name), names()));
  }
  std::string name = value->text();
  if (std::ranges::find(kinematics.tips, name, &RigTip::name) == kinematics.tips.end()) {
    value->refuse(fmt::format("is {}, which is no tip of [kinematics]; write one of {}, or add it there",
                              in_quotes(name), names()));
  }
  return name;
}

}  // namespace

std::optional<RigLens> read_lens(const TomlTable& rig, const std::optional<RigKinematics>& kinematics) {
  const auto value = rig.optional("lens");
  if (!value) return std::nullopt;
  const TomlTable table(value->table(), "the lens", lens_fields);
  if (!kinematics) {
    value->refuse(
        "is in a rig without [kinematics], and nobody knows how its axes move it; add [kinematics], "
        "or leave it out");
  }
  RigLens lens;
  lens.place = value->place();
  lens.focal_length_mm =
      above_zero(table.required("focal_length_mm", "focal_length_mm = 50.0, say"), max_focal_length_mm);
  const auto sensor = read_pair(table, "sensor_mm", "sensor_mm = [36.0, 24.0]");
  const auto resolution = read_pair(table, "resolution_px", "resolution_px = [4096, 2730]");
  for (std::size_t i = 0; i < 2; ++i) {
    lens.sensor_mm.at(i) = above_zero(sensor.at(i), max_sensor_mm);
    lens.resolution_px.at(i) = static_cast<std::int32_t>(resolution.at(i).integer(1, max_resolution_px));
  }
  lens.distance_m = above_zero(
      table.required("distance_m", "distance_m = 1.5, from the tip to what is looked at"), max_distance_m);
  lens.tip = read_lens_tip(table, *kinematics);
  return lens;
}

}  // namespace inbetween
