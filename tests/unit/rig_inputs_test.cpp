// The input lines of a rig under the loop, on lines that are simulated.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/rig/gpio_inputs.hpp"
#include "host_tools/rig/rig_drives.hpp"
#include "host_tools/rig/simulated_hardware.hpp"
#include "tests/support/rig_text.hpp"

namespace inbetween {
namespace rig_inputs_test {

using testing::HasSubstr;

constexpr std::int64_t tick_ns = 4'000'000;

const std::string slider = rig_text(
    {axis_text(
         "slide", "mm", {0, 800}, {.velocity = 100, .acceleration = 200},
         R"(home = { chip = "head", line = 23, direction = "negative", fast = 20, slow = 2, back_off = 5, at = -5 }
limit_min = { chip = "head", line = 24 }
limit_max = { chip = "head", line = 25, active = "low", bias = "pull-up" })",
         R"(type = "step-dir", chip = "head", step = 17, dir = 27, steps_per_unit = 80)"),
     axis_text("pan", "deg", {-90, 90}, {.velocity = 60, .acceleration = 120},
               R"(limit_max = { chip = "head", line = 26 })",
               R"(type = "step-dir", chip = "head", step = 18, dir = 28, steps_per_unit = 80)")},
    {.name = "slider", .rate_hz = 250, .more = R"([emergency_stop]
chip = "head"
line = 5
stops_at = "high"
[start_trigger]
chip = "head"
line = 6
active = "low"
[camera]
chip = "head"
line = 13
asks = { chip = "head", line = 16 }
)"});

/// The lines that no axis has come first, in this order.
enum class RigInput : std::uint8_t { emergency_stop, start_trigger, camera_asks };

struct RigLinesTest : ::testing::Test {
  RigFile rig = parse_rig(slider, "rig.toml");
  std::optional<SimulatedHardware> hardware{std::in_place, rig, std::vector{100.0, 0.0}};
  std::optional<RigInputs> lines{std::in_place, rig, *hardware};
  std::int64_t now_ns = 1'000'000'000;

  void SetUp() override { ticks(3); }

  void stand(std::vector<double> positions) {
    lines.reset();
    hardware.emplace(rig, std::move(positions));
    lines.emplace(rig, *hardware);
  }
  void tick() {
    now_ns += tick_ns;
    lines->read(now_ns);
  }
  void ticks(int count) {
    for (int i = 0; i < count; ++i) tick();
  }
  void set(RigInput input, bool is_active) { set(input, is_active, now_ns + 1'000'000); }
  void set(RigInput input, bool is_active, std::int64_t at_ns) {
    const bool is_active_low = input == RigInput::start_trigger;
    hardware->inputs().set(static_cast<std::size_t>(input), is_active != is_active_low, at_ns);
  }
  /// The axis is moved there at a steady speed. How often a limit was hit.
  int move(std::size_t axis, double from, double to, int count) {
    int hits = 0;
    for (int i = 1; i <= count; ++i) {
      hardware->inputs().follow(axis, from + (to - from) * i / count, now_ns + tick_ns);
      tick();
      hits += lines->limit_hit() ? 1 : 0;
    }
    return hits;
  }
};

TEST_F(RigLinesTest, NothingIsPressedAtFirst) {
  EXPECT_FALSE(lines->emergency_stop());
  EXPECT_FALSE(lines->limit_hit());
  EXPECT_FALSE(lines->start_triggered());
  EXPECT_FALSE(lines->camera_asks());
  EXPECT_FALSE(lines->is_gone());
  EXPECT_TRUE(lines->events().empty());
  EXPECT_EQ(lines->trouble(), "");
}

TEST_F(RigLinesTest, TheEmergencyStopStopsForAsLongAsItsLevelAsks) {
  set(RigInput::emergency_stop, true);
  for (int i = 0; i < 5; ++i) {
    tick();
    EXPECT_TRUE(lines->emergency_stop()) << i;
  }
  EXPECT_THAT(lines->trouble(), HasSubstr("emergency stop is pressed"));
  EXPECT_THAT(lines->trouble(), HasSubstr("line 5 of chip \"head\""));
  set(RigInput::emergency_stop, false);
  tick();
  tick();
  EXPECT_FALSE(lines->emergency_stop());
}

TEST_F(RigLinesTest, AnEdgeOfTheEmergencyStopAloneStops) {
  set(RigInput::emergency_stop, true, now_ns + 1'000'000);
  set(RigInput::emergency_stop, false, now_ns + 1'100'000);
  tick();
  EXPECT_TRUE(lines->emergency_stop());
  EXPECT_THAT(lines->trouble(), HasSubstr("emergency stop was pressed"));
  tick();
  EXPECT_FALSE(lines->emergency_stop());
  EXPECT_THAT(lines->trouble(), HasSubstr("emergency stop was pressed"));
  lines->begin();
  EXPECT_EQ(lines->trouble(), "") << "whoever moves the rig again knows of it";
}

TEST_F(RigLinesTest, TheSignalIsAnEmergencyStopBesideTheWiredOne) {
  std::raise(SIGUSR1);
  EXPECT_TRUE(lines->emergency_stop());
  EXPECT_EQ(lines->trouble(), "the emergency stop is pressed; remove the cause, release it");
  std::raise(SIGUSR2);
  EXPECT_FALSE(lines->emergency_stop());
}

TEST_F(RigLinesTest, ALimitSwitchIsHitOnceAndCanBeLeft) {
  EXPECT_EQ(move(1, 0, 90, 100), 0) << "inside the limits";
  EXPECT_EQ(move(1, 90, 95, 20), 1);
  EXPECT_EQ(
      lines->trouble(),
      "axis \"pan\" reached its limit switch (line 26 of chip \"head\"); move it off slowly, and look why");
  EXPECT_TRUE(lines->homing_input(1).limit_hit) << "it stands on it";
  lines->begin();
  EXPECT_EQ(lines->trouble(), "");
  EXPECT_TRUE(lines->homing_input(1).limit_hit) << "that it is known does not open it";
  EXPECT_EQ(move(1, 95, 80, 50), 0);
  EXPECT_FALSE(lines->homing_input(1).limit_hit);
  EXPECT_EQ(move(1, 80, 95, 50), 1) << "and again";
}

TEST_F(RigLinesTest, TheSwitchesOfTheOtherEndAndOfTheOtherLevelAreHitToo) {
  EXPECT_EQ(move(0, 100, 830, 400), 1);
  EXPECT_FALSE(lines->homing_input(1).limit_hit) << "of another axis";
  EXPECT_EQ(move(0, 830, -40, 800), 1);
  EXPECT_TRUE(lines->homing_input(0).limit_hit);
}

TEST_F(RigLinesTest, ALimitSwitchThatIsNeverQuietStopsLikeOneThatIsHit) {
  int ticks_until_hit = 0;
  for (; ticks_until_hit < 20 && !lines->limit_hit(); ++ticks_until_hit) {
    for (int i = 1; i <= 8; ++i) {
      hardware->inputs().follow(1, i % 2 == 0 ? 80 : 95, now_ns + i * tick_ns / 8);
    }
    tick();
  }
  EXPECT_LT(ticks_until_hit, 20);
  EXPECT_EQ(lines->trouble(),
            "a limit switch of axis \"pan\" is never quiet (line 26 of chip \"head\"); look at its wire and "
            "contact");
  hardware->inputs().follow(1, 80, now_ns + tick_ns);
  ticks(5);
  EXPECT_FALSE(lines->limit_hit()) << "it is quiet again";
}

TEST_F(RigLinesTest, AnAxisThatStandsOnItsLimitSwitchAtFirstHasNotJustReachedIt) {
  lines.reset();
  stand({100, 99});
  for (int i = 0; i < 5; ++i) {
    tick();
    EXPECT_FALSE(lines->limit_hit());
  }
  EXPECT_TRUE(lines->homing_input(1).limit_hit);
}

TEST_F(RigLinesTest, AHomeSwitchIsAtItsPlaceAndTellsTheTimeOfItsEdge) {
  const SwitchSettings home = lines->home_switch(0);
  EXPECT_EQ(lines->homing_input(0).level, !home.active_level);
  hardware->inputs().follow(0, 0, now_ns + tick_ns);
  tick();
  const std::int64_t at_zero_ns = now_ns;
  // 10 mm in a tick: the edge at -5 mm is in the middle of it.
  hardware->inputs().follow(0, -10, now_ns + tick_ns);
  tick();
  EXPECT_EQ(lines->homing_input(0).level, home.active_level);
  ASSERT_EQ(lines->events().size(), 1U);
  EXPECT_EQ(lines->events()[0].line, home.line);
  EXPECT_EQ(lines->events()[0].level, home.active_level);
  EXPECT_NEAR(static_cast<double>(lines->events()[0].at_ns - at_zero_ns), tick_ns / 2.0, 2);
  EXPECT_FALSE(lines->homing_input(0).limit_hit) << "a home switch is no limit switch";
}

TEST_F(RigLinesTest, BehindTheHomeSwitchIsTheDistanceThatAStopTakes) {
  std::string fast = slider;
  fast.replace(fast.find("fast = 20"), 9, "fast = 80");
  rig = parse_rig(fast, "rig.toml");
  lines.reset();
  stand({100, 0});
  tick();
  // From 80 mm/s at 200 mm/s^2: 16 mm, and 4 mm in the 50 ms until the edge is known.
  EXPECT_EQ(move(0, 100, -25, 100), 0);
}

TEST_F(RigLinesTest, EventsOfAllLinesComeInTheOrderOfTheirTimes) {
  set(RigInput::camera_asks, true, now_ns + 3'000'000);
  set(RigInput::emergency_stop, true, now_ns + 1'000'000);
  set(RigInput::start_trigger, true, now_ns + 2'000'000);
  tick();
  ASSERT_EQ(lines->events().size(), 3U);
  for (std::size_t i = 1; i < 3; ++i) EXPECT_LT(lines->events()[i - 1].at_ns, lines->events()[i].at_ns);
  EXPECT_NE(lines->events()[0].line, lines->events()[1].line);
  EXPECT_NE(lines->events()[1].line, lines->events()[2].line);
}

TEST_F(RigLinesTest, TheStartTriggerIsToldOnceAndNotByASpike) {
  set(RigInput::start_trigger, true, now_ns + 1'000'000);
  set(RigInput::start_trigger, false, now_ns + 1'200'000);
  ticks(3);
  EXPECT_FALSE(lines->start_triggered());
  set(RigInput::start_trigger, true);
  ticks(3);
  EXPECT_TRUE(lines->start_triggered());
  EXPECT_FALSE(lines->start_triggered());
  set(RigInput::start_trigger, false);
  ticks(3);
  EXPECT_FALSE(lines->start_triggered());
}

TEST_F(RigLinesTest, TheCameraAsksByAShortPulseAndOnceForItsBounces) {
  for (int i = 0; i < 3; ++i) {
    set(RigInput::camera_asks, true, now_ns + 1'000'000 + i * 200'000);
    set(RigInput::camera_asks, false, now_ns + 1'100'000 + i * 200'000);
  }
  tick();
  EXPECT_TRUE(lines->camera_asks());
  ticks(3);
  EXPECT_FALSE(lines->camera_asks());
  set(RigInput::camera_asks, true);
  ticks(3);
  EXPECT_TRUE(lines->camera_asks());
  set(RigInput::camera_asks, false);
  ticks(3);
  EXPECT_FALSE(lines->camera_asks()) << "its release";
}

TEST_F(RigLinesTest, ASimulatedRigIsFollowed) {
  stand({100, 99});
  const RigDrives drives(rig, *hardware);
  EXPECT_NEAR(hardware->true_position(0), 100, 1.0 / 80);
  EXPECT_NEAR(hardware->true_position(1), 99, 1.0 / 80);
  ticks(3);
  EXPECT_TRUE(lines->homing_input(1).limit_hit) << "where the shaft is";
  EXPECT_FALSE(lines->homing_input(0).limit_hit);
}

}  // namespace rig_inputs_test
}  // namespace inbetween
