// A whole move over the kernel's CAN FD on moteus controllers, and one on drives of three protocols: `run` on
// one side, `sim-drives` on the other.
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
namespace moteus_run_test {

using testing::AllOf;
using testing::HasSubstr;

struct MoteusAxis {
  const char* name;
  double turns_per_unit;
};
constexpr MoteusAxis moteus_axes[] = {{"slide", 0.02}, {"pan", -0.0277777778}, {"tilt", 0.0277777778}};

std::string moteus_rig() {
  return in_checkout("examples/moteus_rig.toml");
}
BusScene moteus_scene(BusSceneOptions options = {}) {
  options.rig = moteus_rig();
  return BusScene(options);
}
/// The tick of its record in which an axis is at the beginning of the plan: it holds its place before the
/// move. Both are compared where they have gone a hundredth of the path.
std::size_t begin_of_plan(const BusScene& scene, const std::string& axis, double scale) {
  const std::vector<double> planned = planned_positions(axis);
  const std::vector<double> applied = scene.applied(axis);
  const double far = 0.01 * std::fabs(planned.back() - planned.front());
  std::size_t first = 0, first_planned = 0;
  while (std::fabs(applied.at(first) - applied.front()) < far * std::fabs(scale)) ++first;
  while (std::fabs(planned.at(first_planned) - planned.front()) < far) ++first_planned;
  EXPECT_GE(first, first_planned) << axis;
  return first - first_planned;
}

TEST(MoteusRun, TheDrivesOwnRecordOfTheirTargetsIsThePlanAtEveryTick) {
  const BusScene scene = moteus_scene();
  ASSERT_EQ(scene.run.status, 0) << scene.run.err << scene.run.out;
  scene.expect_all_stand(testing::Eq("stopped"));
  for (const MoteusAxis& axis : moteus_axes) {
    SCOPED_TRACE(axis.name);
    const std::vector<double> planned = planned_positions(axis.name);
    const std::vector<double> applied = scene.applied(axis.name);
    EXPECT_THAT(scene.emergencies(axis.name), testing::IsEmpty());
    const std::size_t first = begin_of_plan(scene, axis.name, axis.turns_per_unit);
    // Float32 turns, of up to 36 turns of the slide.
    const double resolution = 4e-6 / std::fabs(axis.turns_per_unit);
    for (std::size_t tick = 0; tick < planned.size(); ++tick) {
      ASSERT_NEAR(applied.at(first + tick) / axis.turns_per_unit, planned[tick], resolution)
          << "tick " << tick;
    }
  }
}

// docs/faults.md 29
TEST(MoteusFault, KilledInMotionTheDrivesBrakeByTheirOwnWatchdogs) {
  const BusScene scene = moteus_scene({.during = "sleep 7; kill -KILL $run"});
  EXPECT_EQ(scene.run.status, 128 + 9);
  scene.expect_all_stand(testing::Eq("timeout"));
  for (const MoteusAxis& axis : moteus_axes) {
    EXPECT_THAT(scene.emergencies(axis.name), testing::ElementsAre("010B")) << axis.name;
  }
}

// docs/faults.md 29
TEST(MoteusFault, ADriveWithoutAWatchdogIsRefusedAndNothingIsSwitchedOn) {
  const BusScene scene = moteus_scene({.faults = fault_text("pan", "no-watchdog")});
  EXPECT_EQ(scene.run.status, 4) << scene.run.err;
  EXPECT_THAT(scene.run.out,
              HasSubstr("axis \"pan\": the drive did not notice that this program was silent"));
  scene.expect_no_targets();
  scene.expect_all_stand(testing::Eq("stopped"));
}

TEST(MoteusFault, AnInterfaceWithoutCanFdIsRefusedWithTheRemedy) {
  const ProgramRun run = script_in_bench(
      {"--vcan", "can0", "--virtual-time"},
      "echo -1 >/proc/sys/kernel/sched_rt_runtime_us\nip link set can0 down\nip link set can0 mtu 16 up\n" +
          BusScene::run_command(moteus_rig()) + " && exit 9\ninbetween doctor --rig '" + moteus_rig() +
          "' --seconds 0.2");
  EXPECT_EQ(run.status, 4) << run.err;
  EXPECT_THAT(run.err, AllOf(HasSubstr("moteus_rig.toml:"), HasSubstr("can0 does not carry CAN FD frames"),
                             HasSubstr("dbitrate DATA_BITRATE fd on")));
  EXPECT_THAT(run.out,
              HasSubstr("problem  bus can0: does not carry CAN FD frames, which its drives speak; as "
                        "root: ip link set can0 down; ip link set can0 mtu 72 up"));
}

// docs/faults.md 17, 20, 21, 23, 24, 25
TEST(MoteusFault, WhatIsWrongWithADriveInMotionStopsAllAndIsSaidInWords) {
  expect_faults_said(
      moteus_rig(),
      {{"lose-frames", "direction = \"from-drive\"", "the drive has stopped telling where it is"},
       {"emergency", "code = 38", "the drive is in fault (fault 38: it is too hot)"},
       {"reboot", "", "the drive has started anew"},
       {"stick", "", "the axis is too far from its target"},
       {"short-frames", "", "the drive has stopped telling where it is"},
       {"foreign-sender", "", "somebody else sends what only this program may send"}},
      [](const BusScene& scene) {
        scene.expect_all_stand(testing::_);
        scene.expect_part_of_path(0.02);
      });
}

TEST(MoteusFault, TheDoctorTriesEveryDriveAndLeavesThemWithoutPower) {
  const ProgramRun run = script_in_bench(
      {"--vcan", "can0", "--virtual-time"},
      "echo -1 >/proc/sys/kernel/sched_rt_runtime_us\ncd /tmp\ninbetween sim-drives --rig '" + moteus_rig() +
          "' --record record.csv 2>drives.txt & drives=$!\nuntil_true grep -q power drives.txt\nstatus=0\n"
          "inbetween doctor --rig '" +
          moteus_rig() +
          "' --drives --seconds 0.2 || status=$?\nkill -TERM $drives; wait $drives; grep ,end, record.csv; "
          "exit "
          "$status");
  EXPECT_EQ(run.status, 0) << run.err << run.out;
  EXPECT_THAT(run.out,
              AllOf(HasSubstr("fine     axis \"slide\": node 1 has registers of version 5, a watchdog "
                              "of 50 ms with every command, and told within"),
                    HasSubstr("fine     axis \"tilt\": node 3"), HasSubstr("slide,end,stopped"),
                    HasSubstr("tilt,end,stopped")));
}

/// The camera rig with a CiA 402 drive and an ODrive on can0 and a moteus on can1.
std::string three_protocols_rig() {
  std::string text = file_contents(moteus_rig());
  const auto change = [&](const std::string& what, const std::string& to) {
    const std::size_t at = text.find(what);
    ASSERT_NE(at, std::string::npos) << what;
    text.replace(at, what.size(), to);
  };
  change("[bus.can0]", "[bus.can0]\nbitrate = 1_000_000\n\n[bus.can1]");
  change(R"(type = "moteus", bus = "can0", node = 1, turns_per_unit = 0.02)",
         R"(type = "cia402", bus = "can0", node = 1, counts_per_unit = 1000)");
  change(R"(type = "moteus", bus = "can0", node = 2, turns_per_unit = -0.0277777778)",
         R"(type = "odrive", bus = "can0", node = 8, turns_per_unit = -0.125, firmware = "0.6")");
  change(R"(bus = "can0", node = 3)", R"(bus = "can1", node = 3)");
  return text;
}

/// When the drive is where each tick of the plan wants it, as it says itself.
std::vector<std::int64_t> times_of_ticks(const BusScene& scene, const std::string& axis, double scale) {
  const std::vector<BusScene::Target>& applied = scene.targets(axis);
  const std::size_t first = begin_of_plan(scene, axis, scale);
  std::vector<std::int64_t> times;
  for (std::size_t tick = 0; tick < planned_positions(axis).size(); ++tick) {
    times.push_back(applied.at(first + tick).at_ns);
  }
  return times;
}

TEST(MoteusRun, OneMoveOnThreeProtocolsAndTwoBusesIsOneMotion) {
  const TemporaryFolder folder;
  const std::string rig = (folder.path() / "rig.toml").string();
  std::ofstream(rig) << three_protocols_rig();
  const BusScene scene({.bench = {"--vcan", "can1"}, .rig = rig});
  ASSERT_EQ(scene.run.status, 0) << scene.run.err << scene.run.out;
  constexpr std::int64_t tick_ns = 4'000'000;
  const auto slide = times_of_ticks(scene, "slide", 1000);
  const auto pan = times_of_ticks(scene, "pan", -0.125);
  const auto tilt = times_of_ticks(scene, "tilt", 0.0277777778);
  std::int64_t skew_ns = 0;
  for (std::size_t tick = 0; tick < slide.size(); ++tick) {
    // A moteus is told a position when it shall leave it, the others when they shall go there.
    const auto [earliest, latest] = std::minmax({slide[tick], pan[tick], tilt[tick] - tick_ns});
    skew_ns = std::max(skew_ns, latest - earliest);
  }
  RecordProperty("skew_us", static_cast<int>(skew_ns / 1000));
  fmt::print("skew of the targets of a tick, at most: {:.3f} ms\n", static_cast<double>(skew_ns) * 1e-6);
  EXPECT_LT(skew_ns, 2'000'000) << "the drives look at their buses every millisecond";
}

}  // namespace moteus_run_test
}  // namespace inbetween
