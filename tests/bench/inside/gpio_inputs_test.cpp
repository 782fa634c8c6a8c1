#include "drivers/gpio/gpio_inputs.hpp"

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "drivers/linux/monotonic_clock.hpp"
#include "tests/bench/inside/allowed_calls.hpp"
#include "tests/bench/inside/simulated_chip.hpp"

namespace inbetween::gpio {
namespace gpio_inputs_test {

struct GpioInputsTest : ::testing::Test {
  SimulatedChip simulated{"io", 6};
  GpioChip chip;
  GpioInputs inputs;

  void SetUp() override { ASSERT_FALSE(chip.open("io")); }

  LineEvent next_event() {
    std::array<LineEvent, 1> event{};
    while (inputs.read(event) == 0) ::sched_yield();
    return event[0];
  }

  std::vector<LineEvent> all_events() {
    std::vector<LineEvent> all;
    std::array<LineEvent, 48> some{};
    while (const std::size_t count = inputs.read(some))
      all.insert(all.end(), some.begin(), some.begin() + count);
    return all;
  }
};

struct GpioInputsOnVirtualTime : GpioInputsTest {
  void SetUp() override {
    if (!is_on_virtual_time()) GTEST_SKIP() << "run it alone";
    GpioInputsTest::SetUp();
  }
};

TEST_F(GpioInputsTest, LevelsAreThoseOfAllLinesInTheOrderInWhichTheyWereAskedFor) {
  const std::array<InputLine, 3> lines = {InputLine{.line = 5U}, InputLine{.line = 1U},
                                          InputLine{.line = 2U, .is_inverted = true}};
  ASSERT_FALSE(inputs.open(chip, lines));
  EXPECT_EQ(inputs.levels(), 0b100U);
  simulated.pull(5, true);
  EXPECT_EQ(inputs.levels(), 0b101U);
  simulated.pull(1, true);
  simulated.pull(2, true);
  EXPECT_EQ(inputs.levels(), 0b011U);
  simulated.pull(0, true);
  EXPECT_EQ(inputs.levels(), 0b011U);
}

TEST_F(GpioInputsTest, AResistorOfTheChipHoldsALineThatNobodyDrives) {
  const std::array<InputLine, 2> lines = {InputLine{.line = 0U, .bias = Bias::pull_up},
                                          InputLine{.line = 1U, .bias = Bias::pull_down}};
  ASSERT_FALSE(inputs.open(chip, lines));
  EXPECT_EQ(inputs.levels(), 0b01U);
}

TEST_F(GpioInputsTest, AnEmergencyStopTellsItsEdgeItsTimeAndItsLevel) {
  const std::array<InputLine, 2> lines = {InputLine{.line = 0U}, InputLine{.line = 3U}};
  const MonotonicClock clock;
  simulated.pull(3, true);
  ASSERT_FALSE(inputs.open(chip, lines));
  EXPECT_EQ(inputs.levels(), 0b10U);

  const std::int64_t before_ns = clock.now_ns();
  simulated.pull(3, false);
  EXPECT_EQ(inputs.levels(), 0b00U);
  const LineEvent event = next_event();
  EXPECT_EQ(event.line, 1);
  EXPECT_FALSE(event.level);
  EXPECT_FALSE(event.lost_before);
  EXPECT_GE(event.at_ns, before_ns);
  EXPECT_LE(event.at_ns, clock.now_ns());
  EXPECT_EQ(inputs.lost(), 0U);
}

TEST_F(GpioInputsTest, AnInvertedLineTellsTheLevelThatItHasHere) {
  const std::array<InputLine, 1> lines = {InputLine{.line = 3U, .is_inverted = true}};
  ASSERT_FALSE(inputs.open(chip, lines));
  simulated.pull(3, true);
  EXPECT_FALSE(next_event().level);
  simulated.pull(3, false);
  EXPECT_TRUE(next_event().level);
}

TEST_F(GpioInputsTest, WithoutEdgesAReadReturnsWithNone) {
  const std::array<InputLine, 1> lines = {InputLine{.line = 0U}};
  std::array<LineEvent, 2> events{};
  EXPECT_EQ(inputs.read(events), 0U) << "not open";
  EXPECT_EQ(inputs.levels(), std::nullopt);
  ASSERT_FALSE(inputs.open(chip, lines));
  EXPECT_EQ(inputs.read(events), 0U);
  EXPECT_EQ(inputs.read({}), 0U);
  EXPECT_EQ(inputs.state(), ChipState::there);
}

TEST_F(GpioInputsTest, AnUnpluggedChipIsToldByLevelsAndStaysGone) {
  const std::array<InputLine, 1> lines = {InputLine{.line = 0U}};
  ASSERT_FALSE(inputs.open(chip, lines));
  simulated.unplug();
  const SimulatedChip again("io", 6);
  again.pull(0, true);
  EXPECT_EQ(inputs.levels(), std::nullopt);
  EXPECT_EQ(inputs.state(), ChipState::gone);
  std::array<LineEvent, 2> events{};
  EXPECT_EQ(inputs.read(events), 0U);
  GpioChip chip_again;
  ASSERT_FALSE(chip_again.open("io"));
  ASSERT_FALSE(inputs.open(chip_again, lines));
  EXPECT_EQ(inputs.levels(), 1U);
  EXPECT_EQ(inputs.state(), ChipState::there);
}

TEST_F(GpioInputsTest, AnUnpluggedChipIsToldByARead) {
  const std::array<InputLine, 1> lines = {InputLine{.line = 0U}};
  ASSERT_FALSE(inputs.open(chip, lines));
  simulated.unplug();
  std::array<LineEvent, 2> events{};
  EXPECT_EQ(inputs.read(events), 0U);
  EXPECT_EQ(inputs.state(), ChipState::gone);
  EXPECT_EQ(inputs.levels(), std::nullopt);
}

TEST_F(GpioInputsTest, LevelsAndReadAreASystemCallEach) {
  const std::array<InputLine, 2> lines = {InputLine{.line = 0U}, InputLine{.line = 1U}};
  const auto prepare = [&] {
    if (inputs.open(chip, lines)) ::_exit(1);
    simulated.pull(0, true);
  };
  const auto loop = [&] {
    std::array<LineEvent, 4> events{};
    for (int tick = 0; tick < 20; ++tick) {
      if (inputs.levels() != 1U) ::_exit(2);
      if (inputs.read(events) > 1) ::_exit(3);
    }
  };
  EXPECT_EQ(only_loop_calls(prepare, loop, {SYS_ioctl, SYS_read}), "");
}

TEST_F(GpioInputsOnVirtualTime, EdgesComeInTheirOrderAndAsManyAsFit) {
  const std::array<InputLine, 2> lines = {InputLine{.line = 0U}, InputLine{.line = 3U}};
  ASSERT_FALSE(inputs.open(chip, lines));
  const std::array<LineEvent, 5> given = {
      LineEvent{.line = 1, .level = true}, LineEvent{.line = 0, .level = true},
      LineEvent{.line = 1, .level = false}, LineEvent{.line = 1, .level = true},
      LineEvent{.line = 0, .level = false}};
  for (const LineEvent& edge : given) {
    simulated.pull(edge.line == 0 ? 0 : 3, edge.level);
    SimulatedChip::settle();
  }
  std::vector<LineEvent> seen;
  std::array<LineEvent, 2> some{};
  for (const std::size_t expected : {2U, 2U, 1U, 0U}) {
    const std::size_t count = inputs.read(some);
    EXPECT_EQ(count, expected);
    seen.insert(seen.end(), some.begin(), some.begin() + count);
  }
  ASSERT_EQ(seen.size(), given.size());
  for (std::size_t i = 0; i < given.size(); ++i) {
    EXPECT_EQ(seen[i].line, given[i].line) << i;
    EXPECT_EQ(seen[i].level, given[i].level) << i;
    EXPECT_FALSE(seen[i].lost_before) << i;
    EXPECT_GT(seen[i].at_ns, i > 0 ? seen[i - 1].at_ns : 0) << i;
  }
}

TEST_F(GpioInputsOnVirtualTime, MoreEdgesThanTheKernelKeepsAreMissedAndCounted) {
  constexpr unsigned kept = 1024;
  constexpr unsigned edges = kept + 5;
  const std::array<InputLine, 2> lines = {InputLine{.line = 0U}, InputLine{.line = 3U}};
  ASSERT_FALSE(inputs.open(chip, lines));
  for (unsigned i = 0; i < edges; ++i) {
    simulated.pull(3, i % 2 == 0);
    SimulatedChip::settle();
  }
  const std::vector<LineEvent> seen = all_events();
  ASSERT_EQ(seen.size(), kept);
  EXPECT_EQ(inputs.lost(), edges - kept);
  EXPECT_TRUE(seen.front().lost_before);
  EXPECT_FALSE(seen.front().level) << "the oldest are lost: this is the edge with number 5, from 0";
  for (std::size_t i = 1; i < seen.size(); ++i) EXPECT_FALSE(seen[i].lost_before) << i;
  EXPECT_EQ(inputs.levels(), 0b10U);

  simulated.pull(0, true);
  SimulatedChip::settle();
  const LineEvent after = next_event();
  EXPECT_EQ(after.line, 0);
  EXPECT_FALSE(after.lost_before);
  EXPECT_EQ(inputs.lost(), edges - kept);
}

// The edges of one line push those of another out: its next one tells, though the other line's told before.
TEST_F(GpioInputsOnVirtualTime, ALineWhoseEdgesWereLostSaysSoItself) {
  const std::array<InputLine, 2> lines = {InputLine{.line = 0U}, InputLine{.line = 3U}};
  ASSERT_FALSE(inputs.open(chip, lines));
  simulated.pull(0, true);
  SimulatedChip::settle();
  for (unsigned i = 0; i < 1024; ++i) {
    simulated.pull(3, i % 2 == 0);
    SimulatedChip::settle();
  }
  const std::vector<LineEvent> seen = all_events();
  ASSERT_EQ(seen.size(), 1024U);
  EXPECT_TRUE(seen.front().lost_before);
  simulated.pull(0, false);
  SimulatedChip::settle();
  EXPECT_TRUE(next_event().lost_before);
  EXPECT_EQ(inputs.lost(), 1U);
}

}  // namespace gpio_inputs_test
}  // namespace inbetween::gpio
