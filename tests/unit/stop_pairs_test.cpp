#include "firmware_core/src/limits/stop_pairs.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

/// The quickest stop in one cell, against all rate changes one after the other.

namespace inbetween {
namespace stop_pairs_test {

constexpr std::size_t axis_count = 5;
constexpr double stop_acceleration = 10;
constexpr double stop_jerk = 100;

/// R2 where R1 is `change`: below 0 where that leaves none.
double max_jerk_at(const StopRequest& request, const std::vector<MotionTriple>& suprema, double change) {
  double jerk = request.max_rate_jerk();
  for (const auto& [p1, p2, p3] : suprema) {
    if (p2 + p1 * change > stop_acceleration) return -1;
    const double left = stop_jerk - p3 - 3 * p2 * change;
    if (p1 > 0) jerk = std::min(jerk, left / p1);
    if (left < 0) return -1;
  }
  return jerk;
}

/// Of random axes between those that hardly move and those whose motion takes nearly all of a limit.
TEST(StopPairs, NoOtherRateChangeStopsQuicker) {
  std::mt19937 random(1960);
  std::uniform_real_distribution<double> decades(-4, 0);
  AxisLimitsSpec spec{.min = -10, .max = 10, .max_velocity = 10, .max_acceleration = 10};
  spec.stop_acceleration = stop_acceleration;
  spec.stop_jerk = stop_jerk;
  const std::vector<AxisLimits> limits(axis_count, *AxisLimits::make(spec));
  std::vector<MotionTriple> suprema(axis_count);
  const MotionCells motion{
      .line = {0, 24, 1}, .fps = {24, 1}, .axes = axis_count, .room = {}, .suprema = suprema};
  const StopRequest request{.motion = motion, .limits = limits};
  int below_the_highest_change = 0;
  for (int i = 0; i < 1000; ++i) {
    for (MotionTriple& axis : suprema) {
      axis = {30 * std::pow(10, decades(random)), 10 * std::pow(10, decades(random)),
              100 * std::pow(10, decades(random))};
    }
    if (i % 10 == 0) suprema[0][0] = 0;
    if (i % 10 == 1) {
      for (MotionTriple& axis : suprema) axis[1] = 0;
    }
    const PairSearch search(request, 0);
    if (search.obstacle()) continue;
    const auto [change, jerk] = search.quickest();
    ASSERT_GT(jerk, 0) << i;
    ASSERT_LE(jerk, max_jerk_at(request, suprema, change * (1 - 1e-9)) * (1 + 1e-6)) << i;
    double least = std::numeric_limits<double>::infinity();
    double highest_change = 0;
    for (double other = 1e-5; other <= request.max_rate_change(); other *= 1.0005) {
      const double other_jerk = max_jerk_at(request, suprema, other);
      if (other_jerk <= 0) break;
      highest_change = other;
      least = std::min(least, 1 / other + other / other_jerk);
    }
    if (change < 0.99 * highest_change) ++below_the_highest_change;
    ASSERT_LE(1 / change + change / jerk, least * (1 + 1e-5)) << i;
  }
  EXPECT_GT(below_the_highest_change, 100);
}

}  // namespace stop_pairs_test
}  // namespace inbetween
