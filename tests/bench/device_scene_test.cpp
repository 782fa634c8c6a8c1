// Jog under a device of the kernel's own, uinput: what a pipe drive is told while somebody holds a key of it,
// lets go, unplugs it, turns its wheel.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/bench.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace device_scene_test {

using testing::HasSubstr;

// 20 counts a degree, from 1300 to 2700. Jog takes a tenth of the speed: 20 deg/s; a stop takes all of it.
const std::string rig = rig_text(
    {axis_text("jaw", "deg", {-10, 60}, {.velocity = 200, .acceleration = 2000}, R"(unpowered = "holds")",
               R"(type = "pipe", path = "servos", counts_per_unit = 20, count_at_zero = 1500, )"
               R"(min_count = 1300, max_count = 2700, no_watchdog = "accepted")")},
    {.name = "jaw", .rate_hz = 250});
constexpr int ticks_per_s = 250;
/// A look at the device, the delay to the loop, and 20 deg/s at 2000 deg/s^2, which is 10 ms.
constexpr int ticks_to_rest = 8;

struct DeviceScene {
  /// What happens at the device, for jog with a reach.
  DeviceScene(const std::string& actions, const std::string& reach) {
    std::ofstream(folder.path() / "rig.toml") << rig;
    run = script_in_bench({"--virtual-time"},
                          "cd '" + folder.path().string() +
                              "'\necho -1 >/proc/sys/kernel/sched_rt_runtime_us\nmkfifo servos\n"
                              "inbetween goto --rig rig.toml --positions positions --set-zero jaw\n"
                              "export TERM=dumb\ninbetween_hold_device servos record " +
                              actions +
                              " -- inbetween jog jaw --rig rig.toml --positions positions --device DEVICE "
                              "--reach " +
                              reach);
    std::istringstream record(file_contents((folder.path() / "record").string()));
    for (std::string line; std::getline(record, line);) {
      if (line.starts_with("# ")) {
        said.push_back(line.substr(2));
        at.push_back(counts.size());
      } else if (const std::size_t sign = line.find("jaw="); sign != std::string::npos) {
        counts.push_back(std::stoi(line.substr(sign + 4)));
      }
    }
  }
  /// The number of lines that were there when this was done.
  [[nodiscard]] std::size_t when(const std::string& action) const {
    const auto found = std::ranges::find(said, action);
    EXPECT_NE(found, said.end()) << action;
    return found == said.end() ? 0 : at[static_cast<std::size_t>(found - said.begin())];
  }
  /// The first line from which on nothing moves until the last but `before_end`.
  [[nodiscard]] std::size_t at_rest_before(std::size_t end) const {
    std::size_t first = end - 1;
    while (first > 0 && counts[first - 1] == counts[end - 1]) --first;
    return first;
  }

  TemporaryFolder folder;
  ProgramRun run;
  std::vector<int> counts;  ///< of every line
  std::vector<std::string> said;
  std::vector<std::size_t> at;
};

TEST(DeviceScene, OfAKeyThatIsLetGoTheAxisRestsAsSoonAsItsLimitsAllow) {
  const DeviceScene scene("0:enter 500:press 600:release 800:q", "1");
  ASSERT_EQ(scene.run.status, 0) << scene.run.err << scene.run.out;
  const std::size_t released = scene.when("release");
  EXPECT_EQ(scene.counts[scene.when("press")], 1500) << "before it is pressed";
  EXPECT_GT(scene.counts[released], 1600) << "5 degrees in 0.4 s";
  EXPECT_LE(scene.at_rest_before(scene.when("q")), released + ticks_to_rest);
  EXPECT_LT(scene.counts[scene.when("q") - 1], scene.counts[released - 1] + 20);
  EXPECT_THAT(scene.said, testing::Contains("others heard 2, and then 1"))
      << "Enter, which was held, was let go for all; what came then was for this program alone";
}

TEST(DeviceScene, ThatAnotherProgramHasForItselfIsRefusedInOneLine) {
  const DeviceScene scene("0:grab", "1");
  EXPECT_EQ(scene.run.status, 1) << scene.run.err << scene.run.out;
  EXPECT_TRUE(scene.counts.empty());
  EXPECT_THAT(
      file_contents((scene.folder.path() / "record").string()),
      HasSubstr("/dev/input/event0: error: the device cannot be used: Device or resource busy; another "
                "program has it for itself; end that"));
}

TEST(DeviceScene, UnpluggedTheAxisRestsAsIfItWereLetGo) {
  const DeviceScene scene("500:press 600:unplug 800:q", "1");
  ASSERT_EQ(scene.run.status, 0) << scene.run.err << scene.run.out;
  const std::size_t unplugged = scene.when("unplug");
  EXPECT_GT(scene.counts[unplugged], 1600);
  EXPECT_LE(scene.at_rest_before(scene.when("q")), unplugged + ticks_to_rest);
}

TEST(DeviceScene, HeldForAMinuteTheAxisGoesItsReachAndNeverBeyondItsLimit) {
  const DeviceScene scene("500:press 15500:release 15600:press 30600:release 30700:q", "0.5");
  ASSERT_EQ(scene.run.status, 0) << scene.run.err << scene.run.out;
  EXPECT_EQ(scene.counts[15'000], 2200) << "35 degrees, and no further";
  EXPECT_EQ(scene.counts[30'600], 2700) << "pressed anew, to its limit";
  EXPECT_EQ(std::ranges::max(scene.counts), 2700);
  EXPECT_LE(scene.at_rest_before(15'500), 500 + 2 * ticks_per_s) << "in 2 s at 20 deg/s";
}

TEST(DeviceScene, AWheelThatWasSpunForASecondRestsWithinTheTimeOfOneStep) {
  std::string actions;
  for (int line = 500; line < 750; ++line) actions += std::to_string(line) + ":turn ";
  const DeviceScene scene("450:5 " + actions + "1000:q", "1");
  ASSERT_EQ(scene.run.status, 0) << scene.run.err << scene.run.out;
  const int moved = std::ranges::max(scene.counts) - 1500;
  EXPECT_EQ(moved % 10, 0) << "whole steps of half a degree";
  EXPECT_GE(moved, 30);
  // Half a degree at 200 deg/s^2 takes 0.1 s.
  EXPECT_LE(scene.at_rest_before(scene.when("q")), 750 + ticks_per_s / 10 + ticks_to_rest);
}

}  // namespace device_scene_test
}  // namespace inbetween
