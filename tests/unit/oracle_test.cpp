// The oracle that judges the product is itself held against closed forms here.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/oracle_path.hpp"
#include "tests/support/oracle_profile.hpp"
#include "tests/support/oracle_quadrature.hpp"
#include "tests/support/oracle_table.hpp"
#include "tests/support/random_move.hpp"

namespace inbetween::oracle {
namespace oracle_test {

using Points = std::vector<std::vector<long double>>;

Keys keys_of(Kind kind, Points at, bool closed = false) {
  return {.kind = kind, .closed = closed, .at = std::move(at), .tension_continuity_bias = {}, .weights = {}};
}

void expect_near_relative(long double value, long double expected, long double relative) {
  EXPECT_LE(std::fabs(value - expected), relative * std::fabs(expected)) << value << " is not " << expected;
}

/// Four Catmull-Rom keys whose middle segment is (u, e u^2), -1 <= u <= 1.
Path parabola(long double e) {
  return Path(keys_of(Kind::catmull_rom, {{-3, 9 * e}, {-1, e}, {1, e}, {3, 9 * e}}));
}

/// The same parabola lying on its side, squeezed to a hairpin: (u^2, e u).
Path hairpin(long double e) {
  return Path(keys_of(Kind::catmull_rom, {{9, -3 * e}, {1, -e}, {1, e}, {9, 3 * e}}));
}

/// Integral of sqrt(a^2 + b^2 u^2) from 0 to u.
long double parabola_length(long double a, long double b, long double u) {
  return u / 2 * std::hypot(a, b * u) + a * a / (2 * b) * std::asinh(b * u / a);
}

/// Four Catmull-Rom keys whose middle segment is Neile's parabola (u^2, u^3), -1 <= u <= 1, with a cusp at 0.
Path cusp() {
  return Path(keys_of(Kind::catmull_rom, {{9, -11}, {1, -1}, {1, 1}, {9, 11}}));
}

long double cusp_length(long double u) {
  return (std::pow(4 + 9 * u * u, 1.5L) - 8) / 27;
}

std::vector<std::pair<int, double>> rounded_places(const std::vector<Row>& table) {
  std::vector<std::pair<int, double>> result;
  result.reserve(table.size());
  for (const Row& row : table) result.emplace_back(row.place.segment, static_cast<double>(row.place.t));
  return result;
}

// --- quadrature
// ---------------------------------------------------------------------------------------------------

TEST(OracleQuadrature, RuleIntegratesEveryPowerUpToTwiceItsPoints) {
  for (int power = 0; power < 2 * static_cast<int>(gauss_points); ++power) {
    const auto integrand = [power](long double x) { return std::pow(x, static_cast<long double>(power)); };
    expect_near_relative(gauss_legendre(integrand, 0, 1), 1 / static_cast<long double>(power + 1), 3e-18L);
  }
}

TEST(OracleQuadrature, HalvesUntilANarrowPeakIsResolved) {
  const auto peak = [](long double x) { return 1 / (1e-6L + x * x); };
  expect_near_relative(integral(peak, -1, 2, 1e-12L), 1e3L * (std::atan(1e3L) + std::atan(2e3L)), 1e-16L);
}

TEST(OracleQuadrature, RefusesWhatDoesNotConverge) {
  const auto pole = [](long double x) { return 1 / std::fabs(x - 1 / 3.0L); };
  EXPECT_THROW(integral(pole, 0, 1, 1e-18L), std::runtime_error);
}

// --- lengths
// ------------------------------------------------------------------------------------------------------

TEST(OraclePath, StraightLinesHaveTheLengthOfTheirChords) {
  const Path path(keys_of(Kind::linear, {{0, 0}, {3, 4}, {3, 4}, {3, -8}}));
  EXPECT_EQ(path.segments(), 3);
  expect_near_relative(path.length(0, 0, 1), 5, 1e-18L);
  EXPECT_EQ(path.length(1, 0, 1), 0);
  expect_near_relative(path.total_length(), 17, 1e-18L);
  expect_near_relative(path.length(2, 0.75L, 0.25L), -6, 1e-18L);
  EXPECT_EQ(path.position(2, 0.5L, 1), -2);
  expect_near_relative(path.travelled({0, 0.5L}, {2, 0.25L}), 5.5L, 1e-18L);
  expect_near_relative(path.travelled({2, 0.25L}, {0, 0.5L}), -5.5L, 1e-18L);
}

TEST(OraclePath, ClosedLinesReturnToTheFirstKey) {
  const Path path(keys_of(Kind::linear, {{0, 0}, {4, 0}, {4, 3}}, true));
  EXPECT_EQ(path.segments(), 3);
  expect_near_relative(path.total_length(), 12, 1e-18L);
  EXPECT_EQ(path.position(2, 1, 0), 0);
}

TEST(OraclePath, WeightsStretchTheMeasureAndNotTheShape) {
  Keys keys = keys_of(Kind::linear, {{0, 0}, {3, 4}});
  keys.weights = {4, 0.5L};
  const Path path(keys);
  expect_near_relative(path.total_length(), std::sqrt(148.0L), 1e-18L);
  EXPECT_EQ(path.derivative(1, 0, 0.5L, 1), 4);
}

TEST(OraclePath, ParabolaHasTheLengthOfItsFormula) {
  const Path path = parabola(1);
  for (const long double t : {0.0L, 0.125L, 0.5L, 0.9L, 1.0L}) {
    const long double u = 2 * t - 1;
    EXPECT_NEAR(static_cast<double>(path.position(1, t, 1)), static_cast<double>(u * u), 1e-18);
    expect_near_relative(path.length(1, 0, t), parabola_length(1, 2, 1) + parabola_length(1, 2, u), 1e-18L);
  }
}

TEST(OraclePath, CuspHasTheLengthOfItsFormula) {
  const Path path = cusp();
  expect_near_relative(path.length(1, 0, 1), 2 * cusp_length(1), 1e-18L);
  for (const long double u : {1.0L, 0.5L, 1e-3L}) {
    const long double t = (1 + u) / 2;
    const long double expected = cusp_length(2 * t - 1);
    EXPECT_NEAR(static_cast<double>(path.length(1, 0.5L, t) - expected), 0, 1e-18) << u;
    EXPECT_NEAR(static_cast<double>(path.length(1, 1 - t, 0.5L) - expected), 0, 1e-18) << u;
  }
  EXPECT_LT(path.slowest(), 1e-17L);
  EXPECT_NE(path.piece(1, 0.49L), path.piece(1, 0.51L));
}

TEST(OraclePath, HairpinsOfEveryWidthHaveTheLengthOfTheirFormula) {
  for (int exponent = 0; exponent <= 50; ++exponent) {
    const long double e = std::ldexp(1.0L, -exponent);
    const Path path = hairpin(e);
    expect_near_relative(path.length(1, 0, 1), 2 * parabola_length(e, 2, 1), 2e-17L);
    // A short step at the bend, as wide as the bend itself.
    const long double t = 0.5L + e / 4;
    const long double expected = 2 * parabola_length(e, 2, 2 * t - 1);
    EXPECT_LE(std::fabs(path.length(1, 1 - t, t) - expected), 1e-18L * e) << e;
  }
}

TEST(OraclePath, ClosedSplineThroughACircleApproachesTheCircle) {
  std::vector<long double> error;
  for (const int count : {16, 32, 64}) {
    Points at;
    for (int i = 0; i < count; ++i) {
      const long double angle =
          2 * std::numbers::pi_v<long double> * static_cast<long double>(i) / static_cast<long double>(count);
      at.push_back({1e6L + 5 * std::cos(angle), 5 * std::sin(angle)});
    }
    const Path path(keys_of(Kind::smooth, at, true));
    error.push_back(std::fabs(path.total_length() - 10 * std::numbers::pi_v<long double>));
  }
  EXPECT_LT(error.back(), 5e-5L);
  // A cubic spline is of fourth order: half the spacing, a sixteenth of the error.
  EXPECT_NEAR(static_cast<double>(error[0] / error[1]), 16, 2);
  EXPECT_NEAR(static_cast<double>(error[1] / error[2]), 16, 1);
}

TEST(OraclePath, ScaleAndOffsetLeaveTheLengthItsDigits) {
  const Path plain = hairpin(0x1p-10L);
  for (const long double scale : {1e-100L, 1e100L}) {
    Keys keys =
        keys_of(Kind::catmull_rom, {{9, -3 * 0x1p-10L}, {1, -0x1p-10L}, {1, 0x1p-10L}, {9, 3 * 0x1p-10L}});
    for (auto& key : keys.at)
      for (long double& coordinate : key) coordinate *= scale;
    expect_near_relative(Path(keys).total_length(), scale * plain.total_length(), 1e-17L);
  }
  Keys far = keys_of(Kind::catmull_rom, {{9, -3}, {1, -1}, {1, 1}, {9, 3}});
  const Path near_zero(far);
  for (auto& key : far.at) key[0] += 1e12L;
  EXPECT_EQ(Path(far).total_length(), near_zero.total_length());
  EXPECT_EQ(Path(far).offset(1, 0.25L, 0), near_zero.offset(1, 0.25L, 0));
}

TEST(OraclePath, PlaceInvertsDistanceAcrossCuspsAndDwells) {
  const Path bent = cusp();
  const Path dwelling(keys_of(Kind::linear, {{0}, {3}, {3}, {-8}}));
  for (const Path* path : {&bent, &dwelling}) {
    Place before;
    for (int i = 0; i <= 1000; ++i) {
      const long double distance =
          std::min(path->total_length(), path->total_length() * static_cast<long double>(i) / 1000);
      const Place place = path->place(distance);
      EXPECT_LE(std::fabs(path->distance(place.segment, place.t) - distance), 4e-19L * path->total_length())
          << i;
      EXPECT_GE(std::pair(place.segment, place.t), std::pair(before.segment, before.t)) << i;
      before = place;
    }
  }
  EXPECT_EQ(dwelling.place(dwelling.length(0, 0, 1)).segment, 0);
  EXPECT_EQ(dwelling.place(0).t, 0);
  EXPECT_EQ(dwelling.place(dwelling.total_length()).segment, 2);
  EXPECT_EQ(dwelling.place(dwelling.total_length()).t, 1);
  EXPECT_THROW(dwelling.place(14.01L), std::out_of_range);
  const Path resting(keys_of(Kind::linear, {{0}, {3}, {3}, {3}}));
  EXPECT_EQ(resting.place(resting.total_length()).segment, 2);
}

TEST(OraclePath, RefusesPlacesThatDoNotExist) {
  const Path path = cusp();
  EXPECT_THROW(path.speed(3, 0), std::out_of_range);
  EXPECT_THROW(path.length(0, 0, 1.001L), std::out_of_range);
  EXPECT_THROW(path.speed(0, std::nanl("")), std::out_of_range);
  EXPECT_THROW(path.position(0, 0, 2), std::out_of_range);
  EXPECT_THROW(path.derivative(4, 0, 0, 0), std::out_of_range);
}

// --- splines
// ------------------------------------------------------------------------------------------------------

TEST(OracleSpline, SmoothThroughThreeKeysIsTheNaturalSplineSolvedByHand) {
  // Chords of 5 and 5: even knots, second difference -8 in y, second derivative -12 at the middle key.
  const Path path(keys_of(Kind::smooth, {{0, 0}, {3, 4}, {6, 0}}));
  EXPECT_NEAR(static_cast<double>(path.position(0, 0.5L, 1)), 2.75, 1e-18);
  EXPECT_NEAR(static_cast<double>(path.position(0, 0.5L, 0)), 1.5, 1e-18);
  EXPECT_NEAR(static_cast<double>(path.derivative(2, 0, 1, 1)), -12, 1e-17);
  EXPECT_NEAR(static_cast<double>(path.derivative(1, 1, 0, 1)), 0, 1e-18);
}

TEST(OracleSpline, SmoothIsCentripetal) {
  // Chords of 1 and 4: knot steps 1 and 2. The natural spline's middle second derivative over knots 0, 1, 3
  // is M = 6 ((d2 / h2 - d1 / h1) / (h1 + h2)) / 2 = 6 * ((4 / 2 - 1) / 3) / 2 = 1, and in t of the second
  // segment h2^2 M.
  const Path path(keys_of(Kind::smooth, {{0}, {1}, {5}}));
  EXPECT_NEAR(static_cast<double>(path.derivative(2, 0, 1, 0)), 1, 1e-18);
  EXPECT_NEAR(static_cast<double>(path.derivative(2, 1, 0, 0)), 4, 1e-17);
}

/// The spline's derivatives over its knots, not over t, must agree on both sides of every key that joins two
/// spans.
void expect_smooth_joint(const Path& path, const Keys& keys, int before, int after) {
  const auto step = [&](int segment) {
    long double sum = 0;
    for (int axis = 0; axis < path.axes(); ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      const long double w = keys.weights.empty() ? 1 : keys.weights[a];
      const std::size_t next = (static_cast<std::size_t>(segment) + 1) % keys.at.size();
      sum += std::pow(w * (keys.at[next][a] - keys.at[static_cast<std::size_t>(segment)][a]), 2.0L);
    }
    return std::sqrt(std::sqrt(sum));
  };
  for (int order = 1; order <= 2; ++order) {
    for (int axis = 0; axis < path.axes(); ++axis) {
      const auto power = static_cast<long double>(order);
      const long double left = path.derivative(order, before, 1, axis) / std::pow(step(before), power);
      const long double right = path.derivative(order, after, 0, axis) / std::pow(step(after), power);
      long double scale = 0;
      for (const int segment : {before, after})
        for (int k = 1; k <= 3; ++k)
          scale = std::max(scale,
                           std::fabs(path.derivative(k, segment, 0, axis)) / std::pow(step(segment), power));
      EXPECT_LE(std::fabs(left - right), 1e-16L * scale) << "order " << order << " at key " << after;
    }
  }
}

TEST(OracleSpline, SmoothKeepsFirstAndSecondDerivativeAtEveryKey) {
  const Points at = {{0, 0, 5},   {10, 2, 4},       {11, 2.5L, 4}, {11, 2.5L, 4},
                     {-30, 7, 3}, {-30.5L, 7, 100}, {4, 4, 4}};
  Keys open = keys_of(Kind::smooth, at);
  open.weights = {1, 3, 0.25L};
  Keys closed = open;
  closed.closed = true;
  for (const auto& [before, after] :
       std::vector<std::pair<int, int>>{{0, 1}, {1, 3}, {3, 4}, {4, 5}, {5, 6}, {6, 0}}) {
    if (after < before || after == 6) {
      expect_smooth_joint(Path(closed), closed, before, after);
    } else {
      expect_smooth_joint(Path(open), open, before, after);
      expect_smooth_joint(Path(closed), closed, before, after);
    }
  }
  const Path path(open);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(static_cast<double>(path.derivative(2, 0, 0, axis)), 0, 1e-17);
    EXPECT_NEAR(static_cast<double>(path.derivative(2, 5, 1, axis)), 0, 1e-16);
    EXPECT_EQ(path.derivative(1, 2, 0.5L, axis), 0) << "between equal keys the path stands still";
  }
}

TEST(OracleSpline, EveryKindPassesThroughItsKeys) {
  const Points at = {{0, 1e6L}, {10, 1e6L + 2}, {11, 1e6L - 7}, {-30, 1e6L}};
  for (const Kind kind : {Kind::smooth, Kind::catmull_rom, Kind::tcb, Kind::linear}) {
    for (const bool closed : {false, true}) {
      const Path path(keys_of(kind, at, closed));
      for (int i = 0; i < path.segments(); ++i) {
        for (int axis = 0; axis < 2; ++axis) {
          const auto a = static_cast<std::size_t>(axis);
          const auto key = static_cast<std::size_t>(i);
          EXPECT_EQ(path.position(i, 0, axis), at[key][a]);
          const long double chord = at[(key + 1) % at.size()][a] - at[key][a];
          EXPECT_NEAR(static_cast<double>(path.offset(i, 1, axis) - chord), 0, 1e-16);
        }
      }
    }
  }
}

TEST(OracleSpline, TangentsAreThoseOfKochanekAndBartels) {
  Keys keys = keys_of(Kind::tcb, {{0, 0}, {1, 0}, {1, 2}});
  keys.tension_continuity_bias = {{0, 0, 0}, {0.5L, 0.2L, -0.4L}, {0.25L, 0, 0}};
  const Path path(keys);
  const auto slope = [&](int segment, long double t) {
    return std::array{static_cast<double>(path.derivative(1, segment, t, 0)),
                      static_cast<double>(path.derivative(1, segment, t, 1))};
  };
  EXPECT_NEAR(slope(0, 1)[0], 0.12, 1e-15);  // 0.5 * 0.8 * 0.6 / 2 of the chord before
  EXPECT_NEAR(slope(0, 1)[1], 0.84, 1e-15);  // 0.5 * 1.2 * 1.4 / 2 of the chord after
  EXPECT_NEAR(slope(1, 0)[0], 0.18, 1e-15);  // 0.5 * 1.2 * 0.6 / 2
  EXPECT_NEAR(slope(1, 0)[1], 0.56, 1e-15);  // 0.5 * 0.8 * 1.4 / 2
  EXPECT_NEAR(slope(0, 0)[0], 1, 1e-15);     // both chords are the only one
  EXPECT_NEAR(slope(1, 1)[1], 1.5, 1e-15);   // and tension 1/4 of it
}

TEST(OracleSpline, ClosedTangentsWrapAround) {
  const Path path(keys_of(Kind::catmull_rom, {{0, 0}, {4, 0}, {4, 4}, {0, 4}}, true));
  EXPECT_EQ(path.derivative(1, 0, 0, 0), 2);
  EXPECT_EQ(path.derivative(1, 0, 0, 1), -2);
  EXPECT_EQ(path.derivative(1, 3, 1, 0), 2);
  EXPECT_EQ(path.derivative(1, 3, 1, 1), -2);
}

TEST(OracleSpline, TensionOneStandsStillAtItsKey) {
  Keys keys = keys_of(Kind::tcb, {{0, 0}, {1, 0}, {1, 2}});
  keys.tension_continuity_bias = {{0, 0, 0}, {1, 0.3L, 0.1L}, {0, 0, 0}};
  EXPECT_EQ(Path(keys).speed(0, 1), 0);
  EXPECT_EQ(Path(keys).slowest(), 0);
}

TEST(OracleSpline, OneKeyAndEqualKeysStandStill) {
  for (const Kind kind : {Kind::smooth, Kind::catmull_rom, Kind::tcb, Kind::linear}) {
    for (const bool closed : {false, true}) {
      for (const std::size_t count : {1U, 3U}) {
        const Path path(keys_of(kind, Points(count, {7, -1}), closed));
        EXPECT_EQ(path.total_length(), 0);
        EXPECT_EQ(path.position(0, 0.3L, 0), 7);
        EXPECT_EQ(path.slowest(), 1);
      }
    }
  }
}

TEST(OracleSpline, RefusesKeysThatMakeNoPath) {
  EXPECT_THROW(Path(keys_of(Kind::smooth, {})), std::invalid_argument);
  EXPECT_THROW(Path(keys_of(Kind::smooth, {{0, 0}, {1}})), std::invalid_argument);
  for (const Kind kind : {Kind::smooth, Kind::catmull_rom, Kind::linear}) {
    Keys unseen = keys_of(kind, {{0, 0}, {0, 1}, {0, 2}});
    unseen.weights = {1, 0};
    EXPECT_THROW(Path{unseen}, std::invalid_argument);
    unseen.weights = {1, -1};
    EXPECT_THROW(Path{unseen}, std::invalid_argument);
    unseen.weights = {1};
    EXPECT_THROW(Path{unseen}, std::invalid_argument);
  }
}

// --- speed profile
// ------------------------------------------------------------------------------------------------

TEST(OracleProfile, EqualValuesMakeAConstantAndItsIntegral) {
  for (const std::size_t count : {1U, 2U, 3U, 20U}) {
    const Profile profile(std::vector<long double>(count, 7.0L));
    EXPECT_EQ(profile.spans(), count == 1 ? 1 : static_cast<int>(count) - 1);
    const auto f = static_cast<long double>(profile.spans());
    for (int i = 0; i <= 97; ++i) {
      const long double a = f * static_cast<long double>(i) / 97;
      expect_near_relative(profile.value(a), 7, 1e-18L);
      EXPECT_NEAR(static_cast<double>(profile.derivative(1, a)), 0, 1e-17);
      EXPECT_NEAR(static_cast<double>(profile.integral(a) - 7 * a), 0, 1e-16);
    }
  }
}

TEST(OracleProfile, EvenStepsMakeAStraightLineAndItsIntegral) {
  const Profile profile(std::vector<double>{1, 3, 5, 7});
  for (const long double a : {0.0L, 0.3L, 1.0L, 2.9L, 3.0L}) {
    expect_near_relative(profile.value(a), 1 + 2 * a, 1e-18L);
    expect_near_relative(profile.derivative(1, a), 2, 1e-18L);
    EXPECT_NEAR(static_cast<double>(profile.derivative(2, a)), 0, 1e-17);
    EXPECT_NEAR(static_cast<double>(profile.integral(a) - (a + a * a)), 0, 1e-17);
  }
  expect_near_relative(profile.integral(1.5L, 2.75L), 1.25L + 2.75L * 2.75L - 1.5L * 1.5L, 1e-18L);
  EXPECT_EQ(profile.integral(2, 1), -profile.integral(1, 2));
}

TEST(OracleProfile, FirstSpanIsTheFormulaOfTheNaturalEnd) {
  const Profile profile(std::vector<double>{4, 10, 1, 25, 3});
  for (const long double t : {0.0L, 0.25L, 0.7L, 1.0L}) {
    const long double t3 = t * t * t;
    expect_near_relative(profile.value(t), (1 - t + t3 / 6) * 4 + (t - t3 / 3) * 10 + t3 / 6 * 1, 1e-18L);
    expect_near_relative(profile.value(4 - t), (1 - t + t3 / 6) * 3 + (t - t3 / 3) * 25 + t3 / 6 * 1, 1e-18L);
    const long double exact =
        (t - t * t / 2 + t * t3 / 24) * 4 + (t * t / 2 - t * t3 / 12) * 10 + t * t3 / 24 * 1;
    EXPECT_NEAR(static_cast<double>(profile.integral(t) - exact), 0, 1e-17);
  }
  EXPECT_EQ(profile.value(0), 4);
  expect_near_relative(profile.value(4), 3, 1e-18L);
  EXPECT_NEAR(static_cast<double>(profile.derivative(2, 0)), 0, 1e-17);
  EXPECT_NEAR(static_cast<double>(profile.derivative(2, 4)), 0, 1e-17);
}

TEST(OracleProfile, InnerSpanIsTheUniformCubicBSpline) {
  const Profile profile(std::vector<double>{4, 10, 1, 25, 3});
  const long double t = 0.375L;
  const long double u = 1 - t;
  const long double expected = (u * u * u * 4 + (3 * t * t * t - 6 * t * t + 4) * 10 +
                                (3 * u * u * u - 6 * u * u + 4) * 1 + t * t * t * 25) /
                               6;
  expect_near_relative(profile.value(1 + t), expected, 1e-18L);
}

TEST(OracleProfile, DerivativesAreThoseOfTheValue) {
  const Profile profile(std::vector<double>{0, 0, 10, 10, 4, 10, 0});
  const long double h = 1e-4L;
  for (const long double a : {0.4L, 1.7L, 3.2L, 5.9L}) {
    const long double slope = (profile.value(a + h) - profile.value(a - h)) / (2 * h);
    const long double bend = (profile.value(a + h) - 2 * profile.value(a) + profile.value(a - h)) / (h * h);
    EXPECT_NEAR(static_cast<double>(profile.derivative(1, a)), static_cast<double>(slope), 1e-6);
    EXPECT_NEAR(static_cast<double>(profile.derivative(2, a)), static_cast<double>(bend), 1e-9);
  }
}

RC_GTEST_PROP(OracleProfile, StaysInTheHullOfItsControlValues, (const RandomMove& move)) {
  const Profile profile(move.speed);
  const auto [low, high] = std::minmax_element(move.speed.begin(), move.speed.end());
  for (int i = 0; i <= 200; ++i) {
    const long double value = profile.value(static_cast<long double>(profile.spans() * i) / 200);
    RC_ASSERT(value >= static_cast<long double>(*low) - 1e-16L);
    RC_ASSERT(value <= static_cast<long double>(*high) + 1e-16L);
  }
}

TEST(OracleProfile, RefusesNoValuesAndPlacesBesideTheCurve) {
  EXPECT_THROW(Profile(std::vector<double>{}), std::invalid_argument);
  EXPECT_THROW(Profile(std::vector<double>{1, 2}).value(1.1L), std::out_of_range);
  EXPECT_THROW(Profile(std::vector<double>{1, 2}).value(-0.1L), std::out_of_range);
  EXPECT_THROW(Profile(std::vector<double>{1, 2}).derivative(3, 0), std::out_of_range);
}

// --- table and checker
// --------------------------------------------------------------------------------------------

const Path& straight() {
  static const Path path(keys_of(Kind::linear, {{0, 0}, {30, 40}, {60, 80}}));
  return path;
}

TEST(OracleTable, ConstantSpeedDividesALineEvenly) {
  const std::vector<Row> table = frame_table(straight(), Profile(std::vector<double>{5}), 8);
  ASSERT_EQ(table.size(), 9U);
  for (std::size_t j = 0; j < table.size(); ++j) {
    const auto frame = static_cast<long double>(j);
    expect_near_relative(table[j].distance, 12.5L * frame, 1e-18L);
    expect_near_relative(table[j].alpha, frame / 8, 1e-18L);
    expect_near_relative(table[j].speed, 12.5L, 1e-18L);
    EXPECT_NEAR(static_cast<double>(table[j].acceleration), 0, 1e-16);
    const long double s = static_cast<long double>(table[j].place.segment) + table[j].place.t;
    EXPECT_NEAR(static_cast<double>(s), static_cast<double>(frame / 4), 1e-18);
  }
}

TEST(OracleTable, LinearSpeedCurveIsUniformAcceleration) {
  // phi = 10 a over one span: the distance is the square of the time, 100 (j / 10)^2.
  const std::vector<Row> table = frame_table(straight(), Profile(std::vector<double>{0, 10}), 10);
  for (std::size_t j = 0; j < table.size(); ++j) {
    const auto frame = static_cast<long double>(j);
    EXPECT_NEAR(static_cast<double>(table[j].distance), static_cast<double>(frame * frame), 1e-16);
    EXPECT_NEAR(static_cast<double>(table[j].speed), static_cast<double>(2 * frame), 1e-16);
    EXPECT_NEAR(static_cast<double>(table[j].acceleration), 2, 1e-17);
  }
}

TEST(OracleTable, ADwellHoldsItsPlace) {
  const std::vector<Row> table = frame_table(cusp(), Profile(std::vector<double>{5, 0, 0, 0, 0, 5}), 10);
  EXPECT_EQ(table[5].place.t, table[4].place.t);
  EXPECT_EQ(table[5].place.t, table[6].place.t);
  EXPECT_GT(table[7].distance, table[6].distance);
}

TEST(OracleTable, RefusesWhatHasNoAnswer) {
  EXPECT_THROW(frame_table(straight(), Profile(std::vector<double>{0, 0}), 8), std::invalid_argument);
  EXPECT_THROW(frame_table(straight(), Profile(std::vector<double>{1}), 0), std::invalid_argument);
  EXPECT_THROW(row_at(straight(), Profile(std::vector<double>{1}), 8, 8.5L), std::out_of_range);
}

TEST(OracleChecker, JudgesByTheLengthOfEachStep) {
  const Profile profile(std::vector<double>{5});
  std::vector<std::pair<int, double>> places = rounded_places(frame_table(straight(), profile, 8));
  EXPECT_EQ(worst_speed_error(straight(), profile, 8, places, 1e-9L).worst, 0);

  places[6].second += 1e-6;  // 50e-6 on steps of 12.5, one too long and one too short
  const SpeedError error = worst_speed_error(straight(), profile, 8, places, 1e-6L);
  expect_near_relative(error.worst, 4, 1e-8L);
  EXPECT_EQ(error.frame, 5);
  expect_near_relative(error.wanted, 12.5L, 1e-18L);
  expect_near_relative(error.travelled, 12.50005L, 1e-15L);
  expect_near_relative(error.allowed, 12.5e-6L, 1e-15L);
  expect_near_relative(error.worst_distance, 50e-6L / 100, 1e-8L);
}

TEST(OracleChecker, FirstAndLastStepAreJudged) {
  const Profile profile(std::vector<double>{5});
  const auto exact = rounded_places(frame_table(straight(), profile, 8));
  auto late = exact;
  late.front().second = 0.125;
  EXPECT_EQ(worst_speed_error(straight(), profile, 8, late, 1e-6L).frame, 0);
  expect_near_relative(worst_speed_error(straight(), profile, 8, late, 1e-6L).worst_distance, 0.0625L,
                       1e-15L);
  auto early = exact;
  early.back().second = 0.875;
  EXPECT_EQ(worst_speed_error(straight(), profile, 8, early, 1e-6L).frame, 7);
}

TEST(OracleChecker, StepsBelowAMillionthMayRoundAtThePrecisionUnderTest) {
  // 100 units: the first of the steps is 1e-8 units long, the second 300 times the limit.
  const Path path(keys_of(Kind::linear, {{0}, {100}}));
  const Profile profile(std::vector<double>{0, 10});
  const int frames = 100000;
  auto places = rounded_places(frame_table(path, profile, frames));
  EXPECT_LE(worst_speed_error(path, profile, frames, places, 1e-9L).worst, 1);
  const double ulp = 0x1p-52;
  places[1].second += 7 * ulp;
  EXPECT_LE(worst_speed_error(path, profile, frames, places, 1e-9L).worst, 1);
  places[1].second += 2 * ulp;
  EXPECT_GT(worst_speed_error(path, profile, frames, places, 1e-9L).worst, 1);
  EXPECT_LE(worst_speed_error(path, profile, frames, places, 1e-9L, 0x1p-23L).worst, 1);
}

TEST(OracleChecker, LongStepsAreNotForgivenTheirRounding) {
  const Path path(keys_of(Kind::linear, {{0}, {100}}));
  const Profile profile(std::vector<double>{1});
  const int frames = 100000;  // steps of 1e-5 of the length; 1e-9 of that is 45 spacings of double
  auto places = rounded_places(frame_table(path, profile, frames));
  places[7].second += 48 * 0x1p-52;
  const SpeedError error = worst_speed_error(path, profile, frames, places, 1e-9L);
  EXPECT_GT(error.worst, 1);
  EXPECT_EQ(error.frame, 6);
}

TEST(OracleChecker, GoingBackAndMovingInADwellAreErrors) {
  const Profile dwell(std::vector<double>{5, 0, 0, 0, 0, 5});
  auto places = rounded_places(frame_table(parabola(1), dwell, 10));
  EXPECT_LE(worst_speed_error(parabola(1), dwell, 10, places, 1e-9L).worst, 1);
  places[5].second += 1e-13;
  EXPECT_GT(worst_speed_error(parabola(1), dwell, 10, places, 1e-9L).worst, 1);

  const Profile even(std::vector<double>{5});
  auto back = rounded_places(frame_table(straight(), even, 8));
  std::swap(back[3], back[4]);
  const SpeedError error = worst_speed_error(straight(), even, 8, back, 0.5L);
  EXPECT_EQ(error.frame, 3);
  expect_near_relative(error.travelled, -12.5L, 1e-15L);
}

TEST(OracleChecker, NamesTheFrameThatIsNotOnThePath) {
  const Profile profile(std::vector<double>{5});
  auto places = rounded_places(frame_table(straight(), profile, 8));
  EXPECT_THROW(worst_speed_error(straight(), profile, 9, places, 1e-6L), std::invalid_argument);
  for (const auto& wrong :
       {std::pair(2, 0.5), std::pair(-1, 0.5), std::pair(0, 1.5), std::pair(0, std::nan(""))}) {
    places[3] = wrong;
    try {
      worst_speed_error(straight(), profile, 8, places, 1e-6L);
      ADD_FAILURE() << "a place beside the path was accepted";
    } catch (const std::out_of_range& error) {
      EXPECT_NE(std::string(error.what()).find("frame 3"), std::string::npos) << error.what();
    }
  }
}

TEST(OracleChecker, NothingIsWrongWhereNothingMoves) {
  const Path path(keys_of(Kind::smooth, {{4}, {4}}));
  const Profile profile(std::vector<double>{5});
  const std::vector<std::pair<int, double>> places(9, {0, 0.0});
  EXPECT_EQ(worst_speed_error(path, profile, 8, places, 1e-9L).worst, 0);
}

RC_GTEST_PROP(OracleChecker, AcceptsTheExactTableRoundedToDouble, (const RandomMove& move)) {
  const Path path(move.keys);
  const Profile profile(move.speed);
  const auto places = rounded_places(frame_table(path, profile, move.frames));
  const SpeedError error = worst_speed_error(path, profile, move.frames, places, 1e-9L);
  RC_ASSERT(error.worst <= 1);
  RC_ASSERT(error.worst_distance < 1e-15L);
}

// --- motion
// -------------------------------------------------------------------------------------------------------

TEST(OracleMotion, OnALineIsTheSpeedCurve) {
  const Profile profile(std::vector<double>{0, 0, 10, 30, 4, 0, 0});
  const Path path(keys_of(Kind::linear, {{1e9L, 0}, {1e9L + 30, 40}}));
  const long double k = 50 / profile.integral(6);
  const long double spans_per_second = 6 * 24 / 100.0L;
  for (const long double a : {0.3L, 1.5L, 2.45L, 3.9L, 5.5L}) {
    const Motion motion = motion_at(path, profile, 100, 24, a / spans_per_second);
    const long double distance = k * profile.integral(a);
    const long double speed = k * spans_per_second * profile.value(a);
    const long double acceleration = k * std::pow(spans_per_second, 2.0L) * profile.derivative(1, a);
    const long double jerk = k * std::pow(spans_per_second, 3.0L) * profile.derivative(2, a);
    EXPECT_NEAR(static_cast<double>(motion.position[0] - 1e9L), static_cast<double>(0.6L * distance), 1e-9);
    EXPECT_NEAR(static_cast<double>(motion.position[1]), static_cast<double>(0.8L * distance), 1e-16);
    EXPECT_NEAR(static_cast<double>(motion.velocity[1]), static_cast<double>(0.8L * speed), 1e-14);
    EXPECT_NEAR(static_cast<double>(motion.acceleration[0]), static_cast<double>(0.6L * acceleration), 1e-12);
    EXPECT_NEAR(static_cast<double>(motion.jerk[1]), static_cast<double>(0.8L * jerk), 1e-9);
  }
}

TEST(OracleMotion, OnAParabolaAtConstantSpeedIsTheFormula) {
  const Path path = parabola(1);
  const Profile profile(std::vector<double>{2});
  const long double v = path.total_length() * 25 / 100;  // units a second
  for (const long double u : {-0.8L, -0.1L, 0.4L}) {
    const long double seconds = path.distance(1, (u + 1) / 2) / v;
    const Motion motion = motion_at(path, profile, 100, 25, seconds);
    const long double sigma = std::sqrt(1 + 4 * u * u);
    const long double u1 = v / sigma;
    const long double u2 = -4 * u * v * v / std::pow(sigma, 4.0L);
    const long double u3 = -4 * v * v * u1 * (std::pow(sigma, -4.0L) - 16 * u * u * std::pow(sigma, -6.0L));
    expect_near_relative(motion.position[0], u, 1e-17L);
    expect_near_relative(motion.velocity[0], u1, 1e-13L);
    expect_near_relative(motion.velocity[1], 2 * u * u1, 1e-13L);
    expect_near_relative(motion.acceleration[0], u2, 1e-11L);
    expect_near_relative(motion.acceleration[1], 2 * u1 * u1 + 2 * u * u2, 1e-11L);
    expect_near_relative(motion.jerk[0], u3, 1e-8L);
    expect_near_relative(motion.jerk[1], 6 * u1 * u2 + 2 * u * u3, 1e-8L);
    EXPECT_LE(std::fabs(motion.velocity[0] - u1), motion.velocity_error[0]);
    EXPECT_LE(std::fabs(motion.acceleration[0] - u2), motion.acceleration_error[0]);
    EXPECT_LE(std::fabs(motion.jerk[0] - u3), motion.jerk_error[0]);
  }
}

TEST(OracleMotion, RefusesPlacesWhereTheMoveIsNotSmooth) {
  const Profile profile(std::vector<double>{5, 1, 5});
  const auto at_distance = [](const Path& path, long double share) {
    return motion_at(path, Profile(std::vector<double>{5}), 24, 24,
                     share * path.distance(1, 0.5L) / path.total_length());
  };
  EXPECT_THROW(motion_at(straight(), profile, 24, 24, 0.5L), std::domain_error) << "a control value";
  EXPECT_THROW(at_distance(cusp(), 1), std::domain_error) << "a cusp";
  EXPECT_NO_THROW(at_distance(cusp(), 0.95L));
}

}  // namespace oracle_test
}  // namespace inbetween::oracle

namespace inbetween {
namespace oracle_test {

// --- random moves
// -------------------------------------------------------------------------------------------------

RC_GTEST_PROP(RandomMoves, AreWhatTheyPromise, (const RandomMove& move)) {
  const oracle::Keys& keys = move.keys;
  RC_TAG(keys.kind == oracle::Kind::smooth        ? "smooth"
         : keys.kind == oracle::Kind::catmull_rom ? "catmull-rom"
         : keys.kind == oracle::Kind::tcb         ? "tcb"
                                                  : "linear",
         move.singular ? "singular" : "regular");
  RC_ASSERT(keys.at.size() >= 2U && keys.at.size() <= 12U);
  RC_ASSERT(keys.at.front().size() >= 1U && keys.at.front().size() <= 6U);
  RC_ASSERT(move.frames >= 1 && move.frames <= 400);
  RC_ASSERT(!move.speed.empty() && move.speed.size() <= 20U);
  RC_ASSERT(std::any_of(move.speed.begin(), move.speed.end(), [](double value) { return value > 0; }));
  RC_ASSERT(std::all_of(move.speed.begin(), move.speed.end(),
                        [](double value) { return value >= 0 && value <= 100; }));
  const auto is_double = [](long double x) { return static_cast<long double>(static_cast<double>(x)) == x; };
  for (const auto& key : keys.at) RC_ASSERT(std::all_of(key.begin(), key.end(), is_double));
  for (const auto& key : keys.tension_continuity_bias) {
    RC_ASSERT(std::all_of(key.begin(), key.end(), is_double));
    RC_ASSERT(std::all_of(key.begin(), key.end(), [](long double x) { return x >= -1 && x <= 1; }));
  }
  RC_ASSERT(std::all_of(keys.weights.begin(), keys.weights.end(), is_double));
  RC_ASSERT(move.singular == (oracle::Path(keys).slowest() < 1e-6L));
}

TEST(RandomMoves, CoverEveryKindAndTheRareCases) {
  std::array<int, 4> of_kind{};
  int singular = 0;
  int closed = 0;
  int at_rest = 0;
  int weightless = 0;
  const int count = 2000;
  for (int seed = 0; seed < count; ++seed) {
    const RandomMove move =
        random_move()(rc::Random(static_cast<std::uint64_t>(seed)), rc::kNominalSize).value();
    EXPECT_NO_THROW(oracle::Path{move.keys}) << "seed " << seed << '\n' << as_toml(move);
    of_kind[static_cast<std::size_t>(move.keys.kind)] += 1;
    singular += move.singular ? 1 : 0;
    closed += move.keys.closed ? 1 : 0;
    at_rest += move.speed.size() >= 3 && move.speed[0] == 0 && move.speed[1] == 0 ? 1 : 0;
    weightless += std::count(move.keys.weights.begin(), move.keys.weights.end(), 0.0L) > 0 ? 1 : 0;
  }
  for (const int kind : of_kind) EXPECT_GT(kind, count / 6);
  EXPECT_GT(singular, count / 10);
  EXPECT_LT(singular, count / 3);
  EXPECT_GT(closed, count / 6);
  EXPECT_GT(at_rest, count / 4);
  EXPECT_GT(weightless, count / 100);
}

TEST(RandomMoves, ArePrintedAsAMoveThatCanBePasted) {
  RandomMove move;
  move.keys = {.kind = oracle::Kind::tcb,
               .closed = true,
               .at = {{0, static_cast<long double>(0.1)}, {1e100L, -7}},
               .tension_continuity_bias = {{0, 0, 0}, {1, -0.25L, 0.5L}},
               .weights = {1, 0.5L}};
  move.speed = {0, 0, 12.5};
  move.frames = 24;
  EXPECT_EQ(as_toml(move), R"(name = "random move"
fps = 24
frames = 24

[[track]]
axes = ["x0", "x1"]
spline = "tcb"
closed = true
keys = [
  { at = [0.0, 0.1], tension = 0.0, continuity = 0.0, bias = 0.0 },
  { at = [1e+100, -7.0], tension = 1.0, continuity = -0.25, bias = 0.5 },
]
speed = [0.0, 0.0, 12.5]
weights = [1.0, 0.5]
)");
}

}  // namespace oracle_test
}  // namespace inbetween
