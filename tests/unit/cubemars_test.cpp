// What a CubeMars motor does in its own way: its feedback goes round, it answers nothing, and it has no
// watchdog.
#include "inbetween/can/cubemars.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "host_tools/text/diagnostics.hpp"
#include "tests/support/bus_axis.hpp"
#include "tests/support/rig_text.hpp"

namespace inbetween {
namespace cubemars_test {

using can::Cubemars;
using can::CubemarsMotor;
using can::CubemarsPosition;
using can::DriveFinding;
using can::Frame;
using can::ServoHold;
using can::ServoOrder;
using Trouble = DriveTrouble::Kind;

const CubemarsMotor motor = *CubemarsMotor::make(3);

Cubemars some_motor() {
  return *Cubemars::make({.motor = motor,
                          .scale = {.electric_turns_per_turn = 189},
                          .max_velocity = 500,
                          .hold_velocity = 25,
                          .max_acceleration = 2000});
}
CubemarsPosition position_in(const std::optional<Frame>& frame) {
  return *can::read_cubemars_position(*frame, motor);
}

TEST(CubemarsFeedback, IsCountedOverAllTurnsThoughItGoesRound) {
  Cubemars cubemars = some_motor();
  double deg = 3000;
  for (const double step : {50.0, 100.0, 200.0, 3000.0, -3000.0, -500.0, -3200.0, -3200.0, 100.0}) {
    const auto decidegrees = static_cast<std::int16_t>(std::lround(10 * deg));
    const auto report = cubemars.read(can::cubemars_feedback_frame(motor, {.decidegrees = decidegrees}));
    EXPECT_NEAR(report.place->turns, deg / 360, 1e-9);
    deg += step;
  }
  // Asked anew it is believed as it is.
  EXPECT_FALSE(cubemars.order(ServoOrder::say_what_you_are));
  EXPECT_NEAR(cubemars.read(can::cubemars_feedback_frame(motor, {.decidegrees = -100})).place->turns,
              -10.0 / 360, 1e-9);
}

// docs/faults.md 29
TEST(CubemarsPosition, NeverGoesOutWithoutLimits) {
  EXPECT_FALSE(Cubemars::make({.motor = motor, .scale = {.electric_turns_per_turn = 189}}));
  EXPECT_FALSE(Cubemars::make(
      {.motor = motor, .scale = {}, .max_velocity = 500, .hold_velocity = 25, .max_acceleration = 2000}))
      << "its gear is not known";
  Cubemars cubemars = some_motor();
  EXPECT_EQ(position_in(cubemars.command({.turns = -1})), (CubemarsPosition{-3'600'000, 500, 2000}));
  EXPECT_EQ(position_in(cubemars.hold(ServoHold::switching_on, 1)), (CubemarsPosition{3'600'000, 25, 2000}));
  const auto stop = cubemars.hold(ServoHold::stopping, 1);
  ASSERT_TRUE(stop);
  EXPECT_EQ(can::read_cubemars_speed(*stop, motor), 0) << "a stop needs no position";
  EXPECT_FALSE(cubemars.hold(ServoHold::off, 1)) << "it would be switched on";
  EXPECT_FALSE(cubemars.command({.turns = 597})) << "32 bits hold less";
  EXPECT_FALSE(cubemars.command({.turns = std::nan("")}));
}

TEST(CubemarsReport, ItIsOffOnceItHasBeenSentNoCurrentAndTellsThatNoneFlows) {
  Cubemars cubemars = some_motor();
  const auto status = [&](std::int16_t centiamperes) {
    return *cubemars.read(can::cubemars_feedback_frame(motor, {.centiamperes = centiamperes})).status;
  };
  EXPECT_TRUE(status(0).is_on) << "nobody knows";
  EXPECT_EQ(can::read_cubemars_current(*cubemars.order(ServoOrder::switch_off), motor), 0);
  EXPECT_FALSE(status(-150).is_off || status(-150).is_on);
  EXPECT_TRUE(status(3).is_off);
  static_cast<void>(cubemars.command({.turns = 0}));
  EXPECT_TRUE(status(0).is_on);
}

TEST(CubemarsError, IsSaidInWords) {
  EXPECT_STREQ(can::words_of_cubemars_error(5), "its encoder has failed");
  EXPECT_STREQ(can::words_of_cubemars_error(7), "its motor is blocked");
  EXPECT_STREQ(can::words_of_cubemars_error(8), "an error that its maker does not explain");
}

// Whatever arrives: what has been understood means the same when it is written again.
TEST(CubemarsReport, AnyFramesAreUnderstoodOrRefused) {
  constexpr std::uint32_t seed = 20'260'312;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  Cubemars cubemars = some_motor();
  int understood = 0;
  for (int i = 0; i < 200'000; ++i) {
    constexpr std::uint32_t packets[] = {0, 1, 6, 8, 0x0F, 0x10, 0x29, 0x29, 0x29, 0x2A};
    const std::uint32_t number = packets[random() % 10] << 8 | (random() % 8 == 0 ? 4U : 3U);
    const bool is_extended = random() % 16 != 0;
    Frame frame{.id = is_extended ? can::FrameId::extended(number) : can::FrameId::standard(number & 0x7FF)};
    frame.is_remote = random() % 16 == 0;
    frame.length = static_cast<std::uint8_t>(random() % 4 == 0 ? random() % 9 : 8);
    for (std::size_t byte = 0; byte < frame.length; ++byte) {
      frame.data.at(byte) = static_cast<std::uint8_t>(random());
    }
    if (const auto position = can::read_cubemars_position(frame, motor)) {
      ASSERT_EQ(can::cubemars_position_frame(motor, *position), frame);
    }
    if (!cubemars.is_concerned(frame)) continue;
    const can::ServoReport report = cubemars.read(frame);
    const bool is_feedback = frame.id.number() == 0x2903U;
    ASSERT_EQ(report.is_of_a_host, !is_feedback);
    ASSERT_EQ(report.is_bad, is_feedback && (frame.is_remote || frame.length != 8));
    if (!report.place) continue;
    ++understood;
    ASSERT_EQ(can::cubemars_feedback_frame(motor, *can::read_cubemars_feedback(frame, motor)), frame);
    ASSERT_FALSE(report.status->is_on && report.status->is_off);
  }
  EXPECT_GT(understood, 1000);
}

// --- on a bus

TEST(CubemarsOnABus, EveryStartSaysThatNothingStopsIt) {
  BusAxis<CubemarsKind> axis;
  ASSERT_TRUE(axis.switch_on());
  EXPECT_THAT(CubemarsKind::lacks_of(axis.host()),
              testing::ElementsAre(testing::HasSubstr("nothing stops the motor if this program dies")));
}

// docs/faults.md 29
TEST(CubemarsOnABus, WhenThisProgramDiesItGoesNoFasterThanItsLimitToItsLastPositionAndHoldsIt) {
  BusAxis<CubemarsKind> axis;
  ASSERT_TRUE(axis.switch_on());
  axis.from = axis.state.actual;
  for (int tick = 0; tick <= 125; ++tick) axis.tick(axis.swing(tick * 0.004));
  double fastest = 0;
  for (int i = 0; i < 2000; ++i) {
    static_cast<void>(axis.wire.run(axis.now_ns += 1'000'000));
    fastest = std::max(fastest, std::fabs(axis.drive->velocity() / CubemarsKind::scale_of(axis.axis())));
  }
  const double last = axis.drive->take_record().applied.back().target / CubemarsKind::scale_of(axis.axis());
  EXPECT_LT(fastest, 1.25 * axis.axis().max_velocity);
  EXPECT_NEAR(axis.truly(), last, 0.01);
  EXPECT_TRUE(axis.has_power());
}

// The two scales of the firmware differ by a hundred, and what a motor tells has the same one in both.
TEST(CubemarsOnABus, AMotorWithAnotherScaleIsFoundBeforeItHasGoneFar) {
  BusAxis<CubemarsKind> axis;
  const std::string text = DriveInRig<CubemarsKind>::text();
  const RigFile other =
      parse_rig(rig_text({axis_text("pan", "deg", {-90, 90}, {.velocity = 40, .acceleration = 400}, "",
                                    text + ", counts_per_deg = 1000000")},
                         {.rate_hz = 250, .more = bus_can0}),
                "rig.toml");
  // A host that has the early scale, and a motor with today's: it is told to go a hundred times as far.
  std::vector<CubemarsKind::Bus::Drive> hosts{CubemarsKind::host_of(other.axes[0], other.rate_hz)};
  CubemarsKind::Bus bus = CubemarsKind::bus_of(hosts, other.rate_hz, other.axes[0]);
  std::array<can::PortDrive, 1> known{};
  std::array<CubemarsKind::Bus::Drive::Target, 1> targets{};
  std::array<Frame, can::frames_per_read(1)> frames{};
  std::vector<BusAxis<CubemarsKind>::Port::Lane> lanes{{&bus, &axis.link, targets, known, frames}};
  auto port = *BusAxis<CubemarsKind>::Port::make(lanes, axis.axes);
  port.enable();
  DriveState state{};
  for (int i = 0; i < 1000; ++i) {
    axis.now_ns += axis.tick_ns;
    port.read({&state, 1}, axis.now_ns);
    port.write({}, axis.now_ns);
    if (state.condition != DriveCondition::fine) port.disable();
  }
  EXPECT_TRUE(hosts[0].findings().has(DriveFinding::moved_while_enabling));
  EXPECT_NEAR(axis.truly(), 20, 0.5);
  EXPECT_FALSE(axis.has_power());
}

}  // namespace cubemars_test
}  // namespace inbetween
