// A rig and its camera as glTF and USD, read by readers of others, against Orocos KDL on the joints written
// again by hand.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host_tools/joints/kinematics.hpp"
#include "host_tools/plan/plan.hpp"
#include "host_tools/scene/axis_rows.hpp"
#include "host_tools/scene/base64.hpp"
#include "host_tools/scene/gltf_writer.hpp"
#include "host_tools/scene/rig_scene.hpp"
#include "host_tools/scene/scene_format.hpp"
#include "host_tools/scene/usda_writer.hpp"
#include "tests/support/example_joints.hpp"
#include "tests/support/oracle_scene.hpp"
#include "tests/support/places.hpp"

namespace inbetween {
namespace scene_export_test {

using testing::ElementsAre;
using testing::HasSubstr;

/// A move of the examples on its rig.
struct Example {
  std::string move, rig;
  Plan plan = planned(move, rig);

  static Plan planned(const std::string& move, const std::string& rig) {
    RigFile file = read_rig_file(in_checkout(rig));
    PlanOptions options;
    if (file.kinematics) options.kinematics = std::make_shared<const Kinematics>(read_kinematics(file));
    return {read_move_file(in_checkout(move)), std::move(file), options};
  }
  [[nodiscard]] RigScene scene(const PlanTableOptions& rows = {}) const {
    const Kinematics& kinematics = *plan.kinematics();
    return scene_of_rig(*plan.rig(), kinematics, camera_tip(*plan.rig(), kinematics, std::nullopt),
                        rows_of_plan(plan, rows));
  }
  /// Of every axis of the rig, in its order.
  [[nodiscard]] std::vector<double> axes_at(const FrameTime& time) const {
    std::vector<double> of_move(plan.motion().axis_count()), of_rig;
    plan.motion().positions(time, of_move);
    for (const PlanAxis& axis : plan.axes()) of_rig.push_back(of_move[axis.move_axis]);
    return of_rig;
  }
};

Example crane() {
  return {"examples/crane/over_the_table.toml", "examples/crane/rig.toml"};
}

struct Miss {
  double m = 0, rad = 0;
  void raise(const OraclePose& a, const OraclePose& b) {
    double apart = 0, angle = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      apart += std::pow(a.position[i] - b.position[i], 2);
      double chord = 0;
      for (std::size_t j = 0; j < 3; ++j) chord += std::pow(a.columns[i][j] - b.columns[i][j], 2);
      angle = std::max(angle, 2 * std::asin(std::min(1.0, std::sqrt(chord) / 2)));
    }
    m = std::max(m, std::sqrt(apart));
    rad = std::max(rad, angle);
  }
};

const OracleTree& crane_by_hand() {
  static const OracleTree tree(joints_of_crane());
  return tree;
}
constexpr int crane_tip = 7;

OraclePose crane_camera(const Example& example, double frame) {
  const FrameTime time{static_cast<std::int32_t>(std::floor(frame)), frame - std::floor(frame)};
  return camera_of(crane_by_hand().pose(crane_tip, example.axes_at(time)));
}

TEST(SceneExport, TheCameraInGltfIsOnEveryFrameWhereTheRigTakesIt) {
  const Example example = crane();
  const RigScene made = example.scene();
  for (const GltfForm form : {GltfForm::text, GltfForm::binary}) {
    const GltfText text = write_gltf(made.scene, form);
    const OracleGltf read(text.bytes);
    EXPECT_EQ(read.camera_node(), "camera_view");
    const std::vector<double> times = read.times();
    ASSERT_EQ(times.size(), 289U);
    Miss camera;
    for (std::size_t row = 0; row < times.size(); ++row) {
      EXPECT_NEAR(times[row], static_cast<double>(row) / 24, text.rounding.time_s);
      camera.raise(read.pose("camera_view", times[row]),
                   in_y_up(crane_camera(example, static_cast<double>(row))));
    }
    EXPECT_LE(camera.m, 1e-9);
    EXPECT_LE(camera.rad, 2e-7);
    EXPECT_LE(camera.m, text.rounding.camera_m + 1e-12);
    EXPECT_LE(camera.rad, text.rounding.camera_rad * 1.01);
  }
}

TEST(SceneExport, TheCameraInUsdIsOnEveryFrameWhereTheRigTakesIt) {
  const Example example = crane();
  const RigScene made = example.scene();
  const OracleUsd read(write_usda(made.scene));
  EXPECT_EQ(read.layer("upAxis"), "Z");
  EXPECT_EQ(read.layer("timeCodesPerSecond"), "24");
  EXPECT_EQ(read.layer("endTimeCode"), "288");
  EXPECT_EQ(read.prim_of_type("Camera"), "camera_view");
  Miss camera;
  for (int frame = 0; frame <= 288; ++frame)
    camera.raise(read.pose("camera_view", frame), crane_camera(example, frame));
  EXPECT_LE(camera.m, 1e-12);
  EXPECT_LE(camera.rad, 1e-7);  // the chord of so small an angle has no more digits
}

TEST(SceneExport, UsdHasTheUnitAndTheUpAxisThatAreAskedFor) {
  const Example example = crane();
  const OracleUsd read(write_usda(example.scene().scene, {.up = UpAxis::y, .metres_per_unit = 0.01}));
  EXPECT_EQ(read.layer("upAxis"), "Y");
  EXPECT_EQ(read.layer("metersPerUnit"), "0.01");
  Miss camera;
  for (int frame = 0; frame <= 288; frame += 12) {
    OraclePose pose = read.pose("camera_view", frame);
    for (double& number : pose.position) number /= 100;
    camera.raise(pose, in_y_up(crane_camera(example, frame)));
  }
  EXPECT_LE(camera.m, 1e-12);
  EXPECT_LE(camera.rad, 1e-7);
  const OracleLens lens = read.lens();
  EXPECT_NEAR(lens.focal_length_mm, 50, 1e-9);
  EXPECT_NEAR(lens.width_mm, 36, 1e-9);
  EXPECT_NEAR(lens.height_mm, 24, 1e-9);
  EXPECT_NEAR(lens.focus_m, 2, 1e-9);
}

TEST(SceneExport, TheLensInGltfIsAnAngleOfView) {
  const OracleGltf read(write_gltf(crane().scene().scene, GltfForm::text).bytes);
  EXPECT_NEAR(read.vertical_angle(), 2 * std::atan(12.0 / 50), 1e-9);
  EXPECT_NEAR(read.aspect(), 1.5, 1e-9);
}

/// What is told of the places between two rows is true, and no more than 30 times what is found there.
TEST(SceneExport, BetweenTwoRowsTheCameraIsWithinTheBound) {
  const Example example = crane();
  for (const FrameRate fps : {FrameRate{24, 1}, FrameRate{5, 1}, FrameRate{96, 1}}) {
    const RigScene made = example.scene({.fps = fps});
    const OracleUsd read(write_usda(made.scene));
    Miss camera;
    const double frames_a_row = 24 / fps.frames_per_second();
    for (double row = 0; row < static_cast<double>(made.scene.rows) - 1; row += 0.21) {
      camera.raise(read.pose("camera_view", row), crane_camera(example, std::min(288.0, row * frames_a_row)));
    }
    EXPECT_LE(camera.m, made.scene.between.place_m);
    EXPECT_LE(camera.rad, made.scene.between.turn_rad + 1e-7);
    EXPECT_GE(camera.m * 30, made.scene.between.place_m) << fps.numerator;
  }
}

TEST(SceneExport, EveryLinkIsANodeInItsParent) {
  const Example example = crane();
  const OracleUsd read(write_usda(example.scene().scene));
  const std::vector<std::string> links = {"carriage", "column", "boom", "plate",
                                          "yoke",     "cradle", "ring", "camera"};
  Miss all;
  for (int frame = 0; frame <= 288; frame += 16) {
    const std::vector<double> axes = example.axes_at({frame, 0});
    for (std::size_t link = 0; link < links.size(); ++link)
      all.raise(read.pose(links[link], frame), crane_by_hand().pose(static_cast<int>(link), axes));
  }
  EXPECT_LE(all.m, 1e-12);
}

std::string refusal(const std::function<void()>& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing was refused";
}

TEST(SceneExport, ACameraThatNobodyKnowsThePlaceOfIsRefused) {
  const Example walk{"examples/marionette/walk.toml", "examples/marionette/rig.toml"};
  const Kinematics& kinematics = *walk.plan.kinematics();
  EXPECT_THAT(refusal([&] { camera_tip(*walk.plan.rig(), kinematics, std::nullopt); }),
              HasSubstr("several tips and no [lens]; say with --tip which of head, left_foot"));
  EXPECT_THAT(refusal([&] { camera_tip(*walk.plan.rig(), kinematics, "hat"); }),
              HasSubstr("no tip \"hat\"; name one of"));
  EXPECT_EQ(camera_tip(*walk.plan.rig(), kinematics, "head").name, "head");
  const Example example = crane();
  AxisRows rows = rows_of_plan(example.plan);
  const Tip& tip = camera_tip(*example.plan.rig(), *example.plan.kinematics(), std::nullopt);
  rows.axes.erase(rows.axes.begin() + 2);
  EXPECT_THAT(refusal([&] { scene_of_rig(*example.plan.rig(), *example.plan.kinematics(), tip, rows); }),
              HasSubstr("axis \"boom\" moves camera and is in no track"));
}

TEST(SceneExport, AJointThatTurnsHalfATurnBetweenTwoRowsIsRefused) {
  const Example orrery{"examples/orrery/one_year.toml", "examples/orrery/rig.toml"};
  const Kinematics& kinematics = *orrery.plan.kinematics();
  const Tip& moon = camera_tip(*orrery.plan.rig(), kinematics, "moon");
  EXPECT_THAT(refusal([&] {
                scene_of_rig(*orrery.plan.rig(), kinematics, moon,
                             rows_of_plan(orrery.plan, {.fps = FrameRate{1, 1}}));
              }),
              HasSubstr("other programs would turn it the other way; write more rows a second with --fps"));
  EXPECT_EQ(scene_of_rig(*orrery.plan.rig(), kinematics, moon, rows_of_plan(orrery.plan)).scene.rows, 481U);
}

TEST(SceneExport, NeighbouringQuaternionsAreTheShorterWayApart) {
  // Thirteen turns of the moon pass every sign of a quaternion.
  const Example orrery{"examples/orrery/one_year.toml", "examples/orrery/rig.toml"};
  const Tip& moon = camera_tip(*orrery.plan.rig(), *orrery.plan.kinematics(), "moon");
  const AnimatedScene scene =
      scene_of_rig(*orrery.plan.rig(), *orrery.plan.kinematics(), moon, rows_of_plan(orrery.plan)).scene;
  for (const SceneNode& node : scene.nodes)
    for (std::size_t row = 1; row < node.turns.size(); ++row)
      EXPECT_GT(dot(node.turns[row - 1], node.turns[row]), 0);
}

TEST(SceneExport, AFileIsASceneByItsEndingOrByTheWord) {
  EXPECT_EQ(scene_format_of(std::nullopt, "a.GLB"), SceneFormat::glb);
  EXPECT_EQ(scene_format_of(std::nullopt, "a.csv"), std::nullopt);
  EXPECT_EQ(scene_format_of("usda", "a.txt"), SceneFormat::usda);
  EXPECT_EQ(scene_format_of("csv", "a.gltf"), std::nullopt);
  EXPECT_THAT(refusal([] { scene_format_of(std::nullopt, "a.usdc"); }),
              HasSubstr("take USD as text (.usda) or glTF"));
}

TEST(SceneExport, NamesThatUsdDoesNotHaveAreSpelledOtherwise) {
  AnimatedScene scene{.name = "1st \"take\"", .fps = {}, .rows = 2, .nodes = {}, .camera = {}, .between = {}};
  scene.nodes.push_back({.name = "left arm", .rest = {}});
  scene.nodes.push_back({.name = "left-arm", .rest = {}});
  scene.nodes.push_back({.name = "lens", .parent = 1, .rest = {}});
  scene.camera.node = 2;
  const OracleUsd read(write_usda(scene));
  EXPECT_EQ(read.layer("defaultPrim"), "_1st__take_");
  EXPECT_EQ(read.attribute("left_arm_2", "inbetween:name"), "left-arm");
}

TEST(Base64, IsThatOfTheStandard) {
  // RFC 4648, 10.
  const std::vector<std::pair<std::string, std::string>> vectors = {{"", ""},
                                                                    {"f", "Zg=="},
                                                                    {"fo", "Zm8="},
                                                                    {"foo", "Zm9v"},
                                                                    {"foob", "Zm9vYg=="},
                                                                    {"fooba", "Zm9vYmE="},
                                                                    {"foobar", "Zm9vYmFy"}};
  for (const auto& [bytes, text] : vectors) {
    EXPECT_EQ(base64_of(bytes), text);
    EXPECT_EQ(bytes_of_base64(text), bytes);
  }
  EXPECT_EQ(bytes_of_base64("Zg="), std::nullopt);
  EXPECT_EQ(bytes_of_base64("Z*=="), std::nullopt);
}

}  // namespace scene_export_test
}  // namespace inbetween
