// Faults of a script, in the whole program on a simulated rig.
#include "host_tools/fault_schedule.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace {

using testing::HasSubstr;

const std::string examples = INBETWEEN_SOURCE_DIR "/examples/";

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

}  // namespace
}  // namespace inbetween
