// A rig for the robot of a URDF file: what its maker says, what stays open, and that it is a rig.
#include "host_tools/exchange/urdf_rig.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "host_tools/joints/kinematics.hpp"
#include "host_tools/rig_model/rig_file.hpp"

namespace inbetween {
namespace urdf_rig_test {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

std::string link(const std::string& name) {
  return "<link name=\"" + name + "\"/>\n";
}

std::string joint(const std::string& name, const std::string& type, const std::string& parent,
                  const std::string& child, const std::string& more) {
  return "<joint name=\"" + name + "\" type=\"" + type + "\"><parent link=\"" + parent +
         "\"/><child link=\"" + child + "\"/><axis xyz=\"0 0 1\"/>" + more + "</joint>\n";
}

std::string limit(const std::string& lower, const std::string& upper, const std::string& velocity) {
  return "<limit lower=\"" + lower + "\" upper=\"" + upper + "\" effort=\"1\" velocity=\"" + velocity +
         "\"/>";
}

/// An arm on a slide, a fixed camera on it, and a gripper of which one finger follows the other.
std::string arm() {
  return "<robot name=\"arm\">\n" + link("base") + link("sled") + link("arm") + link("camera") +
         link("left") + link("right") +
         joint("slide", "prismatic", "base", "sled", limit("-0.25", "1", "0.5")) +
         joint("swing", "revolute", "sled", "arm", limit("-3.14159", "1.5708", "2")) +
         joint("mount", "fixed", "arm", "camera", "") +
         joint("finger", "revolute", "arm", "left", limit("0", "0.5", "1")) +
         joint("follower", "revolute", "arm", "right",
               limit("-0.5", "0", "1") + "<mimic joint=\"finger\" multiplier=\"-1\"/>") +
         "</robot>\n";
}

UrdfFile robot(const std::string& text) {
  return parse_urdf(text, "robot.urdf");
}

std::string refusal(const std::function<void()>& act) {
  try {
    act();
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(UrdfRig, JointsThatMoveAreAxesWithTheirLimits) {
  const UrdfFile file = robot(arm());
  const UrdfRig made = rig_of_urdf(file, "robot.urdf", {.rate_hz = 250, .reach_s = 0.5});
  EXPECT_THAT(made.axes, ElementsAre("slide", "swing", "finger"));
  EXPECT_THAT(made.tips, ElementsAre("camera", "left", "right"));
  EXPECT_THAT(made.open, IsEmpty());
  const RigFile rig = parse_rig(made.text, "rig.toml");
  ASSERT_EQ(rig.axes.size(), 3U);
  EXPECT_EQ(rig.rate_hz, 250);
  EXPECT_EQ(rig.axes[0].unit, AxisUnit::mm);
  EXPECT_EQ(rig.axes[0].min, -250);
  EXPECT_EQ(rig.axes[0].max, 1000);
  EXPECT_EQ(rig.axes[0].max_velocity, 500);
  EXPECT_EQ(rig.axes[0].max_acceleration, 1000);
  EXPECT_EQ(rig.axes[1].unit, AxisUnit::deg);
  EXPECT_EQ(rig.axes[1].min, -179.999847) << "inward: 3.14159 rad are 179.99984796... deg";
  const Kinematics kinematics(file, rig);
  EXPECT_THAT(kinematics.warnings(), IsEmpty());
  EXPECT_EQ(kinematics.tips().size(), 3U);
}

TEST(UrdfRig, TheRigIsForSimulationOnly) {
  const UrdfRig made = rig_of_urdf(robot(arm()), "robot.urdf", {.rate_hz = 250, .reach_s = 0.5});
  for (const RigAxis& axis : parse_rig(made.text, "rig.toml").axes) {
    const auto* const pipe = std::get_if<PipeDrive>(&axis.drive);
    ASSERT_NE(pipe, nullptr);
    EXPECT_FALSE(pipe->has_no_watchdog) << "without --sim such a rig is refused";
  }
  EXPECT_THAT(made.text, HasSubstr("write the real ones in their place"));
}

TEST(UrdfRig, WhatTheMakerLeftOutIsOpenAndRefused) {
  const UrdfRig made = rig_of_urdf(robot(arm()), "robot.urdf", {.rate_hz = 250});
  EXPECT_THAT(made.open,
              ElementsAre("slide: max_acceleration", "swing: max_acceleration", "finger: max_acceleration"));
  EXPECT_THAT(made.text, HasSubstr("# max_acceleration = ?  mm/s^2; no URDF file says it\n"));
  EXPECT_THAT(refusal([&] { parse_rig(made.text, "rig.toml"); }), HasSubstr("max_acceleration"));
  std::string filled = made.text;
  for (std::size_t at = 0; (at = filled.find("# max_acceleration = ?", at)) != std::string::npos;)
    filled.replace(at, 22, "max_acceleration = 900 #");
  EXPECT_EQ(parse_rig(filled, "rig.toml").axes.size(), 3U) << filled;
}

TEST(UrdfRig, LimitsThatAreNoneStayOpen) {
  const std::string text = "<robot name=\"r\">\n" + link("a") + link("b") + link("c") + link("d") +
                           joint("zero", "revolute", "a", "b", limit("0", "0", "0")) +
                           joint("endless", "continuous", "b", "c", "") +
                           joint("far", "revolute", "c", "d", limit("-1e16", "1", "1")) + "</robot>\n";
  const UrdfRig made = rig_of_urdf(robot(text), "robot.urdf", {.rate_hz = 250, .reach_s = 1});
  EXPECT_THAT(made.open, ElementsAre("zero: min", "zero: max", "zero: max_velocity", "zero: max_acceleration",
                                     "endless: min", "endless: max", "endless: max_velocity",
                                     "endless: max_acceleration", "far: min"));
  EXPECT_THAT(made.text, AllOf(HasSubstr("# max_velocity = ?  deg/s; the file has 0, line 6\n"),
                               HasSubstr("# min = ?  the joint turns without end"),
                               HasSubstr("# min = ?  the file has -1e+16, which is no end\n")));
}

TEST(UrdfRig, SomeJointsAreAxesAndTheOthersStayWhereTheyAre) {
  const UrdfFile file = robot(arm());
  const UrdfRig made = rig_of_urdf(
      file, "robot.urdf",
      {.rate_hz = 250, .reach_s = 0.5, .angle = MoveUnit::rad, .length = MoveUnit::m, .joints = {"swing"}});
  EXPECT_THAT(made.axes, ElementsAre("swing"));
  EXPECT_THAT(made.held, ElementsAre("slide", "finger"));
  const RigFile rig = parse_rig(made.text, "rig.toml");
  EXPECT_EQ(rig.axes[0].unit, AxisUnit::rad);
  EXPECT_EQ(rig.axes[0].min, -3.14159);
  EXPECT_THAT(Kinematics(file, rig).warnings()[0].message, HasSubstr("slide at 0, finger at 0"));
}

TEST(UrdfRig, WhatCannotBeAnAxisIsRefused) {
  const auto made = [](const std::string& text, const std::vector<std::string>& joints) {
    return refusal([&] {
      static_cast<void>(rig_of_urdf(robot(text), "robot.urdf", {.rate_hz = 250, .joints = joints}));
    });
  };
  EXPECT_THAT(made(arm(), {"swin"}), HasSubstr("no joint \"swin\" may be an axis; did you mean \"swing\"?"));
  EXPECT_THAT(made(arm(), {"follower"}), HasSubstr("one that moves and mimics no other"));
  EXPECT_THAT(made("<robot name=\"r\">" + link("a") + "</robot>", {}), HasSubstr("no joint moves; name"));
  const std::string blank = "<robot name=\"r\">\n" + link("a") + link("b") +
                            joint("left arm", "revolute", "a", "b", limit("0", "1", "1")) + "</robot>\n";
  EXPECT_THAT(made(blank, {}), AllOf(HasSubstr("robot.urdf:4: error: joint \"left arm\" has a blank"),
                                     HasSubstr("; rename it")));
}

TEST(UrdfRig, MoreJointsThanAxesAreToBeChosenFrom) {
  std::string text = "<robot name=\"r\">\n" + link("l0");
  for (int i = 1; i <= 65; ++i) {
    text += link("l" + std::to_string(i)) +
            joint("j" + std::to_string(i), "revolute", "l0", "l" + std::to_string(i), limit("0", "1", "1"));
  }
  text += "</robot>\n";
  EXPECT_THAT(refusal([&] { rig_of_urdf(robot(text), "robot.urdf", {.rate_hz = 250}); }),
              AllOf(HasSubstr("65 joints move, and a rig has 64 axes at most"), HasSubstr("--axis JOINT")));
  const UrdfRig some =
      rig_of_urdf(robot(text), "robot.urdf", {.rate_hz = 250, .reach_s = 1, .joints = {"j1", "j65"}});
  EXPECT_THAT(some.tips, ElementsAre("l1", "l65")) << "the ends that an axis moves";
}

}  // namespace urdf_rig_test
}  // namespace inbetween
