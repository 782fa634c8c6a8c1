// What a moteus cannot be told is not sent, what is none of its frames is not read, and what it does in its
// own way on a bus.
#include "inbetween/can/moteus.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "inbetween/can/bus_load.hpp"
#include "inbetween/can/moteus_register.hpp"
#include "sim/moteus_drive.hpp"
#include "tests/support/bus_axis.hpp"

namespace inbetween {
namespace moteus_test {

using can::DriveFinding;
using can::FdFrame;
using can::Moteus;
using can::MoteusItem;
using can::MoteusMode;
using can::MoteusReader;
using can::MoteusRegister;
using can::MoteusType;
using can::MoteusWriter;
using can::ServoReport;
using Trouble = DriveTrouble::Kind;

const can::MoteusNode node = *can::MoteusNode::make(3);
constexpr double none = std::numeric_limits<double>::quiet_NaN();

TEST(MoteusNode, IsANumberThatOneDriveHas) {
  EXPECT_TRUE(can::MoteusNode::make(1));
  EXPECT_TRUE(can::MoteusNode::make(126));
  EXPECT_FALSE(can::MoteusNode::make(0)) << "that of this program";
  EXPECT_FALSE(can::MoteusNode::make(127)) << "that of all";
}

TEST(FdFrameLength, IsTheNextThatAFrameCanHave) {
  for (std::size_t length = 0; length <= 8; ++length) EXPECT_EQ(can::fd_length_for(length), length);
  EXPECT_EQ(can::fd_length_for(9), 12U);
  EXPECT_EQ(can::fd_length_for(24), 24U);
  EXPECT_EQ(can::fd_length_for(25), 32U);
  EXPECT_EQ(can::fd_length_for(33), 48U);
  EXPECT_EQ(can::fd_length_for(49), 64U);
  EXPECT_FALSE(can::is_fd_length(23));
  EXPECT_FALSE(can::is_fd_length(65));
}

// The times of the standard's frames at 1 and 5 Mbit/s, as the makers of controllers tabulate them.
TEST(BusLoad, OfCanFdFramesIsThatOfBothBitrates) {
  const auto us = [](std::int32_t length, bool is_extended) {
    return can::bits_of_arbitration(can::worst_case_fd_bits(length, is_extended), 1'000'000, 5'000'000);
  };
  EXPECT_EQ(us(16, true), 95);
  EXPECT_EQ(us(24, true), 112);
  EXPECT_EQ(us(32, true), 128);
  EXPECT_EQ(us(64, true), 192);
  EXPECT_EQ(us(24, false), 89);
}

TEST(MoteusValue, AnIntegerSaysNoneByItsLowestNumberAndNeverGoesRound) {
  struct Row {
    double value;
    MoteusType type;
    std::uint32_t bits;
  };
  for (const Row& row : {Row{none, MoteusType::int8, 0xFFFFFF80U}, Row{none, MoteusType::int16, 0xFFFF8000U},
                         Row{none, MoteusType::int32, 0x80000000U}, Row{1e9, MoteusType::int16, 32767},
                         Row{-1e9, MoteusType::int16, static_cast<std::uint32_t>(-32767)},
                         Row{-0.0199, MoteusType::int8, static_cast<std::uint32_t>(-1)},
                         Row{none, MoteusType::float32, 0x7FC00000U}}) {
    EXPECT_EQ(can::moteus_bits_of(row.value, MoteusRegister::position, row.type), row.bits) << row.value;
  }
  EXPECT_TRUE(std::isnan(can::moteus_value_of(0x80, MoteusRegister::position, MoteusType::int8)));
  EXPECT_EQ(can::moteus_value_of(0x81, MoteusRegister::mode, MoteusType::int8), -127);
  EXPECT_TRUE(std::isnan(can::moteus_value_of(0x7FC00000U, MoteusRegister::position, MoteusType::float32)));
}

TEST(MoteusWriter, WhatDoesNotFitIsNotAFrame) {
  FdFrame frame;
  MoteusWriter writer(frame);
  writer.write(MoteusRegister::command_position, MoteusType::float32, std::vector<double>(16, 1.0));
  EXPECT_FALSE(writer.finish());
}

FdFrame answer(const std::vector<std::uint8_t>& bytes) {
  FdFrame frame{.id = 0x300, .length = static_cast<std::uint8_t>(bytes.size())};
  std::ranges::copy(bytes, frame.data.begin());
  return frame;
}
ServoReport read(const std::vector<std::uint8_t>& bytes, bool must_know_place = true) {
  return Moteus({.node = node, .must_know_place = must_know_place}).read(answer(bytes));
}

TEST(MoteusReport, AnAnswerThatBreaksOffIsNotBelievedInItsOtherParts) {
  const std::vector<std::uint8_t> whole{0x21, 0x00, 0x0A, 0x2E, 0x01, 0, 0, 0x80, 0x3E, 0, 0, 0, 0};
  EXPECT_TRUE(read(whole).place && read(whole).status);
  const ServoReport broken = read({0x21, 0x00, 0x0A, 0x2E, 0x01, 0, 0, 0x80});
  EXPECT_TRUE(broken.is_bad);
  EXPECT_FALSE(broken.status || broken.place);
}

TEST(MoteusReport, APositionThatIsNoneIsABadFrameWithAStatus) {
  const ServoReport report = read({0x21, 0x00, 0x0A, 0x26, 0x01, 0x00, 0x80, 0x00, 0x00});
  EXPECT_TRUE(report.is_bad);
  EXPECT_FALSE(report.place);
  EXPECT_TRUE(report.status);
}

TEST(MoteusReport, AFaultAndAForeignModeAreErrorsAndWhatOnlyLimitsIsNone) {
  const auto status = [](std::uint8_t mode, std::uint8_t fault) {
    return read({0x21, 0x00, mode, 0x21, 0x0F, fault}).status.value();
  };
  EXPECT_EQ(status(1, 38).errors, 38U);
  EXPECT_TRUE(status(1, 38).is_off);
  EXPECT_EQ(status(10, 99).errors, 0U) << "its current is limited";
  EXPECT_TRUE(status(10, 99).is_on);
  EXPECT_EQ(status(9, 0).errors, can::moteus_mode_error + 9);
  EXPECT_FALSE(status(3, 0).is_on || status(3, 0).is_off) << "it calibrates";
  EXPECT_EQ(status(3, 0).errors, 0U);
  EXPECT_STREQ(can::words_of_moteus_error(38), "it is too hot");
  EXPECT_STREQ(can::words_of_moteus_error(0x109), "it is in a mode that this program does not use");
  EXPECT_STREQ(can::words_of_moteus_error(77), "an error that this program does not know");
}

TEST(MoteusReport, OtherRegistersThanTheKnownOnesAreAnotherDevice) {
  // 102 as int32, then as an error of the drive that does not have it.
  EXPECT_EQ(read({0x29, 0x82, 0x02, 5, 0, 0, 0}).is_expected_device, true);
  EXPECT_EQ(read({0x29, 0x82, 0x02, 4, 0, 0, 0}).is_expected_device, false);
  EXPECT_EQ(read({0x29, 0x82, 0x02, 4, 0, 0, 0}).version, 4U);
  EXPECT_EQ(read({0x31, 0x82, 0x02, 0x01}).is_expected_device, false);
}

TEST(MoteusReport, ItsPlaceIsKnownByItsOutputShaftOnlyIfTheRigBelievesIt) {
  EXPECT_EQ(read({0x21, 0x0C, 2}).knows_place, true);
  EXPECT_EQ(read({0x21, 0x0C, 1}).knows_place, false) << "by its rotor: whole turns may be missing";
  EXPECT_FALSE(read({0x21, 0x0C, 0}, false).knows_place.has_value());
}

TEST(MoteusReport, WhatAnybodySendsToItIsOfAHost) {
  const Moteus moteus({.node = node});
  for (const std::uint32_t id : {0x0003U, 0x8103U, 0x007FU}) {
    const FdFrame frame{.id = can::FrameId::shortest(id)};
    ASSERT_TRUE(moteus.is_concerned(frame)) << id;
    EXPECT_TRUE(moteus.read(frame).is_of_a_host) << id;
  }
  EXPECT_FALSE(moteus.is_concerned({.id = 0x0004}));
  EXPECT_FALSE(moteus.is_concerned({.id = can::FrameId::extended(0x10003)})) << "of another prefix";
  EXPECT_FALSE(moteus.is_concerned({.id = 0x301})) << "an answer to another host";
}

// Whatever arrives: it ends, and what has been understood means the same when it is written again.
TEST(MoteusReport, AnyBytesAreUnderstoodOrRefused) {
  constexpr std::uint32_t seed = 20250614;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  constexpr std::array<std::uint8_t, 12> heads{0x01, 0x04, 0x0E, 0x10, 0x1F, 0x20,
                                               0x21, 0x24, 0x2F, 0x31, 0x50, 0x40};
  int understood = 0;
  for (int i = 0; i < 200'000; ++i) {
    FdFrame frame{.id = 0x300};
    frame.length = static_cast<std::uint8_t>(can::fd_length_for(random() % 65));
    for (std::uint8_t& byte : frame.data) {
      byte = static_cast<std::uint8_t>(random() % 3 == 0 ? heads[random() % heads.size()] : random() % 16);
    }
    MoteusReader reader(frame);
    std::size_t items = 0;
    while (const auto item = reader.next()) {
      ASSERT_LE(++items, 2048U);
      if (item->kind != MoteusItem::Kind::reply || std::isnan(item->value)) continue;
      ++understood;
      const double again = can::moteus_value_of(
          can::moteus_bits_of(item->value, item->reg, MoteusType::float32), item->reg, MoteusType::float32);
      if (std::isfinite(again)) {
        ASSERT_NEAR(again, item->value, 1e-6 * std::fabs(item->value));
      }
    }
    const ServoReport report = Moteus({.node = node}).read(frame);
    ASSERT_TRUE(!report.place || std::isfinite(report.place->turns));
    ASSERT_TRUE(!report.status || !(report.status->is_on && report.status->is_off));
    if (reader.is_bad()) {
      ASSERT_TRUE(report.is_bad && !report.status && !report.place);
    }
  }
  EXPECT_GT(understood, 10'000);
}

// --- on a bus

const SimulatedMoteus& simulated(const BusAxis<MoteusKind>& axis) {
  return static_cast<const SimulatedMoteus&>(*axis.drive);
}
/// On its way, a quarter of the swing behind it.
void begin(BusAxis<MoteusKind>& axis) {
  ASSERT_TRUE(axis.switch_on());
  axis.from = axis.state.actual;
  for (int tick = 0; tick <= 125; ++tick) axis.tick(axis.swing(tick * 0.004));
  ASSERT_EQ(axis.worst, DriveCondition::fine);
}
void add(BusAxis<MoteusKind>& axis, Trouble kind) {
  axis.drive->add_trouble({.kind = kind, .at_ns = axis.now_ns});
}

// docs/faults.md 29
TEST(MoteusOnABus, ItsWatchdogIsTriedWithoutTorqueAndTheAxisDoesNotMove) {
  BusAxis<MoteusKind> axis;
  axis.port->enable();
  bool was_tried = false;
  while (axis.host().phase() != can::DrivePhase::idle && axis.now_ns < 2'000'000'000) {
    axis.tick();
    was_tried = was_tried || simulated(axis).mode() == MoteusMode::timeout;
    ASSERT_EQ(axis.truly(), BusAxis<MoteusKind>::stands_at);
  }
  EXPECT_TRUE(was_tried);
  EXPECT_GT(axis.host().proven_watchdog_ns(), 40'000'000);
  EXPECT_LT(axis.host().proven_watchdog_ns(), 80'000'000) << "the watchdog of the frames, not of the drive";
  EXPECT_TRUE(axis.drive->take_record().applied.empty());
}

// docs/faults.md 24: a command would switch it on, and it counts from somewhere else then.
TEST(MoteusOnABus, OneThatHasStartedAnewIsNotCommandedAgain) {
  BusAxis<MoteusKind> axis;
  begin(axis);
  add(axis, Trouble::reboot);
  axis.drive->take_record();
  const double before = axis.truly();
  for (int tick = 126; tick < 250; ++tick) axis.tick(axis.swing(tick * 0.004));
  // Not even on its way: a stop that follows a command may come in time or not.
  for (const DriveRecord::Entered& entered : axis.drive->take_record().entered) {
    EXPECT_STREQ(entered.state, "stopped");
  }
  EXPECT_EQ(simulated(axis).mode(), MoteusMode::stopped);
  EXPECT_TRUE(axis.host().findings().has(DriveFinding::unexpected_boot));
  EXPECT_NEAR(axis.truly(), before, 2) << "it rolls out";
}

// docs/faults.md 16, 29
TEST(MoteusOnABus, WhatItsWatchdogBrakesIsLeftToItUntilItRests) {
  BusAxis<MoteusKind> axis;
  begin(axis);
  axis.ticks(20);  // no setpoints: its watchdog expires
  ASSERT_EQ(simulated(axis).mode(), MoteusMode::timeout);
  axis.ticks(100);
  EXPECT_EQ(simulated(axis).mode(), MoteusMode::timeout) << "it still has the torque to hold";
  EXPECT_EQ(axis.host().first_finding(), DriveFinding::drive_fault);
  EXPECT_EQ(MoteusKind::detail_of(axis.host(), DriveFinding::drive_fault),
            " (mode 11: its watchdog has expired)");
  axis.port->disable();
  ASSERT_TRUE(axis.tick_until([&] { return !axis.state.is_leaving && axis.now_ns > 1'200'000'000; }));
  EXPECT_EQ(simulated(axis).mode(), MoteusMode::stopped);
}

TEST(MoteusOnABus, OneThatDoesNotKnowWhereItIsIsRefusedUnlessSomebodySaysSo) {
  for (const bool is_said : {false, true}) {
    BusAxis<MoteusKind> axis(DriveInRig<MoteusKind>::text(), is_said ? "reference = \"operator\"" : "");
    add(axis, Trouble::reboot);  // its encoder counts from there
    EXPECT_EQ(axis.switch_on(), is_said);
    EXPECT_EQ(axis.host().findings().has(DriveFinding::place_unknown), !is_said);
    EXPECT_EQ(axis.has_power(), is_said);
  }
}

TEST(MoteusOnABus, OneWithOtherRegistersIsRefusedWithTheirVersion) {
  BusAxis<MoteusKind> axis;
  SimulatedMoteus other({.node = node, .map_version = 4}, 0);
  SimulatedFdBus wire;
  wire.attach(other);
  axis.wire = wire;
  EXPECT_FALSE(axis.switch_on());
  EXPECT_EQ(axis.host().first_finding(), DriveFinding::wrong_firmware);
  EXPECT_EQ(MoteusKind::detail_of(axis.host(), DriveFinding::wrong_firmware),
            " (its registers are of version 4, and this program knows version 5)");
  EXPECT_EQ(other.mode(), MoteusMode::stopped);
}

// It goes on by its velocity: between two frames it is where the plan is, not where it was.
TEST(MoteusOnABus, BetweenTwoFramesItGoesOnAsThePlanDoes) {
  BusAxis<MoteusKind> axis;
  begin(axis);
  double largest = 0;
  for (int tick = 126; tick < 375; ++tick) {
    axis.tick(axis.swing(tick * 0.004));
    // Halfway to the next tick. A target is sent two ticks after it was given, and arrives in the next.
    axis.drive->advance(axis.now_ns + BusAxis<MoteusKind>::tick_ns / 2);
    const double planned = axis.swing((tick - 2.5) * 0.004).position;
    largest = std::max(largest, std::fabs(axis.truly() - planned));
  }
  EXPECT_LT(largest, 0.02);
}

TEST(MoteusOnABus, TooManyForTheirBusAreRefusedWithBothBitrates) {
  const auto rig = [](int drives, int rate_hz) {
    std::vector<AxisText> axes;
    for (int i = 1; i <= drives; ++i) {
      axes.push_back({.name = "a" + std::to_string(i),
                      .drive = "type = \"moteus\", bus = \"can0\", node = " + std::to_string(i) +
                               ", turns_per_unit = 0.1"});
    }
    return parse_rig(rig_text(axes, {.rate_hz = rate_hz, .more = DriveInRig<MoteusKind>::bus()}), "rig.toml");
  };
  EXPECT_NO_THROW(refuse_overloaded_buses(rig(11, 250)));
  EXPECT_NO_THROW(refuse_overloaded_buses(rig(3, 1000)));
  try {
    refuse_overloaded_buses(rig(4, 1000));
    ADD_FAILURE() << "four at 1 kHz fit";
  } catch (const InputError& error) {
    EXPECT_NE(error.message().find("need 86.8 % of its 1000000 bit/s (5000000 bit/s of data) at 1000 Hz"),
              std::string::npos)
        << error.message();
  }
}

}  // namespace moteus_test
}  // namespace inbetween
