// A whole move over the kernel's CAN: `run` on one side, `sim-drives` as a process of its own on the other.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cctype>
#include <cmath>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/bench.hpp"
#include "tests/support/bus_scene.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace can_run_test {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

using Scene = BusScene;

TEST(CanRun, TheDrivesOwnRecordOfTheirTargetsIsThePlanAtEveryTick) {
  const Scene scene("");
  ASSERT_EQ(scene.run.status, 0) << scene.run.err;
  for (const char* axis : {"slide", "pan", "tilt"}) {
    const std::vector<double>& planned = planned_counts(axis);
    const std::vector<double> applied = scene.applied(axis);
    ASSERT_GT(applied.size(), planned.size()) << axis;
    // It holds its place before the move, and the end after it: aligned by the first target that differs.
    std::size_t first = 0;
    while (first < applied.size() && applied[first] == applied.front()) ++first;
    std::size_t first_planned = 0;
    while (std::fabs(planned[first_planned] - applied.front()) <= 0.5) ++first_planned;
    ASSERT_GE(first, first_planned) << axis;
    for (std::size_t tick = 0; tick < planned.size(); ++tick) {
      const std::size_t at = first - first_planned + tick;
      ASSERT_LT(at, applied.size());
      ASSERT_NEAR(applied[at], planned[tick], 1) << axis << ", tick " << tick;
    }
  }
}

TEST(CanRun, AfterAMoveEveryDriveIsOffAndNoneEverReportsAnEmergency) {
  const Scene scene("");
  ASSERT_EQ(scene.run.status, 0) << scene.run.err;
  scene.expect_quiet();
}

TEST(CanRun, CtrlCSigtermAndALostTerminalEndWithTheDrivesOff) {
  for (const char* signal : {"INT", "TERM", "HUP"}) {
    const Scene scene(std::string("sleep 7; kill -") + signal + " $run");
    EXPECT_EQ(scene.run.status, 4) << signal << scene.run.err;
    scene.expect_quiet();
  }
}

// While the drives are set up: at the beginning of it, in its midst, and while they are switched on.
TEST(CanRun, WhoeverLeavesBeforeTheMoveLeavesTheDrivesOff) {
  for (const char* seconds : {"0.2", "0.6", "1.0", "1.2"}) {
    const Scene scene(std::string("sleep ") + seconds + "; kill -INT $run");
    EXPECT_EQ(scene.run.status, 4) << seconds << scene.run.err;
    scene.expect_quiet();
  }
}

// A drive that watches SYNC at one and a half periods would be in fault after one that is late by one period.
TEST(CanRun, ALateTickIsNoFaultOfADriveThatWatchesSyncStrictly) {
  const Scene scene("sleep 7; kill -STOP $run; sleep 0.009; kill -CONT $run");
  EXPECT_THAT(scene.run.out, HasSubstr("late ticks 1;")) << scene.run.err;
  scene.expect_quiet();
}

// docs/faults.md 29
TEST(CanRun, KilledInMotionTheDrivesStopByTheirOwnWatchdogs) {
  const Scene scene("sleep 7; kill -KILL $run");
  EXPECT_EQ(scene.run.status, 128 + 9);
  EXPECT_THAT(scene.drives, HasSubstr("slide,"));
  for (const char* axis : {"slide", "pan", "tilt"}) {
    // An axis that is fast meets its window for the following error a moment before: its target stands still.
    EXPECT_THAT(scene.last_state(axis), testing::AnyOf("switch-on disabled", "fault")) << axis;
    EXPECT_THAT(scene.emergencies(axis), testing::Contains("8250")) << axis << " missed its setpoints";
  }
  scene.expect_rest();
}

// docs/faults.md 14. Error frames as a controller would send them.
TEST(CanRun, BusOffCeasesSetpointsAndErrorPassiveDoesNot) {
  const Scene passive("sleep 7; cansend can0 20000004#0010000000000000");
  EXPECT_EQ(passive.run.status, 0) << passive.run.err;
  const Scene off("sleep 7; cansend can0 20000040#0000000000000000");
  EXPECT_EQ(off.run.status, 4) << off.run.err;
  EXPECT_THAT(off.run.out, HasSubstr("bus \"can0\" is down or off"));
  off.expect_rest();
}

// docs/faults.md 49. The drives clamp what is outside of 607D.
TEST(CanRun, AnAxisOutsideItsLimitsIsHeldThereAndComesIn) {
  const TemporaryFolder folder;
  const std::string rig = BusScene::rig();
  const ProgramRun run = script_in_bench(
      {"--vcan", "can0", "--virtual-time"},
      "echo -1 >/proc/sys/kernel/sched_rt_runtime_us\ncd '" + folder.path().string() +
          "'\ninbetween sim-drives --rig '" + rig +
          "' --from slide=-3 --from pan=190 --record drives 2>err & drives=$!\nuntil_true grep -q power "
          "err\nstatus=0\n" +
          BusScene::run_command(rig) +
          " --yes 2>refused || status=$?\ncat refused\necho run ended with $status\n" +
          "inbetween goto --rig '" + rig + "' --yes slide=0 pan=180 && echo in\n" +
          "sleep 1\nkill -TERM $drives; wait $drives\ngrep -E '^(slide|pan),(end|emergency|[0-9])' drives");
  EXPECT_THAT(
      run.out,
      AllOf(HasSubstr("axis \"slide\" stands at -3 mm, outside its limits 0..1800 mm; bring it in with"),
            HasSubstr("run ended with 1"), HasSubstr("\nin\n"), Not(HasSubstr("emergency"))));
  std::map<std::string, std::vector<double>> targets;
  std::istringstream lines(run.out);
  for (std::string line; std::getline(lines, line);) {
    for (const std::string axis : {"slide", "pan"}) {
      if (!line.starts_with(axis + ",") || std::isdigit(line[axis.size() + 1]) == 0) continue;
      targets[axis].push_back(std::stod(line.substr(line.rfind(',') + 1)));
    }
  }
  ASSERT_EQ(targets.size(), 2U) << run.err;
  EXPECT_EQ(targets["slide"].front(), -3000);
  EXPECT_EQ(targets["slide"].back(), 0);
  EXPECT_EQ(targets["pan"].front(), 760'000);
  EXPECT_EQ(targets["pan"].back(), 720'000);
  for (std::size_t i = 1; i < targets["slide"].size(); ++i) {
    const double step = targets["slide"][i] - targets["slide"][i - 1];
    ASSERT_GE(step, 0);
    ASSERT_LE(step, 0.1 * 500 * 0.004 * 1000 + 1) << "a tenth of its velocity";
  }
  for (std::size_t i = 1; i < targets["pan"].size(); ++i) ASSERT_LE(targets["pan"][i], targets["pan"][i - 1]);
}

/// `home` of a slide that its drive homes, 60 mm from its home, with `during` beside it. The drives print
/// what became of them.
ProgramRun homed_by_drive(const std::string& during) {
  const std::string rig = rig_text(
      {axis_text("slide", "mm", {0, 300}, {.velocity = 100, .acceleration = 400}, R"(unpowered = "holds"
home = { by = "drive", method = 17, fast = 20, slow = 5, acceleration = 200, at = 10 })",
                 cia402_text(1))},
      {.name = "table", .rate_hz = 250, .more = bus_can0});
  const TemporaryFile file("table.toml", rig);
  // The bench shares the files of this machine: what a scene writes is in a folder of its own.
  const std::string folder = file.path().parent_path().string();
  return script_in_bench(
      {"--vcan", "can0", "--virtual-time"},
      "echo -1 >/proc/sys/kernel/sched_rt_runtime_us\ncd '" + folder +
          "'\ninbetween sim-drives --rig table.toml --from slide=70 --record drives 2>err & drives=$!\n"
          "until_true grep -q power err\ninbetween home --rig table.toml --positions positions & run=$!\n" +
          during +
          "\nstatus=0; wait $run || status=$?\n"
          "if [ $status = 0 ]; then inbetween goto --rig table.toml --positions positions --yes slide=30; "
          "fi\n"
          "sleep 1\nkill -TERM $drives; wait $drives || cat err >&2\n"
          "grep -E 'end|emergency' drives; exit $status");
}

TEST(CanRun, ADriveHomesItselfAndTheNextCommandGoesOnFromThere) {
  const ProgramRun run = homed_by_drive("");
  EXPECT_EQ(run.status, 0) << run.out << run.err;
  EXPECT_THAT(run.out, HasSubstr("table: the axes are home"));
  EXPECT_THAT(run.out, testing::ContainsRegex("slide,end,switch-on disabled,(29999|30000)\\."));
  EXPECT_THAT(run.out, testing::Not(HasSubstr("slide,emergency"))) << run.out;
}

TEST(CanRun, ADriveThatHomesItselfBrakesWhenThisProgramIsKilled) {
  const ProgramRun run = homed_by_drive("sleep 2; kill -KILL $run");
  EXPECT_EQ(run.status, 128 + 9) << run.err;
  EXPECT_THAT(run.out, HasSubstr("slide,emergency"));
  EXPECT_THAT(run.out, testing::ContainsRegex("slide,end,(switch-on disabled|fault),[0-9.]+,-?0\\.000"));
}

// docs/faults.md 15
TEST(CanRun, AfterAKilledRunTheNextOneSetsEverythingUpAnewAndGoesToTheStartSlowly) {
  const Scene scene("sleep 7; kill -KILL $run; sleep 3; " + BusScene::run_command() +
                    " --yes && echo played again");
  EXPECT_THAT(scene.run.out, HasSubstr("played again")) << scene.run.err;
  EXPECT_THAT(scene.run.err, HasSubstr("the rig is not where the move starts"));
  EXPECT_THAT(scene.drives, HasSubstr(",1640000."));
}

// docs/faults.md 16
TEST(CanRun, ALinkThatGoesDownEndsTheRunAndTheDrivesStop) {
  for (const char* what : {"ip link set can0 down", "ip link del can0"}) {
    const Scene scene(std::string("sleep 7; ") + what);
    EXPECT_EQ(scene.run.status, 4) << scene.run.err;
    EXPECT_THAT(scene.run.out, HasSubstr("bus \"can0\" is down or off")) << what;
    scene.expect_rest();
  }
}

// docs/faults.md 13
TEST(CanRun, AQueueThatStaysFullIsAStop) {
  const Scene scene("sleep 7; tc qdisc add dev can0 root netem delay 1s limit 10", {"--echo"});
  EXPECT_EQ(scene.run.status, 4) << scene.run.err;
  EXPECT_THAT(scene.run.out, HasSubstr("reveal: "));
  scene.expect_rest();
}

// docs/faults.md 17
// Pan passes 0 at about that time: a drive that jumps further than that for a tick reports a following error.
TEST(CanRun, AForeignSenderOnOurIdentifiersIsAStopOnThePath) {
  const Scene scene("sleep 6.4; cansend can0 202#0F0000000000");
  EXPECT_EQ(scene.run.status, 4) << scene.run.err;
  EXPECT_THAT(scene.run.out, HasSubstr("axis \"pan\""));
  scene.expect_quiet();
}

// docs/faults.md 36
TEST(CanRun, AStallOfTheLoopIsAControlledStopAndNeverABurst) {
  const Scene scene("sleep 7; kill -STOP $run; sleep 0.05; kill -CONT $run");
  EXPECT_EQ(scene.run.status, 4) << scene.run.err;
  EXPECT_THAT(scene.run.out, HasSubstr("late ticks 1;"));
  scene.expect_rest();
  const std::vector<double> targets = scene.applied("slide");
  ASSERT_GT(targets.size(), 1000U);
  for (std::size_t i = 1; i < targets.size(); ++i) {
    ASSERT_LE(std::fabs(targets[i] - targets[i - 1]), 1.2 * 500 * 1000 / 250 + 1)
        << "max_velocity is 500 mm/s";
  }
  scene.expect_let_go();
}

// docs/faults.md 37
TEST(CanRun, WithoutTheRightsOfARealTimeProgramNothingIsArmed) {
  const Scene scene("", {}, "setpriv --reuid 65534 --regid 65534 --clear-groups ");
  EXPECT_EQ(scene.run.status, 1) << scene.run.err;
  EXPECT_THAT(scene.run.err, HasSubstr("--allow-jitter"));
  EXPECT_THAT(scene.drives, testing::Not(HasSubstr("slide,1"))) << "no target was applied";
}

// docs/faults.md 42
TEST(CanRun, ASecondInstanceIsRefused) {
  const std::string second = "sleep 5; " + BusScene::run_command() + " && exit 99 || true";
  const Scene scene(second);
  EXPECT_EQ(scene.run.status, 0) << scene.run.err;
  EXPECT_THAT(scene.run.err, HasSubstr("another inbetween uses bus can0; end it first"));
}

// docs/faults.md 22
TEST(CanRun, DrivesThatAreNotThereAreNamedAndNothingIsSwitchedOn) {
  const ProgramRun run =
      script_in_bench({"--vcan", "can0", "--virtual-time"},
                      "echo -1 >/proc/sys/kernel/sched_rt_runtime_us\n" + BusScene::run_command());
  EXPECT_EQ(run.status, 4) << run.err;
  EXPECT_THAT(run.out, HasSubstr("axis \"slide\""));
}

TEST(CanRun, ABusThatIsNotThereIsSaidAtItsPlaceInTheRig) {
  const ProgramRun run = script_in_bench({}, BusScene::run_command());
  EXPECT_EQ(run.status, 1) << run.err;
  EXPECT_THAT(run.err, HasSubstr("camera_rig.toml:"));
  EXPECT_THAT(run.err, HasSubstr("can0"));
}

}  // namespace can_run_test
}  // namespace inbetween
