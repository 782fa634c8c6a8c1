#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "inbetween/path/path.hpp"
#include "tests/support/oracle_path.hpp"
#include "tests/support/property.hpp"
#include "tests/support/random_move.hpp"
#include "tests/support/solved_move.hpp"

/// The path and its arc length against the oracle, on random moves of every kind of path.

namespace inbetween {
namespace path_property_test {

constexpr int many_moves = 2000;

/// The largest coefficient of an axis anywhere on the path: its size, with all its bends.
long double size_of(const oracle::Path& path, int axis) {
  long double largest = 0;
  for (int i = 0; i < path.segments(); ++i) {
    for (const int order : {1, 2, 3}) {
      const long double factor = order == 3 ? 6 : order;
      largest = std::max(largest, std::fabs(path.derivative(order, i, 0, axis)) / factor);
    }
  }
  return largest;
}

void expect_near(double value, long double expected, long double tolerance) {
  RC_LOG() << value << " is off by " << static_cast<long double>(value) - expected << ", allowed "
           << tolerance << '\n';
  RC_ASSERT(std::fabs(static_cast<long double>(value) - expected) <= tolerance);
}

/// Offsets from the key and derivatives, all in one: a cubic is known by its coefficients.
void expect_cubic(const Cubic& cubic, const oracle::Path& path, int segment, long double t, int axis,
                  long double ulps) {
  const auto epsilon = static_cast<long double>(std::numeric_limits<double>::epsilon());
  const long double tolerance = ulps * epsilon * size_of(path, axis);
  const auto coefficient = [](double c) { return static_cast<double>(c); };
  expect_near(coefficient(cubic.c1), path.derivative(1, segment, t, axis), tolerance);
  expect_near(coefficient(cubic.c2), path.derivative(2, segment, t, axis) / 2, tolerance);
  expect_near(coefficient(cubic.c3), path.derivative(3, segment, t, axis) / 6, tolerance);
}

TEST(PathProperty, IsTheOraclesPathToAFewUlpOfItsSize) {
  check_property(many_moves, [](const RandomMove& move) {
    const oracle::Path expected(move.keys);
    const TrackInput input(move);
    std::vector<Cubic> cubics(input.keys.size() + static_cast<std::size_t>(input.spec.path.axis_count));
    std::vector<double> weights(static_cast<std::size_t>(input.spec.path.axis_count));
    const Path path = *Path::make(input.spec.path, {cubics, weights});
    const int segments = path.segment_count();
    RC_ASSERT(segments == expected.segments());
    for (int axis = 0; axis < path.axis_count(); ++axis) {
      const auto d = static_cast<std::size_t>(axis);
      for (int i = 0; i <= segments; ++i) {
        const Cubic& cubic = path.segment(i)[d];
        const std::size_t key = static_cast<std::size_t>(i) % move.keys.at.size();
        RC_ASSERT(static_cast<long double>(path.position({i, 0}, axis)) == move.keys.at[key][d]);
        // The continuation is expanded at the end of the last segment.
        expect_cubic(cubic, expected, std::min(i, segments - 1), i < segments ? 0 : 1, axis,
                     i < segments ? 16 : 64);
      }
    }
  });
}

TEST(PathProperty, TheParametricSpeedIsTheOracles) {
  check_property(many_moves, [](const RandomMove& move) {
    const oracle::Path expected(move.keys);
    const SolvedTrack solved = solve(move);
    const Path& path = solved.track().path();
    const int segment = *rc::gen::inRange(0, path.segment_count());
    const double t = *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(0, 1001)) / 1000.0;
    long double size = 0;  // weights are at most 4
    for (int axis = 0; axis < path.axis_count(); ++axis) {
      const long double weight = static_cast<long double>(path.weights()[static_cast<std::size_t>(axis)]);
      size += weight * size_of(expected, axis);
    }
    expect_near(path.parametric_speed({segment, t}), expected.speed(segment, static_cast<long double>(t)),
                100 * 2.2e-16L * size);
  });
}

// --- arc length

/// A place anywhere on the path, rather often at a key.
PathPoint random_point(std::int32_t segments) {
  const int part = *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(-100, 1000));
  return {*rc::gen::inRange(0, segments), std::max(part, 0) / 1000.0};
}

TEST(ArcLengthProperty, TheTotalIsTheOraclesToTwelveDigits) {
  check_property(many_moves, [](const RandomMove& move) {
    const long double expected = oracle::Path(move.keys).total_length();
    const SolvedTrack solved = solve(move, {.delta = 1e-9});
    expect_near(solved.track().arc_length().total(), expected, 1e-12L * expected);
  });
}

TEST(ArcLengthProperty, TheDistanceToAPointIsTheOracles) {
  check_property(many_moves, [](const RandomMove& move) {
    const oracle::Path expected(move.keys);
    const SolvedTrack solved = solve(move, {.delta = 1e-9});
    const Track& track = solved.track();
    for (int i = 0; i < 4; ++i) {
      const PathPoint point = random_point(track.path().segment_count());
      expect_near(track.arc_length().distance(track.path(), point).high,
                  expected.distance(point.segment, static_cast<long double>(point.t)),
                  1e-12L * expected.total_length());
    }
  });
}

TEST(ArcLengthProperty, TheInverseComesBackToThePointMeasured) {
  check_property(many_moves, [](const RandomMove& move) {
    const oracle::Path path(move.keys);
    for (const double delta : {1e-4, 1e-6, 1e-9}) {
      const SolvedTrack solved = solve(move, {.delta = delta});
      const Track& track = solved.track();
      const PathPoint point = random_point(track.path().segment_count());
      const PathPoint back = track.arc_length().locate(track.arc_length().distance(track.path(), point));
      const auto place = [&](const PathPoint& p) {
        const bool at_end = p.segment == path.segments();
        const double t = std::clamp(p.t, 0.0, 1.0);
        return at_end ? oracle::Place{p.segment - 1, 1}
                      : oracle::Place{p.segment, static_cast<long double>(t)};
      };
      // A piece is exact at its ends, and its speed is wrong by less than delta between them.
      const long double off = std::fabs(path.travelled(place(point), place(back)));
      RC_LOG() << "delta " << delta << ": off by " << off / path.total_length() << " of the length\n";
      RC_ASSERT(off <= (static_cast<long double>(delta) / 2 + 8 * 2.2e-16L) * path.total_length());
    }
  });
}

/// Pieces a segment, on average over random moves that nowhere slow down to a fifth within a segment:
/// what one would draw. (A narrow bend takes more, and is no worse for it.)
double pieces_per_segment(double delta) {
  double pieces = 0;
  double segments = 0;
  check_property(200, [&] {
    const RandomMove move = *rc::gen::suchThat(
        regular_move(), [](const RandomMove& drawn) { return oracle::Path(drawn.keys).slowest() > 0.2L; });
    const SolvedTrack solved = solve(move, {.delta = delta});
    pieces += solved.track().arc_length().piece_count();
    segments += solved.track().path().segment_count();
  });
  return pieces / segments;
}

TEST(ArcLengthProperty, OrdinaryPathsTakeFewPieces) {
  EXPECT_LE(pieces_per_segment(1e-4), 13);
  EXPECT_LE(pieces_per_segment(1e-6), 19);
  EXPECT_LE(pieces_per_segment(1e-9), 41);
}

}  // namespace path_property_test
}  // namespace inbetween
