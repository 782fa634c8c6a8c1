// What CANSimple cannot say is not sent, and what is no frame of it is not read.
#include "inbetween/can/odrive.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>

#include "inbetween/can/servo_drive.hpp"
#include "sim/odrive_drive.hpp"
#include "tests/support/bus_axis.hpp"

namespace inbetween::can {
namespace odrive_test {

const OdriveNode node = *OdriveNode::make(3);
constexpr auto v05 = OdriveFamily::firmware_05;
constexpr auto v06 = OdriveFamily::firmware_06;

TEST(OdriveNode, IsANumberThatADriveCanHave) {
  EXPECT_TRUE(OdriveNode::make(0));
  EXPECT_TRUE(OdriveNode::make(62));
  EXPECT_FALSE(OdriveNode::make(63)) << "that of drives without a number";
  EXPECT_FALSE(OdriveNode::make(-1));
}

// An int16 that went round has made a motor run away.
TEST(OdrivePosition, AFeedForwardThatDoesNotFitIsNotSent) {
  const auto frame = [](double turns_per_s) {
    return odrive_position_frame(node, {.turns = 1, .turns_per_s = turns_per_s});
  };
  ASSERT_TRUE(frame(32.767));
  EXPECT_EQ(read_odrive_position(*frame(32.767), node)->turns_per_s, 32.767);
  EXPECT_EQ(read_odrive_position(*frame(-32.767), node)->turns_per_s, -32.767);
  EXPECT_FALSE(frame(32.768));
  EXPECT_FALSE(frame(-40));
  EXPECT_FALSE(frame(std::numeric_limits<double>::quiet_NaN()));
  EXPECT_FALSE(odrive_position_frame(node, {.turns = std::numeric_limits<float>::infinity()}));
  EXPECT_FALSE(odrive_position_frame(node, {.turns = 1, .torque_nm = 33}));
}

TEST(OdrivePosition, ATargetBeyondWhatItCanBeToldIsNone) {
  using Drive = ServoDrive<Odrive>;
  EXPECT_TRUE(Drive::target_of(1.0, 32.0, 0.5));
  EXPECT_EQ(Drive::target_of(1.0, 32.0, 0.5)->turns, 1.5);
  EXPECT_FALSE(Drive::target_of(1.0, 33.0, 0.0));
  EXPECT_FALSE(Drive::target_of(std::numeric_limits<double>::infinity(), 0.0, 0.0));
  EXPECT_FALSE(Drive::target_of(1.0, std::numeric_limits<double>::quiet_NaN(), 0.0));
}

TEST(OdriveError, IsSaidInWordsByItsFamily) {
  EXPECT_STREQ(words_of_odrive_error(v05, 0x800), "its watchdog has expired");
  EXPECT_STREQ(words_of_odrive_error(v06, 0x1000000), "its watchdog has expired");
  EXPECT_STREQ(words_of_odrive_error(v05, 0x100), "its encoder has failed");
  EXPECT_STREQ(words_of_odrive_error(v06, 0x100), "its supply voltage is too high");
  EXPECT_STREQ(words_of_odrive_error(v06, 0x80000000), "an error that this program does not know");
}

TEST(OdriveReport, AnEstimateThatIsNoNumberIsABadFrame) {
  Odrive odrive(node, v06);
  EXPECT_FALSE(odrive.read(odrive_estimates_frame(node, 1, 2)).is_bad);
  EXPECT_TRUE(odrive.read(odrive_estimates_frame(node, std::nanf(""), 0)).is_bad);
  Frame shortened = odrive_estimates_frame(node, 1, 2);
  shortened.length = 7;
  EXPECT_TRUE(odrive.read(shortened).is_bad);
}

TEST(OdriveReport, WhileItIsBusyItIsNeitherOnNorOff) {
  Odrive odrive(node, v06);
  const auto status = [&](std::uint8_t state, std::uint8_t result) {
    return odrive.read(odrive_heartbeat_frame(node, v06, {.state = state, .result = result})).status.value();
  };
  EXPECT_TRUE(status(8, 0).is_on);
  EXPECT_FALSE(status(8, 1).is_on);
  EXPECT_TRUE(status(1, 0).is_off);
  EXPECT_FALSE(status(1, 1).is_off);
  EXPECT_FALSE(status(3, 0).is_on || status(3, 0).is_off) << "it calibrates";
}

// Whatever arrives: what has been understood means the same when it is written again.
TEST(OdriveReport, AnyFramesAreUnderstoodOrRefused) {
  constexpr std::uint32_t seed = 20250311;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  int understood = 0;
  for (int i = 0; i < 200'000; ++i) {
    const auto number = static_cast<std::uint32_t>(3U << 5 | (random() & 0x1FU));
    Frame frame{.is_remote = random() % 16 == 0};
    frame.id = random() % 16 == 0 ? can::FrameId::extended(number) : can::FrameId::standard(number);
    frame.length = static_cast<std::uint8_t>(random() % 4 == 0 ? random() % 9 : 8);
    for (std::uint8_t& byte : frame.data) byte = static_cast<std::uint8_t>(random());
    for (const OdriveFamily family : {v05, v06}) {
      Odrive odrive(node, family);
      if (!odrive.is_concerned(frame)) continue;
      const ServoReport report = odrive.read(frame);
      if (report.place) {
        ++understood;
        ASSERT_EQ(odrive_estimates_frame(node, static_cast<float>(report.place->turns),
                                         static_cast<float>(report.place->turns_per_s)),
                  frame);
      }
      ASSERT_FALSE(report.status && report.status->is_on && report.status->is_off);
      ASSERT_FALSE(frame.is_remote && (report.place || report.status || report.is_of_a_host));
    }
    if (const auto position = read_odrive_position(frame, node); position && std::isfinite(position->turns)) {
      const bool is_symmetric = position->turns_per_s >= -32.767 && position->torque_nm >= -32.767;
      ASSERT_TRUE(!is_symmetric || odrive_position_frame(node, *position) == frame);
    }
    if (const auto version = read_odrive_version(frame, node); version && frame.data[7] <= 1) {
      ASSERT_EQ(odrive_version_frame(node, *version), frame);
    }
  }
  EXPECT_GT(understood, 1000);
}

// --- what it says of itself, and what it does not

using Axis = inbetween::BusAxis<OdriveKind>;
std::string trouble_of(const Axis& axis) {
  const auto finding = axis.host().first_finding();
  return finding ? std::string(words_of(*finding).what) + "; " + words_of(*finding).remedy : "";
}

TEST(OdriveOnABus, SwitchedOffByAnotherProgramItIsToldSoAndKeepsItsPlace) {
  Axis axis;
  ASSERT_TRUE(axis.switch_on());
  axis.from = axis.state.actual;
  for (int tick = 0; tick <= 125; ++tick) axis.tick(axis.swing(tick * 0.004));
  axis.drive->add_trouble({.kind = DriveTrouble::Kind::switched_off, .at_ns = axis.now_ns});
  for (int tick = 126; tick < 300 && axis.worst == DriveCondition::fine; ++tick)
    axis.tick(axis.swing(tick * 0.004));
  EXPECT_EQ(axis.worst, DriveCondition::cannot_follow);
  EXPECT_EQ(
      trouble_of(axis),
      "somebody else has switched the drive off: it tells no error, and was heard all the time; disconnect "
      "other masters and set-up tools from the drive");
  EXPECT_FALSE(axis.port->has_forgotten(0));
}

// docs/faults.md 50
TEST(OdriveOnABus, TwoOfThemWithOneNumberAreFoundByTheirSerials) {
  Axis axis;
  const double scale = OdriveKind::scale_of(axis.axis());
  SimulatedOdrive second(
      {.node = *OdriveNode::make(3), .serial = 42, .turns = -40 * scale, .keeps_record = true}, 0);
  axis.wire.attach(second);
  EXPECT_FALSE(axis.switch_on());
  EXPECT_EQ(axis.host().first_finding(), DriveFinding::two_devices);
  axis.ticks(500);
  EXPECT_FALSE(axis.has_power() || second.is_on());
  EXPECT_FALSE(axis.drive->has_been_moved() || second.has_been_moved());
}

// docs/faults.md 23
TEST(OdriveOnABus, TheErrorsOfItsPartsAreToldByTheirCodes) {
  for (const auto& [code, words] : {std::pair{0x40, "of its motor (error 8h: its gate driver has failed)"},
                                    {0x100, "of its encoder (error 4h: it does not answer)"},
                                    {0x200, "of its controller (error 1h: it was too fast)"}}) {
    Axis axis(R"(type = "odrive", bus = "can0", node = 3, turns_per_unit = 0.25, firmware = "0.5")");
    axis.drive->add_trouble({.kind = DriveTrouble::Kind::emergency, .value = code});
    axis.ticks(250);
    EXPECT_FALSE(axis.switch_on());
    EXPECT_THAT(OdriveKind::detail_of(axis.host(), *axis.host().first_finding()), testing::HasSubstr(words));
  }
}

TEST(OdriveReport, TheOtherFamilyIsNeverAskedForItsNumber) {
  Odrive old(node, v05);
  Odrive unknown(node, v06);
  for (int i = 0; i < 20; ++i) {
    for (Odrive* drive : {&old, &unknown}) {
      const auto asked = drive->order(ServoOrder::say_what_you_are);
      EXPECT_NE(asked ? asked->id.number() & odrive_message_bits : 0, 0x06U)
          << "0.5 would take another node by it";
    }
  }
}

TEST(OdriveOnABus, ARestartIsStillARestart) {
  Axis axis;
  ASSERT_TRUE(axis.switch_on());
  axis.from = axis.state.actual;
  for (int tick = 0; tick <= 125; ++tick) axis.tick(axis.swing(tick * 0.004));
  axis.drive->add_trouble({.kind = DriveTrouble::Kind::reboot, .at_ns = axis.now_ns});
  axis.ticks(1500, axis.swing(0.5));
  EXPECT_TRUE(axis.host().findings().has(DriveFinding::unexpected_boot)) << trouble_of(axis);
  EXPECT_FALSE(axis.host().findings().has(DriveFinding::switched_off_by_another));
  EXPECT_TRUE(axis.port->has_forgotten(0));
}

/// Switched off in motion it is held until it rests, for seconds where it does not come to rest.
TEST(OdriveOnABus, OneThatGetsAwayWhileItIsSwitchedOffLosesItsPowerAtOnce) {
  for (const bool gets_away : {false, true}) {
    Axis axis;
    ASSERT_TRUE(axis.switch_on());
    axis.from = axis.state.actual;
    for (int tick = 0; tick <= 60; ++tick) axis.tick(axis.swing(tick * 0.004));
    axis.port->disable();
    axis.tick();
    ASSERT_TRUE(axis.has_power()) << "it is held until it rests";
    if (gets_away) axis.port->stop_one(0, OwnStop::cut);
    axis.ticks(3);
    EXPECT_EQ(axis.has_power(), !gets_away);
  }
}

TEST(OdriveOnABus, OneThatSendsHeartbeatsAndNoEstimatesIsToldThatAndIsLetGo) {
  Axis axis;
  axis.drive->add_trouble({.kind = DriveTrouble::Kind::lose_feedback});
  EXPECT_FALSE(axis.switch_on());
  EXPECT_THAT(trouble_of(axis), testing::AllOf(testing::HasSubstr("the drive tells how it is, but not where"),
                                               testing::HasSubstr("encoder_msg_rate_ms")));
  axis.port->disable();
  axis.ticks(1500);
  EXPECT_FALSE(axis.host().findings().has(DriveFinding::moves_while_off));
  EXPECT_FALSE(axis.drive->has_been_moved());
}

}  // namespace odrive_test
}  // namespace inbetween::can
