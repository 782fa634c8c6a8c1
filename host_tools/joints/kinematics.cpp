#include "host_tools/joints/kinematics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <optional>
#include <span>
#include <utility>

#include "host_tools/rig_model/move_unit.hpp"

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

/// Nothing for a joint that has no axis.
std::optional<std::size_t> axis_named(const UrdfJoint& joint, const RigFile& rig) {
  const auto axis = std::ranges::find(rig.axes, joint.name, &RigAxis::name);
  if (axis == rig.axes.end()) return std::nullopt;
  return static_cast<std::size_t>(axis - rig.axes.begin());
}

/// By the axis of its name, or by that of the joint that it mimics; nothing where that has none.
std::optional<DrivenBy> driver_of(const UrdfFile& urdf, std::size_t index, const RigFile& rig) {
  const UrdfJoint& joint = urdf.joints[index];
  if (joint.mimic) {
    const std::optional<DrivenBy> followed = driver_of(urdf, joint.mimic->joint, rig);
    if (!followed) return std::nullopt;
    return DrivenBy{followed->axis, joint.mimic->multiplier * followed->factor,
                    joint.mimic->multiplier * followed->offset + joint.mimic->offset};
  }
  const std::optional<std::size_t> index_of_axis = axis_named(joint, rig);
  if (!index_of_axis) return std::nullopt;
  const RigAxis& axis = rig.axes[*index_of_axis];
  const std::optional<double> size = size_of(axis.unit, joint.kind);
  if (!size) {
    const bool turns = joint.kind != UrdfJointKind::prismatic;
    throw InputError(axis.place, fmt::format("axis {} counts in {}, but its joint {} ({}); write unit = {}",
                                             in_quotes(axis.name), to_string(axis.unit),
                                             turns ? "turns" : "slides", to_string(joint.place),
                                             turns ? R"("deg", "rad" or "turn")" : R"("mm" or "m")"));
  }
  return DrivenBy{*index_of_axis, *size, 0};
}

/// Where a joint without an axis stays: where the rig says, or else at 0, or in the middle of limits that
/// exclude 0; one that mimics another, where that puts it.
double held_value(const UrdfFile& urdf, std::size_t index, const RigFile& rig) {
  const UrdfJoint& joint = urdf.joints[index];
  const auto said = std::ranges::find(rig.kinematics->at, joint.name, &RigJoint::name);
  if (said != rig.kinematics->at.end()) return said->value;
  if (joint.mimic) {
    return joint.mimic->multiplier * held_value(urdf, joint.mimic->joint, rig) + joint.mimic->offset;
  }
  if (!joint.limit || (joint.limit->lower <= 0 && joint.limit->upper >= 0)) return 0;
  return joint.limit->lower / 2 + joint.limit->upper / 2;  // their sum may be no number
}

/// That place, if it can be computed.
double checked_held_value(const UrdfFile& urdf, std::size_t index, const RigFile& rig) {
  const double value = held_value(urdf, index, rig);
  if (std::fabs(value) <= max_angle) return value;
  const UrdfJoint& joint = urdf.joints[index];
  throw InputError(
      joint.place,
      fmt::format("joint {} would stay at {:g}; write at = {{ \"{}\" = 0 }} in [kinematics], say",
                  in_quotes(joint.name), value, joint.name));
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

/// How far beyond a limit of the file the rig may go: as far as a number with so many decimals was rounded or
/// cut off, and no further than 0.1 deg or 0.05 mm. Fewer decimals than min_decimals are no rounding of pi.
/// Kinematics.ALimitThatWasRoundedIsTheSameLimitUpToATenthOfADegree.
double slack_of(int decimals, UrdfJointKind kind, double value) {
  constexpr int min_decimals = 3;
  constexpr double max_rad = 0.1 * std::numbers::pi / 180;
  constexpr double max_m = 0.05e-3;
  const double exact = rounding * (1 + std::fabs(value));
  if (decimals < min_decimals) return exact;
  const double most = kind == UrdfJointKind::prismatic ? max_m : max_rad;
  return std::max(exact, std::min(most, std::pow(10.0, -decimals)));
}

/// The ends of the axis must be within what the joint may do, and what can be computed. Limits of a joint
/// that mimics another are often left from before it did, and a velocity of 0 is one that nobody has written:
/// such are named in `passed`.
void refuse_too_far(const UrdfJoint& joint, const DrivenBy& driver, const RigAxis& axis, bool counts,
                    std::vector<std::string>& passed) {
  const char* unit = joint.kind == UrdfJointKind::prismatic ? "m" : "rad";
  const bool has_limit = joint.limit && counts;
  for (const auto& [end, position] : {std::pair("min", axis.min), std::pair("max", axis.max)}) {
    const double value = driver.factor * position + driver.offset;
    // Programs write limits of 1e16 where there are none.
    const double lower = std::max(has_limit ? joint.limit->lower : -max_angle, -max_angle);
    const double upper = std::min(has_limit ? joint.limit->upper : max_angle, max_angle);
    const double below = lower - slack_of(has_limit ? joint.limit->lower_decimals : 0, joint.kind, value);
    const double above = upper + slack_of(has_limit ? joint.limit->upper_decimals : 0, joint.kind, value);
    if (value >= below && value <= above) continue;
    if (has_limit && joint.mimic) {
      passed.push_back(fmt::format("{} (limits)", joint.name));
      return;
    }
    throw InputError(
        axis.place,
        fmt::format("axis {}: {} = {} {} takes joint {} to {:.6g} {}, beyond its limits {:.6g} to "
                    "{:.6g} ({}); correct one of the two files, or write limits = \"rig\" in [kinematics]",
                    in_quotes(axis.name), end, position, to_string(axis.unit), in_quotes(joint.name), value,
                    unit, lower, upper, to_string(joint.limit ? joint.limit->place : joint.place)));
  }
  if (!has_limit) return;
  if (joint.limit->velocity == 0) {
    passed.push_back(fmt::format("{} (velocity 0)", joint.name));
    return;
  }
  const double velocity = std::fabs(driver.factor) * axis.max_velocity;
  if (velocity <= joint.limit->velocity * (1 + rounding)) return;
  if (joint.mimic) {
    passed.push_back(fmt::format("{} (velocity)", joint.name));
    return;
  }
  throw InputError(
      axis.place,
      fmt::format("axis {}: max_velocity = {} {}/s moves joint {} at {:.6g} {}/s, faster than its "
                  "{:.6g} ({}); correct one of the two files, or write limits = \"rig\" in [kinematics]",
                  in_quotes(axis.name), axis.max_velocity, to_string(axis.unit), in_quotes(joint.name),
                  velocity, unit, joint.limit->velocity, to_string(joint.limit->place)));
}

Vector3 vector_of(const std::array<double, 3>& v) {
  return {v[0], v[1], v[2]};
}

/// Turns about the fixed axes x, then y, then z.
Rotation3 rotation_of(const std::array<double, 3>& rpy) {
  return turned_about({0, 0, 1}, sine_cosine(rpy[2])) * turned_about({0, 1, 0}, sine_cosine(rpy[1])) *
         turned_about({1, 0, 0}, sine_cosine(rpy[0]));
}

/// Where the joint is held, it is part of what it hangs on.
Pose held_pose(const UrdfJoint& joint, const Pose& origin, double value) {
  const Vector3 axis = vector_of(joint.axis);
  const Vector3 unit = axis * (1 / std::hypot(axis.x, axis.y, axis.z));
  if (joint.kind == UrdfJointKind::prismatic) return {origin.rotation, origin * (unit * value)};
  return {origin.rotation * turned_about(unit, sine_cosine(value)), origin.position};
}

/// What is told to whoever reads the file.
struct Told {
  std::vector<std::string> held;    // joints without an axis, and where
  std::vector<std::string> passed;  // limits that do not count
};

Joint joint_of(const UrdfFile& urdf, std::size_t index, const RigFile& rig, Told& told) {
  const UrdfJoint& from = urdf.joints[index];
  Joint joint;
  joint.parent = static_cast<std::int32_t>(from.parent);
  joint.origin = {rotation_of(from.rpy), vector_of(from.xyz)};
  if (from.kind == UrdfJointKind::fixed) return joint;
  refuse_mimic_with_axis(from, rig);
  const std::optional<DrivenBy> driver = driver_of(urdf, index, rig);
  if (!driver) {
    const double value = checked_held_value(urdf, index, rig);
    joint.origin = held_pose(from, joint.origin, value);
    told.held.push_back(fmt::format("{} at {:g}", from.name, value));
    return joint;
  }
  refuse_too_far(from, *driver, rig.axes[driver->axis], !rig.kinematics->has_limits_of_rig, told.passed);
  joint.kind = from.kind == UrdfJointKind::prismatic ? JointKind::prismatic : JointKind::revolute;
  joint.coordinate = static_cast<std::int32_t>(driver->axis);
  joint.factor = driver->factor;
  joint.offset = driver->offset;
  joint.axis = vector_of(from.axis);
  return joint;
}

/// A place for a joint that there is none of, or that an axis moves, is a mistake.
void refuse_wrong_places(const UrdfFile& urdf, const RigFile& rig) {
  for (const RigJoint& said : rig.kinematics->at) {
    const auto joint = std::ranges::find(urdf.joints, said.name, &UrdfJoint::name);
    if (joint == urdf.joints.end() || joint->kind == UrdfJointKind::fixed) {
      throw InputError(said.place, fmt::format("there is no joint {} that moves in {}; correct the name",
                                               in_quotes(said.name), urdf.path));
    }
    if (!driver_of(urdf, static_cast<std::size_t>(joint - urdf.joints.begin()), rig)) continue;
    throw InputError(said.place, fmt::format("joint {} is moved by an axis of the rig; remove its place",
                                             in_quotes(said.name)));
  }
}

/// The root link stands in the world; each other link hangs on its joint.
std::vector<Joint> joints_of(const UrdfFile& urdf, const RigFile& rig, std::vector<Warning>& warnings) {
  refuse_wrong_places(urdf, rig);
  warnings = urdf.warnings;
  Told told;
  std::vector<Joint> joints(1);
  for (std::size_t i = 0; i < urdf.joints.size(); ++i) joints.push_back(joint_of(urdf, i, rig, told));
  const Place place{.file = urdf.path};
  const auto warn = [&](const std::vector<std::string>& names, std::string_view before,
                        std::string_view after) {
    if (names.empty()) return;
    Warning warning;
    warning.place = place;
    // A humanoid has hundreds of joints, and a warning is one line.
    constexpr std::size_t max_named = 16;
    const std::span named(names.data(), std::min(names.size(), max_named));
    warning.message = fmt::format("{}: {}", before, comma_separated(named));
    if (names.size() > max_named) warning.message += fmt::format(" and {} more", names.size() - max_named);
    warning.message += after;
    warnings.push_back(std::move(warning));
  };
  warn(told.held, "no axis moves these joints, and they stay where they are (rad, m)",
       "; write at = { JOINT = VALUE } in [kinematics] for another place");
  warn(told.passed, "these limits do not count", "");
  return joints;
}

JointTree tree_of(std::vector<Joint>& joints, const UrdfFile& urdf, const RigFile& rig) {
  const auto tree = JointTree::make(joints, static_cast<std::int32_t>(rig.axes.size()), joints);
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
    : memory_(joints_of(urdf, rig, warnings_)),
      tree_(tree_of(memory_, urdf, rig)),
      tips_(tips_of(urdf, rig)),
      links_(urdf.links) {}

Kinematics read_kinematics(const RigFile& rig, const TextReader& read) {
  const std::filesystem::path path = std::filesystem::path(rig.path).parent_path() / rig.kinematics->urdf;
  return {parse_urdf(read(path, max_file_bytes), path.string()), rig};
}

}  // namespace inbetween
