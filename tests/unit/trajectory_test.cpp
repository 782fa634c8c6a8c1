// The trajectory of every way of timing, its parts and its rolls, its bounds on a stretch, and what is
// refused.
#include "inbetween/trajectory/trajectory.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "host_tools/plan/fitted_trajectory.hpp"
#include "host_tools/plan/plan.hpp"
#include "inbetween/limits/roll_trajectory.hpp"
#include "inbetween/trajectory/bounds.hpp"
#include "tests/support/bounded_cells.hpp"
#include "tests/support/even_pieces.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/timing_kinds.hpp"

namespace inbetween {
namespace trajectory_test {

constexpr std::size_t axes = 2;
using Motions = std::array<AxisMotion, axes>;

RigFile quick_rig() {
  return parse_rig(rig_text({{.name = "x", .max_velocity = 1e5, .max_acceleration = 1e7},
                             {.name = "y", .max_velocity = 1e5, .max_acceleration = 1e7}}),
                   "rig.toml");
}

FrameTime time_at(double frame) {
  const double whole = std::floor(frame);
  return {static_cast<std::int32_t>(whole), frame - whole};
}

class EveryTimingAsATrajectory : public testing::TestWithParam<TimingKind> {
 protected:
  EveryTimingAsATrajectory() : plan_(move_of(GetParam()), quick_rig(), {}), fitted_(track()) {}

  [[nodiscard]] const Track& track() const { return plan_.tracks()[0].track(); }

  Plan plan_;
  FittedTrajectory fitted_;
};

TEST_P(EveryTimingAsATrajectory, IsWithinTheTolerancesOfTheTrack) {
  const std::vector<AxisPeaks> peaks = bounds_of_track(track()).peaks();
  Motions asked, played;
  for (int k = 0; k < 48 * 40; ++k) {
    const FrameTime time = time_at((k + 0.381966) / 40);
    const double speed = fitted_.sampler().sample(time, asked).speed;
    fitted_->motion(time, played);
    for (std::size_t d = 0; d < axes; ++d) {
      const double travel = peaks[d].highest.value - peaks[d].lowest.value;
      EXPECT_NEAR(played[d].position, asked[d].position, 1.1 * travel / (1 << 30)) << k;
      EXPECT_NEAR(played[d].velocity, asked[d].velocity, 1.1e-6 * speed + 1e-12 * travel * 24) << k;
      EXPECT_NEAR(played[d].acceleration, asked[d].acceleration, 1e-4 * peaks[d].acceleration.value + 1e-9)
          << k;
      EXPECT_NEAR(played[d].jerk, asked[d].jerk, 3e-3 * peaks[d].jerk.value + 1e-6) << k;
    }
  }
  EXPECT_EQ(fitted_->loosened(), 1);
}

TEST_P(EveryTimingAsATrajectory, MeetsTheEndsOfTheTrackToTheLastBit) {
  std::array<double, axes> of_track, of_trajectory;
  for (const double frame : {-3.0, 0.0, 48.0, 51.0}) {
    track().positions(time_at(frame), of_track);
    fitted_->positions(time_at(frame), of_trajectory);
    EXPECT_EQ(of_trajectory, of_track) << frame;
  }
}

TEST_P(EveryTimingAsATrajectory, APartOfItIsTheWholeBitForBitAndRestsOutside) {
  const Trajectory part = fitted_->part({7, 0}, {31, 0.25});
  std::array<double, axes> whole, of_part;
  for (int k = -40; k <= 48 * 8 + 40; ++k) {
    const double frame = k / 8.0;
    fitted_->positions(time_at(std::clamp(frame, 7.0, 31.25)), whole);
    part.positions(time_at(frame), of_part);
    EXPECT_EQ(of_part, whole) << frame;
  }
  Motions outside;
  part.motion({40, 0}, outside);
  EXPECT_EQ(outside[0].velocity, 0);
  EXPECT_EQ(outside[1].jerk, 0);
}

TEST_P(EveryTimingAsATrajectory, IsBoundOnAStretchByWhatIsFoundThere) {
  for (const auto& [from, to] : {std::pair{0.0, 48.0}, {3.3, 4.1}, {11.0, 30.5}}) {
    std::array<AxisPeaks, axes> peaks;
    bound_trajectory(*fitted_, time_at(from), time_at(to), peaks);
    std::array<AxisMotion, axes> found{}, played;
    for (int k = 0; k <= 4000; ++k) {
      fitted_->motion(time_at(from + (to - from) * k / 4000), played);
      for (std::size_t d = 0; d < axes; ++d) {
        EXPECT_GE(played[d].position, peaks[d].lowest.value - 1e-12);
        EXPECT_LE(played[d].position, peaks[d].highest.value + 1e-12);
        found[d].velocity = std::max(found[d].velocity, std::fabs(played[d].velocity));
        found[d].acceleration = std::max(found[d].acceleration, std::fabs(played[d].acceleration));
      }
    }
    for (std::size_t d = 0; d < axes; ++d) {
      EXPECT_GE(peaks[d].velocity.value, found[d].velocity * (1 - 1e-12));
      EXPECT_LE(peaks[d].velocity.value, found[d].velocity * 1.005 + 1e-9)
          << from << ": " << peaks[d].velocity.frame;
      EXPECT_GE(peaks[d].acceleration.value, found[d].acceleration * (1 - 1e-12) - 1e-12);
      EXPECT_LE(peaks[d].acceleration.value, found[d].acceleration * 1.02 + 1e-6);
    }
  }
}

TEST_P(EveryTimingAsATrajectory, IsJoinedByTheTrajectoryOfItsRolls) {
  const MoveRolls& rolls = plan_.played().rolls();
  EXPECT_EQ(!rolls.before.empty(), GetParam().rolls);
  for (const std::span<const RollAxis> roll : {rolls.before, rolls.after}) {
    if (roll.empty()) continue;
    std::array<TrajectoryPiece, 1> piece;
    std::array<double, 6 * axes> values;
    std::array<std::uint32_t, 1> bucket;
    const TrajectoryMemory memory{piece, values, bucket, {}, {}, {}, {}};
    const Result<Trajectory> rolled = roll_trajectory(roll, memory);
    ASSERT_TRUE(rolled.has_value());
    const Result<Trajectory> none =
        roll_trajectory(roll, {piece, std::span(values).first(roll.size()), bucket, {}, {}, {}, {}});
    ASSERT_FALSE(none.has_value());
    EXPECT_EQ(none.error().needed, static_cast<std::int64_t>(6 * roll.size()));
    const double frames = frames_between(rolled->begin(), rolled->end());
    Motions played;
    for (int k = 0; k <= 400; ++k) {
      const FrameTime time = moved_by(rolled->begin(), frames * k / 400);
      rolled->motion(time, played);
      for (std::size_t d = 0; d < axes; ++d) {
        const AxisMotion asked = roll[d].motion(time);
        EXPECT_NEAR(played[d].position, asked.position, 1e-12 * (1 + std::fabs(asked.position)));
        EXPECT_NEAR(played[d].velocity, asked.velocity, 1e-9 * (1 + std::fabs(asked.velocity)));
        EXPECT_NEAR(played[d].acceleration, asked.acceleration, 1e-8 * (1 + std::fabs(asked.acceleration)));
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(, EveryTimingAsATrajectory, testing::ValuesIn(timing_kinds()),
                         [](const auto& kind) { return kind.param.name; });

TEST(Trajectory, ARestIsOnePieceWithOneRow) {
  const MoveFile move = parse_move(
      "name = \"m\"\nfps = 24\nframes = 48\n[[track]]\naxes = [\"x\"]\nspeed = [0, 0, 6, 9, 7, 8, 5, 0, 0]\n"
      "keys = [{ at = [0] }, { at = [30], frame = 14, hold = 12 }, { at = [50] }]\n",
      "move.toml");
  const Plan plan(move, std::nullopt, {});
  const FittedTrajectory fitted(plan.tracks()[0].track());
  int rests = 0;
  for (const TrajectoryPiece& piece : fitted->pieces()) {
    if (piece.degree != 1) continue;
    ++rests;
    EXPECT_EQ(piece.begin_row, piece.end_row);
    EXPECT_EQ(fitted->values()[piece.begin_row], 30);
  }
  EXPECT_GE(rests, 1);
}

TEST(Trajectory, CurvesOverFramesAreCubicsAndTakeAPieceForEachStretch) {
  const auto& kinds = timing_kinds();
  const auto curves = std::ranges::find(kinds, "curves", &TimingKind::name);
  const Plan plan(move_of(*curves), std::nullopt, {});
  const Track& track = plan.tracks()[0].track();
  const FittedTrajectory fitted(track);
  EXPECT_EQ(fitted->pieces().size(), track.key_intervals().size());
  for (const TrajectoryPiece& piece : fitted->pieces()) EXPECT_EQ(piece.degree, 3);
}

TEST(Trajectory, APathWithoutLengthIsARest) {
  const MoveFile move = parse_move(
      "name = \"m\"\nfps = 24\nframes = 10\n[[track]]\naxes = [\"x\", \"y\"]\nspeed = [0, 10, 0]\n"
      "keys = [{ at = [7, 8] }]\n",
      "move.toml");
  const Plan plan(move, std::nullopt, {});
  const FittedTrajectory fitted(plan.tracks()[0].track());
  std::array<double, axes> at;
  fitted->positions({4, 0.5}, at);
  EXPECT_EQ(at, (std::array<double, axes>{7, 8}));
  ASSERT_EQ(fitted->pieces().size(), 1U);
  EXPECT_EQ(fitted->pieces()[0].begin_row, fitted->pieces()[0].end_row);
}

TEST(Trajectory, PiecesThatCannotBePlayedAreRefused) {
  const std::array<double, 4> values{1, 0, 2, 0};
  std::array<std::uint32_t, 1> bucket{};
  const auto refused = [&](const TrajectoryPiece& piece) {
    const std::array<TrajectoryPiece, 1> pieces{piece};
    const TrajectoryContents contents{
        .axis_count = 1, .fps = {24, 1}, .end = {10, 0}, .pieces = pieces, .values = values};
    return !Trajectory::make(contents, bucket).has_value();
  };
  const TrajectoryPiece whole{.begin = {0, 0},
                              .inverse_frames = 0.1,
                              .seconds = 10 / 24.0,
                              .begin_row = 0,
                              .end_row = 2,
                              .degree = 3,
                              .is_exact = false};
  EXPECT_FALSE(refused(whole));
  TrajectoryPiece wrong = whole;
  wrong.end_row = 3;
  EXPECT_TRUE(refused(wrong));
  wrong = whole;
  wrong.degree = 4;
  EXPECT_TRUE(refused(wrong));
  wrong = whole;
  wrong.begin = {10, 0};
  EXPECT_TRUE(refused(wrong));
  EXPECT_FALSE(
      Trajectory::make({.axis_count = 1, .fps = {24, 1}, .end = {10, 0}, .pieces = {}, .values = {}}, bucket)
          .has_value());
}

TEST(Trajectory, TooLittleMemoryToFitWithIsAnError) {
  const Plan plan(move_of(timing_kinds().front()), std::nullopt, {});
  const FittedTrajectory fitted(plan.tracks()[0].track());
  TrajectoryRoom room;
  room.reserve(fitted.sampler().joints().size(), axes, 4096);
  const TrajectoryMemory enough = room.memory();
  const auto fits = [&](const TrajectoryMemory& memory) {
    const Result<Trajectory> made = fit_trajectory(fitted.sampler(), {}, memory);
    return made || made.error().code != ErrorCode::capacity;
  };
  EXPECT_TRUE(fits(enough));
  TrajectoryMemory small = enough;
  small.samples = small.samples.first(3 * axes - 1);
  EXPECT_FALSE(fits(small)) << "samples";
  small = enough;
  small.numbers = small.numbers.first(fit_numbers * axes - 1);
  EXPECT_FALSE(fits(small)) << "numbers";
  small = enough;
  small.buckets = {};
  EXPECT_FALSE(fits(small)) << "buckets";
  small = enough;
  small.pieces = small.pieces.first(fitted->pieces().size() - 1);
  EXPECT_FALSE(fits(small)) << "pieces";
  small = enough;
  small.values = small.values.first(fitted->values().size() - 1);
  EXPECT_FALSE(fits(small)) << "values";
}

// --- what is known of pieces by themselves

TEST(Trajectory, AStepIsWhatItLeavesWithLessWhatItArrivedWith) {
  EvenPieces move({0, 1, 2}, {0, 1, 4});
  const std::array<TrajectoryBreak, 1> breaks{{{.time = {1, 0}, .piece = 1}}};
  move.contents.breaks = breaks;
  std::array<TrajectoryStep, 1> steps;
  steps_at(move.made(), breaks[0], steps);
  EXPECT_EQ(steps[0].velocity, (3 - 1) * 24);
  EXPECT_EQ(steps[0].acceleration, 0);
}

TEST(Trajectory, WhatHasNoBoundIsInfinityInThatDerivativeAndThoseAbove) {
  for (const int order : {1, 2, 3}) {
    EvenPieces move({0, 1, 2}, {0, 1, 2});
    const std::array<UnboundedSide, 1> sides{{{.time = {1, 0}, .order = static_cast<std::uint8_t>(order)}}};
    move.contents.unbounded = sides;
    std::array<AxisPeaks, 1> peaks;
    bound_trajectory(move.made(), peaks);
    EXPECT_EQ(std::isinf(peaks[0].velocity.value), order <= 1) << order;
    EXPECT_EQ(std::isinf(peaks[0].acceleration.value), order <= 2) << order;
    EXPECT_TRUE(std::isinf(peaks[0].jerk.value));
    EXPECT_EQ(peaks[0].jerk.frame, 1);
    bound_trajectory(move.made(), {1, 0.5}, {2, 0}, peaks);
    EXPECT_EQ(peaks[0].jerk.value, 0) << "not on this stretch";
  }
}

TEST(Trajectory, ItsMotionEndsOnTheLastRowToTheLastBit) {
  // Of 1e-17 nothing is left in 1 + (1e-17 - 1).
  EvenPieces move({0, 1, 2}, {3, 1, 1e-17});
  const Trajectory whole = move.made();
  std::array<AxisMotion, 1> motion;
  whole.motion({2, 0}, motion);
  EXPECT_EQ(motion[0].position, 1e-17);
  EXPECT_EQ(whole.motion_of(0, {2, 0}).position, 1e-17);
  EXPECT_EQ(motion[0].velocity, -24);
}

TEST(Trajectory, AMomentJustBeforeAPieceIsOnTheOneBeforeIt) {
  // The three parts of the time line by which pieces are looked up begin at 10/3 and 20/3.
  for (const double border : {10.0 / 3, 20.0 / 3}) {
    for (int k = -8; k <= 8; ++k) {
      const double begin = border * (1 + k * 1e-13);
      EvenPieces move({0, begin, 10}, {0, 1, 2});
      const Trajectory trajectory = move.made();
      for (int i = -8; i <= 8; ++i) {
        const FrameTime time = moved_by(FrameTime{}, border * (1 + i * 1e-13));
        EXPECT_EQ(trajectory.piece_at(time), trajectory.pieces()[1].begin <= time ? 1U : 0U) << k << ' ' << i;
      }
    }
  }
}

TEST(Trajectory, ASpeedBetweenTheEndsOfACellIsFoundWhereTheEndsTellTheRest) {
  // From rest to rest in a second, as a cubic would: the speed is largest in the middle, and acceleration and
  // jerk are largest at the ends.
  const std::array<double, 8> values{0, 0, 6, -12, 1, 0, -6, -12};
  const std::array<TrajectoryPiece, 1> pieces{
      {{.begin = {}, .inverse_frames = 1.0 / 24, .seconds = 1, .begin_row = 0, .end_row = 4, .degree = 7}}};
  std::array<std::uint32_t, 1> buckets{};
  const auto trajectory = Trajectory::make(
      {.axis_count = 1, .fps = {24, 1}, .end = {24, 0}, .pieces = pieces, .values = values}, buckets);
  ASSERT_TRUE(trajectory);
  const MotionTriple room{};
  std::array<MotionTriple, 1> suprema{};
  bound_cells(*trajectory, {0, 0}, {24, 0}, {0, 24, 1}, {&room, 1}, suprema, 1);
  EXPECT_GE(suprema[0][0], 1.5);
  EXPECT_LE(suprema[0][0], 1.5 * 1.02);
  EXPECT_NEAR(suprema[0][1], 6, 1e-9);
  EXPECT_NEAR(suprema[0][2], 12, 1e-9);
}

TEST(Trajectory, OfEqualPeaksTheOneThatWasThereStays) {
  const auto peaks_of = [](double value, double frame) {
    AxisPeaks peaks;
    peaks.lowest = {-value, frame};
    peaks.highest = peaks.velocity = peaks.acceleration = peaks.jerk = {value, frame};
    return peaks;
  };
  AxisPeaks peaks = peaks_of(5, 3);
  for (const auto& [value, frame] : {std::pair{4, 3}, {5, 3}, {6, 13}}) {
    peaks.raise(peaks_of(value, 13));
    EXPECT_EQ(peaks.lowest.frame, frame) << value;
    EXPECT_EQ(peaks.highest.frame, frame) << value;
    EXPECT_EQ(peaks.velocity.frame, frame) << value;
    EXPECT_EQ(peaks.acceleration.frame, frame) << value;
    EXPECT_EQ(peaks.jerk.frame, frame) << value;
  }
}

TEST(Trajectory, WhatHasNoBoundHasNoneInItsOwnCellAlone) {
  EvenPieces move({0, 1, 2}, {0, 1, 2});
  const std::array<UnboundedSide, 1> sides{{{.time = {0, 0.5}, .order = 2}}};
  move.contents.unbounded = sides;
  const MotionTriple room{};
  std::array<MotionTriple, 2> suprema{};
  bound_cells(move.made(), {0, 0}, {2, 0}, {0, 2, 2}, {&room, 1}, suprema, 1);
  EXPECT_EQ(suprema[0][0], 24);
  EXPECT_TRUE(std::isinf(suprema[0][1]));
  EXPECT_TRUE(std::isinf(suprema[0][2]));
  EXPECT_EQ(suprema[1], (MotionTriple{24, 0, 0}));
}

TEST(Trajectory, WhereItKeepsToItsJointsNoMomentOfAPieceIsBeyondItsEnds) {
  // It leaves 0 so fast that it would pass 1, and come to it from above.
  const std::array<double, 4> values{0, 120, 1, -120};
  const std::array<TrajectoryPiece, 1> pieces{
      {{.begin = {}, .inverse_frames = 1, .seconds = 1.0 / 24, .begin_row = 0, .end_row = 2, .degree = 3}}};
  std::array<std::uint32_t, 1> buckets{};
  TrajectoryContents contents{
      .axis_count = 1, .fps = {24, 1}, .end = {1, 0}, .pieces = pieces, .values = values};
  std::array<double, 1> position;
  std::array<AxisMotion, 1> motion;
  for (const bool keeps : {false, true}) {
    contents.keeps_to_joints = keeps;
    const Trajectory trajectory = *Trajectory::make(contents, buckets);
    trajectory.positions({0, 0.6}, position);
    trajectory.motion({0, 0.6}, motion);
    EXPECT_EQ(motion[0].position, position[0]);
    if (keeps) {
      EXPECT_EQ(position[0], 1);
    } else {
      EXPECT_GT(position[0], 1.5);
    }
  }
}

}  // namespace trajectory_test
}  // namespace inbetween
