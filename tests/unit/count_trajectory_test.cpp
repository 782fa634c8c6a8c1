// A trajectory in whole counts of drives, evaluated in floats.
#include "inbetween/trajectory/count_trajectory.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "host_tools/plan/fitted_trajectory.hpp"
#include "host_tools/plan/plan.hpp"
#include "tests/support/count_trajectory.hpp"
#include "tests/support/even_pieces.hpp"
#include "tests/support/timing_kinds.hpp"

namespace inbetween {
namespace count_trajectory_test {

constexpr std::size_t axes = 2;
using Counts = std::array<std::int32_t, axes>;

/// 2^20 counts over what the track goes, on one axis forward and on the other one backward.
class EveryTimingInCounts : public testing::TestWithParam<TimingKind> {
 protected:
  EveryTimingInCounts() : plan_(move_of(GetParam()), std::nullopt, {}), fitted_(plan_.tracks()[0].track()) {
    std::array<AxisMotion, axes> samples;
    std::array<double, axes> travel;
    measure_travel(fitted_.sampler(), samples, travel);
    for (std::size_t d = 0; d < axes; ++d)
      scale_.push_back((d == 0 ? 1 : -1) * 1048576 / std::max(travel[d], 1e-3));
  }
  /// How far a position is from that of a trajectory, in counts.
  [[nodiscard]] double miss(CountTrajectory& counts, const Trajectory& trajectory,
                            const FloatFrameTime& time) const {
    std::array<double, axes> positions;
    trajectory.positions({time.frame, time.fraction}, positions);
    double most = 0;
    for (std::size_t d = 0; d < axes; ++d) {
      const CountTrajectory::Position found = counts.position(time, d);
      const double exact = positions[d] * scale_[d];
      most = std::max(most, std::fabs(found.base - exact + static_cast<double>(found.offset)));
    }
    return most;
  }
  [[nodiscard]] static FloatFrameTime time_at(double frame) {
    const double whole = std::floor(frame);
    return {static_cast<std::int32_t>(whole), static_cast<float>(frame - whole)};
  }

  Plan plan_;
  FittedTrajectory fitted_;
  std::vector<double> scale_;
};

TEST_P(EveryTimingInCounts, IsWithinATwentiethOfACountOfTwentyBits) {
  CountsOfTrajectory counts(*fitted_, scale_);
  Counts whole;
  for (int k = 0; k < 48 * 64; ++k) {
    const FloatFrameTime time = time_at(k * 0.6180339887 * 7 - 48 * std::floor(k * 0.6180339887 * 7 / 48));
    ASSERT_LE(miss(*counts, *fitted_, time), 0.05) << time.frame << " " << time.fraction;
    counts->counts(time, whole);
    for (std::size_t d = 0; d < axes; ++d) {
      const CountTrajectory::Position exact = counts->position(time, d);
      EXPECT_LE(std::fabs(exact.base - whole[d] + static_cast<double>(exact.offset)), 0.5 + 1e-6) << k;
    }
  }
}

TEST_P(EveryTimingInCounts, IsTheSameWhicheverPieceWasAskedForBefore) {
  CountsOfTrajectory forward(*fitted_, scale_);
  CountsOfTrajectory backward(*fitted_, scale_);
  CountsOfTrajectory jumping(*fitted_, scale_);
  constexpr int ticks = 48 * 20 + 80;
  std::vector<Counts> of_forward(ticks);
  const auto time_of = [](int k) { return time_at(k / 20.0 - 2); };
  for (int k = 0; k < ticks; ++k) forward->counts(time_of(k), of_forward[static_cast<std::size_t>(k)]);
  Counts other;
  for (int k = ticks; k-- > 0;) {
    backward->counts(time_of(k), other);
    EXPECT_EQ(other, of_forward[static_cast<std::size_t>(k)]) << k;
    const int jump = k * 377 % ticks;
    jumping->counts(time_of(jump), other);
    EXPECT_EQ(other, of_forward[static_cast<std::size_t>(jump)]) << jump;
  }
}

TEST_P(EveryTimingInCounts, StandsAtBothEndsOutsideThem) {
  const Trajectory part = fitted_->part({7, 0.25}, {31, 0.5});
  const FrameTime end = fitted_->end();
  for (const auto& [trajectory, first, last] :
       {std::tuple{*fitted_, FrameTime{}, end}, std::tuple{part, FrameTime{7, 0.25}, FrameTime{31, 0.5}}}) {
    CountsOfTrajectory counts(trajectory, scale_);
    for (const auto& [outside, place] : {std::pair{-3.0, first}, {1000.0, last}, {48.5, last}}) {
      Counts found;
      std::array<double, axes> positions;
      counts->counts(time_at(outside), found);
      trajectory.positions(place, positions);
      for (std::size_t d = 0; d < axes; ++d)
        EXPECT_LE(std::fabs(found[d] - positions[d] * scale_[d]), 0.51) << outside;
    }
    Counts at_end, beyond;
    counts->counts({last.frame, static_cast<float>(last.fraction)}, at_end);
    counts->counts({last.frame + 1, 0}, beyond);
    EXPECT_EQ(at_end, beyond);
  }
}

TEST_P(EveryTimingInCounts, APartOfItIsTheWholeWithinWhatAFloatKnows) {
  const Trajectory part = fitted_->part({7, 0.25}, {31, 0.5});
  CountsOfTrajectory counts(part, scale_);
  for (int k = 0; k < 400; ++k)
    EXPECT_LE(miss(*counts, *fitted_, time_at(7.25 + (31.5 - 7.25) * k / 400)), 0.05) << k;
}

TEST_P(EveryTimingInCounts, TellsWhatMemoryItTakes) {
  const Result<std::size_t> count = CountTrajectory::piece_count(*fitted_, scale_);
  ASSERT_TRUE(count.has_value());
  std::vector<CountTrajectoryPiece> pieces(*count);
  std::vector<CountPolynomial> polynomials(*count * axes);
  EXPECT_TRUE(CountTrajectory::make(*fitted_, scale_, {pieces, polynomials}).has_value());
  const auto small = CountTrajectory::make(*fitted_, scale_, {std::span(pieces).first(1), polynomials});
  ASSERT_FALSE(small.has_value());
  EXPECT_EQ(small.error().code, ErrorCode::capacity);
  EXPECT_EQ(small.error().needed, static_cast<std::int64_t>(*count));
}

INSTANTIATE_TEST_SUITE_P(Kinds, EveryTimingInCounts, testing::ValuesIn(timing_kinds()),
                         [](const auto& kind) { return kind.param.name; });

// --- what is refused, and what is as short as a float tells

TEST(CountTrajectory, APieceThatIsShorterThanAFloatTellsIsPassedAtItsBegin) {
  const double short_while = 0.5 + 1e-12;
  EvenPieces at_the_end({0, 0.5, short_while}, {0, 1, 11});
  EvenPieces between({0, 0.5, short_while, 1}, {0, 1, 11, 13});
  CountsOfTrajectory ended(at_the_end.made(), {100.0});
  CountsOfTrajectory goes_on(between.made(), {100.0});
  std::array<std::int32_t, 1> found;
  for (const auto& [frame, at_end, further] :
       {std::tuple{0.0F, 0, 0}, {0.25F, 50, 50}, {0.5F, 1100, 1100}, {0.75F, 1100, 1200}}) {
    ended->counts({0, frame}, found);
    EXPECT_EQ(found[0], at_end) << frame;
    goes_on->counts({0, frame}, found);
    EXPECT_EQ(found[0], further) << frame;
  }
}

// What a quintic cannot follow of it is a count and a half, so it is cut.
TEST(CountTrajectory, ASepticFromRestToRestIsFollowedByQuintics) {
  for (const double scale : {1.0, 512.0, 1.0 / 512}) {
    const std::array<double, 8> values{0, 0, 0, 0, 600 / scale, 0, 0, 0};
    const std::array<TrajectoryPiece, 1> pieces{
        {{.begin = {}, .inverse_frames = 1.0 / 24, .seconds = 1, .begin_row = 0, .end_row = 4, .degree = 7}}};
    std::array<std::uint32_t, 1> buckets{};
    const Trajectory trajectory = *Trajectory::make(
        {.axis_count = 1, .fps = {24, 1}, .end = {24, 0}, .pieces = pieces, .values = values}, buckets);
    CountsOfTrajectory counts(trajectory, {scale});
    std::array<double, 1> position;
    for (int k = 0; k < 24 * 16; ++k) {
      const FloatFrameTime time{k / 16, static_cast<float>(k % 16) / 16};
      trajectory.positions({time.frame, time.fraction}, position);
      const CountTrajectory::Position found = counts->position(time, 0);
      EXPECT_NEAR(found.base + static_cast<double>(found.offset), position[0] * scale, 0.02)
          << k << " at " << scale;
    }
  }
}

TEST(CountTrajectory, APieceThatIsMadeFromVelocitiesIsFollowed) {
  // The axis goes from rest to 40 in half a second.
  const std::array<double, 8> values{7, 0, 0, 0, 17, 40, 0, 0};
  const std::array<TrajectoryPiece, 1> pieces{
      {{.begin = {}, .inverse_frames = 1.0 / 12, .seconds = 0.5, .begin_row = 0, .end_row = 4, .degree = 6}}};
  std::array<std::uint32_t, 1> buckets{};
  const Trajectory trajectory = *Trajectory::make(
      {.axis_count = 1, .fps = {24, 1}, .end = {12, 0}, .pieces = pieces, .values = values}, buckets);
  CountsOfTrajectory counts(trajectory, {100.0});
  std::array<double, 1> position;
  for (int k = 0; k < 12 * 16; ++k) {
    const FloatFrameTime time{k / 16, static_cast<float>(k % 16) / 16};
    trajectory.positions({time.frame, time.fraction}, position);
    const CountTrajectory::Position found = counts->position(time, 0);
    EXPECT_NEAR(found.base + static_cast<double>(found.offset), position[0] * 100, 0.02) << k;
  }
}

TEST(CountTrajectory, RefusesCountsThatAreNone) {
  EvenPieces move({0, 1}, {0, 10});
  const auto error_of = [&](const std::vector<double>& scale) {
    const auto count = CountTrajectory::piece_count(move.made(), scale);
    return count ? Error{} : count.error();
  };
  EXPECT_EQ(error_of({}).code, ErrorCode::wrong_count);
  for (const double none : {0.0, std::numeric_limits<double>::infinity(), std::nan("")}) {
    EXPECT_EQ(error_of({none}).code, ErrorCode::out_of_range) << none;
    EXPECT_EQ(error_of({none}).axis, 0);
  }
  const Error far = error_of({2147483647.0});
  EXPECT_EQ(far.code, ErrorCode::out_of_range);
  EXPECT_STREQ(far.what, "a position does not fit 32 bits of counts");
}

}  // namespace count_trajectory_test
}  // namespace inbetween
