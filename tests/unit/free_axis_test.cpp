// A free axis by numbers that are worked out by hand.
#include "inbetween/play/free_axis.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "host_tools/motions/free_axes.hpp"

namespace inbetween {
namespace free_axis_test {

constexpr double tick_s = 0.004;
/// 100 mm/s after 0.5 s: 0.25 s bends of 200 mm/s^2 at most, and 0.25 s straight.
constexpr FreeAxisLimits track{.velocity = 100, .acceleration = 200, .jerk = 800, .min = 0, .max = 1000};

FreeAxis axis_at(double position, const FreeAxisLimits& limits = track) {
  return *FreeAxis::make(limits, position, tick_s);
}

void tick_for(FreeAxis& axis, int ticks) {
  for (int i = 0; i < ticks; ++i) axis.tick();
}
int ticks_to_rest(FreeAxis& axis) {
  int ticks = 0;
  for (; !axis.is_resting() && ticks < 100'000; ++ticks) axis.tick();
  return ticks;
}

const char* remedy_of(const Status& status) {
  return status ? "" : status.error().remedy;
}

/// v/a + a/j seconds up and down, and the rest of the way at v: 0.75 s, 325 mm / 100 mm/s, 0.75 s.
TEST(FreeAxis, GoesFromRestToRestInTheShortestTime) {
  FreeAxis axis = axis_at(100);
  ASSERT_TRUE(axis.go_to(500));
  EXPECT_EQ(axis.end(), 500);
  EXPECT_EQ(ticks_to_rest(axis), static_cast<int>(std::ceil((0.75 + 3.25 + 0.75) / tick_s - 1e-9)));
  EXPECT_EQ(axis.position(), 500);
}

/// 8 mm with four bends of t seconds: 2 j t^3.
TEST(FreeAxis, AShortDistanceHasFourBendsAndNothingElse) {
  FreeAxis axis = axis_at(100);
  ASSERT_TRUE(axis.go_to(92));
  const double seconds = 4 * std::cbrt(8.0 / (2 * 800));
  EXPECT_EQ(ticks_to_rest(axis), static_cast<int>(std::ceil(seconds / tick_s)));
  EXPECT_EQ(axis.position(), 92);
}

TEST(FreeAxis, MovesByTheCubicOfItsJerkWhereverThatChangesWithinATick) {
  FreeAxis axis = axis_at(0);
  ASSERT_TRUE(axis.drive(1));  // bends of sqrt(1/800) = 0.03536 s, which is 8.8 ticks
  const double bend_s = std::sqrt(1.0 / 800);
  for (int i = 1; i < 20; ++i) {
    const Setpoint now = axis.tick();
    const double t = i * tick_s;
    const double left = 2 * bend_s - t;
    if (t <= bend_s) {
      EXPECT_NEAR(now.position, 800 * t * t * t / 6, 1e-13);
      EXPECT_NEAR(now.velocity, 400 * t * t, 1e-12);
      EXPECT_NEAR(now.acceleration, 800 * t, 1e-11);
    } else if (left > 0) {
      EXPECT_NEAR(now.position, bend_s - left + 800 * left * left * left / 6, 1e-13);
      EXPECT_NEAR(now.velocity, 1 - 400 * left * left, 1e-12);
      EXPECT_NEAR(now.acceleration, 800 * left, 1e-11);
    } else {
      EXPECT_NEAR(now.position, t - bend_s, 1e-13);
      EXPECT_EQ(now.velocity, 1);
      EXPECT_EQ(now.acceleration, 0);
    }
  }
}

TEST(FreeAxis, WhatIsDrivenRestsExactlyAtTheSoftLimitAhead) {
  FreeAxis axis = axis_at(500);
  ASSERT_TRUE(axis.drive(100));
  EXPECT_EQ(axis.end(), 1000);
  ticks_to_rest(axis);
  EXPECT_EQ(axis.position(), 1000);
  ASSERT_TRUE(axis.drive(-30));
  ticks_to_rest(axis);
  EXPECT_EQ(axis.position(), 0);
}

TEST(FreeAxis, ARepeatedCommandChangesNothing) {
  FreeAxis once = axis_at(500);
  FreeAxis again = axis_at(500);
  ASSERT_TRUE(once.drive(70));
  for (int i = 0; i < 2000; ++i) {
    if (i == 0 || !again.is_resting()) {
      ASSERT_TRUE(again.drive(70));
    }
    EXPECT_EQ(once.tick().position, again.tick().position);
  }
  EXPECT_EQ(again.position(), 1000);
}

/// 0.75 s and v/2 times as far from full speed; while the speed rises at 200 mm/s^2 it has to bend first.
TEST(FreeAxis, KnowsItsStopBeforehand) {
  FreeAxis axis = axis_at(0);
  ASSERT_TRUE(axis.drive(100));
  tick_for(axis, 250);
  EXPECT_NEAR(axis.stop_distance(), 37.5, 1e-12);
  EXPECT_NEAR(axis.stop_seconds(), 0.75, 1e-12);
  const double rest = axis.position() + axis.stop_distance();
  axis.stop();
  EXPECT_EQ(axis.end(), rest);
  EXPECT_EQ(ticks_to_rest(axis), 188);  // 187.5
  EXPECT_EQ(axis.position(), rest);
  EXPECT_EQ(axis.stop_distance(), 0);
  EXPECT_EQ(axis.stop_seconds(), 0);
}

TEST(FreeAxis, TooFastToRestThereItComesBack) {
  FreeAxis axis = axis_at(0);
  ASSERT_TRUE(axis.drive(100));
  tick_for(axis, 500);
  const double target = axis.position() + 10;
  ASSERT_TRUE(axis.go_to(target));
  double furthest = 0;
  while (!axis.is_resting()) furthest = std::max(furthest, axis.tick().position);
  EXPECT_GT(furthest, target + 10);
  EXPECT_EQ(axis.position(), target);
}

/// From an even speed the way grows with the root of what the speed gains: the last bit of the highest speed
/// that fits is worth half a micrometre, which must not be a jump.
TEST(FreeAxis, WhatTheLastBitOfASpeedLeavesOpenIsNoJump) {
  constexpr double fine_s = 1.0 / 4000;
  FreeAxis axis = *FreeAxis::make(track, 0, fine_s);
  ASSERT_TRUE(axis.drive(50));
  while (axis.state().acceleration != 0 || axis.state().velocity != 50) axis.tick();
  const double target = axis.position() + axis.stop_distance() + 1e-6;
  ASSERT_TRUE(axis.go_to(target));
  while (!axis.is_resting()) {
    const Setpoint from = axis.state();
    const double way = axis.tick().position - from.position;
    const double expected = fine_s * (from.velocity + fine_s * from.acceleration / 2);
    ASSERT_NEAR(way, expected, track.jerk * fine_s * fine_s * fine_s / 6 + 1e-11);
  }
  EXPECT_EQ(axis.position(), target);
}

TEST(FreeAxis, SlowsDownToTheSpeedOfANewCommand) {
  FreeAxis axis = axis_at(0);
  ASSERT_TRUE(axis.drive(100));
  tick_for(axis, 250);
  ASSERT_TRUE(axis.go_to(900, 20));
  tick_for(axis, 250);
  EXPECT_EQ(axis.state().velocity, 20);
  ticks_to_rest(axis);
  EXPECT_EQ(axis.position(), 900);
}

TEST(FreeAxis, OutsideItsSoftLimitsItIsOnlyDrivenInside) {
  FreeAxis axis = axis_at(1200);
  EXPECT_STREQ(remedy_of(axis.drive(10)), "drive it the other way");
  EXPECT_TRUE(axis.is_resting());
  EXPECT_STREQ(remedy_of(axis.go_to(1100)), "go to one between min and max");
  ASSERT_TRUE(axis.drive(-100));
  tick_for(axis, 100);
  EXPECT_STREQ(remedy_of(axis.drive(100)), "drive it the other way");
  EXPECT_LT(axis.state().velocity, 0) << "what was refused has not changed what it does";
  ticks_to_rest(axis);
  EXPECT_EQ(axis.position(), 0);
  EXPECT_FALSE(axis.drive(-10)) << "at the limit there is no way left";
}

TEST(FreeAxis, HaltedItIsAtRestWhereItIs) {
  FreeAxis axis = axis_at(0);
  ASSERT_TRUE(axis.drive(100));
  tick_for(axis, 100);
  const double here = axis.position();
  EXPECT_EQ(axis.place(7).error().code, ErrorCode::wrong_state);
  EXPECT_EQ(axis.set_range(0, 10).error().code, ErrorCode::wrong_state);
  axis.halt();
  EXPECT_TRUE(axis.is_resting());
  EXPECT_EQ(axis.tick().position, here);
  EXPECT_EQ(axis.tick().velocity, 0);
  ASSERT_TRUE(axis.place(7));
  EXPECT_EQ(axis.position(), 7);
  ASSERT_TRUE(axis.set_range(0, 10));
  EXPECT_FALSE(axis.go_to(11));
}

/// With 4 times the limits 3200 mm/s^3 alone decide: 2 sqrt(100/3200) s, and half of 100 mm/s meanwhile.
TEST(FreeAxis, AStopMayUseMoreThanTheMotion) {
  FreeAxisLimits limits = track;
  limits.stop_share = 4;
  FreeAxis axis = axis_at(0, limits);
  ASSERT_TRUE(axis.drive(100));
  tick_for(axis, 250);
  EXPECT_EQ(axis.state().velocity, 100) << "it speeds up as ever";
  EXPECT_NEAR(axis.stop_seconds(), 2 * std::sqrt(1.0 / 32), 1e-12);
  const double from = axis.position();
  axis.stop();
  EXPECT_EQ(ticks_to_rest(axis), 89);
  EXPECT_NEAR(axis.position() - from, 100 * std::sqrt(1.0 / 32), 1e-9);
}

TEST(FreeAxis, IllegalNumbersAreRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  const auto limits_with = [](double FreeAxisLimits::*field, double value) {
    FreeAxisLimits limits = track;
    limits.*field = value;
    return FreeAxis::make(limits, 0, tick_s);
  };
  using Limits = FreeAxisLimits;
  for (double Limits::*field : {&Limits::velocity, &Limits::acceleration, &Limits::jerk}) {
    for (const double value : {nan, infinity, 0.0, -1.0, 1e200}) EXPECT_FALSE(limits_with(field, value));
  }
  for (const double value : {nan, infinity, 0.9, -1.0}) {
    EXPECT_FALSE(limits_with(&Limits::stop_share, value));
  }
  for (const double value : {nan, infinity, 1000.0, 1e200}) EXPECT_FALSE(limits_with(&Limits::min, value));
  EXPECT_FALSE(limits_with(&Limits::max, 0));
  EXPECT_FALSE(limits_with(&Limits::jerk, 1e-119)) << "a stop of years";
  EXPECT_FALSE(FreeAxis::make(track, nan, tick_s));
  EXPECT_FALSE(FreeAxis::make(track, 0, 0));
  FreeAxis axis = axis_at(0);
  for (const double value : {nan, infinity, 101.0, -101.0}) {
    EXPECT_FALSE(axis.drive(value));
    EXPECT_FALSE(axis.go_to(10, value));
  }
  EXPECT_FALSE(axis.go_to(nan));
  EXPECT_FALSE(axis.go_to(10, 0));
  EXPECT_FALSE(axis.place(infinity));
  EXPECT_TRUE(axis.is_resting());
}

TEST(FreeAxes, AreTickedAndStoppedTogether) {
  FreeAxes motion({axis_at(0), axis_at(500)});
  EXPECT_TRUE(motion.is_resting());
  ASSERT_TRUE(motion.axes()[0].drive(100));
  ASSERT_TRUE(motion.axes()[1].drive(-50));
  std::array<Setpoint, 2> out;
  for (int i = 0; i < 250; ++i) motion.tick(0, out);
  EXPECT_EQ(out[0].velocity, 100);
  EXPECT_EQ(out[1].velocity, -50);
  EXPECT_FALSE(motion.is_resting());
  motion.stop();
  for (int i = 0; i < 188; ++i) motion.tick(0, out);
  EXPECT_TRUE(motion.is_resting());
  ASSERT_TRUE(motion.axes()[0].drive(100));
  motion.tick(0, out);
  motion.halt();
  EXPECT_TRUE(motion.is_resting());
}

}  // namespace free_axis_test
}  // namespace inbetween
