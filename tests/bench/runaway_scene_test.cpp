// On the kernel's CAN, with drives of every kind: an axis that runs away, stands short, or moves by another
// scale.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/support/bus_scene.hpp"
#include "tests/support/places.hpp"

namespace inbetween {
namespace runaway_scene_test {

using testing::HasSubstr;

BusScene scene_on(const std::string& rig, const std::string& faults) {
  BusSceneOptions options{.faults = faults};
  options.rig = in_checkout("examples/" + rig);
  return BusScene(options);
}
const std::string blind = fault_text("pan", "blind", "after_motion = 4");

void expect_no_power(const BusScene& scene) {
  scene.expect_all_stand(testing::AnyOf("off", "idle", "stopped", "fault", "switch-on disabled"));
}

// docs/faults.md 52
void expect_power_goes_and_the_speed_is_said(const std::string& rig) {
  for (const char* speed : {"60", "-200", "720"}) {
    SCOPED_TRACE(testing::Message() << rig << " " << speed);
    const bool is_cia402 = rig == "camera_rig.toml";
    const BusScene scene =
        scene_on(rig, (is_cia402 ? blind : "") +
                          fault_text("pan", "run-away", fmt::format("speed = {}\nafter_motion = 4", speed)));
    EXPECT_EQ(scene.run.status, 4) << scene.run.err;
    EXPECT_THAT(scene.run.out, HasSubstr("axis \"pan\": the axis is too far from its target"));
    EXPECT_THAT(scene.run.out, HasSubstr("axis \"pan\" still moved at"));
    expect_no_power(scene);
    if (is_cia402) scene.expect_stop_on_path({"slide"}, 2.5);
  }
}
TEST(RunawayScene, OnACia402DriveLosesItsPowerAndTheOthersStopOnTheirPath) {
  expect_power_goes_and_the_speed_is_said("camera_rig.toml");
}
TEST(RunawayScene, OnAnOdriveLosesItsPower) {
  expect_power_goes_and_the_speed_is_said("odrive_rig.toml");
}
TEST(RunawayScene, OnAMoteusLosesItsPower) {
  expect_power_goes_and_the_speed_is_said("moteus_rig.toml");
}
TEST(RunawayScene, OnAMotorWithItsOwnProtocolLosesItsPower) {
  expect_power_goes_and_the_speed_is_said("motor_rig.toml");
}

// docs/faults.md 25, case 60
TEST(RunawayScene, AnAxisThatStandsShortThoughItsDriveSaysNothingHasNotArrived) {
  const BusScene early = scene_on("camera_rig.toml", blind + fault_text("pan", "stick", "after_motion = 4"));
  EXPECT_EQ(early.run.status, 4) << early.run.err;
  EXPECT_THAT(early.run.out, HasSubstr("axis \"pan\": the axis is too far from its target"));
  early.expect_stop_on_path({"slide"}, 2.5);
  const BusScene late = scene_on("camera_rig.toml", blind + fault_text("pan", "stick", "after_motion = 6.5"));
  EXPECT_EQ(late.run.status, 4) << late.run.err;
  EXPECT_THAT(late.run.out, HasSubstr("axis \"pan\" has not arrived: it stands at"));
  late.expect_let_go();
}

// docs/faults.md 53, case 59
TEST(RunawayScene, AMotorWithAnotherScaleIsStoppedAtOnce) {
  for (const char* ratio : {"0.01", "0.8", "1.25", "100", "-1"}) {
    SCOPED_TRACE(ratio);
    const BusScene scene =
        scene_on("motor_rig.toml", fault_text("tilt", "other-scale", fmt::format("ratio = {}", ratio)));
    EXPECT_EQ(scene.run.status, 4) << scene.run.err;
    EXPECT_THAT(scene.run.out,
                testing::AnyOf(HasSubstr("axis \"tilt\": the axis moves by more or less than it is told"),
                               HasSubstr("axis \"tilt\": the axis moved while")));
    expect_no_power(scene);
  }
}

}  // namespace runaway_scene_test
}  // namespace inbetween
