// One CiA 402 drive as the host sees it, fed with frames by hand.
#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "inbetween/can/cia402_drive.hpp"
#include "inbetween/can/drive_phase.hpp"
#include "tests/support/drive_frames.hpp"
#include "tests/support/drive_objects.hpp"

namespace inbetween::can {
namespace can_drive_test {

constexpr std::int64_t ms = 1'000'000;

constexpr std::uint16_t disabled = 0x0250;
constexpr std::uint16_t ready = 0x0231;
constexpr std::uint16_t switched_on = 0x0233;
constexpr std::uint16_t enabled = 0x0237;
constexpr std::uint16_t following = 0x1237;
constexpr std::uint16_t quick_stopped = 0x0217;
constexpr std::uint16_t in_fault = 0x0218;

NodeId node(int number) {
  return NodeId::make(number).value();
}

Cia402Settings settings_of(int number) {
  return {.setup = {.node = node(number), .host = node(127)}, .max_step_counts = 1000};
}

TEST(DrivePhase, EveryPhaseTimesEveryEvent) {
  using enum DrivePhase;
  using Event = DriveEvent;
  const std::map<DrivePhase, std::map<Event, DrivePhase>> transitions{
      {off, {{Event::connect, booting}}},
      {booting, {{Event::booted, configuring}, {Event::timed_out, refused}, {Event::disable, off}}},
      {configuring,
       {{Event::configured, starting},
        {Event::refused, refused},
        {Event::disable, disabling},
        {Event::vanished, gone}}},
      {starting,
       {{Event::started, idle},
        {Event::timed_out, refused},
        {Event::disable, disabling},
        {Event::vanished, gone}}},
      {idle,
       {{Event::connect, booting},
        {Event::enable, clearing},
        {Event::disable, disabling},
        {Event::vanished, gone}}},
      {clearing,
       {{Event::cleared, enabling},
        {Event::timed_out, idle},
        {Event::dropped_out, idle},
        {Event::disable, disabling},
        {Event::quick_stop, stopping},
        {Event::vanished, gone}}},
      {enabling,
       {{Event::enabled, DrivePhase::following},
        {Event::timed_out, idle},
        {Event::dropped_out, idle},
        {Event::disable, disabling},
        {Event::quick_stop, stopping},
        {Event::vanished, gone}}},
      {DrivePhase::following,
       {{Event::dropped_out, idle},
        {Event::stopped_itself, stopping},
        {Event::disable, disabling},
        {Event::quick_stop, stopping},
        {Event::vanished, gone}}},
      {stopping, {{Event::enable, clearing}, {Event::disable, disabling}, {Event::vanished, gone}}},
      {disabling, {{Event::disabled, DrivePhase::disabled}, {Event::timed_out, abandoned}}},
      {DrivePhase::disabled, {{Event::connect, booting}, {Event::leave, leaving}}},
      {leaving, {{Event::connect, booting}, {Event::left, off}, {Event::timed_out, abandoned}}},
      {abandoned, {{Event::connect, booting}}},
      {refused, {{Event::connect, booting}, {Event::disable, disabling}}},
      {gone, {{Event::connect, booting}, {Event::disable, disabling}}},
  };
  ASSERT_EQ(transitions.size(), drive_phases);
  for (const auto& [phase, next_of] : transitions) {
    for (std::size_t e = 0; e < drive_events; ++e) {
      const auto event = static_cast<Event>(e);
      const DriveStep step = next_phase(phase, event);
      const bool leads_on = next_of.contains(event);
      const bool is_start = event == Event::connect || event == Event::enable || event == Event::leave;
      const DrivePhase otherwise = event == Event::disconnect ? off : phase;
      EXPECT_EQ(step.phase, leads_on ? next_of.at(event) : otherwise)
          << "phase " << static_cast<int>(phase) << ", event " << e;
      EXPECT_EQ(step.is_refused, is_start && !leads_on)
          << "phase " << static_cast<int>(phase) << ", event " << e;
    }
  }
}

/// A drive that is played by the test, every 4 ms.
class DriveOfNode5 : public testing::Test {
 protected:
  Cia402Settings settings = settings_of(5);
  std::optional<Cia402Drive> drive;
  DriveObjects objects;
  std::int64_t now = 0;
  std::vector<Frame> services;

  void SetUp() override { drive = Cia402Drive::make(settings).value(); }

  /// A tick without anything from the drive. The frame with the next target, if there is one.
  std::optional<DriveCommand> silent_tick(std::optional<std::int32_t> target = {}) {
    now += 4 * ms;
    drive->tick(now);
    const std::optional<Frame> frame = drive->command(target);
    services.clear();
    if (const std::optional<Frame> service = drive->service(now)) services.push_back(*service);
    if (!frame) return {};
    return read_command(*frame, node(5));
  }
  void heartbeat(NmtState state) { drive->receive(heartbeat_frame(node(5), state), now); }
  void feedback(std::uint16_t statusword, std::int32_t actual, std::int8_t mode = 8) {
    drive->receive(feedback_frame(node(5), {.statusword = statusword, .actual = actual, .mode = mode}), now);
  }
  std::optional<DriveCommand> tick(std::uint16_t statusword, std::int32_t actual,
                                   std::optional<std::int32_t> target = {}) {
    heartbeat(NmtState::operational);
    feedback(statusword, actual);
    return silent_tick(target);
  }

  void reset() {
    ASSERT_TRUE(drive->connect(now));
    silent_tick();
    ASSERT_EQ(services.size(), 1U);
    EXPECT_EQ(read_nmt(services[0]), (NmtOrder{NmtCommand::reset_communication, 5}));
  }
  /// Until the drive has been told to start.
  void configure() {
    reset();
    heartbeat(NmtState::boot_up);
    while (drive->phase() == DrivePhase::configuring) {
      silent_tick();
      for (const Frame& frame : services) {
        if (frame.id != 0x605) continue;
        drive->receive(sdo_frame(0x585, objects.answer(*read_sdo_request(frame))), now);
      }
    }
  }
  void bring_to_idle() {
    configure();
    ASSERT_EQ(drive->phase(), DrivePhase::starting);
    ASSERT_EQ(services.size(), 1U);
    EXPECT_EQ(read_nmt(services[0]), (NmtOrder{NmtCommand::start, 5}));
    drive->note_host_heartbeat();
    silent_tick();
    tick(disabled, 700);
    ASSERT_EQ(drive->phase(), DrivePhase::idle);
  }
  void bring_to_following() {
    bring_to_idle();
    ASSERT_TRUE(drive->enable(now));
    for (const std::uint16_t word : {disabled, ready, switched_on, enabled, following}) tick(word, 700);
    ASSERT_EQ(drive->phase(), DrivePhase::following);
    ASSERT_TRUE(drive->findings().empty());
  }
  [[nodiscard]] bool has_found(DriveFinding finding) const { return drive->findings().has(finding); }
};

TEST_F(DriveOfNode5, IsSwitchedOnWithItsTargetWhereItIs) {
  bring_to_idle();
  EXPECT_EQ(tick(disabled, 701), (DriveCommand{.controlword = 0x0000, .target = 701}));
  EXPECT_TRUE(drive->enable(now));
  EXPECT_EQ(tick(disabled, 702), (DriveCommand{.controlword = 0x0006, .target = 702}));
  EXPECT_EQ(tick(ready, 703), (DriveCommand{.controlword = 0x0007, .target = 703}));
  EXPECT_EQ(tick(switched_on, 704), (DriveCommand{.controlword = 0x000F, .target = 704}));
  EXPECT_EQ(tick(switched_on, 705), (DriveCommand{.controlword = 0x000F, .target = 704}))
      << "held from now on";
  EXPECT_EQ(tick(enabled, 690), (DriveCommand{.controlword = 0x000F, .target = 704}));
  EXPECT_EQ(drive->phase(), DrivePhase::enabling) << "bit 12 is still clear";
  EXPECT_EQ(tick(following, 705), (DriveCommand{.controlword = 0x000F, .target = 704}));
  EXPECT_EQ(drive->phase(), DrivePhase::following);
  EXPECT_EQ(tick(following, 705), (DriveCommand{.controlword = 0x000F, .target = 704}));
  EXPECT_EQ(tick(following, 705, 705), (DriveCommand{.controlword = 0x000F, .target = 705}));
  EXPECT_EQ(tick(following, 705, 900), (DriveCommand{.controlword = 0x000F, .target = 900}));
  EXPECT_TRUE(drive->findings().empty());
  EXPECT_EQ(drive->target(), 900);
}

TEST_F(DriveOfNode5, IsNotEnabledBeforeItShowsTheRightMode) {
  bring_to_idle();
  drive->enable(now);
  tick(disabled, 700);
  tick(ready, 700);
  for (int i = 0; i < 5; ++i) {
    heartbeat(NmtState::operational);
    feedback(switched_on, 700 + i, 1);
    EXPECT_EQ(silent_tick(), (DriveCommand{.controlword = 0x0007, .target = 700 + i}));
  }
  EXPECT_EQ(tick(switched_on, 700)->controlword, 0x000F);
}

TEST_F(DriveOfNode5, AFaultIsResetByAnEdge) {
  bring_to_idle();
  for (int i = 0; i < 2; ++i) EXPECT_EQ(tick(in_fault, 700)->controlword, 0x0000);
  drive->enable(now);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(tick(in_fault, 700)->controlword, 0x0080);
  EXPECT_EQ(tick(disabled, 700)->controlword, 0x0006);
}

TEST_F(DriveOfNode5, AFaultThatNeedsMoreThanOneEdgeGetsThem) {
  bring_to_idle();
  drive->enable(now);
  int edges = 0;
  std::uint16_t before = 0;
  for (int i = 0; i < 200; ++i) {
    const std::uint16_t word = tick(in_fault, 700)->controlword;
    edges += (word & 0x80) != 0 && (before & 0x80) == 0 ? 1 : 0;
    EXPECT_EQ(word & 0x0F, 0) << "and nothing else is ordered";
    before = word;
  }
  EXPECT_GE(edges, 3);
  EXPECT_EQ(tick(disabled, 700)->controlword, 0x0006);
}

TEST_F(DriveOfNode5, AFaultThatStaysIsReported) {
  bring_to_idle();
  drive->enable(now);
  for (int i = 0; i <= 250; ++i) tick(in_fault, 700);
  EXPECT_EQ(drive->first_finding(), DriveFinding::fault_stays);
  EXPECT_EQ(drive->phase(), DrivePhase::idle);
}

TEST_F(DriveOfNode5, OneThatDoesNotSwitchOnIsReported) {
  bring_to_idle();
  drive->enable(now);
  for (int i = 0; i < 1252; ++i) tick(switched_on, 700);
  EXPECT_EQ(drive->first_finding(), DriveFinding::not_enabled);
  EXPECT_EQ(drive->phase(), DrivePhase::idle);
  EXPECT_FALSE(drive->enable(now)) << "not before somebody has seen it";
  drive->acknowledge();
  EXPECT_TRUE(drive->enable(now));
}

TEST_F(DriveOfNode5, AFaultWhileItIsSwitchedOnIsReported) {
  bring_to_idle();
  drive->enable(now);
  tick(disabled, 700);
  tick(in_fault, 700);
  EXPECT_EQ(drive->first_finding(), DriveFinding::drive_fault);
  EXPECT_EQ(drive->phase(), DrivePhase::idle);
}

TEST_F(DriveOfNode5, WhatIsFoundOnTheWayKeepsItOff) {
  bring_to_idle();
  drive->enable(now);
  tick(disabled, 700);
  tick(switched_on, 700);
  drive->receive(emergency_frame(node(5), {.code = 0x3220}), now);
  for (int i = 0; i < 6; ++i) tick(enabled, 700);
  EXPECT_EQ(drive->phase(), DrivePhase::idle);

  for (int i = 0; i < 40; ++i) {
    feedback(in_fault, 700);
    silent_tick();
  }
  drive->acknowledge();
  ASSERT_TRUE(drive->enable(now));
  feedback(in_fault, 700);
  EXPECT_EQ(silent_tick()->controlword, 0x0000) << "its heartbeat is lost, so its fault is not reset";
  EXPECT_EQ(drive->phase(), DrivePhase::idle);
}

TEST_F(DriveOfNode5, AnEmergencyThatIsRepeatedWhenItIsStartedDoesNotKeepItOff) {
  configure();
  drive->receive(emergency_frame(node(5), {.code = 0x8130}), now);
  drive->note_host_heartbeat();
  silent_tick();
  tick(disabled, 700);
  ASSERT_EQ(drive->phase(), DrivePhase::idle);
  drive->receive(emergency_frame(node(5), {.code = 0x8130}), now);
  EXPECT_TRUE(drive->enable(now)) << "its fault is over";
  EXPECT_EQ(drive->counters().emergencies, 2U);
  EXPECT_EQ(drive->last_emergency().code, 0x8130);
  for (const std::uint16_t word : {disabled, ready, switched_on, enabled, following}) tick(word, 700);
  EXPECT_EQ(drive->phase(), DrivePhase::following);
}

TEST_F(DriveOfNode5, AnEmergencyWhoseFaultStaysKeepsItOff) {
  bring_to_idle();
  drive->receive(emergency_frame(node(5), {.code = 0x4210}), now);
  ASSERT_TRUE(drive->enable(now));
  for (int i = 0; i <= 250; ++i) tick(in_fault, 700);
  EXPECT_EQ(drive->first_finding(), DriveFinding::fault_stays);
  EXPECT_EQ(drive->last_emergency().code, 0x4210);
}

TEST_F(DriveOfNode5, AnAxisThatMovesAwayFromItsFirstSetpointIsRefused) {  // docs/faults.md 27
  bring_to_idle();
  drive->enable(now);
  tick(disabled, 700);
  tick(switched_on, 700);
  tick(following, 801);
  EXPECT_EQ(drive->first_finding(), DriveFinding::moved_while_enabling);
  EXPECT_EQ(drive->phase(), DrivePhase::idle);
}

TEST_F(DriveOfNode5, StopsQuicklyAndCanBeSwitchedOnAgain) {
  bring_to_following();
  EXPECT_TRUE(drive->quick_stop(now));
  EXPECT_EQ(tick(following, 710, 720), (DriveCommand{.controlword = 0x0002, .target = 710}));
  EXPECT_EQ(tick(quick_stopped, 715, 720), (DriveCommand{.controlword = 0x0002, .target = 715}));
  EXPECT_TRUE(drive->enable(now));
  EXPECT_EQ(tick(quick_stopped, 715)->controlword, 0x0000);
  EXPECT_EQ(tick(disabled, 715)->controlword, 0x0006);
  EXPECT_TRUE(drive->findings().empty());
}

TEST_F(DriveOfNode5, AQuickStopThatIsIgnoredIsReported) {
  bring_to_following();
  drive->quick_stop(now);
  for (int i = 0; i < 252; ++i) tick(following, 700);
  EXPECT_EQ(drive->first_finding(), DriveFinding::quick_stop_ignored);
  EXPECT_EQ(words_of(*drive->first_finding()).reaction, DriveReaction::cease_setpoints);
}

TEST_F(DriveOfNode5, GoesOffByItsOwnRamp) {
  bring_to_following();
  drive->disable(now);
  EXPECT_EQ(tick(following, 700, 720)->controlword, 0x0007);
  EXPECT_EQ(tick(switched_on, 700, 720)->controlword, 0x0006);
  EXPECT_EQ(tick(ready, 703, 720), (DriveCommand{.controlword = 0x0000, .target = 703}));
  EXPECT_EQ(drive->phase(), DrivePhase::disabling);
  EXPECT_FALSE(drive->leave(now)) << "it has not told that it is off";
  for (int i = 0; i < 13; ++i) EXPECT_EQ(tick(disabled, 703)->controlword, 0x0000);
  EXPECT_EQ(drive->phase(), DrivePhase::disabled) << "and it has rested for 50 ms";
}

TEST_F(DriveOfNode5, IsLetGoWithoutItsWatchdogs) {
  bring_to_following();
  drive->disable(now);
  for (int i = 0; i < 16; ++i) tick(disabled, 703);
  ASSERT_TRUE(drive->leave(now));
  silent_tick();
  ASSERT_EQ(services.size(), 1U);
  EXPECT_EQ(read_nmt(services[0]), (NmtOrder{NmtCommand::enter_pre_operational, 5}));
  objects.remove(0x1006, 0);
  objects.written.clear();
  for (int i = 0; i < 10; ++i) {
    EXPECT_FALSE(silent_tick()) << "no process data";
    for (const Frame& frame : services) {
      drive->receive(sdo_frame(0x585, objects.answer(*read_sdo_request(frame))), now);
    }
  }
  EXPECT_EQ(drive->phase(), DrivePhase::off);
  const std::vector<std::pair<DriveObjects::Key, std::uint32_t>> expected{
      {{0x1400, 5}, 0}, {{0x1016, 1}, 0}, {{0x1017, 0}, 0}};
  EXPECT_EQ(objects.written, expected);
  EXPECT_FALSE(drive->needs_sync());
  EXPECT_FALSE(drive->is_in_use());
}

TEST_F(DriveOfNode5, OneThatDoesNotLetItselfGoIsSetBackAndThenReported) {
  bring_to_following();
  drive->disable(now);
  for (int i = 0; i < 16; ++i) tick(disabled, 703);
  drive->leave(now);
  int resets = 0;
  for (int i = 0; i < 1600; ++i) {
    silent_tick();
    for (const Frame& frame : services) {
      if (read_nmt(frame) == NmtOrder{NmtCommand::reset_communication, 5}) ++resets;
    }
  }
  EXPECT_EQ(resets, 1);
  EXPECT_EQ(drive->phase(), DrivePhase::abandoned);
  EXPECT_EQ(drive->first_finding(), DriveFinding::watchdog_stays);
}

TEST_F(DriveOfNode5, OneToWhichNothingWasWrittenIsLeftAsItIs) {
  objects.set(0x1000, 0, 4, 0x00020191);
  configure();
  ASSERT_EQ(drive->first_finding(), DriveFinding::wrong_device);
  EXPECT_TRUE(drive->disable(now));
  EXPECT_EQ(drive->phase(), DrivePhase::off);
  silent_tick();
  EXPECT_TRUE(services.empty());
}

TEST_F(DriveOfNode5, SendsNothingOnceSetpointsHaveCeased) {
  bring_to_following();
  EXPECT_TRUE(tick(following, 700)) << "holds until the first target";
  EXPECT_TRUE(tick(following, 700, 700));
  EXPECT_FALSE(tick(following, 700));
  EXPECT_TRUE(drive->is_commanded());
}

TEST_F(DriveOfNode5, ASetpointThatJumpsIsNotSent) {
  bring_to_following();
  EXPECT_EQ(tick(following, 700, 701)->target, 701);
  EXPECT_EQ(tick(following, 700, 1701)->target, 1701);
  EXPECT_EQ(tick(following, 700, 2702)->target, 1701);
  EXPECT_EQ(drive->first_finding(), DriveFinding::setpoint_jump);
  EXPECT_EQ(tick(following, 700, std::numeric_limits<std::int32_t>::min())->target, 1701);
  EXPECT_EQ(words_of(DriveFinding::setpoint_jump).reaction, DriveReaction::quick_stop);
}

TEST_F(DriveOfNode5, AFirstSetpointThatIsNotWhereTheAxisIsIsNotSent) {  // docs/faults.md 27
  bring_to_following();
  EXPECT_EQ(tick(following, 700, 801)->target, 700);
  EXPECT_EQ(drive->first_finding(), DriveFinding::moved_while_enabling);
  EXPECT_FALSE(drive->is_commanded());
}

TEST_F(DriveOfNode5, NeverBootsWithoutABootUpMessage) {  // docs/faults.md 22
  reset();
  heartbeat(NmtState::pre_operational);
  for (int i = 0; i < 1248; ++i) silent_tick();
  EXPECT_EQ(drive->phase(), DrivePhase::booting);
  for (int i = 0; i < 2; ++i) silent_tick();
  EXPECT_EQ(drive->phase(), DrivePhase::refused);
  EXPECT_EQ(drive->first_finding(), DriveFinding::never_booted);
  EXPECT_FALSE(drive->enable(now));
}

TEST_F(DriveOfNode5, ABootUpMessageBeforeTheResetWasSentIsNoAnswerToIt) {
  drive->connect(now);
  heartbeat(NmtState::boot_up);
  silent_tick();
  EXPECT_EQ(drive->phase(), DrivePhase::booting);
  heartbeat(NmtState::boot_up);
  EXPECT_EQ(drive->phase(), DrivePhase::configuring);
}

TEST_F(DriveOfNode5, TheFirstHeartbeatMustCome) {  // docs/faults.md 22
  configure();
  drive->note_host_heartbeat();
  for (int i = 0; i < 1252; ++i) {
    feedback(disabled, 700);
    silent_tick();
  }
  EXPECT_EQ(drive->phase(), DrivePhase::refused);
  EXPECT_EQ(drive->first_finding(), DriveFinding::first_heartbeat_missing);
  EXPECT_EQ(words_of(*drive->first_finding()).reaction, DriveReaction::refuse);
}

TEST_F(DriveOfNode5, IsNotStartedBeforeItIsOperationalAndTheHostsHeartbeatWasSent) {
  configure();
  silent_tick();
  tick(disabled, 700);
  EXPECT_EQ(drive->phase(), DrivePhase::starting) << "it does not watch the host yet";
  drive->note_host_heartbeat();
  silent_tick();
  EXPECT_EQ(drive->phase(), DrivePhase::idle);
}

TEST_F(DriveOfNode5, OneThatStaysPreOperationalIsRefused) {
  configure();
  drive->note_host_heartbeat();
  for (int i = 0; i < 1252; ++i) {
    heartbeat(NmtState::pre_operational);
    silent_tick();
  }
  EXPECT_EQ(drive->first_finding(), DriveFinding::not_operational);
}

TEST_F(DriveOfNode5, ADriveThatCannotBeSetUpIsRefusedWithTheReason) {
  objects.set(0x6065, 0, 4, 0xFFFFFFFF);
  configure();
  EXPECT_EQ(drive->phase(), DrivePhase::refused);
  EXPECT_EQ(drive->first_finding(), DriveFinding::window_disabled);
  EXPECT_EQ(drive->refusal().object.index, 0x6065);
  objects.set(0x6065, 0, 4, 1000);
  configure();
  EXPECT_EQ(drive->phase(), DrivePhase::starting);
}

TEST_F(DriveOfNode5, FeedbackThatIsMissingIsCountedAndThenAFinding) {  // docs/faults.md 13, 20
  bring_to_following();
  heartbeat(NmtState::operational);
  EXPECT_TRUE(silent_tick(700));
  EXPECT_TRUE(silent_tick(700));
  EXPECT_TRUE(drive->findings().empty());
  tick(following, 700, 700);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(silent_tick(700)) << "it may still hear its targets";
  EXPECT_EQ(drive->first_finding(), DriveFinding::feedback_missing);
  EXPECT_TRUE(drive->lasting().has(DriveFinding::feedback_missing));
  EXPECT_EQ(drive->counters().missed, 5U);
  EXPECT_EQ(words_of(*drive->first_finding()).reaction, DriveReaction::controlled_stop);
  tick(following, 700, 700);
  EXPECT_FALSE(drive->lasting().has(DriveFinding::feedback_missing));
  EXPECT_TRUE(has_found(DriveFinding::feedback_missing)) << "until somebody has seen it";
}

TEST_F(DriveOfNode5, FeedbackThatComesLateIsNoDuplicate) {
  bring_to_following();
  for (int i = 0; i < 100; ++i) {
    heartbeat(NmtState::operational);
    silent_tick(700);
    feedback(following, 700);
    feedback(following, 701);
    silent_tick(700);
    EXPECT_EQ(drive->feedback().actual, 701);
  }
  EXPECT_TRUE(drive->findings().empty());
  EXPECT_EQ(drive->counters().duplicates, 0U);
}

TEST_F(DriveOfNode5, ShortAndDuplicateFramesAreDiscardedCountedAndThenAFinding) {  // docs/faults.md 19
  bring_to_following();
  Frame too_short = feedback_frame(node(5), {.statusword = in_fault, .actual = 9, .mode = 8});
  too_short.length = 6;
  for (int i = 0; i < 4; ++i) {
    heartbeat(NmtState::operational);
    drive->receive(too_short, now);
    feedback(following, 700);
    feedback(in_fault, 9);  // a second one for the same SYNC
    silent_tick(700);
    EXPECT_EQ(drive->feedback().actual, 700);
  }
  EXPECT_TRUE(drive->findings().empty());
  EXPECT_EQ(drive->counters().bad_frames, 4U);
  EXPECT_EQ(drive->counters().duplicates, 4U);
  drive->receive(too_short, now);
  EXPECT_EQ(drive->first_finding(), DriveFinding::bad_frames);
  EXPECT_EQ(drive->phase(), DrivePhase::following);
}

TEST_F(DriveOfNode5, NowAndThenABadFrameIsForgiven) {
  bring_to_following();
  Frame too_short = feedback_frame(node(5), {});
  too_short.length = 1;
  for (int i = 0; i < 30 * 260; ++i) {
    if (i % 260 == 0) drive->receive(too_short, now);
    tick(following, 700, 700);
  }
  EXPECT_TRUE(drive->findings().empty());
  EXPECT_EQ(drive->counters().bad_frames, 30U);
}

TEST_F(DriveOfNode5, AForeignCommandIsAFinding) {  // docs/faults.md 17
  bring_to_following();
  drive->note_foreign_frame();
  EXPECT_EQ(drive->first_finding(), DriveFinding::foreign_sender);
  EXPECT_EQ(drive->counters().foreign_frames, 1U);
}

TEST_F(DriveOfNode5, AHeartbeatThatStopsIsFoundWithinItsTimeout) {  // docs/faults.md 21
  bring_to_following();
  const std::int64_t heard = now - 4 * ms;
  std::int64_t found = 0;
  for (int i = 0; i < 60 && found == 0; ++i) {
    feedback(following, 700);
    silent_tick(700);
    if (has_found(DriveFinding::heartbeat_lost)) found = now;
  }
  EXPECT_GT(found, 0);
  EXPECT_LE(found - heard, 154 * ms);
  EXPECT_EQ(drive->phase(), DrivePhase::following) << "it still follows the others on their way to rest";
  tick(following, 700, 700);
  EXPECT_TRUE(drive->lasting().empty());
}

TEST_F(DriveOfNode5, AnEmergencyInMotionIsAFindingWithItsCode) {  // docs/faults.md 23
  bring_to_following();
  drive->receive(emergency_frame(node(5), {.code = 0x2310, .error_register = 3}), now);
  EXPECT_FALSE(drive->first_finding()) << "it may be a warning";
  feedback(in_fault, 700);
  EXPECT_EQ(drive->first_finding(), DriveFinding::emergency) << "at once";
  EXPECT_STREQ(words_of_emergency(drive->last_emergency().code), "over-current");
  drive->receive(emergency_frame(node(5), {}), now);
  EXPECT_EQ(drive->last_emergency().code, 0x2310) << "that it is gone does not say which it was";
  EXPECT_EQ(drive->counters().emergencies, 1U);
}

TEST_F(DriveOfNode5, AnEmergencyThatTheStatuswordDoesNotExplainIsAFindingAfterAMoment) {  // docs/faults.md 23
  bring_to_following();
  drive->receive(emergency_frame(node(5), {.code = 0x8110}), now);
  for (int i = 0; i < 5; ++i) tick(following, 700, 700);
  EXPECT_TRUE(drive->findings().empty());
  tick(following, 700, 700);
  EXPECT_EQ(drive->first_finding(), DriveFinding::emergency);
}

TEST_F(DriveOfNode5, AnEmergencyThatWarnsIsCounted) {  // docs/faults.md 23
  bring_to_following();
  drive->receive(emergency_frame(node(5), {.code = 0x4210}), now);
  for (int i = 0; i < 20; ++i) tick(following | 0x80, 700, 700);
  EXPECT_TRUE(drive->findings().empty());
  EXPECT_EQ(drive->counters().emergencies, 1U);
  EXPECT_EQ(drive->last_emergency().code, 0x4210);
}

TEST_F(DriveOfNode5, AFaultInMotionIsAFinding) {  // docs/faults.md 23
  bring_to_following();
  EXPECT_EQ(tick(0x021F, 700, 700)->controlword, 0x0000);
  EXPECT_EQ(drive->first_finding(), DriveFinding::drive_fault);
  EXPECT_EQ(drive->phase(), DrivePhase::idle);
  EXPECT_EQ(tick(in_fault, 650, 700), (DriveCommand{.controlword = 0x0000, .target = 650}));
}

TEST_F(DriveOfNode5, ADriveThatStopsByItselfIsLeftToItsRamp) {
  bring_to_following();
  EXPECT_EQ(tick(quick_stopped, 700, 700)->controlword, 0x0002);
  EXPECT_EQ(drive->first_finding(), DriveFinding::left_operation);
  EXPECT_EQ(drive->phase(), DrivePhase::stopping);
}

TEST_F(DriveOfNode5, ADriveThatSwitchesOffIsAFinding) {
  bring_to_following();
  tick(ready, 700, 700);
  EXPECT_EQ(drive->first_finding(), DriveFinding::left_operation);
  EXPECT_EQ(drive->phase(), DrivePhase::idle);
}

TEST_F(DriveOfNode5, AnUnexpectedBootUpMessageLosesTheReference) {  // docs/faults.md 24
  bring_to_following();
  heartbeat(NmtState::boot_up);
  EXPECT_EQ(drive->first_finding(), DriveFinding::unexpected_boot);
  EXPECT_TRUE(words_of(*drive->first_finding()).loses_reference);
  EXPECT_EQ(drive->phase(), DrivePhase::gone);
  EXPECT_FALSE(silent_tick(700)) << "nothing is sent to it";
  drive->acknowledge();
  EXPECT_FALSE(drive->enable(now));
  EXPECT_TRUE(drive->connect(now)) << "from the beginning";
}

TEST_F(DriveOfNode5, ADriveThatLeavesOperationalIsGone) {
  bring_to_following();
  heartbeat(NmtState::pre_operational);
  feedback(following, 700);
  EXPECT_FALSE(silent_tick(700));
  EXPECT_EQ(drive->first_finding(), DriveFinding::left_operational);
  EXPECT_EQ(drive->phase(), DrivePhase::gone);
}

TEST_F(DriveOfNode5, AFollowingErrorAsksForAStopAndThenAQuickStop) {  // docs/faults.md 25
  bring_to_following();
  EXPECT_TRUE(tick(following | 0x2000, 700, 700));
  EXPECT_EQ(drive->first_finding(), DriveFinding::following_error);
  EXPECT_EQ(words_of(*drive->first_finding()).reaction, DriveReaction::own_stop);
  EXPECT_EQ(drive->phase(), DrivePhase::following);
}

TEST_F(DriveOfNode5, AnInternalLimitMayBeThereForAMomentOnly) {  // docs/faults.md 26
  bring_to_following();
  for (int i = 0; i < 5; ++i) tick(following | 0x0800, 700, 700);
  tick(following, 700, 700);
  for (int i = 0; i < 5; ++i) tick(following | 0x0800, 700, 700);
  EXPECT_TRUE(drive->findings().empty());
  tick(following | 0x0800, 700, 700);
  EXPECT_EQ(drive->first_finding(), DriveFinding::internal_limit);
}

TEST_F(DriveOfNode5, AnotherModeIsAFindingAtOnce) {  // docs/faults.md 26
  bring_to_following();
  heartbeat(NmtState::operational);
  feedback(following, 700, 1);
  EXPECT_TRUE(silent_tick(700));
  EXPECT_EQ(drive->first_finding(), DriveFinding::wrong_mode);
}

TEST_F(DriveOfNode5, Bit12MayBeClearForAMomentOnly) {  // docs/faults.md 26
  bring_to_following();
  for (int i = 0; i < 4; ++i) tick(enabled, 700, 700);
  tick(following, 700, 700);
  for (int i = 0; i < 5; ++i) tick(enabled, 700, 700);
  EXPECT_TRUE(drive->findings().empty());
  tick(enabled, 700, 700);
  EXPECT_EQ(drive->first_finding(), DriveFinding::target_ignored);
}

TEST_F(DriveOfNode5, SettingsWithoutLimitsAreRefused) {
  const auto refuses = [&](auto change) {
    Cia402Settings bad = settings_of(5);
    change(bad);
    return !Cia402Drive::make(bad);
  };
  EXPECT_FALSE(refuses([](Cia402Settings&) {}));
  EXPECT_TRUE(refuses([](Cia402Settings& bad) { bad.max_step_counts = 0; }));
  EXPECT_TRUE(refuses([](Cia402Settings& bad) { bad.missing_limit = 0; }));
  EXPECT_TRUE(refuses([](Cia402Settings& bad) { bad.boot_timeout_ns = 0; }));
  EXPECT_TRUE(refuses([](Cia402Settings& bad) { bad.heartbeat_timeout_ns = 99 * ms; }));
  EXPECT_TRUE(refuses([](Cia402Settings& bad) { bad.setup.host_timeout_ms = 0; }));
}

TEST(DriveMemory, ADriveFitsIntoTwoAndAHalfKilobytes) {
  EXPECT_LE(sizeof(Cia402Drive), 2432U);
}

}  // namespace can_drive_test
}  // namespace inbetween::can
