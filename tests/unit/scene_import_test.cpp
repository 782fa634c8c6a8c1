// Scenes of other programs as they come in: how they are read, how they stand on the stage, and what is
// refused.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "host_tools/joints/kinematics.hpp"
#include "host_tools/scene/base64.hpp"
#include "host_tools/scene/gltf_reader.hpp"
#include "host_tools/scene/rig_poses.hpp"
#include "host_tools/scene/rig_scene.hpp"
#include "host_tools/scene/scene_poses.hpp"
#include "host_tools/scene/usda_reader.hpp"
#include "tests/support/example_joints.hpp"
#include "tests/support/places.hpp"
#include "tests/support/refused_text.hpp"

namespace inbetween {
namespace scene_import_test {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

SceneFile usd(const std::string& text) {
  return read_usda("#usda 1.0\n" + text, "a.usda");
}

void expect_vector(const Vector3& found, double x, double y, double z) {
  EXPECT_NEAR(found.x, x, 1e-12);
  EXPECT_NEAR(found.y, y, 1e-12);
  EXPECT_NEAR(found.z, z, 1e-12);
}

std::string refusal(const std::function<void()>& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing was refused";
}

/// The point (1, 2, 3) of prim "a" with these properties, in its parent.
Vector3 moved_point(const std::string& properties, double code = 0) {
  const SceneFile scene = usd("def Xform \"a\"\n{\n" + properties + "\n}\n");
  return world_of(scene, 0, code) * Vector3{1, 2, 3};
}

TEST(UsdaReader, EveryOpIsWhatUsdSays) {
  // UsdGeomXformOp: the first of the order is the outermost; angles are degrees, counterclockwise about an
  // axis.
  expect_vector(moved_point("double3 xformOp:translate = (10, 0, 0)\n"
                            "uniform token[] xformOpOrder = [\"xformOp:translate\"]"),
                11, 2, 3);
  expect_vector(
      moved_point("float xformOp:rotateZ = 90\nuniform token[] xformOpOrder = [\"xformOp:rotateZ\"]"), -2, 1,
      3);
  // First about x: (1, -3, 2); then about z: (3, 1, 2).
  expect_vector(
      moved_point(
          "float3 xformOp:rotateXYZ = (90, 0, 90)\nuniform token[] xformOpOrder = [\"xformOp:rotateXYZ\"]"),
      3, 1, 2);
  // First about z: (-2, 1, 3); then about x: (-2, -3, 1).
  expect_vector(
      moved_point(
          "float3 xformOp:rotateZYX = (90, 0, 90)\nuniform token[] xformOpOrder = [\"xformOp:rotateZYX\"]"),
      -2, -3, 1);
  // The real part of a quaternion stands first: half a turn about y.
  expect_vector(
      moved_point("quatf xformOp:orient = (0, 0, 1, 0)\nuniform token[] xformOpOrder = [\"xformOp:orient\"]"),
      -1, 2, -3);
  expect_vector(
      moved_point("half3 xformOp:scale = (2, 3, 4)\nuniform token[] xformOpOrder = [\"xformOp:scale\"]"), 2,
      6, 12);
  // A point stands at the left of a matrix: its last row is the place.
  expect_vector(
      moved_point(
          "matrix4d xformOp:transform = ( (0, 1, 0, 0), (-1, 0, 0, 0), (0, 0, 1, 0), (10, 20, 30, 1) )\n"
          "uniform token[] xformOpOrder = [\"xformOp:transform\"]"),
      8, 21, 33);
  // Turned about a pivot at (1, 0, 0).
  expect_vector(
      moved_point("double3 xformOp:translate:pivot = (1, 0, 0)\nfloat xformOp:rotateZ = 90\n"
                  "uniform token[] xformOpOrder = [\"xformOp:translate:pivot\", \"xformOp:rotateZ\", "
                  "\"!invert!xformOp:translate:pivot\"]"),
      -1, 0, 3);
  // What is not in the order does nothing.
  expect_vector(moved_point("double3 xformOp:translate = (10, 0, 0)"), 1, 2, 3);
}

TEST(UsdaReader, SamplesAreInterpolatedAndHeldOutside) {
  const std::string turning =
      "float xformOp:rotateZ.timeSamples = { 0: 0, 10: 90, }\nuniform token[] xformOpOrder = "
      "[\"xformOp:rotateZ\"]";
  expect_vector(moved_point(turning, -5), 1, 2, 3);
  expect_vector(moved_point(turning, 99), -2, 1, 3);
  const double c = std::cos(std::numbers::pi / 4);
  expect_vector(moved_point(turning, 5), c * 1 - c * 2, c * 1 + c * 2, 3);
  const std::string quaternions =
      "quatf xformOp:orient.timeSamples = { 0: (1, 0, 0, 0), 10: (0, 0, 0, -1) }\nuniform token[] "
      "xformOpOrder = [\"xformOp:orient\"]";
  expect_vector(moved_point(quaternions, 5), 2, -1, 3);  // half a turn, the shorter way is a quarter back
}

TEST(UsdaReader, AStageIsInHundredthsOfAMetreWithYUpWhereItSaysNothing) {
  const SceneFile scene = usd("def Camera \"c\" { }\n");
  EXPECT_EQ(scene.metres_per_unit, 0.01);
  EXPECT_EQ(scene.up, UpAxis::y);
  EXPECT_EQ(scene.codes_per_second, 24);
  const SceneFile said =
      usd("( upAxis = \"Z\" metersPerUnit = 1 timeCodesPerSecond = 50 startTimeCode = 1 endTimeCode = 9 )\n");
  EXPECT_EQ(said.metres_per_unit, 1);
  EXPECT_EQ(said.up, UpAxis::z);
  EXPECT_EQ(said.codes_per_second, 50);
  EXPECT_EQ(said.first, 1);
  EXPECT_EQ(said.last, 9);
}

TEST(UsdaReader, WhatOtherProgramsWriteBesidesIsPassedOver) {
  const SceneFile scene = usd(R"((
    doc = """Blender v3.4.1
"quoted" """
    defaultPrim = "root"
    subLayers = [ @./more.usda@ ]
)
# a comment
def Xform "root" (
    customData = { dictionary Blender = { bool generated = 1 } }
    prepend references = @other.usda@</x>
    kind = "assembly"
)
{
    def Mesh "mesh" ( active = true )
    {
        float3[] extent = [(-1, -1, -1), (1, 1, 1)]
        int[] faceVertexCounts = [4, 4]
        normal3f[] normals = [(0, 0, 1)] ( interpolation = "faceVarying" )
        uniform token subdivisionScheme = "none"
        rel material:binding = </root/paint>
        custom string userProperties:blenderName:object = "mesh"
        asset file = @a b.png@
        float inputs:x.connect = </root/paint.outputs:r>
        point3f[] points.timeSamples = { 0: [(0, 0, 0)], 1: None, }
    }
    variantSet "look" = { "red" { def Camera "hidden" { } } }
    def Camera "camera"
    {
        float focalLength = 35
    }
}
)");
  ASSERT_EQ(scene.nodes.size(), 3U);
  EXPECT_EQ(path_of(scene, 2), "/root/camera");
  EXPECT_TRUE(scene.nodes[2].is_camera);
  ASSERT_EQ(scene.warnings.size(), 3U);
  EXPECT_THAT(scene.warnings[0].message, HasSubstr("(subLayers) is not read"));
  EXPECT_THAT(scene.warnings[1].message, HasSubstr("(references) is not read"));
  EXPECT_THAT(scene.warnings[2].message, HasSubstr("variants are not read"));
}

TEST(UsdaReader, WhatIsWrongIsRefusedWithItsPlace) {
  const auto parse = [](const std::string& text, const std::string& file) { read_usda(text, file); };
  expect_refused(parse, "@usda 1.0", {"#usda 1.0"});
  expect_refused(parse, "#usda 1.0\ndef Xform @a { }", {"a prim has a name in quotes"});
  expect_refused(parse, "#usda 1.0\ndef Xform \"a\" {\n  double3 xformOp:translate = @(1, 2)\n}",
                 {"2 numbers in place of 3"});
  expect_refused(parse, "#usda 1.0\ndef Xform \"a\" {\n  double3 xformOp:translate = (1, @nan, 2)\n}",
                 {"no number"});
  expect_refused(parse, "#usda 1.0\ndef Xform \"a\" {\n  quatf @xformOp:orient = (0, 0, 0, 0)\n}",
                 {"turns nowhere"});
  expect_refused(parse, "#usda 1.0\ndef Xform \"a\" {\n  float @xformOp:shear = 1\n}",
                 {"the op \"shear\" is not read"});
  expect_refused(parse,
                 "#usda 1.0\ndef Xform \"a\" {\n  float xformOp:rotateX.timeSamples = { 1: 0, @1: 2 }\n}",
                 {"do not ascend"});
  expect_refused(parse, "#usda 1.0\n( upAxis = @\"X\" )", {"up is Y or Z"});
  expect_refused(parse, "#usda 1.0\n( metersPerUnit = @0 )", {"above 0"});
  expect_refused(parse, "#usda 1.0\ndef Xform \"a\" {\n  string s = @\"open\n}", {"no quote ends this text"});
  expect_refused(parse, "#usda 1.0\ndef Xform \"a\" {\n  int[] x = [1, 2@", {"the text ends within a value"});
  EXPECT_THAT(refusal([] { read_usda("PXR-USDC\0", "a.usda"); }),
              HasSubstr("USD in binary; write it as text"));
  std::string deep = "#usda 1.0\n";
  for (int i = 0; i < 200; ++i) deep += "def \"a\" {";
  EXPECT_THAT(refusal([&] { read_usda(deep, "a.usda"); }), HasSubstr("deeper than 128"));
}

// --- glTF

std::string floats(const std::vector<float>& numbers) {
  std::string bytes(numbers.size() * 4, '\0');
  std::memcpy(bytes.data(), numbers.data(), bytes.size());
  return bytes;
}

/// A camera that slides along x from time 0 to 2 s, carried by a node that is `carrier`; `outputs` are its
/// values.
std::string sliding(const std::string& interpolation, const std::vector<float>& outputs,
                    const std::string& carrier = "") {
  const std::string bytes = floats({0, 2}) + floats(outputs);
  return fmt::format(
      R"({{"asset": {{"version": "2.0"}}, "nodes": [{{"name": "camera", "camera": 0}}, {{"name": "set", "children": [0]{}}}],
"buffers": [{{"byteLength": {}, "uri": "data:application/octet-stream;base64,{}"}}],
"bufferViews": [{{"buffer": 0, "byteLength": 8}}, {{"buffer": 0, "byteOffset": 8, "byteLength": {}}}],
"accessors": [{{"bufferView": 0, "componentType": 5126, "count": 2, "type": "SCALAR"}},
{{"bufferView": 1, "componentType": 5126, "count": {}, "type": "VEC3"}}],
"animations": [{{"samplers": [{{"input": 0, "output": 1, "interpolation": "{}"}}],
"channels": [{{"sampler": 0, "target": {{"node": 0, "path": "translation"}}}}]}}]}})",
      carrier, bytes.size(), base64_of(bytes), outputs.size() * 4, outputs.size() / 3, interpolation);
}

double x_at(const SceneFile& scene, double seconds) {
  return world_of(scene, chosen_node(scene, std::nullopt), seconds).origin.x;
}

TEST(GltfReader, CurvesAreLinesStepsAndCubics) {
  const SceneFile line = read_gltf(sliding("LINEAR", {0, 0, 0, 8, 0, 0}), "a.gltf");
  EXPECT_DOUBLE_EQ(x_at(line, 0.5), 2);
  EXPECT_DOUBLE_EQ(x_at(line, -1), 0);
  EXPECT_DOUBLE_EQ(x_at(line, 3), 8);
  const SceneFile step = read_gltf(sliding("STEP", {0, 0, 0, 8, 0, 0}), "a.gltf");
  EXPECT_DOUBLE_EQ(x_at(step, 1.99), 0);
  // Tangents are per second: x = t^3 from 0 to 2 has 0 and 12.
  const SceneFile cubic =
      read_gltf(sliding("CUBICSPLINE", {0, 0, 0, 0, 0, 0, 0, 0, 0, 12, 0, 0, 8, 0, 0, 0, 0, 0}), "a.gltf");
  EXPECT_NEAR(x_at(cubic, 0.5), 0.125, 1e-12);
  EXPECT_NEAR(x_at(cubic, 1.5), 3.375, 1e-12);
  // And 8 - (2 - t)^3 has 12 and 0.
  const SceneFile slowing =
      read_gltf(sliding("CUBICSPLINE", {0, 0, 0, 0, 0, 0, 12, 0, 0, 0, 0, 0, 8, 0, 0, 0, 0, 0}), "a.gltf");
  EXPECT_NEAR(x_at(slowing, 0.5), 4.625, 1e-12);
}

TEST(GltfReader, WhatCarriesANodeMovesIt) {
  const SceneFile scene = read_gltf(
      sliding("LINEAR", {0, 0, 0, 8, 0, 0}, R"(, "scale": [2, 2, 2], "translation": [1, 0, 0])"), "a.gltf");
  EXPECT_EQ(path_of(scene, chosen_node(scene, std::nullopt)), "/set/camera");
  EXPECT_DOUBLE_EQ(x_at(scene, 1), 9);
}

TEST(GltfReader, ItsNumbersMayStandInAFileBesideIt) {
  const std::string text =
      R"({"asset": {"version": "2.0"}, "nodes": [{"camera": 0}], "buffers": [{"byteLength": 32, "uri": "URI"}],
"bufferViews": [{"buffer": 0, "byteLength": 8}, {"buffer": 0, "byteOffset": 8, "byteLength": 24}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 2, "type": "SCALAR"}, {"bufferView": 1, "componentType": 5126, "count": 2, "type": "VEC3"}],
"animations": [{"samplers": [{"input": 0, "output": 1}], "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]}]})";
  const TextReader reader = [](const std::filesystem::path& path, std::size_t) {
    EXPECT_EQ(path, "folder/a shot.bin");
    return floats({0, 2, 0, 0, 0, 8, 0, 0});
  };
  EXPECT_DOUBLE_EQ(x_at(read_gltf(with(text, "URI", "a%20shot.bin"), "folder/a.gltf", reader), 1), 4);
  for (const char* outside : {"/etc/passwd", "../a.bin", "a/%2e%2e/b.bin", "http://a/b"}) {
    EXPECT_THAT(refusal([&] { read_gltf(with(text, "URI", outside), "folder/a.gltf", reader); }),
                HasSubstr("not in the folder of the scene"))
        << outside;
  }
}

TEST(GltfReader, WhatIsWrongIsRefusedWithItsPlace) {
  const std::string good = sliding("LINEAR", {0, 0, 0, 8, 0, 0});
  const auto refused = [&](const char* from, const char* to) {
    return refusal([&] { read_gltf(with(good, from, to), "a.gltf"); });
  };
  EXPECT_EQ(refused("\"version\": \"2.0\"", "\"version\": \"1.0\""),
            "a.gltf:1:27: error: only glTF 2 is read; write the file again as glTF 2.0");
  EXPECT_THAT(refused("\"children\": [0]", "\"children\": [7]"), HasSubstr("a.gltf:1:"));
  EXPECT_THAT(refused("\"children\": [0]", "\"children\": [1]"), HasSubstr("hangs on two"));
  EXPECT_THAT(refused("\"count\": 2, \"type\": \"VEC3\"", "\"count\": 3, \"type\": \"VEC3\""),
              HasSubstr("beyond the end of their buffer"));
  EXPECT_THAT(refused("\"type\": \"VEC3\"", "\"type\": \"VEC4\""), HasSubstr("it must be VEC3 here"));
  EXPECT_THAT(refused("LINEAR", "QUADRATIC"), HasSubstr("no interpolation"));
  EXPECT_THAT(refused("base64,", "base64,*"), HasSubstr("no base64"));
  EXPECT_THAT(refusal([] { read_gltf("{", "a.gltf"); }), HasSubstr("not JSON"));
  EXPECT_THAT(refusal([] { read_gltf("glTF", "a.glb"); }), HasSubstr("ends before its first chunk"));
  EXPECT_THAT(refusal([] {
                read_gltf(sliding("LINEAR", {0, 0, 0, NAN, 0, 0}), "a.gltf");
              }),
              HasSubstr("write finite ones"));
}

// --- on the stage

const std::string camera_in_y_up =
    R"(( upAxis = "Y" metersPerUnit = 0.01 timeCodesPerSecond = 24 startTimeCode = 1 endTimeCode = 25 )
def Camera "shot"
{
    double3 xformOp:translate.timeSamples = { 1: (100, 200, 300), 25: (200, 200, 300) }
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
)";

TEST(ScenePoses, ACameraWithYUpLooksAlongTheTip) {
  const SceneFile scene = usd(camera_in_y_up);
  const SceneRows rows = rows_of_node(scene, 0, {}, std::nullopt);
  ASSERT_EQ(rows.poses.size(), 25U);
  EXPECT_EQ(rows.first_frame, 1);
  EXPECT_EQ(rows.fps, (FrameRate{24, 1}));
  // x stays, y up is z, and what comes towards the eye is -y.
  expect_vector(rows.poses.front().position, 1, -3, 2);
  expect_vector(rows.poses.back().position, 2, -3, 2);
  // It looks along -z, which is y on the stage; its top is up, and its left is -x.
  expect_vector(rows.poses.front().rotation.x, 0, 1, 0);
  expect_vector(rows.poses.front().rotation.y, -1, 0, 0);
  expect_vector(rows.poses.front().rotation.z, 0, 0, 1);
}

TEST(ScenePoses, ASceneIsScaledThenTurnedThenPutDown) {
  const SceneFile scene = usd(camera_in_y_up);
  const Pose pose = StagedNode(scene, 0, {.scale = 2, .turn_deg = 90, .place = {10, 20, 30}}).at(1);
  // (1, -3, 2) twice as large is (2, -6, 4), turned (6, 2, 4).
  expect_vector(pose.position, 16, 22, 34);
  expect_vector(pose.rotation.x, -1, 0, 0);
  expect_vector(pose.rotation.z, 0, 0, 1);
}

TEST(ScenePoses, AnObjectMovesTheTipWithItsOwnAxes) {
  const SceneFile z_up =
      usd("( upAxis = \"Z\" metersPerUnit = 1 )\ndef Xform \"a\" { double3 xformOp:translate.timeSamples = { "
          "0: (1, 2, 3), 1: (2, 2, 3) }\n"
          "uniform token[] xformOpOrder = [\"xformOp:translate\"] }\n");
  expect_vector(StagedNode(z_up, 0, {}).at(0).rotation.x, 1, 0, 0);
  const SceneFile y_up =
      usd("( upAxis = \"Y\" metersPerUnit = 1 )\ndef Xform \"a\" { double3 xformOp:translate.timeSamples = { "
          "0: (1, 2, 3), 1: (2, 2, 3) }\n"
          "uniform token[] xformOpOrder = [\"xformOp:translate\"] }\n");
  const Pose pose = StagedNode(y_up, 0, {}).at(0);
  expect_vector(pose.position, 1, -3, 2);
  expect_vector(pose.rotation.x, 1, 0, 0);
  expect_vector(pose.rotation.z, 0, 0, 1);
}

TEST(ScenePoses, ColumnsAreAPlaceAndThreeAngles) {
  const SceneFile scene =
      usd("( upAxis = \"Z\" metersPerUnit = 1 )\ndef Xform \"a\" {\n  float3 xformOp:rotateXYZ.timeSamples = "
          "{ 0: (10, -20, 170), 1: (10, -20, 200) }\n"
          "  uniform token[] xformOpOrder = [\"xformOp:rotateXYZ\"] }\n");
  const BakedTable table = table_of_poses(scene, rows_of_node(scene, 0, {}, std::nullopt));
  std::vector<std::string> names;
  for (const BakedColumn& column : table.columns) names.push_back(column.name);
  EXPECT_THAT(names, ElementsAre("tx", "ty", "tz", "pan", "tilt", "roll"));
  // About z last is pan; about y downwards is tilt with its sign turned; about x first is roll.
  EXPECT_NEAR(table.columns[3].values[0], 170, 1e-9);
  EXPECT_NEAR(table.columns[3].values[1], 200, 1e-9);  // and not -160
  EXPECT_NEAR(table.columns[4].values[0], 20, 1e-9);
  EXPECT_NEAR(table.columns[5].values[0], 10, 1e-9);
}

TEST(ScenePoses, WhatCannotBeAMotionIsRefused) {
  const auto rows = [](const std::string& text, const std::optional<FrameRate>& fps = std::nullopt) {
    return refusal([&] {
      const SceneFile scene = usd(text);
      rows_of_node(scene, chosen_node(scene, std::nullopt), {}, fps);
    });
  };
  EXPECT_THAT(rows("def Camera \"a\" { }\n"),
              HasSubstr("\"a\" does not move; name another node with --node"));
  EXPECT_THAT(rows("def Camera \"a\" { }\ndef Camera \"b\" { }\n"),
              HasSubstr("several cameras; say which with --node: \"/a\", \"/b\""));
  EXPECT_THAT(rows("def Xform \"a\" { }\n"), HasSubstr("no camera, and nothing in it moves"));
  EXPECT_THAT(rows(with(camera_in_y_up, "timeCodesPerSecond = 24", "timeCodesPerSecond = 23.976")),
              HasSubstr("not exact; say --fps 24000/1001"));
  EXPECT_EQ(rows(with(camera_in_y_up, "timeCodesPerSecond = 24", "timeCodesPerSecond = 23.976"),
                 FrameRate{24000, 1001}),
            "nothing was refused");
  EXPECT_THAT(refusal([] {
                const SceneFile scene = read_gltf(sliding("LINEAR", {0, 0, 0, 8, 0, 0}), "a.gltf");
                rows_of_node(scene, chosen_node(scene, std::nullopt), {}, std::nullopt);
              }),
              HasSubstr("say it with --fps 24"));
  EXPECT_THAT(refusal([] {
                const SceneFile scene =
                    read_gltf(sliding("LINEAR", {0, 0, 0, 8, 0, 0}, ", \"scale\": [-1, 1, 1]"), "a.gltf");
                rows_of_node(scene, chosen_node(scene, std::nullopt), {}, FrameRate{24, 1});
              }),
              HasSubstr("is mirrored"));
  const SceneFile scene = usd(camera_in_y_up);
  EXPECT_THAT(refusal([&] { chosen_node(scene, "shto"); }), HasSubstr("did you mean \"shot\"?"));
  EXPECT_EQ(chosen_node(scene, "/shot"), 0U);
}

TEST(ScenePoses, ARateThatWasRoundedIsARowATimeCode) {
  const SceneFile scene = usd(with(camera_in_y_up, "timeCodesPerSecond = 24", "timeCodesPerSecond = 23.976"));
  const SceneRows exact = rows_of_node(scene, 0, {}, FrameRate{24000, 1001});
  EXPECT_EQ(exact.step, 1);
  EXPECT_EQ(exact.poses.size(), 25U);
  const SceneRows twice = rows_of_node(scene, 0, {}, FrameRate{48, 1});
  EXPECT_NEAR(twice.step, 23.976 / 48, 1e-15);
  EXPECT_EQ(twice.first_frame, 0);
}

TEST(RigPoses, APlaceThatTheRigCannotReachIsRefusedWithItsFrame) {
  RigFile rig = read_rig_file(in_checkout("examples/crane/rig.toml"));
  const Kinematics kinematics = read_kinematics(rig);
  const Tip& tip = camera_tip(rig, kinematics, std::nullopt);
  // From within reach to far away.
  const SceneFile scene =
      usd("( upAxis = \"Z\" metersPerUnit = 1 )\ndef Xform \"a\" {\n"
          "  double3 xformOp:translate.timeSamples = { 0: (3, 0.5, 1.5), 10: (3, 20.5, 1.5) }\n"
          "  uniform token[] xformOpOrder = [\"xformOp:translate\"] }\n");
  const SceneRows rows = rows_of_node(scene, 0, {}, std::nullopt);
  EXPECT_THAT(
      refusal([&] { axes_of_poses(rig, kinematics, tip, scene, rows); }),
      AllOf(HasSubstr("on frame 2 the rig comes no nearer"), HasSubstr("--place, --turn and --scale")));
}

/// A camera that looks straight down, as over a table, has no level from which its roll could count.
TEST(RigPoses, ACameraThatLooksStraightDownIsFollowedToo) {
  const RigFile rig = read_rig_file(in_checkout("examples/crane/rig.toml"));
  const Kinematics kinematics = read_kinematics(rig);
  const Tip& tip = camera_tip(rig, kinematics, std::nullopt);
  const SceneFile scene =
      usd("( upAxis = \"Z\" metersPerUnit = 1 )\ndef Camera \"a\" {\n"
          "  double3 xformOp:translate.timeSamples = { 0: (3, 0.5, 1.5), 20: (3.5, 0.2, 1.2) }\n"
          "  float xformOp:rotateZ.timeSamples = { 0: 0, 20: 30 }\n"
          "  uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:rotateZ\"] }\n");
  const SceneRows rows = rows_of_node(scene, 0, {}, std::nullopt);
  const BakedTable table = axes_of_poses(rig, kinematics, tip, scene, rows);
  const OracleTree oracle(joints_of_crane());
  for (std::size_t row = 0; row < table.rows(); ++row) {
    std::vector<double> axes;
    for (const BakedColumn& column : table.columns) axes.push_back(column.values[row]);
    const OraclePose pose = oracle.pose(7, axes);
    EXPECT_NEAR(pose.position[0], rows.poses[row].position.x, 1e-9);
    EXPECT_NEAR(pose.position[2], rows.poses[row].position.z, 1e-9);
    EXPECT_NEAR(pose.columns[0][2], -1, 1e-9);
    EXPECT_NEAR(pose.columns[1][0], rows.poses[row].rotation.y.x, 1e-9);
    EXPECT_NEAR(pose.columns[1][1], rows.poses[row].rotation.y.y, 1e-9);
    if (row == 0) continue;
    for (const BakedColumn& column : table.columns)
      EXPECT_LE(std::fabs(column.values[row] - column.values[row - 1]), 60) << column.name << row;
  }
}

}  // namespace scene_import_test
}  // namespace inbetween
