// CiA 402 in interpolated position (mode 7). The contract of every protocol runs on it as well
// (bus_kind_test.cpp).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "host_tools/text/diagnostics.hpp"
#include "inbetween/can/little_endian.hpp"
#include "tests/support/bus_axis.hpp"

namespace inbetween {
namespace can_interpolated_test {

using can::DriveFinding;
using can::Frame;
using Axis = BusAxis<InterpolatedKind>;
using Trouble = DriveTrouble::Kind;

struct Command {
  std::uint16_t controlword;
  std::int32_t target;
};
/// What the drive was told in its process data while `act` went on.
template <class Act>
std::vector<Command> told(Axis& axis, Act act) {
  std::vector<Command> commands;
  const can::FrameId id = can::rpdo1_id(*can::NodeId::make(3));
  axis.wire.set_fate([&](const Frame& frame, std::int64_t) -> FrameFate {
    if (frame.id == id && frame.length == 6) {
      commands.push_back({can::load<std::uint16_t>(frame.data, 0),
                          static_cast<std::int32_t>(can::load<std::uint32_t>(frame.data, 2))});
    }
    return {};
  });
  act();
  axis.wire.set_fate({});
  return commands;
}
void add_fixed_object(Axis& axis, std::uint16_t index, std::int32_t value) {
  axis.drive->add_trouble(
      {.kind = Trouble::fixed_object, .at_ns = 0, .value = value, .object = {.index = index}});
  axis.ticks(1);
}

TEST(InterpolatedPosition, BeginsByBit4OnceTheDriveIsInOperationAndFromWhereItStands) {
  Axis axis;
  bool is_on = false;
  const std::vector<Command> commands = told(axis, [&] { is_on = axis.switch_on(); });
  ASSERT_TRUE(is_on);
  int operations = 0;
  for (const Command& command : commands) {
    if (command.controlword == can::control_enable_operation) ++operations;
    if ((command.controlword & can::control_interpolate) == 0) continue;
    EXPECT_EQ(command.controlword, 0x001F);
    EXPECT_EQ(command.target, 20'000);
    EXPECT_GT(operations, 1) << "the drive was in operation before";
  }
  EXPECT_EQ(commands.back().controlword, 0x001F);
}

TEST(InterpolatedPosition, IsAPeriodBehindCyclicPosition) {
  BusAxis<Cia402Kind> cyclic;
  Axis interpolated;
  ASSERT_TRUE(cyclic.switch_on() && interpolated.switch_on());
  for (int tick = 0; tick <= 125; ++tick) {
    cyclic.tick(cyclic.swing(tick * 0.004));
    interpolated.tick(interpolated.swing(tick * 0.004));
  }
  const double velocity = cyclic.drive->velocity();
  EXPECT_NEAR((cyclic.drive->position() - interpolated.drive->position()) / velocity, 0.004, 0.0004);
}

TEST(InterpolatedPosition, ADriveThatDoesNotOfferItIsRefused) {
  Axis axis;
  add_fixed_object(axis, 0x6502, 0x80);
  EXPECT_FALSE(axis.switch_on());
  EXPECT_EQ(axis.host().first_finding(), DriveFinding::mode_not_offered);
  EXPECT_EQ(axis.host().refusal().expected, 0x40U);
}

TEST(InterpolatedPosition, ADriveThatStaysInAnotherModeIsNotSwitchedOn) {
  Axis axis(DriveInRig<InterpolatedKind>::text() + ", enable_timeout_s = 1");
  axis.drive->add_trouble({.kind = Trouble::wrong_mode, .at_ns = 0, .value = 8});
  EXPECT_FALSE(axis.switch_on());
  EXPECT_EQ(axis.host().first_finding(), DriveFinding::mode_not_shown);
  EXPECT_FALSE(axis.has_power());
}

// docs/faults.md 26
TEST(InterpolatedPosition, ADriveThatCeasesToInterpolateIsFound) {
  Axis axis;
  ASSERT_TRUE(axis.switch_on());
  for (int tick = 0; tick <= 125; ++tick) axis.tick(axis.swing(tick * 0.004));
  axis.drive->add_trouble({.kind = Trouble::ignore_target, .at_ns = axis.now_ns});
  for (int tick = 126; tick <= 140; ++tick) axis.tick(axis.swing(tick * 0.004));
  EXPECT_EQ(axis.host().first_finding(), DriveFinding::target_ignored);
  EXPECT_EQ(axis.worst, DriveCondition::cannot_follow);
}

/// What a host finds in a drive that holds its place and shows bit 13 at every tick.
template <class Kind>
std::optional<DriveFinding> found_with_bit_13() {
  BusAxis<Kind> axis;
  EXPECT_TRUE(axis.switch_on());
  std::optional<Frame> own;
  const auto shows_it = [](const Frame& frame) { return (frame.data[1] & 0x20U) != 0; };
  axis.wire.set_fate([&](const Frame& frame, std::int64_t) -> FrameFate {
    if (frame.id != can::tpdo1_id(*can::NodeId::make(3)) || shows_it(frame)) return {};
    own = frame;
    return {.copies = 0};
  });
  const Setpoint held{.position = axis.stands_at};
  for (int i = 0; i < 50; ++i) {
    if (own) {
      Frame changed = *own;
      changed.data[1] |= 0x20U;
      axis.wire.inject(changed);
    }
    axis.tick(held);
  }
  return axis.host().first_finding();
}

/// CiA 402-2: in cyclic position the bit is a following error, in interpolated position it is reserved.
TEST(InterpolatedPosition, Bit13OfTheStatuswordSaysNothing) {
  EXPECT_EQ(found_with_bit_13<Cia402Kind>(), DriveFinding::following_error);
  EXPECT_EQ(found_with_bit_13<InterpolatedKind>(), std::nullopt);
}

TEST(InterpolatedPosition, EndsWithAQuickStopOrTheWayOff) {
  Axis axis;
  ASSERT_TRUE(axis.switch_on());
  const std::vector<Command> commands = told(axis, [&] {
    axis.port->quick_stop();
    axis.ticks(250);
    axis.port->disable();
    axis.ticks(250);
  });
  ASSERT_GT(commands.size(), 10U);
  for (std::size_t i = 1; i < commands.size(); ++i) {
    EXPECT_EQ(commands[i].controlword & can::control_interpolate, 0) << i;
  }
}

TEST(InterpolatedPosition, TheDoctorSaysInWhichModeADriveIsMoved) {
  Axis axis;
  ASSERT_TRUE(axis.switch_on());
  EXPECT_THAT(Cia402Kind::fitness_of(axis.host(), 250), testing::StartsWith("node 3 has mode 7, the period"));
}

}  // namespace can_interpolated_test
}  // namespace inbetween
