// The motion loop over CiA 402 drives on a simulated bus: what each fault does to the whole rig
// (docs/faults.md).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "tests/support/can_crane.hpp"
#include "tests/support/drive_frames.hpp"

namespace inbetween {
namespace can_loop_test {

using State = SupervisorState;

using Crane = CanCrane;
constexpr std::int64_t tick_ns = CanCrane::tick_ns;
constexpr double counts_per_unit = CanCrane::counts_per_unit;

void add(SimulatedCia402Drive& drive, DriveTrouble::Kind kind, std::int64_t at_ns, std::int32_t value = 0) {
  drive.add_trouble({.kind = kind, .at_ns = at_ns, .value = value});
}

TEST(CanLoop, PlaysAMoveAndTheDrivesOwnRecordIsThePlan) {
  Crane crane;
  crane.start();
  const std::size_t before = crane.drives[0].record().applied.size();
  ASSERT_TRUE(crane.tick_until(State::ready));
  crane.tick(100);
  const std::int64_t last = last_tick(96, {24, 1}, 250);
  std::array<double, 2> expected{};
  for (std::size_t d = 0; d < 2; ++d) {
    const auto& applied = crane.drives[d].record().applied;
    ASSERT_GT(applied.size(), before + static_cast<std::size_t>(last) + 2);
    for (std::int64_t tick = 1; tick <= last; ++tick) {
      crane.plan.motion().positions(frame_time_of_tick(tick, {24, 1}, 250), expected);
      // A target acts one tick after it was given, and the bus is heard in the tick after.
      const double target = applied[before + static_cast<std::size_t>(tick) + 1].target;
      ASSERT_NEAR(target, expected[d] * counts_per_unit, 0.5001) << "axis " << d << ", tick " << tick;
    }
  }
  EXPECT_NEAR(crane.drives[0].position(), -5'000, 1.5);
  EXPECT_NEAR(crane.drives[1].position(), 260'000, 1.5);
}

// docs/faults.md 13
TEST(CanLoop, AFullQueueIsCountedAndSeveralInARowAreAControlledStop) {
  Crane crane;
  crane.start();
  crane.tick(200);
  crane.link.set_room(1);
  crane.tick();
  crane.link.set_room(64);
  crane.tick(20);
  EXPECT_EQ(crane.loop().state(), State::running) << "one is counted";
  EXPECT_GT(crane.port.front().counters(0).unsent, 0U);
  crane.link.set_room(1);
  crane.tick(4);
  EXPECT_EQ(crane.loop().state(), State::stopping);
}

// docs/faults.md 15
TEST(CanLoop, FramesThatWaitedBeforeAreThrownAwayBeforeTheDrivesAreSwitchedOn) {
  Crane crane;
  const can::Frame stale =
      can::feedback_frame(*can::NodeId::make(1), {.statusword = 0x1237, .actual = 77'000});
  for (int i = 0; i < 500; ++i) crane.link.put_stale(stale);
  crane.start();
  EXPECT_GE(crane.port.front().counters(0).drained, 400U);
  EXPECT_EQ(crane.loop().state(), State::running);
}

// docs/faults.md 16
TEST(CanLoop, ALinkThatGoesDownCeasesSetpointsAndDoesNotReconnectAndGo) {
  Crane crane;
  crane.start();
  crane.tick(400);
  crane.link.set_up(false);
  crane.expect_ceased_setpoints();
  crane.link.set_up(true);
  crane.tick(200);
  EXPECT_EQ(crane.loop().state(), State::cut_off);
  EXPECT_FALSE(crane.loop().post(SupervisorEvent::start));
  ASSERT_TRUE(crane.loop().post(SupervisorEvent::acknowledge));
  ASSERT_TRUE(crane.tick_until(State::ready)) << name_of(crane.loop().state());
  EXPECT_FALSE(crane.loop().start(Direction::forward)) << "it is not where the playhead is";
}

// docs/faults.md 17
TEST(CanLoop, AForeignSenderOnOurIdentifiersIsAControlledStop) {
  Crane crane;
  crane.start();
  crane.tick(400);
  crane.wire.inject(can::command_frame(*can::NodeId::make(2), {.controlword = 0x000F, .target = 0}));
  crane.expect_controlled_stop(State::latched);
}

// docs/faults.md 18
TEST(CanLoop, AFloodOfFramesIsBoundedAndCountedAndTheMoveGoesOn) {
  Crane crane;
  crane.start();
  const can::Frame noise{.id = 0x123, .length = 8};
  for (int tick = 0; tick < 100; ++tick) {
    for (int i = 0; i < 40; ++i) crane.wire.inject(noise);
    crane.tick();
  }
  EXPECT_EQ(crane.loop().state(), State::running);
  for (int i = 0; i < 100; ++i) crane.wire.inject(noise);
  crane.tick();
  EXPECT_GT(crane.port.front().counters(0).floods, 0U);
}

// docs/faults.md 20
TEST(CanLoop, LostFramesOfOneAxisStopAllOnThePath) {
  Crane crane;
  crane.start();
  crane.tick(400);
  add(crane.drives[1], DriveTrouble::Kind::lose_feedback, crane.now_ns);
  crane.expect_controlled_stop(State::faulted);
}

// docs/faults.md 21, 23, 24, 25, 26. What each of them is found by is DriveOfNode5's to show; the loop
// answers all alike.
TEST(CanLoop, WhateverIsWrongWithADriveStopsAllOnThePath) {
  using enum DriveTrouble::Kind;
  for (const auto kind : {lose_heartbeat, emergency, reboot, stick, ignore_target, wrong_mode}) {
    SCOPED_TRACE(static_cast<int>(kind));
    Crane crane;
    crane.start();
    crane.tick(400);
    add(crane.drives[1], kind, crane.now_ns + tick_ns, kind == emergency ? 0x2310 : 1);
    ASSERT_TRUE(crane.tick_until(State::stopping, 500)) << name_of(crane.loop().state());
    while (crane.loop().state() == State::stopping) {
      ASSERT_TRUE(crane.is_on_path());
      crane.tick();
    }
    crane.tick(100);
    EXPECT_NE(crane.loop().state(), State::running);
    EXPECT_FALSE(crane.loop().post(SupervisorEvent::start));
  }
}

// docs/faults.md 28
TEST(CanLoop, AnEmergencyStopIsNotUndoneByItsRelease) {
  Crane crane;
  crane.start();
  crane.tick(400);
  crane.lines.is_pressed = true;
  crane.expect_ceased_setpoints();
  add(crane.drives[0], DriveTrouble::Kind::move_by_hand, crane.now_ns, 5'000);
  crane.tick(10);
  crane.lines.is_pressed = false;
  crane.tick(100);
  EXPECT_EQ(crane.loop().state(), State::cut_off);
  ASSERT_TRUE(crane.loop().post(SupervisorEvent::acknowledge));
  ASSERT_TRUE(crane.tick_until(State::ready)) << name_of(crane.loop().state());
  EXPECT_NEAR(crane.room.targets()[0] * counts_per_unit, crane.drives[0].position(), 3)
      << "positions were read again";
  EXPECT_FALSE(crane.loop().start(Direction::forward)) << "it has been moved";
  crane.tick(100);
  EXPECT_NEAR(crane.drives[0].velocity(), 0, 1);
}

// docs/faults.md 29
TEST(CanLoop, WhenTheHostFallsSilentTheDrivesStopByThemselves) {
  Crane crane;
  crane.start();
  crane.tick(400);
  ASSERT_GT(std::fabs(crane.drives[1].velocity()), 1000);
  for (int i = 0; i < 100; ++i) {
    crane.now_ns += tick_ns;
    static_cast<void>(crane.wire.run(crane.now_ns));
  }
  for (const SimulatedCia402Drive& drive : crane.drives) EXPECT_NEAR(drive.velocity(), 0, 1);
}

TEST(CanLoop, ADriveThatNeverBootsIsNamedAndNothingIsSwitchedOn) {
  Crane crane;
  crane.wire.set_fate(
      [](const can::Frame& frame, std::int64_t) { return FrameFate{.copies = frame.id == 0x702 ? 0 : 1}; });
  ASSERT_TRUE(crane.loop().post(SupervisorEvent::arm));
  ASSERT_TRUE(crane.tick_until(State::faulted)) << name_of(crane.loop().state());
  EXPECT_EQ(crane.hosts[1].first_finding(), can::DriveFinding::never_booted);
  EXPECT_NE(crane.drives[0].state(), can::Cia402State::operation_enabled);
}

// A drive that counts from wherever it was switched on: where its axis stands is known from before.
TEST(CanLoop, AnAxisStandsWhereItIsKnownToWhateverItsDriveCounts) {
  Crane crane(-777);
  ASSERT_NO_FATAL_FAILURE(crane.start());
  EXPECT_EQ(crane.room.targets()[0], 10);
  EXPECT_NEAR(crane.drives[0].position(), -777, 1) << "it has not moved to where its count would be 10'000";
  ASSERT_TRUE(crane.tick_until(State::ready, 2000));
  crane.tick(50);
  const double end = crane.room.targets()[0];
  EXPECT_NEAR(crane.drives[0].position(), -777 + (end - 10) * counts_per_unit, 2);
}

}  // namespace can_loop_test
}  // namespace inbetween
