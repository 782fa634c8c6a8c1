// Formats that are documents: the JSON of blender-servo-animation, scenes and moves of Dragonframe's Arc
// workspace.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "host_tools/exchange/arc_move.hpp"
#include "host_tools/exchange/placed_json.hpp"
#include "host_tools/exchange/servo_json.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "tests/support/refused_text.hpp"

namespace inbetween {
namespace exchange_documents_test {

using testing::ElementsAre;
using testing::HasSubstr;

template <class Read>
std::string refusal(Read read, const std::string& text) {
  try {
    read(text, "a");
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

const std::string servo =
    R"({"description":"Blender Servo Animation Positions","fps":25,"frames":3,"seconds":0,
 "bones":1,"armature":"Rig","file":"a.blend","scene":"Scene",
 "servos":{"0":{"name":"Pan","positions":[1500,1510,1520]}}})";

TEST(ExchangeServoJson, ServosCountInWhatNobodySays) {
  const BakedTable table = read_servo_json(servo, "a.json");
  EXPECT_EQ(table.fps, (FrameRate{25, 1}));
  ASSERT_EQ(table.columns.size(), 1U);
  EXPECT_EQ(table.columns[0].name, "Pan");
  EXPECT_EQ(table.columns[0].channel, 0);
  EXPECT_TRUE(table.columns[0].is_in_counts);
  EXPECT_EQ(table.columns[0].decimals, 0);
  EXPECT_THAT(table.columns[0].values, ElementsAre(1500, 1510, 1520));
  EXPECT_FALSE(table.first_frame);
}

TEST(ExchangeServoJson, TheShapeByFrameIsTheSame) {
  const BakedTable table = read_servo_json(
      "{\"fps\":24,\"frames\":2,\"positions\":[\n{\"7\":-3,\"12\":4},\n{\"12\":6,\"7\":5}\n]}", "a.json");
  ASSERT_EQ(table.columns.size(), 2U);
  EXPECT_EQ(table.columns[0].name, "servo 7");
  EXPECT_EQ(table.columns[1].channel, 12);
  EXPECT_THAT(table.columns[0].values, ElementsAre(-3, 5));
  EXPECT_THAT(table.columns[1].values, ElementsAre(4, 6));
}

TEST(ExchangeServoJson, WhatIsWrittenIsReadBackAsItsOwnWriterHasIt) {
  BakedTable table = read_servo_json(servo, "a.json");
  table.columns.push_back({.name = "Tilt \"left\"", .values = {1.4, -2.6, 1e9}});
  const std::string text = write_servo_json(table);
  EXPECT_THAT(text, HasSubstr(R"("fps":25,"frames":3,"seconds":0,"bones":2,"armature":"")"));
  const BakedTable back = read_servo_json(text, "a.json");
  EXPECT_EQ(back.columns[1].channel, 1);
  EXPECT_EQ(back.columns[1].name, "Tilt \"left\"");
  EXPECT_THAT(back.columns[1].values, ElementsAre(1, -3, 1e9));
  table.fps = FrameRate{24000, 1001};
  EXPECT_THROW(write_servo_json(table), InputError);
}

TEST(ExchangeServoJson, AWrongFileIsRefusedAtItsPlace) {
  const auto refused = [](const char* from, const char* to) {
    return refusal(read_servo_json, with(servo, from, to));
  };
  EXPECT_THAT(refused("1510", "15.5"), HasSubstr("a:3:48: error: a position is 15.5"));
  EXPECT_THAT(refused("1510", "NaN"), HasSubstr("a:3:48: error: this is no number of JSON"));
  EXPECT_THAT(refused("1510", "\"1510\""), HasSubstr("a position is no number"));
  EXPECT_THAT(refused("1510,", ""),
              HasSubstr("a:3:42: error: servo \"0\" has 2 positions, and \"frames\" is 3"));
  EXPECT_THAT(refused("\"frames\":3", "\"frames\":4"), HasSubstr("has 3 positions, and \"frames\" is 4"));
  EXPECT_THAT(refused("\"bones\":1", "\"bones\":2"),
              HasSubstr("a:2:10: error: \"bones\" is 2, and 1 are there"));
  EXPECT_THAT(refused("\"seconds\":0", "\"seconds\":9"), HasSubstr("3 frames at 25 a second last 0.12 s"));
  EXPECT_THAT(refused("\"fps\":25", "\"fps\":0"), HasSubstr("above 0"));
  EXPECT_THAT(refused("\"fps\":25,", ""), HasSubstr("\"fps\" is missing"));
  EXPECT_THAT(refused("\"0\":", "\"255\":"), HasSubstr("from 0 to 254"));
  EXPECT_THAT(refused("\"0\":", "\"x\":"), HasSubstr("no number of a servo"));
  EXPECT_THAT(refused("\"servos\"", "\"servo\""), HasSubstr("either \"servos\" or \"positions\""));
  EXPECT_THAT(refused("\"bones\":1", "\"fps\":24"), HasSubstr("\"fps\" is there a second time"));
  EXPECT_THAT(refused("}}}", "}}"), HasSubstr("not JSON"));
  const auto by_frame = [](const std::string& second) {
    return refusal(read_servo_json,
                   "{\"fps\":24,\"frames\":2,\"positions\":[\n{\"7\":3,\"1\":4},\n" + second + "]}");
  };
  EXPECT_THAT(by_frame("{\"7\":3}"), HasSubstr("a:3:1: error: this frame has 1 servo, and the first has 2"));
  EXPECT_THAT(by_frame("{\"7\":3,\"2\":4}"), HasSubstr("the first frame has no servo \"2\""));
  EXPECT_THAT(by_frame("[3,4]"), HasSubstr("a frame is no object"));
  EXPECT_THAT(refusal(read_servo_json, "[[[[[[[[[1]]]]]]]]]"),
              HasSubstr("a:1:9: error: this nests deeper than 8"));
  EXPECT_THAT(refusal(read_servo_json, "{\"fps\":1e999}"), HasSubstr("not JSON"));
  EXPECT_THAT(refusal(read_servo_json, "7"), HasSubstr("this is no object"));
  EXPECT_THAT(refusal(read_servo_json, ""), HasSubstr("not JSON"));
}

const std::string arcm = R"(<?xml version="1.0" encoding="UTF-8"?>
<scen:scene xmlns:scen="http://caliri.com/motion/scene" endframe="24">
  <scen:axis name="PAN" units="deg">
    <scen:points x="1" y="0"/>
    <scen:points x="25" y="90"/>
    <scen:controlPoints x="9" y="0"/>
    <scen:controlPoints x="17" y="90"/>
  </scen:axis>
</scen:scene>
)";

TEST(ExchangeArc, ACurveIsSampledOnItsFrames) {
  const BakedTable table = read_arc_move(arcm, "a.arcm");
  EXPECT_EQ(table.first_frame, 1);
  ASSERT_EQ(table.columns.size(), 1U);
  EXPECT_EQ(table.columns[0].name, "PAN");
  EXPECT_EQ(table.columns[0].unit, MoveUnit::deg);
  ASSERT_EQ(table.rows(), 25U);
  EXPECT_EQ(table.columns[0].values[0], 0);
  EXPECT_EQ(table.columns[0].values[24], 90);
  // Its control points are at thirds of the frames, so that u is the share of the frames: 90 (3 u^2 - 2 u^3).
  for (int row = 0; row <= 24; ++row) {
    const double u = row / 24.0;
    EXPECT_NEAR(table.columns[0].values[static_cast<std::size_t>(row)], 90 * u * u * (3 - 2 * u), 1e-12)
        << row;
  }
}

TEST(ExchangeArc, ANamespaceCountsAndNoPrefix) {
  std::string other = arcm;
  for (std::size_t at = 0; (at = other.find("scen:", at)) != std::string::npos;) other.replace(at, 5, "m:");
  other = with(other, "xmlns:scen", "xmlns:m");
  EXPECT_EQ(read_arc_move(other, "a.arcm").rows(), 25U);
  EXPECT_THAT(refusal(read_arc_move, with(arcm, "caliri", "example")),
              HasSubstr("a:2: error: <scen:scene> is not of"));
}

TEST(ExchangeArc, HandlesThatReachOutOfTheirSegmentAreHeldInIt) {
  const ArcScene scene =
      read_arc_scene(with(with(arcm, "x=\"9\"", "x=\"60\""), "x=\"17\"", "x=\"-60\""), "a.arcm");
  // Held to 25 and 1: x(u) = 1 + 24 (3 u (1-u)^2 + u^3), and y is half way where x is.
  // There u goes on while the frame stands still, so that a last bit of the frame is much of u.
  EXPECT_NEAR(arc_value(scene.axes[0], 13), 45, 1e-3);
  EXPECT_EQ(arc_value(scene.axes[0], -7), 0) << "it holds before its first point";
  EXPECT_EQ(arc_value(scene.axes[0], 99), 90);
}

const std::string arcx = R"(<?xml version="1.0" encoding="UTF-8"?>
<scen:scene xmlns:scen="http://caliri.com/motion/scene">
  <scen:axis name="PAN" connectionType="1" connectionChannel="1" stepsPerUnit="100" pulseRate="5000" acceleration="2" currentPosition="0" base="0" settleTime="1.5" viewPosition="10" integral="false" indexCount="1" runMaxVelocity="20000" runMaxAcceleration="10000" frameToFrameSpeed="8" graphSolo="false" graphHide="false" graphColor="-65536"/>
  <scen:virtualConfiguration type="0">
    <scen:axis>-1</scen:axis><scen:axis>-1</scen:axis><scen:axis>-1</scen:axis>
    <scen:axis>-1</scen:axis><scen:axis>-1</scen:axis><scen:axis>-1</scen:axis>
  </scen:virtualConfiguration>
</scen:scene>
)";

TEST(ExchangeArc, OnlyChildrenOfTheSceneAreAxesAndEverythingComesBack) {
  const ArcScene scene = read_arc_scene(arcx, "a.arcx");
  ASSERT_EQ(scene.axes.size(), 1U);
  EXPECT_EQ(scene.axes[0].number("stepsPerUnit"), 100);
  EXPECT_FALSE(scene.has_motion());
  EXPECT_EQ(write_arc_scene(scene), arcx);
  EXPECT_THAT(refusal(read_arc_move, arcx), HasSubstr("no axis of the scene has points"));
  const std::string odd =
      with(with(arcm, "name=\"PAN\"", "name=\"P &amp; &quot;&lt;\" new=\"&#10;\""), "  </scen:axis>",
           "    <scen:more a='1'>x &amp; y</scen:more>\n  </scen:axis>");
  const std::string back = write_arc_scene(read_arc_scene(odd, "a.arcm"), 0);
  EXPECT_EQ(back, odd);
  EXPECT_EQ(write_arc_scene(read_arc_scene("\xEF\xBB\xBF" + odd, "a.arcm"), 0), odd)
      << "with a byte order mark";
}

TEST(ExchangeArc, ASceneBecomesARigThatAsksForWhatItDoesNotSay) {
  const std::string text = rig_of_arc_scene(read_arc_scene(arcx, "a.arcx"), 250);
  EXPECT_THAT(text, HasSubstr("name = \"PAN\"\n# motor \"1\""));
  EXPECT_THAT(text, HasSubstr("runMaxVelocity is 20000, which is 200 if it counts steps"));
  EXPECT_THAT(text, HasSubstr("steps_per_unit or counts_per_unit = 100"));
  EXPECT_THAT(
      refusal([](const std::string& rig, const std::string& file) { return parse_rig(rig, file); }, text),
      HasSubstr("error:"))
      << "it is no rig before somebody has answered";
  std::string answered = text;
  answered = with(answered, "# unit = ?  the scene does not say; write \"mm\" or \"deg\"", "unit = \"deg\"");
  answered = with(answered, "# min = ?", "min = -90");
  answered = with(answered, "# max = ?", "max = 90");
  answered = with(answered, "# max_velocity = ?  in", "max_velocity = 200 #");
  answered = with(answered, "# max_acceleration = ?  in", "max_acceleration = 100 #");
  answered = with(answered, "# drive = ?  with",
                  "drive = { type = \"pipe\", path = \"p\", counts_per_unit = 100 } #");
  EXPECT_EQ(parse_rig(answered, "rig.toml").axes[0].name, "PAN") << answered;
}

TEST(ExchangeArc, AWrongFileIsRefusedAtItsLine) {
  const auto refused = [](const char* from, const char* to) {
    return refusal(read_arc_move, with(arcm, from, to));
  };
  EXPECT_THAT(refused("    <scen:controlPoints x=\"9\" y=\"0\"/>\n", ""),
              HasSubstr("a:3: error: axis \"PAN\" has 2 points and 1 control point"));
  EXPECT_THAT(refused("x=\"25\"", "x=\"1\""), HasSubstr("a:5: error: <scen:points> is at frame 1"));
  EXPECT_THAT(
      refused("y=\"90\"/>\n    <scen:controlPoints x=\"9\"", "y=\"nan\"/>\n    <scen:controlPoints x=\"9\""),
      HasSubstr("a:5: error: <scen:points>: y is \"nan\""));
  EXPECT_THAT(refused("x=\"17\"", "x=\"1,7\""), HasSubstr("a:7: error:"));
  EXPECT_THAT(refused("x=\"17\" ", ""), HasSubstr("a:7: error: <scen:controlPoints> has no x"));
  EXPECT_THAT(refused("deg", "rad"), HasSubstr("a:3: error: units is \"rad\"; write m, cm, mm, in or deg"));
  EXPECT_THAT(refused("x=\"25\"", "x=\"9000000\""), HasSubstr("positions; leave some out"));
  EXPECT_THAT(refused("</scen:axis>", ""), HasSubstr("not valid XML"));
  EXPECT_THAT(refusal(read_arc_move, ""), HasSubstr("not valid XML"));
}

TEST(ExchangeArc, ATableIsWrittenWithAPointOnEachFrameAndNoStepOfSpeed) {
  BakedTable table{.file = "move"};
  table.columns.push_back({.name = "PAN", .unit = MoveUnit::deg, .values = {0, 1, 4, 9, 9}});
  table.first_frame = -2;
  const std::string text = write_arc_move(table);
  const BakedTable back = read_arc_move(text, "a.arcm");
  EXPECT_EQ(back.first_frame, -2);
  EXPECT_EQ(back.columns[0].unit, MoveUnit::deg);
  EXPECT_THAT(back.columns[0].values, ElementsAre(0, 1, 4, 9, 9));
  const ArcAxis axis = read_arc_scene(text, "a.arcm").axes[0];
  const double d = 1e-4;
  for (const double frame : {-1.0, 0.0, 1.0}) {
    const double before = (arc_value(axis, frame) - arc_value(axis, frame - d)) / d;
    const double behind = (arc_value(axis, frame + d) - arc_value(axis, frame)) / d;
    EXPECT_NEAR(before, behind, 0.01) << frame;
  }
  table.columns[0].unit = MoveUnit::rad;
  EXPECT_THROW(write_arc_move(table), InputError);
}

}  // namespace exchange_documents_test
}  // namespace inbetween
