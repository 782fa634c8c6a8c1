#include "host_tools/joints/kinematics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <initializer_list>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/refused_text.hpp"

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

const char* const rig = R"(name = "crane"
rate_hz = 100
[kinematics]
urdf = "crane.urdf"
tip = "head"
[[axis]]
name = "focus"
unit = "unit"
min = 0
max = 9
max_velocity = 1
max_acceleration = 1
drive = { type = "pipe", path = "f", counts_per_unit = 1 }
[[axis]]
name = "boom"
unit = "deg"
min = -50
max = 50
max_velocity = 20
max_acceleration = 1
drive = { type = "pipe", path = "b", counts_per_unit = 1 }
[[axis]]
name = "track"
unit = "mm"
min = 0
max = 4000
max_velocity = 500
max_acceleration = 1
drive = { type = "pipe", path = "t", counts_per_unit = 1 }
)";

Kinematics kinematics_of(const std::string& urdf, const std::string& rig_text) {
  return {parse_urdf(urdf, "crane.urdf"), parse_rig(rig_text, "rig.toml")};
}

TEST(Kinematics, TheAxesMoveTheTipInTheirOwnUnits) {
  const Kinematics crane_of_rig = kinematics_of(crane, rig);
  ASSERT_EQ(crane_of_rig.tips().size(), 1U);
  const Tip& tip = crane_of_rig.tips()[0];
  EXPECT_EQ(tip.name, "head");
  std::vector<Pose<double>> poses(crane_of_rig.links().size());
  ASSERT_TRUE(crane_of_rig.tree().poses(std::vector{5.0, 30.0, 1500.0}, poses));
  const Pose<double>& head = poses[static_cast<std::size_t>(tip.link)];
  EXPECT_NEAR(head.position.x, 1.5 + 2 * std::numbers::sqrt3 / 2, 1e-12);
  EXPECT_NEAR(head.position.y, 0, 1e-12);
  EXPECT_NEAR(head.position.z, 1 + 2 * 0.5, 1e-12);
  EXPECT_NEAR(head.rotation.x.x, 1, 1e-12) << "the head stays level";
  std::vector<JacobianColumn<double>> jacobian(3);
  crane_of_rig.tree().jacobian(tip.link, poses, jacobian);
  EXPECT_EQ(jacobian[0].linear, Vector3<double>{}) << "the focus moves nothing";
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
  const Joint<double>& joint = lens.tree().joints().back();
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

TEST(Kinematics, AJointWithoutAxisIsRefused) {
  expect_refused(crane, with(rig, "name = \"track\"", "name = \"trakc\""), "crane.urdf:6",
                 {"\"track\"", "no axis"});
  expect_refused(crane, with(rig, "name = \"focus\"", "name = \"level\""), "rig.toml:6:1",
                 {"\"level\"", "mimics", "crane.urdf:24"});
}

TEST(Kinematics, AUnitThatTheJointCannotHaveIsRefused) {
  expect_refused(crane, with(rig, "\"mm\"", "\"deg\""), "rig.toml:22:1", {"slides", "\"mm\" or \"m\""});
  expect_refused(crane, with(rig, "\"deg\"", "\"mm\""), "rig.toml:14:1", {"turns", "\"deg\""});
  expect_refused(crane, with(rig, "\"deg\"", "\"unit\""), "rig.toml:14:1", {"turns", "\"deg\""});
}

TEST(Kinematics, AnAxisThatGoesBeyondItsJointIsRefused) {
  expect_refused(crane, with(rig, "max = 4000", "max = 4000.1"), "rig.toml:22:1",
                 {"max = 4000.1 mm", "4.0001 m", "crane.urdf:10"});
  expect_refused(crane, with(rig, "min = -50", "min = -57.3"), "rig.toml:14:1", {"min = -57.3 deg"});
  expect_refused(crane, with(rig, "max_velocity = 500", "max_velocity = 501"), "rig.toml:22:1",
                 {"max_velocity", "0.5 (crane.urdf:10)"});
  // A joint that mimics has limits of its own.
  const std::string limited = with(crane, "<joint name=\"level\" type=\"continuous\">",
                                   "<joint name=\"level\" type=\"revolute\">\n"
                                   "<limit lower=\"-0.5\" upper=\"1\" velocity=\"9\"/>");
  expect_refused(limited, rig, "rig.toml:14:1", {"max = 50 deg", "\"level\"", "crane.urdf:20"});
}

TEST(Kinematics, ATipThatIsNoLinkIsRefused) {
  expect_refused(crane, with(rig, "tip = \"head\"", "tip = [\"head\", \"hand\"]"), "rig.toml:5:16",
                 {"\"hand\"", "crane.urdf"});
}

}  // namespace kinematics_test
}  // namespace inbetween
