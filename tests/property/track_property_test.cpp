#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <vector>

#include "inbetween/timing/track.hpp"
#include "tests/support/oracle_table.hpp"
#include "tests/support/property.hpp"
#include "tests/support/random_move.hpp"
#include "tests/support/solved_move.hpp"

/// What the real-time loop evaluates, between the frames too, against the oracle on random moves.

namespace inbetween {
namespace track_property_test {

constexpr int many_moves = 1000;

long double widened(double value) {
  return static_cast<long double>(value);
}

void expect_near(double value, long double expected, long double tolerance) {
  RC_LOG() << value << " is off by " << widened(value) - expected << ", allowed " << tolerance << '\n';
  RC_ASSERT(std::fabs(widened(value) - expected) <= tolerance);
}

/// A time anywhere in a move, rather often on a frame.
FrameTime random_time(std::int32_t frames) {
  const int part = *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(-200, 1000));
  return {*rc::gen::resize(rc::kNominalSize, rc::gen::inRange(0, frames)), std::max(part, 0) / 1000.0};
}

long double frame_of(const FrameTime& time) {
  return static_cast<long double>(time.frame) + widened(time.fraction);
}

// --- derivatives between frames

/// How far a derivative in time may be off when the place on the path is off by `error` in t: the
/// derivatives along the path change by their own size when t changes by `reach`.
struct Sensitivity {
  long double reach = 0;     ///< in t
  long double per_second[4]  ///< s', and what the speed curve adds to s'' and s''', as powers of it
      = {};

  Sensitivity(const oracle::Path& path, oracle::Place place, const AlongPath& along) {
    const auto weighted = [&](int order) {
      long double sum = 0;
      for (int axis = 0; axis < path.axes(); ++axis) {
        // The weights are not the oracle's to tell; they are at most 4, and 1 where there are none.
        sum += std::fabs(path.derivative(order, place.segment, place.t, axis));
      }
      return 4 * sum;
    };
    const long double sigma = path.speed(place.segment, place.t);
    reach = 1 / (1 + weighted(2) / sigma + std::sqrt(weighted(3) / sigma));
    const long double first = std::fabs(widened(along.speed)) / sigma;
    const long double second = std::fabs(widened(along.acceleration)) / sigma;
    const long double third = std::fabs(widened(along.jerk)) / sigma;
    per_second[1] = first;
    per_second[2] = first * first / reach + second;
    per_second[3] = first * first * first / (reach * reach) + first * second / reach + third;
  }

  /// Of the derivative of the given order of an axis that is `size` large.
  long double tolerance(int order, long double size, long double error) const {
    return error / reach * per_second[order] * size;
  }
};

/// |P'| + |P''| + |P'''| of an axis at a place: how much it changes when t changes by 1.
long double size_at(const oracle::Path& path, oracle::Place place, int axis) {
  long double sum = 0;
  for (const int order : {1, 2, 3}) sum += std::fabs(path.derivative(order, place.segment, place.t, axis));
  return sum;
}

std::optional<oracle::Motion> motion_of(const oracle::Path& path, const oracle::Profile& profile, int frames,
                                        long double frame) {
  try {
    return oracle::motion_at(path, profile, frames, 24, frame / 24);
  } catch (const std::domain_error&) {
    return std::nullopt;  // at a key, a control value or a cusp there is no derivative to compare with
  }
}

TEST(TrackProperty, EveryDerivativeBetweenFramesIsTheOracles) {
  int compared = 0;
  int tight = 0;
  check_property(many_moves, [&] {
    const RandomMove move = *regular_move();
    const oracle::Path path(move.keys);
    const oracle::Profile profile(move.speed);
    const SolvedTrack solved = solve(move, {.delta = 1e-9});
    const Track& track = solved.track();
    std::vector<AxisMotion> axes(static_cast<std::size_t>(path.axes()));
    for (int i = 0; i < 3; ++i) {
      const FrameTime time = random_time(move.frames);
      const std::optional<oracle::Motion> expected = motion_of(path, profile, move.frames, frame_of(time));
      const oracle::Place place = oracle::row_at(path, profile, move.frames, frame_of(time)).place;
      if (!expected || path.speed(place.segment, place.t) == 0) continue;  // nothing moves
      ++compared;
      RC_LOG() << "frame " << frame_of(time) << '\n';
      RC_ASSERT(track.motion(time, axes) == 3);
      const Sensitivity sensitivity(path, place, track.along(time));
      if (sensitivity.reach > 1e-2L) ++tight;
      for (int axis = 0; axis < path.axes(); ++axis) {
        const auto d = static_cast<std::size_t>(axis);
        const long double size = size_at(path, place, axis);
        // Half of delta over a piece of at most a sixteenth of a segment, and what rounding leaves of it.
        const long double error = 1e-10L;
        const auto tolerance = [&](int order) { return sensitivity.tolerance(order, size, error); };
        expect_near(axes[d].position, expected->position[d],
                    error / sensitivity.reach * size + 2.3e-16L * std::fabs(expected->position[d]));
        expect_near(axes[d].velocity, expected->velocity[d], tolerance(1) + expected->velocity_error[d]);
        expect_near(axes[d].acceleration, expected->acceleration[d],
                    tolerance(2) + expected->acceleration_error[d]);
        expect_near(axes[d].jerk, expected->jerk[d], tolerance(3) + expected->jerk_error[d]);
      }
    }
  });
  if (!counts_mean_something()) return;
  EXPECT_GT(compared, many_moves) << "too few times have derivatives to compare with";
  EXPECT_GT(tight, compared / 2) << "most comparisons are too lenient to mean anything";
}

TEST(TrackProperty, AlongThePathEveryDerivativeIsTheDrawnCurvesAtAnyTime) {
  check_property(many_moves, [](const RandomMove& move) {
    const oracle::Path path(move.keys);
    const oracle::Profile profile(move.speed);
    const SolvedTrack solved = solve(move, {.delta = 1e-9});
    const FrameTime time = random_time(move.frames);
    const oracle::Row row = oracle::row_at(path, profile, move.frames, frame_of(time));
    const long double scale =
        path.total_length() / profile.integral(static_cast<long double>(profile.spans()));
    const long double rate =
        24 * static_cast<long double>(profile.spans()) / static_cast<long double>(move.frames);
    const long double largest = widened(*std::ranges::max_element(move.speed));
    const AlongPath along = solved.track().along(time);
    // The phase a is rounded, and with it the derivatives; the length is known to twelve digits.
    const long double exact = 1e-12L * scale * largest * rate;
    expect_near(along.speed, row.speed * 24, exact);
    expect_near(along.acceleration, row.acceleration * 24 * 24, exact * rate * 8);
    expect_near(along.jerk, scale * rate * rate * rate * profile.derivative(2, row.alpha),
                exact * rate * rate * 64);
    expect_near(solved.track().distance(time).high, row.distance, 2e-12L * path.total_length());
  });
}

// --- positions

TEST(TrackProperty, TheTickIsOnThePathWhereTheOraclePutsIt) {
  check_property(many_moves, [](const RandomMove& move) {
    const oracle::Path path(move.keys);
    const oracle::Profile profile(move.speed);
    const SolvedTrack solved = solve(move);
    for (int i = 0; i < 4; ++i) {
      const FrameTime time = random_time(move.frames);
      const PathPoint point = solved.track().locate(time);
      const oracle::Place place = point.segment == path.segments()
                                      ? oracle::Place{point.segment - 1, 1}
                                      : oracle::Place{point.segment, widened(std::clamp(point.t, 0.0, 1.0))};
      const oracle::Place expected = oracle::row_at(path, profile, move.frames, frame_of(time)).place;
      // Within a piece the speed is off by less than delta, and at its ends the place is exact.
      const long double off = std::fabs(path.travelled(expected, place));
      RC_LOG() << "frame " << frame_of(time) << " is off by " << off << " of " << path.total_length() << '\n';
      RC_ASSERT(off <= 5e-7L * path.total_length());
    }
  });
}

TEST(TrackProperty, RowsReadAsTheOracleDrawsThem) {
  check_property(many_moves / 10, [](const RandomMove& move) {
    const oracle::Path path(move.keys);
    const oracle::Profile profile(move.speed);
    const std::vector<oracle::Row> expected = oracle::frame_table(path, profile, move.frames);
    const SolvedTrack solved = solve(move, {.delta = 1e-9});
    long double fastest = 0;
    for (const oracle::Row& row : expected) fastest = std::max(fastest, row.speed);
    const long double rate =
        static_cast<long double>(profile.spans()) / static_cast<long double>(move.frames);
    for (std::int32_t frame = 0; frame <= move.frames; ++frame) {
      const FrameRow row = frame_row(solved.track(), solved.table(), frame);
      const oracle::Row& drawn = expected[static_cast<std::size_t>(frame)];
      RC_LOG() << "frame " << frame << '\n';
      expect_near(row.alpha, drawn.alpha, 1e-14L);
      expect_near(row.distance, drawn.distance, 1e-9L * path.total_length());
      expect_near(row.speed, drawn.speed * 24, 1e-11L * fastest * 24);
      const long double largest = path.total_length() * 100 * 8 * rate * rate /
                                  profile.integral(static_cast<long double>(profile.spans()));
      expect_near(row.acceleration, drawn.acceleration * 576, 1e-12L * 576 * largest);
    }
  });
}

}  // namespace track_property_test
}  // namespace inbetween
