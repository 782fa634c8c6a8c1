#include "inbetween/limits/stop_bounds.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "host_tools/plan/solved_track.hpp"
#include "tests/support/bounded_cells.hpp"

/// Stop bounds of moves that are known by hand; random moves and stops are in tests/property.

namespace inbetween {
namespace stop_bounds_test {

/// Of the playhead, in seconds.
constexpr double tick = 0.001;

constexpr std::size_t cells = 128;

SolvedTrack solved(const PathSpec& path, const std::vector<double>& speed, std::int32_t frames) {
  return SolvedTrack(
      {.path = path, .control_values = speed, .frames = frames, .fps = {24, 1}, .arc_length = {}},
      Solver::closed_form);
}

AxisLimits stop_limits(double acceleration, std::optional<double> jerk = std::nullopt) {
  AxisLimitsSpec spec{
      .min = -10'000, .max = 10'000, .max_velocity = 10'000, .max_acceleration = acceleration};
  spec.stop_acceleration = acceleration;
  spec.stop_jerk = jerk;
  return *AxisLimits::make(spec);
}

/// A move with its track.
struct TrackedMove {
  Move move;
  std::span<const Track> tracks;
};

TrackedMove move_of(const SolvedTrack& solution, const MoveRolls& rolls = {}) {
  const std::span<const Track> tracks(&solution.track(), 1);
  return {*Move::make(tracks, rolls), tracks};
}

/// Bounds with the memory that they live in.
struct Stops {
  std::vector<StopCell> stop_cells;
  std::vector<AxisPeaks> peaks;
  std::optional<StopObstacle> obstacle;
  Result<StopBounds> bounds;

  Stops(const TrackedMove& move, const std::vector<AxisLimits>& limits, double rate = 1)
      : stop_cells(cells + 1),
        peaks(limits.size()),
        bounds(StopBounds::make(
            {bounded_cells(move.move, move.tracks, limits, cells, rate, tick).cells(), limits, rate, tick},
            stop_cells, peaks, &obstacle)) {}
  Stops(const Stops&) = delete;
  Stops& operator=(const Stops&) = delete;
};

const std::vector<double> line{0, 1000};
const std::vector<double> bend{0, 0, 300, 50, 400, 400, 900, 500};
const std::vector<double> calm{0, 0, 10, 10, 10, 0, 0};

TEST(StopBounds, AStraightLineAtConstantSpeedIsStoppedWithAllItsAxisCanBear) {
  // 100 mm/s; 50 mm/s^2 are 0.5 /s, for a stop of 2 s and, at half the speed on average, one second of the
  // move.
  const auto solution = solved({.axis_count = 1, .keys = line}, {10, 10}, 240);
  const Stops stops(move_of(solution), {stop_limits(50.0)});
  ASSERT_TRUE(stops.bounds.has_value());
  EXPECT_NEAR(stops.bounds->rate_change({120, 0}), 0.5, 0.01);
  EXPECT_LE(stops.bounds->rate_change({120, 0}), 0.5);
  EXPECT_NEAR(stops.bounds->longest_in_time().length.seconds, 2, 0.05);
  EXPECT_NEAR(stops.bounds->longest_in_time().length.frames, 24, 0.6);
  EXPECT_NEAR(stops.peaks[0].acceleration.value, 50, 1e-3);
  EXPECT_NEAR(stops.peaks[0].velocity.value, 100, 2);
}

TEST(StopBounds, AJerkLimitMakesTheQuickestStopOfBothLimits) {
  // R2 = 1 /s^2: from rate 1 the quickest is 2 s, with a rate change of 1 /s in the middle.
  const auto solution = solved({.axis_count = 1, .keys = line}, {10, 10}, 240);
  const Stops gentle(move_of(solution), {stop_limits(1000.0, std::optional(100.0))});
  ASSERT_TRUE(gentle.bounds.has_value());
  EXPECT_NEAR(gentle.bounds->rate_jerk({120, 0}), 1, 0.02);
  EXPECT_NEAR(gentle.bounds->rate_change({120, 0}), 1, 0.02);
  // R1 = 0.5 /s, R2 = 1 /s^2: 2 s, and half a second each to begin and to end, of which one is the other's
  // loss.
  const Stops both(move_of(solution), {stop_limits(50.0, std::optional(100.0))});
  ASSERT_TRUE(both.bounds.has_value());
  const StopLength stop = both.bounds->stop_from({120, 0}, true);
  EXPECT_NEAR(stop.seconds, 0.5 + 2.5, 0.06);
}

TEST(StopBounds, TheJerkThatIsToldIsAllThatTheLimitAllows) {
  // The speed grows all the way: the jerk of every stop has a part by acceleration and change of the rate.
  const auto solution = solved({.axis_count = 1, .keys = line}, {5, 15}, 240);
  const Stops stops(move_of(solution), {stop_limits(1e5, std::optional(100.0))});
  ASSERT_TRUE(stops.bounds.has_value());
  EXPECT_NEAR(stops.peaks[0].jerk.value, 100, 1);
}

TEST(StopBounds, AStopIsAsLongAsFromTheHighestRateChangeInItsCell) {
  const auto solution = solved({.axis_count = 1, .keys = line}, calm, 240);
  const Stops stops(move_of(solution), {stop_limits(500.0, std::optional(500.0))});
  ASSERT_TRUE(stops.bounds.has_value());
  // Nothing lies behind the last cell that could make a stop longer. The slower the axis is, the more may
  // change.
  const StopCell& begin = stops.stop_cells[cells - 1];
  const StopCell& end = stops.stop_cells[cells];
  ASSERT_LT(begin.rate_change, 0.99 * end.rate_change);
  const double change = begin.rate_change;
  const double jerk = std::min(begin.release_jerk, end.release_jerk);
  const double rise = std::min(end.rate_change / jerk, std::sqrt(2 / jerk));
  const double fall = change * change <= jerk ? 1 / change + change / jerk : 2 / std::sqrt(jerk);
  EXPECT_NEAR(stops.bounds->stop_from({239, 0.5}, true).seconds, rise + fall, 1e-9);
}

TEST(StopBounds, AMoveHasACellAFrameUnlessThatIsLessThanTwoTicksOrFewerThan64) {
  const auto of_frames = [](std::int32_t frames, std::int32_t rate_hz, double rate) {
    const auto solution = solved({.axis_count = 1, .keys = line}, calm, frames);
    return stop_cells(move_of(solution).move, rate_hz, rate);
  };
  EXPECT_EQ(of_frames(240, 1000, 1), 240U);
  EXPECT_EQ(of_frames(24, 1000, 1), 64U);
  EXPECT_EQ(of_frames(24, 100, 1), 50U) << "of two ticks";
  EXPECT_EQ(of_frames(24, 100, 2.5), 20U) << "at the highest rate";
  EXPECT_EQ(of_frames(24, 100, 0.5), 50U);
  EXPECT_EQ(of_frames(5000, 1000, 1), static_cast<std::size_t>(max_stop_cells));
}

TEST(StopBounds, AHigherRateLeavesLessAndStopsLater) {
  const auto solution = solved({.axis_count = 2, .keys = bend}, calm, 240);
  const std::vector<AxisLimits> limits(2, stop_limits(2000.0, std::optional(20'000.0)));
  const Stops once(move_of(solution), limits, 1);
  const Stops twice(move_of(solution), limits, 2);
  ASSERT_TRUE(once.bounds.has_value());
  ASSERT_TRUE(twice.bounds.has_value());
  EXPECT_EQ(twice.bounds->rate(), 2);
  EXPECT_GT(twice.bounds->longest_in_time().length.seconds, once.bounds->longest_in_time().length.seconds);
  EXPECT_GT(twice.bounds->longest_in_time().length.frames, 2 * once.bounds->longest_in_time().length.frames);
}

TEST(StopBounds, AMotionThatTakesAllOfAStopLimitIsRefusedWithItsAxisAndPlace) {
  const auto solution = solved({.axis_count = 2, .keys = bend}, calm, 240);
  const std::vector<AxisPeaks> peaks = bounds_of_track(solution.track()).peaks();
  const TrackedMove move = move_of(solution);
  for (const bool by_jerk : {false, true}) {
    const Peak peak = by_jerk ? peaks[1].jerk : peaks[1].acceleration;
    const AxisLimits tight =
        by_jerk ? stop_limits(1e5, std::optional(0.99 * peak.value)) : stop_limits(0.99 * peak.value);
    const std::vector<AxisLimits> limits{stop_limits(1e5), tight};
    Stops stops(move, limits);
    ASSERT_FALSE(stops.bounds.has_value());
    EXPECT_EQ(stops.bounds.error().code, ErrorCode::no_solution);
    EXPECT_EQ(stops.bounds.error().axis, 1);
    EXPECT_NEAR(stops.bounds.error().frame, peak.frame, 8);
    const auto& obstacle = stops.obstacle;
    ASSERT_TRUE(obstacle.has_value());
    EXPECT_EQ(obstacle->quantity, by_jerk ? StopQuantity::jerk : StopQuantity::acceleration);
    EXPECT_EQ(obstacle->axis, 1);
    EXPECT_NEAR(obstacle->frame, peak.frame, 8);
    EXPECT_NEAR(obstacle->value, peak.value, 0.04 * peak.value);
    EXPECT_GE(obstacle->value, obstacle->limit);
    // A little above the peak there is a slow stop.
    const double enough = 1.05 * peak.value;
    const std::vector<AxisLimits> loose{
        stop_limits(1e5), by_jerk ? stop_limits(1e5, std::optional(enough)) : stop_limits(enough)};
    const Stops slow(move, loose);
    EXPECT_TRUE(slow.bounds.has_value());
    EXPECT_FALSE(slow.obstacle.has_value());
  }
}

TEST(StopBounds, WhereNothingMovesTheyAreTheLargestThereAre) {
  const std::vector<double> still{5, 5};
  const auto solution = solved({.axis_count = 1, .keys = still}, {10, 10}, 48);
  const Stops stops(move_of(solution), {stop_limits(1.0, std::optional(1.0))});
  ASSERT_TRUE(stops.bounds.has_value());
  for (const std::int32_t frame : {-10, 0, 20, 48, 500}) {
    EXPECT_DOUBLE_EQ(stops.bounds->rate_change({frame, 0}), 1 / (16 * tick));
    EXPECT_DOUBLE_EQ(stops.bounds->rate_jerk({frame, 0}), 1 / (16 * 8 * tick * tick));
    EXPECT_DOUBLE_EQ(stops.bounds->release_jerk({frame, 0}), 0.99 / (16 * 8 * tick * tick));
  }
  EXPECT_EQ(stops.peaks[0].acceleration.value, 0);
}

TEST(StopBounds, NoStopIsPossibleThroughACuspAtASpeed) {
  const std::vector<double> keys{0, 0, 50, 20, 60, 90, 0, 100};
  const std::vector<KeyShape> shapes{{}, {.tension = 1, .continuity = 0, .bias = 0}, {}, {}};
  const auto solution =
      solved({.spline = Spline::tcb, .axis_count = 2, .keys = keys, .shapes = shapes}, {10, 10}, 48);
  const Stops stops(move_of(solution), {2, stop_limits(1e9)});
  ASSERT_FALSE(stops.bounds.has_value());
  EXPECT_EQ(stops.bounds.error().code, ErrorCode::no_solution);
}

TEST(StopBounds, PreRollAndPostRollAreWithinThem) {
  const auto solution = solved({.axis_count = 1, .keys = line}, {10, 10}, 240);
  // From 0 to 100 mm/s in 12 frames: 200 mm/s^2 on average, where the line itself has none.
  std::vector<AxisMotion> joint{{.position = 0, .velocity = 100}};
  const auto before = *RollAxis::make({RollEnd::before, 0, 12, {24, 1}}, joint[0]);
  joint[0].position = 1000;
  const auto after = *RollAxis::make({RollEnd::after, 240, 12, {24, 1}}, joint[0]);
  const TrackedMove move = move_of(solution, {{&before, 1}, {&after, 1}});
  const double most = before.peaks().acceleration.value;
  const Stops refused(move, {stop_limits(0.99 * most)});
  ASSERT_FALSE(refused.bounds.has_value());
  EXPECT_EQ(refused.bounds.error().frame, -1) << "there are no negative frames in an error";
  ASSERT_TRUE(refused.obstacle.has_value());
  EXPECT_LT(refused.obstacle->frame, 0);
  EXPECT_GT(refused.obstacle->frame, -12);
  const Stops stops(move, {stop_limits(1.5 * most)});
  ASSERT_TRUE(stops.bounds.has_value());
  const StopBounds& bounds = *stops.bounds;
  EXPECT_LT(bounds.rate_change({-6, 0}), 0.9 * bounds.rate_change({120, 0}));
  EXPECT_LT(bounds.rate_change({246, 0}), 0.9 * bounds.rate_change({120, 0}));
  EXPECT_NEAR(bounds.rate_change({120, 0}), 1.5 * most / 100, 0.02 * 1.5 * most / 100);
}

TEST(StopBounds, TheReverseOfAMoveHasTheSameBoundsFromTheOtherEnd) {
  std::vector<double> turned;
  for (std::size_t i = bend.size(); i > 0; i -= 2) turned.insert(turned.end(), {bend[i - 2], bend[i - 1]});
  const std::vector<double> slow_start{0, 0, 4, 10, 10, 0, 0};
  const std::vector<double> slow_end{0, 0, 10, 10, 4, 0, 0};
  const auto there = solved({.axis_count = 2, .keys = bend}, slow_start, 240);
  const auto back = solved({.axis_count = 2, .keys = turned}, slow_end, 240);
  const std::vector<AxisLimits> limits(2, stop_limits(3000.0, std::optional(30'000.0)));
  const Stops forward(move_of(there), limits);
  const Stops reverse(move_of(back), limits);
  ASSERT_TRUE(forward.bounds.has_value());
  ASSERT_TRUE(reverse.bounds.has_value());
  for (std::int32_t frame = 0; frame <= 240; frame += 12) {
    const StopBound a = forward.bounds->at({frame, 0});
    const StopBound b = reverse.bounds->at({240 - frame, 0});
    EXPECT_NEAR(a.rate_change, b.rate_change, 0.02 * a.rate_change) << frame;
    EXPECT_NEAR(a.release_jerk, b.release_jerk, 0.04 * a.release_jerk) << frame;
  }
  const LongestStop& a = forward.bounds->longest_in_time();
  const LongestStop& b = reverse.bounds->longest_in_time();
  EXPECT_NEAR(a.length.seconds, b.length.seconds, 0.03 * a.length.seconds);
}

TEST(StopBounds, TheyFallAndRiseNoFasterThanAStopCanFollow) {
  const auto solution = solved({.axis_count = 2, .keys = bend}, calm, 240);
  const Stops stops(move_of(solution), {2, stop_limits(800.0, std::optional(6000.0))});
  ASSERT_TRUE(stops.bounds.has_value());
  const auto& all = stops.stop_cells;
  const double seconds = 10.0 / cells;
  for (std::size_t i = 0; i < cells; ++i) {
    const double jerk = all[i].rate_jerk;
    const double max_change = std::max(all[i].rate_change, all[i + 1].rate_change);
    const double low = std::min(all[i].release_jerk, all[i + 1].release_jerk);
    const double high = std::max(all[i].release_jerk, all[i + 1].release_jerk);
    EXPECT_LE(std::fabs(all[i + 1].rate_change - all[i].rate_change) / seconds, jerk * (1 + 1e-12));
    EXPECT_LE(high, jerk);
    EXPECT_LE((high - low) / seconds,
              2 * low * (jerk - high) / std::min(max_change, std::sqrt(2 * jerk)) * (1 + 1e-9) + 1e-12);
  }
}

// --- where the bounds change from cell to cell

/// A corner at each key, on which a line of another direction begins: found by a random search. A stop with
/// little of its jerk left crosses them for minutes.
const std::vector<double> corners{
    -698, -445'000, -840'000, -90'900, 230'000,  0,     //
    -806, -971'000, -407'000, -13'300, -154'000, -456,  //
    -187, -26'000,  -365'000, -3'500,  -333'000, 0,     //
    256,  609'000,  -771'000, -82'500, 287'000,  0,     //
    127,  -544'000, 668'000,  -35'300, -105'000, 0,     //
    -555, 711'000,  974'000,  68'900,  371'000,  510,   //
    0,    -875'000, -217'000, -8'500,  -465'000, 0,     //
    0,    -354'000, 121'000,  23'400,  371'000,  0,
};
const std::vector<double> corner_weights{0.01, 1.83, 2.88, 3.59, 1.85, 0.01};
constexpr std::size_t corner_axes = 6;
constexpr std::int32_t corner_frames = 155;

/// Its motion by the definition: a uniform cubic B-spline with natural ends along straight lines.
class CornerOracle {
 public:
  CornerOracle() {
    for (std::size_t key = 0; key + 1 < key_count; ++key) {
      long double squares = 0;
      for (std::size_t d = 0; d < corner_axes; ++d) {
        const long double part = corner_weights[d] * step(key, d);
        squares += part * part;
      }
      lengths_[key] = std::sqrt(squares);
      length_ += lengths_[key];
    }
    for (std::size_t i = 0; i < span_count; ++i) {
      const auto* v = &values_[i];
      spans_[i] = {(v[0] + 4 * v[1] + v[2]) / 6, (v[2] - v[0]) / 2, (v[0] - 2 * v[1] + v[2]) / 2,
                   (v[3] - 3 * v[2] + 3 * v[1] - v[0]) / 6};
      integral_ += integral(i, 1);
    }
  }
  /// |p1|, |p2|, |p3| of an axis at a frame.
  [[nodiscard]] std::array<long double, 3> motion(long double frame, std::size_t d) const {
    const long double a = frame * span_count / corner_frames;
    const std::size_t span = std::min(static_cast<std::size_t>(a), span_count - 1);
    const long double t = a - static_cast<long double>(span);
    long double passed = integral(span, t);
    for (std::size_t i = 0; i < span; ++i) passed += integral(i, 1);
    long double left = passed * length_ / integral_;
    std::size_t key = 0;
    while (key + 2 < key_count && left > lengths_[key]) left -= lengths_[key++];
    const long double slope = std::fabs(step(key, d)) / lengths_[key] * length_ / integral_;
    const long double rate = span_count * 24.0L / corner_frames;
    const auto [c0, c1, c2, c3] = spans_[span];
    return {slope * rate * std::fabs(c0 + t * (c1 + t * (c2 + t * c3))),
            slope * rate * rate * std::fabs(c1 + t * (2 * c2 + 3 * t * c3)),
            slope * rate * rate * rate * std::fabs(2 * c2 + 6 * t * c3)};
  }

 private:
  static constexpr std::size_t key_count = 8;
  static constexpr std::size_t span_count = 4;
  [[nodiscard]] static long double step(std::size_t key, std::size_t d) {
    return static_cast<long double>(corners[(key + 1) * corner_axes + d]) - corners[key * corner_axes + d];
  }
  [[nodiscard]] long double integral(std::size_t span, long double t) const {
    const auto [c0, c1, c2, c3] = spans_[span];
    return t * (c0 + t * (c1 / 2 + t * (c2 / 3 + t * c3 / 4)));
  }

  std::array<long double, span_count + 3> values_{4.5L, 2.25L, 0, 19.75L, 0, 0, 0};
  std::array<std::array<long double, 4>, span_count> spans_{};
  std::array<long double, key_count - 1> lengths_{};
  long double length_ = 0;
  long double integral_ = 0;
};

TEST(StopBounds, TheJerkBoundHoldsWithinACellOfItsPlaceAndNoFurther) {
  const auto solution = solved(
      {.spline = Spline::linear, .axis_count = corner_axes, .keys = corners, .weights = corner_weights},
      {2.25, 0, 19.75, 0, 0}, corner_frames);
  const std::array<double, corner_axes> acceleration{117.46, 175'373, 98'575, 13'259.5, 133'977, 86.53};
  const std::array<double, corner_axes> jerk{47.254, 86'955, 55'491, 8'461.6, 29'184.6, 32.74};
  std::vector<AxisLimits> limits;
  for (std::size_t d = 0; d < corner_axes; ++d) {
    limits.push_back(*AxisLimits::make({.min = -1e7,
                                        .max = 1e7,
                                        .max_velocity = 1e8,
                                        .max_acceleration = acceleration[d],
                                        .max_jerk = jerk[d],
                                        .stop_acceleration = acceleration[d],
                                        .stop_jerk = jerk[d]}));
  }
  constexpr double rate = 0.25;
  const Stops stops(move_of(solution), limits, rate);
  const auto& bounds = stops.bounds;
  ASSERT_TRUE(bounds.has_value());

  const CornerOracle oracle;
  const auto worst_jerk = [&](double cell, std::size_t jerk_of_cell) {
    long double worst = 0;
    const double frame = cell * corner_frames / cells;
    const double change = bounds->at({static_cast<std::int32_t>(frame), std::fmod(frame, 1)}).rate_change;
    for (std::size_t d = 0; d < corner_axes; ++d) {
      const auto [p1, p2, p3] = oracle.motion(frame, d);
      worst = std::max(worst, (p3 * rate * rate * rate + 3 * p2 * rate * change +
                               p1 * stops.stop_cells[jerk_of_cell].rate_jerk) /
                                  jerk[d]);
    }
    return worst;
  };
  long double further = 0;
  for (std::size_t cell = 2; cell + 2 < cells; ++cell) {
    for (const double share : {0.001, 0.25, 0.5, 0.75, 0.999}) {
      const double here = static_cast<double>(cell) + share;
      for (const std::size_t near : {cell - 1, cell, cell + 1}) {
        EXPECT_LE(worst_jerk(here, near), 1 + 1e-6) << "in cell " << here << " by the bound of " << near;
      }
      further = std::max({further, worst_jerk(here, cell - 2), worst_jerk(here, cell + 2)});
    }
  }
  EXPECT_GT(further, 1.2) << "a step over two cells would break the jerk limit";
}

TEST(StopBounds, WhatIsAskedWronglyIsRefused) {
  const auto solution = solved({.axis_count = 2, .keys = bend}, calm, 240);
  const std::vector<AxisLimits> limits(2, stop_limits(3000.0));
  const BoundedMove bounded =
      bounded_cells(move_of(solution).move, move_of(solution).tracks, limits, 10, 1, tick);
  const MotionCells& motion = bounded.cells();
  std::vector<StopCell> stop_cells(11);
  std::vector<AxisPeaks> peaks(2);
  const auto code = [&](const StopRequest& request, std::span<StopCell> its, std::span<AxisPeaks> out) {
    const auto made = StopBounds::make(request, its, out);
    return made ? std::pair(ErrorCode{}, std::int64_t{0}) : std::pair(made.error().code, made.error().needed);
  };
  EXPECT_TRUE(StopBounds::make({motion, limits, 1, tick}, stop_cells, peaks).has_value());
  EXPECT_TRUE(StopBounds::make({motion, limits, 1, tick}, stop_cells, {}).has_value());
  const std::span<const AxisLimits> one(limits.data(), 1);
  EXPECT_EQ(code({motion, one, 1, tick}, stop_cells, {}), std::pair(ErrorCode::wrong_count, std::int64_t{2}));
  EXPECT_EQ(code({motion, limits, 1, tick}, stop_cells, std::span(peaks).first(1)),
            std::pair(ErrorCode::wrong_count, std::int64_t{2}));
  for (const double rate : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    EXPECT_EQ(code({motion, limits, rate, tick}, stop_cells, peaks).first, ErrorCode::out_of_range);
  }
  EXPECT_EQ(code({motion, limits, 1, tick}, std::span(stop_cells).first(10), {}),
            std::pair(ErrorCode::wrong_count, std::int64_t{11}));
  MotionCells small = motion;
  small.suprema = small.suprema.first(19);
  EXPECT_EQ(code({small, limits, 1, tick}, stop_cells, {}),
            std::pair(ErrorCode::wrong_count, std::int64_t{11}));
}

}  // namespace stop_bounds_test
}  // namespace inbetween
