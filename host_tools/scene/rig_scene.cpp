#include "host_tools/scene/rig_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "host_tools/joints/vector_length.hpp"

namespace inbetween {
namespace {

/// A tip looks along x with z up, a camera along -z with y up.
constexpr Rotation3 camera_in_tip{{0, -1, 0}, {0, 0, 1}, {-1, 0, 0}};

double value_of(const Joint& joint, double position) {
  return joint.factor * position + joint.offset;
}

/// The motion of every coordinate of the tree: a row of the move, or nothing where it is in no track.
std::vector<const AxisRow*> rows_of_coordinates(const RigFile& rig, const AxisRows& rows) {
  std::vector<const AxisRow*> found;
  for (const RigAxis& axis : rig.axes) {
    const auto row = std::ranges::find(rows.axes, axis.name, &AxisRow::name);
    found.push_back(row == rows.axes.end() ? nullptr : &*row);
  }
  return found;
}

/// Where an axis is drawn that the move does not place: at 0, or at the end of its range that is nearest.
double drawn_place(const RigAxis& axis) {
  return std::clamp(0.0, axis.min, axis.max);
}

SceneNode node_of(const Joint& joint, const std::string& name, const AxisRow* axis, double held) {
  SceneNode node{.name = name, .parent = joint.parent, .rest = joint.origin};
  if (joint.kind == JointKind::fixed) return node;
  const auto pose_at = [&](double position) -> Pose {
    const double value = value_of(joint, position);
    if (joint.kind == JointKind::prismatic)
      return {joint.origin.rotation, joint.origin * (joint.axis * value)};
    return {joint.origin.rotation * turned_about(joint.axis, sine_cosine(value)), joint.origin.position};
  };
  node.rest = pose_at(axis == nullptr ? held : axis->positions.front());
  if (axis == nullptr) return node;
  for (const double position : axis->positions) {
    const Pose pose = pose_at(position);
    if (joint.kind == JointKind::prismatic) {
      node.positions.push_back(pose.position);
      continue;
    }
    const Quaternion turn = quaternion_of(pose.rotation);
    node.turns.push_back(node.turns.empty() ? turn : nearer_sign(turn, node.turns.back()));
  }
  return node;
}

void refuse_half_turns(const Joint& joint, const AxisRow& axis, const AxisRows& rows) {
  if (joint.kind != JointKind::revolute) return;
  for (std::size_t row = 0; row + 1 < rows.rows; ++row) {
    const double turned = std::fabs(joint.factor * (axis.positions[row + 1] - axis.positions[row]));
    if (turned < std::numbers::pi) continue;
    throw InputError(
        {rows.name},
        fmt::format("axis {} turns by {:.4g} degrees between frames {} and {}, and other programs "
                    "would turn it the other way; write more rows a second with --fps",
                    in_quotes(axis.name), turned * 180 / std::numbers::pi,
                    rows.first_frame + static_cast<std::int64_t>(row),
                    rows.first_frame + static_cast<std::int64_t>(row) + 1));
  }
}

/// How far the camera may be off between two rows because the joints of its branch are.
class BranchBound {
 public:
  /// From the tip to the root. `reach` of a joint is the farthest that the tip can be from its axis.
  BranchBound(std::span<const Joint> joints, std::int32_t tip, std::span<const AxisRow* const> axes) {
    double reach = 0;
    for (std::int32_t link = tip; link >= 0; link = joints[static_cast<std::size_t>(link)].parent) {
      const Joint& joint = joints[static_cast<std::size_t>(link)];
      const AxisRow* const axis =
          joint.coordinate < 0 ? nullptr : axes[static_cast<std::size_t>(joint.coordinate)];
      if (axis != nullptr) {
        const bool turns = joint.kind == JointKind::revolute;
        moved_.push_back({axis, std::fabs(joint.factor), turns ? reach : 1, turns});
      }
      reach += length(joint.origin.position);
      if (joint.kind == JointKind::prismatic && axis != nullptr) reach += farthest(joint, *axis);
    }
  }

  [[nodiscard]] BetweenRows on(std::size_t row) const {
    BetweenRows sum;
    for (const Moved& moved : moved_) {
      const double off = moved.factor * moved.axis->off[row];
      sum.place_m += off * moved.reach;
      if (moved.turns) sum.turn_rad += off;
    }
    return sum;
  }

 private:
  struct Moved {
    const AxisRow* axis;
    double factor;  // rad or m per unit
    double reach;   // m per rad, or 1
    bool turns;
  };

  static double farthest(const Joint& joint, const AxisRow& axis) {
    double most = 0;
    for (const double position : axis.positions) most = std::max(most, std::fabs(value_of(joint, position)));
    double off = 0;
    for (const double between : axis.off) off = std::max(off, between);
    return most + std::fabs(joint.factor) * off;
  }

  std::vector<Moved> moved_;
};

std::string unused_name(const std::vector<SceneNode>& nodes, const std::string& wanted) {
  std::set<std::string> names;
  for (const SceneNode& node : nodes) names.insert(node.name);
  std::string name = wanted;
  while (names.contains(name)) name += "_";
  return name;
}

SceneCamera add_camera(const RigFile& rig, const Tip& tip, AnimatedScene& scene) {
  SceneCamera camera{.node = static_cast<std::int32_t>(scene.nodes.size())};
  scene.nodes.push_back({.name = unused_name(scene.nodes, tip.name + "_view"),
                         .parent = tip.link,
                         .rest = {camera_in_tip, {}}});
  if (rig.lens && rig.lens->tip == tip.name) {
    camera.lens = {.focal_length_mm = rig.lens->focal_length_mm,
                   .sensor_mm = rig.lens->sensor_mm,
                   .focus_m = rig.lens->distance_m};
  }
  return camera;
}

}  // namespace

const Tip& camera_tip(const RigFile& rig, const Kinematics& kinematics,
                      const std::optional<std::string>& named) {
  const std::vector<Tip>& tips = kinematics.tips();
  std::vector<std::string> names;
  names.reserve(tips.size());
  for (const Tip& tip : tips) names.push_back(tip.name);
  const std::string wanted = named ? *named : rig.lens ? rig.lens->tip : tips.front().name;
  const auto found = std::ranges::find(tips, wanted, &Tip::name);
  if (found == tips.end()) {
    throw InputError({rig.path}, fmt::format("the rig has no tip {}; name one of {} with --tip",
                                             in_quotes(wanted), comma_separated(names)));
  }
  if (named || rig.lens || tips.size() == 1) return *found;
  throw InputError(
      {rig.path},
      fmt::format("the rig has several tips and no [lens]; say with --tip which of {} carries the "
                  "camera",
                  comma_separated(names)));
}

RigScene scene_of_rig(const RigFile& rig, const Kinematics& kinematics, const Tip& tip,
                      const AxisRows& rows) {
  const std::vector<const AxisRow*> axes = rows_of_coordinates(rig, rows);
  const std::span<const Joint> joints = kinematics.tree().joints();
  RigScene result;
  for (std::size_t a = 0; a < axes.size(); ++a) {
    if (axes[a] != nullptr) continue;
    const bool is_joint =
        std::ranges::find(joints, static_cast<std::int32_t>(a), &Joint::coordinate) != joints.end();
    if (!is_joint) continue;
    const RigAxis& axis = rig.axes[a];
    if (kinematics.tree().moves(static_cast<std::int32_t>(a), tip.link)) {
      throw InputError({rows.name},
                       fmt::format("{} moves {} and is in no track, so that nobody knows where "
                                   "the camera is; put it into one, with the place where it stays",
                                   named(axis), tip.name));
    }
    result.told.push_back(fmt::format("{} is in no track; its joint is drawn at {:g} {}", named(axis),
                                      drawn_place(axis), to_string(axis.unit)));
  }
  AnimatedScene& scene = result.scene;
  scene = {.name = rows.name,
           .fps = rows.fps,
           .first_frame = rows.first_frame,
           .rows = rows.rows,
           .nodes = {},
           .camera = {},
           .between = {}};
  for (std::size_t link = 0; link < joints.size(); ++link) {
    const Joint& joint = joints[link];
    const auto coordinate = static_cast<std::size_t>(std::max(joint.coordinate, 0));
    const AxisRow* const axis = joint.coordinate < 0 ? nullptr : axes[coordinate];
    if (axis != nullptr) refuse_half_turns(joint, *axis, rows);
    const double held = joint.coordinate < 0 ? 0 : drawn_place(rig.axes[coordinate]);
    scene.nodes.push_back(node_of(joint, kinematics.links()[link], axis, held));
  }
  scene.camera = add_camera(rig, tip, scene);
  const BranchBound bound(joints, tip.link, axes);
  for (std::size_t row = 0; row + 1 < rows.rows; ++row) {
    const BetweenRows between = bound.on(row);
    scene.between.place_m = std::max(scene.between.place_m, between.place_m);
    scene.between.turn_rad = std::max(scene.between.turn_rad, between.turn_rad);
  }
  return result;
}

}  // namespace inbetween
