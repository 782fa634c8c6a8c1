// The host's drive against simulated drives on a simulated bus: set up, switched on, following, stopped; and
// every fault of a drive (docs/faults.md) as the drive's finding.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "inbetween/can/cia402_drive.hpp"
#include "inbetween/can/emergency.hpp"
#include "tests/support/simulated_can_rig.hpp"

namespace inbetween {
namespace can_simulated_drive_test {

using can::Cia402State;
using can::DriveFinding;
using can::DrivePhase;
using Kind = DriveTrouble::Kind;

constexpr std::int64_t ms = 1'000'000;

class CanRig : public testing::Test {
 protected:
  std::unique_ptr<SimulatedCanRig> rig = std::make_unique<SimulatedCanRig>(3);
  std::vector<std::int32_t> targets{1000, 2000, 3000};

  void bring_to_following() {
    const bool is_following = rig->bring_to_following();
    for (const can::Cia402Drive& host : rig->hosts) {
      const auto finding = host.first_finding();
      ASSERT_TRUE(is_following) << static_cast<int>(host.phase()) << ", "
                                << (finding ? words_of(*finding).what : "") << ", object " << std::hex
                                << host.refusal().object.index;
    }
  }
  /// All axes at 50 counts a tick.
  void move(int ticks) {
    for (int i = 0; i < ticks; ++i) {
      for (std::int32_t& target : targets) target += 50;
      rig->tick(targets);
    }
  }
  void hold(int ticks) {
    for (int i = 0; i < ticks; ++i) rig->tick(targets);
  }
  /// In motion, from now on.
  void trouble(std::size_t axis, DriveTrouble trouble) {
    trouble.at_ns = rig->now_ns;
    rig->drive(axis).add_trouble(trouble);
  }
  /// The ticks in motion until a drive has it; the others have nothing.
  int ticks_until(std::size_t axis, DriveFinding finding, int most) {
    int ticks = 0;
    while (!rig->host_of(axis).findings().has(finding) && ticks < most) {
      move(1);
      ++ticks;
    }
    EXPECT_TRUE(rig->host_of(axis).findings().has(finding)) << words_of(finding).what;
    for (std::size_t other = 0; other < rig->hosts.size(); ++other) {
      if (other == axis) continue;
      EXPECT_TRUE(rig->host_of(other).findings().empty()) << other;
      EXPECT_EQ(rig->host_of(other).phase(), DrivePhase::following) << other;
    }
    return ticks;
  }
  [[nodiscard]] std::optional<DriveFinding> finding_of(std::size_t axis) {
    return rig->host_of(axis).first_finding();
  }
  void expect_refused(std::size_t axis, DriveFinding finding) {
    rig->connect();
    EXPECT_TRUE(rig->tick_until([&] { return rig->host_of(axis).phase() == DrivePhase::refused; }));
    ASSERT_TRUE(finding_of(axis));
    EXPECT_EQ(*finding_of(axis), finding) << words_of(*finding_of(axis)).what;
    EXPECT_EQ(words_of(finding).reaction, can::DriveReaction::refuse);
    EXPECT_FALSE(rig->host_of(axis).enable(rig->now_ns));
  }
};

TEST_F(CanRig, DrivesAreSwitchedOnWhereTheyAre) {
  bring_to_following();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(rig->drive(axis).state(), Cia402State::operation_enabled);
    EXPECT_EQ(rig->host_of(axis).target(), targets[axis]);
    EXPECT_NEAR(rig->drive(axis).position(), targets[axis], 1);
  }
}

TEST_F(CanRig, TheDrivesOwnRecordIsWhatWasSentATickBefore) {
  bring_to_following();
  hold(2);
  std::vector<std::vector<std::int32_t>> sent(3);
  std::vector<std::size_t> recorded;
  for (std::size_t axis = 0; axis < 3; ++axis) recorded.push_back(rig->drive(axis).record().applied.size());
  const std::int64_t begin = rig->now_ns;
  for (int i = 0; i < 500; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      targets[axis] +=
          static_cast<std::int32_t>(std::lround(400 * std::sin(0.02 * i + static_cast<double>(axis))));
      sent[axis].push_back(targets[axis]);
    }
    rig->tick(targets);
  }
  rig->tick(targets);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto& applied = rig->drive(axis).record().applied;
    ASSERT_EQ(applied.size(), recorded[axis] + 501);
    for (std::size_t i = 0; i < 500; ++i) {
      ASSERT_EQ(applied[recorded[axis] + 1 + i].target, sent[axis][i]) << "axis " << axis << ", tick " << i;
      ASSERT_EQ(applied[recorded[axis] + 1 + i].at_ns, begin + static_cast<std::int64_t>(i + 2) * 4 * ms);
    }
    EXPECT_TRUE(rig->host_of(axis).findings().empty());
    EXPECT_EQ(rig->host_of(axis).counters().missed, 0U);
  }
}

TEST_F(CanRig, TheMotorsFollowARamp) {
  bring_to_following();
  move(250);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(rig->drive(axis).position(), targets[axis] - 50, 60);
    EXPECT_NEAR(rig->drive(axis).velocity(), 50 * 250, 200);
  }
  hold(100);
  for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_NEAR(rig->drive(axis).position(), targets[axis], 2);
}

TEST_F(CanRig, ACounterInSyncWorksAsWell) {
  can::Cia402Setup setup = SimulatedCanRig::default_setup();
  setup.sync_overflow = 10;
  rig = std::make_unique<SimulatedCanRig>(3, setup);
  bring_to_following();
  move(50);
  for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_TRUE(rig->host_of(axis).findings().empty());
}

TEST_F(CanRig, DrivesAreSwitchedOff) {
  bring_to_following();
  hold(10);
  for (can::Cia402Drive& host : rig->hosts) host.disable(rig->now_ns);
  for (int i = 0; i < 20; ++i) rig->tick();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(rig->drive(axis).state(), Cia402State::switch_on_disabled);
    EXPECT_TRUE(rig->host_of(axis).findings().empty());
  }
}

TEST_F(CanRig, AQuickStopIsByTheDrivesRampAndNothingMovesWhenItIsSwitchedOnAgain) {
  bring_to_following();
  move(250);
  for (can::Cia402Drive& host : rig->hosts) host.quick_stop(rig->now_ns);
  const double from = rig->drive(0).position();
  hold(100);
  EXPECT_EQ(rig->drive(0).state(), Cia402State::quick_stop_active);
  EXPECT_NEAR(rig->drive(0).velocity(), 0, 1);
  // 12500 counts/s by 500000 counts/s^2, and the ticks until the order acts.
  EXPECT_NEAR(rig->drive(0).position() - from, 12500.0 * 12500 / (2 * 500000) + 12500 * 0.008, 60);
  const double rest = rig->drive(0).position();
  ASSERT_TRUE(rig->enable());
  ASSERT_TRUE(rig->tick_until([&] { return rig->all_are(DrivePhase::following); }));
  for (int i = 0; i < 10; ++i) rig->tick();
  EXPECT_NEAR(rig->drive(0).position(), rest, 1) << "the old target is not resumed";
}

TEST_F(CanRig, AFaultIsResetAndTheDriveSwitchedOnAgain) {
  bring_to_following();
  move(100);
  trouble(1, {.kind = Kind::emergency, .for_ns = 400 * ms, .value = 0x2310});
  ticks_until(1, DriveFinding::drive_fault, 5);
  hold(110);
  EXPECT_EQ(rig->drive(1).state(), Cia402State::fault);
  EXPECT_FALSE(rig->host_of(1).enable(rig->now_ns)) << "nobody has seen it yet";
  const double rest = rig->drive(1).position();
  rig->host_of(1).acknowledge();
  ASSERT_TRUE(rig->host_of(1).enable(rig->now_ns));
  ASSERT_TRUE(rig->tick_until([&] { return rig->all_are(DrivePhase::following); }, targets));
  EXPECT_NEAR(rig->drive(1).position(), rest, 1);
  EXPECT_EQ(rig->host_of(1).last_emergency().code, 0x2310);
}

TEST_F(CanRig, AFaultWhoseCauseLastsCannotBeReset) {
  bring_to_following();
  trouble(1, {.kind = Kind::emergency, .value = 0x4210});
  ticks_until(1, DriveFinding::drive_fault, 5);
  rig->host_of(1).acknowledge();
  ASSERT_TRUE(rig->host_of(1).enable(rig->now_ns));
  EXPECT_TRUE(
      rig->tick_until([&] { return rig->host_of(1).findings().has(DriveFinding::fault_stays); }, targets));
}

TEST_F(CanRig, Fault13AFewMissingSetpointsAreRiddenOutAndMissingFeedbackIsCounted) {
  bring_to_following();
  move(50);
  int left = 2;
  rig->wire.set_fate([&](const can::Frame& frame, std::int64_t) {
    const bool is_lost = frame.id == 0x181 && left > 0;
    if (is_lost) --left;
    return FrameFate{.copies = is_lost ? 0 : 1};
  });
  move(50);
  EXPECT_EQ(rig->host_of(0).counters().missed, 2U);
  EXPECT_TRUE(rig->host_of(0).findings().empty());
  left = 3;
  EXPECT_LE(ticks_until(0, DriveFinding::feedback_missing, 10), 5);
}

TEST_F(CanRig, Fault17AForeignSenderOnOurIdentifiers) {
  bring_to_following();
  move(50);
  rig->wire.inject({.id = 0x202, .length = 6, .data = {0x0F, 0, 0, 0, 0, 0}});
  ticks_until(1, DriveFinding::foreign_sender, 3);
  EXPECT_EQ(words_of(DriveFinding::foreign_sender).reaction, can::DriveReaction::controlled_stop);
  rig->wire.inject({.id = 0x000, .length = 2, .data = {0x80, 0x00}});
  move(2);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_TRUE(rig->host_of(axis).findings().has(DriveFinding::foreign_sender)) << axis;
  }
}

TEST_F(CanRig, Fault17AForeignSenderAtBootKeepsTheDrivesOff) {
  rig->connect();
  ASSERT_TRUE(rig->tick_until([&] { return rig->all_are(DrivePhase::idle); }));
  rig->wire.inject({.id = 0x080});
  rig->tick();
  EXPECT_FALSE(rig->enable());
}

TEST_F(CanRig, Fault19DuplicateAndShortFramesAreDiscardedCountedAndThenAFinding) {
  bring_to_following();
  move(50);
  const int before = static_cast<int>(rig->host_of(2).counters().duplicates);
  rig->wire.set_fate(
      [](const can::Frame& frame, std::int64_t) { return FrameFate{.copies = frame.id == 0x183 ? 2 : 1}; });
  const int ticks = ticks_until(2, DriveFinding::bad_frames, 50);
  EXPECT_GE(ticks, 9);
  EXPECT_LE(ticks, 11);
  EXPECT_GT(static_cast<int>(rig->host_of(2).counters().duplicates), before + 8);
  EXPECT_EQ(rig->host_of(2).phase(), DrivePhase::following);
}

TEST_F(CanRig, Fault19FramesThatComeATickLateAreNeitherLostNorDuplicates) {
  bring_to_following();
  rig->wire.set_fate([](const can::Frame& frame, std::int64_t now_ns) {
    return FrameFate{.delay_ns = frame.id == 0x182 && now_ns % (80 * ms) < 4 * ms ? 4 * ms : 0};
  });
  move(250);
  EXPECT_TRUE(rig->host_of(1).findings().empty());
  EXPECT_EQ(rig->host_of(1).counters().duplicates, 0U);
}

TEST_F(CanRig, Fault20FramesOfOneAxisAreLost) {
  bring_to_following();
  move(50);
  trouble(1, {.kind = Kind::lose_feedback});
  EXPECT_LE(ticks_until(1, DriveFinding::feedback_missing, 10), 5);
  EXPECT_EQ(rig->host_of(1).phase(), DrivePhase::following) << "it slows down with the others";
}

TEST_F(CanRig, Fault21AHeartbeatIsLost) {
  bring_to_following();
  move(50);
  trouble(1, {.kind = Kind::lose_heartbeat});
  const int ticks = ticks_until(1, DriveFinding::heartbeat_lost, 100);
  EXPECT_LE(ticks * 4, 154);
  EXPECT_GE(ticks * 4, 100);
}

TEST_F(CanRig, Fault22TheFirstHeartbeatNeverComes) {
  rig->drive(1).add_trouble({.kind = Kind::lose_heartbeat});
  expect_refused(1, DriveFinding::first_heartbeat_missing);
}

TEST_F(CanRig, Fault22ADriveThatIsNotThereNeverBoots) {
  rig->wire.set_fate(
      [](const can::Frame& frame, std::int64_t) { return FrameFate{.copies = frame.id == 0x702 ? 0 : 1}; });
  expect_refused(1, DriveFinding::never_booted);
}

TEST_F(CanRig, Fault23AnEmergencyInMotionHasItsCodeInWords) {
  bring_to_following();
  move(50);
  trouble(1, {.kind = Kind::emergency, .value = 0x4210});
  EXPECT_LE(ticks_until(1, DriveFinding::emergency, 5), 2);
  EXPECT_STREQ(can::words_of_emergency(rig->host_of(1).last_emergency().code), "the drive is too hot");
  move(30);
  EXPECT_TRUE(rig->host_of(1).findings().has(DriveFinding::drive_fault));
  EXPECT_EQ(rig->drive(1).state(), Cia402State::fault);
  EXPECT_EQ(rig->host_of(1).phase(), DrivePhase::idle);
}

TEST_F(CanRig, Fault24ADriveThatStartsAnewHasLostItsReference) {
  bring_to_following();
  move(50);
  trouble(1, {.kind = Kind::reboot});
  ticks_until(1, DriveFinding::unexpected_boot, 30);
  EXPECT_TRUE(words_of(DriveFinding::unexpected_boot).loses_reference);
  EXPECT_EQ(rig->host_of(1).phase(), DrivePhase::gone);
  rig->host_of(1).acknowledge();
  EXPECT_FALSE(rig->host_of(1).enable(rig->now_ns));
  ASSERT_TRUE(rig->host_of(1).connect(rig->now_ns));
  EXPECT_TRUE(rig->tick_until([&] { return rig->host_of(1).phase() == DrivePhase::idle; }, targets));
  // It calls the place 0 where it was when it started anew, and rolled on from there.
  EXPECT_LT(rig->host_of(1).feedback().actual, 1000);
  EXPECT_GT(rig->drive(1).position(), 4000);
}

TEST_F(CanRig, Fault25AFollowingErrorIsFoundByTheDriveAndStopsIt) {
  bring_to_following();
  move(50);
  trouble(1, {.kind = Kind::stick});
  const int ticks = ticks_until(1, DriveFinding::emergency, 200);
  EXPECT_GE(ticks, 2000 / 50);
  EXPECT_EQ(rig->host_of(1).last_emergency().code, 0x8611);
  move(30);
  EXPECT_TRUE(rig->host_of(1).findings().has(DriveFinding::drive_fault));
  EXPECT_EQ(rig->drive(1).state(), Cia402State::fault);
}

TEST_F(CanRig, Fault25ADisabledWindowIsRefused) {
  rig->drive(1).add_object({.index = 0x6065}, {.value = 0xFFFFFFFF});
  expect_refused(1, DriveFinding::window_disabled);
}

TEST_F(CanRig, Fault26AnotherModeOfOperation) {
  bring_to_following();
  move(50);
  trouble(1, {.kind = Kind::wrong_mode, .value = 1});
  EXPECT_LE(ticks_until(1, DriveFinding::wrong_mode, 5), 2);
}

TEST_F(CanRig, Fault26ATargetThatIsIgnored) {
  bring_to_following();
  move(50);
  trouble(1, {.kind = Kind::ignore_target});
  const int ticks = ticks_until(1, DriveFinding::target_ignored, 20);
  EXPECT_GE(ticks, 6);
  EXPECT_LE(ticks, 8);
}

TEST_F(CanRig, Fault27AFirstTargetThatIsNotWhereTheAxisIsIsNotSent) {
  bring_to_following();
  targets[1] += 101;
  hold(10);
  EXPECT_EQ(finding_of(1), DriveFinding::moved_while_enabling);
  EXPECT_NEAR(rig->drive(1).position(), 2000, 1);
  EXPECT_TRUE(rig->host_of(0).findings().empty());
}

TEST_F(CanRig, Fault29WithoutAWatchdogTheDriveIsRefused) {
  rig->drive(1).remove_object({.index = 0x1016, .sub = 1});
  rig->drive(1).change_access({.index = 0x1400, .sub = 5}, ObjectDictionary::Access::write_ignored);
  expect_refused(1, DriveFinding::watchdog_unset);
}

TEST_F(CanRig, AnEmergencyOfTheLastRunThatIsRepeatedAtTheStartIsNoReasonToStayOff) {
  rig->connect();
  ASSERT_TRUE(rig->tick_until([&] { return rig->host_of(1).phase() == DrivePhase::starting; }));
  rig->wire.inject(can::emergency_frame(rig->host_of(1).node(), {.code = 0x8130, .error_register = 0x11}));
  ASSERT_TRUE(rig->tick_until([&] { return rig->all_are(DrivePhase::idle); }));
  EXPECT_EQ(rig->host_of(1).last_emergency().code, 0x8130);
  ASSERT_TRUE(rig->enable());
  EXPECT_TRUE(rig->tick_until([&] { return rig->all_are(DrivePhase::following); }));
}

TEST_F(CanRig, ADriveThatRefusesItsRampIsRefusedWithWhatItSays) {
  rig->drive(1).add_object({.index = 0x605E}, {.size = 2, .access = ObjectDictionary::Access::write_refused});
  expect_refused(1, DriveFinding::would_coast);
  EXPECT_EQ(rig->host_of(1).refusal().found, 0U);
  EXPECT_EQ(rig->host_of(1).refusal().abort_code, can::abort_device_state);
}

TEST_F(CanRig, ADriveThatFallsSilentWhileItIsSetUpIsSaidToBeSilent) {
  rig->drive(1).change_access({.index = 0x6007}, ObjectDictionary::Access::silent);
  expect_refused(1, DriveFinding::sdo_silent);
  EXPECT_FALSE(rig->host_of(1).refusal().found);
}

TEST_F(CanRig, ADriveThatCoastsInAFaultRollsOut) {
  can::Cia402Setup setup = SimulatedCanRig::default_setup();
  setup.coasts = true;
  rig = std::make_unique<SimulatedCanRig>(3, setup);
  rig->drive(1).add_object({.index = 0x605E}, {.size = 2, .access = ObjectDictionary::Access::read_only});
  bring_to_following();
  move(250);
  trouble(0, {.kind = Kind::emergency, .value = 0x4210});
  trouble(1, {.kind = Kind::emergency, .value = 0x4210});
  const double speed = rig->drive(1).velocity();
  hold(10);
  EXPECT_GT(rig->drive(1).velocity(), speed / 5);
  EXPECT_LT(rig->drive(0).velocity(), rig->drive(1).velocity() / 4) << "by its ramp";
}

/// How long the motor moves on after the host is dead.
std::int64_t time_to_rest(SimulatedCanRig& rig, std::size_t axis) {
  const std::int64_t dead_ns = rig.now_ns;
  while (std::fabs(rig.drive(axis).velocity()) > 1 && rig.now_ns < dead_ns + 2000 * ms) rig.pass(ms);
  return rig.now_ns - dead_ns;
}

TEST_F(CanRig, Fault29WhenTheHostIsDeadTheDrivesStopAlone) {
  bring_to_following();
  move(250);
  for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_GT(rig->drive(axis).velocity(), 10000);
  // Setpoints are missed first, after 50 ms. The ramp takes 25 ms, settling twice that.
  rig->pass(54 * ms);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(rig->drive(axis).state(), Cia402State::quick_stop_active);
  }
  EXPECT_LE(time_to_rest(*rig, 0), 50 * ms);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_NE(rig->drive(axis).state(), Cia402State::operation_enabled);
    EXPECT_EQ(rig->drive(axis).nmt(), can::NmtState::pre_operational);
  }
}

/// Each watchdog alone, in a drive that does not watch SYNC.
class CanRigWithOneWatchdog : public CanRig {
 protected:
  void SetUp() override {
    for (SimulatedCia402Drive& drive : rig->drives) drive.remove_object({.index = 0x1006});
  }
};

TEST_F(CanRigWithOneWatchdog, Fault29TheHeartbeatOfTheHostIsEnough) {
  for (SimulatedCia402Drive& drive : rig->drives) drive.remove_object({.index = 0x1400, .sub = 5});
  bring_to_following();
  move(250);
  const std::int64_t rest = time_to_rest(*rig, 0);
  EXPECT_GT(rest, 60 * ms);
  EXPECT_LE(rest, 100 * ms + 45 * ms);
}

TEST_F(CanRigWithOneWatchdog, Fault29TheTimeoutOfSetpointsIsEnough) {
  for (SimulatedCia402Drive& drive : rig->drives) drive.remove_object({.index = 0x1016, .sub = 1});
  bring_to_following();
  move(250);
  const std::int64_t rest = time_to_rest(*rig, 0);
  EXPECT_GT(rest, 40 * ms);
  EXPECT_LE(rest, 50 * ms + 45 * ms);
}

TEST_F(CanRigWithOneWatchdog, Fault29SetpointsThatCeaseStopTheDrivesThoughTheHostLives) {
  for (SimulatedCia402Drive& drive : rig->drives) drive.remove_object({.index = 0x1400, .sub = 5});
  bring_to_following();
  move(250);
  for (int i = 0; i < 40; ++i) rig->tick();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(rig->drive(axis).velocity(), 0, 1);
    EXPECT_FALSE(rig->host_of(axis).findings().empty());
  }
}

TEST_F(CanRig, ADriveMovedByHandWhileOffIsSwitchedOnWhereItIs) {
  bring_to_following();
  move(50);
  for (can::Cia402Drive& host : rig->hosts) host.disable(rig->now_ns);
  ASSERT_TRUE(rig->tick_until([&] { return rig->all_are(DrivePhase::disabled); }));
  trouble(1, {.kind = Kind::move_by_hand, .value = 50000});
  rig->tick();
  const double there = rig->drive(1).position();
  ASSERT_TRUE(rig->bring_to_following());
  for (int i = 0; i < 10; ++i) rig->tick();
  EXPECT_NEAR(rig->drive(1).position(), there, 1);
}

}  // namespace can_simulated_drive_test
}  // namespace inbetween
