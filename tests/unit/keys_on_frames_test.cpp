// Rows as keys on frames: the keys that a curve has, where it holds, and where there is no curve.
#include "host_tools/fit/keys_on_frames.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "inbetween/path/path.hpp"

namespace inbetween {
namespace keys_on_frames_test {

using testing::ElementsAre;
using testing::Lt;

/// What the core plays of keys on frames, one axis.
std::vector<double> rows_through(const std::vector<std::int32_t>& frames, const std::vector<double>& at,
                                 bool start = true, bool end = true) {
  std::array<Cubic, 200> cubics{};
  std::array<double, 4> weights{};
  std::array<FrameKnot, 100> knots{};
  const auto path = Path::make(
      {.axis_count = 1, .keys = at, .key_frames = frames, .rests_at_start = start, .rests_at_end = end},
      {cubics, weights, knots});
  if (!path) throw std::logic_error("the keys are no path");
  std::vector<double> rows;
  for (std::int32_t segment = 0; segment < path->segment_count(); ++segment) {
    const auto frame_at = [&](double t) {
      const double s = path->knots()[static_cast<std::size_t>(segment)].parameter(t);
      const auto key = std::min(static_cast<std::size_t>(s), frames.size() - 2);
      return frames[key] + (s - static_cast<double>(key)) * (frames[key + 1] - frames[key]);
    };
    const double begin = frame_at(0), size = frame_at(1) - begin;
    for (auto frame = static_cast<std::int32_t>(rows.size()); frame <= begin + size + 1e-9; ++frame)
      rows.push_back(path->position({segment, (frame - begin) / size}, 0));
  }
  return rows;
}

KeysOnFrames fitted(const std::vector<double>& rows, double tolerance) {
  return keys_on_frames({.rows = {rows}, .tolerances = {tolerance}}, 6, [](double) {});
}

double largest_miss(const std::vector<double>& rows, const KeysOnFrames& keys) {
  std::vector<double> at;
  for (const std::vector<double>& key : keys.at) at.push_back(key[0]);
  const std::vector<double> played = rows_through(keys.frames, at, keys.rests_at_start, keys.rests_at_end);
  double largest = 0;
  for (std::size_t row = 0; row < rows.size(); ++row)
    largest = std::max(largest, std::fabs(played[row] - rows[row]));
  return largest;
}

TEST(KeysOnFrames, OnlyTheKeysOfACurveAreNeeded) {
  const std::vector<double> rows = rows_through({0, 31, 50, 96, 120}, {0, 40, 25, -30, 10});
  ASSERT_EQ(rows.size(), 121U);
  const KeysOnFrames keys = fitted(rows, 0.01);
  EXPECT_LE(keys.frames.size(), 7U);
  EXPECT_LE(largest_miss(rows, keys), 0.01);
  EXPECT_TRUE(keys.rests_at_start);
  EXPECT_TRUE(keys.rests_at_end);
}

TEST(KeysOnFrames, EndsThatGoOnDoNotRest) {
  const std::vector<double> rows = rows_through({0, 30, 60}, {0, 40, 25}, false, true);
  const KeysOnFrames keys = fitted(rows, 0.01);
  EXPECT_FALSE(keys.rests_at_start);
  EXPECT_TRUE(keys.rests_at_end);
  EXPECT_LE(largest_miss(rows, keys), 0.01);
  EXPECT_LE(keys.frames.size(), 5U);
}

TEST(KeysOnFrames, AHoldHasAKeyOnEitherSide) {
  const std::vector<double> rows = rows_through({0, 40, 70, 100}, {0, 25, 25, 5});
  const KeysOnFrames keys = fitted(rows, 0.01);
  EXPECT_THAT(keys.frames, testing::IsSupersetOf({0, 40, 70, 100}));
  EXPECT_LE(keys.frames.size(), 6U);
  for (std::size_t k = 0; k < keys.frames.size(); ++k) {
    if (keys.frames[k] == 40 || keys.frames[k] == 70) {
      EXPECT_EQ(keys.at[k][0], 25);
    }
  }
}

TEST(KeysOnFrames, RowsThatNeverMoveAreTwoKeys) {
  EXPECT_THAT(fitted(std::vector<double>(50, 3.0), 0.1).frames, ElementsAre(0, 49));
}

TEST(KeysOnFrames, NoiseGetsAKeyOnEveryFrameAndMissesNothing) {
  std::vector<double> rows = {0, 0, 5, -3, 8, 1, 1.5, -7, 2, 9, 4, 4};
  const KeysOnFrames keys = fitted(rows, 1e-6);
  EXPECT_EQ(keys.frames.size(), rows.size());
  EXPECT_LE(largest_miss(rows, keys), 1e-6);
}

TEST(KeysOnFrames, ManyKeysAreStillFewerThanRows) {
  std::vector<double> rows;
  for (int row = 0; row <= 4000; ++row) rows.push_back(50 * std::sin(row / 9.0) + 20 * std::sin(row / 31.0));
  const KeysOnFrames keys = fitted(rows, 0.05);
  EXPECT_THAT(keys.frames.size(), Lt(900U)) << "five keys a wave";
  EXPECT_LE(keys.worst, 1);
}

}  // namespace keys_on_frames_test
}  // namespace inbetween
