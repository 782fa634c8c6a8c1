#include "inbetween/timing/frame_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include "host_tools/plan/solved_track.hpp"
#include "tests/support/oracle_table.hpp"
#include "tests/support/solved_move.hpp"

namespace inbetween {
namespace frame_table_test {

using testing::HasSubstr;

RandomMove ordinary_move() {
  RandomMove move;
  move.keys = {.kind = oracle::Kind::smooth,
               .closed = false,
               .at = {{0, 0}, {5, 9}, {20, 3}, {18, -4}, {30, -10}},
               .tension_continuity_bias = {},
               .weights = {}};
  move.speed = {0, 0, 10, 30, 4, 4, 0, 0};
  move.frames = 100;
  return move;
}

/// A long dwell on frames 4 to 6, entered and left at a run.
RandomMove dwelling_move() {
  RandomMove move = ordinary_move();
  move.speed = {50, 0, 0, 0, 0, 50};
  move.frames = 10;
  return move;
}

void expect_near(double value, long double expected, long double tolerance) {
  EXPECT_LE(std::fabs(static_cast<long double>(value) - expected), tolerance)
      << value << " is not " << expected;
}

// --- what a table says

TEST(FrameTable, RowsReadAsTheOracleDrawsThem) {
  for (const bool closed : {false, true}) {
    RandomMove move = ordinary_move();
    move.keys.closed = closed;
    move.keys.weights = {1, 0.5L};
    const SolvedTrack solution = solve(move);
    const oracle::Path path(move.keys);
    const std::vector<oracle::Row> expected =
        oracle::frame_table(path, oracle::Profile(move.speed), move.frames);
    const auto fps = static_cast<long double>(24);
    const auto delta = static_cast<long double>(Precision::default_delta);
    const long double digits = 64 * static_cast<long double>(std::numeric_limits<double>::epsilon());
    const long double exact = std::max(1e-9L, digits);  // the length itself, at this delta
    for (std::int32_t frame = 0; frame <= move.frames; ++frame) {
      const FrameRow row = frame_row(solution.track(), solution.table(), frame);
      const oracle::Row& drawn = expected[static_cast<std::size_t>(frame)];
      expect_near(row.alpha, drawn.alpha, digits * 7);
      expect_near(row.distance, drawn.distance, delta * path.total_length());
      expect_near(row.speed, drawn.speed * fps, exact * 40);
      expect_near(row.acceleration, drawn.acceleration * fps * fps, exact * 1000);
      EXPECT_EQ(row.point, solution.table().point(frame));
    }
  }
}

TEST(FrameTable, ThePositionsOfAllRowsHaveTheBitsOfEach) {
  const SolvedTrack solution = solve(ordinary_move());
  const Path& path = solution.track().path();
  const std::span<const PathPoint> points = solution.table().points();
  std::vector<double> positions(points.size() * static_cast<std::size_t>(path.axis_count()));
  path.positions(points, positions);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    EXPECT_EQ(positions[i],
              path.position(points[i % points.size()], static_cast<std::int32_t>(i / points.size())))
        << i;
  }
}

TEST(FrameTable, RowsOfAnotherConstantAreReadWithThatConstant) {
  const SolvedTrack solution = solve(ordinary_move());
  const FrameTable twice(solution.table().points(),
                         {.constant = 2 * solution.track().constant(), .speed_error = 1e-6});
  const FrameRow row = frame_row(solution.track(), solution.table(), 40);
  const FrameRow doubled = frame_row(solution.track(), twice, 40);
  EXPECT_DOUBLE_EQ(doubled.speed, 2 * row.speed);
  EXPECT_DOUBLE_EQ(doubled.acceleration, 2 * row.acceleration);
  EXPECT_EQ(doubled.distance, row.distance);
}

TEST(FrameTable, SaysHowGoodItIs) {
  const SolvedTrack solution = solve(ordinary_move());
  EXPECT_EQ(solution.table().frames(), 100);
  const Provenance& provenance = solution.table().provenance();
  EXPECT_EQ(provenance.speed_error, Precision::default_delta);
  EXPECT_EQ(provenance.constant, solution.track().constant());
  EXPECT_EQ(provenance.short_step_error, 0);
}

TEST(FrameTable, StatesTheCapacityNeededWhichSuffices) {
  const SolvedTrack solution = solve(ordinary_move());
  std::vector<PathPoint> points(100);
  const auto refused = closed_form_table(solution.track(), points);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::capacity);
  ASSERT_EQ(refused.error().needed, 101);
  points.resize(101);
  EXPECT_TRUE(closed_form_table(solution.track(), points));
}

TEST(FrameTable, OneKeyIsOneRowAfterAnother) {
  RandomMove move = ordinary_move();
  move.keys.at.resize(1);
  const SolvedTrack solution = solve(move);
  ASSERT_EQ(solution.table().frames(), 100);
  for (std::int32_t frame = 0; frame <= 100; ++frame) {
    const FrameRow row = frame_row(solution.track(), solution.table(), frame);
    EXPECT_EQ(row.point, (PathPoint{0, 0}));
    EXPECT_EQ(row.distance, 0);
    EXPECT_EQ(row.speed, 0);
    EXPECT_EQ(row.acceleration, 0);
  }
  EXPECT_TRUE(check_invariants(solution.track(), solution.table()));
}

// --- its invariants

TEST(FrameTable, GoodTablesKeepEveryRule) {
  for (const oracle::Kind kind : {oracle::Kind::smooth, oracle::Kind::catmull_rom, oracle::Kind::linear}) {
    for (const bool closed : {false, true}) {
      for (RandomMove move : {ordinary_move(), dwelling_move()}) {
        move.keys.kind = kind;
        move.keys.closed = closed;
        const SolvedTrack solution = solve(move);
        const Status status = check_invariants(solution.track(), solution.table());
        EXPECT_TRUE(status) << status.error().what;
      }
    }
  }
}

using Damage = std::function<void(std::vector<PathPoint>&)>;

/// Damages a good table and expects the rule and the frame to be named.
void expect_broken(const RandomMove& move, const Damage& damage, const char* rule, std::int32_t frame) {
  const SolvedTrack solution = solve(move);
  const auto good = solution.table().points();
  std::vector<PathPoint> points(good.begin(), good.end());
  damage(points);
  const FrameTable table(points, solution.table().provenance());
  const Status status = check_invariants(solution.track(), table);
  ASSERT_FALSE(status) << "nobody noticed: " << rule;
  EXPECT_THAT(status.error().what, HasSubstr(rule));
  EXPECT_EQ(status.error().frame, frame);
}

TEST(FrameTable, APairOfFramesThatChangedPlacesIsNoticed) {
  using Points = std::vector<PathPoint>;
  expect_broken(
      ordinary_move(), [](Points& points) { std::swap(points[50], points[51]); }, "s falls", 51);
  expect_broken(
      ordinary_move(), [](Points& points) { std::swap(points[99], points[100]); }, "s falls", 100);
}

TEST(FrameTable, APointBesideThePathIsNoticed) {
  using Points = std::vector<PathPoint>;
  const double infinity = std::numeric_limits<double>::infinity();
  for (const PathPoint& bad : {PathPoint{2, 1.5},
                               {2, -0.5},
                               {2, 1.001},
                               {2, std::nextafter(1.0, 2.0)},
                               {-1, 0},
                               {5, 0},
                               {4, 1e-30},
                               {2, std::numeric_limits<double>::quiet_NaN()},
                               {2, infinity}}) {
    expect_broken(
        ordinary_move(), [&](Points& points) { points[50] = bad; }, "not on the path", 50);
  }
}

TEST(FrameTable, AFirstFrameThatLeftTheFirstKeyIsNoticed) {
  using Points = std::vector<PathPoint>;
  const double ulp = std::numeric_limits<double>::denorm_min();
  expect_broken(
      ordinary_move(),
      [&](Points& points) {
        points[0] = {0, ulp};
      },
      "begin at the first key", 0);
  expect_broken(
      ordinary_move(),
      [&](Points& points) {
        points[0] = {0, -ulp};
      },
      "not on the path", 0);
  expect_broken(
      ordinary_move(),
      [&](Points& points) {
        points[0] = {1, 0};
      },
      "s falls", 1);
}

TEST(FrameTable, ALastFrameThatMissesTheLastKeyIsNoticed) {
  using Points = std::vector<PathPoint>;
  // {3, 1} is the place of the last key, but not written as every reader expects it.
  for (const PathPoint& bad : {PathPoint{3, std::nextafter(1.0, 0.0)}, {3, 1}}) {
    expect_broken(
        ordinary_move(), [&](Points& points) { points[100] = bad; }, "end at the last key", 100);
  }
}

TEST(FrameTable, AFrameAwayFromItsDrawnSpeedIsNoticed) {
  using Points = std::vector<PathPoint>;
  for (const double off : {1e-3, -1e-3}) {
    expect_broken(
        ordinary_move(), [&](Points& points) { points[58].t += off; }, "speed is not as drawn", 58);
  }
}

TEST(FrameTable, ACreepWithinADwellIsNoticed) {
  // 1e-9 of a segment: too little to show in the step that leaves the dwell.
  expect_broken(
      dwelling_move(), [](std::vector<PathPoint>& points) { points[6].t += 1e-9; }, "short step", 6);
}

TEST(FrameTable, ARowTooFewIsNoticed) {
  expect_broken(
      ordinary_move(), [](std::vector<PathPoint>& points) { points.pop_back(); },
      "not one row for every frame", 99);
}

TEST(FrameTable, TheFirstBrokenRuleIsTheOneNamed) {
  using Points = std::vector<PathPoint>;
  expect_broken(
      ordinary_move(),
      [](Points& points) {
        points[0] = {0, 1e-300};
        std::swap(points[50], points[51]);
        points[70].t = 7;
      },
      "s falls", 51);
  expect_broken(
      ordinary_move(),
      [](Points& points) {
        points[0] = {0, 1e-300};
        points[100] = {3, 1};
        points[60].t += 1e-3;
      },
      "begin at the first key", 0);
}

// --- the measure of speed

TEST(FrameTable, TheDeviationIsThatOfTheWorstStep) {
  // 10 frames at one unit a frame along a line.
  RandomMove move = ordinary_move();
  move.keys.at = {{0, 0}, {10, 0}};
  move.speed = {1};
  move.frames = 10;
  const SolvedTrack solution = solve(move);
  const auto good = solution.table().points();
  std::vector<PathPoint> points(good.begin(), good.end());
  EXPECT_LE(measure_speed_deviation(solution.track(), points).relative, 1e-13);
  points[4].t += 0.002;  // 0.02 units
  points[7].t -= 0.001;
  const auto deviation = measure_speed_deviation(solution.track(), points);
  EXPECT_NEAR(deviation.relative, 0.02, 1e-12);
  EXPECT_TRUE(deviation.frame == 4 || deviation.frame == 5);
  EXPECT_EQ(deviation.absolute, 0);
  EXPECT_EQ(deviation.absolute_frame, -1);
}

}  // namespace frame_table_test
}  // namespace inbetween
