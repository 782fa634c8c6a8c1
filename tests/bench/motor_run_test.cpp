// A whole move over the kernel's CAN on geared motors, which are switched on by their first position: `run`
// on one side, `sim-drives` on the other.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/support/bus_scene.hpp"
#include "tests/support/places.hpp"

namespace inbetween {
namespace motor_run_test {

using testing::AllOf;
using testing::HasSubstr;

struct Motor {
  const char* axis;
  double turns_per_unit;
  double step_turns;  ///< of a position in its frames
};
constexpr double rmd_step = 1.0 / 36'000;
constexpr Motor motors[] = {
    {"slide", 0.005, rmd_step}, {"pan", -0.0027777778, rmd_step}, {"tilt", 0.0027777778, 1e-4 / 360}};

BusScene motor_scene(BusSceneOptions options = {}) {
  options.rig = in_checkout("examples/motor_rig.toml");
  return BusScene(options);
}
void expect_at_rest_without_power(const BusScene& scene) {
  scene.expect_all_stand(testing::AnyOf("off", "fault"));
}

TEST(MotorRun, TheMotorsOwnRecordOfTheirTargetsIsThePlanAtEveryTick) {
  const BusScene scene = motor_scene();
  ASSERT_EQ(scene.run.status, 0) << scene.run.err << scene.run.out;
  expect_at_rest_without_power(scene);
  for (const Motor& motor : motors) {
    SCOPED_TRACE(motor.axis);
    scene.expect_plan(motor.axis, motor.turns_per_unit,
                      0.501 * motor.step_turns / std::fabs(motor.turns_per_unit));
  }
}

// docs/faults.md 29
TEST(MotorFault, KilledInMotionTheMotorsStopByTheirOwnWatchdogsOrAtTheirLastPosition) {
  const BusScene scene = motor_scene({.during = "sleep 7; kill -KILL $run"});
  EXPECT_EQ(scene.run.status, 128 + 9);
  for (const char* axis : {"slide", "pan"}) EXPECT_EQ(scene.last_state(axis), "off") << axis;
  EXPECT_EQ(scene.last_state("tilt"), "position") << "it has no watchdog, and holds its last position";
  scene.expect_all_stand(testing::_);
}

// docs/faults.md 29
TEST(MotorFault, AMotorWithoutAWatchdogIsRefusedAndNothingIsSwitchedOn) {
  const BusScene scene = motor_scene({.faults = fault_text("pan", "no-watchdog")});
  EXPECT_EQ(scene.run.status, 4) << scene.run.err;
  EXPECT_THAT(scene.run.out, AllOf(HasSubstr("axis \"pan\": the drive did not confirm the time after which"),
                                   HasSubstr("no_watchdog = \"accepted\"")));
  scene.expect_no_targets();
}

// docs/faults.md 17, 20, 21, 23, 24, 25
TEST(MotorFault, WhatIsWrongWithAMotorInMotionStopsAllAndIsSaidInWords) {
  expect_faults_said(
      in_checkout("examples/motor_rig.toml"),
      {{"lose-frames", "direction = \"from-drive\"", "the drive has stopped telling where it is"},
       {"emergency", "code = 0x2", "the drive is in fault (error 2h: its motor has stalled)"},
       {"reboot", "", "the drive was silent for a while and may have started anew"},
       {"stick", "", "the axis is too far from its target"},
       {"foreign-sender", "", "somebody else sends what only this program may send"}},
      expect_at_rest_without_power);
}

}  // namespace motor_run_test
}  // namespace inbetween
