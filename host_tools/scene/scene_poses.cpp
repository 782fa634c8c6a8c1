#include "host_tools/scene/scene_poses.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "host_tools/joints/vector_length.hpp"
#include "host_tools/scene/scene_bounds.hpp"

namespace inbetween {
namespace {

constexpr double degrees = 180 / std::numbers::pi;
constexpr double max_place_m = 1e6;  // of a joint tree
/// y up becomes z up.
constexpr Rotation3 y_up_on_stage{{1, 0, 0}, {0, 0, 1}, {0, -1, 0}};
/// The axes of a tip, as a camera sees them.
constexpr Rotation3 tip_in_camera{{0, 0, -1}, {-1, 0, 0}, {0, 1, 0}};

/// The direction of what is drawn as x is kept, then the plane of x and y (Gram and Schmidt).
Rotation3 rotation_of_map(const Affine& map, const Place& place) {
  const auto refuse = [&](const char* what) {
    throw InputError(place,
                     fmt::format("this node, or one above it, {}; freeze its scale where it was made", what));
  };
  const Vector3 z = map.z;
  const double size = length(z);
  const Vector3 side = cross(map.y, z);
  if (!(size > 0) || !(length(side) > 0)) refuse("has a scale of 0");
  if (!std::isfinite(size) || !std::isfinite(length(side))) refuse("is scaled beyond all numbers");
  if (!(dot(side, map.x) > 0)) refuse("is mirrored");
  const Vector3 unit_z = z * (1 / size);
  const Vector3 unit_x = side * (1 / length(side));
  return {unit_x, cross(unit_z, unit_x), unit_z};
}

/// Nearest to the angle before, in whole turns.
double unwound(double angle, double before) {
  return angle + 360 * std::round((before - angle) / 360);
}

/// How the table is off the level: pan, tilt, roll.
std::array<double, 3> angles_of(const Rotation3& tip, const std::array<double, 3>& before) {
  const double flat = std::hypot(tip.x.x, tip.x.y);
  const double tilt = std::atan2(tip.x.z, flat);
  // Straight up or down pan and roll are one angle: pan stays.
  constexpr double nearly_upright = 1e-9;
  const double pan = flat < nearly_upright ? before[0] / degrees : std::atan2(tip.x.y, tip.x.x);
  const Vector3 level{-std::sin(pan), std::cos(pan), 0};
  const Vector3 above = cross(tip.x, level);
  const double roll = std::atan2(dot(tip.y, above), dot(tip.y, level));
  return {unwound(pan * degrees, before[0]), tilt * degrees, unwound(roll * degrees, before[2])};
}

/// The rate of the rows, and how many time codes a row is.
struct RowRate {
  FrameRate fps;
  double step = 1;
};

RowRate rate_of(const SceneFile& scene, const std::optional<FrameRate>& asked) {
  const std::optional<FrameRate> fps = asked ? asked : scene.fps;
  const double codes = scene.codes_per_second;
  if (fps) {
    const bool is_each = scene.has_frames && (is_about(codes, *fps) || scene.fps == fps);
    return {*fps, is_each ? 1 : codes / fps->frames_per_second()};
  }
  constexpr double max_rate = 1000;
  const bool is_whole = scene.has_frames && codes == std::floor(codes) && codes <= max_rate;
  if (is_whole) return {{static_cast<std::int32_t>(codes), 1}, 1};
  if (scene.has_frames) {
    throw InputError({scene.file},
                     fmt::format("the file says {:g} frames a second, which is not exact; say --fps "
                                 "24000/1001, or what is meant",
                                 codes));
  }
  throw InputError({scene.file},
                   "glTF does not say how many frames a second a scene has; say it with --fps 24");
}

}  // namespace

StagedNode::StagedNode(const SceneFile& scene, std::size_t node, const ScenePlacement& placement)
    : scene_(scene), node_(node), placement_(placement) {}

Pose StagedNode::at(double code) const {
  const FileNode& node = scene_.nodes[node_];
  const Affine world = world_of(scene_, node_, code);
  const double turn = placement_.turn_deg / degrees;
  const Rotation3 up = scene_.up == UpAxis::y ? y_up_on_stage : Rotation3{};
  const Rotation3 stage = turned_about({0, 0, 1}, {std::sin(turn), std::cos(turn)}) * up;
  const double size = placement_.scale * scene_.metres_per_unit;
  Pose pose;
  pose.position = stage * world.origin * size + placement_.place;
  pose.rotation = stage * rotation_of_map(world, node.place) * (node.is_camera ? tip_in_camera : inverse(up));
  if (!(length(pose.position) <= max_place_m)) {
    throw InputError(node.place,
                     fmt::format("at time code {:g} this node is {:.3g} m away, beyond {:g} m; say --scale",
                                 code, length(pose.position), max_place_m));
  }
  return pose;
}

SceneRows rows_of_node(const SceneFile& scene, std::size_t node, const ScenePlacement& placement,
                       const std::optional<FrameRate>& fps) {
  const std::optional<std::array<double, 2>> moved = moved_codes(scene, node);
  if (!moved || (*moved)[0] == (*moved)[1]) {
    throw InputError(scene.nodes[node].place, fmt::format("{} does not move; name another node with --node",
                                                          in_quotes(scene.nodes[node].name)));
  }
  const RowRate rate = rate_of(scene, fps);
  SceneRows rows{.fps = rate.fps, .step = rate.step, .poses = {}};
  rows.first = scene.first.value_or((*moved)[0]);
  const double last = scene.last.value_or((*moved)[1]);
  // Times that were rounded to 24 bits are off by less than this share of a row, up to an hour of rows.
  constexpr double rounding = 1e-2;
  const double count = std::ceil((last - rows.first) / rows.step - rounding) + 1;
  if (!(count >= 2) || count > static_cast<double>(max_table_rows)) {
    throw InputError({scene.file},
                     fmt::format("from time code {:g} to {:g} there are {:.0f} rows; a motion has 2 to {}",
                                 rows.first, last, count, max_table_rows));
  }
  const double number = scene.has_frames && rows.step == 1 ? std::round(rows.first) : 0;
  if (std::fabs(number) > static_cast<double>(max_table_frame))
    throw InputError({scene.file},
                     fmt::format("the first frame is {:g}; let the scene begin nearer to 0", number));
  rows.first_frame = scene.first_frame.value_or(static_cast<std::int64_t>(number));
  const StagedNode staged(scene, node, placement);
  for (std::size_t row = 0; row < static_cast<std::size_t>(count); ++row)
    rows.poses.push_back(staged.at(rows.code(static_cast<double>(row))));
  return rows;
}

BakedTable table_of_poses(const SceneFile& scene, const SceneRows& rows) {
  BakedTable table{.file = scene.file};
  table.fps = rows.fps;
  table.first_frame = rows.first_frame;
  table.has_exposures = false;
  for (const char* name : {"tx", "ty", "tz"}) table.columns.push_back({.name = name, .unit = MoveUnit::m});
  for (const char* name : {"pan", "tilt", "roll"})
    table.columns.push_back({.name = name, .unit = MoveUnit::deg});
  std::array<double, 3> before{};
  for (const Pose& pose : rows.poses) {
    before = angles_of(pose.rotation, before);
    const std::array<double, 6> numbers = {pose.position.x, pose.position.y, pose.position.z,
                                           before[0],       before[1],       before[2]};
    for (std::size_t i = 0; i < numbers.size(); ++i) table.columns[i].values.push_back(numbers[i]);
  }
  table.warnings = scene.warnings;
  check_table(table);
  return table;
}

}  // namespace inbetween
