#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "inbetween/path/arc_length.hpp"
#include "inbetween/path/path.hpp"

namespace inbetween {
namespace path_of_cubics_test {

/// One axis that goes as t^2 over two halves of a distance, and a guide that goes evenly from 0 to 3.
struct Halves {
  std::vector<Cubic> cubics = {{0, 0, 0.25, 0}, {0, 1.5, 0, 0}, {0.25, 0.5, 0.25, 0}, {1.5, 1.5, 0, 0}};
  std::vector<double> weights = {0, 1};
  std::vector<FrameKnot> knots = {{.key = 0, .part = 0, .parts = 2}, {.key = 0, .part = 1, .parts = 2}};
  std::int32_t key_count = 2;
  std::array<Cubic, 6> cubic_memory{};
  std::array<double, 2> weight_memory{};
  std::array<FrameKnot, 2> knot_memory{};

  Result<Path> make() {
    return Path::make_of_cubics(
        {.axis_count = 1, .key_count = key_count, .cubics = cubics, .weights = weights, .knots = knots},
        {cubic_memory, weight_memory, knot_memory});
  }
  ErrorCode error() {
    const auto made = make();
    EXPECT_FALSE(made);
    return made ? ErrorCode{} : made.error().code;
  }
};

TEST(PathOfCubics, TheGuideIsTheDistanceAndTheAxisFollows) {
  Halves halves;
  const auto path = halves.make();
  ASSERT_TRUE(path) << path.error().what;
  EXPECT_EQ(path->axis_count(), 1);
  EXPECT_EQ(path->segment_count(), 2);
  EXPECT_EQ(path->key_at(0), 0);
  EXPECT_EQ(path->key_at(1), std::nullopt);
  EXPECT_EQ(path->key_at(2), 1);
  EXPECT_FALSE(path->over_frames());
  EXPECT_DOUBLE_EQ(path->parameter({1, 0.5}), 0.75);
  ArcLengthStorage<2> storage;
  const auto length = ArcLength::make(*path, {}, storage.memory());
  ASSERT_TRUE(length);
  EXPECT_DOUBLE_EQ(length->total(), 3);
  const PathPoint point = length->locate({2.25, 0});
  EXPECT_NEAR(path->position(point, 0), 0.75 * 0.75, 1e-12);
  EXPECT_DOUBLE_EQ(path->position({2, 0}, 0), 1);
}

TEST(PathOfCubics, WhatDoesNotGoTogetherIsRefused) {
  Halves gap;
  gap.cubics[2].c0 = 0.26;
  EXPECT_EQ(gap.error(), ErrorCode::no_solution);
  Halves missing_part;
  missing_part.knots[1].part = 0;
  EXPECT_EQ(missing_part.error(), ErrorCode::out_of_range);
  Halves too_long;
  too_long.knots[1].length = 2;
  EXPECT_EQ(too_long.error(), ErrorCode::out_of_range);
  Halves missing_key;
  missing_key.key_count = 3;
  EXPECT_EQ(missing_key.error(), ErrorCode::out_of_range);
  Halves no_guide;
  no_guide.weights = {0, 0};
  EXPECT_EQ(no_guide.error(), ErrorCode::unmeasured);
  Halves not_a_number;
  not_a_number.cubics[3].c1 = std::nan("");
  EXPECT_EQ(not_a_number.error(), ErrorCode::not_finite);
  Halves too_few;
  too_few.knots.pop_back();
  EXPECT_EQ(too_few.error(), ErrorCode::wrong_count);
}

}  // namespace path_of_cubics_test
}  // namespace inbetween
