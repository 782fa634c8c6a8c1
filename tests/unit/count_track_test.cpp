#include "inbetween/timing/count_track.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "host_tools/plan/solved_track.hpp"

namespace inbetween {
namespace count_track_test {

constexpr double twenty_bits = 1048576.0;

struct Drawn {
  Spline spline = Spline::smooth;
  bool closed = false;
  std::int32_t axes = 1;
  std::vector<double> keys;
  std::vector<KeyShape<double>> shapes = {};
  std::vector<double> speed{10.0};
  std::int32_t frames = 48;
};

template <Precise Real = double>
SolvedTrack<Real> solved(const Drawn& move) {
  const std::vector<Real> keys(move.keys.begin(), move.keys.end());
  const std::vector<Real> speed(move.speed.begin(), move.speed.end());
  std::vector<KeyShape<Real>> shapes;
  for (const KeyShape<double>& shape : move.shapes) {
    shapes.push_back({static_cast<Real>(shape.tension), static_cast<Real>(shape.continuity),
                      static_cast<Real>(shape.bias)});
  }
  TrackSpec<Real> spec;
  spec.path = {
      .spline = move.spline, .closed = move.closed, .axis_count = move.axes, .keys = keys, .shapes = shapes};
  spec.control_values = speed;
  spec.frames = move.frames;
  spec.fps = {24, 1};
  return SolvedTrack<Real>(spec, Solver::closed_form);
}

/// A count track with exactly the memory that it asks for.
template <Precise Real>
struct Counting {
  std::vector<CountPortion<Real>> portions;
  std::vector<CountSpan<Real>> spans;
  std::vector<CountPiece<Real>> pieces;
  std::vector<CountCubic<Real>> cubics;
  std::optional<CountTrack<Real>> track;

  template <Precise Source>
  Counting(const Track<Source>& source, const std::vector<double>& counts_per_unit) {
    const CountSizes sizes = count_sizes<Real>(source);
    portions.resize(sizes.portions + 1);
    spans.resize(sizes.spans);
    pieces.resize(sizes.pieces + 1);
    cubics.resize(pieces.size() * static_cast<std::size_t>(source.path().axis_count()));
    const auto made = CountTrack<Real>::make(source, counts_per_unit, memory());
    if (made) track = *made;
  }
  CountTrackMemory<Real> memory() { return {portions, spans, pieces, cubics}; }

  [[nodiscard]] double at(const FrameTime<Real>& time, std::int32_t axis) const {
    const CountPosition<Real> position = track->position(time, axis);
    return position.base + static_cast<double>(position.offset);
  }
  [[nodiscard]] std::vector<std::int32_t> counts(const FrameTime<Real>& time) const {
    std::vector<std::int32_t> result(static_cast<std::size_t>(track->axis_count()));
    track->counts(time, result);
    return result;
  }
};

/// How far an axis goes from its least to its largest position.
double travel(const Track<double>& track, std::int32_t axis) {
  double least = std::numeric_limits<double>::infinity();
  double largest = -least;
  std::vector<double> positions(static_cast<std::size_t>(track.path().axis_count()));
  for (std::int32_t eighth = 0; eighth <= 8 * track.frames(); ++eighth) {
    track.positions({eighth / 8, (eighth % 8) / 8.0}, positions);
    least = std::min(least, positions[static_cast<std::size_t>(axis)]);
    largest = std::max(largest, positions[static_cast<std::size_t>(axis)]);
  }
  return largest - least;
}

/// The largest difference from the track in double, in counts, over ticks at a rate that does not divide the
/// frames evenly.
template <Precise Real>
double worst_error(const Track<double>& track, const Counting<Real>& counting, double counts_per_unit) {
  constexpr std::int32_t rate_hz = 250;
  double worst = 0;
  std::vector<double> positions(static_cast<std::size_t>(track.path().axis_count()));
  for (std::int64_t tick = 0; tick <= last_tick(track.frames(), track.frame_rate(), rate_hz); ++tick) {
    track.positions(frame_time_of_tick<double>(tick, track.frame_rate(), rate_hz), positions);
    const auto time = frame_time_of_tick<Real>(tick, track.frame_rate(), rate_hz);
    for (std::size_t d = 0; d < positions.size(); ++d) {
      const double expected = positions[d] * counts_per_unit;
      const double error = std::fabs(counting.at(time, static_cast<std::int32_t>(d)) - expected);
      if (!(error <= worst)) worst = error;
    }
  }
  return worst;
}

/// Whole numbers up to a thousand, every kind, some moves with fewer frames than spans, some with keys at
/// which the path stands still.
Drawn random_drawn(std::mt19937& random) {
  const auto number = [&](int below) { return static_cast<int>(random() % static_cast<unsigned>(below)); };
  Drawn move;
  move.spline = static_cast<Spline>(number(4));
  move.closed = number(4) == 0;
  move.axes = 1 + number(3);
  const int key_count = 2 + number(6);
  for (int i = 0; i < key_count * move.axes; ++i) move.keys.push_back(number(1001) - 500);
  if (move.spline == Spline::tcb) {
    for (int i = 0; i < key_count; ++i) {
      move.shapes.push_back({.tension = number(3) == 0 ? 1.0 : number(10) / 10.0,
                             .continuity = number(10) / 20.0,
                             .bias = number(10) / 20.0});
    }
  }
  move.speed.resize(static_cast<std::size_t>(1 + number(30)));
  for (double& value : move.speed) value = number(20);
  move.speed[move.speed.size() / 2] += 1;
  move.frames = 12 + (number(4) == 0 ? number(40) : number(400));
  return move;
}

/// The weighted length over the longest way of an axis.
double windings(const Track<double>& track, double longest) {
  return track.arc_length().total() / longest;
}

TEST(CountTrack, IsWithinATenthOfACountOfTwentyBits) {
  std::mt19937 random(1989);
  double worst = 0;
  int tried = 0;
  for (int i = 0; i < 600; ++i) {
    const Drawn move = random_drawn(random);
    const SolvedTrack<double> source = solved(move);
    double longest = 0;
    for (std::int32_t d = 0; d < move.axes; ++d) longest = std::max(longest, travel(source.track(), d));
    if (longest < 1 || windings(source.track(), longest) > 8) continue;
    const double scale = twenty_bits / longest;
    const Counting<float> counting(source.track(),
                                   std::vector<double>(static_cast<std::size_t>(move.axes), scale));
    ASSERT_TRUE(counting.track);
    const double error = worst_error(source.track(), counting, scale);
    ASSERT_LE(error, 0.1) << "move " << i << " with " << move.keys.size() << " coordinates";
    worst = std::max(worst, error);
    ++tried;
  }
  EXPECT_GE(tried, 500);
  RecordProperty("worst_count_error", std::to_string(worst));
}

TEST(CountTrack, InDoubleIsTheTrackItself) {
  std::mt19937 random(7);
  for (int i = 0; i < 100; ++i) {
    const Drawn move = random_drawn(random);
    const SolvedTrack<double> source = solved(move);
    const Counting<double> counting(source.track(),
                                    std::vector<double>(static_cast<std::size_t>(move.axes), 1000.0));
    ASSERT_TRUE(counting.track);
    ASSERT_LE(worst_error(source.track(), counting, 1000.0), 1e-5) << "move " << i;
  }
}

/// The same path, a sixth of 2^20 counts from key to key, in other ways of timing.
class CountTrackTimedOtherwise : public testing::Test {
 protected:
  static constexpr std::int32_t frames = 100;
  static constexpr double scale = twenty_bits / 600;

  [[nodiscard]] Track<double> with_breaks(std::span<const BreakKey> breaks) {
    const Track<double>& drawn = drawn_.track();
    return *Track<double>::make_with_breaks(drawn.path(), drawn.arc_length(), drawn.profile(), frames,
                                            {24, 1}, breaks,
                                            {.span_distances = span_distances_, .portions = portions_});
  }
  [[nodiscard]] Track<double> with_key_frames(std::span<const std::int32_t> key_frames, Kinetic kinetic) {
    const Track<double>& drawn = drawn_.track();
    return *Track<double>::make_with_key_frames(drawn.path(), drawn.arc_length(), key_frames, kinetic, frames,
                                                {24, 1}, {.key_intervals = key_intervals_});
  }
  template <Precise Real>
  static double error_of(const Track<double>& track) {
    const Counting<Real> counting(track, {scale, scale});
    EXPECT_TRUE(counting.track);
    return counting.track ? worst_error(track, counting, scale) : twenty_bits;
  }

 private:
  SolvedTrack<double> drawn_ = solved({.axes = 2,
                                       .keys = {0, 0, 100, 50, 200, 200, 350, 210, 500, 300, 600, 600},
                                       .speed = {0, 0, 4, 9, 3, 3, 8, 0, 0},
                                       .frames = frames});
  std::array<SpanDistance<double>, 9> span_distances_;
  std::array<Portion<double>, 3> portions_;
  std::array<KeyInterval<double>, 5> key_intervals_;
};

TEST_F(CountTrackTimedOtherwise, KeepsTheSpeedOfEveryPortionBetweenBreaks) {
  // On a border of spans, inside one, and on frames next to each other.
  for (const auto& breaks :
       {std::array<BreakKey, 2>{{{1, 25}, {3, 50}}}, std::array<BreakKey, 2>{{{2, 31}, {4, 88}}},
        std::array<BreakKey, 2>{{{2, 60}, {3, 61}}}}) {
    const Track<double> track = with_breaks(breaks);
    EXPECT_LE(error_of<float>(track), 0.1) << "breaks on " << breaks[0].frame << " and " << breaks[1].frame;
    EXPECT_LE(error_of<double>(track), 1e-5);
  }
}

TEST_F(CountTrackTimedOtherwise, KeepsTheFramesOfKeys) {
  for (const Kinetic kinetic : {Kinetic::linear, Kinetic::monotone}) {
    for (const auto& key_frames : {std::array<std::int32_t, 6>{0, 20, 40, 60, 80, 100},
                                   std::array<std::int32_t, 6>{0, 1, 2, 50, 99, 100}}) {
      const Track<double> track = with_key_frames(key_frames, kinetic);
      EXPECT_LE(error_of<float>(track), 0.1);
      EXPECT_LE(error_of<double>(track), 1e-5);
    }
  }
}

TEST(CountTrack, OfAFewFramesIsAsGoodAsAFractionOfAFrame) {
  std::mt19937 random(12);
  for (int i = 0; i < 200; ++i) {
    Drawn move = random_drawn(random);
    move.frames = 1 + i % 10;
    const SolvedTrack<double> source = solved(move);
    // Half a rounding of the fraction, and as much again in working with it.
    const double length = source.track().arc_length().total();
    const double scale = twenty_bits / std::max(length, 1.0);
    const Counting<float> counting(source.track(),
                                   std::vector<double>(static_cast<std::size_t>(move.axes), scale));
    ASSERT_TRUE(counting.track);
    ASSERT_LE(worst_error(source.track(), counting, scale), 0.2) << "move " << i;
  }
}

TEST(CountTrack, IsAsGoodFarFromZero) {
  Drawn move{.keys = {0, 300, 1000, 400}, .speed = {0, 0, 8, 3, 0, 0}, .frames = 100};
  for (double& key : move.keys) key += 1'900'000;
  const SolvedTrack<double> source = solved(move);
  const double scale = 1000;  // keys near 1.9e9 of the 2.1e9 counts that 32 bits hold
  const Counting<float> counting(source.track(), {scale});
  ASSERT_TRUE(counting.track);
  EXPECT_LE(worst_error(source.track(), counting, scale), 0.1);
}

TEST(CountTrack, FromATrackInSinglePrecisionIsWithinThatTracksOwnError) {
  const Drawn move{.axes = 2, .keys = {0, 0, 300, 200, 500, 900, 1000, 1000}, .speed = {0, 0, 8, 3, 9, 0, 0}};
  const SolvedTrack<double> reference = solved(move);
  const SolvedTrack<float> source = solved<float>(move);
  const double scale = twenty_bits / 1000;
  const Counting<float> counting(source.track(), {scale, scale});
  ASSERT_TRUE(counting.track);
  EXPECT_LE(worst_error(reference.track(), counting, scale), 1.0);
}

TEST(CountTrack, CountsAreThePositionRounded) {
  const Drawn move{.axes = 2, .keys = {0, 0, 30.3, 20.1, -50.7, 90.4}, .speed = {0, 0, 8, 3, 9, 0, 0}};
  const SolvedTrack<double> source = solved(move);
  const Counting<float> counting(source.track(), {100.0, -333.0});
  ASSERT_TRUE(counting.track);
  for (std::int32_t tenth = 0; tenth < 10 * move.frames; ++tenth) {
    const FrameTime<float> time{tenth / 10, static_cast<float>(tenth % 10) / 10.0F};
    const std::vector<std::int32_t> counts = counting.counts(time);
    for (std::int32_t d = 0; d < 2; ++d) {
      EXPECT_LE(std::fabs(counts[static_cast<std::size_t>(d)] - counting.at(time, d)), 0.5 + 1e-4);
    }
  }
}

TEST(CountTrack, StandsOnTheFirstKeyBeforeAndOnTheLastAfterTheMove) {
  const Drawn move{.axes = 2, .keys = {1.5, -2, 30, 20, 77, 8.25}, .speed = {5, 9}, .frames = 24};
  const SolvedTrack<double> source = solved(move);
  const Counting<float> counting(source.track(), {1000.0, 4.0});
  ASSERT_TRUE(counting.track);
  for (const FrameTime<float> before : {FrameTime<float>{0, 0}, {-1, 0.5F}, {-1000000, 0}}) {
    EXPECT_EQ(counting.counts(before), (std::vector<std::int32_t>{1500, -8}));
  }
  for (const FrameTime<float> after : {FrameTime<float>{24, 0}, {24, 0.5F}, {1000000, 0}}) {
    EXPECT_EQ(counting.counts(after), (std::vector<std::int32_t>{77000, 33}));
  }
}

TEST(CountTrack, ANegativeScaleTurnsTheAxisRound) {
  const Drawn move{.keys = {0, 100, 250}};
  const SolvedTrack<double> source = solved(move);
  const Counting<float> forward(source.track(), {40.0});
  const Counting<float> backward(source.track(), {-40.0});
  ASSERT_TRUE(forward.track && backward.track);
  for (std::int32_t frame = 0; frame <= move.frames; ++frame) {
    EXPECT_EQ(forward.counts({frame, 0}).at(0), -backward.counts({frame, 0}).at(0));
  }
}

TEST(CountTrack, OfOneKeyStaysThere) {
  const Drawn move{.axes = 3, .keys = {1, 2, -3}};
  const SolvedTrack<double> source = solved(move);
  const Counting<float> counting(source.track(), {10.0, 10.0, 10.0});
  ASSERT_TRUE(counting.track);
  for (const std::int32_t frame : {-1, 0, 1, 47, 48, 49}) {
    EXPECT_EQ(counting.counts({frame, 0.5F}), (std::vector<std::int32_t>{10, 20, -30}));
  }
}

TEST(CountTrack, RestsWhereTheSpeedCurveIsZero) {
  const Drawn move{.keys = {0, 100}, .speed = {9, 0, 0, 0, 0, 0, 9}, .frames = 60};
  const SolvedTrack<double> source = solved(move);
  const Counting<float> counting(source.track(), {1000.0});
  ASSERT_TRUE(counting.track);
  const std::int32_t resting = counting.counts({25, 0}).at(0);
  for (std::int32_t frame = 20; frame <= 40; ++frame) EXPECT_EQ(counting.counts({frame, 0}).at(0), resting);
}

/// What a refusal says.
template <Precise Real>
Error refusal(const SolvedTrack<double>& source, const std::vector<double>& counts_per_unit,
              const CountTrackMemory<Real>& memory) {
  const auto made = CountTrack<Real>::make(source.track(), counts_per_unit, memory);
  return made ? Error{.what = "made"} : made.error();
}

TEST(CountTrack, RefusesCountsThatAreNone) {
  const SolvedTrack<double> source = solved(Drawn{.axes = 2, .keys = {0, 0, 10, 20}});
  Counting<float> room(source.track(), {1.0, 1.0});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refusal(source, {1.0}, room.memory()).code, ErrorCode::wrong_count);
  EXPECT_EQ(refusal(source, {1.0, 2.0, 3.0}, room.memory()).code, ErrorCode::wrong_count);
  EXPECT_EQ(refusal(source, {1.0, nan}, room.memory()).code, ErrorCode::not_finite);
  EXPECT_EQ(refusal(source, {1.0, nan}, room.memory()).axis, 1);
  EXPECT_EQ(refusal(source, {0.0, 1.0}, room.memory()).code, ErrorCode::out_of_range);
  EXPECT_EQ(refusal(source, {0.0, 1.0}, room.memory()).axis, 0);
}

TEST(CountTrack, RefusesPositionsThatDoNotFit32Bits) {
  const SolvedTrack<double> source = solved(Drawn{.axes = 2, .keys = {0, 0, 0, 1000, 0, 3000}});
  Counting<double> room(source.track(), {1.0, 1.0});
  EXPECT_STREQ(refusal(source, {1e6, 7e5}, room.memory()).what, "made");
  const Error error = refusal(source, {1.0, 8e5}, room.memory());
  EXPECT_EQ(error.code, ErrorCode::out_of_range);
  EXPECT_EQ(error.key, 1);
  EXPECT_EQ(error.axis, 1);
  EXPECT_EQ(refusal(source, {1.0, -8e5}, room.memory()).code, ErrorCode::out_of_range);
  EXPECT_EQ(refusal(source, {1.0, 1e300}, room.memory()).code, ErrorCode::out_of_range);
}

TEST(CountTrack, RefusesInSinglePrecisionPiecesLongerThanItsWholeNumbers) {
  const SolvedTrack<double> source = solved(Drawn{.spline = Spline::linear, .keys = {0, 1000}});
  Counting<float> room(source.track(), {1.0});
  EXPECT_STREQ(refusal(source, {10'000.0}, room.memory()).what, "made");
  EXPECT_EQ(refusal(source, {100'000.0}, room.memory()).code, ErrorCode::out_of_range);
}

TEST(CountTrack, SaysWhichMemoryItNeeds) {
  const SolvedTrack<double> source =
      solved(Drawn{.axes = 2, .keys = {0, 0, 10, 20, 5, 50}, .speed = {1, 2, 3, 4}});
  Counting<float> room(source.track(), {1.0, 1.0});
  const CountTrackMemory<float> enough = room.memory();
  EXPECT_STREQ(refusal(source, {1.0, 1.0}, enough).what, "made");
  CountTrackMemory<float> memory = enough;
  memory.portions = enough.portions.first(1);
  EXPECT_EQ(refusal(source, {1.0, 1.0}, memory).needed, 2);
  memory = enough;
  memory.spans = enough.spans.first(enough.spans.size() - 1);
  EXPECT_EQ(refusal(source, {1.0, 1.0}, memory).code, ErrorCode::capacity);
  EXPECT_EQ(refusal(source, {1.0, 1.0}, memory).needed, static_cast<std::int64_t>(enough.spans.size()));
  memory = enough;
  memory.pieces = enough.pieces.first(enough.pieces.size() - 1);
  EXPECT_EQ(refusal(source, {1.0, 1.0}, memory).needed, static_cast<std::int64_t>(enough.pieces.size()));
  memory = enough;
  memory.cubics = enough.cubics.first(enough.cubics.size() - 1);
  EXPECT_EQ(refusal(source, {1.0, 1.0}, memory).needed, static_cast<std::int64_t>(enough.cubics.size()));
}

TEST(CountTrack, CutsShortCurvesOnly) {
  EXPECT_EQ(count_span_count<float>(1), 64);
  EXPECT_EQ(count_span_count<float>(3), 96);
  EXPECT_EQ(count_span_count<float>(63), 126);
  EXPECT_EQ(count_span_count<float>(64), 64);
  EXPECT_EQ(count_span_count<float>(1000), 1000);
  EXPECT_EQ(count_span_count<double>(3), 192);
}

}  // namespace count_track_test
}  // namespace inbetween
