#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <vector>

#include "inbetween/loop/take_up.hpp"
#include "tests/support/oracle_gear.hpp"
#include "tests/support/property.hpp"

/// The take-up of backlash against a gear with play, and against the peaks that are promised of it.

namespace inbetween {
namespace take_up_property_test {

constexpr double tick_s = 0.004;

double any_number(double low, double high) {
  constexpr int steps = 1'000'000;
  return low + (high - low) * (*rc::gen::resize(rc::kNominalSize, rc::gen::inRange(0, steps + 1))) / steps;
}

/// Swings, creeps, rests and trembles by less than a count.
std::vector<double> any_motion(double count) {
  std::vector<double> positions{any_number(-20, 20)};
  const int parts = *rc::gen::inRange(1, 20);
  for (int part = 0; part < parts; ++part) {
    const int ticks = *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(1, 120));
    const double speed = any_number(-1, 1) * std::pow(10, any_number(-4, 1));
    const int kind = *rc::gen::inRange(0, 3);
    const double from = positions.back();
    for (int i = 1; i <= ticks; ++i) {
      if (kind == 0) positions.push_back(from);
      if (kind == 1) positions.push_back(from + speed * tick_s * i);
      if (kind == 2) positions.push_back(from + (i % 2 == 0 ? 0.9 : 0) * count);
    }
  }
  return positions;
}

TEST(TakeUpProperty, ItStaysInsideItsPeaksAndTheLoadIsWhereTheAxisIs) {
  int taken = 0;
  check_property(3000, [&] {
    const double play = std::pow(10, any_number(-3, 0));
    const double count = any_number(0, 0.1) * play;
    const bool up = *rc::gen::arbitrary<bool>();
    const int ticks = *rc::gen::inRange(1, 60);
    TakeUp take_up({.distance = up ? -play : play, .approach_is_up = up, .ticks = ticks, .min_return = count},
                   tick_s);
    const auto [velocity, acceleration, jerk] = take_up_peaks(play, ticks * tick_s);
    const std::vector<double> positions = any_motion(count);
    // Mirrored where the approach is down: the gear of the oracle pushes upward.
    const double sign = up ? 1 : -1;
    oracle::PlayedGear gear(play, sign * positions.front());
    std::array<double, 4> last{};  // the newest first
    bool was_under_way = false;
    for (const double position : positions) {
      const Setpoint more = take_up.follow(position);
      std::copy_backward(last.begin(), last.end() - 1, last.end());
      last[0] = more.position;
      constexpr double rounding = 1 + 1e-9;
      RC_ASSERT(std::fabs(more.position) <= play * rounding && sign * more.position <= 1e-15);
      RC_ASSERT(std::fabs(more.velocity) <= velocity * rounding);
      RC_ASSERT(std::fabs(more.acceleration) <= acceleration * rounding);
      RC_ASSERT(std::fabs(last[0] - last[1]) <= velocity * tick_s * rounding + 1e-15);
      RC_ASSERT(std::fabs(last[0] - 2 * last[1] + last[2]) <=
                acceleration * tick_s * tick_s * rounding + 1e-14);
      RC_ASSERT(std::fabs(last[0] - 3 * last[1] + 3 * last[2] - last[3]) <=
                jerk * tick_s * tick_s * tick_s * rounding + 1e-14);
      const long double load = sign * gear.turn(sign * (position + more.position));
      RC_ASSERT(std::fabs(load - position) <= play * rounding + count);
      const bool is_under_way = take_up.is_under_way();
      if (!is_under_way && was_under_way) ++taken;
      if (!is_under_way) RC_ASSERT(std::fabs(load - position) <= count * rounding + 1e-12);
      was_under_way = is_under_way;
    }
  });
  std::cout << taken << " take-ups\n";
  EXPECT_GT(taken, 100);
}

TEST(TakeUpProperty, WhenSetpointsCeaseItStaysAndBeginsAnewFromThere) {
  check_property(1000, [] {
    const double play = any_number(0.01, 1);
    const int ticks = *rc::gen::inRange(2, 60);
    TakeUp take_up({.distance = -play, .ticks = ticks}, tick_s);
    take_up.follow(0);
    const int until = *rc::gen::inRange(1, ticks);
    double told = 0;
    for (int i = 1; i <= until; ++i) told = take_up.follow(-0.01 * i).position;
    take_up.halt();
    RC_ASSERT(take_up.now().position == told && take_up.now().velocity == 0 && !take_up.is_under_way());
    // Wherever the axis is then: nothing moves by being switched on, nor while it rests.
    const double elsewhere = any_number(-100, 100);
    for (int i = 0; i < 10; ++i) RC_ASSERT(take_up.follow(elsewhere).position == told || until == ticks);
    for (int i = 1; i <= 2 * ticks + 1; ++i) told = take_up.follow(elsewhere + 0.01 * i).position;
    RC_ASSERT(told == 0);
  });
}

}  // namespace take_up_property_test
}  // namespace inbetween
