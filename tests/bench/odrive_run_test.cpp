// A whole move over the kernel's CAN on ODrives of both families: `run` on one side, `sim-drives` on the
// other.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include "tests/support/bench.hpp"
#include "tests/support/bus_scene.hpp"
#include "tests/support/places.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace odrive_run_test {

using testing::AllOf;
using testing::HasSubstr;

struct OdriveAxis {
  const char* name;
  double turns_per_unit;
};
constexpr OdriveAxis axes[] = {{"slide", 0.04}, {"pan", -0.125}, {"tilt", 0.125}};

std::string odrive_rig() {
  return in_checkout("examples/odrive_rig.toml");
}
BusScene odrive_scene(BusSceneOptions options = {}) {
  options.rig = odrive_rig();
  return BusScene(options);
}
void expect_at_rest_without_power(const BusScene& scene) {
  scene.expect_all_stand(testing::AnyOf("idle", "fault"));
}
/// The rig was on its way, and did not go on to its end.
void expect_stopped_with(const BusScene& scene, const std::string& words) {
  EXPECT_EQ(scene.run.status, 4) << scene.run.err;
  EXPECT_THAT(scene.run.out, HasSubstr(words));
  expect_at_rest_without_power(scene);
  scene.expect_part_of_path(0.04);
}

TEST(OdriveRun, TheDrivesOwnRecordOfTheirTargetsIsThePlanAtEveryTick) {
  const BusScene scene = odrive_scene();
  ASSERT_EQ(scene.run.status, 0) << scene.run.err << scene.run.out;
  expect_at_rest_without_power(scene);
  for (const OdriveAxis& axis : axes) {
    SCOPED_TRACE(axis.name);
    // Float32 turns, of up to 72 turns of the slide.
    scene.expect_plan(axis.name, axis.turns_per_unit, 4e-6 / std::fabs(axis.turns_per_unit));
  }
}

// docs/faults.md 29
TEST(OdriveRun, KilledInMotionTheDrivesStopByTheirOwnWatchdogs) {
  const BusScene scene = odrive_scene({.during = "sleep 7; kill -KILL $run"});
  EXPECT_EQ(scene.run.status, 128 + 9);
  expect_at_rest_without_power(scene);
  EXPECT_THAT(scene.emergencies("slide"), testing::Contains("1000000"));
  EXPECT_THAT(scene.emergencies("tilt"), testing::Contains("0800"));
}

// docs/faults.md 29
TEST(OdriveFault, ADriveWithoutAWatchdogIsRefusedAndNothingIsSwitchedOn) {
  const BusScene scene = odrive_scene({.faults = fault_text("pan", "no-watchdog")});
  EXPECT_EQ(scene.run.status, 4) << scene.run.err;
  EXPECT_THAT(scene.run.out,
              AllOf(HasSubstr("axis \"pan\": the drive did not notice that this program was silent"),
                    HasSubstr("switch its watchdog on")));
  scene.expect_no_targets();
}

TEST(OdriveFault, ADriveOfTheOtherFamilyIsRefusedAndNothingIsSwitchedOn) {
  const TemporaryFolder folder;
  for (const char* axis : {"slide", "tilt"}) {
    std::string text = file_contents(odrive_rig());
    const bool is_06 = axis == std::string("slide");
    const std::string said = is_06 ? "0.04, firmware = \"0.6\"" : "firmware = \"0.5\"";
    const std::string is = is_06 ? "0.04, firmware = \"0.5\"" : "firmware = \"0.6\"";
    text.replace(text.find(said), said.size(), is);
    const std::string rig = (folder.path() / "rig.toml").string();
    std::ofstream(rig) << text;
    const BusScene scene = odrive_scene({.rig_of_drives = rig});
    EXPECT_EQ(scene.run.status, 4) << scene.run.err;
    EXPECT_THAT(scene.run.out, HasSubstr(fmt::format(
                                   "axis \"{}\": the drive has another firmware than the rig says", axis)));
    scene.expect_no_targets();
  }
}

// docs/faults.md 17, 20, 21, 23, 24, 25
TEST(OdriveFault, WhatIsWrongWithADriveInMotionStopsAllAndIsSaidInWords) {
  expect_faults_said(
      odrive_rig(),
      {{"lose-frames", "direction = \"from-drive\"", "the drive has stopped telling where it is"},
       {"lose-heartbeat", "", "the heartbeat of the drive has stopped"},
       {"emergency", "code = 0x4000", "the drive is in fault (error 4000h: its power stage is too hot)"},
       {"reboot", "", "the drive has started anew"},
       {"stick", "", "the axis is too far from its target"},
       {"foreign-sender", "", "somebody else sends what only this program may send"}},
      [](const BusScene& scene) {
        expect_at_rest_without_power(scene);
        scene.expect_part_of_path(0.04);
      });
}

// Somebody looks at it by its USB port.
TEST(OdriveFault, OneThatAnotherProgramSwitchesOffIsToldSo) {
  const BusScene scene = odrive_scene({.faults = fault_text("pan", "switched-off", "after_motion = 4")});
  expect_stopped_with(scene, "axis \"pan\": somebody else has switched the drive off");
}

// docs/faults.md 16
TEST(OdriveFault, ALinkThatGoesDownEndsTheRunAndTheDrivesStop) {
  const BusScene scene = odrive_scene({.during = "sleep 7; ip link set can0 down"});
  expect_stopped_with(scene, "bus \"can0\" is down or off");
}

TEST(OdriveRun, CtrlCEndsWithTheDrivesOff) {
  const BusScene scene = odrive_scene({.during = "sleep 7; kill -INT $run"});
  EXPECT_EQ(scene.run.status, 4) << scene.run.err;
  expect_at_rest_without_power(scene);
  for (const OdriveAxis& axis : axes) EXPECT_THAT(scene.emergencies(axis.name), testing::IsEmpty());
}

// docs/faults.md 48. The rig stands at the end of the move, and its drives count from 0 again.
TEST(OdriveRun, ADriveThatForgotItsTurnsIsNotBelieved) {
  const TemporaryFolder folder;
  const std::string drives = "inbetween sim-drives --rig '" + odrive_rig() + "' --record drives.csv";
  const std::string on = " 2>drives.txt & drives=$!\nuntil_true grep -q power drives.txt\n";
  const std::string off = "kill -TERM $drives; wait $drives\n";
  const ProgramRun run = script_in_bench(
      {"--vcan", "can0", "--virtual-time"},
      "cd '" + folder.path().string() +
          "'\nexport XDG_STATE_HOME=$PWD\necho -1 >/proc/sys/kernel/sched_rt_runtime_us\n" + drives +
          " --from slide=60 --from pan=-62 --from tilt=-4" + on + "status=0\n" +
          BusScene::run_command(odrive_rig()) +
          " --yes 2>&1 || status=$?\necho first ended with $status\ninbetween goto --rig '" + odrive_rig() +
          "' --stands-at slide=60 pan=-62 tilt=-4\nstatus=0\n" + BusScene::run_command(odrive_rig()) +
          " --yes || status=$?\necho second ended with $status\n" + off + drives + on + "status=0\n" +
          BusScene::run_command(odrive_rig()) + " --yes || status=$?\n" + off +
          "grep end drives.csv\nexit $status");
  EXPECT_THAT(run.out, AllOf(HasSubstr("does not know where it is"), HasSubstr("first ended with 1"),
                             HasSubstr("second ended with 0")));
  EXPECT_EQ(run.status, 1) << run.out;
  EXPECT_THAT(run.err,
              AllOf(HasSubstr("axis \"slide\" was left at 16"), HasSubstr("its drive tells 0, 1640 mm less"),
                    HasSubstr("--stands-at slide=16")));
  for (const OdriveAxis& axis : axes) {
    EXPECT_THAT(run.out, testing::ContainsRegex(fmt::format("{},end,idle,-?0\\.0000", axis.name)))
        << "it has not moved";
  }
}

TEST(OdriveRun, TheDoctorTriesEveryDriveAndNamesWhatIsWrong) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "faults.toml") << fault_text("tilt", "no-watchdog");
  const ProgramRun run = script_in_bench(
      {"--vcan", "can0", "--virtual-time"},
      "cd '" + folder.path().string() + "'\necho -1 >/proc/sys/kernel/sched_rt_runtime_us\n" +
          "inbetween sim-drives --rig '" + odrive_rig() +
          "' --faults faults.toml 2>drives.txt & drives=$!\n" +
          "until_true grep -q power drives.txt\nstatus=0\ninbetween doctor --rig '" + odrive_rig() +
          "' --drives --seconds 0.2 || status=$?\nkill -TERM $drives; wait $drives; exit $status");
  EXPECT_EQ(run.status, 4) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("fine     axis \"slide\": node 1 has firmware 0.6 and told within"),
                             HasSubstr("fine     axis \"pan\": node 2 has firmware 0.6"),
                             HasSubstr("problem  axis \"tilt\": the drive did not notice")));
}

}  // namespace odrive_run_test
}  // namespace inbetween
