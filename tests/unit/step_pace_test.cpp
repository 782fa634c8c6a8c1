#include "drivers/gpio/step_pace.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

namespace inbetween::gpio {
namespace step_pace_test {

constexpr StepPaceLimits limits{.tolerated_late_ns = 50'000, .min_spacing_ns = 5'000};
constexpr std::int64_t ms = 1'000'000;

/// A call that begins this late takes no time.
bool play(StepPace& pace, std::int64_t at_ns, std::int64_t late_ns = 0) {
  const std::int64_t begun_ns = pace.due_ns(at_ns) + late_ns;
  return pace.note_played(at_ns, begun_ns, begun_ns);
}

TEST(StepPace, WhatIsOnTimeStaysOnTime) {
  StepPace pace(limits);
  for (std::int64_t at_ns = 0; at_ns < 100 * ms; at_ns += ms) {
    EXPECT_EQ(pace.due_ns(at_ns), at_ns);
    EXPECT_FALSE(play(pace, at_ns));
  }
  EXPECT_EQ(pace.shift_ns(), 0);
}

TEST(StepPace, ALateInstantMovesAllThatFollowByItsLateness) {
  StepPace pace(limits);
  play(pace, 1 * ms);
  EXPECT_TRUE(play(pace, 2 * ms, 300'000));
  EXPECT_EQ(pace.shift_ns(), 300'000);
  for (std::int64_t at_ns = 3 * ms; at_ns < 100 * ms; at_ns += ms) {
    EXPECT_EQ(pace.due_ns(at_ns), at_ns + 300'000);
    EXPECT_FALSE(play(pace, at_ns));
  }
  EXPECT_TRUE(play(pace, 100 * ms, 200'000));
  EXPECT_EQ(pace.due_ns(101 * ms), 101 * ms + 500'000);
}

TEST(StepPace, TheShiftEndsWhereTheSeriesDoesAndSpacingsHoldEvenSo) {
  StepPace pace(limits);
  play(pace, 1 * ms, 10 * ms);
  pace.end_series();
  EXPECT_EQ(pace.due_ns(200 * ms), 200 * ms) << "stood still for long enough";
  EXPECT_EQ(pace.due_ns(65 * ms), 65 * ms) << "that, too";
  EXPECT_EQ(pace.due_ns(50 * ms), 11 * ms + 49 * ms - 49 * ms / 16) << "does not stand still yet";
  EXPECT_EQ(pace.due_ns(2 * ms), 11 * ms + ms - ms / 16) << "goes on at once";
}

TEST(StepPace, AfterAShiftAPauseIsShortenedToATimeOfRestAndNoFurther) {
  StepPace pace(limits);
  play(pace, 1 * ms, 100 * ms);
  pace.end_series();
  EXPECT_EQ(pace.due_ns(120 * ms), 151 * ms);
  EXPECT_EQ(pace.due_ns(151 * ms), 151 * ms);
  EXPECT_EQ(pace.due_ns(152 * ms), 152 * ms);
}

TEST(StepPace, ALatenessThatIsToleratedIsMadeGoodByASixteenthOfWhatFollows) {
  StepPace pace(limits);
  play(pace, 0);
  EXPECT_FALSE(play(pace, 100'000, 50'000));
  EXPECT_EQ(pace.shift_ns(), 0);
  std::int64_t before_ns = 150'000;
  int hurried = 0;
  for (std::int64_t at_ns = 200'000; pace.due_ns(at_ns) > at_ns; at_ns += 100'000, ++hurried) {
    EXPECT_EQ(pace.due_ns(at_ns), before_ns + 93'750);
    before_ns = pace.due_ns(at_ns);
    play(pace, at_ns);
  }
  EXPECT_EQ(hurried, 7);  // 50 us in parts of 6.25 us: the eighth is on time
}

TEST(StepPace, TheLittleThatEveryCallIsLateByDoesNotAddUp) {
  StepPace pace(limits);
  std::int64_t worst_ns = 0;
  for (std::int64_t at_ns = 0; at_ns < 1'000 * ms; at_ns += 20'000) {
    const std::int64_t begun_ns = pace.due_ns(at_ns) + 900;
    worst_ns = std::max(worst_ns, begun_ns - at_ns);
    pace.note_played(at_ns, begun_ns, begun_ns + 700);
  }
  EXPECT_EQ(pace.shift_ns(), 0);
  EXPECT_LE(worst_ns, 1'800);
}

TEST(StepPace, APulseIsNotShortenedByTheTimeOfACall) {
  StepPace pace(limits);
  pace.note_played(0, 0, 4'000);
  EXPECT_EQ(pace.due_ns(5'000), 9'000);
  EXPECT_EQ(pace.due_ns(3'000), 7'000) << "planned shorter";
}

TEST(StepPace, AnInstantBeforeTheOneBeforeItFollowsItAtOnce) {
  StepPace pace(limits);
  play(pace, 10 * ms);
  EXPECT_EQ(pace.due_ns(9 * ms), 10 * ms);
  EXPECT_TRUE(play(pace, 9 * ms));
}

// Whatever happens: nothing early, nothing closer than a 16th below plan nor than the least spacing.
TEST(StepPace, AfterAnyLatenessThereIsNoBurst) {
  std::mt19937 random(20);  // NOLINT(bugprone-random-generator-seed): the same every time
  std::uniform_int_distribution<std::int64_t> spacing_ns(1'000, 300'000);
  std::uniform_int_distribution<std::int64_t> jitter_ns(0, 60'000);
  StepPace pace(limits);
  std::int64_t at_ns = 0;
  std::int64_t begun_ns = 0;
  std::int64_t ended_ns = 0;
  pace.note_played(0, 0, 0);
  for (int i = 0; i < 100'000; ++i) {
    const std::int64_t planned_ns = spacing_ns(random);
    at_ns += planned_ns;
    if (random() % 1'000 == 0) pace.end_series();
    const std::int64_t shift_ns = pace.shift_ns();
    const std::int64_t due_ns = pace.due_ns(at_ns);
    ASSERT_GE(due_ns, at_ns + shift_ns);
    ASSERT_GE(due_ns - begun_ns, planned_ns - planned_ns / 16);
    ASSERT_GE(due_ns - ended_ns, std::min<std::int64_t>(planned_ns, 5'000));
    begun_ns = due_ns + (random() % 100 == 0 ? 20 * jitter_ns(random) : jitter_ns(random) / 30);
    ended_ns = begun_ns + jitter_ns(random) / 10;
    const bool is_late = pace.note_played(at_ns, begun_ns, ended_ns);
    ASSERT_EQ(is_late, begun_ns - at_ns - shift_ns > 50'000);
    ASSERT_EQ(pace.shift_ns(), is_late ? begun_ns - at_ns : shift_ns);
  }
}

}  // namespace step_pace_test
}  // namespace inbetween::gpio
