// How the use of drives on a bus ends: every axis rests, every drive is off, and none reports an emergency,
// by the drives' own record and by the frames on the bus.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "inbetween/can/drive_exit.hpp"
#include "inbetween/can/nmt.hpp"
#include "tests/support/can_crane.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/run_on.hpp"

namespace inbetween {
namespace can_switch_off_test {

using can::Cia402State;
using can::DriveFinding;
using can::DrivePhase;
using can::NmtState;
using Kind = DriveTrouble::Kind;
using State = SupervisorState;
using Crane = CanCrane;

constexpr std::int64_t ms = 1'000'000;

void trouble(Crane& crane, std::size_t drive, DriveTrouble trouble) {
  trouble.at_ns = std::max(trouble.at_ns, crane.now_ns);
  crane.drives[drive].add_trouble(trouble);
}

/// The codes that a drive has sent, without those that say that an error is gone.
std::vector<int> emergencies_of(const SimulatedCia402Drive& drive) {
  std::vector<int> codes;
  for (const auto& reported : drive.record().reported) {
    if (reported.code != 0) codes.push_back(static_cast<int>(reported.code));
  }
  return codes;
}

/// It is off, rests, and does not miss the host, who has been gone for two seconds.
void expect_left_well(const SimulatedCia402Drive& drive) {
  SCOPED_TRACE(fmt::format("node {}", drive.node().value()));
  EXPECT_EQ(drive.state(), Cia402State::switch_on_disabled) << name_of(drive.state());
  EXPECT_EQ(drive.nmt(), NmtState::pre_operational);
  EXPECT_NEAR(drive.velocity(), 0, 1);
  EXPECT_FALSE(drive.misses_something());
}

/// The same of a rig in which nothing went wrong: nobody has reported anything at any time.
void expect_quiet_end(Crane& crane) {
  crane.switch_off();
  crane.pass(2000 * ms);
  for (const SimulatedCia402Drive& drive : crane.drives) {
    expect_left_well(drive);
    EXPECT_THAT(emergencies_of(drive), testing::IsEmpty()) << "node " << int{drive.node().value()};
  }
}

TEST(DriveExit, EveryStateTimesEveryEvent) {
  using can::ExitEvent;
  using enum can::ExitState;
  const std::vector<std::vector<can::ExitState>> table{
      // hush, ask, release, all_released, refused
      {silent, asking, releasing, silent, silent},   {silent, asking, releasing, asking, failed},
      {silent, asking, releasing, released, failed}, {silent, asking, releasing, released, released},
      {silent, failed, releasing, failed, failed},
  };
  ASSERT_EQ(table.size(), can::exit_states);
  for (std::size_t state = 0; state < can::exit_states; ++state) {
    for (std::size_t event = 0; event < can::exit_events; ++event) {
      EXPECT_EQ(next_state(static_cast<can::ExitState>(state), static_cast<ExitEvent>(event)),
                table[state][event])
          << state << ", event " << event;
    }
  }
}

TEST(CanSwitchOff, AfterAMoveEveryDriveIsOffAndNoneReportsAnEmergency) {
  Crane crane;
  crane.start();
  ASSERT_TRUE(crane.tick_until(State::ready));
  crane.tick(100);
  expect_quiet_end(crane);
  for (const can::Cia402Drive& host : crane.hosts) EXPECT_EQ(host.phase(), DrivePhase::off);
  for (const SimulatedCia402Drive& drive : crane.drives) {
    std::vector<std::string> last;
    for (const auto& entered : drive.record().entered) last.push_back(entered.state);
    ASSERT_GE(last.size(), 4U);
    EXPECT_THAT(std::vector(last.end() - 4, last.end()),
                testing::ElementsAre(
                    name_of(Cia402State::operation_enabled), name_of(Cia402State::switched_on),
                    name_of(Cia402State::ready_to_switch_on), name_of(Cia402State::switch_on_disabled)));
    EXPECT_EQ(drive.objects().value(0x1400, 5), 0U);
    EXPECT_EQ(drive.objects().value(0x1006), 0U);
    EXPECT_EQ(drive.objects().value(0x1016, 1), 0U);
    EXPECT_EQ(drive.objects().value(0x1017), 0U);
  }
}

/// One order to leave is sent a tick, and a drive may miss five setpoints.
TEST(CanSwitchOff, OfTwelveDrivesOnABusNoneMissesItsSetpointsWhileTheOthersLeave) {
  std::vector<AxisText> axes;
  for (int node = 1; node <= 12; ++node) {
    axes.push_back({.name = fmt::format("a{}", node), .drive = cia402_text(node)});
  }
  const ProgramRun run = run_on(rig_text(axes, {.more = bus_can0}), "run",
                                "name = \"m\"\nfps = 24\nframes = 24\n[[track]]\naxes = [\"a1\"]\n"
                                "keys = [ { at = [0] }, { at = [10] } ]\nspeed = [0, 0, 10, 0, 0]\n",
                                {"--sim", "--fast"});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.out, testing::Not(testing::HasSubstr("emergencies")));
}

/// What the host says on the bus, in words, each thing once.
TEST(CanSwitchOff, NothingLeavesBeforeEverythingIsOffAndSyncAndHeartbeatAreTheLast) {
  Crane crane;
  crane.start();
  ASSERT_TRUE(crane.tick_until(State::ready));
  trouble(crane, 1, {.kind = Kind::stay_on, .for_ns = 500 * ms});
  std::int64_t first_left_ns = 0;
  std::int64_t last_order_ns = 0;
  std::int64_t sync_ns = 0;
  std::int64_t heartbeat_ns = 0;
  crane.wire.set_fate([&](const can::Frame& frame, std::int64_t now_ns) {
    if (const auto order = can::read_nmt(frame)) {
      EXPECT_EQ(order->command, can::NmtCommand::enter_pre_operational);
      if (first_left_ns == 0) first_left_ns = now_ns;
      for (const SimulatedCia402Drive& drive : crane.drives) {
        EXPECT_EQ(drive.state(), Cia402State::switch_on_disabled) << "node " << int{drive.node().value()};
      }
    }
    if (frame.id == 0x601 || frame.id == 0x602) last_order_ns = now_ns;
    if (frame.id == can::sync_id) sync_ns = now_ns;
    if (frame.id == 0x700 + 127) heartbeat_ns = now_ns;
    return FrameFate{};
  });
  const std::int64_t from_ns = crane.now_ns;
  crane.switch_off();
  EXPECT_GE(first_left_ns - from_ns, 500 * ms) << "the other drive was on until then";
  EXPECT_GE(sync_ns, last_order_ns);
  EXPECT_GE(heartbeat_ns, last_order_ns - 30 * ms);
  EXPECT_GT(last_order_ns, first_left_ns);
  const std::int64_t end_ns = crane.now_ns;
  crane.tick(100);
  EXPECT_LE(sync_ns, end_ns) << "it is quiet then";
  EXPECT_LE(heartbeat_ns, end_ns);
  crane.pass(2000 * ms);
  for (const SimulatedCia402Drive& drive : crane.drives) expect_left_well(drive);
}

TEST(CanSwitchOff, ADriveThatStaysOnIsNamedKeepsItsWatchdogsAndTheOthersLeave) {
  Crane crane;
  crane.start();
  crane.tick(300);
  trouble(crane, 1, {.kind = Kind::stay_on});
  crane.loop().post(SupervisorEvent::stop);
  ASSERT_TRUE(crane.tick_until(State::latched));
  crane.tick(50);
  const int ticks = crane.switch_off();
  EXPECT_LE(ticks, 2500 / 4) << "bounded by disable_timeout_ns";
  EXPECT_EQ(crane.hosts[0].phase(), DrivePhase::off);
  EXPECT_EQ(crane.hosts[1].phase(), DrivePhase::abandoned);
  EXPECT_EQ(crane.hosts[1].first_finding(), DriveFinding::not_switched_off);
  EXPECT_NE(crane.drives[1].objects().value(0x1016, 1), 0U);
  EXPECT_NE(crane.drives[1].objects().value(0x1400, 5), 0U);
  crane.pass(2000 * ms);
  expect_left_well(crane.drives[0]);
  EXPECT_THAT(emergencies_of(crane.drives[0]), testing::IsEmpty());
  EXPECT_EQ(crane.drives[1].state(), Cia402State::switch_on_disabled) << "by its own watchdog";
  EXPECT_THAT(emergencies_of(crane.drives[1]), testing::Not(testing::IsEmpty()));
}

TEST(CanSwitchOff, AnAxisThatSinksWhenItsDriveIsOffIsNamed) {
  Crane crane;
  crane.start();
  ASSERT_TRUE(crane.tick_until(State::ready));
  trouble(crane, 0, {.kind = Kind::sink, .value = -5000});
  crane.switch_off();
  EXPECT_EQ(crane.hosts[0].phase(), DrivePhase::abandoned);
  EXPECT_EQ(crane.hosts[0].first_finding(), DriveFinding::moves_while_off);
  EXPECT_EQ(crane.hosts[1].phase(), DrivePhase::off);
}

/// An emergency stop: setpoints cease, the drives stop by their own watchdogs and are in pre-operational.
void stop_by_emergency(Crane& crane) {
  crane.start();
  crane.tick(400);
  crane.lines.is_pressed = true;
  crane.expect_ceased_setpoints();
}

TEST(CanSwitchOff, AfterAnEmergencyStopNothingIsMissedAnyMore) {
  Crane crane;
  stop_by_emergency(crane);
  for (const SimulatedCia402Drive& drive : crane.drives) {
    EXPECT_THAT(emergencies_of(drive), testing::Not(testing::IsEmpty())) << "setpoints have ceased";
  }
  std::vector<std::size_t> at_the_stop;
  for (const SimulatedCia402Drive& drive : crane.drives) at_the_stop.push_back(emergencies_of(drive).size());
  crane.switch_off();
  crane.pass(2000 * ms);
  for (std::size_t i = 0; i < 2; ++i) {
    expect_left_well(crane.drives[i]);
    EXPECT_EQ(crane.hosts[i].phase(), DrivePhase::off);
    EXPECT_THAT(emergencies_of(crane.drives[i]), testing::SizeIs(at_the_stop[i]))
        << "none but those of the stop";
  }
}

// 605A of 5 to 8: the drive holds its axis after its quick stop, with power.
TEST(CanSwitchOff, ADriveThatHoldsItsAxisAfterItsOwnQuickStopIsSwitchedOffBySdo) {
  Crane crane;
  for (SimulatedCia402Drive& drive : crane.drives) {
    drive.add_object({.index = 0x605A}, {.size = 2, .value = 6, .min = 5, .max = 8});
  }
  stop_by_emergency(crane);
  for (const SimulatedCia402Drive& drive : crane.drives) {
    EXPECT_EQ(drive.state(), Cia402State::quick_stop_active);
    EXPECT_EQ(drive.nmt(), NmtState::pre_operational);
  }
  crane.switch_off();
  crane.pass(2000 * ms);
  for (const SimulatedCia402Drive& drive : crane.drives) expect_left_well(drive);
}

// 6007 of 1: the drive is in fault because this program was silent. A fault of its own stays.
TEST(CanSwitchOff, AFaultOfCommunicationIsResetAndOneOfTheDriveIsNot) {
  Crane crane;
  for (SimulatedCia402Drive& drive : crane.drives) {
    drive.add_object({.index = 0x6007}, {.size = 2, .value = 1, .max = 1});
  }
  crane.start();
  crane.tick(400);
  trouble(crane, 1, {.kind = Kind::emergency, .value = 0x2310});
  crane.tick(20);
  crane.lines.is_pressed = true;
  ASSERT_TRUE(crane.tick_until(State::faulted, 100));
  crane.tick(300);
  EXPECT_EQ(crane.drives[0].state(), Cia402State::fault);
  crane.switch_off();
  crane.pass(2000 * ms);
  expect_left_well(crane.drives[0]);
  EXPECT_EQ(crane.drives[1].state(), Cia402State::fault) << "for whoever looks at the drive";
  EXPECT_FALSE(crane.drives[1].misses_something());
  EXPECT_EQ(crane.hosts[1].phase(), DrivePhase::off) << "a fault has no power";
}

TEST(CanSwitchOff, AStartThatIsRefusedLeavesTheOtherDrivesQuiet) {
  Crane crane;
  bool is_lost = true;
  crane.wire.set_fate([&](const can::Frame& frame, std::int64_t) {
    return FrameFate{.copies = is_lost && frame.id == 0x702 ? 0 : 1};
  });
  ASSERT_TRUE(crane.loop().post(SupervisorEvent::arm));
  ASSERT_TRUE(crane.tick_until(State::faulted));
  expect_quiet_end(crane);
  EXPECT_EQ(crane.hosts[1].first_finding(), DriveFinding::never_booted);
  is_lost = false;
  crane.loop().post(SupervisorEvent::arm);
  ASSERT_TRUE(crane.tick_until(State::ready)) << "the next start finds nothing that is in its way";
}

TEST(CanSwitchOff, WhoeverLeavesDuringTheSetUpLeavesItWellInEveryTickOfIt) {
  int ticks_until_ready = 0;
  {
    Crane crane;
    ASSERT_TRUE(crane.loop().post(SupervisorEvent::arm));
    for (; crane.loop().state() != State::ready; ++ticks_until_ready) crane.tick();
  }
  ASSERT_GT(ticks_until_ready, 100);
  for (int ticks = 0; ticks < ticks_until_ready; ++ticks) {
    SCOPED_TRACE(ticks);
    Crane crane;
    ASSERT_TRUE(crane.loop().post(SupervisorEvent::arm));
    crane.tick(ticks);
    crane.loop().post(SupervisorEvent::stop);
    ASSERT_NO_FATAL_FAILURE(expect_quiet_end(crane));
    for (const can::Cia402Drive& host : crane.hosts) ASSERT_EQ(host.phase(), DrivePhase::off);
  }
}

TEST(CanSwitchOff, ADriveWhoseFeedbackIsLostIsAskedBySdo) {
  Crane crane;
  crane.start();
  crane.tick(400);
  trouble(crane, 1, {.kind = Kind::lose_feedback});
  ASSERT_TRUE(crane.tick_until(State::stopping, 100));
  ASSERT_TRUE(crane.tick_until(State::faulted, 1000)) << name_of(crane.loop().state());
  crane.tick(50);
  expect_quiet_end(crane);
  EXPECT_EQ(crane.hosts[1].phase(), DrivePhase::off);
}

TEST(CanSwitchOff, ADriveThatDoesNotAnswerIsNotTakenForOff) {
  Crane crane;
  crane.start();
  ASSERT_TRUE(crane.tick_until(State::ready));
  trouble(crane, 1, {.kind = Kind::lose_sent});
  const int ticks = crane.switch_off();
  EXPECT_LE(ticks, 1000 / 4) << "a transfer of SDO is waited for, and no more";
  EXPECT_EQ(crane.hosts[1].phase(), DrivePhase::abandoned);
  EXPECT_TRUE(crane.hosts[1].findings().has(DriveFinding::not_switched_off));
  EXPECT_EQ(crane.hosts[0].phase(), DrivePhase::off);
}

TEST(CanSwitchOff, ADriveThatKeepsItsWatchdogsIsSetBackToPowerOn) {
  Crane crane;
  crane.start();
  ASSERT_TRUE(crane.tick_until(State::ready));
  bool is_reset = false;
  crane.wire.set_fate([&](const can::Frame& frame, std::int64_t) {
    const auto order = can::read_nmt(frame);
    is_reset = is_reset || (order && *order == can::NmtOrder{can::NmtCommand::reset_communication, 2});
    // What it answers to the order to watch no more is that it does not.
    const bool is_order = frame.id == 0x602 && frame.data[1] == 0x16 && frame.data[2] == 0x10;
    if (is_order) {
      crane.wire.inject(can::sdo_frame(0x582, {.kind = can::SdoKind::abort,
                                               .object = {.index = 0x1016, .sub = 1},
                                               .value = can::abort_device_state}));
    }
    return FrameFate{.copies = is_order ? 0 : 1};
  });
  expect_quiet_end(crane);
  EXPECT_TRUE(is_reset);
  for (const can::Cia402Drive& host : crane.hosts) EXPECT_EQ(host.phase(), DrivePhase::off);
}

TEST(CanSwitchOff, AQuickStopIsNotCutShort) {
  Crane crane;
  crane.start();
  crane.tick(400);
  crane.drives[1].add_object({.index = 0x6085}, {.size = 4, .value = 200'000, .min = 1});
  crane.drives[1].add_object({.index = 0x605A}, {.size = 2, .value = 6, .min = 5, .max = 8});
  ASSERT_GT(std::fabs(crane.drives[1].velocity()), 10'000);
  crane.port.front().quick_stop();
  crane.tick(3);
  ASSERT_EQ(crane.drives[1].state(), Cia402State::quick_stop_active);
  crane.port.front().disable();
  crane.tick(500);
  const auto& entered = crane.drives[1].record().entered;
  ASSERT_STREQ(entered.back().state, name_of(Cia402State::switch_on_disabled));
  EXPECT_NEAR(entered.back().velocity, 0, 300) << "no faster than what counts as rest";
}

TEST(CanSwitchOff, AfterTheEndTheRigCanBeUsedAgain) {
  Crane crane;
  crane.start();
  crane.tick(400);
  crane.loop().post(SupervisorEvent::stop);
  ASSERT_TRUE(crane.tick_until(State::latched));
  // Not even the end of the end is waited for.
  for (const int ticks : {0, 1, 5, 14, 20, 40, 500}) {
    SCOPED_TRACE(ticks);
    crane.loop().post(SupervisorEvent::disarm);
    crane.tick(ticks);
    ASSERT_TRUE(crane.loop().post(SupervisorEvent::arm));
    ASSERT_TRUE(crane.tick_until(State::ready)) << name_of(crane.loop().state());
  }
  expect_quiet_end(crane);
}

// --- SYNC that is late

/// The host is not scheduled for a tick, and its SYNC is as much late.
TEST(CanSync, OneLateTickIsNoFaultOfADriveThatWatchesSyncStrictly) {
  Crane crane;
  crane.start();
  for (int i = 0; i < 10; ++i) {
    crane.tick(20);
    crane.now_ns += Crane::tick_ns;
    crane.loop().tick(2, crane.now_ns += Crane::tick_ns);
  }
  EXPECT_EQ(crane.loop().state(), State::running);
  for (const SimulatedCia402Drive& drive : crane.drives) {
    EXPECT_EQ(drive.objects().value(0x1006), 0U);
    EXPECT_THAT(emergencies_of(drive), testing::IsEmpty());
    EXPECT_EQ(drive.state(), Cia402State::operation_enabled);
  }
}

TEST(CanSync, ADriveThatCannotWatchTheHostsHeartbeatWatchesSyncWithItsExactPeriod) {
  Crane crane;
  crane.drives[1].remove_object({.index = 0x1016, .sub = 1});
  crane.start();
  crane.tick(200);
  EXPECT_EQ(crane.drives[0].objects().value(0x1006), 0U);
  EXPECT_EQ(crane.drives[1].objects().value(0x1006), 4000U);
  crane.pass(10 * ms);
  EXPECT_EQ(crane.drives[0].state(), Cia402State::operation_enabled);
  EXPECT_EQ(crane.drives[1].state(), Cia402State::quick_stop_active) << "SYNC is missed";
}

}  // namespace can_switch_off_test
}  // namespace inbetween
