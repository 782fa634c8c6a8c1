// What drives of other makes do, and the standards allow: each quirk is a drive of the tests' own that has
// it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

#include "tests/support/quirk_scene.hpp"

namespace inbetween {
namespace can_quirks_test {

using can::DriveFinding;
using can::DrivePhase;
using testing::HasSubstr;

const QuirkRig stops_by_itself{.axis = "on_host_lost = \"stops\"\n"};

TEST(DriveQuirk, ADriveWithoutQuirksRuns) {
  QuirkScene scene("");
  EXPECT_TRUE(scene.runs()) << scene.trouble();
}

TEST(DriveQuirk, WithoutObject6007TheRigSaysWhatItDoesWithoutItsHost) {
  QuirkScene refused(R"(absent = ["6007"])");
  EXPECT_FALSE(refused.is_set_up());
  EXPECT_EQ(refused.host().first_finding(), DriveFinding::host_loss_unsaid);
  QuirkScene scene(R"(absent = ["6007"])", stops_by_itself);
  EXPECT_TRUE(scene.runs()) << scene.trouble();
}

// --- answers

TEST(DriveQuirk, AnAnswerWithMoreBytesThanWereAskedForIsTakenIfTheValueFits) {
  QuirkScene scene(
      R"(wide = ["605A", "605B", "605C", "605D", "605E", "6007", "1017", "1019", "1029:1", "60C2:1",
                              "60C2:2", "6060", "1400:2", "1400:5", "1600:0", "1800:2", "1800:3", "1A00:0"])");
  EXPECT_TRUE(scene.runs()) << scene.trouble();
  EXPECT_EQ(scene.drive.value(0x60C2, 2), 0xFDU);
}

TEST(DriveQuirk, AnAnswerWithMoreBytesThatHaveAValueIsRefused) {
  QuirkScene scene("wide = [\"605A\"]\nhigh_bytes = 0x10000");
  EXPECT_FALSE(scene.is_set_up());
  EXPECT_EQ(scene.host().first_finding(), DriveFinding::sdo_failed);
  EXPECT_THAT(scene.trouble(), HasSubstr("605Ah:0"));
}

TEST(DriveQuirk, AnAnswerOfFourBytesMayComeInSegments) {
  QuirkScene scene(R"(segmented = ["1000", "1005", "6502", "605A", "60C2:1", "1400:1", "1A00:3", "6060"])");
  EXPECT_TRUE(scene.runs()) << scene.trouble();
}

// --- what it has already

TEST(DriveQuirk, WhatItHasAlreadyIsNotWritten) {
  QuirkScene scene(R"(read_only = ["1006", "60C2:1", "60C2:2", "1029:1", "1019", "1401:1", "1801:1"]
                      values = { "60C2:1" = 4, "1401:1" = 0x80000305, "1801:1" = 0xC0000285 })");
  EXPECT_TRUE(scene.is_switched_on()) << scene.trouble();
  for (const unsigned index : {0x1006U, 0x1029U, 0x1019U, 0x1401U, 0x1801U}) {
    EXPECT_EQ(scene.drive.writes(index, index == 0x1006 || index == 0x1019 ? 0 : 1), 0) << std::hex << index;
  }
  EXPECT_EQ(scene.drive.writes(0x60C2, 1) + scene.drive.writes(0x60C2, 2), 0);
}

TEST(DriveQuirk, WhatIsFixedAtAnotherValueIsRefused) {
  QuirkScene scene("read_only = [\"60C2:1\"]\nvalues = { \"60C2:1\" = 2 }");
  EXPECT_FALSE(scene.is_set_up());
  EXPECT_THAT(scene.trouble(), HasSubstr("60C2h:1 is 2 (2h), not 4 (4h); 0601 0002h"));
}

constexpr std::string_view fixed_mapping = R"(
read_only = ["1400:1", "1400:2", "1600", "1600:1", "1600:2",
             "1800:1", "1800:2", "1800:3", "1A00", "1A00:1", "1A00:2", "1A00:3"]
[values]
"1400:1" = 0x205
"1400:2" = 1
"1600" = 2
"1600:1" = 0x60400010
"1600:2" = 0x607A0020
"1800:1" = 0x40000185
"1800:2" = 1
"1A00" = 3
"1A00:1" = 0x60410010
"1A00:2" = 0x60640020
"1A00:3" = )";

TEST(DriveQuirk, AMappingThatIsFixedAsItShallBeIsLeftAlone) {
  QuirkScene scene(std::string(fixed_mapping) + "0x60610008");
  EXPECT_TRUE(scene.runs()) << scene.trouble();
  for (const unsigned index : {0x1600U, 0x1A00U})
    EXPECT_EQ(scene.drive.writes(index), 0) << std::hex << index;
  EXPECT_EQ(scene.drive.writes(0x1400, 1) + scene.drive.writes(0x1800, 1), 0);
}

TEST(DriveQuirk, AMappingThatIsFixedAndAnotherIsRefused) {
  QuirkScene scene(std::string(fixed_mapping) + "0x60600008");
  EXPECT_FALSE(scene.is_set_up());
  EXPECT_THAT(scene.trouble(), HasSubstr("object 1800h:1"));
}

/// By how much a limit reaches beyond an axis that stands outside: half a millisecond of max_velocity.
constexpr std::int32_t stands_within = 83'886;
std::int32_t limit(const QuirkScene& scene, std::uint8_t sub) {
  return static_cast<std::int32_t>(scene.drive.value(0x607D, sub));
}

TEST(DriveQuirk, TheRangeIsWrittenInTheOrderInWhichItStaysConsistent) {
  for (const char* const range :
       {"min = 50\nmax = 200\n", "min = -200\nmax = -50\n", "min = 0\nmax = 200\n"}) {
    for (const char* const before : {"0", "-2000000000", "2000000000"}) {
      QuirkScene scene(
          "values = { \"607D:1\" = " + std::string(before) + ", \"607D:2\" = " + std::string(before) + " }",
          {.range = range});
      EXPECT_TRUE(scene.is_set_up()) << range << before << scene.trouble();
      // It stands at 0, where the middle one of these is at an end and the others are not: then they reach
      // there.
      const bool is_above = std::string(range).find("50") == 6;
      const bool is_below = std::string(range)[6] == '-';
      EXPECT_EQ(limit(scene, 1), is_above   ? -stands_within
                                 : is_below ? -167'772'160
                                            : 0 - stands_within)
          << range;
      EXPECT_EQ(limit(scene, 2), is_below ? stands_within : 167'772'160) << range;
    }
  }
}

// docs/faults.md 49. A drive clamps a target that is outside of its limits, and goes there by itself.
TEST(DriveQuirk, TheLimitsOfADriveReachToWhereTheAxisStandsAndNoFurtherUntilTheNextSetUp) {
  for (const bool is_below : {true, false}) {
    QuirkScene scene("", {.range = is_below ? "min = 1\nmax = 200\n" : "min = -200\nmax = -1\n"});
    ASSERT_TRUE(scene.is_switched_on()) << scene.trouble();
    const std::int32_t near = is_below ? 838'860 : -838'861 + 1;
    EXPECT_EQ(limit(scene, is_below ? 1 : 2), is_below ? -stands_within : stands_within);
    EXPECT_EQ(scene.drive.applied().back(), 0) << "it is held where it stands";
    for (int i = 0; i <= 125; ++i) scene.tick({(is_below ? 1 : -1) * i * 10'000});
    EXPECT_EQ(scene.trouble(), "") << "it comes in";
    EXPECT_EQ(scene.drive.applied().back(), is_below ? 1'240'000 : -1'240'000);
    scene.host().disable(scene.now_ns);
    scene.tick_until([&] { return scene.phase() == DrivePhase::disabled; });
    scene.host().leave(scene.now_ns);
    scene.tick_until([&] { return scene.phase() == DrivePhase::off; });
    ASSERT_TRUE(scene.host().connect(scene.now_ns));
    ASSERT_TRUE(scene.is_set_up()) << scene.trouble();
    EXPECT_NEAR(limit(scene, is_below ? 1 : 2), near, 1) << "inside, its own limits are right";
  }
}

// docs/faults.md 49
TEST(DriveQuirk, AnAxisThatIsMovedOutOfItsLimitsAfterItsSetUpIsNotSwitchedOn) {
  QuirkScene scene("");
  ASSERT_TRUE(scene.is_set_up()) << scene.trouble();
  scene.drive.push_to(-1'000'000);
  for (int i = 0; i < 10; ++i) scene.tick();
  EXPECT_FALSE(scene.is_switched_on());
  EXPECT_EQ(scene.host().first_finding(), DriveFinding::moved_outside);
  EXPECT_THAT(scene.trouble(), HasSubstr("inbetween goto"));
  EXPECT_EQ(scene.times_sent(0x205, {0x0F, 0x00}), 0);
}

// --- what it does not have

TEST(DriveQuirk, AModeThatIsNotOfferedMayBeTakenAllTheSame) {
  QuirkScene scene(R"(absent = ["6502"])");
  EXPECT_TRUE(scene.runs()) << scene.trouble();
}

TEST(DriveQuirk, WithoutObject6502AModeThatIsNotShownIsNotSwitchedOn) {
  QuirkScene scene("absent = [\"6502\"]\nshows_mode = \"never\"\nmode_shown = 1",
                   {.drive = ", enable_timeout_s = 1"});
  EXPECT_FALSE(scene.is_switched_on());
  EXPECT_EQ(scene.host().first_finding(), DriveFinding::mode_not_shown);
  EXPECT_TRUE(scene.drive.applied().empty());
}

TEST(DriveQuirk, ItsModeMayBeWriteOnly) {
  QuirkScene scene(R"(write_only = ["6060"])");
  EXPECT_TRUE(scene.runs()) << scene.trouble();
}

TEST(DriveQuirk, NothingElseMayBeWriteOnly) {
  QuirkScene scene(R"(write_only = ["6007"])");
  EXPECT_FALSE(scene.is_set_up());
  EXPECT_THAT(scene.trouble(), HasSubstr("6007h:0; 0601 0001h"));
}

TEST(DriveQuirk, WithoutObject6065TheRigSaysThatItWatchesItsFollowingError) {
  QuirkScene refused(R"(absent = ["6065"])");
  EXPECT_FALSE(refused.is_set_up());
  EXPECT_EQ(refused.host().first_finding(), DriveFinding::window_unsaid);
  QuirkScene scene(R"(absent = ["6065"])", {.drive = ", watches_following_error = true"});
  EXPECT_TRUE(scene.runs()) << scene.trouble();
  QuirkScene off(R"(values = { "6065" = 0xFFFFFFFF })", {.drive = ", watches_following_error = true"});
  EXPECT_FALSE(off.is_set_up()) << "it says that it does not";
}

TEST(DriveQuirk, WhatNothingDependsOnMayBeAbsent) {
  QuirkScene scene(
      R"(absent = ["607D:1", "607D:2", "1005", "1006", "1019", "1029:1", "1400:5", "1800:3", "1800:5"])");
  EXPECT_TRUE(scene.runs()) << scene.trouble();
}

TEST(DriveQuirk, WithoutObject60C2ThePeriodOfSyncTellsHowLongATickIs) {
  QuirkScene scene(R"(absent = ["60C2:1", "60C2:2"])");
  EXPECT_TRUE(scene.is_switched_on()) << scene.trouble();
  EXPECT_EQ(scene.drive.value(0x1006), 4000U);
  QuirkScene milliseconds(R"(absent = ["60C2:2"])");
  EXPECT_TRUE(milliseconds.is_switched_on()) << milliseconds.trouble();
  EXPECT_EQ(milliseconds.drive.value(0x60C2, 1), 4U);
  EXPECT_EQ(milliseconds.drive.value(0x1006), 0U);
}

// --- heartbeats, starting

TEST(DriveQuirk, AHeartbeatThatIsRoundedUpIsWaitedFor) {
  QuirkScene scene("heartbeat_step_ms = 100");
  EXPECT_TRUE(scene.runs()) << scene.trouble();
  EXPECT_EQ(scene.host().setup().drive_heartbeat_ms(), 100);
}

TEST(DriveQuirk, AHeartbeatOfMoreThanTwiceIsRefused) {
  QuirkScene scene("heartbeat_step_ms = 101");
  EXPECT_FALSE(scene.is_set_up());
  EXPECT_THAT(scene.trouble(), HasSubstr("1017h:0 is 101"));
}

TEST(DriveQuirk, ANodeThatStartsByItselfIsSentBackBeforeItIsMapped) {
  QuirkScene scene("starts_itself = true");
  EXPECT_TRUE(scene.runs()) << scene.trouble();
  QuirkScene ordinary("");
  EXPECT_TRUE(ordinary.is_set_up());
  EXPECT_EQ(ordinary.times_sent(0x000, {0x80, 5}), 0) << "others are not told";
}

TEST(DriveQuirk, ADriveThatObeysResetNodeOnlyNeedsTheRigToSaySo) {
  QuirkScene refused("boots_after_communication = false");
  EXPECT_FALSE(refused.is_set_up());
  EXPECT_EQ(refused.host().first_finding(), DriveFinding::never_booted);
  EXPECT_THAT(refused.trouble(), HasSubstr("reset = \"node\""));
  EXPECT_EQ(refused.times_sent(0x000, {0x81, 5}), 0);
  QuirkScene scene("boots_after_communication = false", {.drive = ", reset = \"node\""});
  EXPECT_TRUE(scene.runs()) << scene.trouble();
  EXPECT_EQ(scene.times_sent(0x000, {0x82, 5}), 0);
}

// --- life guarding

constexpr std::string_view knows_no_heartbeats = R"(absent = ["1016:1", "1017", "1400:5"])";
const QuirkRig guards{.drive = ", watchdog = \"life-guarding\""};

TEST(DriveQuirk, ADriveWithoutHeartbeatsIsRefusedUnlessTheRigGuardsIt) {
  QuirkScene refused(R"(absent = ["1016:1", "1400:5"])");
  EXPECT_FALSE(refused.is_set_up());
  EXPECT_EQ(refused.host().first_finding(), DriveFinding::watchdog_unset);
  EXPECT_THAT(refused.trouble(), HasSubstr("watchdog = \"life-guarding\""));
  QuirkScene scene(knows_no_heartbeats, guards);
  EXPECT_TRUE(scene.runs()) << scene.trouble();
  EXPECT_EQ(scene.drive.value(0x100C) + scene.drive.value(0x100D), 0U) << "it is let go";
}

TEST(DriveQuirk, GuardingNeedsItsObjectsAndALifeTimeThatWasAskedFor) {
  for (const char* const quirks :
       {R"(absent = ["1016:1", "1400:5", "100C"])", R"(absent = ["1016:1", "1400:5", "100D"])",
        "read_only = [\"100D\"]", "read_only = [\"100C\"]\nvalues = { \"100C\" = 500 }",
        "read_only = [\"100D\"]\nvalues = { \"100D\" = 200 }"}) {
    QuirkScene scene(quirks, guards);
    EXPECT_FALSE(scene.is_set_up()) << quirks;
    EXPECT_THAT(scene.trouble(), HasSubstr("object 100")) << quirks;
  }
}

TEST(DriveQuirk, AGuardedDriveIsAskedInTimeAndItsHeartbeatIsOff) {
  QuirkScene scene("values = { \"1017\" = 100 }", guards);
  ASSERT_TRUE(scene.is_switched_on()) << scene.trouble();
  EXPECT_EQ(scene.drive.value(0x1017), 0U);
  EXPECT_EQ(scene.drive.value(0x100C) * scene.drive.value(0x100D), 120U);
  const std::int32_t held = scene.host().target();
  scene.sent.clear();
  for (int i = 0; i < 250; ++i) scene.tick({held});
  EXPECT_TRUE(scene.host().findings().empty()) << scene.trouble();
  const auto is_question = [](const can::Frame& frame) { return frame.is_remote && frame.id == 0x705; };
  EXPECT_NEAR(static_cast<double>(std::ranges::count_if(scene.sent, is_question)), 1000 / 30.0, 3);
}

TEST(DriveQuirk, AGuardedDriveStopsByItselfWhenSetpointsAndQuestionsCease) {
  QuirkScene scene(knows_no_heartbeats, guards);
  ASSERT_TRUE(scene.is_switched_on()) << scene.trouble();
  scene.tick({scene.host().target()});
  scene.sent.clear();
  int ticks = 0;
  for (; scene.drive.has_power() && ticks < 100; ++ticks) scene.tick();
  EXPECT_LE(4 * ticks, 120 + 4);  // ms
  for (const can::Frame& frame : scene.sent) EXPECT_FALSE(frame.is_remote);
  EXPECT_EQ(scene.host().last_emergency().code, 0x8130);
}

TEST(DriveQuirk, AGuardedDriveThatGivesTheSameAnswerAgainIsFoundByIt) {
  QuirkScene scene("toggles = false", guards);
  scene.tick_until([&] { return !scene.host().findings().empty(); });
  EXPECT_EQ(scene.host().first_finding(), DriveFinding::guard_answer_repeated);
  const auto is_question = [](const can::Frame& frame) { return frame.id == 0x705 && frame.is_remote; };
  EXPECT_EQ(std::ranges::count_if(scene.sent, is_question), 2)
      << "the first answer is right, and the second is found at once";
}

TEST(DriveQuirk, AnAnswerThatIsLostOrComesTwiceIsNoWrongToggleBit) {
  for (const char* const habit : {"loses_answer = 5", "doubles_answer = 5"}) {
    QuirkScene scene(habit, guards);
    EXPECT_TRUE(scene.runs()) << habit << scene.trouble();
    EXPECT_EQ(scene.host().counters().bad_frames, 1U) << habit;
  }
}

// --- in operation

TEST(DriveQuirk, ALimitForAMomentIsNone) {
  QuirkScene scene("bit_11_ms = 16");
  EXPECT_TRUE(scene.runs()) << scene.trouble();
  QuirkScene longer("bit_11_ms = 40");
  EXPECT_FALSE(longer.runs());
  EXPECT_EQ(longer.host().first_finding(), DriveFinding::internal_limit);
}

TEST(DriveQuirk, AnEmergencyThatIsAWarningIsCountedAndTheMoveGoesOn) {
  QuirkScene scene("emergency = 0x4210\nwarns = true");
  EXPECT_TRUE(scene.runs()) << scene.trouble();
  EXPECT_EQ(scene.host().counters().emergencies, 1U);
  EXPECT_EQ(scene.host().last_emergency().code, 0x4210);
}

TEST(DriveQuirk, AnEmergencyThatNothingExplainsIsAFinding) {
  QuirkScene scene("emergency = 0x8110");
  EXPECT_FALSE(scene.runs());
  EXPECT_EQ(scene.host().first_finding(), DriveFinding::emergency);
  QuirkScene fault("emergency = 0x2310\nfails = true");
  EXPECT_FALSE(fault.runs());
  EXPECT_EQ(fault.host().first_finding(), DriveFinding::emergency);
  QuirkScene both("emergency = 0x2310\nfails = true\nwarns = true");
  EXPECT_FALSE(both.runs()) << "a fault is none";
  EXPECT_EQ(both.host().first_finding(), DriveFinding::emergency);
}

TEST(DriveQuirk, ADriveWithoutBit12IsToldSo) {
  QuirkScene scene("has_bit_12 = false", {.drive = ", enable_timeout_s = 1"});
  EXPECT_FALSE(scene.is_switched_on());
  EXPECT_EQ(scene.host().first_finding(), DriveFinding::follow_bit_missing);
  EXPECT_THAT(scene.trouble(), HasSubstr("bit 12"));
}

// --- a mode that is shown once it is enabled

TEST(DriveQuirk, AModeThatIsShownOnlyOnceItIsEnabledIsWaitedForInOperation) {
  QuirkScene scene("shows_mode = \"enabled\"\nmode_delay_ms = 12");
  EXPECT_TRUE(scene.runs()) << scene.trouble();
}

TEST(DriveQuirk, WithoutItsModeSoonAfterItIsEnabledItIsStopped) {
  QuirkScene scene("shows_mode = \"enabled\"\nmode_delay_ms = 100");
  EXPECT_FALSE(scene.is_switched_on());
  EXPECT_EQ(scene.host().first_finding(), DriveFinding::mode_not_shown);
  scene.tick();
  EXPECT_GE(scene.times_sent(0x205, {0x02, 0x00}), 1) << "a quick stop";
  EXPECT_EQ(scene.phase(), DrivePhase::stopping);
  EXPECT_FALSE(scene.drive.is_in_operation());
  for (const std::int32_t target : scene.drive.applied()) EXPECT_EQ(target, 0);
}

TEST(DriveQuirk, AModeThatIsAnotherIsNeverEnabled) {
  QuirkScene scene("shows_mode = \"enabled\"\nmode_shown = 1", {.drive = ", enable_timeout_s = 1"});
  EXPECT_FALSE(scene.is_switched_on());
  EXPECT_EQ(scene.host().first_finding(), DriveFinding::mode_not_shown);
  EXPECT_EQ(scene.times_sent(0x205, {0x0F, 0x00}), 0);
}

TEST(DriveQuirk, WithAVelocityOrATorqueAskedOfItADriveWithoutAModeIsNeverEnabled) {
  for (const char* const other : {"60FF", "6071"}) {
    QuirkScene scene("shows_mode = \"enabled\"\nsizes = { \"" + std::string(other) +
                         (std::string(other) == "60FF" ? "\" = 4 }" : "\" = 2 }"),
                     {.drive = ", enable_timeout_s = 1"});
    EXPECT_FALSE(scene.is_switched_on());
    EXPECT_EQ(scene.times_sent(0x205, {0x0F, 0x00}), 0);
  }
}

// --- times and tolerances

TEST(DriveQuirk, ABrakeMayTakeItsTime) {
  QuirkScene scene("brake_ms = 3000");
  EXPECT_TRUE(scene.runs()) << scene.trouble();
  QuirkScene longer("brake_ms = 7000");
  EXPECT_FALSE(longer.is_switched_on());
  EXPECT_EQ(longer.host().first_finding(), DriveFinding::not_enabled);
  QuirkScene allowed("brake_ms = 7000", {.drive = ", enable_timeout_s = 8"});
  EXPECT_TRUE(allowed.runs()) << allowed.trouble();
}

TEST(DriveQuirk, AnAxisThatSagsByAQuarterOfAMicrometreHoldsItsPlace) {
  QuirkScene scene("sag_counts = 201");
  EXPECT_TRUE(scene.runs()) << scene.trouble();
  QuirkScene falls("sag_counts = 90000");  // 0.107 mm
  EXPECT_FALSE(falls.is_switched_on());
  EXPECT_EQ(falls.host().first_finding(), DriveFinding::moved_while_enabling);
}

TEST(DriveQuirk, TheFirstTargetIsNoFurtherThanATickFromRest) {
  const std::int32_t tick_from_rest = 5369;  // 0.5 * 800 mm/s^2 * (4 ms)^2
  QuirkScene near("");
  ASSERT_TRUE(near.is_switched_on());
  near.tick({near.host().target() + tick_from_rest});
  EXPECT_TRUE(near.host().findings().empty());
  QuirkScene far("");
  ASSERT_TRUE(far.is_switched_on());
  const std::int32_t held = far.host().target();
  far.tick({held + tick_from_rest + 1});
  far.tick();
  EXPECT_EQ(far.host().first_finding(), DriveFinding::moved_while_enabling);
  for (const std::int32_t target : far.drive.applied()) EXPECT_EQ(target, held);
}

}  // namespace can_quirks_test
}  // namespace inbetween
