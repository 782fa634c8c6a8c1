// Rows that were rounded, as the motion that they were rounded from; rows that are wrong, by name.
#include "host_tools/fit/row_smoothing.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace inbetween {
namespace row_smoothing_test {

using testing::ElementsAre;
using testing::IsEmpty;

/// Minimum jerk from 0 to `reach` (Flash and Hogan 1985).
std::vector<double> ease(std::size_t frames, double reach) {
  std::vector<double> rows;
  for (std::size_t frame = 0; frame <= frames; ++frame) {
    const double t = static_cast<double>(frame) / static_cast<double>(frames);
    rows.push_back(reach * t * t * t * (10 - 15 * t + 6 * t * t));
  }
  return rows;
}

std::vector<double> rounded(std::vector<double> rows, double resolution) {
  for (double& row : rows) row = std::round(row / resolution) * resolution;
  return rows;
}

double largest_change(const std::vector<double>& one, const std::vector<double>& other) {
  double largest = 0;
  for (std::size_t row = 0; row < one.size(); ++row)
    largest = std::max(largest, std::fabs(one[row] - other[row]));
  return largest;
}

/// A motion that goes on through all rows, at up to 4 a row.
std::vector<double> waves() {
  std::vector<double> rows;
  for (int row = 0; row < 120; ++row) rows.push_back(40 * std::sin(row / 12.0) + 10 * std::cos(row / 20.0));
  return rows;
}

std::vector<std::size_t> rows_of(const std::vector<RowSpike>& spikes) {
  std::vector<std::size_t> rows;
  for (const RowSpike& spike : spikes) rows.insert(rows.end(), {spike.first, spike.count});
  return rows;
}

TEST(RowSmoothing, AStaircaseOfWholeDegreesIsTheEaseThatItWasRoundedFrom) {
  const std::vector<double> clean = ease(150, 50);
  const std::vector<double> stairs = rounded(clean, 1);
  EXPECT_GT(largest_second_difference(stairs), 70 * largest_second_difference(clean));
  const SmoothRows smooth = smooth_rows(stairs, 1);
  EXPECT_LE(largest_change(smooth.rows, stairs), 0.5 + 1e-9);
  EXPECT_LT(largest_second_difference(smooth.rows), 1.1 * largest_second_difference(clean));
  EXPECT_THAT(smooth.spikes, IsEmpty());
  EXPECT_EQ(smooth.rows.front(), 0);
  EXPECT_EQ(smooth.rows[1], 0);
  EXPECT_EQ(smooth.rows.back(), 50);
}

TEST(RowSmoothing, AHoldStaysWhereItIs) {
  std::vector<double> clean = ease(40, 23.3);
  clean.insert(clean.end(), 40, 23.3);
  const std::vector<double> back = ease(30, 23.3);
  clean.insert(clean.end(), back.rbegin(), back.rend());
  const std::vector<double> rows = rounded(clean, 0.5);
  const SmoothRows smooth = smooth_rows(rows, 0.5);
  for (std::size_t row = 46; row < 76; ++row) EXPECT_EQ(smooth.rows[row], 23.5) << row;
  EXPECT_LT(largest_second_difference(smooth.rows), 1.3 * largest_second_difference(clean));
  EXPECT_THAT(smooth.spikes, IsEmpty());
}

TEST(RowSmoothing, ASlowMotionIsNoHold) {
  std::vector<double> rows;
  for (int row = 0; row < 300; ++row) rows.push_back(std::round(0.04 * row));
  EXPECT_LT(largest_second_difference(smooth_rows(rows, 1).rows), 0.02);
}

TEST(RowSmoothing, RowsAtAnEndOfTheRangeStayInIt) {
  std::vector<double> rows;
  for (int row = 0; row < 60; ++row)
    rows.push_back(std::clamp(std::round(20 * std::sin(row / 8.0)), -10.0, 10.0));
  const SmoothRows smooth = smooth_rows(rows, 1, {-10, 10});
  EXPECT_LE(*std::ranges::max_element(smooth.rows), 10);
  EXPECT_GE(*std::ranges::min_element(smooth.rows), -10);
  const SmoothRows unbounded = smooth_rows(rows, 1);
  EXPECT_GT(*std::ranges::max_element(unbounded.rows), 10) << "the range is what keeps them";
}

TEST(RowSmoothing, ASpikeIsNamedAndFollowsTheMotionAroundIt) {
  const std::vector<double> clean = waves();
  std::vector<double> rows = rounded(clean, 0.1);
  rows[47] += 3;
  const SmoothRows smooth = smooth_rows(rows, 0.1);
  ASSERT_THAT(rows_of(smooth.spikes), ElementsAre(47, 1));
  EXPECT_NEAR(smooth.spikes[0].off, 3, 0.1);
  EXPECT_NEAR(smooth.rows[47], clean[47], 0.1);
}

TEST(RowSmoothing, ASpikeIsNamedAtEitherEndAsWell) {
  std::vector<double> rows = rounded(waves(), 0.1);
  rows.front() -= 5;
  rows.back() += 5;
  EXPECT_THAT(rows_of(smooth_rows(rows, 0.1).spikes), ElementsAre(0, 1, 119, 1));
}

TEST(RowSmoothing, RowsThatRepeatWhileTheAxisGoesOnAreNamed) {
  std::vector<double> rows = rounded(waves(), 0.1);
  rows[61] = rows[62] = rows[63] = rows[60];
  const SmoothRows smooth = smooth_rows(rows, 0.1);
  EXPECT_THAT(rows_of(smooth.spikes), ElementsAre(61, 3));
}

TEST(RowSmoothing, CornersAndFastPassagesAreNoSpikes) {
  std::vector<double> rows(20, 0);
  for (int row = 0; row < 20; ++row) rows.push_back(5 * row);              // a corner
  for (int row = 0; row < 10; ++row) rows.push_back(95);                   // and another
  for (const double hit : {105, 125, 135, 125, 105}) rows.push_back(hit);  // there and back in six frames
  rows.insert(rows.end(), 20, 95);
  EXPECT_THAT(smooth_rows(rows, 0.01).spikes, IsEmpty());
}

TEST(RowSmoothing, TwoEqualRowsOfAnEvenMotionAreNoRest) {
  std::vector<double> rows;
  for (int row = 0; row < 100; ++row) rows.push_back(std::round(0.45 * row));
  ASSERT_EQ(rows[0], rows[1]);
  EXPECT_LT(largest_second_difference(smooth_rows(rows, 1).rows), 0.01) << "a rest there would be a jolt";
}

TEST(RowSmoothing, RowsWithoutRoundingStayAsTheyAre) {
  const std::vector<double> clean = waves();
  EXPECT_LT(largest_change(smooth_rows(clean, 1e-6).rows, clean), 5.1e-7);
  EXPECT_THAT(smooth_rows(std::vector{1.0, 2.0, 4.0}, 1).rows, ElementsAre(1, 2, 4));
}

}  // namespace row_smoothing_test
}  // namespace inbetween
