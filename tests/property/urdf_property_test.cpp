// URDF files as six exporters write them, and with the mistakes of people in them, against urdfdom (the
// reader that the format comes with) and Orocos KDL.
#include <console_bridge/console.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <kdl/segment.hpp>
#include <map>
#include <numbers>
#include <optional>
#include <random>
#include <regex>
#include <string>
#include <vector>

#include "host_tools/joints/kinematics.hpp"
#include "host_tools/joints/urdf_file.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "tests/support/exported_urdf.hpp"
#include "tests/support/property.hpp"
#include "tests/support/rig_text.hpp"

namespace inbetween {
namespace urdf_property_test {

using Model = urdf::ModelInterfaceSharedPtr;

/// Nothing where urdfdom refuses. What it says of that is not shown.
Model read_by_urdfdom(const std::string& text) {
  console_bridge::noOutputHandler();
  Model model = urdf::parseURDF(text);
  console_bridge::restorePreviousOutputHandler();
  return model;
}

std::array<double, 3> numbers_of(const urdf::Vector3& v) {
  return {v.x, v.y, v.z};
}

int type_of(UrdfJointKind kind) {
  switch (kind) {
    case UrdfJointKind::fixed:
      return urdf::Joint::FIXED;
    case UrdfJointKind::revolute:
      return urdf::Joint::REVOLUTE;
    case UrdfJointKind::continuous:
      return urdf::Joint::CONTINUOUS;
    case UrdfJointKind::prismatic:
      return urdf::Joint::PRISMATIC;
  }
  return urdf::Joint::UNKNOWN;
}

/// What differs in a joint; nothing where all is the same.
const char* difference(const UrdfFile& file, const UrdfJoint& joint, const urdf::Joint& expected) {
  if (expected.type != type_of(joint.kind)) return "type";
  if (expected.parent_link_name != file.links[joint.parent]) return "parent";
  if (expected.child_link_name != file.links[joint.child]) return "child";
  const urdf::Pose& origin = expected.parent_to_joint_origin_transform;
  if (joint.xyz != numbers_of(origin.position)) return "xyz";
  urdf::Rotation turned;
  turned.setFromRPY(joint.rpy[0], joint.rpy[1], joint.rpy[2]);
  const urdf::Rotation& rotation = origin.rotation;
  if (std::fabs(turned.x - rotation.x) + std::fabs(turned.y - rotation.y) + std::fabs(turned.z - rotation.z) +
          std::fabs(turned.w - rotation.w) >
      1e-12) {
    return "rpy";
  }
  if (joint.kind == UrdfJointKind::fixed) return nullptr;
  if (joint.axis != numbers_of(expected.axis)) return "axis";
  if (joint.limit) {
    if (joint.limit->lower != expected.limits->lower) return "lower";
    if (joint.limit->upper != expected.limits->upper) return "upper";
    if (joint.limit->velocity != expected.limits->velocity) return "velocity";
  }
  if (joint.mimic.has_value() != (expected.mimic != nullptr)) return "mimic";
  if (!joint.mimic) return nullptr;
  if (file.joints[joint.mimic->joint].name != expected.mimic->joint_name) return "mimicked joint";
  if (joint.mimic->multiplier != expected.mimic->multiplier) return "multiplier";
  return joint.mimic->offset == expected.mimic->offset ? nullptr : "offset";
}

std::string difference(const UrdfFile& file, const Model& model) {
  if (model->links_.size() != file.links.size()) return "number of links";
  if (model->joints_.size() != file.joints.size()) return "number of joints";
  if (model->getRoot()->name != file.links.front()) return "root";
  for (const UrdfJoint& joint : file.joints) {
    const auto expected = model->getJoint(joint.name);
    if (!expected) return "a joint " + joint.name;
    const char* differs = difference(file, joint, *expected);
    if (differs != nullptr) return fmt::format("{} of {}", differs, joint.name);
  }
  return "";
}

/// The joints in radians and metres, by their names, and the rig and coordinates that put them there.
struct Stance {
  std::map<std::string, double> values;  // of those that mimic nothing
  std::string rig;
  std::vector<double> coordinates;
};

/// Some joints have axes, in units of all kinds; some others stay where the rig says.
Stance random_stance(const UrdfFile& file, std::mt19937_64& random) {
  const auto one_in = [&](int count) { return std::uniform_int_distribution<int>(1, count)(random) == 1; };
  Stance stance;
  std::vector<AxisText> axes = {{.name = "focus"}};
  stance.coordinates = {0};
  std::string at;
  for (const UrdfJoint& joint : file.joints) {
    if (joint.kind == UrdfJointKind::fixed || joint.mimic) continue;
    const bool slides = joint.kind == UrdfJointKind::prismatic;
    double& value = stance.values[joint.name];
    value = std::uniform_real_distribution<double>(-2, 2)(random);
    if (axes.size() < 40 && one_in(2)) {
      const std::array<std::pair<const char*, double>, 3> units =
          slides ? std::array{std::pair("mm", 1e3), std::pair("m", 1.0), std::pair("mm", 1e3)}
                 : std::array{std::pair("deg", 180 / std::numbers::pi), std::pair("rad", 1.0),
                              std::pair("turn", 0.5 / std::numbers::pi)};
      const auto& [unit, size] = units.at(std::uniform_int_distribution<std::size_t>(0, 2)(random));
      axes.push_back({.name = joint.name, .unit = unit, .min = -3 * size, .max = 3 * size});
      stance.coordinates.push_back(value * size);
    } else if (one_in(3)) {
      at += fmt::format("{}\"{}\" = {}", at.empty() ? "" : ", ", joint.name, value);
    } else {
      const bool has_zero = !joint.limit || (joint.limit->lower <= 0 && joint.limit->upper >= 0);
      value = has_zero ? 0 : (joint.limit->lower + joint.limit->upper) / 2;
    }
  }
  stance.rig =
      rig_text(axes, {.more = fmt::format("[kinematics]\nurdf = \"robot.urdf\"\ntip = \"{}\"\nlimits "
                                          "= \"rig\"\nat = {{ {} }}\n",
                                          file.links.back(), at)});
  return stance;
}

double value_of(const Model& model, const urdf::Joint& joint, const Stance& stance) {
  if (!joint.mimic) return stance.values.at(joint.name);
  const auto followed = model->getJoint(joint.mimic->joint_name);
  RC_ASSERT(followed != nullptr);
  return joint.mimic->multiplier * value_of(model, *followed, stance) + joint.mimic->offset;
}

/// As ROS makes KDL's segments of a URDF file.
KDL::Frame frame_of(const Model& model, const std::string& link, const Stance& stance) {
  const auto found = model->getLink(link);
  RC_ASSERT(found != nullptr);
  const auto joint = found->parent_joint;
  if (!joint) return KDL::Frame::Identity();
  const urdf::Pose& from = joint->parent_to_joint_origin_transform;
  const KDL::Frame origin(
      KDL::Rotation::Quaternion(from.rotation.x, from.rotation.y, from.rotation.z, from.rotation.w),
      {from.position.x, from.position.y, from.position.z});
  const KDL::Vector axis = origin.M * KDL::Vector(joint->axis.x, joint->axis.y, joint->axis.z);
  const bool is_fixed = joint->type == urdf::Joint::FIXED;
  const auto kind = joint->type == urdf::Joint::PRISMATIC ? KDL::Joint::TransAxis : KDL::Joint::RotAxis;
  const KDL::Segment segment(
      is_fixed ? KDL::Joint(KDL::Joint::None) : KDL::Joint(joint->name, origin.p, axis, kind), origin);
  return frame_of(model, joint->parent_link_name, stance) *
         segment.pose(is_fixed ? 0 : value_of(model, *joint, stance));
}

/// Of any link, in m.
double largest_distance(const UrdfFile& file, const Model& model, const Stance& stance) {
  const Kinematics kinematics(file, parse_rig(stance.rig, "rig.toml"));
  std::vector<Pose> poses(kinematics.links().size());
  RC_ASSERT(kinematics.tree().poses(stance.coordinates, poses).has_value());
  double largest = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const KDL::Frame expected = frame_of(model, kinematics.links()[i], stance);
    const auto distance = [](const Vector3& v, const KDL::Vector& w) {
      return std::hypot(v.x - w.x(), v.y - w.y(), v.z - w.z());
    };
    largest = std::max({largest, distance(poses[i].position, expected.p),
                        distance(poses[i].rotation.x, expected.M.UnitX()),
                        distance(poses[i].rotation.y, expected.M.UnitY())});
  }
  return largest;
}

struct Reading {
  std::optional<UrdfFile> file;
  std::string reason;
};

Reading read(const std::string& text) {
  try {
    return {parse_urdf(text, "robot.urdf"), ""};
  } catch (const InputError& error) {
    return {std::nullopt, error.what()};
  }
}

constexpr double max_distance = 1e-9;

TEST(UrdfProperty, WhatSixExportersWriteIsReadAsUrdfdomReadsItAndPlacedAsKdlPlacesIt) {
  check_property(10'000, [](std::uint64_t seed) {
    std::mt19937_64 random(seed);
    const UrdfExporter exporter = *rc::gen::elementOf(urdf_exporters);
    const auto joints = static_cast<std::size_t>(*rc::gen::inRange(0, 25));
    const std::string text = text_of(random_robot(random, exporter, joints), random_style(random, exporter));
    RC_LOG() << text;
    const Model model = read_by_urdfdom(text);
    RC_ASSERT(model != nullptr);
    const Reading reading = read(text);
    RC_ASSERT(reading.reason == "");
    RC_ASSERT(difference(*reading.file, model) == "");
    const Stance stance = random_stance(*reading.file, random);
    RC_LOG() << stance.rig;
    RC_ASSERT(largest_distance(*reading.file, model, stance) < max_distance);
  });
}

/// A reason names an element of the tree, and not what stands in it for other programs.
bool names_what_places(const std::string& reason) {
  static const std::regex names(
      R"re(error: (<(link|joint|parent|child|origin|axis|limit|mimic)>|<\w+> is not known in <joint>|)re"
      R"re((there is no )?(link|joint) "))re");
  return std::regex_search(reason, names);
}

TEST(UrdfProperty, AMistakeIsReadAsUrdfdomReadsItOrRefusedForWhatPlaces) {
  check_property(20'000, [](std::uint64_t seed) {
    std::mt19937_64 random(seed);
    const UrdfExporter exporter = *rc::gen::elementOf(urdf_exporters);
    const auto joints = static_cast<std::size_t>(*rc::gen::inRange(1, 12));
    UrdfElement robot = random_robot(random, exporter, joints);
    const UrdfStyle style = random_style(random, exporter);
    const Model before = read_by_urdfdom(text_of(robot, style));
    const UrdfMistake mistake = make_mistake(random, robot);
    const std::string text = text_of(robot, style);
    RC_LOG() << mistake.what << "\n" << text;
    const Model model = read_by_urdfdom(text);
    const Reading reading = read(text);
    if (!reading.file) {
      // Whoever mends what is refused here has a file for urdfdom too.
      RC_LOG() << reading.reason;
      RC_ASSERT(mistake.places);
      RC_ASSERT(names_what_places(reading.reason));
      return;
    }
    // What urdfdom refuses and means nothing to us leaves everything where it was.
    RC_ASSERT(difference(*reading.file, model ? model : before) == "");
    if (!model) return;
    RC_ASSERT(largest_distance(*reading.file, model, random_stance(*reading.file, random)) < max_distance);
  });
}

}  // namespace urdf_property_test
}  // namespace inbetween
