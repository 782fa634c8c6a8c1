// What judges the product: that it sees what is narrow, and finds what is wrong. Where the product and the
// oracle must agree, closed forms are held against the product.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
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

std::vector<std::pair<int, double>> rounded_places(const std::vector<Row>& table) {
  std::vector<std::pair<int, double>> result;
  result.reserve(table.size());
  for (const Row& row : table) result.emplace_back(row.place.segment, static_cast<double>(row.place.t));
  return result;
}

// --- quadrature

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

// --- table and checker

const Path& straight() {
  static const Path path(keys_of(Kind::linear, {{0, 0}, {30, 40}, {60, 80}}));
  return path;
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

RC_GTEST_PROP(OracleChecker, AcceptsTheExactTableRoundedToDouble, (const RandomMove& move)) {
  const Path path(move.keys);
  const Profile profile(move.speed);
  const auto places = rounded_places(frame_table(path, profile, move.frames));
  const SpeedError error = worst_speed_error(path, profile, move.frames, places, 1e-9L);
  RC_ASSERT(error.worst <= 1);
  RC_ASSERT(error.worst_distance < 1e-15L);
}

}  // namespace oracle_test
}  // namespace inbetween::oracle

namespace inbetween {
namespace oracle_test {

// --- random moves

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
  const int count = 600;
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
