// Whole moves on stepper drivers at the kernel's GPIO: `run` on one side of the lines, on the other somebody
// who writes down every change of them.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include "tests/bench/gpio_scene.hpp"
#include "tests/support/bench.hpp"
#include "tests/support/bus_scene.hpp"
#include "tests/support/places.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace gpio_run_test {

using testing::AllOf;
using testing::HasSubstr;
using testing::MatchesRegex;

constexpr double steps_per_unit = 10;
constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t tick_ns = 4 * ms;

const std::string rig_of_both = rig_text(
    {gpio_axis("x", {-1, 60}, R"(chip = "head", step = 0, dir = 1, enable = 4, enable_active = "high")",
               R"(limit_max = { chip = "head", line = 7, active = "high", bias = "none" })"),
     gpio_axis("y", {-60, 1}, R"(chip = "head", step = 2, dir = 3, enable = 5, enable_active = "high")")},
    {.name = "bench", .rate_hz = 250, .more = "step_watch_us = 0\n" + emergency_stop_of_head});
constexpr unsigned step_x = 0, dir_x = 1, step_y = 2, dir_y = 3, enable_x = 4, enable_y = 5;
constexpr unsigned emergency_stop = 6, limit_x = 7;

/// What the lines did while the move was run: `during` happens in the middle of it.
struct GpioRunScene : GpioScene {
  explicit GpioRunScene(const std::string& during, const std::vector<std::string>& more_of_bench = {})
      : GpioScene({.rig = rig_of_both,
                   .move = move_of_both,
                   .at_zero = {"x", "y"},
                   .during = during,
                   .more_of_bench = more_of_bench}) {}
  /// Steps in both axes, and not the whole move.
  void expect_a_part_of_the_move() const {
    EXPECT_GT(rises(step_x).size(), 50U);
    EXPECT_LT(rises(step_x).size(), 450U);
    EXPECT_GT(rises(step_y).size(), 20U);
    EXPECT_LT(rises(step_y).size(), 180U);
  }
  void expect_drives_off() const {
    ASSERT_FALSE(record.empty());
    EXPECT_FALSE(is_high_at_the_end(enable_x));
    EXPECT_FALSE(is_high_at_the_end(enable_y));
  }
};

/// When the plan passes the middle between two steps, from the tick of the start on; an axis that goes one
/// way.
std::vector<double> planned_ns(const GpioRunScene& scene, int column) {
  const std::string csv = run_program({"plan", scene.path("move.toml"), "--rig", scene.path("rig.toml"),
                                       "--per", "tick", "--csv", "-"})
                              .out;
  std::vector<double> at_ns;
  double before = 0;
  std::size_t tick = 0;
  for (const double position : column_of(csv, column)) {
    const double steps = std::fabs(position) * steps_per_unit;
    for (double next = static_cast<double>(at_ns.size()) + 0.5; next <= steps; next += 1) {
      const double share = (next - before) / (steps - before);
      at_ns.push_back((static_cast<double>(tick) - 1 + share) * static_cast<double>(tick_ns));
    }
    before = steps;
    ++tick;
  }
  return at_ns;
}

TEST(GpioRun, TheStepsOnTheLinesAreThePlanInNumberDirectionAndTime) {
  const GpioRunScene scene("");
  ASSERT_EQ(scene.run.status, 0) << scene.run.err << scene.run.out;
  struct Axis {
    unsigned step, dir, enable;
    int column;
    std::size_t steps;
  };
  for (const Axis& axis : {Axis{step_x, dir_x, enable_x, 2, 500}, Axis{step_y, dir_y, enable_y, 3, 200}}) {
    const std::vector<std::int64_t> rises = scene.rises(axis.step);
    const std::vector<double> planned = planned_ns(scene, axis.column);
    ASSERT_EQ(planned.size(), axis.steps);
    ASSERT_EQ(rises.size(), axis.steps);
    double offset = 0;
    for (std::size_t i = 0; i < rises.size(); ++i) offset += static_cast<double>(rises[i]) - planned[i];
    offset /= static_cast<double>(rises.size());
    for (std::size_t i = 0; i < rises.size(); ++i) {
      ASSERT_NEAR(static_cast<double>(rises[i]) - offset, planned[i], 0.5e6) << "step " << i;
    }
    std::vector<bool> directions;
    for (std::size_t i = 1; i < scene.record.size(); ++i) {
      if (scene.is_high(i, axis.step) && !scene.is_high(i - 1, axis.step)) {
        directions.push_back(scene.is_high(i, axis.dir));
        ASSERT_TRUE(scene.is_high(i, axis.enable)) << "the drive is off at step " << directions.size();
      }
    }
    EXPECT_EQ(std::ranges::count(directions, directions.front()), static_cast<std::ptrdiff_t>(axis.steps));
  }
  scene.expect_drives_off();
}

// docs/faults.md 32
TEST(GpioRun, TheEmergencyStopInMotionEndsTheStepsWithinATick) {
  const GpioRunScene scene(fmt::format("pull {} up", emergency_stop));
  EXPECT_EQ(scene.run.status, 4) << scene.run.err << scene.run.out;
  EXPECT_THAT(scene.run.out, HasSubstr("the emergency stop is pressed, or its wire is broken"));
  EXPECT_THAT(scene.run.out, HasSubstr("line 6 of chip \"head\""));
  scene.expect_a_part_of_the_move();
  ASSERT_EQ(scene.rises(emergency_stop).size(), 1U);
  const std::int64_t pressed_ns = scene.rises(emergency_stop).front();
  EXPECT_LE(scene.rises(step_x).back(), pressed_ns + tick_ns + ms);
  EXPECT_LE(scene.rises(step_y).back(), pressed_ns + tick_ns + ms);
  scene.expect_drives_off();
}

TEST(GpioRun, AnEmergencyStopThatIsReleasedAtOnceStopsAsWell) {
  const GpioRunScene scene(fmt::format("pull {0} up; sleep 0.02; pull {0} down", emergency_stop));
  EXPECT_EQ(scene.run.status, 4) << scene.run.err << scene.run.out;
  EXPECT_THAT(scene.run.out, HasSubstr("the emergency stop was pressed, or its wire is loose"));
  scene.expect_a_part_of_the_move();
  scene.expect_drives_off();
}

TEST(GpioRun, ALimitSwitchInMotionIsAStopOnThePath) {
  const GpioRunScene scene(fmt::format("pull {} up", limit_x));
  EXPECT_EQ(scene.run.status, 4) << scene.run.err << scene.run.out;
  EXPECT_THAT(scene.run.out, HasSubstr("axis \"x\" reached its limit switch (line 7 of chip \"head\")"));
  scene.expect_a_part_of_the_move();
  const std::vector<std::int64_t> x = scene.rises(step_x);
  const std::vector<std::int64_t> y = scene.rises(step_y);
  EXPECT_NEAR(static_cast<double>(x.size()) / 50, static_cast<double>(y.size()) / 20, 0.06)
      << "both axes stop where the path is";
  const std::int64_t hit_ns = scene.rises(limit_x).front();
  EXPECT_GT(x.back(), hit_ns + 5 * tick_ns) << "it slows down";
  EXPECT_LT(x.back(), hit_ns + 1000 * ms) << "and rests";
  // From the tick that heard the switch on, a step takes as long as the one before, or longer.
  for (std::size_t i = 2; i < x.size(); ++i) {
    if (x[i - 2] < hit_ns + 4 * tick_ns) continue;
    EXPECT_GE(x[i] - x[i - 1], x[i - 1] - x[i - 2] - ms) << "step " << i;
  }
  scene.expect_drives_off();
}

// docs/faults.md 34
TEST(GpioRun, AChipThatIsUnpluggedInMotionEndsTheRun) {
  const GpioRunScene scene("echo 0 >/sys/kernel/config/gpio-sim/bench-head/live");
  EXPECT_EQ(scene.run.status, 4) << scene.run.err << scene.run.out;
  EXPECT_THAT(scene.run.out, HasSubstr("chip \"head\" of the rig has gone"));
  scene.expect_a_part_of_the_move();
}

// docs/faults.md 30
TEST(GpioRun, ABusyLineNamesItsUserAndNothingIsSwitchedOn) {
  const std::vector<unsigned> busy{emergency_stop, limit_x, step_x, dir_y, enable_y};
  const TemporaryFolder folder;
  std::string script =
      "cd " + folder.path().string() + "\nchip=$(basename $(readlink $INBETWEEN_BENCH_GPIO/head))\n";
  std::ofstream(folder.path() / "rig.toml") << rig_of_both;
  std::ofstream(folder.path() / "move.toml") << move_of_both;
  EXPECT_EQ(run_program({"goto", "--rig", (folder.path() / "rig.toml").string(), "--positions",
                         (folder.path() / "positions").string(), "--set-zero", "x", "y"})
                .status,
            0);
  script += "inbetween_watch_lines $INBETWEEN_BENCH_GPIO/head {0..7} >record & watch=$!\n";
  for (const unsigned line : busy) {
    // Somebody who listens to the line has it, and leaves its level alone.
    script += fmt::format(
        "gpiomon --chip $chip --consumer lamp {0} >/dev/null & lamp=$!\n"
        "until_true eval 'gpioinfo --chip $chip {0} | grep -q lamp'\n"
        "inbetween run move.toml --rig rig.toml --positions positions 2>err{0} || echo $? >status{0}\n"
        "kill $lamp; wait $lamp || true\n",
        line);
  }
  const ProgramRun run =
      script_in_bench({"--gpio", "head:8", "--virtual-time"}, script + "sleep 0.5; kill $watch");
  EXPECT_EQ(run.status, 0) << run.err;
  const auto text_of = [&](const std::string& name) {
    return file_contents((folder.path() / name).string());
  };
  for (const unsigned line : busy) {
    EXPECT_EQ(text_of(fmt::format("status{}", line)), "1\n");
    EXPECT_THAT(text_of(fmt::format("err{}", line)),
                AllOf(HasSubstr(fmt::format("line {} of chip head is in use by lamp", line)),
                      HasSubstr("rig.toml:")));
  }
  EXPECT_EQ(std::ranges::count(text_of("record"), '\n'), 1) << "a level has changed";
}

// docs/faults.md 35. What is left of the lines when nobody holds them is the chip's affair: this one leaves
// them to what pulls at them, as docs ask of the wiring of ENABLE.
TEST(GpioRun, KilledInMotionTheStepsEndAndWhatPullsAtEnableDecides) {
  const GpioRunScene scene("kill -KILL $run");
  EXPECT_EQ(scene.run.status, 128 + 9);
  scene.expect_a_part_of_the_move();
  EXPECT_TRUE(scene.has_ever_been_high(enable_x));
  scene.expect_drives_off();
  EXPECT_LT(scene.record.back().at_ns, scene.rises(step_x).front() + 3000 * ms) << "then it was killed";
}

TEST(GpioRun, AStepRateBeyondTheDrivesIsRefusedAtItsPlaceInTheRig) {
  const TemporaryFile move("move.toml", move_of_both);
  std::string text = rig_of_both;
  text.replace(text.find("max_velocity = 33"), 17, "max_velocity = 34");
  const TemporaryFile rig("rig.toml", text);
  const ProgramRun run =
      script_in_bench({"--gpio", "head:8"},
                      fmt::format("inbetween run {} --rig {}", move.path().string(), rig.path().string()));
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.err, HasSubstr("rig.toml:"));
  EXPECT_THAT(run.err, HasSubstr("max_step_rate"));
}

TEST(GpioRun, AMixedRigPlaysOneMoveOnCanAndOnGpioTogether) {
  const TemporaryFolder folder;
  const std::string rig = (folder.path() / "rig.toml").string();
  const std::string record = (folder.path() / "record.csv").string();
  const std::string err = (folder.path() / "err").string();
  // Nobody has closed the contacts of this chip: what its own resistors say would be "pressed".
  std::string text = file_contents(in_checkout("examples/mixed_rig.toml"));
  for (std::size_t at = 0; (at = text.find("\"pull-up\"", at)) != std::string::npos;) {
    text.replace(at, 9, "\"none\"");
  }
  std::ofstream(rig) << text;
  // Shorter than the example's: the kernel of the bench watches the clock before every step.
  const std::string move = (folder.path() / "move.toml").string();
  std::ofstream(move) << R"(name = "a little"
fps = 24
frames = 72
[[track]]
axes = ["track"]
keys = [ { at = [200] }, { at = [230] } ]
speed = [0, 0, 10, 0, 0]
[[track]]
axes = ["focus"]
keys = [ { at = [0] }, { at = [9] } ]
speed = [0, 0, 10, 0, 0]
)";
  const std::string positions = (folder.path() / "positions").string();
  EXPECT_EQ(run_program({"goto", "--rig", rig, "--positions", positions, "--set-zero", "focus"}).status, 0);
  const ProgramRun run = script_in_bench(
      {"--gpio", "pinctrl-bcm2711:54", "--vcan", "can0", "--virtual-time"},
      "echo -1 >/proc/sys/kernel/sched_rt_runtime_us\nsleep 1\ninbetween sim-drives --rig " + rig +
          " --from track=200 --record " + record + " 2>" + err + " & drives=$!\nuntil_true grep -q power " +
          err + "\nstatus=0; inbetween run " + move + " --rig " + rig + " --positions " + positions +
          " --yes --json - || status=$?\nkill -TERM $drives; wait $drives; exit $status");
  EXPECT_EQ(run.status, 0) << run.err << run.out;
  const std::string drives = file_contents(record);
  EXPECT_THAT(drives, HasSubstr("track,end,")) << drives.substr(0, 200);
  EXPECT_THAT(drives, HasSubstr(",115000")) << "230 mm of 500 counts";
  EXPECT_THAT(run.out, HasSubstr(R"("ended":"finished")"));
  EXPECT_THAT(run.out, HasSubstr(R"("name":"focus","last_commanded":9,"last_actual":9,)"));
  EXPECT_THAT(run.out, MatchesRegex(R"re(.*"label":"pinctrl-bcm2711","played":[1-9][0-9]*,.*)re"))
      << "what its chip was told is counted";
}

}  // namespace gpio_run_test
}  // namespace inbetween
