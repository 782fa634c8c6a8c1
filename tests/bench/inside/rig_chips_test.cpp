// The lines of a rig, looked for on chips of the kernel before any of them is taken.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "host_tools/rig/machine_hardware.hpp"
#include "tests/bench/inside/simulated_chip.hpp"

namespace inbetween {
namespace rig_chips_test {

using testing::AllOf;
using testing::HasSubstr;

// Every use that a line may have, and each line where its number says.
const std::string text = R"(name = "bench"
rate_hz = 250
[emergency_stop]
chip = "io"
line = 0
stops_at = "high"
bias = "pull-up"
[start_trigger]
chip = "io"
line = 1
[camera]
chip = "io"
line = 2
asks = { chip = "io", line = 3 }
[output.lamp]
chip = "io"
line = 4
[output.mark]
line = "MARK"
[[axis]]
name = "pan"
unit = "deg"
min = -90
max = 90
max_velocity = 60
max_acceleration = 120
drive = { type = "step-dir", chip = "io", step = 6, dir = "DIR", enable = 8, steps_per_unit = 80 }
home = { chip = "io", line = 9, direction = "positive", fast = 20, slow = 2, back_off = 5 }
limit_min = { chip = "io", line = 10 }
limit_max = { chip = "io", line = 11, active = "low", bias = "pull-up" }
)";
constexpr unsigned all_lines = 12;
const SimulatedChip::Line mark{.offset = 5, .name = "MARK", .user = ""};
const SimulatedChip::Line dir{.offset = 7, .name = "DIR", .user = ""};

/// What is refused of a rig; "" if nothing is.
std::string refused(const std::string& rig_text) {
  const RigFile rig = parse_rig(rig_text, "rig.toml");
  try {
    refuse_unavailable_lines(rig);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

std::string text_with(const std::string& old, const std::string& now) {
  std::string with = text;
  with.replace(with.find(old), old.size(), now);
  return with;
}

/// Nobody has the lines, and whoever wants them gets them all.
void expect_free(const std::string& label, const std::vector<unsigned>& busy = {}) {
  gpio::GpioChip chip;
  ASSERT_FALSE(chip.open(label));
  std::vector<gpio::LineUse> uses;
  for (unsigned line = 0; line < all_lines; ++line) {
    if (std::ranges::find(busy, line) == busy.end()) uses.push_back({.offset = line});
  }
  gpio::HeldLines held;
  EXPECT_FALSE(chip.take(uses, held));
}

TEST(RigChips, LinesThatAreThereAndFreeAreRefusedByNobodyAndStayFree) {
  const SimulatedChip io("io", all_lines, {mark, dir});
  EXPECT_EQ(refused(text), "");
  EXPECT_EQ(io.levels(), 0U) << "resistors of the chip would show";
  expect_free("io");
}

TEST(RigChips, EachLineOfTheRigIsRefusedAtItsPlaceWhileSomebodyElseHasIt) {
  struct Use {
    unsigned line;
    int place;  // in the text
    std::string name = {};
  };
  const Use uses[] = {{0, 5},  {1, 10},        {2, 13}, {3, 14}, {4, 17},  {5, 19, "MARK"},
                      {6, 20}, {7, 20, "DIR"}, {8, 20}, {9, 28}, {10, 29}, {11, 30}};
  static_assert(std::size(uses) == all_lines);
  for (const Use& use : uses) {
    std::vector<SimulatedChip::Line> lines{{.offset = use.line, .name = use.name, .user = "fan"}};
    for (const SimulatedChip::Line& named : {mark, dir}) {
      if (named.offset != use.line) lines.push_back(named);
    }
    const SimulatedChip io("io", all_lines, lines);
    const std::string name = use.name.empty() ? "" : " (" + use.name + ")";
    EXPECT_THAT(refused(text),
                AllOf(HasSubstr(fmt::format("rig.toml:{}:", use.place)),
                      HasSubstr(fmt::format("line {}{} of chip io is in use by fan", use.line, name))));
    EXPECT_EQ(io.levels(), 0U) << use.line;
    expect_free("io", {use.line});
  }
}

TEST(RigChips, ALineThatIsBusyOnAnotherChipIsFoundAsWell) {
  const SimulatedChip io("io", all_lines, {mark, dir});
  const SimulatedChip other("other", 2, {{.offset = 1, .name = "", .user = "fan"}});
  EXPECT_THAT(refused(text_with("\"io\"\nline = 4", "\"other\"\nline = 1")),
              AllOf(HasSubstr("rig.toml:17:"), HasSubstr("line 1 of chip other is in use by fan")));
  expect_free("io");
}

TEST(RigChips, WhatIsNotThereIsRefusedAtItsPlace) {
  const SimulatedChip io("io", all_lines, {mark, dir});
  EXPECT_THAT(refused(text_with("\"MARK\"", "\"LAMP\"")),
              HasSubstr("rig.toml:19:8: error: there is no GPIO line named LAMP"));
  EXPECT_THAT(refused(text_with("\"io\"\nline = 4", "\"oi\"\nline = 4")),
              HasSubstr("rig.toml:17:8: error: there is no GPIO chip labelled oi"));
  EXPECT_THAT(refused(text_with("line = 4", "line = 12")),
              AllOf(HasSubstr("rig.toml:17:"), HasSubstr("chip io has no line 12")));
}

TEST(RigChips, ANameThatLinesOfTwoChipsHaveIsRefused) {
  const SimulatedChip io("io", all_lines, {mark, dir});
  const SimulatedChip other("other", all_lines, {mark});
  EXPECT_THAT(refused(text), AllOf(HasSubstr("rig.toml:19:"), HasSubstr("MARK")));
}

// The rig file itself finds two equal offsets, and two equal names.
TEST(RigChips, ALineThatIsMeantByItsOffsetAndByItsNameIsRefused) {
  {
    const SimulatedChip io("io", all_lines, {{.offset = 1, .name = "MARK", .user = ""}, dir});
    EXPECT_THAT(refused(text), HasSubstr("rig.toml:19:8: error: line 1 of chip \"io\" is used in line 10 "
                                         "already; give each line one use"));
  }
  const SimulatedChip io("io", all_lines, {mark, {.offset = 6, .name = "DIR", .user = ""}});
  EXPECT_THAT(refused(text), HasSubstr("rig.toml:20:1: error: line 6 of chip \"io\" is used in line 20 "
                                       "already; give each line one use"));
}

TEST(RigChips, TheSameOffsetOfTwoChipsIsTwoLines) {
  const SimulatedChip io("io", all_lines, {mark, dir});
  const SimulatedChip other("other", all_lines);
  EXPECT_EQ(refused(text_with("\"io\"\nline = 4", "\"other\"\nline = 0")), "");
}

}  // namespace rig_chips_test
}  // namespace inbetween
