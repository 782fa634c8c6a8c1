// The search that judges certificates of limits: that it sees what is narrow, and that refinement finds
// nothing more.
#include "tests/support/oracle_limits.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "tests/support/oracle_table.hpp"
#include "tests/support/property.hpp"
#include "tests/support/random_move.hpp"

namespace inbetween::oracle {
namespace oracle_limits_test {

using Points = std::vector<std::vector<long double>>;
using Values = std::vector<double>;

Keys keys_of(Kind kind, Points at, bool closed = false) {
  return {.kind = kind, .closed = closed, .at = std::move(at), .tension_continuity_bias = {}, .weights = {}};
}

void expect_near(long double value, long double expected, long double tolerance) {
  EXPECT_LE(std::fabs(value - expected), tolerance) << value << " is not " << expected;
}

// --- one function

TEST(OraclePeak, IsFoundBetweenTheSamplesAndAtTheEnds) {
  const auto parabola = [](long double x) { return 2 - (x - 1 / 3.0L) * (x - 1 / 3.0L); };
  for (const int samples : {1, 2, 3, 10, 1000}) {
    const Extreme peak = peak_of(parabola, -1, 1, samples);
    expect_near(peak.value, 2, 1e-15L);
    expect_near(peak.place, 1 / 3.0L, 1e-7L);
    EXPECT_EQ(peak_of(parabola, 0.5L, 1, samples).place, 0.5L);
    EXPECT_EQ(peak_of(parabola, -1, 0.25L, samples).place, 0.25L);
  }
  EXPECT_EQ(peak_of(parabola, 0.5L, 0.5L, 4).value, parabola(0.5L));
}

// --- where the path nearly or wholly stands still

TEST(OracleLimits, AHairpinOfAnyWidthIsResolved) {
  // (u^2, e u): the acceleration at its bend is 2 v^2 / e^2 along x.
  for (const long double e : {1.0L, 1e-2L, 1e-4L, 1e-6L, 1e-8L}) {
    const IdealMotion motion(keys_of(Kind::catmull_rom, {{9, -3 * e}, {1, -e}, {1, e}, {9, 3 * e}}),
                             Profile(Values{2}), 100, 25);
    const long double v = motion.path().total_length() / 4;
    for (const int samples : {20, 2000}) {
      const Extremes found = motion.extremes(samples);
      expect_near(found.axes[0].acceleration.value * e * e, 2 * v * v, 1e-12L * v * v);
      expect_near(found.axes[0].acceleration.place, 50, 1e-4L);
      // (u, e u^2), lying on its side and e^2 times as large.
      expect_near(found.axes[1].acceleration.value * e * e, 2.25L / std::sqrt(12.0L) * v * v, 1e-12L * v * v);
      expect_near(found.axes[1].jerk.value * std::pow(e, 4.0L), 4 * v * v * v, 1e-11L * v * v * v);
    }
  }
}

// --- against differences of positions, and against itself

/// The five extremes of an axis as numbers.
std::array<long double, 5> numbers_of(const AxisExtremes& axis) {
  return {axis.lowest.value, axis.highest.value, axis.velocity.value, axis.acceleration.value,
          axis.jerk.value};
}

TEST(OracleLimitsProperty, RefinementFindsNothingMore) {
  check_property(40, [] {
    const RandomMove move = *regular_move();
    const IdealMotion motion(move.keys, Profile(move.speed), move.frames, 24);
    const Extremes coarse = motion.extremes(300);
    const Extremes fine = motion.extremes(1571);
    for (std::size_t axis = 0; axis < fine.axes.size(); ++axis) {
      const auto a = numbers_of(coarse.axes[axis]);
      const auto b = numbers_of(fine.axes[axis]);
      for (std::size_t i = 0; i < a.size(); ++i) RC_ASSERT(std::fabs(a[i] - b[i]) <= 1e-6L * std::fabs(b[i]));
    }
  });
}

TEST(OracleLimitsProperty, NoStateExceedsTheExtremes) {
  check_property(40, [] {
    const RandomMove move = *regular_move();
    const IdealMotion motion(move.keys, Profile(move.speed), move.frames, 24);
    const Extremes found = motion.extremes(150);
    const auto at_most = [](long double value, const Extreme& peak) {
      return value <= peak.value + 1e-12L * std::fabs(peak.value);
    };
    for (int i = 0; i <= 97; ++i) {
      const long double frame =
          std::min(static_cast<long double>(move.frames) * static_cast<long double>(i) / 97,
                   static_cast<long double>(move.frames));
      const std::vector<AxisState> state = motion.at(frame);
      for (std::size_t axis = 0; axis < state.size(); ++axis) {
        RC_ASSERT(at_most(state[axis].position, found.axes[axis].highest));
        RC_ASSERT(state[axis].position >=
                  found.axes[axis].lowest.value - 1e-12L * std::fabs(found.axes[axis].lowest.value));
        RC_ASSERT(at_most(std::fabs(state[axis].velocity), found.axes[axis].velocity));
        RC_ASSERT(at_most(std::fabs(state[axis].acceleration), found.axes[axis].acceleration));
        RC_ASSERT(at_most(std::fabs(state[axis].jerk), found.axes[axis].jerk));
      }
    }
  });
}

TEST(OracleLimitsProperty, TheStateAtTheReportedFrameIsTheExtreme) {
  check_property(40, [] {
    const RandomMove move = *regular_move();
    const IdealMotion motion(move.keys, Profile(move.speed), move.frames, 24);
    if (motion.path().slowest() < 1e-3L) return;  // a frame would need more digits than it has
    const Extremes found = motion.extremes(100);
    const auto reached = [&](const Extreme& peak, auto value_of) {
      const auto last = static_cast<long double>(move.frames);
      long double best = 0;
      for (const long double off : {-1e-9L, 0.0L, 1e-9L})
        for (const Side side : {Side::before, Side::after})
          best = std::max(best, value_of(motion.at(std::clamp(peak.place + off, 0.0L, last), side)));
      return best >= peak.value * (1 - 1e-6L);
    };
    for (std::size_t axis = 0; axis < found.axes.size(); ++axis) {
      RC_ASSERT(reached(found.axes[axis].velocity,
                        [&](const auto& state) { return std::fabs(state[axis].velocity); }));
      RC_ASSERT(reached(found.axes[axis].acceleration,
                        [&](const auto& state) { return std::fabs(state[axis].acceleration); }));
    }
  });
}

}  // namespace oracle_limits_test
}  // namespace inbetween::oracle
