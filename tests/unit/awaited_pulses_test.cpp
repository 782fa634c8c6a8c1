#include "host_tools/rig/awaited_pulses.hpp"

#include <gtest/gtest.h>

namespace inbetween {
namespace awaited_pulses_test {

constexpr BegunPulse pulse(std::size_t number, std::int64_t at_ns, bool is_merged = false) {
  return {.pulse = number, .at_ns = at_ns, .is_merged = is_merged};
}

TEST(AwaitedPulses, APulseIsToldWhenItsChipHasSwitchedItsLineOn) {
  AwaitedPulses awaited(4);
  ASSERT_TRUE(awaited.add(pulse(7, 1000), 0, 0b10));
  EXPECT_FALSE(awaited.next());
  awaited.note_played(1, 1000, 0b10, 5);  // another chip
  awaited.note_played(0, 1000, 0b01, 5);  // another line
  awaited.note_played(0, 1000, 0, 5);     // a line is switched off
  awaited.note_played(0, 900, 0b10, 5);   // another time
  EXPECT_FALSE(awaited.next());
  awaited.note_played(0, 1000, 0b11, 12'345);
  const std::optional<PlayedPulse> told = awaited.next();
  ASSERT_TRUE(told);
  EXPECT_EQ(told->begun.pulse, 7U);
  EXPECT_TRUE(told->is_played);
  EXPECT_EQ(told->late_ns, 12'345);
  EXPECT_FALSE(awaited.next());
}

TEST(AwaitedPulses, PulsesKeepTheirOrderWhicheverChipIsFirst) {
  AwaitedPulses awaited(4);
  ASSERT_TRUE(awaited.add(pulse(0, 1000), 0, 1));
  ASSERT_TRUE(awaited.add(pulse(1, 1000), 1, 1));
  awaited.note_played(1, 1000, 1, 0);
  EXPECT_FALSE(awaited.next());
  awaited.note_played(0, 1000, 1, 0);
  EXPECT_EQ(awaited.next()->begun.pulse, 0U);
  EXPECT_EQ(awaited.next()->begun.pulse, 1U);
}

TEST(AwaitedPulses, WhatGoesOnWithALineThatIsOnIsAwaitedForNothing) {
  AwaitedPulses awaited(4);
  ASSERT_TRUE(awaited.add(pulse(3, 1000, true), 0, 1));
  const std::optional<PlayedPulse> told = awaited.next();
  ASSERT_TRUE(told);
  EXPECT_FALSE(told->is_played);
}

TEST(AwaitedPulses, WhatAChipNeverPlaysIsLeftAtTheEnd) {
  AwaitedPulses awaited(4);
  ASSERT_TRUE(awaited.add(pulse(0, 1000), 0, 1));
  ASSERT_TRUE(awaited.add(pulse(1, 2000), 0, 1));
  awaited.note_played(0, 1000, 1, 8);
  EXPECT_TRUE(awaited.rest()->is_played);
  EXPECT_FALSE(awaited.rest()->is_played);
  EXPECT_FALSE(awaited.rest());
}

TEST(AwaitedPulses, ThereIsRoomForAsManyAsWereAskedForAgainAndAgain) {
  AwaitedPulses awaited(3);
  for (std::size_t i = 0; i < 10; ++i) {
    ASSERT_TRUE(awaited.add(pulse(i, 1000), 0, 1));
    awaited.note_played(0, 1000, 1, 0);
    EXPECT_EQ(awaited.next()->begun.pulse, i);
  }
  for (std::size_t i = 0; i < 3; ++i) ASSERT_TRUE(awaited.add(pulse(i, 1000), 0, 1));
  EXPECT_FALSE(awaited.add(pulse(3, 1000), 0, 1));
}

}  // namespace awaited_pulses_test
}  // namespace inbetween
