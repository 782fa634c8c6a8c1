#include "inbetween/limits/motion_bounds.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "host_tools/plan/solved_track.hpp"
#include "inbetween/limits/motion_cells.hpp"
#include "inbetween/limits/move.hpp"
#include "tests/support/random_move.hpp"
#include "tests/support/solved_move.hpp"

/// The proven bounds on moves whose peaks are known; random moves are in tests/property.

namespace inbetween {
namespace motion_bounds_test {

template <Precise Real>
SolvedTrack<Real> solved(const PathSpec<Real>& path, const std::vector<Real>& speed, std::int32_t frames,
                         const std::vector<KeyLock>& locks = {}) {
  TrackSpec<Real> spec{
      .path = path, .control_values = speed, .frames = frames, .fps = {24, 1}, .arc_length = {}};
  spec.locks = locks;
  return SolvedTrack<Real>(spec, Solver::closed_form);
}

template <Precise Real>
std::vector<AxisPeaks<Real>> peaks_of(const Track<Real>& track,
                                      const std::optional<WholeFrames>& part = std::nullopt) {
  const auto axes = static_cast<std::size_t>(track.path().axis_count());
  std::vector<AxisTurn<Real>> turns(axes);
  const std::vector<MotionTriple<Real>> slack(axes);
  std::vector<AxisPeaks<Real>> peaks(axes);
  EXPECT_TRUE(bound_motion<Real>(track, slack, {turns}, peaks, part).has_value());
  return peaks;
}

/// At or above the truth, and within 1 % of it.
void expect_bound(double bound, double truth) {
  EXPECT_GE(bound, truth);
  EXPECT_LE(bound, 1.01 * truth);
}

TEST(MotionBounds, AStraightLineWithAStraightSpeedCurveIsKnownByHand) {
  // 100 mm in 48 frames, from v to 3 v: v = 25 mm/s, acceleration 2 v in 2 s.
  const std::vector<double> keys{0, 100};
  const auto move = solved<double>({.axis_count = 1, .keys = keys}, {10, 30}, 48);
  const AxisPeaks<double> peaks = peaks_of(move.track())[0];
  EXPECT_EQ(peaks.lowest.value, 0);
  EXPECT_EQ(peaks.highest.value, 100);
  EXPECT_EQ(peaks.highest.frame, 48);
  expect_bound(peaks.velocity.value, 75);
  EXPECT_EQ(peaks.velocity.frame, 48);
  expect_bound(peaks.acceleration.value, 25);
  EXPECT_LE(peaks.jerk.value, 1e-9);
}

TEST(MotionBounds, APartIsBoundedByItselfAlone) {
  // The speed rises from 25 to 75 mm/s in 48 frames: from 12 to 36 it goes from 37.5 to 62.5.
  const std::vector<double> keys{0, 100};
  const auto move = solved<double>({.axis_count = 1, .keys = keys}, {10, 30}, 48);
  const AxisPeaks<double> peaks = peaks_of(move.track(), WholeFrames{12, 36})[0];
  expect_bound(peaks.velocity.value, 62.5);
  EXPECT_EQ(peaks.velocity.frame, 36);
  expect_bound(peaks.acceleration.value, 25);
  EXPECT_NEAR(peaks.lowest.value, 25.0 * 0.5 + 25.0 * 0.5 * 0.5 / 2, 1e-9);
  EXPECT_NEAR(peaks.lowest.frame, 12, 1e-12);
  EXPECT_NEAR(peaks.highest.value, 25.0 * 1.5 + 25.0 * 1.5 * 1.5 / 2, 1e-9);
  EXPECT_EQ(peaks.highest.frame, 36);
}

TEST(MotionBounds, TheCellsOfAPartKnowNothingOfTheRest) {
  const std::vector<double> keys{0, 100};
  const auto move = solved<double>({.axis_count = 1, .keys = keys}, {10, 30}, 48);
  const std::array tracks{move.track()};
  const auto part = Move<double>::make(tracks, {}, WholeFrames{12, 36});
  ASSERT_TRUE(part);
  constexpr std::size_t cells = 8;
  std::vector<MotionTriple<double>> suprema(cells);
  std::vector<AxisTurn<double>> turns(1);
  std::vector<MotionTriple<double>> slack(1);
  bound_cells<double>(*part, turns, {.cells = cells, .slack = slack, .suprema = suprema});
  for (std::size_t cell = 0; cell < cells; ++cell) {
    const double fastest = 37.5 + 25.0 * static_cast<double>(cell + 1) / cells;
    EXPECT_GE(suprema[cell][0], fastest * (1 - 1e-12)) << cell;
    EXPECT_LE(suprema[cell][0], 1.02 * fastest) << cell;
  }
}

TEST(MotionBounds, TheCellsOfAMoveAreAsCloseToTheTruthAsTheyPromise) {
  const std::vector<double> keys{0, 0, 30, 50, 45, 20, 90, 35, 70, 80, 20, 60};
  const auto move = solved<double>({.axis_count = 2, .keys = keys}, {0, 0, 10, 4, 12, 8, 0, 0}, 96);
  const std::array tracks{move.track()};
  constexpr std::size_t cells = 24;
  constexpr int samples = 4000;
  std::array<MotionTriple<double>, 2 * cells> found{};
  std::array<MotionTriple<double>, 2> peak{};
  for (int i = 0; i <= samples * static_cast<int>(cells); ++i) {
    const double frame = 96.0 * i / (samples * cells);
    const auto whole = static_cast<std::int32_t>(frame);
    std::array<AxisMotion<double>, 2> motion;
    static_cast<void>(move.track().motion({whole, frame - whole}, motion));
    // Samples on a border belong to neither of its cells.
    if (i % samples == 0) continue;
    for (std::size_t d = 0; d < 2; ++d) {
      const MotionTriple<double> here{motion[d].velocity, motion[d].acceleration, motion[d].jerk};
      for (std::size_t q = 0; q < motion_quantities; ++q) {
        double& of_cell = found[2 * static_cast<std::size_t>(i / samples) + d][q];
        of_cell = std::max(of_cell, std::fabs(here[q]));
        peak[d][q] = std::max(peak[d][q], of_cell);
      }
    }
  }
  std::vector<MotionTriple<double>> suprema(2 * cells);
  std::vector<AxisTurn<double>> turns(2);
  std::vector<MotionTriple<double>> slack(2);
  bound_cells<double>(Move<double>::make(tracks, {}).value(), turns,
                      {.cells = cells, .slack = slack, .suprema = suprema});
  // The samples miss next to nothing of a peak, and a border is off by as little.
  constexpr double missed = 1e-3;
  for (std::size_t i = 0; i < suprema.size(); ++i) {
    for (std::size_t q = 0; q < motion_quantities; ++q) {
      const double own = found[i][q];
      EXPECT_GE(suprema[i][q], own) << "cell " << i / 2 << ", axis " << i % 2 << ", quantity " << q;
      EXPECT_LE(suprema[i][q], own + std::max(0.02 * own, 0.005 * peak[i % 2][q]) + missed * peak[i % 2][q])
          << "cell " << i / 2 << ", axis " << i % 2 << ", quantity " << q;
    }
  }
}

TEST(MotionBounds, AKeyOnTheFirstOrLastFrameOfAPartHasOneSide) {
  // An axis each before and behind the corner, which is met on frame 24 as exactly as a lock is.
  const std::vector<double> keys{0, 0, 100, 0, 100, 60};
  for (const bool breaks : {false, true}) {
    const auto move = solved<double>({.spline = Spline::linear, .axis_count = 2, .keys = keys}, {10, 14, 10},
                                     48, {{.key = 1, .frame = 24, .breaks = breaks}});
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

TEST(MotionBounds, AnAxisThatTurnsInsideASegmentIsBoundedBeyondItsKeys) {
  const std::vector<double> keys{0, 0, 10, 50, 20, 50, 30, 0};
  const auto move = solved<double>({.axis_count = 2, .keys = keys}, {10, 10}, 48);
  const AxisPeaks<double> peaks = peaks_of(move.track())[1];
  double sampled = 0;
  for (int i = 0; i <= 1000; ++i)
    sampled = std::max(sampled, move.track().path().segment(1)[1].value(i / 1000.0));
  EXPECT_GT(sampled, 52);
  EXPECT_GE(peaks.highest.value, sampled);
  EXPECT_LE(peaks.highest.value, sampled + 1e-4);
  EXPECT_NEAR(peaks.highest.frame, 24, 1e-6);
}

TEST(MotionBounds, ASpikeBetweenTwoFramesIsFoundWhereASamplerOf24ASecondMissesIt) {
  // Two keys 1 mm apart in a tight bend of a smooth path.
  const std::vector<double> keys{0, 0, 400, 0, 400, 1, 0, 2};
  const double limit = 1000;
  const auto move = solved<double>({.axis_count = 2, .keys = keys}, {0, 0, 10, 10, 0, 0}, 101);
  const std::vector<AxisPeaks<double>> peaks = peaks_of(move.track());
  std::vector<AxisMotion<double>> motion(2);
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

TEST(MotionBounds, ALineThatTurnsBackInsideASegmentAtASpeedHasNoBound) {
  const std::vector<double> keys{0, 10, 9, 0};
  const auto move = solved<double>({.axis_count = 1, .keys = keys}, {10, 10}, 48);
  const AxisPeaks<double> peaks = peaks_of(move.track())[0];
  ASSERT_GT(peaks.highest.value, 10);
  expect_bound(peaks.velocity.value, move.track().arc_length().total() / 2);
  EXPECT_EQ(peaks.acceleration.value, std::numeric_limits<double>::infinity());
  EXPECT_EQ(peaks.jerk.value, std::numeric_limits<double>::infinity());
  EXPECT_NEAR(peaks.acceleration.frame, peaks.highest.frame, 1e-6);
}

TEST(MotionBounds, ALineThatTurnsBackAtRestIsBounded) {
  // The same way, and phi is 0 where the line turns.
  const std::vector<double> keys{0, 10, 0};
  const auto move = solved<double>({.axis_count = 1, .keys = keys}, {0, 0, 10, 0, 0, 0, 10, 0, 0}, 96);
  const AxisPeaks<double> peaks = peaks_of(move.track())[0];
  EXPECT_TRUE(std::isfinite(peaks.acceleration.value));
  EXPECT_GT(peaks.acceleration.value, 1);
}

TEST(MotionBounds, ABendOfAMillionthOfAMillimetreIsNotTakenForALine) {
  const std::vector<double> keys{0, 0, 8, 0, 8, 1e-6, 0, 0};
  const auto move =
      solved<double>({.spline = Spline::catmull_rom, .axis_count = 2, .keys = keys}, {10, 10}, 48);
  EXPECT_GT(peaks_of(move.track())[0].acceleration.value, 1e6);
}

TEST(MotionBounds, AKeyOfTensionOneHasABoundedVelocity) {
  const std::vector<double> keys{0, 0, 50, 20, 60, 90, 0, 100};
  const std::vector<KeyShape<double>> shapes{{}, {.tension = 1, .continuity = 0, .bias = 0}, {}, {}};
  const auto move =
      solved<double>({.spline = Spline::tcb, .axis_count = 2, .keys = keys, .shapes = shapes}, {10, 10}, 48);
  const double speed = move.track().arc_length().total() / 2;
  for (const AxisPeaks<double>& axis : peaks_of(move.track())) {
    EXPECT_LE(axis.velocity.value, 1.01 * speed);
    EXPECT_GE(axis.velocity.value, speed / 10);
    EXPECT_EQ(axis.acceleration.value, std::numeric_limits<double>::infinity());
  }
}

TEST(MotionBounds, ADwellIsStill) {
  const std::vector<double> keys{0, 50, 50, 100};
  const auto move =
      solved<double>({.axis_count = 1, .keys = keys}, {0, 0, 10, 10, 0, 0, 0, 10, 10, 0, 0}, 240);
  const AxisPeaks<double> peaks = peaks_of(move.track())[0];
  EXPECT_TRUE(std::isfinite(peaks.acceleration.value));
  EXPECT_TRUE(std::isfinite(peaks.jerk.value));
  EXPECT_GT(peaks.velocity.value, 10);
}

TEST(MotionBounds, BreaksHaveTheSpeedOfTheirOwnPortion) {
  const std::vector<double> keys{0, 10, 100};
  const auto move = solved<double>({.axis_count = 1, .keys = keys}, {10, 10}, 48,
                                   {{.key = 1, .frame = 24, .breaks = true}});
  expect_bound(peaks_of(move.track())[0].velocity.value, 90);
}

TEST(MotionBounds, TimedByFramesAreBoundedToo) {
  const std::vector<double> keys{0, 30, 90, 90};
  const std::vector<std::int32_t> key_frames{0, 12, 48, 72};
  for (const Kinetic kinetic : {Kinetic::linear, Kinetic::monotone}) {
    const TrackSpec<double> spec{.path = {.axis_count = 1, .keys = keys},
                                 .control_values = {},
                                 .frames = 72,
                                 .fps = {24, 1},
                                 .arc_length = {},
                                 .key_frames = key_frames,
                                 .kinetic = kinetic};
    const SolvedTrack<double> move(spec, Solver::closed_form);
    const AxisPeaks<double> peaks = peaks_of(move.track())[0];
    std::vector<AxisMotion<double>> motion(1);
    AxisMotion<double> dense;
    for (std::int32_t frame = 0; frame < 72; ++frame) {
      for (int part = 0; part < 1000; ++part) {
        move.track().motion({frame, part / 1000.0}, motion);
        dense.velocity = std::max(dense.velocity, std::fabs(motion[0].velocity));
        dense.acceleration = std::max(dense.acceleration, std::fabs(motion[0].acceleration));
        dense.jerk = std::max(dense.jerk, std::fabs(motion[0].jerk));
      }
    }
    expect_bound(peaks.velocity.value, dense.velocity);
    EXPECT_GE(peaks.acceleration.value, dense.acceleration);
    EXPECT_LE(peaks.acceleration.value, 1.02 * dense.acceleration + 1e-9);
    EXPECT_GE(peaks.jerk.value, dense.jerk);
    EXPECT_LE(peaks.jerk.value, 1.02 * dense.jerk + 1e-9);
  }
}

TEST(MotionBounds, SinglePrecisionBoundsTheSameMove) {
  const std::vector<double> keys{0, 0, 100, 20, 180, -40, 300, 0};
  const std::vector<float> single_keys(keys.begin(), keys.end());
  const auto full = solved<double>({.axis_count = 2, .keys = keys}, {0, 0, 10, 10, 4, 10, 0, 0}, 120);
  const auto single = solved<float>({.axis_count = 2, .keys = single_keys}, {0, 0, 10, 10, 4, 10, 0, 0}, 120);
  const std::vector<AxisPeaks<double>> expected = peaks_of(full.track());
  const std::vector<AxisPeaks<float>> peaks = peaks_of(single.track());
  for (std::size_t d = 0; d < 2; ++d) {
    EXPECT_NEAR(static_cast<double>(peaks[d].velocity.value) / expected[d].velocity.value, 1, 0.01);
    EXPECT_NEAR(static_cast<double>(peaks[d].acceleration.value) / expected[d].acceleration.value, 1, 0.02);
    EXPECT_NEAR(static_cast<double>(peaks[d].jerk.value) / expected[d].jerk.value, 1, 0.05);
  }
}

TEST(MotionBounds, TooLittleMemorySaysHowMuchIsNeeded) {
  const std::vector<double> keys{0, 0, 10, 50};
  const auto move = solved<double>({.axis_count = 2, .keys = keys}, {10, 10}, 48);
  std::vector<AxisTurn<double>> turns(1);
  const std::vector<MotionTriple<double>> slack(2);
  std::vector<AxisPeaks<double>> peaks(2);
  const Status refused = bound_motion<double>(move.track(), slack, {turns}, peaks);
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().code, ErrorCode::capacity);
  EXPECT_EQ(refused.error().needed, 2);
}

TEST(MotionBounds, TheEndOfThePathIsBoundedThoughTheLastFrameIsARoundingShortOfIt) {
  // Towards the key of tension 0.99999 the acceleration grows by a hundredth in the last 1e-10 mm.
  RandomMove move;
  move.keys.kind = oracle::Kind::tcb;
  move.keys.at = {{183, 0, 0}, {21, 0, -3}, {0, -1, 1}, {0, -1, -7}, {0, 46, 0}};
  move.keys.tension_continuity_bias = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0.99999L, 0, 0}};
  move.speed = {0.25, 0.25, 0.25, 0.5, 0.5, 3.5, 0, 0, 3, 0.25};
  move.frames = 1;
  const TrackInput<double> input(move);
  const SolvedTrack<double> solved(input.spec, Solver::closed_form);
  std::vector<AxisTurn<double>> turns(3);
  std::vector<AxisPeaks<double>> peaks(3);
  const std::vector<MotionTriple<double>> slacks(3);
  ASSERT_TRUE(bound_motion<double>(solved.track(), slacks, {turns}, peaks));
  EXPECT_GE(peaks[1].acceleration.value, 1.411898e13) << "the oracle's";
  EXPECT_GE(peaks[2].acceleration.value, 9.47988926e13);
}

TEST(MotionBounds, ASharpTurnIsBoundedSoonWhateverTheLimits) {
  // Beside the key of tension 0.99999 rounding hides where on the turn the motion is. A search that did not
  // know when halving is in vain would go on for hours as soon as a slack was given.
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
  const TrackInput<double> input(move);
  const SolvedTrack<double> solved(input.spec, Solver::closed_form);
  std::vector<AxisTurn<double>> turns(3);
  std::vector<AxisPeaks<double>> peaks(3);
  for (const double slack : {0.0, 1e-6, 1e20, 1e24}) {
    const std::vector<MotionTriple<double>> slacks(3, {slack, slack, slack});
    ASSERT_TRUE(bound_motion<double>(solved.track(), slacks, {turns}, peaks));
    for (const AxisPeaks<double>& axis : peaks) EXPECT_GT(axis.acceleration.value, 1e6);
  }
}

}  // namespace motion_bounds_test
}  // namespace inbetween
