// What an RMD motor does in its own way: it answers only, its first position gives it power, and a restart is
// not told.
#include "inbetween/can/rmd.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <utility>

#include "host_tools/text/diagnostics.hpp"
#include "inbetween/can/little_endian.hpp"
#include "tests/support/bus_axis.hpp"

namespace inbetween {
namespace rmd_test {

using can::DriveFinding;
using can::Frame;
using can::Rmd;
using can::RmdCommand;
using can::RmdMotor;
using can::ServoHold;
using Trouble = DriveTrouble::Kind;

const RmdMotor motor = *RmdMotor::make(3);

Frame acceleration_by_a_tool(std::uint32_t deg_per_s2) {
  Frame frame = can::rmd_acceleration_question(motor);
  frame.data[0] = 0x43;
  can::store(frame.data, 4, deg_per_s2);
  return frame;
}
bool is_command(const Frame& frame, RmdCommand command) {
  return frame.id == can::rmd_command_id(motor) && frame.data[0] == static_cast<std::uint8_t>(command);
}

TEST(RmdMotor, IsANumberThatAMotorCanHave) {
  EXPECT_TRUE(RmdMotor::make(1));
  EXPECT_TRUE(RmdMotor::make(32));
  EXPECT_FALSE(RmdMotor::make(0));
  EXPECT_FALSE(RmdMotor::make(33));
}

// docs/faults.md 29
TEST(RmdPosition, NeverGoesOutWithoutAVelocityLimit) {
  EXPECT_FALSE(Rmd::make({.motor = motor, .max_deg_per_s = 0, .hold_deg_per_s = 0}));
  EXPECT_FALSE(Rmd::make({.motor = motor, .max_deg_per_s = 100, .hold_deg_per_s = 0}));
  EXPECT_FALSE(Rmd::make({.motor = motor, .max_deg_per_s = 100, .hold_deg_per_s = 101}));
  const Rmd rmd = *Rmd::make({.motor = motor, .max_deg_per_s = 100, .hold_deg_per_s = 5});
  const auto position = [](const std::optional<Frame>& frame) {
    return *can::read_rmd_position(*frame, motor);
  };
  EXPECT_EQ(position(rmd.command({.turns = 2})), (can::RmdPosition{72'000, 100}));
  EXPECT_EQ(position(rmd.hold(ServoHold::switching_on, -1)), (can::RmdPosition{-36'000, 5}));
  EXPECT_FALSE(rmd.hold(ServoHold::off, 1)) << "it would be switched on";
  EXPECT_TRUE(is_command(*rmd.hold(ServoHold::stopping, 1), RmdCommand::stop));
}

TEST(RmdPosition, ATargetBeyondItsBitsIsNotSent) {
  const Rmd rmd = *Rmd::make({.motor = motor, .max_deg_per_s = 100, .hold_deg_per_s = 5});
  EXPECT_TRUE(rmd.command({.turns = can::rmd_max_turns}));
  EXPECT_FALSE(rmd.command({.turns = can::rmd_max_turns + 1}));
  EXPECT_FALSE(rmd.command({.turns = std::nan("")}));
  EXPECT_FALSE(can::ServoDrive<Rmd>::target_of(-60'000.0, 0.0, 0.0));
}

TEST(RmdPosition, IsTheNearestHundredthOfADegree) {
  const Rmd rmd = *Rmd::make({.motor = motor, .max_deg_per_s = 100, .hold_deg_per_s = 5});
  for (const auto& [steps, nearest] : {std::pair{0.6, 1}, {0.4, 0}, {-0.6, -1}, {-0.4, 0}, {7.7, 8}}) {
    const auto frame = rmd.command({.turns = steps / can::rmd_steps_per_turn});
    ASSERT_TRUE(frame);
    EXPECT_EQ(can::read_rmd_position(*frame, motor)->steps, nearest) << steps;
  }
}

// Whatever arrives: what has been understood means the same when it is written again.
TEST(RmdReport, AnyFramesAreUnderstoodOrRefused) {
  constexpr std::uint32_t seed = 20'260'311;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  Rmd rmd = *Rmd::make({.motor = motor, .max_deg_per_s = 100, .hold_deg_per_s = 5});
  int places = 0;
  for (int i = 0; i < 200'000; ++i) {
    constexpr std::uint32_t ids[] = {0x143, 0x243, 0x243, 0x243, 0x244, 0x280, 0x403};
    constexpr std::uint8_t commands[] = {0x42, 0x80, 0x81, 0x92, 0x9A, 0xA4, 0xB3, 0x00};
    const std::uint32_t number = ids[random() % 7];
    const bool is_extended = random() % 16 == 0;
    Frame frame{.id = is_extended ? can::FrameId::extended(number) : can::FrameId::standard(number)};
    frame.is_remote = random() % 16 == 0;
    frame.length = static_cast<std::uint8_t>(random() % 4 == 0 ? random() % 9 : 8);
    for (std::uint8_t& byte : frame.data) byte = static_cast<std::uint8_t>(random());
    frame.data[0] = commands[random() % 8];
    if (!rmd.is_concerned(frame)) continue;
    const can::ServoReport report = rmd.read(frame);
    ASSERT_EQ(report.is_of_a_host, frame.id != 0x243);
    const bool is_whole = !frame.is_remote && frame.length == 8;
    ASSERT_EQ(report.is_bad, frame.id == 0x243 && !is_whole);
    if (report.place) {
      ++places;
      Frame again = can::rmd_angle_frame(
          motor, static_cast<std::int32_t>(std::lround(report.place->turns * can::rmd_steps_per_turn)));
      again.data[1] = frame.data[1];
      again.data[2] = frame.data[2];
      again.data[3] = frame.data[3];
      ASSERT_EQ(again, frame);
    }
    ASSERT_FALSE(report.status && report.status->is_on == report.status->is_off);
  }
  EXPECT_GT(places, 1000);
}

TEST(RmdError, IsSaidInWords) {
  EXPECT_STREQ(can::words_of_rmd_error(0x2), "its motor has stalled");
  EXPECT_STREQ(can::words_of_rmd_error(0x2000), "its encoder is not calibrated");
  EXPECT_STREQ(can::words_of_rmd_error(0x200), "an error that its maker does not explain");
}

// --- on a bus

TEST(RmdOnABus, OneThatPlansARampOfItsOwnIsRefused) {
  BusAxis<RmdKind> axis;
  axis.ticks(100);
  axis.wire.inject(acceleration_by_a_tool(5000));
  axis.ticks(2);
  EXPECT_FALSE(axis.switch_on());
  EXPECT_EQ(axis.host().first_finding(), DriveFinding::plans_by_itself);
}

// docs/faults.md 29
TEST(RmdOnABus, OneWithoutAWatchdogIsRefusedUnlessTheRigAcceptsThat) {
  const auto add_trouble = [](BusAxis<RmdKind>& axis) {
    axis.drive->add_trouble({.kind = Trouble::no_watchdog, .at_ns = axis.now_ns});
  };
  BusAxis<RmdKind> refused;
  add_trouble(refused);
  EXPECT_FALSE(refused.switch_on());
  EXPECT_EQ(refused.host().first_finding(), DriveFinding::watchdog_unconfirmed);
  EXPECT_TRUE(RmdKind::lacks_of(refused.host()).empty());

  BusAxis<RmdKind> accepted(DriveInRig<RmdKind>::text() + R"(, no_watchdog = "accepted")");
  add_trouble(accepted);
  EXPECT_TRUE(accepted.switch_on());
  EXPECT_THAT(RmdKind::lacks_of(accepted.host()),
              testing::ElementsAre(testing::HasSubstr("if this program dies")));
}

/// Every position that the motor was told while `act` went on, in degrees of the axis.
template <class Act>
std::vector<can::RmdPosition> told(BusAxis<RmdKind>& axis, Act act) {
  std::vector<can::RmdPosition> positions;
  axis.wire.set_fate([&](const Frame& frame, std::int64_t) -> FrameFate {
    if (const auto position = can::read_rmd_position(frame, motor)) positions.push_back(*position);
    return {};
  });
  act();
  axis.wire.set_fate({});
  return positions;
}

TEST(RmdOnABus, IsToldNoPositionBeforeItIsSwitchedOnAndThenTheOneWhereItStandsSlowly) {
  BusAxis<RmdKind> axis;
  bool is_on = false;
  const auto positions = told(axis, [&] { is_on = axis.switch_on(); });
  ASSERT_TRUE(is_on);
  const auto stands = static_cast<std::int32_t>(std::lround(20 * RmdKind::scale_of(axis.axis()) * 36'000));
  ASSERT_FALSE(positions.empty());
  for (const can::RmdPosition& position : positions) {
    EXPECT_EQ(position.steps, stands);
    EXPECT_LE(position.max_deg_per_s, 0.05 * max_rmd_deg_per_s_of(axis.axis()));
  }
  axis.port->disable();
  axis.tick();
  EXPECT_TRUE(told(axis, [&] { axis.ticks(250); }).empty());
}

// The next position would give a motor power that has started anew, and it would run to where it then
// believes that to be.
TEST(RmdOnABus, AfterASilenceItGetsNoPositionAndHasLostItsReference) {
  for (const Trouble kind : {Trouble::reboot, Trouble::lose_sent}) {
    BusAxis<RmdKind> axis;
    ASSERT_TRUE(axis.switch_on());
    axis.from = axis.state.actual;
    for (int tick = 0; tick <= 125; ++tick) axis.tick(axis.swing(tick * 0.004));
    axis.drive->add_trouble({.kind = kind, .at_ns = axis.now_ns, .for_ns = 200'000'000});
    int tick = 125;
    const auto go_on = [&](int ticks) {
      for (int i = 0; i < ticks; ++i) axis.tick(axis.swing(++tick * 0.004));
    };
    go_on(14);
    const auto positions = told(axis, [&] { go_on(120); });
    EXPECT_TRUE(positions.empty());
    EXPECT_TRUE(axis.host().findings().has(DriveFinding::silent_for_a_while));
    EXPECT_TRUE(can::loses_reference(axis.host().findings()));
    EXPECT_FALSE(axis.has_power());
  }
}

TEST(RmdOnABus, OnceSetpointsHaveCeasedNothingGivesItPowerAgain) {
  BusAxis<RmdKind> axis;
  ASSERT_TRUE(axis.switch_on());
  axis.from = axis.state.actual;
  for (int tick = 0; tick <= 125; ++tick) axis.tick(axis.swing(tick * 0.004));
  axis.ticks(100);
  ASSERT_FALSE(axis.has_power());
  const auto positions = told(axis, [&] {
    axis.ticks(100, axis.swing(0.5));
    axis.port->quick_stop();
    axis.ticks(100);
  });
  EXPECT_TRUE(positions.empty());
  EXPECT_FALSE(axis.has_power());
}

}  // namespace rmd_test
}  // namespace inbetween
