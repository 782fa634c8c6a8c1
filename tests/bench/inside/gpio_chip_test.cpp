#include "drivers/gpio/gpio_chip.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/gpio/gpio_outputs.hpp"
#include "tests/bench/inside/simulated_chip.hpp"

namespace inbetween::gpio {
namespace gpio_chip_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string told(const std::optional<Refusal>& refusal) {
  return refusal ? refusal->what : "";
}

std::string refusal_of(const GpioChip& chip, const std::vector<LineChoice>& lines) {
  std::vector<unsigned> offsets;
  return told(chip.find(lines, offsets));
}

TEST(GpioChip, IsFoundByItsLabel) {
  const SimulatedChip one("one", 3);
  const SimulatedChip other("other", 5);
  GpioChip chip;
  EXPECT_EQ(told(chip.open("other")), "");
  EXPECT_EQ(refusal_of(chip, {4U}), "");
  EXPECT_EQ(told(chip.open("one")), "");
  EXPECT_EQ(refusal_of(chip, {4U}), "chip one has no line 4, it has 3 lines from 0");
}

TEST(GpioChip, OneThatIsNotThereIsNamed) {
  const SimulatedChip one("one", 3);
  GpioChip chip;
  ASSERT_FALSE(chip.open("one"));
  const std::optional<Refusal> refusal = chip.open("on");
  ASSERT_TRUE(refusal);
  EXPECT_EQ(refusal->what, "there is no GPIO chip labelled on");
  EXPECT_THAT(refusal->remedy, HasSubstr("gpiodetect"));
  EXPECT_FALSE(chip.is_open());
  EXPECT_EQ(refusal_of(chip, {0U}), "no GPIO chip is open");
}

TEST(GpioChip, TwoOfOneLabelAreNotGuessedBetween) {
  const SimulatedChip one("same", 3);
  const SimulatedChip other("same", 3);
  GpioChip chip;
  EXPECT_EQ(told(chip.open("same")), "2 GPIO chips are labelled same");
  EXPECT_FALSE(chip.is_open());
}

TEST(GpioChip, LinesAreFoundByOffsetAndByName) {
  const SimulatedChip simulated(
      "io", 6, {{.offset = 1, .name = "STEP", .user = ""}, {.offset = 4, .name = "ENABLE", .user = ""}});
  GpioChip chip;
  ASSERT_FALSE(chip.open("io"));
  std::vector<unsigned> offsets;
  EXPECT_EQ(told(chip.find(std::vector<LineChoice>{"ENABLE", 0U, "STEP"}, offsets)), "");
  EXPECT_THAT(offsets, ElementsAre(4, 0, 1));
}

TEST(GpioChip, LinesThatAreNotOneAreRefused) {
  const SimulatedChip simulated("io", 6,
                                {{.offset = 1, .name = "STEP", .user = ""},
                                 {.offset = 2, .name = "TWICE", .user = ""},
                                 {.offset = 5, .name = "TWICE", .user = ""}});
  GpioChip chip;
  ASSERT_FALSE(chip.open("io"));
  EXPECT_EQ(refusal_of(chip, {"DIR"}), "chip io has no line named DIR");
  EXPECT_EQ(refusal_of(chip, {""}), "chip io has no line named ");
  EXPECT_EQ(refusal_of(chip, {0U, "TWICE"}), "chip io has 2 lines named TWICE");
  EXPECT_EQ(refusal_of(chip, {"STEP", 0U, 1U}), "line 1 (STEP) of chip io is asked for twice");
}

TEST(GpioChip, ABusyLineIsRefusedByItsUserBeforeAnyOutputChanges) {
  const SimulatedChip simulated("io", 4, {{.offset = 2, .name = "FAN", .user = "lamp"}});
  simulated.pull(0, true);
  GpioChip chip;
  ASSERT_FALSE(chip.open("io"));
  GpioOutputs outputs;
  const std::array<OutputLine, 3> lines = {OutputLine{.line = 0U}, OutputLine{.line = 1U, .safe_level = true},
                                           OutputLine{.line = 2U}};
  EXPECT_EQ(told(outputs.open(chip, lines)), "line 2 (FAN) of chip io is in use by lamp");
  EXPECT_FALSE(outputs.is_open());
  EXPECT_EQ(simulated.levels(), 0b0001U);
}

// As `find` would have seen it a moment before.
TEST(GpioChip, ALineThatBecameBusyAfterTheLookIsRefusedByItsUserToo) {
  const SimulatedChip simulated("io", 4, {{.offset = 2, .name = "", .user = "lamp"}});
  simulated.pull(0, true);
  GpioChip chip;
  ASSERT_FALSE(chip.open("io"));
  HeldLines held;
  const std::array<LineUse, 2> lines = {LineUse{.offset = 0, .is_output = true},
                                        LineUse{.offset = 2, .is_output = true}};
  EXPECT_EQ(told(chip.take(lines, held)), "line 2 of chip io is in use by lamp");
  EXPECT_EQ(simulated.levels(), 0b0001U);
}

TEST(GpioChip, LinesThatThisProgramHoldsAreBusyUntilItGivesThemBack) {
  const SimulatedChip simulated("io", 4);
  GpioChip chip;
  ASSERT_FALSE(chip.open("io"));
  const std::array<OutputLine, 2> lines = {OutputLine{.line = 1U}, OutputLine{.line = 3U}};
  GpioOutputs first;
  GpioOutputs second;
  ASSERT_FALSE(first.open(chip, lines));
  EXPECT_EQ(told(second.open(chip, lines)), "line 1 of chip io is in use by inbetween");
  first.close();
  EXPECT_EQ(told(second.open(chip, lines)), "");
}

TEST(GpioChip, MoreLinesThanARequestHoldsAreRefused) {
  const SimulatedChip simulated("wide", 70);
  GpioChip chip;
  ASSERT_FALSE(chip.open("wide"));
  std::vector<OutputLine> lines;
  for (unsigned i = 0; i < 65; ++i) lines.push_back({.line = i});
  GpioOutputs outputs;
  EXPECT_EQ(told(outputs.open(chip, lines)),
            "65 lines of chip wide are asked for at once, and the kernel gives 1 to 64");
  EXPECT_EQ(told(outputs.open(chip, {})),
            "0 lines of chip wide are asked for at once, and the kernel gives 1 to 64");
  lines.pop_back();
  EXPECT_EQ(told(outputs.open(chip, lines)), "");
  EXPECT_TRUE(outputs.set(std::uint64_t{1} << 63, std::uint64_t{1} << 63));
  EXPECT_TRUE(simulated.level(63));
}

TEST(GpioChip, OneThatWasUnpluggedTellsSoWhenItsLinesAreAskedFor) {
  SimulatedChip simulated("io", 4);
  GpioChip chip;
  ASSERT_FALSE(chip.open("io"));
  simulated.unplug();
  EXPECT_EQ(refusal_of(chip, {1U}), "line 1 of chip io cannot be asked for: No such device");
}

}  // namespace gpio_chip_test
}  // namespace inbetween::gpio
