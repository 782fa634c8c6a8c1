// Faults of a script, in the whole program on a simulated rig.
#include "host_tools/rig/fault_schedule.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/places.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace fault_schedule_test {

using testing::HasSubstr;

const std::string examples = in_checkout("examples/");

ProgramRun run_with(const std::string& faults) {
  return run_program({"run", examples + "reveal.toml", "--rig", examples + "camera_rig.toml", "--sim",
                      "--fast", "--faults", faults});
}

ProgramRun run_with_text(const std::string& faults) {
  const TemporaryFile file("faults.toml", faults);
  return run_with(file.path().string());
}

/// "1153 ticks"
int ticks_of(const ProgramRun& run) {
  const std::size_t end = run.out.find(" ticks at");
  if (end == std::string::npos) return -1;
  const std::size_t begin = run.out.rfind(' ', end - 1);
  return std::stoi(run.out.substr(begin + 1, end - begin - 1));
}

TEST(FaultSchedule, TheExampleLosesAnAxisInTheMidstOfTheMove) {
  const ProgramRun run = run_with(examples + "faults/lost_axis.toml");
  EXPECT_EQ(run.status, 4);
  EXPECT_THAT(run.out, HasSubstr("axis \"tilt\": the drive has stopped telling where it is"));
}

TEST(FaultSchedule, AfterMotionCountsFromTheFirstMotionAndAtFromPowerOn) {
  const std::string sticks = "[[fault]]\naxis = \"slide\"\nwhat = \"stick\"\n";
  const int late = ticks_of(run_with_text(sticks + "after_motion = 4"));
  const int early = ticks_of(run_with_text(sticks + "after_motion = 3"));
  EXPECT_NEAR(late - early, 250, 25);
  const int from_power = ticks_of(run_with_text(sticks + "at = 4"));
  EXPECT_LT(from_power, late) << "the drives boot and are set up before anything moves";
  EXPECT_GT(from_power, 0);
}

TEST(FaultSchedule, WhatIsCountedIsToldOfWhomItIsAndOfNobodyElse) {
  EXPECT_THAT(run_with_text("[[fault]]\naxis = \"pan\"\nwhat = \"reboot\"\nafter_motion = 100\n").out,
              testing::Not(HasSubstr("counted:")));
  const TemporaryFile faults(
      "faults.toml",
      "[[fault]]\naxis = \"pan\"\nwhat = \"duplicate-frames\"\nafter_motion = 1\ncount = 3\n"
      "[[fault]]\naxis = \"tilt\"\nwhat = \"short-frames\"\nafter_motion = 2\ncount = 2\n");
  const TemporaryFolder folder;
  const std::string json_file = (folder.path() / "run.json").string();
  const ProgramRun run =
      run_program({"run", examples + "reveal.toml", "--rig", examples + "camera_rig.toml", "--sim", "--fast",
                   "--faults", faults.path().string(), "--json", json_file});
  EXPECT_EQ(run.status, 0) << run.out;
  const auto json = nlohmann::json::parse(file_contents(json_file));
  const auto& drives = json["drives"];
  ASSERT_EQ(drives.size(), 3U);
  EXPECT_EQ(drives[1]["duplicates"], 3);
  EXPECT_EQ(drives[2]["bad_frames"], 2);
  EXPECT_EQ(drives[2]["missed"], 2);
  EXPECT_EQ(drives[0]["duplicates"], 0);
  EXPECT_EQ(drives[0]["bad_frames"], 0);
  EXPECT_EQ(drives[1]["bad_frames"], 0);
  EXPECT_EQ(drives[2]["duplicates"], 0);
  EXPECT_THAT(run.out, HasSubstr("  counted: pan: duplicates 3; tilt: missed 2, bad frames 2\n"));
}

TEST(FaultSchedule, AFaultAfterTheMoveHarmsNothing) {
  const ProgramRun run = run_with_text("[[fault]]\naxis = \"pan\"\nwhat = \"reboot\"\nafter_motion = 100\n");
  EXPECT_EQ(run.status, 0) << run.out;
}

TEST(FaultSchedule, WhatADriveIsIsFoundBeforeAnythingMoves) {
  const ProgramRun run = run_with_text("[[fault]]\naxis = \"pan\"\nwhat = \"no-watchdog\"\n");
  EXPECT_EQ(run.status, 4);
  EXPECT_THAT(run.out, HasSubstr("axis \"pan\": the drive would run on if this program died"));
}

TEST(FaultSchedule, AScriptThatIsWrongMovesNothing) {
  const TemporaryFile file("faults.toml", "[[fault]]\naxis = \"nod\"\nwhat = \"stick\"\nat = 1\n");
  const ProgramRun run = run_with(file.path().string());
  EXPECT_EQ(run.status, 1);
  EXPECT_EQ(run.err.find(file.path().string() + ":2:8: error: axis is \"nod\""), 0U) << run.err;
}

TEST(FaultSchedule, FaultsAreForSimulatedDrives) {
  const ProgramRun run = run_program({"run", examples + "reveal.toml", "--rig", examples + "camera_rig.toml",
                                      "--faults", examples + "faults/lost_axis.toml"});
  EXPECT_EQ(run.status, 2);
  EXPECT_THAT(run.err, HasSubstr("--faults is for simulated drives; add --sim"));
}

}  // namespace fault_schedule_test
}  // namespace inbetween
