// `home` on the kernel's GPIO: with switches on the travel of the motors, and with some that do not do what
// switches do.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "tests/bench/gpio_scene.hpp"

namespace inbetween {
namespace gpio_home_test {

using testing::AllOf;
using testing::HasSubstr;

constexpr unsigned step_x = 0, dir_x = 1, step_y = 2, dir_y = 3, enable_x = 4, enable_y = 5;
constexpr double steps_per_unit = 10;
constexpr std::int64_t ms = 1'000'000;

/// An axis with a home on the chip.
AxisText homed_axis(const std::string& name, const std::string& lines, unsigned home) {
  return gpio_axis(name, {0, 100}, R"(chip = "head", enable_active = "high", )" + lines,
                   fmt::format("home = {{ chip = \"head\", line = {}, bias = \"none\", direction = "
                               "\"negative\", fast = 20, slow = 2, back_off = 2 }}",
                               home));
}
const std::string rig_of_both = rig_text({homed_axis("x", "step = 0, dir = 1, enable = 4", 6),
                                          homed_axis("y", "step = 2, dir = 3, enable = 5", 7)},
                                         {.name = "bench", .rate_hz = 250, .more = "step_watch_us = 0\n"});

/// Both axes look for their switches. That of y is in order, and far away.
struct HomeScene : GpioScene {
  HomeScene(const std::string& before, const std::string& during, const std::string& rig = rig_of_both)
      : GpioScene({.rig = rig,
                   .at_zero = {"x", "y"},
                   .before = before,
                   .command = "home --rig rig.toml --positions positions",
                   .during = during}) {}

  /// Steps of a motor that go up, and those that go down.
  struct Counts {
    int up = 0;
    int down = 0;
  };
  [[nodiscard]] Counts counts(unsigned step, unsigned dir) const {
    Counts counts;
    for (std::size_t i = 1; i < record.size(); ++i) {
      if (is_high(i, step) && !is_high(i - 1, step)) ++(is_high(i, dir) ? counts.up : counts.down);
    }
    return counts;
  }
  /// Where the position file has an axis; not a number where it does not know.
  [[nodiscard]] double kept(const std::string& axis) const {
    std::istringstream lines(positions);
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with("at ") && line.ends_with(" " + axis)) return std::stod(line.substr(3));
    }
    return std::numeric_limits<double>::quiet_NaN();
  }
  /// y was on its way at the speed of `fast`, and slowed down when x failed.
  void expect_y_was_stopped_with_x() const {
    const std::vector<std::int64_t> x = rises(step_x);
    const std::vector<std::int64_t> y = rises(step_y);
    ASSERT_FALSE(x.empty());
    ASSERT_GT(y.size(), 20U);
    EXPECT_EQ(counts(step_y, dir_y).up, 0);
    EXPECT_LT(y.size(), 900U) << "y went to the end of its travel";
    // x failed when it had come to rest, within a stop of 200 ms and the times of its switch.
    EXPECT_GT(y.back(), x.back());
    EXPECT_LT(y.back(), x.back() + 500 * ms);
    for (std::size_t i = y.size() - 15; i < y.size(); ++i) {
      EXPECT_GE(y[i] - y[i - 1], y[i - 1] - y[i - 2] - ms) << "step " << i << " of y";
    }
  }
  void expect_off_and_lost() const {
    EXPECT_EQ(run.status, 4);
    EXPECT_THAT(positions, AllOf(HasSubstr("unreferenced x\n"), HasSubstr("unreferenced y\n")));
    for (const unsigned enable : {enable_x, enable_y}) {
      EXPECT_TRUE(has_ever_been_high(enable));
      EXPECT_FALSE(is_high_at_the_end(enable));
    }
  }
};

TEST(GpioHome, AxesThatFindTheirSwitchesKnowToTheStepWhereTheyAre) {
  constexpr int switch_x = -150, switch_y = -260;
  const HomeScene scene(
      fmt::format("{0} $chips/head {1} {2} 6 {3} 4 & {0} $chips/head {4} {5} 7 {6} 4 &",
                  "inbetween_turn_switch", step_x, dir_x, switch_x, step_y, dir_y, switch_y),
      "");
  EXPECT_EQ(scene.run.status, 0) << scene.run.err;
  EXPECT_THAT(scene.run.out, HasSubstr("bench: the axes are home"));
  struct Axis {
    const char* name;
    unsigned step, dir;
    int closes;
  };
  for (const Axis& axis : {Axis{"x", step_x, dir_x, switch_x}, Axis{"y", step_y, dir_y, switch_y}}) {
    const HomeScene::Counts counts = scene.counts(axis.step, axis.dir);
    EXPECT_GT(counts.up, 20) << "it backed off";
    EXPECT_NEAR(scene.kept(axis.name) * steps_per_unit, counts.up - counts.down - axis.closes, 1)
        << axis.name;
  }
}

// docs/faults.md 33
TEST(GpioHome, ASwitchThatIsActuatedFromTheBeginningAndStaysSoStopsAllAxes) {
  const HomeScene scene("pull 6 up", "");
  EXPECT_THAT(scene.run.out, HasSubstr("bench: axis \"x\": the switch stays actuated although the axis has "
                                       "left it; see whether it sticks"));
  const HomeScene::Counts x = scene.counts(step_x, dir_x);
  EXPECT_GT(x.up, 4 * 20) << "off the switch, by more than it may take to open";
  EXPECT_LT(x.up, 200);
  EXPECT_EQ(x.down, 0);
  scene.expect_y_was_stopped_with_x();
  scene.expect_off_and_lost();
}

TEST(GpioHome, ASwitchThatDoesNotOpenAgainStopsAllAxes) {
  const HomeScene scene("", "pull 6 up");
  EXPECT_THAT(scene.run.out, HasSubstr("bench: axis \"x\": the switch stays actuated although the axis has "
                                       "left it; see whether it sticks"));
  const HomeScene::Counts x = scene.counts(step_x, dir_x);
  EXPECT_GT(x.down, 50) << "to the switch";
  EXPECT_GT(x.up, 20) << "and off it";
  EXPECT_LT(x.up, 100);
  scene.expect_y_was_stopped_with_x();
  scene.expect_off_and_lost();
}

TEST(GpioHome, ASwitchThatIsNotReachedInTheAllowedDistanceStopsAllAxes) {
  std::string rig = rig_of_both;
  rig.replace(rig.find("back_off = 2 }"), 14, "back_off = 2, search = 20 }");
  const HomeScene scene("", "", rig);
  EXPECT_THAT(scene.run.out, HasSubstr("bench: axis \"x\": the switch was not reached within the distance to "
                                       "look for it; see whether its wire is broken"));
  const HomeScene::Counts x = scene.counts(step_x, dir_x);
  EXPECT_EQ(x.down, 200) << "the distance that is allowed";
  EXPECT_EQ(x.up, 0);
  scene.expect_y_was_stopped_with_x();
  scene.expect_off_and_lost();
}

}  // namespace gpio_home_test
}  // namespace inbetween
