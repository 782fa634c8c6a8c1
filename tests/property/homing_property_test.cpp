#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iostream>
#include <vector>

#include "inbetween/homing/homing.hpp"
#include "tests/support/property.hpp"
#include "tests/support/simulated_homing.hpp"

/// A thousand homings with switches that bounce and wires that pick up noise: every axis knows where it is to
/// within a count.

namespace inbetween {
namespace homing_property_test {

constexpr int many_homings = 1000;
constexpr double counts_per_unit = 100;

double any_between(double min, double max) {
  return min + (max - min) * *rc::gen::inRange(0, 1001) / 1000;
}

/// A spike that comes right before the edge makes it early, by less than 4 ms, which at 0.6 units a second is
/// a quarter of a count; more than one before the same edge is rarer than a thousand homings can show.
LostAxis any_lost_axis(double unit, std::uint8_t line) {
  LostAxis lost;
  const double fast = unit * any_between(10, 60);
  lost.limits = {.velocity = fast * any_between(1, 3),
                 .acceleration = fast * any_between(4, 40),
                 .jerk = 0,
                 .min = -unit,
                 .max = unit};
  lost.limits.jerk = lost.limits.acceleration * any_between(5, 50);
  const double hysteresis = unit * any_between(0, 0.3);
  lost.spec = {.towards_max = *rc::gen::arbitrary<bool>(),
               .at = unit * any_between(-500, 500),
               .fast = fast,
               .slow = unit * any_between(0.2, 0.6),
               .search = unit * 30,
               .leave = unit * 30,
               .back_off = hysteresis + unit * any_between(0.05, 0.4),
               .home = {.line = line,
                        .active_level = *rc::gen::arbitrary<bool>(),
                        .quiet_ns = *rc::gen::inRange(1'000'000, 3'000'001)}};
  const double quiet_s = static_cast<double>(lost.spec.home.quiet_ns) / 1e9;
  lost.there = {.line = line,
                .active_level = lost.spec.home.active_level,
                .is_above = lost.spec.towards_max,
                .closes = unit * any_between(-1000, 1000),
                .hysteresis = hysteresis,
                .bounce_s = 0.95 * quiet_s,
                .max_bounces = static_cast<std::uint32_t>(*rc::gen::inRange(0, 6)),
                .noise_hz = *rc::gen::arbitrary<bool>() ? any_between(0.1, 5) : 0,
                .longest_noise_s = 0.3 * quiet_s};
  const double before = unit * any_between(-3, 25);
  lost.true_position = lost.there.closes + (lost.spec.towards_max ? -before : before);
  lost.position = unit * any_between(-1000, 1000);
  return lost;
}

TEST(HomingProperty, AThousandHomingsWithBounceAndNoiseEndWithinOneCount) {
  double worst = 0;
  std::uint64_t spikes = 0;
  int homed = 0;
  int began_on_the_switch = 0;
  check_property(many_homings, [&] {
    const double unit = std::pow(10.0, *rc::gen::inRange(-3, 4));
    std::vector<LostAxis> lost;
    for (int i = *rc::gen::inRange(1, 4); i > 0; --i) {
      lost.push_back(any_lost_axis(unit, static_cast<std::uint8_t>(i)));
    }
    SimulatedHoming homing(lost, *rc::gen::element(50, 100, 250, 1000, 2000),
                           static_cast<std::uint32_t>(*rc::gen::inRange(0, 1 << 30)));
    for (std::size_t i = 0; i < lost.size(); ++i) {
      if (homing.home_switch(i).level() == lost[i].there.active_level) ++began_on_the_switch;
    }
    RC_ASSERT(homing.start().has_value());
    if (homing.run() != HomingState::done) {
      for (std::size_t i = 0; i < lost.size(); ++i) {
        RC_LOG() << "axis " << i << ": phase " << static_cast<int>(homing.axis(i).phase()) << ", "
                 << words_of(homing.axis(i).failure()) << "\n";
      }
      RC_FAIL("not every axis is referenced");
    }
    for (std::size_t i = 0; i < lost.size(); ++i) {
      const double off = std::fabs(homing.error(i)) / unit * counts_per_unit;
      RC_ASSERT(off <= 1);
      worst = std::max(worst, off);
      spikes += homing.axis(i).home_switch().noise_count();
    }
    RC_ASSERT(homing.fastest() <= 1 + 1e-12);
    RC_ASSERT(homing.sharpest() <= 1 + 1e-12);
    ++homed;
  });
  std::cout << homed << " homings, " << began_on_the_switch << " axes began on their switch, " << spikes
            << " spikes, at worst " << worst << " counts off\n";
  if (!counts_mean_something()) return;
  EXPECT_GT(began_on_the_switch, homed / 20);
  EXPECT_GT(spikes, 0U);
}

}  // namespace homing_property_test
}  // namespace inbetween
