// The hard cases of a move, each with the result that it must have: cusps and near-cusps, keys that are given
// twice, lines that turn back, dwells, loops, moves that stay, numbers far from 1, and what has no solution.
// The speed is judged by the oracle.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iostream>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include "tests/support/oracle_table.hpp"
#include "tests/support/solved_move.hpp"

namespace inbetween {
namespace hard_cases_test {

using oracle::Kind;

constexpr std::array every_kind = {Kind::smooth, Kind::catmull_rom, Kind::tcb, Kind::linear};

using Points = std::vector<std::vector<long double>>;
using Shapes = std::vector<std::array<long double, 3>>;

/// A move at constant speed, in 48 frames.
RandomMove move_of(Kind kind, Points points, Shapes shapes = {}) {
  RandomMove move;
  move.keys.kind = kind;
  move.keys.at = std::move(points);
  move.keys.tension_continuity_bias = std::move(shapes);
  move.speed = {10};
  move.frames = 48;
  return move;
}

/// Every key with the same tension.
RandomMove tense(long double tension, Points points) {
  Shapes shapes(points.size(), {tension, 0, 0});
  return move_of(Kind::tcb, std::move(points), std::move(shapes));
}

/// The coordinates as they are in the precision under test, so that the oracle is asked about the same path.
RandomMove rounded(RandomMove move) {
  for (auto& key : move.keys.at) {
    for (long double& coordinate : key)
      coordinate = static_cast<long double>(static_cast<double>(coordinate));
  }
  for (auto& shape : move.keys.tension_continuity_bias) {
    for (long double& number : shape) number = static_cast<long double>(static_cast<double>(number));
  }
  return move;
}

/// The error with which a solver refuses a move.
Error refusal(const RandomMove& move, Solver solver = Solver::closed_form) {
  const TrackInput input(move);
  try {
    const SolvedTrack solution(input.spec, solver);
    ADD_FAILURE() << "solved, with a speed error of " << solution.table().provenance().speed_error;
  } catch (const SolverError& error) {
    return error.error();
  }
  return {};
}

/// How far a step may be off: a share of the step, and a share of the length of the path.
struct Tolerance {
  long double of_step = 0;
  long double of_length = 0;
};

/// The worst step of a table over what it may be off by.
long double worst_step(const RandomMove& move, const SolvedTrack& solution, const Tolerance& tolerance) {
  const oracle::Path path(move.keys);
  const auto places = oracle_places(solution.track(), solution.table());
  const auto rows = oracle::frame_table(path, oracle::Profile(move.speed), move.frames);
  const auto place = [&](std::size_t frame) {
    return oracle::Place{places[frame].first, static_cast<long double>(places[frame].second)};
  };
  long double worst = 0;
  for (std::size_t frame = 1; frame < rows.size(); ++frame) {
    const long double wanted = rows[frame].distance - rows[frame - 1].distance;
    const long double error = std::fabs(path.travelled(place(frame - 1), place(frame)) - wanted);
    const long double allowed = tolerance.of_step * wanted + tolerance.of_length * path.total_length();
    worst = std::max(worst, error / allowed);
  }
  return worst;
}

long double rounding(int ulps) {
  return static_cast<long double>(ulps) * static_cast<long double>(std::numeric_limits<double>::epsilon());
}

/// The same for a table in closed form, by the strict rule.
long double worst_step(const RandomMove& move, const SolvedTrack& solution) {
  const auto delta = static_cast<long double>(solution.track().arc_length().delta());
  const auto places = oracle_places(solution.track(), solution.table());
  const oracle::Path path(move.keys);
  return oracle::worst_speed_error(path, oracle::Profile(move.speed), move.frames, places, delta).worst;
}

std::vector<AxisMotion> motion_at(const SolvedTrack& solution, const FrameTime& time,
                                  std::uint8_t* order = nullptr) {
  std::vector<AxisMotion> axes(static_cast<std::size_t>(solution.track().path().axis_count()));
  const std::uint8_t given = solution.track().motion(time, axes);
  if (order != nullptr) *order = given;
  return axes;
}

/// No position and no derivative is a NaN or an infinity, on frames and between them.
void expect_finite(const SolvedTrack& solution) {
  for (std::int32_t frame = 0; frame <= solution.track().frames(); ++frame) {
    for (const double fraction : {0.0, 0.3}) {
      for (const AxisMotion& axis : motion_at(solution, {frame, fraction})) {
        ASSERT_TRUE(std::isfinite(axis.position)) << "frame " << frame << " + " << fraction;
        ASSERT_TRUE(std::isfinite(axis.velocity)) << "frame " << frame << " + " << fraction;
        ASSERT_TRUE(std::isfinite(axis.acceleration)) << "frame " << frame << " + " << fraction;
        ASSERT_TRUE(std::isfinite(axis.jerk)) << "frame " << frame << " + " << fraction;
      }
    }
  }
}

/// What the pieces of a path cost, at most. A segment without a cusp takes about 17 pieces at the default
/// delta; measured here are at most 62.
constexpr int max_pieces_per_segment = 600;

/// Solves a move in closed form and judges the speed of every frame, the invariants and the number of pieces.
void expect_as_drawn(const RandomMove& drawn, double delta = Precision::default_delta) {
  const RandomMove move = rounded(drawn);
  const SolvedTrack solution = solve(move, {.delta = delta});
  EXPECT_LE(worst_step(move, solution), 1.0L);
  const Status invariants = check_invariants(solution.track(), solution.table());
  EXPECT_TRUE(invariants) << (invariants ? "" : invariants.error().what);
  expect_finite(solution);
  EXPECT_LE(solution.track().arc_length().piece_count(),
            max_pieces_per_segment * solution.track().path().segment_count());
}

/// The paper's solver gives a table that is as good as it says, or an error; never a wrong table.
void expect_right_or_refused_by_runge_kutta(const RandomMove& drawn) {
  const RandomMove move = rounded(drawn);
  const TrackInput input(move);
  try {
    const SolvedTrack solution(input.spec, Solver::runge_kutta);
    const Status invariants = check_invariants(solution.track(), solution.table());
    EXPECT_TRUE(invariants) << (invariants ? "" : invariants.error().what);
    const Provenance& provenance = solution.table().provenance();
    EXPECT_LE(provenance.speed_error, 0.02);
    EXPECT_LE(provenance.short_step_error, 1e-6);
    // The solver's own measure of its error rounds, too.
    const Tolerance tolerance{static_cast<long double>(provenance.speed_error),
                              static_cast<long double>(provenance.short_step_error) + rounding(16)};
    EXPECT_LE(worst_step(move, solution, tolerance), 1.0L);
    expect_finite(solution);
  } catch (const SolverError& error) {
    EXPECT_STRNE(error.error().remedy, "") << error.error().what;
  }
}

// --- the path stands still: tension 1, cusps

/// Corners in three axes.
const Points corners = {{0, 0, 0}, {40, 10, 0}, {40, 50, 8}, {-20, 44, 8}, {-20, 0, -30}};

TEST(HardCases, TensionOneIsTravelledAtTheDrawnSpeed) {
  RandomMove move = tense(1, corners);
  expect_as_drawn(move);
  move.speed = {0, 0, 10, 30, 4, 4, 0, 0};
  expect_as_drawn(move);
}

TEST(HardCases, TensionOneRunsStraightThroughEveryCorner) {
  // Without tangents every segment is its chord: 100 units in x, then 100 in y, in 48 frames.
  const SolvedTrack solution = solve(tense(1, {{0, 0}, {100, 0}, {100, 100}}));
  for (int frame = 0; frame <= 48; ++frame) {
    const auto axes = motion_at(solution, {frame, 0});
    const double travelled = frame * 200.0 / 48;
    EXPECT_NEAR(axes[0].position, std::min(travelled, 100.0), 2e-3) << frame;
    EXPECT_NEAR(axes[1].position, std::max(travelled - 100, 0.0), 2e-3) << frame;
  }
}

TEST(HardCases, TensionOneReportsThatDerivativesAtAKeyAreOneSided) {
  const SolvedTrack solution = solve(tense(1, {{0, 0}, {100, 0}, {100, 100}}));
  const double speed = 200 / 2.0;  // 200 units in 48 frames of 1/24 s
  std::uint8_t order{};
  const auto start = motion_at(solution, {0, 0}, &order);
  EXPECT_EQ(order, 1);
  EXPECT_NEAR(start[0].velocity, speed, 1e-3);
  const auto end = motion_at(solution, {48, 0}, &order);
  EXPECT_EQ(order, 1);
  EXPECT_NEAR(end[1].velocity, speed, 1e-3);
}

TEST(HardCases, TensionOneIsSingularForRungeKutta) {
  const Error error = refusal(tense(1, corners), Solver::runge_kutta);
  EXPECT_EQ(error.code, ErrorCode::singular);
  EXPECT_EQ(error.key, 0);
  RandomMove move = tense(0, corners);
  move.keys.tension_continuity_bias[2][0] = 1;
  EXPECT_EQ(refusal(move, Solver::runge_kutta).key, 2);
}

/// Catmull-Rom keys whose middle segment is (u^2, u^3 + e u), -1 <= u <= 1: at u = 0 the speed is e / 2 of
/// that at the ends, and for e = 0 there is a cusp.
RandomMove cusp(long double e) {
  return move_of(Kind::catmull_rom, {{9, -(11 + 3 * e)}, {1, -(1 + e)}, {1, 1 + e}, {9, 11 + 3 * e}});
}

TEST(HardCases, ACuspIsPassedAtTheDrawnSpeed) {
  RandomMove move = cusp(0);
  for (const int frames : {1, 2, 47, 48, 1000}) {
    move.frames = frames;
    expect_as_drawn(move);
    expect_right_or_refused_by_runge_kutta(move);
  }
}

TEST(HardCases, NearCuspsAreAsFiniteAndAsFastAsDrawn) {
  const int digits = 12;
  for (int i = 2; i <= digits; ++i) {
    SCOPED_TRACE("e = 1e-" + std::to_string(i));
    RandomMove move = cusp(std::pow(10.0L, -i));
    expect_as_drawn(move);
    expect_right_or_refused_by_runge_kutta(move);
    move.speed = {0, 0, 10, 30, 4, 4, 0, 0};
    move.frames = 500;
    expect_as_drawn(move);
  }
}

TEST(HardCases, NearCuspsAreAsDrawnAtEveryDelta) {
  for (int i = 1; i <= 12; ++i) {
    for (const double delta : {1e-4, 1e-9}) {
      SCOPED_TRACE("e = 1e-" + std::to_string(i) + ", delta " + std::to_string(delta));
      const RandomMove move = cusp(std::pow(10.0L, -i));
      const SolvedTrack solution = solve(rounded(move), {.delta = delta});
      EXPECT_LE(worst_step(rounded(move), solution), 1.0L);
      EXPECT_LE(solution.track().arc_length().piece_count(), 3 * 4 * max_pieces_per_segment);
    }
  }
}

TEST(HardCases, TensionNearlyOneIsAsFiniteAndAsFastAsDrawn) {
  const int digits = 15;
  for (int i = 1; i <= digits; ++i) {
    SCOPED_TRACE("tension 1 - 1e-" + std::to_string(i));
    RandomMove move = tense(1 - std::pow(10.0L, -i), corners);
    expect_as_drawn(move);
    expect_right_or_refused_by_runge_kutta(move);
    move.frames = 1000;
    expect_as_drawn(move);
  }
}

TEST(HardCases, WhereTheCuspIsTheAccelerationIsReportedAsUnbounded) {
  // Across the cusp the acceleration grows without a bound; along the path it is that of the curve, 0 here.
  const SolvedTrack solution = solve(cusp(0));
  const auto near = motion_at(solution, {23, 0.9});
  const auto nearer = motion_at(solution, {23, 0.99});
  EXPECT_GT(std::fabs(nearer[1].acceleration), 2 * std::fabs(near[1].acceleration));
  std::uint8_t order{};
  const auto at = motion_at(solution, {24, 0}, &order);
  EXPECT_NEAR(at[0].position, 0, 1e-3);
  EXPECT_TRUE(order == 1 || std::fabs(at[1].acceleration) > 1000) << at[1].acceleration;
}

// --- the same key twice, three and four times

Points with_key_repeated(int times) {
  Points points = {{0, 0}, {30, 10}};
  for (int i = 1; i < times; ++i) points.push_back({30, 10});
  points.insert(points.end(), {{50, -20}, {80, 0}});
  return points;
}

TEST(HardCases, TheSameKeyTwiceIsASmallLoopInTcb) {
  for (const Kind kind : {Kind::tcb, Kind::catmull_rom}) {
    const RandomMove move = move_of(kind, with_key_repeated(2));
    expect_as_drawn(move);
    expect_right_or_refused_by_runge_kutta(move);
    const SolvedTrack solution = solve(move);
    const ArcLength& length = solution.track().arc_length();
    const double loop = length.segment_begin(2).minus(length.segment_begin(1));
    const oracle::Path path(move.keys);
    EXPECT_GT(loop, 1);
    EXPECT_NEAR(loop, static_cast<double>(path.length(1, 0, 1)), 1e-4);
  }
}

TEST(HardCases, TheSameKeyThreeTimesHasZeroSpeedInTheMiddleInTcb) {
  for (const Kind kind : {Kind::tcb, Kind::catmull_rom}) {
    const RandomMove move = move_of(kind, with_key_repeated(3));
    expect_as_drawn(move);
    const SolvedTrack solution = solve(move);
    EXPECT_EQ(solution.track().path().parametric_speed({2, 0}), 0);
    const Error error = refusal(move, Solver::runge_kutta);
    EXPECT_EQ(error.code, ErrorCode::singular);
    EXPECT_EQ(error.key, 2);
  }
}

TEST(HardCases, TheSameKeyFourTimesHasASegmentWithoutLengthThatIsSkipped) {
  for (const Kind kind : {Kind::tcb, Kind::catmull_rom}) {
    RandomMove move = move_of(kind, with_key_repeated(4));
    move.frames = 1000;
    expect_as_drawn(move);
    const SolvedTrack solution = solve(move);
    const ArcLength& length = solution.track().arc_length();
    EXPECT_EQ(length.segment_begin(2).minus(length.segment_begin(3)), 0);
    for (const PathPoint& point : solution.table().points()) EXPECT_NE(point.segment, 2);
    const Error error = refusal(move, Solver::runge_kutta);
    EXPECT_EQ(error.code, ErrorCode::singular);
    EXPECT_EQ(error.key, 2);
  }
}

TEST(HardCases, RepeatedKeysAreOneInASmoothPath) {
  RandomMove move = move_of(Kind::smooth, with_key_repeated(1));
  move.speed = {0, 5, 20, 3, 0, 0};
  const SolvedTrack once = solve(move);
  for (const int times : {2, 3, 4}) {
    move.keys.at = with_key_repeated(times);
    expect_as_drawn(move);
    const SolvedTrack repeated = solve(move);
    EXPECT_EQ(repeated.track().arc_length().total(), once.track().arc_length().total());
    for (int frame = 0; frame <= move.frames; ++frame) {
      const PathPoint& point = repeated.table().point(frame);
      const PathPoint& expected = once.table().point(frame);
      EXPECT_EQ(point.t, expected.t) << frame;
      EXPECT_EQ(point.segment, expected.segment + (expected.segment > 0 ? times - 1 : 0)) << frame;
    }
    EXPECT_EQ(refusal(move, Solver::runge_kutta).code, ErrorCode::singular);
  }
}

TEST(HardCases, RepeatedKeysInALinePassInNoTime) {
  for (const int times : {2, 3, 4}) {
    const RandomMove move = move_of(Kind::linear, with_key_repeated(times));
    expect_as_drawn(move);
    EXPECT_EQ(refusal(move, Solver::runge_kutta).key, 1);
  }
}

// --- lines that turn back

TEST(HardCases, ALineThatTurnsBackIsTravelledBothWays) {
  for (const Kind kind : every_kind) {
    RandomMove move = move_of(kind, {{0, 0}, {10, 20}, {4, 8}, {12, 24}});
    move.frames = 100;
    expect_as_drawn(move);
    expect_right_or_refused_by_runge_kutta(move);
    const SolvedTrack solution = solve(move);
    int turns = 0;
    double direction = 1;
    for (int frame = 1; frame <= move.frames; ++frame) {
      const auto before = frame_row(solution.track(), solution.table(), frame - 1);
      const auto row = frame_row(solution.track(), solution.table(), frame);
      EXPECT_GT(row.distance, before.distance);
      const double velocity = motion_at(solution, {frame, 0})[0].velocity;
      if (velocity * direction < 0) {
        ++turns;
        direction = -direction;
      }
      // In one direction or the other, the whole of the drawn speed.
      EXPECT_NEAR(std::fabs(velocity) * std::sqrt(5.0), row.speed, row.speed * 1e-4) << frame;
    }
    EXPECT_EQ(turns, 2);
  }
}

/// There and back: closed, with the turns on both keys, where Catmull-Rom has no tangent.
RandomMove there_and_back() {
  RandomMove move = move_of(Kind::catmull_rom, {{0}, {8}});
  move.keys.closed = true;
  return move;
}

TEST(HardCases, WhereALineTurnsBackTheInfiniteAccelerationIsReported) {
  const SolvedTrack solution = solve(there_and_back());
  std::uint8_t order{};
  const auto start = motion_at(solution, {0, 0}, &order);
  EXPECT_EQ(order, 1);
  EXPECT_NEAR(start[0].velocity, 8, 1e-3);  // 16 units in 48 frames of 1/24 s
  const auto end = motion_at(solution, {48, 0}, &order);
  EXPECT_EQ(order, 1);
  EXPECT_NEAR(end[0].velocity, -8, 1e-3);  // with which it arrives
  // On both sides of the turn the rig has its whole speed.
  EXPECT_NEAR(motion_at(solution, {23, 0.99})[0].velocity, 8, 1e-3);
  EXPECT_NEAR(motion_at(solution, {24, 0.01})[0].velocity, -8, 1e-3);
}

TEST(HardCases, ALineThatTurnsBackAtRestHasNothingToReport) {
  RandomMove move = there_and_back();
  move.speed = {0, 0, 0, 5, 0, 0, 0, 0, 0, 5, 0, 0, 0};
  const SolvedTrack solution = solve(move);
  for (const int frame : {0, 24, 48}) {
    std::uint8_t order{};
    const auto turn = motion_at(solution, {frame, 0}, &order);
    EXPECT_EQ(order, 3) << frame;
    EXPECT_EQ(turn[0].velocity, 0) << frame;
    EXPECT_EQ(turn[0].acceleration, 0) << frame;
  }
}

// --- dwells

TEST(HardCases, InADwellTheRigStandsStillToTheBit) {
  for (const Kind kind : every_kind) {
    RandomMove move = move_of(kind, corners);
    move.speed = {10, 3, 0, 0, 0, 0, 0, 7, 10};  // phi = 0 from a = 3 to a = 5
    move.frames = 80;
    expect_as_drawn(move);
    expect_right_or_refused_by_runge_kutta(move);
    const SolvedTrack solution = solve(move);
    for (int frame = 31; frame <= 50; ++frame) {
      ASSERT_EQ(solution.table().point(frame), solution.table().point(30)) << frame;
      ASSERT_EQ(solution.track().locate({frame - 1, 0.7}), solution.table().point(30)) << frame;
    }
    EXPECT_FALSE(solution.table().point(29) == solution.table().point(30));
    EXPECT_FALSE(solution.table().point(51) == solution.table().point(50));
  }
}

TEST(HardCases, ADwellAtAnEndIsOnTheKeyToTheBit) {
  for (const Kind kind : every_kind) {
    RandomMove move = move_of(kind, corners);
    move.speed = {0, 0, 0, 10, 4, 0, 0, 0, 0};  // phi = 0 to a = 1 and from a = 6
    move.frames = 80;
    expect_as_drawn(move);
    expect_right_or_refused_by_runge_kutta(move);
    const SolvedTrack solution = solve(move);
    for (int frame = 0; frame <= 10; ++frame) {
      ASSERT_EQ(solution.table().point(frame), (PathPoint{0, 0})) << frame;
    }
    for (int frame = 60; frame <= 80; ++frame) {
      ASSERT_EQ(solution.table().point(frame), (PathPoint{4, 0})) << frame;
    }
    EXPECT_FALSE(solution.table().point(11) == solution.table().point(10));
  }
}

// --- loops, and moves that stay

TEST(HardCases, AClosedPathComesBackToItsBeginning) {
  for (const Kind kind : every_kind) {
    RandomMove move = move_of(kind, corners);
    move.keys.closed = true;
    expect_as_drawn(move);
    expect_right_or_refused_by_runge_kutta(move);
    const SolvedTrack solution = solve(move);
    const auto start = motion_at(solution, {0, 0});
    const auto end = motion_at(solution, {48, 0});
    EXPECT_EQ(solution.table().point(48), (PathPoint{5, 0}));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(end[axis].position, start[axis].position);
      if (kind == Kind::linear) continue;  // its direction steps at keys, the first one too
      EXPECT_NEAR(end[axis].velocity, start[axis].velocity, 1e-3);  // tangents wrap
    }
  }
}

TEST(HardCases, TwoKeysClosedAreTravelledThereAndBack) {
  for (const Kind kind : every_kind) {
    RandomMove move = move_of(kind, {{0, 0}, {30, 40}});
    move.keys.closed = true;
    expect_as_drawn(move);
    expect_right_or_refused_by_runge_kutta(move);
    const auto half = motion_at(solve(move), {24, 0});
    EXPECT_NEAR(half[0].position, 30, 1e-3);
    EXPECT_NEAR(half[1].position, 40, 1e-3);
  }
}

void expect_to_stay(RandomMove move) {
  for (const std::vector<double>& speed : {std::vector<double>{5, 0, 9}, {0, 0}}) {
    move.speed = speed;
    const TrackInput input(move);
    for (const Solver solver : {Solver::closed_form, Solver::runge_kutta}) {
      const SolvedTrack solution(input.spec, solver);
      EXPECT_EQ(solution.track().constant(), 0);
      EXPECT_EQ(solution.table().provenance().constant, 0);
      EXPECT_EQ(solution.table().frames(), move.frames);
      EXPECT_TRUE(check_invariants(solution.track(), solution.table()));
      for (std::int32_t frame = 0; frame <= move.frames; ++frame) {
        std::uint8_t order{};
        const auto axes = motion_at(solution, {frame, 0}, &order);
        EXPECT_EQ(order, 3);
        for (std::size_t axis = 0; axis < axes.size(); ++axis) {
          EXPECT_EQ(axes[axis].position, static_cast<double>(move.keys.at[0][axis]));
          EXPECT_EQ(axes[axis].velocity, 0);
          EXPECT_EQ(axes[axis].acceleration, 0);
          EXPECT_EQ(axes[axis].jerk, 0);
        }
      }
    }
  }
}

TEST(HardCases, OneKeyOrAllKeysEqualStayAndHaveAllTheirFrames) {
  for (const Kind kind : every_kind) {
    for (const bool closed : {false, true}) {
      for (const std::size_t keys : {1U, 2U, 5U}) {
        RandomMove move = move_of(kind, Points(keys, {3.3L, -4e6L}));
        move.keys.closed = closed;
        expect_to_stay(move);
      }
    }
  }
}

// --- what has no solution, and what is no number

TEST(HardCases, ACurveOfZerosOnAPathThatHasALengthIsAnError) {
  RandomMove move = move_of(Kind::smooth, corners);
  for (const std::vector<double>& speed : {std::vector<double>{0}, {0, 0}, {0, 0, 0, 0, 0, 0}}) {
    move.speed = speed;
    EXPECT_EQ(refusal(move).code, ErrorCode::no_distance);
    EXPECT_EQ(refusal(move, Solver::runge_kutta).code, ErrorCode::no_distance);
  }
}

TEST(HardCases, ANegativeSpeedIsAnErrorThatNamesTheControlValue) {
  RandomMove move = move_of(Kind::smooth, corners);
  for (const double negative : {-1.0, -1e-30, -100.0}) {
    move.speed = {5, 5, negative, 5};
    const Error error = refusal(move);
    EXPECT_EQ(error.code, ErrorCode::out_of_range);
    EXPECT_EQ(error.control_value, 2);
  }
}

TEST(HardCases, WhatIsNoNumberIsAnErrorThatNamesItsPlace) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                           -std::numeric_limits<double>::infinity()}) {
    const auto number = static_cast<long double>(bad);
    RandomMove move = tense(0, corners);
    move.speed = {5, bad, 5};
    EXPECT_EQ(refusal(move).code, ErrorCode::not_finite);
    EXPECT_EQ(refusal(move).control_value, 1);

    move = tense(0, corners);
    move.keys.at[3][1] = number;
    EXPECT_EQ(refusal(move).code, ErrorCode::not_finite);
    EXPECT_EQ(refusal(move).key, 3);
    EXPECT_EQ(refusal(move).axis, 1);

    move = tense(0, corners);
    move.keys.weights = {1, 1, number};
    EXPECT_EQ(refusal(move).axis, 2);

    move = tense(0, corners);
    move.keys.tension_continuity_bias[4][2] = number;
    EXPECT_EQ(refusal(move).code, ErrorCode::not_finite);
    EXPECT_EQ(refusal(move).key, 4);
  }
}

// --- numbers far from 1

/// The same move with every coordinate mapped.
RandomMove mapped(RandomMove move, const std::function<long double(long double)>& map) {
  for (auto& key : move.keys.at) std::ranges::transform(key, key.begin(), map);
  return move;
}

void expect_same_table(const RandomMove& move, const RandomMove& plain, double tolerance) {
  const SolvedTrack solution = solve(move);
  const SolvedTrack expected = solve(plain);
  for (std::int32_t frame = 0; frame <= move.frames; ++frame) {
    const PathPoint& point = solution.table().point(frame);
    const PathPoint& other = expected.table().point(frame);
    const double apart = static_cast<double>(point.segment - other.segment) + (point.t - other.t);
    ASSERT_LE(std::fabs(apart), tolerance) << "frame " << frame;
  }
}

/// Four kinds of ordinary moves, and one of the hardest.
std::vector<RandomMove> plain_moves() {
  std::vector<RandomMove> moves;
  for (const Kind kind : every_kind) moves.push_back(move_of(kind, corners));
  moves.push_back(tense(1, corners));
  moves.push_back(cusp(0));
  for (RandomMove& move : moves) move.speed = {0, 0, 10, 30, 4, 4, 0, 0};
  return moves;
}

TEST(HardCases, AScaleByAPowerOfFourChangesNoBitOfTheTable) {
  // Of four, because the knots of a smooth path and the pieces beside a cusp take square roots of lengths.
  const int most = 332;  // 2^332 is about 1e100
  for (const RandomMove& plain : plain_moves()) {
    for (const int exponent : {most, -most, 2, -2}) {
      SCOPED_TRACE(exponent);
      const RandomMove move = mapped(plain, [&](long double x) { return std::ldexp(x, exponent); });
      expect_same_table(move, plain, 0);
      expect_as_drawn(move);
      expect_right_or_refused_by_runge_kutta(move);
    }
  }
}

TEST(HardCases, AnyOtherScaleChangesTheTableByRoundingOnly) {
  const std::vector<long double> scales{1e100L, 1e-100L, 3e7L, 2};
  for (const RandomMove& plain : plain_moves()) {
    for (const long double scale : scales) {
      SCOPED_TRACE(static_cast<double>(scale));
      const RandomMove move = mapped(plain, [&](long double x) { return x * scale; });
      // Near a key with tension 1 or a cusp, t is as the square root of the distance.
      expect_same_table(move, plain, std::sqrt(16 * std::numeric_limits<double>::epsilon()));
      expect_as_drawn(move);
    }
  }
}

TEST(HardCases, AnOffsetChangesNoBitOfTheTable) {
  const long double offset = 1e12L;
  for (const RandomMove& plain : plain_moves()) {
    const RandomMove move = mapped(plain, [&](long double x) { return x + offset; });
    expect_same_table(move, plain, 0);
    expect_as_drawn(move);
    expect_right_or_refused_by_runge_kutta(move);
  }
}

TEST(HardCases, AWeightFarFromOneChangesNoBitOfTheTable) {
  const int most = 200;
  for (const RandomMove& plain : plain_moves()) {
    for (const int exponent : {most, -most}) {
      RandomMove move = plain;
      move.keys.weights.assign(plain.keys.at[0].size(), std::ldexp(1.0L, exponent));
      expect_same_table(move, plain, 0);
      expect_as_drawn(move);
    }
  }
}

}  // namespace hard_cases_test
}  // namespace inbetween
