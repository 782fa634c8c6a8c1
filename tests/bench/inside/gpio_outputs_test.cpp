#include "drivers/gpio/gpio_outputs.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <optional>

#include "tests/bench/inside/simulated_chip.hpp"

namespace inbetween::gpio {
namespace gpio_outputs_test {

constexpr unsigned io_lines = 5;

struct GpioOutputsTest : ::testing::Test {
  SimulatedChip simulated{"io", io_lines};
  GpioChip chip;
  GpioOutputs outputs;

  void SetUp() override { ASSERT_FALSE(chip.open("io")); }
};

/// A process of its own, which holds what this one held when it began.
class Holder {
 public:
  Holder() : process_(::fork()) {
    while (process_ == 0) ::pause();
  }
  ~Holder() {
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
  }
  Holder(const Holder&) = delete;
  Holder& operator=(const Holder&) = delete;

 private:
  pid_t process_;
};

TEST_F(GpioOutputsTest, BitsAreTheLinesInTheOrderInWhichTheyWereAskedFor) {
  const std::array<OutputLine, 3> lines = {OutputLine{.line = 4U}, OutputLine{.line = 0U},
                                           OutputLine{.line = 2U}};
  ASSERT_FALSE(outputs.open(chip, lines));
  EXPECT_TRUE(outputs.set(0b001, 0b111));
  EXPECT_EQ(simulated.levels(), 0b10000U);
  EXPECT_TRUE(outputs.set(0b110, 0b111));
  EXPECT_EQ(simulated.levels(), 0b00101U);
}

TEST_F(GpioOutputsTest, LinesThatAreNotInTheMaskKeepTheirLevels) {
  const std::array<OutputLine, 3> lines = {OutputLine{.line = 0U}, OutputLine{.line = 1U},
                                           OutputLine{.line = 2U}};
  ASSERT_FALSE(outputs.open(chip, lines));
  EXPECT_TRUE(outputs.set(0b011, 0b011));
  EXPECT_TRUE(outputs.set(0b100, 0b101));
  EXPECT_EQ(simulated.levels(), 0b110U);
  EXPECT_TRUE(outputs.set(0b111, 0));
  EXPECT_EQ(simulated.levels(), 0b110U);
  EXPECT_EQ(outputs.state(), ChipState::there);
}

TEST_F(GpioOutputsTest, LinesAreTakenAtTheirSafeLevels) {
  simulated.pull(0, true);
  simulated.pull(1, true);
  const std::array<OutputLine, 3> lines = {OutputLine{.line = 0U}, OutputLine{.line = 1U, .safe_level = true},
                                           OutputLine{.line = 2U, .safe_level = true}};
  ASSERT_FALSE(outputs.open(chip, lines));
  EXPECT_EQ(simulated.levels(), 0b110U);
}

TEST_F(GpioOutputsTest, ClosedTheyAreLeftAtTheirSafeLevels) {
  const std::array<OutputLine, 2> lines = {OutputLine{.line = 0U},
                                           OutputLine{.line = 1U, .safe_level = true}};
  ASSERT_FALSE(outputs.open(chip, lines));
  EXPECT_TRUE(outputs.set(0b01, 0b11));
  // Given back, a simulated line would fall to what pulls it. Somebody else holds them for us.
  const Holder holder;
  EXPECT_EQ(simulated.levels(), 0b01U);
  outputs.close();
  EXPECT_EQ(simulated.levels(), 0b10U);
}

TEST_F(GpioOutputsTest, AnInvertedLineIsLowWhereItIsTrue) {
  const std::array<OutputLine, 2> lines = {OutputLine{.line = 0U, .safe_level = true, .is_inverted = true},
                                           OutputLine{.line = 1U, .is_inverted = true}};
  ASSERT_FALSE(outputs.open(chip, lines));
  EXPECT_EQ(simulated.levels(), 0b10U);
  EXPECT_TRUE(outputs.set(0b10, 0b11));
  EXPECT_EQ(simulated.levels(), 0b01U);
}

TEST_F(GpioOutputsTest, AnUnpluggedChipIsToldAndStaysGone) {
  const std::array<OutputLine, 1> lines = {OutputLine{.line = 0U}};
  ASSERT_FALSE(outputs.open(chip, lines));
  simulated.unplug();
  EXPECT_FALSE(outputs.set(1, 1));
  EXPECT_EQ(outputs.state(), ChipState::gone);
  EXPECT_FALSE(outputs.set_safe());

  const SimulatedChip again("io", io_lines);
  EXPECT_FALSE(outputs.set(1, 1));
  EXPECT_EQ(outputs.state(), ChipState::gone);
  EXPECT_EQ(again.levels(), 0U);

  GpioChip chip_again;
  ASSERT_FALSE(chip_again.open("io"));
  ASSERT_FALSE(outputs.open(chip_again, lines));
  EXPECT_TRUE(outputs.set(1, 1));
  EXPECT_EQ(outputs.state(), ChipState::there);
  EXPECT_EQ(again.levels(), 1U);
}

TEST_F(GpioOutputsTest, ABitThatIsNoLineEndsThemAndOnlyTheSafeLevelsAreSetAfterwards) {
  const std::array<OutputLine, 2> lines = {OutputLine{.line = 0U}, OutputLine{.line = 1U}};
  ASSERT_FALSE(outputs.open(chip, lines));
  EXPECT_TRUE(outputs.set(0b01, 0b01));
  EXPECT_FALSE(outputs.set(0b110, 0b110));
  EXPECT_EQ(outputs.state(), ChipState::failed);
  EXPECT_EQ(outputs.error(), EINVAL);
  EXPECT_FALSE(outputs.set(0b10, 0b10));
  EXPECT_EQ(simulated.levels(), 0b01U);
  EXPECT_TRUE(outputs.set_safe());
  EXPECT_EQ(simulated.levels(), 0b00U);
  EXPECT_EQ(outputs.state(), ChipState::failed);
}

// What GpioOutputs says about kill -9: this kernel's simulated chip leaves the line to the resistor.
TEST_F(GpioOutputsTest, KilledWhileEnableIsOnItIsTheResistorThatDecides) {
  for (const bool pulls_up : {false, true}) {
    simulated.pull(3, pulls_up);
    std::array<int, 2> pipe{};
    ASSERT_EQ(::pipe(pipe.data()), 0);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      const std::array<OutputLine, 1> enable = {OutputLine{.line = 3U}};
      const bool is_on = !outputs.open(chip, enable) && outputs.set(1, 1);
      if (!is_on || ::write(pipe[1], "1", 1) != 1) ::_exit(1);
      for (;;) ::pause();
    }
    ::close(pipe[1]);
    char enabled = 0;
    ASSERT_EQ(::read(pipe[0], &enabled, 1), 1);
    ::close(pipe[0]);
    EXPECT_TRUE(simulated.level(3));
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    EXPECT_EQ(simulated.level(3), pulls_up);
    // And the line is free again.
    const std::array<OutputLine, 1> enable = {OutputLine{.line = 3U}};
    EXPECT_FALSE(outputs.open(chip, enable));
    EXPECT_FALSE(simulated.level(3));
    outputs.close();
  }
}

}  // namespace gpio_outputs_test
}  // namespace inbetween::gpio
