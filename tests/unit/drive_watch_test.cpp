// What the host of every drive watches it with, whatever its protocol: each class alone.
#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "inbetween/can/drive_finding.hpp"
#include "inbetween/can/drive_phase.hpp"
#include "inbetween/can/rest_watch.hpp"
#include "inbetween/can/servo_report.hpp"
#include "inbetween/can/silence_watch.hpp"
#include "inbetween/can/standing_order.hpp"

namespace inbetween::can {
namespace drive_watch_test {

// --- what was found

TEST(FindingLog, AFindingStaysUntilItIsAcknowledgedAndLastsForATick) {
  FindingLog log({});
  EXPECT_TRUE(log.empty());
  log.find_lasting(DriveFinding::following_error);
  log.find(DriveFinding::drive_fault);
  EXPECT_EQ(log.lasting(), DriveFinding::following_error);
  log.begin_tick();
  EXPECT_TRUE(log.lasting().empty());
  EXPECT_TRUE(log.all().has(DriveFinding::following_error));
  EXPECT_TRUE(log.all().has(DriveFinding::drive_fault));
  log.acknowledge();
  EXPECT_TRUE(log.empty());
}

TEST(FindingLog, TheFirstFindingIsTheFirstSinceItWasAcknowledged) {
  FindingLog log({});
  EXPECT_FALSE(log.first());
  log.find(DriveFinding::setpoint_jump);
  log.find(DriveFinding::never_booted);
  EXPECT_EQ(log.first(), DriveFinding::setpoint_jump);
  log.acknowledge();
  EXPECT_FALSE(log.first());
  log.find_lasting(DriveFinding::never_booted);
  EXPECT_EQ(log.first(), DriveFinding::never_booted);
}

TEST(FindingLog, OneBadFrameMoreThanTheLimitIsAFinding) {
  FindingLog log({.limit = 2, .ticks = 10});
  std::uint32_t counter = 0;
  log.take_bad_frame(counter);
  log.take_bad_frame(counter);
  EXPECT_TRUE(log.empty());
  log.take_bad_frame(counter);
  EXPECT_EQ(log.first(), DriveFinding::bad_frames);
  EXPECT_EQ(counter, 3U);
}

TEST(FindingLog, ABadFrameIsForgivenInEveryFewTicksAndNoneInAdvance) {
  FindingLog log({.limit = 1, .ticks = 3});
  std::uint32_t counter = 0;
  for (int tick = 0; tick < 30; ++tick) log.forgive();
  log.take_bad_frame(counter);
  for (int tick = 0; tick < 2; ++tick) log.forgive();
  EXPECT_TRUE(log.empty());
  log.forgive();  // the third forgives that one
  log.take_bad_frame(counter);
  EXPECT_TRUE(log.empty());
  log.take_bad_frame(counter);
  EXPECT_EQ(log.first(), DriveFinding::bad_frames);
}

TEST(FindingLog, WhoAcknowledgesForgivesAllBadFrames) {
  FindingLog log({.limit = 1, .ticks = 100});
  std::uint32_t counter = 0;
  log.take_bad_frame(counter);
  log.acknowledge();
  log.take_bad_frame(counter);
  EXPECT_TRUE(log.empty());
}

// --- in which phase it is

struct Phases {
  bool apply(DriveEvent event, std::int64_t now_ns) {
    return clock.apply(event, now_ns, [&] { entered.push_back(clock.phase()); });
  }
  PhaseClock clock;
  std::vector<DrivePhase> entered;
};

TEST(PhaseClock, AnEventEntersThePhaseThatFollowsOnce) {
  Phases phases;
  EXPECT_TRUE(phases.apply(DriveEvent::connect, 5));
  EXPECT_EQ(phases.entered, std::vector{DrivePhase::booting});
  EXPECT_EQ(phases.clock.phase(), DrivePhase::booting);
  EXPECT_EQ(phases.clock.before(), DrivePhase::off);
  EXPECT_EQ(phases.clock.since_ns(), 5);
}

TEST(PhaseClock, AWishThatIsRefusedAndAnEventWithoutEffectEnterNothing) {
  Phases phases;
  phases.apply(DriveEvent::connect, 5);
  phases.clock.set_deadline(100);
  EXPECT_FALSE(phases.apply(DriveEvent::enable, 6));
  EXPECT_TRUE(phases.apply(DriveEvent::quick_stop, 7));
  EXPECT_EQ(phases.entered.size(), 1U);
  EXPECT_EQ(phases.clock.before(), DrivePhase::off);
  EXPECT_EQ(phases.clock.since_ns(), 5);
  EXPECT_TRUE(phases.clock.is_late(100)) << "the deadline of the phase stands";
}

TEST(PhaseClock, APhaseHasItsOwnDeadlineOrNone) {
  Phases phases;
  EXPECT_FALSE(phases.clock.is_late(std::numeric_limits<std::int64_t>::max() - 1));
  phases.apply(DriveEvent::connect, 0);
  phases.clock.set_deadline(100);
  EXPECT_FALSE(phases.clock.is_late(99));
  EXPECT_TRUE(phases.clock.is_late(100));
  phases.apply(DriveEvent::booted, 50);
  EXPECT_FALSE(phases.clock.is_late(1000)) << "that was the deadline of booting";
  phases.clock.set_deadline(2000);
  phases.clock.clear_deadline();
  EXPECT_FALSE(phases.clock.is_late(3000));
}

TEST(PhaseClock, EveryPhaseIsWatchedOrNotAsItsPowerAsks) {
  using enum DrivePhase;
  Phases phases;
  const auto follow = [&](DriveEvent event) {
    EXPECT_TRUE(phases.apply(event, 0));
    const PhaseClock& clock = phases.clock;
    return std::vector{clock.is_switching_on(), clock.is_to_have_power(), clock.is_supervised(),
                       clock.is_leaving()};
  };
  using Answers = std::vector<bool>;
  EXPECT_EQ(follow(DriveEvent::connect), (Answers{false, false, false, false}));
  EXPECT_EQ(follow(DriveEvent::booted), (Answers{false, false, false, false}));
  EXPECT_EQ(follow(DriveEvent::configured), (Answers{false, false, false, false}));
  EXPECT_EQ(follow(DriveEvent::started), (Answers{false, false, true, false}));    // idle
  EXPECT_EQ(follow(DriveEvent::enable), (Answers{true, false, true, false}));      // clearing
  EXPECT_EQ(follow(DriveEvent::cleared), (Answers{true, true, true, false}));      // enabling
  EXPECT_EQ(follow(DriveEvent::enabled), (Answers{false, true, true, false}));     // following
  EXPECT_EQ(follow(DriveEvent::quick_stop), (Answers{false, true, true, false}));  // stopping
  EXPECT_EQ(follow(DriveEvent::disable), (Answers{false, false, false, true}));    // disabling
  EXPECT_EQ(follow(DriveEvent::disabled), (Answers{false, false, false, true}));
  EXPECT_EQ(follow(DriveEvent::leave), (Answers{false, false, false, true}));
  EXPECT_EQ(follow(DriveEvent::left), (Answers{false, false, false, false}));
  EXPECT_EQ(phases.clock.phase(), off);
}

// --- whether its axis rests

TEST(RestWatch, AnAxisRestsAfterATimeAtOnePlace) {
  RestWatch watch(2, 10);
  EXPECT_FALSE(watch.since_ns());
  watch.look(5, 100);
  EXPECT_FALSE(watch.rests());
  watch.look(7, 109);
  EXPECT_FALSE(watch.rests());
  watch.look(3, 110);
  EXPECT_TRUE(watch.rests()) << "up to 2 from 5, for 10";
  EXPECT_EQ(watch.since_ns(), 100);
}

TEST(RestWatch, OneThatCreepsAwayFromItsPlaceDoesNotRest) {
  RestWatch watch(2, 10);
  for (int i = 0; i < 100; ++i) {
    watch.look(0.5 * i, 2 * i);
    EXPECT_FALSE(watch.rests()) << i;
  }
  RestWatch slow(2, 10);
  slow.look(0, 0);
  slow.look(2.5, 20);
  EXPECT_FALSE(slow.rests());
  EXPECT_EQ(slow.since_ns(), 20);
}

TEST(RestWatch, APlaceThatIsNoNumberIsNoRest) {
  RestWatch watch(2, 10);
  for (int i = 0; i < 100; ++i) watch.look(std::numeric_limits<double>::quiet_NaN(), i);
  EXPECT_FALSE(watch.rests());
}

TEST(RestWatch, BegunAnewItHasSeenNothing) {
  RestWatch watch(2, 10);
  watch.look(5, 0);
  watch.look(5, 10);
  ASSERT_TRUE(watch.rests());
  watch.begin();
  EXPECT_FALSE(watch.rests());
  watch.look(5, 11);
  EXPECT_FALSE(watch.rests());
  watch.look(5, 21);
  EXPECT_TRUE(watch.rests());
}

// Counts at opposite ends of their range are exact in a double.
TEST(RestWatch, CountsMayBeAtTheEndsOfTheirRange) {
  constexpr auto least = std::numeric_limits<std::int32_t>::min();
  constexpr auto most = std::numeric_limits<std::int32_t>::max();
  RestWatch watch(10, 10);
  watch.look(least, 0);
  watch.look(least + 10, 10);
  EXPECT_TRUE(watch.rests());
  watch.look(most, 20);
  EXPECT_FALSE(watch.rests());
  watch.look(most - 11, 30);
  EXPECT_FALSE(watch.rests());
}

// --- whether it is heard

TEST(SilenceWatch, ASilenceIsLongerThanTheLimit) {
  SilenceWatch watch(10);
  watch.hear(100);
  EXPECT_FALSE(watch.is_silent(110));
  EXPECT_TRUE(watch.is_silent(111));
  watch.hear(115);
  EXPECT_FALSE(watch.is_silent(120));
}

TEST(SilenceWatch, OneThatSomebodySawIsRememberedUntilAllBeginsAnew) {
  SilenceWatch watch(10);
  watch.hear(100);
  watch.look(105);
  EXPECT_FALSE(watch.was_silent());
  watch.look(120);
  EXPECT_TRUE(watch.was_silent());
  watch.hear(121);
  watch.look(122);
  EXPECT_TRUE(watch.was_silent());
  watch.begin();
  watch.look(123);
  EXPECT_FALSE(watch.was_silent());
}

TEST(SilenceWatch, OneThatEndedIsKnownThoughNobodyLooked) {
  SilenceWatch watch(10);
  watch.hear(100);
  watch.hear(108);
  EXPECT_TRUE(watch.was_heard_since(101));
  watch.hear(120);
  EXPECT_FALSE(watch.was_heard_since(110));
  EXPECT_FALSE(watch.was_heard_since(120));
  EXPECT_TRUE(watch.was_heard_since(121));
  EXPECT_FALSE(watch.was_silent());
}

// --- what it is ordered

TEST(StandingOrder, IsSentAtOnceAndAgainUntilItIsWithdrawn) {
  StandingOrder order(100);
  EXPECT_FALSE(order.next(0));
  order.give(ServoOrder::switch_off);
  EXPECT_TRUE(order.stands());
  EXPECT_EQ(order.next(7), ServoOrder::switch_off);
  EXPECT_FALSE(order.next(106));
  EXPECT_EQ(order.next(107), ServoOrder::switch_off);
  order.withdraw();
  EXPECT_FALSE(order.stands());
  EXPECT_FALSE(order.next(1000));
}

TEST(StandingOrder, TheNextOneTakesItsPlaceAndDoesNotWait) {
  StandingOrder order(100);
  order.give(ServoOrder::clear_errors);
  EXPECT_TRUE(order.next(0));
  order.give(ServoOrder::switch_off);
  EXPECT_TRUE(order.is(ServoOrder::switch_off));
  EXPECT_FALSE(order.is(ServoOrder::clear_errors));
  EXPECT_FALSE(order.was_sent());
  EXPECT_EQ(order.next(1), ServoOrder::switch_off);
  EXPECT_TRUE(order.was_sent());
}

TEST(StandingOrder, ADriveIsToldOnceToSwitchOn) {
  StandingOrder order(100);
  order.give(ServoOrder::switch_on);
  EXPECT_EQ(order.next(0), ServoOrder::switch_on);
  for (int now = 1; now < 500; ++now) EXPECT_FALSE(order.next(now)) << now;
  EXPECT_TRUE(order.stands());
}

TEST(StandingOrder, OnlyWhatIsToldAfterItWasSentFirstAnswersIt) {
  StandingOrder order(100);
  EXPECT_FALSE(order.is_answered(1000)) << "nothing was ordered";
  order.give(ServoOrder::switch_off);
  EXPECT_FALSE(order.is_answered(1000)) << "nothing was sent";
  order.next(50);
  order.next(150);
  EXPECT_FALSE(order.is_answered(50));
  EXPECT_TRUE(order.is_answered(51));
  order.withdraw();
  EXPECT_TRUE(order.is_answered(51)) << "it was obeyed";
  order.begin();
  EXPECT_FALSE(order.is_answered(51)) << "that was in another phase";
  EXPECT_FALSE(order.stands());
}

// --- what it has told

TEST(ServoTold, ConnectedAnewItKeepsItsPlaceAndHasToldNothing) {
  ServoTold told;
  told.take({.place = ServoPlace{.turns = 3},
             .status = ServoStatus{.is_on = true},
             .is_expected_device = true,
             .version = 6,
             .knows_place = false,
             .has_watchdog = true,
             .is_another_device = true},
            5);
  EXPECT_TRUE(told.is_heard());
  EXPECT_TRUE(told.is_another_device);
  told.begin();
  EXPECT_FALSE(told.is_heard());
  EXPECT_EQ(told.place.turns, 3);
  EXPECT_TRUE(told.status.is_on);
  EXPECT_EQ(told.version, 6U);
  EXPECT_FALSE(told.is_expected_device || told.knows_place || told.has_watchdog || told.is_another_device);
}

TEST(ServoTold, WhatAReportDoesNotSayStays) {
  ServoTold told;
  told.take({.place = ServoPlace{.turns = 3}, .is_expected_device = false, .version = 6}, 5);
  EXPECT_FALSE(told.is_heard()) << "not how it is";
  told.take({.status = ServoStatus{.errors = 2}, .version = 7}, 9);
  EXPECT_TRUE(told.is_heard());
  EXPECT_EQ(told.place.turns, 3);
  EXPECT_EQ(told.place_ns, 5);
  EXPECT_EQ(told.status_ns, 9);
  EXPECT_EQ(told.is_expected_device, std::optional(false));
  EXPECT_EQ(told.version, 6U) << "a version comes with what it is";
}

TEST(ServoTold, BrakesAloneWhileItHasMissedItsHostAndIsNotOff) {
  ServoTold told;
  const auto brakes = [&](bool has_missed_host, bool is_off) {
    told.take({.status = ServoStatus{.is_off = is_off, .has_missed_host = has_missed_host}}, 1);
    return told.brakes_alone();
  };
  EXPECT_TRUE(brakes(true, false));
  EXPECT_FALSE(brakes(true, true));
  EXPECT_FALSE(brakes(false, false));
}

}  // namespace drive_watch_test
}  // namespace inbetween::can
