// Random moves of five rigs as scenes: what readers of others find on every frame, against Orocos KDL, and
// what comes back between the frames.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "host_tools/joints/kinematics.hpp"
#include "host_tools/joints/urdf_file.hpp"
#include "host_tools/plan/plan.hpp"
#include "host_tools/scene/axis_rows.hpp"
#include "host_tools/scene/gltf_reader.hpp"
#include "host_tools/scene/gltf_writer.hpp"
#include "host_tools/scene/rig_poses.hpp"
#include "host_tools/scene/rig_scene.hpp"
#include "host_tools/scene/scene_poses.hpp"
#include "host_tools/scene/usda_reader.hpp"
#include "host_tools/scene/usda_writer.hpp"
#include "host_tools/text/text_file.hpp"
#include "tests/support/oracle_kinematics.hpp"
#include "tests/support/oracle_scene.hpp"
#include "tests/support/places.hpp"
#include "tests/support/property.hpp"

namespace inbetween {
namespace scene_property_test {

double between(std::mt19937_64& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

struct RigOfExample {
  std::string folder, tip;
};
const std::array<RigOfExample, 5> rigs = {{{"crane", "camera"},
                                           {"arm", "hand"},
                                           {"brow", "middle"},
                                           {"marionette", "left_hand"},
                                           {"orrery", "moon"}}};

/// A rig, and its joints as the oracle has them.
struct JointedRig {
  RigFile rig;
  std::shared_ptr<const Kinematics> kinematics;
  std::vector<OracleJoint> joints;
  int tip = 0;
};

OracleJoint oracle_joint(const UrdfFile& urdf, std::size_t index, const RigFile& rig) {
  const UrdfJoint& joint = urdf.joints[index];
  OracleJoint made{
      .parent = static_cast<int>(joint.parent) - 1, .xyz = joint.xyz, .rpy = joint.rpy, .axis = joint.axis};
  const UrdfJoint& driver = joint.mimic ? urdf.joints[joint.mimic->joint] : joint;
  const auto axis = std::ranges::find(rig.axes, driver.name, &RigAxis::name);
  if (joint.kind == UrdfJointKind::fixed || axis == rig.axes.end()) return made;
  made.kind = joint.kind == UrdfJointKind::prismatic ? OracleJointKind::prismatic : OracleJointKind::revolute;
  made.coordinate = static_cast<int>(axis - rig.axes.begin());
  const double unit = axis->unit == AxisUnit::deg  ? std::numbers::pi / 180
                      : axis->unit == AxisUnit::mm ? 1e-3
                                                   : 1;
  made.factor = unit * (joint.mimic ? joint.mimic->multiplier : 1);
  made.offset = joint.mimic ? joint.mimic->offset : 0;
  return made;
}

JointedRig jointed_rig(const RigOfExample& example) {
  JointedRig made;
  const std::string folder = in_checkout("examples/" + example.folder);
  made.rig = read_rig_file(folder + "/rig.toml");
  made.kinematics = std::make_shared<const Kinematics>(read_kinematics(made.rig));
  const std::string urdf_path = folder + "/" + made.rig.kinematics->urdf;
  const UrdfFile urdf = parse_urdf(read_text_file(urdf_path), urdf_path);
  for (std::size_t i = 0; i < urdf.joints.size(); ++i) made.joints.push_back(oracle_joint(urdf, i, made.rig));
  made.tip = static_cast<int>(std::ranges::find(urdf.links, example.tip) - urdf.links.begin()) - 1;
  return made;
}

/// All axes of the rig through two to six random places.
std::string random_move(const RigFile& rig, std::mt19937_64& random) {
  const int frames = std::uniform_int_distribution<int>(20, 60)(random);
  std::string text = fmt::format("name = \"random\"\nfps = {}\nframes = {}\n\n[[track]]\naxes = [",
                                 random() % 2 == 0 ? "24" : "\"30000/1001\"", frames);
  for (const RigAxis& axis : rig.axes) text += fmt::format("\"{}\", ", axis.name);
  text += "]\nkeys = [\n";
  const int keys = std::uniform_int_distribution<int>(2, 6)(random);
  for (int key = 0; key < keys; ++key) {
    text += "  { at = [";
    for (const RigAxis& axis : rig.axes) {
      const double most = axis.unit == AxisUnit::deg ? 100 : 1000;  // no joint turns half a turn in a frame
      text += fmt::format("{}, ", between(random, std::max(axis.min, -most), std::min(axis.max, most)));
    }
    text += "] },\n";
  }
  text += "]\nspeed = [0, 0, 10, 10, 0, 0]\nweights = [";
  for (std::size_t a = 0; a < rig.axes.size(); ++a) text += "1, ";
  return text + "]\n";
}

struct Apart {
  double m = 0, rad = 0;
};
Apart apart(const OraclePose& a, const OraclePose& b) {
  Apart found;
  double squares = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    squares += std::pow(a.position[i] - b.position[i], 2);
    double chord = 0;
    for (std::size_t j = 0; j < 3; ++j) chord += std::pow(a.columns[i][j] - b.columns[i][j], 2);
    found.rad = std::max(found.rad, 2 * std::asin(std::min(1.0, std::sqrt(chord) / 2)));
  }
  found.m = std::sqrt(squares);
  return found;
}

OraclePose as_oracle(const Pose& pose) {
  const auto three = [](const Vector3& v) { return std::array<double, 3>{v.x, v.y, v.z}; };
  return {three(pose.position), {three(pose.rotation.x), three(pose.rotation.y), three(pose.rotation.z)}};
}

std::vector<double> axes_of_rig(const Plan& plan, const RigFile& rig, const FrameTime& time) {
  std::vector<double> of_move(plan.motion().axis_count()), of_rig(rig.axes.size());
  plan.motion().positions(time, of_move);
  for (const PlanAxis& axis : plan.axes()) {
    const auto at = std::ranges::find(rig.axes, axis.name, &RigAxis::name);
    of_rig[static_cast<std::size_t>(at - rig.axes.begin())] = of_move[axis.move_axis];
  }
  return of_rig;
}

struct MadeScene {
  JointedRig rig;
  std::unique_ptr<Plan> plan;
  RigScene made;
  std::string text;
};
MadeScene random_scene(std::mt19937_64& random) {
  const RigOfExample& example = rigs.at(random() % rigs.size());
  MadeScene scene{.rig = jointed_rig(example), .plan = nullptr, .made = {}, .text = {}};
  scene.text = random_move(scene.rig.rig, random);
  scene.plan = std::make_unique<Plan>(parse_move(scene.text, "random.toml"), scene.rig.rig,
                                      PlanOptions{.kinematics = scene.rig.kinematics});
  const Tip& tip = camera_tip(scene.rig.rig, *scene.rig.kinematics, example.tip);
  scene.made = scene_of_rig(scene.rig.rig, *scene.rig.kinematics, tip, rows_of_plan(*scene.plan));
  return scene;
}

TEST(SceneProperty, TheCameraIsWhereTheRigTakesItOnEveryFrameInReadersOfOthers) {
  check_property(1'000, [](std::uint64_t seed) {
    std::mt19937_64 random(seed);
    const MadeScene scene = random_scene(random);
    RC_LOG() << scene.text;
    const AnimatedScene& made = scene.made.scene;
    const std::string camera = made.nodes.back().name;
    const OracleTree oracle(scene.rig.joints);
    const OracleGltf gltf(write_gltf(made, random() % 2 == 0 ? GltfForm::text : GltfForm::binary).bytes);
    const OracleUsd usd(write_usda(made));
    const std::vector<double> times = gltf.times();
    RC_ASSERT(times.size() == made.rows);
    for (std::size_t row = 0; row < made.rows; ++row) {
      const std::vector<double> axes =
          axes_of_rig(*scene.plan, scene.rig.rig, {static_cast<std::int32_t>(row), 0});
      const OraclePose exact = camera_of(oracle.pose(scene.rig.tip, axes));
      const Apart in_usd = apart(usd.pose(camera, static_cast<double>(row)), exact);
      const Apart in_gltf = apart(gltf.pose(camera, times[row]), in_y_up(exact));
      RC_ASSERT(in_usd.m <= 1e-9 && in_usd.rad <= 1e-7);  // so many digits has the chord of an angle
      RC_ASSERT(in_gltf.m <= 1e-8 && in_gltf.rad <= 5e-7);
    }
  });
}

TEST(SceneProperty, WhatComesBackIsWithinTheBoundThatIsStated) {
  check_property(1'000, [](std::uint64_t seed) {
    std::mt19937_64 random(seed);
    const MadeScene scene = random_scene(random);
    RC_LOG() << scene.text;
    const AnimatedScene& made = scene.made.scene;
    const bool is_gltf = random() % 2 == 0;
    const UsdaChoices choices{.up = random() % 2 == 0 ? UpAxis::y : UpAxis::z,
                              .metres_per_unit = random() % 2 == 0 ? 1 : 0.01};
    const GltfText text = write_gltf(made, GltfForm::binary);
    const SceneFile back =
        is_gltf ? read_gltf(text.bytes, "a.glb") : read_usda(write_usda(made, choices), "a.usda");
    const std::size_t node = chosen_node(back, std::nullopt);
    const SceneRows rows = rows_of_node(back, node, {}, made.fps);
    RC_ASSERT(rows.poses.size() == made.rows);
    RC_ASSERT(rows.fps == made.fps);
    const OracleTree oracle(scene.rig.joints);
    const StagedNode staged(back, node, {});
    for (int i = 0; i < 60; ++i) {
      const double frame = between(random, 0, static_cast<double>(made.rows - 1));
      const FrameTime time{static_cast<std::int32_t>(frame), frame - std::floor(frame)};
      const std::vector<double> axes = axes_of_rig(*scene.plan, scene.rig.rig, time);
      const Apart off = apart(as_oracle(staged.at(rows.code(frame))), oracle.pose(scene.rig.tip, axes));
      // The times of glTF are rounded too; no tip of these moves at more than 20 m/s and 400 rad/s.
      const double time_off = is_gltf ? 2 * text.rounding.time_s : 0;
      RC_ASSERT(off.m <= made.between.place_m + 1e-9 + 20 * time_off);
      RC_ASSERT(off.rad <= made.between.turn_rad + 5e-7 + 400 * time_off);
    }
  });
}

TEST(SceneProperty, TheAxesOfACraneComeBackFromItsCamera) {
  check_property(300, [](std::uint64_t seed) {
    std::mt19937_64 random(seed);
    const JointedRig rig = jointed_rig(rigs[0]);
    // Within what a head does upright; near the poles pan and roll are one.
    std::string text =
        "name = \"random\"\nfps = 24\nframes = 40\n[[track]]\naxes = [\"track\", \"swing\", \"boom\", "
        "\"pan\", \"tilt\", \"roll\"]\nkeys = [\n";
    for (int key = 0; key < 4; ++key) {
      text += fmt::format("  {{ at = [{}, {}, {}, {}, {}, {}] }},\n", between(random, 1500, 2500),
                          between(random, -60, 60), between(random, -20, 40), between(random, -90, 90),
                          between(random, -60, 60), between(random, -60, 60));
    }
    text += "]\nspeed = [0, 0, 10, 10, 0, 0]\nweights = [1, 1, 1, 1, 1, 1]\n";
    RC_LOG() << text;
    const Plan plan(parse_move(text, "random.toml"), rig.rig, PlanOptions{.kinematics = rig.kinematics});
    const Tip& tip = camera_tip(rig.rig, *rig.kinematics, std::nullopt);
    const RigScene made = scene_of_rig(rig.rig, *rig.kinematics, tip, rows_of_plan(plan));
    const SceneFile back = read_usda(write_usda(made.scene), "a.usda");
    const ScenePlacement placement{};
    const SceneRows rows = rows_of_node(back, chosen_node(back, std::nullopt), placement, std::nullopt);
    const BakedTable table = axes_of_poses(rig.rig, *rig.kinematics, tip, back, rows);
    const OracleTree oracle(rig.joints);
    for (std::size_t row = 0; row < table.rows(); ++row) {
      std::vector<double> axes;
      for (const BakedColumn& column : table.columns) axes.push_back(column.values[row]);
      const Apart off =
          apart(oracle.pose(rig.tip, axes),
                oracle.pose(rig.tip, axes_of_rig(plan, rig.rig, {static_cast<std::int32_t>(row), 0})));
      RC_ASSERT(off.m <= 1e-9 && off.rad <= 1e-7);
    }
  });
}

}  // namespace scene_property_test
}  // namespace inbetween
