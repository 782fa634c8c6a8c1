#include "host_tools/joints/kinematics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <utility>

#include "host_tools/files/move_unit.hpp"

namespace inbetween {
namespace {

/// Limits in two files and two units agree up to rounding.
constexpr double rounding = 1e-9;

/// What 1 of the unit is in radians or metres; nothing where the joint cannot count in it.
std::optional<double> size_of(AxisUnit unit, UrdfJointKind kind) {
  if (unit == AxisUnit::unit) return std::nullopt;
  return converted(1, as_move_unit(unit), kind == UrdfJointKind::prismatic ? AxisUnit::m : AxisUnit::rad);
}

/// Joint value = factor * axis + offset.
struct DrivenBy {
  std::size_t axis = 0;
  double factor = 1;
  double offset = 0;
};

std::size_t axis_named(const UrdfJoint& joint, const RigFile& rig) {
  const auto axis = std::ranges::find(rig.axes, joint.name, &RigAxis::name);
  if (axis != rig.axes.end()) return static_cast<std::size_t>(axis - rig.axes.begin());
  throw InputError(joint.place, fmt::format("joint {} is no axis of the rig {}; give an axis this name, or "
                                            "write type=\"fixed\"",
                                            in_quotes(joint.name), in_quotes(rig.name)));
}

/// By the axis of its name, or by that of the joint that it mimics.
DrivenBy driver_of(const UrdfFile& urdf, std::size_t index, const RigFile& rig) {
  const UrdfJoint& joint = urdf.joints[index];
  if (joint.mimic) {
    const DrivenBy followed = driver_of(urdf, joint.mimic->joint, rig);
    return {followed.axis, joint.mimic->multiplier * followed.factor,
            joint.mimic->multiplier * followed.offset + joint.mimic->offset};
  }
  const std::size_t index_of_axis = axis_named(joint, rig);
  const RigAxis& axis = rig.axes[index_of_axis];
  const std::optional<double> size = size_of(axis.unit, joint.kind);
  if (!size) {
    const bool turns = joint.kind != UrdfJointKind::prismatic;
    throw InputError(axis.place, fmt::format("axis {} counts in {}, but its joint {} ({}); write unit = {}",
                                             in_quotes(axis.name), to_string(axis.unit),
                                             turns ? "turns" : "slides", to_string(joint.place),
                                             turns ? R"("deg", "rad" or "turn")" : R"("mm" or "m")"));
  }
  return {index_of_axis, *size, 0};
}

void refuse_mimic_with_axis(const UrdfJoint& joint, const RigFile& rig) {
  if (!joint.mimic) return;
  const auto axis = std::ranges::find(rig.axes, joint.name, &RigAxis::name);
  if (axis == rig.axes.end()) return;
  throw InputError(
      axis->place,
      fmt::format("axis {} has the name of a joint that mimics another ({}); remove one of the two",
                  in_quotes(axis->name), to_string(joint.mimic->place)));
}

/// The ends of the axis must be within what the joint may do, and what can be computed.
void refuse_too_far(const UrdfJoint& joint, const DrivenBy& driver, const RigAxis& axis) {
  const char* unit = joint.kind == UrdfJointKind::prismatic ? "m" : "rad";
  for (const auto& [end, position] : {std::pair("min", axis.min), std::pair("max", axis.max)}) {
    const double value = driver.factor * position + driver.offset;
    const double slack = rounding * (1 + std::fabs(value));
    const double lower = joint.limit ? joint.limit->lower : -max_angle<double>;
    const double upper = joint.limit ? joint.limit->upper : max_angle<double>;
    if (value >= lower - slack && value <= upper + slack) continue;
    throw InputError(
        axis.place,
        fmt::format("axis {}: {} = {} {} takes joint {} to {:.6g} {}, beyond its limits {:.6g} to "
                    "{:.6g} ({}); correct one of the two files",
                    in_quotes(axis.name), end, position, to_string(axis.unit), in_quotes(joint.name), value,
                    unit, lower, upper, to_string(joint.limit ? joint.limit->place : joint.place)));
  }
  const double velocity = std::fabs(driver.factor) * axis.max_velocity;
  if (!joint.limit || velocity <= joint.limit->velocity * (1 + rounding)) return;
  throw InputError(
      axis.place,
      fmt::format("axis {}: max_velocity = {} {}/s moves joint {} at {:.6g} {}/s, faster than its "
                  "{:.6g} ({}); correct one of the two files",
                  in_quotes(axis.name), axis.max_velocity, to_string(axis.unit), in_quotes(joint.name),
                  velocity, unit, joint.limit->velocity, to_string(joint.limit->place)));
}

Vector3<double> vector_of(const std::array<double, 3>& v) {
  return {v[0], v[1], v[2]};
}

/// Turns about the fixed axes x, then y, then z.
Rotation3<double> rotation_of(const std::array<double, 3>& rpy) {
  return turned_about({0, 0, 1}, sine_cosine(rpy[2])) * turned_about({0, 1, 0}, sine_cosine(rpy[1])) *
         turned_about({1, 0, 0}, sine_cosine(rpy[0]));
}

Joint<double> joint_of(const UrdfFile& urdf, std::size_t index, const RigFile& rig) {
  const UrdfJoint& from = urdf.joints[index];
  Joint<double> joint;
  joint.parent = static_cast<std::int32_t>(from.parent);
  joint.origin = {rotation_of(from.rpy), vector_of(from.xyz)};
  if (from.kind == UrdfJointKind::fixed) return joint;
  refuse_mimic_with_axis(from, rig);
  const DrivenBy driver = driver_of(urdf, index, rig);
  refuse_too_far(from, driver, rig.axes[driver.axis]);
  joint.kind = from.kind == UrdfJointKind::prismatic ? JointKind::prismatic : JointKind::revolute;
  joint.coordinate = static_cast<std::int32_t>(driver.axis);
  joint.factor = driver.factor;
  joint.offset = driver.offset;
  joint.axis = vector_of(from.axis);
  return joint;
}

/// The root link stands in the world; each other link hangs on its joint.
std::vector<Joint<double>> joints_of(const UrdfFile& urdf, const RigFile& rig) {
  std::vector<Joint<double>> joints(1);
  for (std::size_t i = 0; i < urdf.joints.size(); ++i) joints.push_back(joint_of(urdf, i, rig));
  return joints;
}

JointTree<double> tree_of(std::vector<Joint<double>>& joints, const UrdfFile& urdf, const RigFile& rig) {
  const auto tree = JointTree<double>::make(joints, static_cast<std::int32_t>(rig.axes.size()), joints);
  if (tree) return *tree;
  const Error& error = tree.error();
  const bool has_joint = error.axis > 0;  // link i hangs on joint i - 1
  throw InputError(has_joint ? urdf.joints[static_cast<std::size_t>(error.axis) - 1].place : Place{urdf.path},
                   fmt::format("{}; {}", error.what, error.remedy));
}

std::vector<Tip> tips_of(const UrdfFile& urdf, const RigFile& rig) {
  std::vector<Tip> tips;
  for (const RigTip& tip : rig.kinematics->tips) {
    const auto link = std::ranges::find(urdf.links, tip.name);
    if (link == urdf.links.end()) {
      throw InputError(tip.place, fmt::format("there is no link {} in {}; name one of its links",
                                              in_quotes(tip.name), urdf.path));
    }
    tips.push_back({tip.name, static_cast<std::int32_t>(link - urdf.links.begin())});
  }
  return tips;
}

}  // namespace

Kinematics::Kinematics(const UrdfFile& urdf, const RigFile& rig)
    : memory_(joints_of(urdf, rig)),
      tree_(tree_of(memory_, urdf, rig)),
      tips_(tips_of(urdf, rig)),
      links_(urdf.links) {}

Kinematics read_kinematics(const RigFile& rig) {
  const std::filesystem::path folder = std::filesystem::path(rig.path).parent_path();
  return {read_urdf_file(folder / rig.kinematics->urdf), rig};
}

}  // namespace inbetween
