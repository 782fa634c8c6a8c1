#include "inbetween/limits/move_bounds.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "host_tools/plan/solved_track.hpp"
#include "tests/support/bounded_cells.hpp"
#include "tests/support/random_move.hpp"
#include "tests/support/solved_move.hpp"

/// The proven bounds on moves whose peaks are known; random moves are in tests/property.

namespace inbetween {
namespace move_bounds_test {

SolvedTrack solved(const PathSpec& path, const std::vector<double>& speed, std::int32_t frames,
                   const std::vector<KeyLock>& locks = {}) {
  TrackSpec spec{.path = path, .control_values = speed, .frames = frames, .fps = {24, 1}, .arc_length = {}};
  spec.locks = locks;
  return SolvedTrack(spec, Solver::closed_form);
}

std::vector<AxisPeaks> peaks_of(const Track& track, const std::optional<WholeFrames>& part = std::nullopt) {
  return bounds_of_track(track, part).peaks();
}

/// What plays is within a ten-thousandth of what is asked; its bound is at or above it, and hardly more.
void expect_bound(double bound, double truth) {
  EXPECT_GE(bound, truth * (1 - 1e-4));
  EXPECT_LE(bound, 1.001 * truth);
}

TEST(MoveBounds, AStraightLineWithAStraightSpeedCurveIsKnownByHand) {
  // 100 mm in 48 frames, from v to 3 v: v = 25 mm/s, acceleration 2 v in 2 s.
  const std::vector<double> keys{0, 100};
  const auto move = solved({.axis_count = 1, .keys = keys}, {10, 30}, 48);
  const AxisPeaks peaks = peaks_of(move.track())[0];
  EXPECT_EQ(peaks.lowest.value, 0);
  EXPECT_EQ(peaks.highest.value, 100);
  EXPECT_EQ(peaks.highest.frame, 48);
  expect_bound(peaks.velocity.value, 75);
  EXPECT_EQ(peaks.velocity.frame, 48);
  expect_bound(peaks.acceleration.value, 25);
  EXPECT_LE(peaks.jerk.value, 1e-9);
}

TEST(MoveBounds, APartIsBoundedByItselfAlone) {
  // The speed rises from 25 to 75 mm/s in 48 frames: from 12 to 36 it goes from 37.5 to 62.5.
  const std::vector<double> keys{0, 100};
  const auto move = solved({.axis_count = 1, .keys = keys}, {10, 30}, 48);
  const AxisPeaks peaks = peaks_of(move.track(), WholeFrames{12, 36})[0];
  expect_bound(peaks.velocity.value, 62.5);
  EXPECT_EQ(peaks.velocity.frame, 36);
  expect_bound(peaks.acceleration.value, 25);
  EXPECT_NEAR(peaks.lowest.value, 25.0 * 0.5 + 25.0 * 0.5 * 0.5 / 2, 1e-9);
  EXPECT_NEAR(peaks.lowest.frame, 12, 1e-12);
  EXPECT_NEAR(peaks.highest.value, 25.0 * 1.5 + 25.0 * 1.5 * 1.5 / 2, 1e-9);
  EXPECT_EQ(peaks.highest.frame, 36);
}

TEST(MoveBounds, APartHasNoStepsOfTheRest) {
  // Two corners, on frames 24 and 48.
  const std::vector<double> keys{0, 0, 100, 0, 100, 60, 40, 60};
  const std::vector<std::int32_t> frames{0, 24, 48, 72};
  TrackSpec spec;
  spec.path = {.spline = Spline::linear, .axis_count = 2, .keys = keys};
  spec.fps = {24, 1};
  spec.frames = 72;
  spec.key_frames = frames;
  spec.kinetic = Kinetic::linear;
  const SolvedTrack timed(spec, Solver::closed_form);
  const BoundedMove bounded = bounds_of_track(timed.track(), WholeFrames{30, 60});
  ASSERT_EQ(bounded.steps().size(), 2U);
  for (const MoveStep& step : bounded.steps()) EXPECT_EQ(step.key, 2);
}

TEST(MoveBounds, TheCellsOfAPartKnowNothingOfTheRest) {
  const std::vector<double> keys{0, 100};
  const auto move = solved({.axis_count = 1, .keys = keys}, {10, 30}, 48);
  const std::array tracks{move.track()};
  const auto part = Move::make(tracks, {}, WholeFrames{12, 36});
  ASSERT_TRUE(part);
  constexpr std::size_t cells = 8;
  const BoundedMove bounded(*part, tracks, {.limits = {}, .motors = {}, .cells = cells, .room = {}});
  const std::span<const MotionTriple> suprema = bounded.cells().suprema;
  for (std::size_t cell = 0; cell < cells; ++cell) {
    const double fastest = 37.5 + 25.0 * static_cast<double>(cell + 1) / cells;
    EXPECT_GE(suprema[cell][0], fastest * (1 - 1e-12)) << cell;
    EXPECT_LE(suprema[cell][0], 1.02 * fastest) << cell;
  }
}

TEST(MoveBounds, TheMiddleOfACellIsAFrameOfTheMove) {
  MotionCells cells;
  cells.line = {-12, 252, 11};
  EXPECT_EQ(cells.middle_frame(0), 0);
  EXPECT_EQ(cells.middle_frame(5), 120);
  EXPECT_EQ(cells.middle_frame(10), 240);
}

TEST(MoveBounds, TheCellsOfAMoveAreAsCloseToTheTruthAsTheyPromise) {
  const std::vector<double> keys{0, 0, 30, 50, 45, 20, 90, 35, 70, 80, 20, 60};
  const auto move = solved({.axis_count = 2, .keys = keys}, {0, 0, 10, 4, 12, 8, 0, 0}, 96);
  const std::array tracks{move.track()};
  constexpr std::size_t cells = 24;
  constexpr int samples = 4000;
  std::array<MotionTriple, 2 * cells> found{};
  std::array<MotionTriple, 2> peak{};
  for (int i = 0; i <= samples * static_cast<int>(cells); ++i) {
    const double frame = 96.0 * i / (samples * cells);
    const auto whole = static_cast<std::int32_t>(frame);
    std::array<AxisMotion, 2> motion;
    static_cast<void>(move.track().motion({whole, frame - whole}, motion));
    // Samples on a border belong to neither of its cells.
    if (i % samples == 0) continue;
    for (std::size_t d = 0; d < 2; ++d) {
      const MotionTriple here{motion[d].velocity, motion[d].acceleration, motion[d].jerk};
      for (std::size_t q = 0; q < motion_quantities; ++q) {
        double& of_cell = found[2 * static_cast<std::size_t>(i / samples) + d][q];
        of_cell = std::max(of_cell, std::fabs(here[q]));
        peak[d][q] = std::max(peak[d][q], of_cell);
      }
    }
  }
  const BoundedMove bounded(Move::make(tracks, {}).value(), tracks,
                            {.limits = {}, .motors = {}, .cells = cells, .room = {}});
  const std::span<const MotionTriple> suprema = bounded.cells().suprema;
  // The samples miss next to nothing of a peak, and a border is off by as little.
  constexpr double missed = 1e-3;
  for (std::size_t i = 0; i < suprema.size(); ++i) {
    for (std::size_t q = 0; q < motion_quantities; ++q) {
      const double own = found[i][q];
      double around = own;  // a piece of the trajectory counts in two cells
      if (i >= 2) around = std::max(around, found[i - 2][q]);
      if (i + 2 < suprema.size()) around = std::max(around, found[i + 2][q]);
      EXPECT_GE(suprema[i][q], own * (1 - 1e-4))
          << "cell " << i / 2 << ", axis " << i % 2 << ", quantity " << q;
      EXPECT_LE(suprema[i][q],
                around + std::max(0.02 * around, 0.005 * peak[i % 2][q]) + missed * peak[i % 2][q])
          << "cell " << i / 2 << ", axis " << i % 2 << ", quantity " << q;
    }
  }
}

TEST(MoveBounds, AKeyOnTheFirstOrLastFrameOfAPartHasOneSide) {
  // An axis each before and behind the corner, which is met on frame 24 as exactly as a lock is.
  const std::vector<double> keys{0, 0, 100, 0, 100, 60};
  for (const bool breaks : {false, true}) {
    const auto move = solved({.spline = Spline::linear, .axis_count = 2, .keys = keys}, {10, 14, 10}, 48,
                             {{.key = 1, .frame = 24, .breaks = breaks}});
    for (const WholeFrames& part : {WholeFrames{0, 24}, {5, 24}}) {
      EXPECT_GT(peaks_of(move.track(), part)[0].velocity.value, 60);
      EXPECT_EQ(peaks_of(move.track(), part)[1].velocity.value, 0) << part.first;
    }
    for (const WholeFrames& part : {WholeFrames{24, 48}, {24, 30}}) {
      EXPECT_EQ(peaks_of(move.track(), part)[0].velocity.value, 0) << part.last;
      EXPECT_GT(peaks_of(move.track(), part)[1].velocity.value, 30);
    }
    EXPECT_GT(peaks_of(move.track(), WholeFrames{0, 25})[1].velocity.value, 30);
  }
}

TEST(MoveBounds, AnAxisThatTurnsInsideASegmentIsBoundedBeyondItsKeys) {
  const std::vector<double> keys{0, 0, 10, 50, 20, 50, 30, 0};
  const auto move = solved({.axis_count = 2, .keys = keys}, {10, 10}, 48);
  const AxisPeaks peaks = peaks_of(move.track())[1];
  double sampled = 0;
  for (int i = 0; i <= 1000; ++i)
    sampled = std::max(sampled, move.track().path().segment(1)[1].value(i / 1000.0));
  EXPECT_GT(sampled, 52);
  EXPECT_GE(peaks.highest.value, sampled);
  EXPECT_LE(peaks.highest.value, sampled + 1e-4);
  EXPECT_NEAR(peaks.highest.frame, 24, 1e-6);
}

TEST(MoveBounds, ASpikeBetweenTwoFramesIsFoundWhereASamplerOf24ASecondMissesIt) {
  // Two keys 1 mm apart in a tight bend of a smooth path.
  const std::vector<double> keys{0, 0, 400, 0, 400, 1, 0, 2};
  const double limit = 1000;
  const auto move = solved({.axis_count = 2, .keys = keys}, {0, 0, 10, 10, 0, 0}, 101);
  const std::vector<AxisPeaks> peaks = peaks_of(move.track());
  std::vector<AxisMotion> motion(2);
  double on_frames = 0;
  double dense = 0;
  for (std::int32_t frame = 0; frame < 100; ++frame) {
    for (int part = 0; part < 20'000; ++part) {
      move.track().motion({frame, part / 20'000.0}, motion);
      dense = std::max(dense, std::fabs(motion[0].acceleration));
      if (part == 0) on_frames = std::max(on_frames, std::fabs(motion[0].acceleration));
    }
  }
  EXPECT_GT(dense, 50 * limit);
  EXPECT_LT(on_frames, limit) << "who looks at the frames only lets this move pass";
  expect_bound(peaks[0].acceleration.value, dense);
}

TEST(MoveBounds, ALineThatTurnsBackInsideASegmentAtASpeedStepsThere) {
  const std::vector<double> keys{0, 10, 9, 0};
  const auto move = solved({.axis_count = 1, .keys = keys}, {10, 10}, 48);
  const BoundedMove bounded = bounds_of_track(move.track());
  const AxisPeaks& peaks = bounded.peaks()[0];
  const double speed = move.track().arc_length().total() / 2;
  ASSERT_GT(peaks.highest.value, 10);
  expect_bound(peaks.velocity.value, speed);
  ASSERT_EQ(bounded.steps().size(), 1U);
  EXPECT_EQ(bounded.steps()[0].key, -1);
  EXPECT_NEAR(bounded.steps()[0].velocity, 2 * speed, 1e-6 * speed);
  EXPECT_NEAR(bounded.steps()[0].frame, peaks.highest.frame, 1e-6);
}

TEST(MoveBounds, ALineThatTurnsBackAtRestIsBounded) {
  // The same way, and phi is 0 where the line turns.
  const std::vector<double> keys{0, 10, 0};
  const auto move = solved({.axis_count = 1, .keys = keys}, {0, 0, 10, 0, 0, 0, 10, 0, 0}, 96);
  const AxisPeaks peaks = peaks_of(move.track())[0];
  EXPECT_TRUE(std::isfinite(peaks.acceleration.value));
  EXPECT_GT(peaks.acceleration.value, 1);
}

TEST(MoveBounds, ABendOfAMillionthOfAMillimetreIsNotTakenForALine) {
  const std::vector<double> keys{0, 0, 8, 0, 8, 1e-6, 0, 0};
  const auto move = solved({.spline = Spline::catmull_rom, .axis_count = 2, .keys = keys}, {10, 10}, 48);
  EXPECT_GT(peaks_of(move.track())[0].acceleration.value, 1e6);
}

TEST(MoveBounds, AKeyOfTensionOneHasABoundedVelocity) {
  const std::vector<double> keys{0, 0, 50, 20, 60, 90, 0, 100};
  const std::vector<KeyShape> shapes{{}, {.tension = 1, .continuity = 0, .bias = 0}, {}, {}};
  const auto move =
      solved({.spline = Spline::tcb, .axis_count = 2, .keys = keys, .shapes = shapes}, {10, 10}, 48);
  const double speed = move.track().arc_length().total() / 2;
  for (const AxisPeaks& axis : peaks_of(move.track())) {
    EXPECT_LE(axis.velocity.value, 1.01 * speed);
    EXPECT_GE(axis.velocity.value, speed / 10);
    EXPECT_EQ(axis.acceleration.value, std::numeric_limits<double>::infinity());
  }
}

TEST(MoveBounds, ADwellIsStill) {
  const std::vector<double> keys{0, 50, 50, 100};
  const auto move = solved({.axis_count = 1, .keys = keys}, {0, 0, 10, 10, 0, 0, 0, 10, 10, 0, 0}, 240);
  const AxisPeaks peaks = peaks_of(move.track())[0];
  EXPECT_TRUE(std::isfinite(peaks.acceleration.value));
  EXPECT_TRUE(std::isfinite(peaks.jerk.value));
  EXPECT_GT(peaks.velocity.value, 10);
}

TEST(MoveBounds, BreaksHaveTheSpeedOfTheirOwnPortion) {
  const std::vector<double> keys{0, 10, 100};
  const auto move =
      solved({.axis_count = 1, .keys = keys}, {10, 10}, 48, {{.key = 1, .frame = 24, .breaks = true}});
  expect_bound(peaks_of(move.track())[0].velocity.value, 90);
}

TEST(MoveBounds, TimedByFramesAreBoundedToo) {
  const std::vector<double> keys{0, 30, 90, 90};
  const std::vector<std::int32_t> key_frames{0, 12, 48, 72};
  for (const Kinetic kinetic : {Kinetic::linear, Kinetic::monotone}) {
    const TrackSpec spec{.path = {.axis_count = 1, .keys = keys},
                         .control_values = {},
                         .frames = 72,
                         .fps = {24, 1},
                         .arc_length = {},
                         .key_frames = key_frames,
                         .kinetic = kinetic};
    const SolvedTrack move(spec, Solver::closed_form);
    const AxisPeaks peaks = peaks_of(move.track())[0];
    std::vector<AxisMotion> motion(1);
    AxisMotion dense;
    for (std::int32_t frame = 0; frame < 72; ++frame) {
      for (int part = 0; part < 1000; ++part) {
        move.track().motion({frame, part / 1000.0}, motion);
        dense.velocity = std::max(dense.velocity, std::fabs(motion[0].velocity));
        dense.acceleration = std::max(dense.acceleration, std::fabs(motion[0].acceleration));
        dense.jerk = std::max(dense.jerk, std::fabs(motion[0].jerk));
      }
    }
    expect_bound(peaks.velocity.value, dense.velocity);
    EXPECT_GE(peaks.acceleration.value, dense.acceleration * (1 - 1e-12));
    EXPECT_LE(peaks.acceleration.value, 1.02 * dense.acceleration + 1e-9);
    EXPECT_GE(peaks.jerk.value, dense.jerk * (1 - 1e-9));
    EXPECT_LE(peaks.jerk.value, 1.02 * dense.jerk + 1e-9);
  }
}

TEST(MoveBounds, TooLittleMemorySaysHowMuchIsNeeded) {
  const std::vector<double> keys{0, 0, 10, 50, 20, 10, 0, 0};
  const auto solution = solved({.axis_count = 2, .keys = keys}, {10, 10}, 48);
  const Move move = Move::make({&solution.track(), 1}, {}).value();
  MoveBoundsStorage<2, 20, 200, 20, 4> storage;
  const auto code = [&](const MoveBoundsMemory& memory, MoveBounds bounds) {
    const Status status = bound_move(move, {&solution.track(), 1}, {}, {}, memory, bounds);
    return status ? ErrorCode{} : status.error().code;
  };
  const MoveBounds bounds = storage.bounds(move, 4);
  EXPECT_EQ(code(storage.memory(), bounds), ErrorCode{});
  MoveBounds wrong = bounds;
  wrong.peaks = wrong.peaks.first(1);
  EXPECT_EQ(code(storage.memory(), wrong), ErrorCode::wrong_count);
  wrong = bounds;
  wrong.cells.suprema = wrong.cells.suprema.first(7);
  EXPECT_EQ(code(storage.memory(), wrong), ErrorCode::wrong_count);
  MoveBoundsMemory small = storage.memory();
  small.joints = small.joints.first(2);
  EXPECT_EQ(code(small, bounds), ErrorCode::capacity);
  small = storage.memory();
  small.travel = small.travel.first(1);
  EXPECT_EQ(code(small, bounds), ErrorCode::capacity);
  small = storage.memory();
  small.trajectory.pieces = small.trajectory.pieces.first(3);
  EXPECT_EQ(code(small, bounds), ErrorCode::capacity);
}

TEST(MoveBounds, AMotorOfAnAxisThatTheMoveDoesNotHaveIsAnError) {
  const std::vector<double> keys{0, 0, 10, 50, 20, 10, 0, 0};
  const auto solution = solved({.axis_count = 2, .keys = keys}, {10, 10}, 48);
  const Move move = Move::make({&solution.track(), 1}, {}).value();
  std::array<CalibrationPiece, 3> pieces;
  const std::array<CalibrationMark, 2> marks{{{0, 0}, {100, 10}}};
  const auto curve = Calibration::make(marks, pieces);
  ASSERT_TRUE(curve);
  const CalibratedMotor motor{.axis = 2, .calibration = &*curve};
  MoveBoundsStorage<3, 20, 200, 20, 4, 64, 2> storage;
  MoveBounds bounds = storage.bounds(move, 4, 1);
  const Status status = bound_move(move, {&solution.track(), 1}, {}, {&motor, 1}, storage.memory(), bounds);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::out_of_range);
}

TEST(MoveBounds, TheRollsOfMoreAxesThanATrajectoryMayHaveAreAllInTheCells) {
  const std::vector<double> keys{0, 100};
  const auto one = solved({.axis_count = 1, .keys = keys}, {10, 10}, 48);
  const std::vector<Track> tracks(max_trajectory_axes + 2, one.track());
  const std::vector<RollAxis> before(
      tracks.size(), *RollAxis::make({RollEnd::before, 0, 12, {24, 1}},
                                     {.position = 0, .velocity = 50, .acceleration = 0, .jerk = 0}));
  const auto move = Move::make(tracks, {.before = before});
  ASSERT_TRUE(move);
  const BoundedMove bounded(*move, tracks, {.limits = {}, .motors = {}, .cells = 5, .room = {}});
  const std::span<const MotionTriple> on_the_roll = bounded.cells().of_cell(0);
  EXPECT_GT(on_the_roll.front()[1], 100);
  EXPECT_EQ(on_the_roll.back(), on_the_roll.front());
}

TEST(MoveBounds, ARollOnWhichAMotorPassesMoreMarksThanThereIsRoomForIsAnError) {
  const std::vector<double> keys{0, 100};
  const auto solution = solved({.axis_count = 1, .keys = keys}, {10, 10}, 48);
  const std::span<const Track> tracks(&solution.track(), 1);
  // It comes from -50, over all marks but the last.
  const auto roll = RollAxis::make({RollEnd::before, 0, 48, {24, 1}},
                                   {.position = 0, .velocity = 50, .acceleration = 0, .jerk = 0});
  ASSERT_TRUE(roll);
  const auto move = Move::make(tracks, {.before = {&*roll, 1}});
  ASSERT_TRUE(move);
  std::array<CalibrationMark, 21> marks;
  for (std::size_t i = 0; i < marks.size(); ++i)
    marks[i].axis = marks[i].motor = 2.0 * static_cast<double>(i) - 42;
  marks.back().axis = marks.back().motor = 200;
  std::array<CalibrationPiece, 22> pieces;
  const auto curve = Calibration::make(marks, pieces);
  ASSERT_TRUE(curve);
  const CalibratedMotor motor{.axis = 0, .calibration = &*curve};
  MoveBoundsStorage<2, 20, 200, 20, 4, 64, 1> storage;
  TrajectoryStorage<1, 800, 100> of_motor;
  std::array<MotorJoint, 100> joints;
  MoveBoundsMemory memory = storage.memory();
  memory.motor = of_motor.memory();
  MoveBounds bounds = storage.bounds(*move, 4, 1);
  memory.motor_joints = joints;
  EXPECT_TRUE(bound_move(*move, tracks, {}, {&motor, 1}, memory, bounds));
  memory.motor_joints = std::span(joints).first(12);
  const Status status = bound_move(*move, tracks, {}, {&motor, 1}, memory, bounds);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::capacity);
}

TEST(MoveBounds, AStretchThatHasNoRoomIsFittedInShorterOnesWithTheSameBounds) {
  const std::vector<double> keys{0, 0, 100, 20, 180, -40, 300, 0, 200, 50, 20, 10};
  const auto solution = solved({.axis_count = 2, .keys = keys}, {0, 0, 10, 10, 4, 10, 0, 0}, 120);
  const Move move = Move::make({&solution.track(), 1}, {}).value();
  MoveBoundsStorage<2, 40, 400, 40, 30> wide;
  MoveBoundsStorage<2, 40, 60, 40, 30> narrow;
  MoveBounds at_once = wide.bounds(move, 30);
  MoveBounds in_stretches = narrow.bounds(move, 30);
  ASSERT_TRUE(bound_move(move, {&solution.track(), 1}, {}, {}, wide.memory(), at_once));
  ASSERT_TRUE(bound_move(move, {&solution.track(), 1}, {}, {}, narrow.memory(), in_stretches));
  for (std::size_t d = 0; d < 2; ++d) {
    EXPECT_NEAR(in_stretches.peaks[d].jerk.value, at_once.peaks[d].jerk.value,
                2e-5 * at_once.peaks[d].jerk.value);
    EXPECT_NEAR(in_stretches.peaks[d].velocity.value, at_once.peaks[d].velocity.value,
                2e-5 * at_once.peaks[d].velocity.value);
  }
  ASSERT_EQ(in_stretches.step_count, at_once.step_count);
  for (std::size_t i = 0; i < at_once.step_count; ++i) {
    EXPECT_EQ(in_stretches.steps[i].key, at_once.steps[i].key);
    EXPECT_EQ(in_stretches.steps[i].velocity, at_once.steps[i].velocity);
    EXPECT_EQ(in_stretches.steps[i].acceleration, at_once.steps[i].acceleration);
  }
}

TEST(MoveBounds, TheEndOfThePathIsBoundedThoughTheLastFrameIsARoundingShortOfIt) {
  // Towards the key of tension 0.99999 the acceleration grows by a hundredth in the last 1e-10 mm.
  RandomMove move;
  move.keys.kind = oracle::Kind::tcb;
  move.keys.at = {{183, 0, 0}, {21, 0, -3}, {0, -1, 1}, {0, -1, -7}, {0, 46, 0}};
  move.keys.tension_continuity_bias = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0.99999L, 0, 0}};
  move.speed = {0.25, 0.25, 0.25, 0.5, 0.5, 3.5, 0, 0, 3, 0.25};
  move.frames = 1;
  const SolvedTrack solved = solve(move);
  const std::vector<AxisPeaks> peaks = peaks_of(solved.track());
  EXPECT_GE(peaks[1].acceleration.value, 1.411898e13) << "the oracle's";
  EXPECT_GE(peaks[2].acceleration.value, 9.47988926e13);
}

TEST(MoveBounds, ASharpTurnIsBoundedSoon) {
  // Beside the key of tension 0.99999 rounding hides where on the turn the motion is. A search that did not
  // know when halving is in vain would go on for hours.
  RandomMove move;
  move.keys.kind = oracle::Kind::tcb;
  move.keys.closed = true;
  move.keys.at = {{-5030, 95, 397997200},  {-6900, 886, 398004830}, {6840, -967, 397996390},
                  {1140, 530, 397990680},  {8570, -387, 398006110}, {-3970, -78, 398006130},
                  {3910, -103, 397999520}, {-6250, -460, 398010000}};
  move.keys.tension_continuity_bias = {{0.99999L, -0.168L, 0.697L}, {-0.017L, -0.62L, -0.237L},
                                       {0.541L, -0.492L, -0.531L},  {-0.129L, -0.456L, -0.206L},
                                       {0.059L, -0.285L, 0.652L},   {-0.761L, 0.967L, -0.697L},
                                       {-0.549L, -0.217L, 0.503L},  {-0.494L, -0.758L, 0.144L}};
  move.speed = {1.75, 27.25, 71.75, 27.75, 50.5, 98.5, 0, 0};
  move.frames = 372;
  const SolvedTrack solved = solve(move);
  for (const AxisPeaks& axis : peaks_of(solved.track())) EXPECT_GT(axis.acceleration.value, 1e6);
}

}  // namespace move_bounds_test
}  // namespace inbetween
