#include "host_tools/joints/kinematics.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <initializer_list>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/refused_text.hpp"
#include "tests/support/rig_text.hpp"

namespace inbetween {
namespace kinematics_test {

/// A carriage on a rail, a boom on it, and a head that stays level.
const char* const crane = R"(<robot name="crane">
  <link name="floor"/>
  <link name="carriage"/>
  <link name="boom"/>
  <link name="head"/>
  <joint name="track" type="prismatic">
    <parent link="floor"/>
    <child link="carriage"/>
    <axis xyz="1 0 0"/>
    <limit lower="0" upper="4" effort="1" velocity="0.5"/>
  </joint>
  <joint name="boom" type="revolute">
    <parent link="carriage"/>
    <child link="boom"/>
    <origin xyz="0 0 1"/>
    <axis xyz="0 -1 0"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/>
  </joint>
  <joint name="level" type="continuous">
    <parent link="boom"/>
    <child link="head"/>
    <origin xyz="2 0 0"/>
    <axis xyz="0 -1 0"/>
    <mimic joint="boom" multiplier="-1"/>
  </joint>
</robot>
)";

const std::string rig = rig_text({axis_text("focus", "unit", {0, 9}, {.velocity = 1, .acceleration = 1}, "",
                                            R"(type = "pipe", path = "f", counts_per_unit = 1)"),
                                  axis_text("boom", "deg", {-50, 50}, {.velocity = 20, .acceleration = 1}, "",
                                            R"(type = "pipe", path = "b", counts_per_unit = 1)"),
                                  axis_text("track", "mm", {0, 4000}, {.velocity = 500, .acceleration = 1},
                                            "", R"(type = "pipe", path = "t", counts_per_unit = 1)")},
                                 {.name = "crane", .more = R"([kinematics]
urdf = "crane.urdf"
tip = "head"
)"});

Kinematics kinematics_of(const std::string& urdf, const std::string& rig_text) {
  return {parse_urdf(urdf, "crane.urdf"), parse_rig(rig_text, "rig.toml")};
}

TEST(Kinematics, TheAxesMoveTheTipInTheirOwnUnits) {
  const Kinematics crane_of_rig = kinematics_of(crane, rig);
  ASSERT_EQ(crane_of_rig.tips().size(), 1U);
  const Tip& tip = crane_of_rig.tips()[0];
  EXPECT_EQ(tip.name, "head");
  std::vector<Pose> poses(crane_of_rig.links().size());
  ASSERT_TRUE(crane_of_rig.tree().poses(std::vector{5.0, 30.0, 1500.0}, poses));
  const Pose& head = poses[static_cast<std::size_t>(tip.link)];
  EXPECT_NEAR(head.position.x, 1.5 + 2 * std::numbers::sqrt3 / 2, 1e-12);
  EXPECT_NEAR(head.position.y, 0, 1e-12);
  EXPECT_NEAR(head.position.z, 1 + 2 * 0.5, 1e-12);
  EXPECT_NEAR(head.rotation.x.x, 1, 1e-12) << "the head stays level";
  std::vector<JacobianColumn> jacobian(3);
  crane_of_rig.tree().jacobian(tip.link, poses, jacobian);
  EXPECT_EQ(jacobian[0].linear, Vector3{}) << "the focus moves nothing";
  EXPECT_NEAR(jacobian[2].linear.x, 1e-3, 1e-15) << "metres per millimetre";
}

TEST(Kinematics, AMimicOfAMimicFollowsTheSameAxis) {
  std::string urdf = with(crane, "</robot>", R"(  <link name="lens"/>
  <joint name="lens" type="prismatic">
    <parent link="head"/>
    <child link="lens"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/>
    <mimic joint="level" multiplier="0.5" offset="0.125"/>
  </joint>
</robot>)");
  const Kinematics lens = kinematics_of(urdf, with(rig, "tip = \"head\"", "tip = \"lens\""));
  const Joint& joint = lens.tree().joints().back();
  EXPECT_EQ(joint.coordinate, 1);
  EXPECT_NEAR(joint.factor, -0.5 * std::numbers::pi / 180, 1e-15);
  EXPECT_EQ(joint.offset, 0.125);
}

void expect_refused(const std::string& urdf, const std::string& rig_text, std::string_view place,
                    std::initializer_list<std::string_view> words) {
  try {
    kinematics_of(urdf, rig_text);
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::StartsWith(std::string(place) + ": error: "));
    for (const std::string_view word : words)
      EXPECT_THAT(error.what(), testing::HasSubstr(std::string(word)));
  }
}

TEST(Kinematics, AnAxisOfAJointThatMimicsIsRefused) {
  expect_refused(crane, with(rig, "name = \"focus\"", "name = \"level\""), "rig.toml:6:1",
                 {"\"level\"", "mimics", "crane.urdf:24"});
}

TEST(Kinematics, AUnitThatTheJointCannotHaveIsRefused) {
  expect_refused(crane, with(rig, "\"mm\"", "\"deg\""), "rig.toml:24:1", {"slides", "\"mm\" or \"m\""});
  expect_refused(crane, with(rig, "\"deg\"", "\"mm\""), "rig.toml:15:1", {"turns", "\"deg\""});
  expect_refused(crane, with(rig, "\"deg\"", "\"unit\""), "rig.toml:15:1", {"turns", "\"deg\""});
}

TEST(Kinematics, AnAxisThatGoesBeyondItsJointIsRefused) {
  expect_refused(crane, with(rig, "max = 4000", "max = 4000.1"), "rig.toml:24:1",
                 {"max = 4000.1 mm", "4.0001 m", "crane.urdf:10"});
  expect_refused(crane, with(rig, "min = -50", "min = -57.3"), "rig.toml:15:1", {"min = -57.3 deg"});
  expect_refused(crane, with(rig, "max_velocity = 500", "max_velocity = 501"), "rig.toml:24:1",
                 {"max_velocity", "0.5 (crane.urdf:10)"});
  // Those of a joint that mimics are often left from before it did.
  const std::string limited = with(crane, "<joint name=\"level\" type=\"continuous\">",
                                   "<joint name=\"level\" type=\"revolute\">\n"
                                   "<limit lower=\"-0.5\" upper=\"1\" velocity=\"9\"/>");
  const Kinematics all_the_same = kinematics_of(limited, rig);
  ASSERT_EQ(all_the_same.warnings().size(), 1U);
  EXPECT_THAT(all_the_same.warnings()[0].message, testing::HasSubstr("do not count: level (limits)"));
}

// Case 25. The crane without an axis for its track stands where the track is at 0, or where the rig says.
TEST(Kinematics, AJointWithoutAxisStaysWhereItIs) {
  const auto joints_of = [](const Kinematics& kinematics) { return kinematics.tree().joints().size(); };
  const std::string other = with(rig, "name = \"track\"", "name = \"other\"");
  const Kinematics held = kinematics_of(crane, other);
  EXPECT_EQ(joints_of(held), joints_of(kinematics_of(crane, rig)));
  ASSERT_EQ(held.warnings().size(), 1U);
  EXPECT_THAT(held.warnings()[0].message, testing::HasSubstr("stay where they are (rad, m): track at "));
  const Kinematics said =
      kinematics_of(crane, with(other, "[kinematics]", "[kinematics]\nat = { track = 0.25 }"));
  EXPECT_THAT(said.warnings()[0].message, testing::HasSubstr("track at 0.25"));
  expect_refused(crane, with(rig, "[kinematics]", "[kinematics]\nat = { track = 0.25 }"), "rig.toml:4:16",
                 {"\"track\"", "moved by an axis"});
  expect_refused(crane, with(rig, "[kinematics]", "[kinematics]\nat = { trakc = 0.25 }"), "rig.toml:4:16",
                 {"\"trakc\"", "correct the name"});
}

TEST(Kinematics, OneLineTellsOfAThousandJointsThatNoAxisMoves) {
  std::string more;
  for (int i = 0; i < 1000; ++i) {
    more += fmt::format(R"(<link name="x{0}"/><joint name="j{0}" type="{1}"><parent link="floor"/>)"
                        R"(<child link="x{0}"/><limit lower="-1e16" upper="1e16" velocity="1"/></joint>)",
                        i, i % 2 == 0 ? "revolute" : "fixed");
  }
  const Kinematics held = kinematics_of(with(crane, "</robot>", more + "</robot>"), rig);
  ASSERT_EQ(held.warnings().size(), 1U);
  EXPECT_THAT(held.warnings()[0].message, testing::HasSubstr("j28 at 0, j30 at 0 and 484 more; write at ="));
}

/// Two links and one joint of this kind with this limit, and an axis from -min to min.
Kinematics limited_to(const std::string& limit, double most, const std::string& unit = "deg",
                      const std::string& more = "") {
  const std::string urdf =
      fmt::format(R"(<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="{}">
<parent link="a"/><child link="b"/><limit {}/></joint></robot>)",
                  unit == "mm" ? "prismatic" : "revolute", limit);
  const std::string text =
      rig_text({{.name = "j", .unit = unit, .min = -most, .max = most, .max_velocity = 1}},
               {.more = "[kinematics]\nurdf = \"r.urdf\"\ntip = \"b\"\n" + more});
  return {parse_urdf(urdf, "r.urdf"), parse_rig(text, "rig.toml")};
}

// Cases 23 and 24
TEST(Kinematics, ALimitThatWasRoundedIsTheSameLimitUpToATenthOfADegree) {
  const std::string pi = R"(lower="-3.14159" upper="3.1416" velocity="9")";
  EXPECT_NO_THROW(limited_to(pi, 180));
  EXPECT_THROW(limited_to(pi, 180.01), InputError);
  EXPECT_NO_THROW(limited_to(R"(lower="-3.141" upper="3.142" velocity="9")", 180)) << "cut off";
  EXPECT_THROW(limited_to(R"(lower="-3.14" upper="3.14" velocity="9")", 180), InputError) << "two decimals";
  EXPECT_NO_THROW(limited_to(R"(lower="-0.5000" upper="0.5000" velocity="9")", 500.04, "mm"));
  EXPECT_THROW(limited_to(R"(lower="-0.500" upper="0.500" velocity="9")", 500.06, "mm"), InputError);
  EXPECT_NO_THROW(limited_to(R"(lower="-1" upper="1" velocity="9")", 180, "deg", "limits = \"rig\"\n"));
  const Kinematics unknown = limited_to(R"(lower="-4" upper="4" velocity="0")", 180);
  ASSERT_EQ(unknown.warnings().size(), 1U);
  EXPECT_THAT(unknown.warnings()[0].message, testing::HasSubstr("do not count: j (velocity 0)"));
}

// Limits of 1e16 mean that there are none, and so does nothing that can be computed.
TEST(Kinematics, ALimitFartherThanCanBeComputedBoundsNothingAndHoldsNothing) {
  const std::string far = R"(lower="-1e16" upper="1e16" velocity="9")";
  EXPECT_NO_THROW(limited_to(far, 180));
  try {
    limited_to(far, 1e8);
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("min = -100000000 deg"));
    EXPECT_THAT(error.what(), testing::HasSubstr("limits -1e+06 to 1e+06"));
  }
  const std::string away = R"(<robot name="r"><link name="a"/><link name="b"/><joint name="k" type="revolute">
<parent link="a"/><child link="b"/><limit lower="1e16" upper="1.7e308" velocity="9"/></joint></robot>)";
  const std::string no_axis =
      rig_text({{.name = "j"}}, {.more = "[kinematics]\nurdf = \"r.urdf\"\ntip = \"b\"\n"});
  expect_refused(away, no_axis, "crane.urdf:1", {"joint \"k\" would stay at 8.5e+307", "at = { \"k\" = 0 }"});
  EXPECT_NO_THROW(kinematics_of(away, with(no_axis, "tip =", "at = { k = 0 }\ntip =")));
}

TEST(Kinematics, ATipThatIsNoLinkIsRefused) {
  expect_refused(crane, with(rig, "tip = \"head\"", "tip = [\"head\", \"hand\"]"), "rig.toml:5:16",
                 {"\"hand\"", "crane.urdf"});
}

}  // namespace kinematics_test
}  // namespace inbetween
