// A move on its time line: tracks side by side between a pre-roll and a post-roll.
#include "inbetween/limits/move.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <optional>
#include <vector>

#include "host_tools/plan/solved_track.hpp"

namespace inbetween {
namespace move_test {

constexpr FrameRate film{24, 1};

/// A line of one axis from `from` to `to`, or through more keys.
SolvedTrack track_of(const std::vector<double>& keys, const std::vector<double>& speed,
                     std::int32_t frames = 48, FrameRate fps = film) {
  TrackSpec spec;
  spec.path = {.spline = Spline::smooth, .closed = false, .axis_count = 1, .keys = keys};
  spec.control_values = speed;
  spec.frames = frames;
  spec.fps = fps;
  return SolvedTrack(spec, Solver::closed_form);
}

std::vector<RollAxis> rolls_of(std::span<const Track> tracks, RollEnd end, std::int32_t frames,
                               std::size_t axes) {
  std::vector<AxisMotion> joints(axes);
  joints_of(tracks, end, std::span(joints));
  std::vector<RollAxis> rolls;
  const std::int32_t joint_frame = end == RollEnd::before ? 0 : tracks.front().frames();
  for (const AxisMotion& joint : joints) {
    rolls.push_back(*RollAxis::make({end, joint_frame, frames, film}, joint));
  }
  return rolls;
}

TEST(Move, LastsFromItsPreRollToItsPostRoll) {
  const auto moving = track_of({0, 30, 100}, {5, 10, 7});
  const auto resting = track_of({-1, 2}, {0, 0, 10, 0, 0});
  const std::array tracks{moving.track(), resting.track()};
  const std::span<const Track> all(tracks);
  const auto before = rolls_of(all, RollEnd::before, 12, 2);
  const auto after = rolls_of(all, RollEnd::after, 8, 2);
  const auto move = Move::make(all, {before, after});
  ASSERT_TRUE(move);
  EXPECT_EQ(move->axis_count(), 2U);
  EXPECT_EQ(move->frames(), 48);
  EXPECT_EQ(move->first_frame(), -12);
  EXPECT_EQ(move->last_frame(), 56);
  for (const std::int32_t frame : {-1000, -12, -1, 0, 20, 48, 49, 1000}) {
    const std::span<const RollAxis> rolls = move->rolls_at({frame, 0});
    const RollAxis* const expected = frame < 0 ? before.data() : frame > 48 ? after.data() : nullptr;
    EXPECT_EQ(rolls.data(), expected) << frame;
  }
}

TEST(Move, RefusesAPartThatIsNone) {
  const auto solved = track_of({0, 100}, {5, 10, 7});
  const std::array tracks{solved.track()};
  for (const WholeFrames& part : {WholeFrames{-1, 20}, {20, 20}, {20, 10}, {20, 49}}) {
    const auto move = Move::make(std::span<const Track>(tracks), {}, part);
    ASSERT_FALSE(move);
    EXPECT_EQ(move.error().code, ErrorCode::out_of_range);
  }
  const auto before = rolls_of(tracks, RollEnd::before, 12, 1);
  EXPECT_FALSE(Move::make(std::span<const Track>(tracks), {before, {}}, WholeFrames{10, 20}))
      << "a roll that joins frame 0";
}

TEST(Move, WithoutRollsRestsBeforeAndBehindItsFrames) {
  const auto solved = track_of({0, 100}, {5, 10, 7});
  const std::array tracks{solved.track()};
  const auto move = Move::make(std::span<const Track>(tracks), {});
  ASSERT_TRUE(move);
  EXPECT_EQ(move->first_frame(), 0);
  EXPECT_EQ(move->last_frame(), 48);
  EXPECT_TRUE(move->rests_at({-1, 0.5}));
  EXPECT_FALSE(move->rests_at({48, 0}));
  EXPECT_TRUE(move->rests_at({48, 0.5}));
  EXPECT_EQ(move->within_part({-1, 0.5}).frame, 0);
  EXPECT_EQ(move->within_part({48, 0.5}).fraction, 0);
}

TEST(Move, IsMovingWhereTheSpeedIsNotZeroAndNotWhereOnlyTheAccelerationIs) {
  const auto both = track_of({0, 100}, {5, 10, 7});
  const auto start = track_of({0, 100}, {5, 10, 0, 0});
  const auto jerks = track_of({0, 100}, {0, 10, 0});
  EXPECT_TRUE(is_moving(both.track(), RollEnd::before));
  EXPECT_TRUE(is_moving(both.track(), RollEnd::after));
  EXPECT_TRUE(is_moving(start.track(), RollEnd::before));
  EXPECT_FALSE(is_moving(start.track(), RollEnd::after));
  EXPECT_FALSE(is_moving(jerks.track(), RollEnd::before));
  const std::array tracks{jerks.track()};
  std::vector<AxisMotion> joint(1);
  EXPECT_FALSE(joints_of(std::span<const Track>(tracks), RollEnd::before, std::span(joint)));
  EXPECT_EQ(joint[0].acceleration, 0) << "it rests until frame 0";
}

TEST(Move, RefusesTracksOfDifferentTimesAndRollsThatDoNotJoin) {
  const auto one = track_of({0, 100}, {5, 10, 7});
  const auto longer = track_of({0, 100}, {5, 10, 7}, 49);
  const auto slower = track_of({0, 100}, {5, 10, 7}, 48, {25, 1});
  const auto code_of = [](const Result<Move>& move) { return move.error().code; };
  const std::array unequal{one.track(), longer.track()};
  EXPECT_EQ(code_of(Move::make(unequal, {})), ErrorCode::out_of_range);
  const std::array rates{one.track(), slower.track()};
  EXPECT_EQ(code_of(Move::make(rates, {})), ErrorCode::out_of_range);
  EXPECT_EQ(code_of(Move::make(std::span<const Track>(), {})), ErrorCode::wrong_count);

  const std::array pair{one.track(), one.track()};
  const std::span<const Track> tracks(pair);
  auto before = rolls_of(tracks, RollEnd::before, 12, 2);
  const auto after = rolls_of(tracks, RollEnd::after, 12, 2);
  EXPECT_TRUE(Move::make(tracks, {before, after}));
  EXPECT_EQ(code_of(Move::make(tracks, {std::span(before).first(1), after})), ErrorCode::wrong_count);
  EXPECT_EQ(code_of(Move::make(tracks, {after, {}})), ErrorCode::out_of_range) << "the wrong end";
  before[1] = rolls_of(tracks, RollEnd::before, 13, 2)[1];
  const auto refused = Move::make(tracks, {before, after});
  EXPECT_EQ(code_of(refused), ErrorCode::out_of_range) << "two numbers of frames";
  EXPECT_EQ(refused.error().axis, 1);
}

}  // namespace move_test
}  // namespace inbetween
