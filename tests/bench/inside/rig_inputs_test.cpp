// The input lines of a rig on chips of the kernel.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/syscall.h>

#include <memory>
#include <string>

#include "drivers/linux/monotonic_clock.hpp"
#include "host_tools/rig/gpio_inputs.hpp"
#include "host_tools/rig/machine_hardware.hpp"
#include "tests/bench/inside/allowed_calls.hpp"
#include "tests/bench/inside/simulated_chip.hpp"

namespace inbetween {
namespace rig_inputs_test {

using testing::HasSubstr;

// On two chips, one of the lines by its name alone.
const std::string text = R"(name = "bench"
rate_hz = 250
[emergency_stop]
chip = "io"
line = 3
stops_at = "high"
bias = "none"
[start_trigger]
line = "START"
[[axis]]
name = "pan"
unit = "deg"
min = -90
max = 90
max_velocity = 60
max_acceleration = 120
drive = { type = "step-dir", chip = "steps", step = 0, dir = 1, steps_per_unit = 80 }
home = { chip = "other", line = 0, direction = "positive", fast = 20, slow = 2, back_off = 5, bias = "none" }
limit_min = { chip = "io", line = 0, bias = "none" }
limit_max = { chip = "other", line = 2, active = "low", bias = "pull-up" }
)";

struct RigInputsOnChips : ::testing::Test {
  SimulatedChip io{"io", 4};
  SimulatedChip other{"other", 4, {{.offset = 1, .name = "START", .user = ""}}};
  RigFile rig = parse_rig(text, "rig.toml");
  MonotonicClock clock;
  MachineHardware hardware{rig};
  std::unique_ptr<RigInputs> lines;

  void open() {
    lines = std::make_unique<RigInputs>(rig, hardware);
    lines->read(clock.now_ns());
  }
  /// Ticks until the switches are known to be as they are: what changes before is how they stood at the
  /// start.
  void settle() {
    constexpr std::int64_t longer_than_it_takes_ns = 20'000'000;
    const std::int64_t begin_ns = clock.now_ns();
    read_until([&] { return clock.now_ns() - begin_ns > longer_than_it_takes_ns; });
  }
  /// Ticks until it is so; the time limit of the bench is the bound.
  template <class Condition>
  void read_until(Condition is_so) {
    while (!is_so()) {
      ::sched_yield();
      lines->read(clock.now_ns());
    }
  }
};

TEST_F(RigInputsOnChips, NothingIsPressedWhereNothingIs) {
  open();
  EXPECT_FALSE(lines->emergency_stop());
  EXPECT_FALSE(lines->is_gone());
  EXPECT_FALSE(lines->homing_input(0).limit_hit);
  EXPECT_EQ(lines->trouble(), "");
}

TEST_F(RigInputsOnChips, TheLevelOfTheEmergencyStopIsHeardByTheNextTick) {
  open();
  io.pull(3, true);
  lines->read(clock.now_ns());
  EXPECT_TRUE(lines->emergency_stop());
  EXPECT_THAT(lines->trouble(), HasSubstr("line 3 of chip \"io\""));
  io.pull(3, false);
  read_until([&] { return !lines->emergency_stop(); });
}

TEST_F(RigInputsOnChips, APulseOfTheEmergencyStopBetweenTwoTicksIsHeard) {
  open();
  io.pull(3, true);
  io.pull(3, false);
  read_until([&] { return lines->emergency_stop(); });
}

TEST_F(RigInputsOnChips, AWireThatBreaksIsAnEmergencyStop) {
  // The closed circuit holds the line low against the resistor of the chip.
  std::string with_pull = text;
  with_pull.replace(with_pull.find("\"none\""), 6, "\"pull-up\"");
  rig = parse_rig(with_pull, "rig.toml");
  open();
  EXPECT_TRUE(lines->emergency_stop()) << "nothing is connected";
  io.pull(3, false);
  read_until([&] { return !lines->emergency_stop(); });
}

TEST_F(RigInputsOnChips, SwitchesOfBothChipsTellWhereTheyAre) {
  open();
  settle();
  io.pull(0, true);
  read_until([&] { return lines->limit_hit(); });
  EXPECT_TRUE(lines->homing_input(0).limit_hit);
  EXPECT_FALSE(lines->homing_input(0).level);
  io.pull(0, false);
  read_until([&] { return !lines->homing_input(0).limit_hit; });
  other.pull(2, false);
  read_until([&] { return lines->limit_hit(); });
  other.pull(0, true);
  std::size_t home_edges = 0;
  read_until([&] {
    for (const LineEvent& event : lines->events())
      home_edges += event.line == lines->home_switch(0).line ? 1U : 0U;
    return home_edges > 0;
  });
  EXPECT_TRUE(lines->homing_input(0).level);
}

TEST_F(RigInputsOnChips, ALineIsFoundByItsNameAlone) {
  open();
  settle();
  other.pull(1, true);
  read_until([&] { return lines->start_triggered(); });
}

TEST_F(RigInputsOnChips, AChipThatIsUnpluggedIsAnEmergencyStop) {
  open();
  other.unplug();
  lines->read(clock.now_ns());
  EXPECT_TRUE(lines->is_gone());
  EXPECT_TRUE(lines->emergency_stop());
  EXPECT_EQ(lines->trouble(), "chip \"other\" of the rig has gone; plug it in again");
}

TEST_F(RigInputsOnChips, ABusyLineIsRefusedAtItsPlaceWithItsUserAndNoLineIsTaken) {
  {
    const SimulatedChip steps("more", 2, {{.offset = 1, .name = "", .user = "lamp"}});
    std::string busy = text;
    busy.replace(busy.find("chip = \"other\", line = 2"), 24, "chip = \"more\", line = 1 ");
    rig = parse_rig(busy, "rig.toml");
    try {
      open();
      ADD_FAILURE() << "it was taken";
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("rig.toml:20:"));
      EXPECT_THAT(error.what(), HasSubstr("line 1 of chip more is in use by lamp"));
    }
  }
  rig = parse_rig(text, "rig.toml");
  EXPECT_NO_THROW(open()) << "the others are free";
}

TEST_F(RigInputsOnChips, WhatIsNotThereIsSaidAtItsPlace) {
  const auto refusal = [&](const std::string& old, const std::string& now) {
    std::string wrong = text;
    wrong.replace(wrong.find(old), old.size(), now);
    rig = parse_rig(wrong, "rig.toml");
    try {
      open();
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("it was taken");
  };
  EXPECT_THAT(refusal("\"io\"", "\"oi\""),
              HasSubstr("rig.toml:5:8: error: there is no GPIO chip labelled oi"));
  EXPECT_THAT(refusal("START", "BEGIN"), HasSubstr("rig.toml:9:8: error: there is no GPIO line named BEGIN"));
  EXPECT_THAT(refusal("line = 3", "line = 7"), HasSubstr("chip io has no line 7"));
}

TEST_F(RigInputsOnChips, AReadMakesNoOtherSystemCallsThanThoseOfALoop) {
  const auto loop = [&] {
    for (int i = 0; i < 10; ++i) lines->read(clock.now_ns());
  };
  EXPECT_EQ(only_loop_calls([&] { open(); }, loop, {SYS_ioctl, SYS_read}), "");
}

}  // namespace rig_inputs_test
}  // namespace inbetween
