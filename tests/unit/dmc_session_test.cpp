// Whole sessions with a DMC device, from a scripted host that shares nothing with it.
#include "tests/support/dmc_session.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace inbetween {
namespace dmc_session_test {

using namespace dragonframe;

constexpr unsigned ok = 0x10;
constexpr unsigned moving = 0x12;
constexpr unsigned unsupported = 0x13;
constexpr unsigned range = 0x14;
constexpr unsigned general = 0x15;
constexpr unsigned not_in_position = 0x16;
constexpr unsigned preroll = 0x17;
constexpr unsigned postroll = 0x18;
constexpr unsigned soft_upper = 0x20;
constexpr unsigned soft_lower = 0x21;
constexpr unsigned hard_lower = 0x23;

const DmcFacts eight_motors{.motors = 8, .outputs = 2, .inputs = 1, .capabilities = 0x0783};

/// Frame after frame of a motor, whole steps.
std::int32_t drawn(unsigned motor, std::int32_t frame) {
  return static_cast<std::int32_t>(std::lround(1000.0 * motor + 400 * std::sin(0.01 * motor * frame)));
}

void upload_all(DmcSession& session, std::int32_t frames) {
  ASSERT_EQ(session.ask(session.host.upload_begin(1, frames)), ok);
  constexpr std::int32_t block = 500;
  for (unsigned motor = 1; motor <= 8; ++motor) {
    for (std::int32_t first = 1; first <= frames; first += block) {
      std::vector<std::int32_t> positions;
      for (std::int32_t frame = first; frame < std::min(first + block, frames + 1); ++frame) {
        positions.push_back(drawn(motor, frame));
      }
      const auto index = static_cast<std::uint32_t>(first - 1);
      ASSERT_EQ(session.ask(session.host.upload_axis(motor, index, first + block > frames, positions)), ok);
    }
  }
  ASSERT_EQ(session.ask(session.host.upload_triggers(1, {{9, 1}})), ok);
  ASSERT_EQ(session.ask(session.host.upload_end()), ok);
}

TEST(DmcSession, EightMotorsAreConfiguredUploadedPositionedAndRun) {
  DmcSession session(eight_motors);
  ASSERT_EQ(session.pushed(0x0001), 1U) << "a host hears that the device was reset";
  ASSERT_EQ(session.ask(session.host.hi()), 0U);
  EXPECT_EQ(session.host.data()->payload.size(), 51U);
  EXPECT_EQ(session.host.data()->number(41, 4), 10'000U) << "the capacity that uploads are held to";
  for (unsigned motor = 1; motor <= 8; ++motor) {
    ASSERT_EQ(session.ask(session.host.configure(motor, 0x01)), ok);
    ASSERT_EQ(session.ask(session.host.speed(motor, 20'000, 40'000)), ok);
    ASSERT_EQ(session.ask(session.host.limits(motor, -1000, 10'000)), ok);
  }
  upload_all(session, 2000);
  ASSERT_TRUE(session.device.arm());
  ASSERT_EQ(session.ask(session.host.position_frame(1)), ok);
  session.run_until_still();
  for (unsigned motor = 1; motor <= 8; ++motor) {
    EXPECT_EQ(session.position(static_cast<std::uint8_t>(motor)), drawn(motor, 1));
  }
  ASSERT_EQ(session.ask(session.host.run({.start = 1, .end = 48, .is_synced = true, .bloop_bits = 2})), ok);
  EXPECT_EQ(session.ask(session.host.go()), not_in_position) << "it is not there yet";
  session.run_until(DmcStage::wait);
  const double speed = 24.0 * (drawn(3, 2) - drawn(3, 1));
  EXPECT_EQ(session.position(3), std::lround(drawn(3, 1) - speed / 2))
      << "half a second of the speed at frame 1";
  session.heard.clear();
  ASSERT_EQ(session.ask(session.host.go()), ok);
  session.run_until(DmcStage::jog);
  // Every frame is told where it begins.
  std::int32_t next = 1;
  bool has_ended = false;
  for (const oracle::DmcHeard& message : session.heard) {
    if (message.type == 0x0114) has_ended = true;
    if (message.type != 0x0034 || has_ended ||
        message.number(0, 4) / 1000 != static_cast<std::uint32_t>(next))
      continue;
    EXPECT_NEAR(message.position(5), drawn(5, next), std::abs(drawn(5, next + 1) - drawn(5, next)) + 1);
    ++next;
  }
  EXPECT_EQ(next, 50) << "frames 1 to 48, and where time ends";
  EXPECT_EQ(session.pushed(0x0114), 1U) << "and the end, once";
  const auto outputs = session.rig.taken<SetOutputs>();
  EXPECT_EQ(outputs, (std::vector<SetOutputs>{{2}, {0}, {1}, {0}, {2}, {0}}))
      << "a pulse, the trigger of frame 10, one more";
  session.run_until_still();
  EXPECT_EQ(session.position(3), drawn(3, 49)) << "the frame behind the last";
  EXPECT_EQ(session.ask(session.host.run({.start = 1, .end = 48})), ok) << "it stands on a frame";
}

TEST(DmcSession, AStopInTheMiddleHasNoEndAndTakesTheConsentAway) {
  DmcSession session(eight_motors);
  session.upload(1, std::vector<std::int32_t>(100, 500));
  ASSERT_TRUE(session.device.arm());
  ASSERT_EQ(session.ask(session.host.position_frame(1)), ok);
  session.run_until_still();
  ASSERT_EQ(session.ask(session.host.run({.start = 1, .end = 90})), ok);
  session.run_until(DmcStage::wait);
  ASSERT_EQ(session.ask(session.host.go()), ok);
  session.run_for(2);
  ASSERT_EQ(session.device.stage(), DmcStage::shoot);
  EXPECT_EQ(session.ask(session.host.position_frame(1)), moving);
  EXPECT_EQ(session.ask(session.host.run({.start = 1, .end = 90})), moving);
  EXPECT_EQ(session.ask(session.host.move(1, 0)), moving);
  EXPECT_EQ(session.ask(session.host.reset(1, 0)), moving);
  EXPECT_EQ(session.ask(session.host.upload_begin(1, 10)), moving);
  ASSERT_EQ(session.ask(session.host.stop_all()), ok);
  EXPECT_EQ(session.ask(session.host.stop_all()), ok) << "a stop is never refused";
  const auto stops = session.rig.taken<StopAll>();
  EXPECT_EQ(stops, (std::vector<StopAll>{{.harder = false}, {.harder = true}}));
  EXPECT_EQ(session.ask(session.host.move(1, 0)), hard_lower) << "the gate";
  EXPECT_FALSE(session.device.arm()) << "not before the stop is over";
  EXPECT_EQ(session.ask(session.host.positions()), 0U) << "positions are told nevertheless";
  session.run_for(2.1);
  EXPECT_EQ(session.pushed(0x0114), 0U);
  EXPECT_EQ(session.ask(session.host.run({.start = 1, .end = 90})), not_in_position);
  EXPECT_EQ(session.ask(session.host.move(1, 0)), general) << "somebody has to agree again";
  ASSERT_TRUE(session.device.arm());
  EXPECT_EQ(session.ask(session.host.move(1, 0)), ok);
}

TEST(DmcSession, ASilentStopKeepsTheConsent) {
  DmcSession session(eight_motors);
  ASSERT_TRUE(session.device.arm());
  ASSERT_EQ(session.ask(session.host.move(1, 10'000)), ok);
  session.tick();
  ASSERT_EQ(session.ask(session.host.stop_all(1)), ok);
  session.run_until_still();
  EXPECT_EQ(session.ask(session.host.move(1, 0)), ok);
}

TEST(DmcSession, AJogGoesOnWhileItIsRepeatedAndStopsWithItsHost) {
  DmcSession session(eight_motors);
  ASSERT_TRUE(session.device.arm());
  for (int i = 0; i < 10; ++i) {
    ASSERT_EQ(session.ask(session.host.jog(2, 10'000, INT32_MAX)), ok);
    session.run_for(0.2);
  }
  EXPECT_TRUE(session.rig.taken<StopMotor>().empty());
  const std::int32_t last_heard = session.position(2);
  session.run_for(3);
  EXPECT_EQ(session.rig.taken<StopMotor>(), (std::vector<StopMotor>{{.motor = 2}}));
  EXPECT_LE(session.position(2) - last_heard, 5000 / 2) << "half a second";
  // The other way round the motor first stops.
  ASSERT_EQ(session.ask(session.host.jog(2, 5000, INT32_MAX)), ok);
  session.tick();
  ASSERT_EQ(session.ask(session.host.jog(2, 5000, INT32_MIN)), ok);
  EXPECT_EQ(session.rig.taken<StopMotor>().size(), 2U);
  session.run_for(0.1);
  ASSERT_EQ(session.ask(session.host.jog(2, 5000, INT32_MIN)), ok);
  EXPECT_EQ(session.rig.taken<JogMotor>().back().destination, INT32_MIN);
  // An inch is a move of two steps.
  ASSERT_EQ(session.ask(session.host.stop(2)), ok);
  session.run_until_still();
  const std::int32_t here = session.position(2);
  ASSERT_EQ(session.ask(session.host.jog(2, 1, INT32_MAX)), ok);
  session.run_until_still();
  EXPECT_EQ(session.position(2), here + 2);
}

TEST(DmcSession, AMoveComesRoundUntilItIsToldNotTo) {
  for (const unsigned flags : {0x0001U, 0x0002U}) {
    DmcSession session(eight_motors);
    session.upload(1, {0, 10, 20, 30, 40, 50, 60, 70, 80, 90, 100});
    ASSERT_TRUE(session.device.arm());
    ASSERT_EQ(session.ask(session.host.position_frame(1)), ok);
    session.run_until_still();
    ASSERT_EQ(session.ask(session.host.run({.start = 1, .end = 10, .flags = flags})), ok);
    EXPECT_EQ(session.rig.taken<PrepareRun>().back().postroll_ms, 0U);
    session.run_until(DmcStage::wait);
    ASSERT_EQ(session.ask(session.host.go()), ok);
    session.run_for(6);
    EXPECT_EQ(session.device.stage(), DmcStage::shoot) << "five times as long as the move";
    EXPECT_EQ(session.pushed(0x0114), 0U);
    ASSERT_EQ(session.ask(session.host.stop_loop()), ok);
    session.run_until(DmcStage::jog);
    EXPECT_EQ(session.pushed(0x0114), 1U);
  }
}

TEST(DmcSession, AllJogAlongTheMoveToAFrame) {
  DmcSession session(eight_motors);
  session.upload(1, {0, 100, 200, 300, 400});
  ASSERT_TRUE(session.device.arm());
  EXPECT_EQ(session.ask(session.host.jog_all(12'000, 4)), not_in_position);
  ASSERT_EQ(session.ask(session.host.position_frame(1)), ok);
  session.run_until_still();
  EXPECT_EQ(session.ask(session.host.jog_all(12'000, 6)), range);
  ASSERT_EQ(session.ask(session.host.jog_all(12'000, 4)), ok);
  EXPECT_EQ(session.ask(session.host.move(1, 0)), moving);
  EXPECT_EQ(session.ask(session.host.jog_all(12'000, 3)), ok) << "another frame, on the way";
  session.run_until_still();
  EXPECT_EQ(session.position(1), 200);
  EXPECT_EQ(session.ask(session.host.jog_all(12'000, 5)), ok);
}

TEST(DmcSession, AStopOnAFrameLeavesTheRigInPositionAndAMotorMovedByItselfDoesNot) {
  DmcSession session(eight_motors);
  session.upload(1, {0, 100, 200, 300, 400});
  ASSERT_TRUE(session.device.arm());
  ASSERT_EQ(session.ask(session.host.position_frame(1)), ok);
  session.run_until_still();
  ASSERT_EQ(session.ask(session.host.jog_all(12'000, 5)), ok);
  session.tick();
  ASSERT_EQ(session.ask(session.host.stop_all(1)), ok);
  EXPECT_EQ(session.ask(session.host.jog_all(12'000, 5)), moving);
  session.run_until_still();
  EXPECT_EQ(session.ask(session.host.jog_all(12'000, 5)), not_in_position);
  // A rig that comes to rest on a frame says so.
  ASSERT_EQ(session.ask(session.host.position_frame(1)), ok);
  session.run_until_still();
  ASSERT_EQ(session.ask(session.host.jog_all(12'000, 5)), ok);
  ASSERT_EQ(session.ask(session.host.stop_all(1)), ok);
  session.device.tell(FrameReached{2}, session.now_ns);
  session.run_until_still();
  EXPECT_EQ(session.ask(session.host.jog_all(12'000, 5)), ok);
  ASSERT_EQ(session.ask(session.host.stop_all(1)), ok);
  session.run_until_still();
  // What comes late, behind a move of a motor, is not believed.
  ASSERT_EQ(session.ask(session.host.move(1, 7)), ok);
  session.device.tell(FrameReached{2}, session.now_ns);
  session.run_until_still();
  EXPECT_EQ(session.ask(session.host.jog_all(12'000, 5)), not_in_position);
}

TEST(DmcSession, AMovePlayedBackwardsEndsOneFrameBeforeItsFirst) {
  DmcSession session(eight_motors);
  session.upload(1, {0, 100, 200, 300, 400});
  ASSERT_TRUE(session.device.arm());
  ASSERT_EQ(session.ask(session.host.position_frame(5)), ok);
  session.run_until_still();
  ASSERT_EQ(session.ask(session.host.run({.start = 5, .end = 2, .preroll_ms = 500, .postroll_ms = 500})), ok);
  const auto run = session.rig.taken<PrepareRun>().at(0);
  EXPECT_EQ(run.preroll[0], 400 + 600) << "it comes from above at 2400 steps/s";
  EXPECT_EQ(run.postroll[0], 0 - 600);
  session.run_until(DmcStage::wait);
  ASSERT_EQ(session.ask(session.host.go()), ok);
  session.run_until(DmcStage::jog);
  session.run_until_still();
  EXPECT_EQ(session.pushed(0x0114), 1U);
  EXPECT_EQ(session.position(1), 0) << "frame 1";
}

TEST(DmcSession, AShotInMotionCrossesItsFrameAtConstantSpeed) {
  DmcSession session(eight_motors);
  session.upload(1, {0, 100, 200, 300, 400});
  ASSERT_TRUE(session.device.arm());
  ASSERT_EQ(session.ask(session.host.shoot(3, true, 500, 500)), ok);
  // Half of the frame, 175 to 225 ... in half a second: 100 steps/s, gathered over 50 steps.
  const auto shot = session.rig.taken<PrepareShot>().at(0);
  ASSERT_EQ(shot.motors.size(), 1U);
  EXPECT_EQ(shot.motors[0].start, 175 - 50);
  EXPECT_EQ(shot.motors[0].pieces, (std::vector<ShotPiece>{{1, 0, 100}, {0.5, 100, 100}, {1, 100, 0}}));
  EXPECT_EQ(shot.open_s, 1);
  EXPECT_EQ(shot.close_s, 1.5);
  session.run_until(DmcStage::wait);
  ASSERT_EQ(session.ask(session.host.go()), ok);
  session.run_until(DmcStage::jog);
  EXPECT_EQ(session.position(1), 275);
  EXPECT_EQ(session.ask(session.host.run({.start = 1, .end = 4})), not_in_position);
  // Backwards, and by a way of its own, whose middle half is exposed.
  ASSERT_EQ(session.ask(session.host.shoot(3, false, 500, 500)), ok);
  EXPECT_EQ(session.rig.taken<PrepareShot>().back().motors[0].start, 225 + 50);
  ASSERT_EQ(session.ask(session.host.stop_all(1)), ok);
  session.run_until_still();
  ASSERT_EQ(session.ask(session.host.shoot(3, true, 500, 500, {{1, 1000, 1200}, {9, 0, 0}})), ok);
  EXPECT_EQ(session.rig.taken<PrepareShot>().back().motors[0].start, 1050 - 100);
}

TEST(DmcSession, AShutterThatTurnsTakesItsTimeFromItsAngles) {
  DmcSession session(eight_motors);
  session.upload(1, {0, 100, 200, 300, 400});
  ASSERT_TRUE(session.device.arm());
  ASSERT_EQ(session.ask(session.host.shoot2(3, 500, {90, 270})), ok);
  const auto shot = session.rig.taken<PrepareShot>().at(0);
  EXPECT_EQ(shot.motors.at(0).start, 150);
  const auto& pieces = shot.motors.at(0).pieces;
  ASSERT_EQ(pieces.size(), 5U);
  EXPECT_DOUBLE_EQ(pieces[2].seconds, 0.75) << "six eighths of a second, which is 360 degrees";
  EXPECT_DOUBLE_EQ(pieces[2].from, 800.0 / 7);
  EXPECT_DOUBLE_EQ(shot.open_s, 0.25);
  EXPECT_DOUBLE_EQ(shot.close_s, 0.75);
  session.run_until(DmcStage::wait);
  ASSERT_EQ(session.ask(session.host.go()), ok);
  session.run_until(DmcStage::jog);
  EXPECT_EQ(session.position(1), 250);
  EXPECT_EQ(session.ask(session.host.shoot2(3, 500, {90, 90})), range);
}

TEST(DmcSession, WhatWouldBreakALimitIsAnsweredWithItsCode) {
  DmcSession session(eight_motors);
  session.upload(1, {0, 100, 200, 300, 400});
  ASSERT_TRUE(session.device.arm());
  ASSERT_EQ(session.ask(session.host.limits(1, -50, 400)), ok);
  EXPECT_EQ(session.ask(session.host.move(1, 401)), soft_upper);
  EXPECT_EQ(session.ask(session.host.move(1, -51)), soft_lower);
  ASSERT_EQ(session.ask(session.host.position_frame(1)), ok);
  session.run_until_still();
  EXPECT_EQ(session.ask(session.host.run({.start = 1, .end = 4})), preroll) << "2400 steps/s, half a second";
  EXPECT_EQ(session.ask(session.host.run({.start = 1, .end = 3, .preroll_ms = 0, .postroll_ms = 1000})),
            postroll);
  EXPECT_EQ(session.ask(session.host.run({.start = 1, .end = 4, .preroll_ms = 40, .postroll_ms = 0})), ok);
  ASSERT_EQ(session.ask(session.host.stop_all(1)), ok);
  session.run_until_still();
  EXPECT_EQ(session.ask(session.host.shoot(1, true, 100, 0)), preroll);
  ASSERT_EQ(session.ask(session.host.limits(1, {}, 150)), ok);
  EXPECT_EQ(session.ask(session.host.position_frame(3)), soft_upper);
  EXPECT_EQ(session.ask(session.host.shoot(3, true, 60'000, 0)), soft_upper);
  // What the rig itself says is told as it says it.
  const std::vector<std::pair<RigAnswer, unsigned>> answers{{RigAnswer::hard_upper, 0x22},
                                                            {RigAnswer::soft_lower, soft_lower},
                                                            {RigAnswer::range, range},
                                                            {RigAnswer::moving, moving}};
  for (const auto& [answer, code] : answers) {
    session.rig.judge = [said = answer](const RigOrder& /*order*/) { return said; };
    EXPECT_EQ(session.ask(session.host.move(1, 0)), code);
  }
}

TEST(DmcSession, ErrorsAreThoseOfTheDescription) {
  DmcSession session(eight_motors);
  ASSERT_TRUE(session.device.arm());
  for (const unsigned type : {0x0020U, 0x0102U, 0x003AU, 0x0114U, 0x0200U, 0x0201U, 0x0207U, 0x0300U}) {
    EXPECT_EQ(session.ask(session.host.ask(type, oracle::DmcBytes(40))), unsupported) << type;
  }
  for (const unsigned motor : {0U, 9U, 255U}) {
    EXPECT_EQ(session.ask(session.host.move(motor, 1)), range);
    EXPECT_EQ(session.ask(session.host.stop(motor)), range);
    EXPECT_EQ(session.ask(session.host.jog(motor, 100, 1)), range);
    EXPECT_EQ(session.ask(session.host.reset(motor, 1)), range);
    EXPECT_EQ(session.ask(session.host.configure(motor, 1)), range);
    EXPECT_EQ(session.ask(session.host.speed(motor, 100, 100)), range);
    EXPECT_EQ(session.ask(session.host.limits(motor, 0, 1)), range);
  }
  EXPECT_EQ(session.ask(session.host.ask(0x0031, oracle::DmcBytes(4))), general) << "too short";
  EXPECT_EQ(session.ask(session.host.ask(0x0035, oracle::DmcBytes(6))), general) << "too long";
  EXPECT_EQ(session.ask(session.host.jog(1, 0, 1)), range);
  EXPECT_EQ(session.ask(session.host.jog(1, 10'001, 1)), range);
  EXPECT_EQ(session.ask(session.host.configure(1, 0x08 | 0x10)), ok);
  EXPECT_EQ(session.ask(session.host.configure(8, 0x10)), range) << "no motor is behind the last";
  // Moves that are not there, too large, or with holes.
  EXPECT_EQ(session.ask(session.host.position_frame(1)), general);
  EXPECT_EQ(session.ask(session.host.run({})), general);
  EXPECT_EQ(session.ask(session.host.shoot(1, true, 100, 0)), general);
  EXPECT_EQ(session.ask(session.host.upload_axis(1, 0, true, {1})), general) << "nothing was begun";
  EXPECT_EQ(session.ask(session.host.upload_end()), general);
  EXPECT_EQ(session.ask(session.host.upload_begin(1, 10'001)), range);
  EXPECT_EQ(session.ask(session.host.upload_begin(2, 1)), range);
  EXPECT_EQ(session.ask(session.host.upload_begin(INT32_MIN, INT32_MAX)), range);
  ASSERT_EQ(session.ask(session.host.upload_begin(1, 5)), ok);
  EXPECT_EQ(session.ask(session.host.upload_axis(9, 0, true, {1})), range);
  EXPECT_EQ(session.ask(session.host.upload_axis(1, 5, true, {1})), range);
  EXPECT_EQ(session.ask(session.host.upload_axis(1, 3, false, {1, 2, 3})), range);
  EXPECT_EQ(session.ask(session.host.upload_axis(1, 3, false, {4, 5})), ok);
  EXPECT_EQ(session.ask(session.host.upload_end()), general) << "frames 1 to 3 are missing";
  EXPECT_EQ(session.ask(session.host.go()), not_in_position);
  EXPECT_FALSE(session.rig.was_moved());
}

TEST(DmcSession, NothingMovesWithoutConsent) {
  DmcSession session(eight_motors);
  session.upload(1, {0, 100, 200});
  EXPECT_EQ(session.ask(session.host.move(1, 10)), general);
  EXPECT_EQ(session.ask(session.host.jog(1, 100, 10)), general);
  EXPECT_EQ(session.ask(session.host.position_frame(1)), general);
  EXPECT_EQ(session.ask(session.host.shoot(2, true, 100, 0)), general);
  EXPECT_FALSE(session.rig.was_moved());
  const auto notices = session.device.take_notices();
  EXPECT_EQ(std::count_if(notices.begin(), notices.end(),
                          [](const PortNotice& notice) {
                            return notice.kind == PortNotice::Kind::consent_missing &&
                                   !text_of(notice).empty();
                          }),
            4);
}

TEST(DmcSession, WhoIsUnpluggedLeavesARigAtRestAndNothingBehind) {
  DmcSession session(eight_motors);
  session.upload(1, {0, 100, 200});
  ASSERT_TRUE(session.device.arm());
  ASSERT_EQ(session.ask(session.host.move(1, 100'000)), ok);
  session.tick();
  EXPECT_FALSE(session.device.connect(session.now_ns)) << "a second host does not get in";
  EXPECT_TRUE(session.device.is_armed());
  session.device.hear(std::vector<std::uint8_t>{'D', 'F', 1}, session.now_ns);
  session.device.disconnect(session.now_ns);
  EXPECT_EQ(session.rig.taken<StopAll>().size(), 1U);
  EXPECT_TRUE(std::holds_alternative<ForgetHost>(session.rig.orders.back()));
  EXPECT_FALSE(session.device.arm());
  session.run_for(1);
  session.heard.clear();
  ASSERT_TRUE(session.device.connect(session.now_ns));
  session.pass();
  EXPECT_EQ(session.pushed(0x0001), 1U);
  EXPECT_EQ(session.ask(session.host.position_frame(1)), general) << "the move is gone";
  EXPECT_EQ(session.ask(session.host.move(1, 0)), general) << "and the consent";
}

TEST(DmcSession, ARigThatStopsByItselfTellsTheHost) {
  DmcSession session(eight_motors);
  ASSERT_TRUE(session.device.arm());
  ASSERT_EQ(session.ask(session.host.move(3, 100'000)), ok);
  session.tick();
  session.device.tell(HardStop{.reason = HardStopReason::upper, .motor = 3}, session.now_ns);
  session.pass();
  ASSERT_EQ(session.heard.back().type, 0x003AU);
  EXPECT_EQ(session.heard.back().payload, (oracle::DmcBytes{1, 3}));
  EXPECT_FALSE(session.device.is_armed());
  EXPECT_EQ(session.ask(session.host.move(3, 0)), hard_lower);
  session.device.stop(session.now_ns);
  session.pass();
  EXPECT_EQ(session.heard.back().payload, (oracle::DmcBytes{0}));
}

TEST(DmcSession, ALiveMotorMovesDuringARunAndTheStartSwitchBeginsIt) {
  DmcSession session(eight_motors);
  session.upload(1, std::vector<std::int32_t>(50, 500));
  ASSERT_EQ(session.ask(session.host.configure(2, 0x09)), ok);
  ASSERT_TRUE(session.device.arm());
  ASSERT_EQ(session.ask(session.host.position_frame(1)), ok);
  session.run_until_still();
  ASSERT_EQ(session.ask(session.host.run({.start = 1, .end = 40})), ok);
  session.run_until(DmcStage::wait);
  session.device.tell(StartSwitch{}, session.now_ns);
  session.pass();
  EXPECT_EQ(session.pushed(0x0113), 1U);
  EXPECT_EQ(session.ask(session.host.jog(2, 10'000, 500)), ok);
  EXPECT_EQ(session.ask(session.host.jog(1, 10'000, 500)), moving);
  EXPECT_EQ(session.ask(session.host.stop(2)), ok);
  EXPECT_EQ(session.device.stage(), DmcStage::shoot);
  // A motor of the move does not stop alone.
  EXPECT_EQ(session.ask(session.host.stop(1)), ok);
  EXPECT_EQ(session.rig.taken<StopAll>().size(), 1U);
  EXPECT_EQ(session.device.stage(), DmcStage::jog);
}

TEST(DmcSession, AJogEndsAtTheLimitOfTheHostAndDoesNotBeginThere) {
  DmcSession session(eight_motors);
  ASSERT_TRUE(session.device.arm());
  ASSERT_EQ(session.ask(session.host.limits(1, -300, 500)), ok);
  ASSERT_EQ(session.ask(session.host.jog(1, 10'000, INT32_MAX)), ok);
  session.run_for(0.4);
  EXPECT_EQ(session.position(1), 500);
  EXPECT_GE(session.pushed(0x0034), 2U) << "positions on the way, and at rest";
  EXPECT_EQ(session.ask(session.host.jog(1, 10'000, INT32_MAX)), soft_upper);
  ASSERT_EQ(session.ask(session.host.jog(1, 10'000, INT32_MIN)), ok);
  session.run_for(0.4);
  EXPECT_EQ(session.position(1), -300);
  EXPECT_EQ(session.ask(session.host.jog(1, 10'000, INT32_MIN)), soft_lower);
}

TEST(DmcSession, PositionsComeTenTimesASecondWhileSomethingMoves) {
  DmcSession session(eight_motors);
  ASSERT_TRUE(session.device.arm());
  ASSERT_EQ(session.ask(session.host.move(1, 1'000'000)), ok);
  session.heard.clear();
  session.run_for(2);
  EXPECT_NEAR(static_cast<double>(session.pushed(0x0034)), 20, 1);
}

TEST(DmcSession, ASpeedIsTakenAsTheMakersDeviceTakesIt) {
  DmcSession session(eight_motors);
  ASSERT_EQ(session.ask(session.host.speed(1, 3, 0)), ok);
  const MotorSettings slow = session.rig.taken<SetMotor>().back().settings;
  EXPECT_EQ(slow.max_velocity, 10U);
  EXPECT_EQ(slow.max_acceleration, 5U) << "none is given: half of the velocity";
  EXPECT_EQ(session.device.take_notices().back().kind, PortNotice::Kind::speed_raised);
}

TEST(DmcSession, TriggersLeaveOtherOutputsAlone) {
  DmcSession session(eight_motors);
  ASSERT_EQ(session.ask(session.host.configure(1, 0x01)), ok);
  ASSERT_EQ(session.ask(session.host.upload_begin(1, 5)), ok);
  ASSERT_EQ(session.ask(session.host.upload_axis(1, 0, true, {0})), ok);
  ASSERT_EQ(session.ask(session.host.upload_triggers(1, {{1, 1}})), ok);
  EXPECT_EQ(session.ask(session.host.upload_triggers(1, {{5, 1}})), range);
  ASSERT_EQ(session.ask(session.host.upload_end()), ok);
  ASSERT_EQ(session.ask(session.host.ask(0x0021, {2, 0, 0, 0})), ok);
  ASSERT_TRUE(session.device.arm());
  ASSERT_EQ(session.ask(session.host.position_frame(1)), ok);
  session.run_until_still();
  ASSERT_EQ(session.ask(session.host.run({.start = 1, .end = 4, .is_synced = true})), ok);
  session.run_until(DmcStage::wait);
  ASSERT_EQ(session.ask(session.host.go()), ok);
  session.run_until(DmcStage::jog);
  EXPECT_EQ(session.rig.taken<SetOutputs>(), (std::vector<SetOutputs>{{2}, {3}, {2}}));
}

TEST(DmcSession, InputsArePushedAndAnswered) {
  DmcSession session(eight_motors);
  session.rig.set_inputs(0x3);
  session.tick();
  EXPECT_EQ(session.pushed(0x0022), 1U);
  EXPECT_EQ(session.ask(session.host.ask(0x0022)), 0U);
  EXPECT_EQ(session.host.data()->number(0, 4), 1U) << "there is one input";
  EXPECT_EQ(session.ask(session.host.ask(0x0021, {3, 0, 0, 0})), ok);
  EXPECT_EQ(session.ask(session.host.ask(0x0021, {4, 0, 0, 0})), range);
  session.device.disconnect(session.now_ns);
  EXPECT_EQ(session.rig.taken<SetOutputs>(), (std::vector<SetOutputs>{{3}, {0}}))
      << "off, where nobody is left";
}

}  // namespace dmc_session_test
}  // namespace inbetween
