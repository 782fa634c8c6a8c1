// The search that judges certificates of limits is itself held against closed forms, against refinement and
// against differences of positions.
#include "tests/support/oracle_limits.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <stdexcept>
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

void expect_peak(const Extreme& peak, long double value, long double frame) {
  expect_near(peak.value, value, 1e-13L * std::fabs(value));
  expect_near(peak.place, frame, 1e-4L);
}

const Step& step_of(const Extremes& extremes, int key, int axis) {
  return *std::find_if(extremes.steps.begin(), extremes.steps.end(),
                       [&](const Step& step) { return step.key == key && step.axis == axis; });
}

// --- one function
// -------------------------------------------------------------------------------------------------

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

TEST(OraclePeak, OfManyIsTheHighest) {
  const auto wave = [](long double x) { return std::sin(40 * x) + x / 100; };
  const Extreme peak = peak_of(wave, 0, 10, 1000);
  // 40 cos(40 x) + 1/100 = 0 on the last crest.
  const long double quarter = std::numbers::pi_v<long double> / 2;
  const long double x = (63 * 4 * quarter + quarter + std::asin(1 / 4000.0L)) / 40;
  expect_near(peak.place, x, 1e-9L);
  expect_near(peak.value, wave(x), 1e-15L);
}

TEST(OraclePeak, RefusesWhatIsNotANumber) {
  EXPECT_THROW(peak_of([](long double x) { return std::sqrt(x); }, -1, 1, 10), std::domain_error);
  EXPECT_THROW(peak_of([](long double x) { return x; }, 0, 1, 0), std::invalid_argument);
  EXPECT_THROW(peak_of([](long double x) { return x; }, 1, 0, 10), std::invalid_argument);
  EXPECT_EQ(peak_of([](long double x) { return 1 / x; }, 0, 1, 10).value,
            std::numeric_limits<long double>::infinity());
}

// --- along a line, where the axes do what the curve says
// ----------------------------------------------------------

TEST(OracleLimits, TwoControlValuesAreUniformAcceleration) {
  // phi = 10 a over one span: 100 units in 2 s, p = 25 t^2 along the line.
  const IdealMotion motion(keys_of(Kind::linear, {{1, 0}, {61, -80}}), Profile(Values{0, 10}), 48, 24);
  const Extremes found = motion.extremes(50);
  EXPECT_EQ(found.axes[0].lowest.value, 1);
  expect_peak(found.axes[0].highest, 61, 48);
  expect_peak(found.axes[1].lowest, -80, 48);
  EXPECT_EQ(found.axes[1].highest.value, 0);
  expect_peak(found.axes[0].velocity, 60, 48);
  expect_peak(found.axes[1].velocity, 80, 48);
  expect_near(found.axes[0].acceleration.value, 30, 1e-15L);
  expect_near(found.axes[1].acceleration.value, 40, 1e-15L);
  expect_near(found.axes[0].jerk.value, 0, 1e-15L);

  ASSERT_EQ(found.steps.size(), 4U);
  EXPECT_EQ(step_of(found, 0, 0).frame, 0);
  EXPECT_EQ(step_of(found, 0, 0).velocity, 0);
  expect_near(step_of(found, 0, 0).acceleration, 30, 1e-15L);
  EXPECT_EQ(step_of(found, 1, 1).frame, 48);
  expect_near(step_of(found, 1, 1).velocity, 80, 1e-15L);
  expect_near(step_of(found, 1, 1).acceleration, 40, 1e-15L);
}

TEST(OracleLimits, ATrapezoidPeaksWhereTheSplineSays) {
  // Nine values, 0 0 0 8 8 8 0 0 0, over 8 s: the area is 24, K = 50. phi is 8 at its middle alone, its slope
  // (0 8 0 0 -8 0, quadratic) at most 6, between the knots, and its bend +-8, at the knots.
  const IdealMotion motion(keys_of(Kind::linear, {{0, 7}, {600, 7}, {1200, 7}}),
                           Profile(Values{0, 0, 0, 8, 8, 8, 0, 0, 0}), 200, 25);
  const Extremes found = motion.extremes(40);
  expect_peak(found.axes[0].velocity, 50 * 8, 100);
  expect_near(found.axes[0].acceleration.value, 50 * 6, 1e-13L);
  EXPECT_TRUE(std::fabs(found.axes[0].acceleration.place - 62.5L) < 1e-4L ||
              std::fabs(found.axes[0].acceleration.place - 137.5L) < 1e-4L);
  expect_near(found.axes[0].jerk.value, 50 * 8, 1e-13L);
  EXPECT_EQ(found.axes[1].lowest.value, 7);
  EXPECT_EQ(found.axes[1].highest.value, 7);
  EXPECT_EQ(found.axes[1].velocity.value, 0);
  EXPECT_EQ(found.axes[1].jerk.value, 0);
  for (const Step& step : found.steps) {
    EXPECT_EQ(step.frame, 100 * step.key);
    expect_near(step.velocity, 0, 1e-15L);
    expect_near(step.acceleration, 0, 1e-14L);
  }
}

TEST(OracleLimits, ACornerStepsTheVelocity) {
  // An L of 20 units in a second, from 12 units a second to 28.
  const IdealMotion motion(keys_of(Kind::linear, {{0, 0}, {0, 8}, {12, 8}}), Profile(Values{6, 14}), 24, 24);
  const long double after = motion.key_frame(1) / 24;
  expect_near(12 * after + 8 * after * after, 8, 1e-15L);
  const long double speed = 12 + 16 * after;
  const Extremes found = motion.extremes(30);
  for (const int axis : {0, 1}) {
    expect_near(step_of(found, 1, axis).velocity, speed, 1e-15L);
    expect_near(step_of(found, 1, axis).acceleration, 16, 1e-15L);
  }
  expect_peak(found.axes[0].velocity, 28, 24);
  expect_peak(found.axes[1].velocity, speed, 24 * after);
  expect_near(motion.at_key(1, Side::before)[0].velocity, 0, 0);
  expect_near(motion.at_key(1, Side::after)[0].velocity, speed, 1e-15L);
  expect_near(motion.at(24 * after, Side::before)[1].velocity, speed, 1e-15L);
  expect_near(motion.at(24 * after, Side::after)[1].velocity, 0, 0);
}

TEST(OracleLimits, ADwellStandsStillAndItsKeyIsMetWhereItBegins) {
  // phi is 0 from a = 4 to 6, frames 40 to 60, and the middle key is where it dwells.
  const IdealMotion motion(keys_of(Kind::linear, {{0}, {10}, {20}}),
                           Profile(Values{0, 0, 5, 0, 0, 0, 0, 0, 5, 0, 0}), 100, 25);
  EXPECT_GE(motion.key_frame(1), 40 - 1e-2L);
  EXPECT_LE(motion.key_frame(1), 40);
  const Extremes found = motion.extremes(200);
  expect_near(step_of(found, 1, 0).velocity, 0, 1e-12L);
  EXPECT_EQ(motion.at(50)[0].velocity, 0);
  EXPECT_EQ(motion.at(50)[0].jerk, 0);
  expect_near(motion.at(50)[0].position, 10, 1e-17L);
}

// --- on bends
// -----------------------------------------------------------------------------------------------------

TEST(OracleLimits, OnAParabolaAtConstantSpeedIsTheFormula) {
  // The middle segment of these Catmull-Rom keys is (u, u^2); the outer ones are flatter. At speed v the
  // acceleration is (-4 u, 2) v^2 / (1 + 4 u^2)^2: 2 v^2 at u = 0, and at u^2 = 1/12 (9/4) / sqrt(12) v^2.
  const IdealMotion motion(keys_of(Kind::catmull_rom, {{-3, 9}, {-1, 1}, {1, 1}, {3, 9}}), Profile(Values{2}),
                           100, 25);
  const long double v = motion.path().total_length() / 4;
  const Extremes found = motion.extremes(100);
  expect_peak(found.axes[0].velocity, v, 50);
  expect_peak(found.axes[1].acceleration, 2 * v * v, 50);
  expect_near(found.axes[0].acceleration.value, 2.25L / std::sqrt(12.0L) * v * v, 1e-13L);
  const long double u = 1 / std::sqrt(12.0L);
  const long double frames_to_it = motion.path().length(1, 0.5L, (1 + u) / 2) / v * 25;
  expect_near(std::fabs(found.axes[0].acceleration.place - 50), frames_to_it, 1e-6L);
  // d/dt of the acceleration of x: u' (-4 + 48 u^2) v^2 / (1 + 4 u^2)^3 with u' = v / sqrt(1 + 4 u^2).
  expect_peak(found.axes[0].jerk, 4 * v * v * v, 50);
  EXPECT_EQ(found.axes[0].lowest.value, -3);
  expect_near(found.axes[1].lowest.value, 0, 1e-15L);
}

TEST(OracleLimits, AroundACircleTheAccelerationPointsToTheMiddle) {
  Points at;
  for (int i = 0; i < 64; ++i) {
    const long double angle = std::numbers::pi_v<long double> * static_cast<long double>(i) / 32;
    at.push_back({100 + 5 * std::cos(angle), 5 * std::sin(angle)});
  }
  const IdealMotion motion(keys_of(Kind::smooth, at, true), Profile(Values{1}), 48, 24);
  const Extremes found = motion.extremes(50);
  const long double v = motion.path().total_length() / 2;
  for (const AxisExtremes& axis : found.axes) {
    expect_near(axis.velocity.value, v, 1e-4L * v);
    expect_near(axis.acceleration.value, v * v / 5, 2e-3L * v * v / 5);
    expect_near(axis.jerk.value, v * v * v / 25, 2e-2L * v * v * v / 25);
  }
  expect_near(found.axes[0].lowest.value, 95, 1e-4L);
  for (const Step& step : found.steps) {
    const bool ends = step.key == 0 || step.key == 64;
    if (!ends) expect_near(step.acceleration, 0, 1e-12L);
  }
  expect_near(step_of(found, 0, 0).acceleration, v * v / 5, 2e-3L * v * v / 5);
}

TEST(OracleLimits, SmoothKeysDoNotStepAndCatmullRomKeysDo) {
  const Points at = {{0, 0}, {40, 10}, {50, 60}, {90, 50}};
  for (const Kind kind : {Kind::smooth, Kind::catmull_rom}) {
    const Extremes found =
        IdealMotion(keys_of(kind, at), Profile(Values{0, 0, 10, 10, 0, 0}), 48, 24).extremes(50);
    for (const int key : {1, 2})
      for (const int axis : {0, 1}) {
        const Step& step = step_of(found, key, axis);
        expect_near(step.velocity, 0, 1e-13L);
        if (kind == Kind::smooth) expect_near(step.acceleration, 0, 1e-12L);
        if (kind == Kind::catmull_rom) {
          EXPECT_GT(step.acceleration, 1);
        }
      }
  }
}

TEST(OracleLimits, WeightsMeasureTheSpeed) {
  // Twice the speed costs the axis that counts twice half the speed of the other.
  Keys keys = keys_of(Kind::linear, {{0, 0}, {10, 0}, {10, 10}});
  keys.weights = {2, 1};
  const Extremes found = IdealMotion(keys, Profile(Values{1}), 30, 10).extremes(10);
  expect_near(found.axes[0].velocity.value, 5, 1e-15L);
  expect_near(found.axes[1].velocity.value, 10, 1e-15L);
  expect_near(step_of(found, 1, 0).frame, 20, 1e-15L);
}

// --- where the path nearly or wholly stands still
// -----------------------------------------------------------------

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
      // It is the parabola above, e^2 times as large and lying on its side.
      expect_near(found.axes[1].acceleration.value * e * e, 2.25L / std::sqrt(12.0L) * v * v, 1e-12L * v * v);
      expect_near(found.axes[1].jerk.value * std::pow(e, 4.0L), 4 * v * v * v, 1e-11L * v * v * v);
    }
  }
}

TEST(OracleLimits, ACuspAndATurnOnALineAreInfinite) {
  const long double infinity = std::numeric_limits<long double>::infinity();
  const IdealMotion cusp(keys_of(Kind::catmull_rom, {{9, -11, 4}, {1, -1, 4}, {1, 1, 4}, {9, 11, 4}}),
                         Profile(Values{2}), 100, 25);
  const long double v = cusp.path().total_length() / 4;
  const Extremes found = cusp.extremes(100);
  for (const int axis : {0, 1}) {
    const AxisExtremes& extremes = found.axes[static_cast<std::size_t>(axis)];
    EXPECT_EQ(extremes.acceleration.value, infinity);
    EXPECT_EQ(extremes.jerk.value, infinity);
    expect_near(extremes.acceleration.place, 50, 1e-9L);
    EXPECT_LE(extremes.velocity.value, v * (1 + 1e-15L));
  }
  expect_near(found.axes[0].velocity.value, v, 1e-9L * v);
  EXPECT_EQ(found.axes[2].acceleration.value, 0);

  // A single axis that overshoots its second key and comes back: the velocity jumps inside the segment.
  const IdealMotion turn(keys_of(Kind::catmull_rom, {{0}, {10}, {9}}), Profile(Values{0, 0, 5, 5, 0, 0}), 48,
                         24);
  EXPECT_EQ(turn.extremes(100).axes[0].acceleration.value, infinity);
  EXPECT_GT(turn.extremes(100).axes[0].highest.value, 10);
}

TEST(OracleLimits, AKeyWithoutTangentIsHarmlessAtRestAndNotAtSpeed) {
  Keys keys = keys_of(Kind::tcb, {{0, 0}, {10, 4}, {20, -3}, {31, 0}});
  keys.tension_continuity_bias = {{1, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  const Extremes at_rest = IdealMotion(keys, Profile(Values{0, 0, 5, 5, 0, 0}), 48, 24).extremes(200);
  EXPECT_TRUE(std::isfinite(at_rest.axes[0].acceleration.value));
  EXPECT_TRUE(std::isfinite(at_rest.axes[1].acceleration.value));
  const Extremes at_speed = IdealMotion(keys, Profile(Values{5, 5, 5, 5, 0, 0}), 48, 24).extremes(200);
  EXPECT_TRUE(std::isinf(at_speed.axes[1].acceleration.value));
  EXPECT_EQ(at_speed.axes[1].acceleration.place, 0);
}

TEST(OracleLimits, NothingIsFoundWhereNothingMoves) {
  const IdealMotion motion(keys_of(Kind::smooth, {{4, -1}, {4, -1}}), Profile(Values{5}), 10, 24);
  const Extremes found = motion.extremes(10);
  EXPECT_EQ(found.axes[1].lowest.value, -1);
  EXPECT_EQ(found.axes[1].highest.value, -1);
  EXPECT_EQ(found.axes[0].velocity.value, 0);
  EXPECT_EQ(found.axes[0].jerk.value, 0);
  EXPECT_EQ(motion.at(5)[0].position, 4);
}

TEST(OracleLimits, RepeatedKeysShareTheirStep) {
  const IdealMotion motion(keys_of(Kind::linear, {{0, 0}, {0, 8}, {0, 8}, {12, 8}, {12, 8}}),
                           Profile(Values{1}), 20, 1);
  const Extremes found = motion.extremes(10);
  for (const int key : {1, 2}) {
    expect_near(step_of(found, key, 0).frame, 8, 1e-15L);
    expect_near(step_of(found, key, 0).velocity, 1, 1e-15L);
    expect_near(step_of(found, key, 1).velocity, 1, 1e-15L);
  }
  for (const int key : {3, 4}) expect_near(step_of(found, key, 0).velocity, 1, 1e-15L);
  EXPECT_EQ(motion.at(20)[0].position, 12);
  expect_near(motion.at(20)[0].velocity, 1, 1e-15L);
}

// --- against differences of positions, and against itself
// ---------------------------------------------------------

TEST(OracleLimits, StateIsTheDerivativeOfThePosition) {
  int compared = 0;
  for (std::uint64_t seed = 0; seed < 150; ++seed) {
    const RandomMove move = regular_move()(rc::Random(seed), rc::kNominalSize).value();
    const IdealMotion motion(move.keys, Profile(move.speed), move.frames, 25);
    for (const long double share : {0.137L, 0.5L - 0.011L, 0.871L}) {
      const long double frame = share * static_cast<long double>(move.frames);
      Motion differences;
      try {
        differences = motion_at(motion.path(), motion.profile(), move.frames, 25, frame / 25);
      } catch (const std::domain_error&) {
        continue;  // too near a key or a knot for a difference quotient
      }
      const std::vector<AxisState> state = motion.at(frame);
      for (std::size_t axis = 0; axis < state.size(); ++axis) {
        const long double moved = std::fabs(state[axis].velocity) * static_cast<long double>(move.frames);
        expect_near(state[axis].position, differences.position[axis],
                    1e-18L * (std::fabs(state[axis].position) + moved));
        const auto near = [&](long double value, long double expected, long double error) {
          expect_near(value, expected, error + 1e-15L * std::fabs(value));
        };
        near(state[axis].velocity, differences.velocity[axis], differences.velocity_error[axis]);
        near(state[axis].acceleration, differences.acceleration[axis], differences.acceleration_error[axis]);
        near(state[axis].jerk, differences.jerk[axis], differences.jerk_error[axis]);
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 200);
}

/// The five extremes of an axis as numbers.
std::array<long double, 5> numbers_of(const AxisExtremes& axis) {
  return {axis.lowest.value, axis.highest.value, axis.velocity.value, axis.acceleration.value,
          axis.jerk.value};
}

TEST(OracleLimits, RefinementFindsNothingMore) {
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

TEST(OracleLimits, NoStateExceedsTheExtremes) {
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

TEST(OracleLimits, TheStateAtTheReportedFrameIsTheExtreme) {
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

TEST(OracleLimits, RefusesWhatHasNoAnswer) {
  const Keys keys = keys_of(Kind::linear, {{0}, {1}});
  EXPECT_THROW(IdealMotion(keys, Profile(Values{0, 0}), 8, 24), std::invalid_argument);
  EXPECT_THROW(IdealMotion(keys, Profile(Values{1}), 0, 24), std::invalid_argument);
  const IdealMotion motion(keys, Profile(Values{1}), 8, 24);
  EXPECT_THROW(motion.at(8.5L), std::out_of_range);
  EXPECT_THROW(motion.at_key(2, Side::after), std::out_of_range);
  EXPECT_THROW(motion.extremes(0), std::invalid_argument);
}

}  // namespace oracle_limits_test
}  // namespace inbetween::oracle
