// Random motions, rounded: no spike is named where none is, and one that is there never plays.
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "host_tools/fit/row_smoothing.hpp"
#include "tests/support/property.hpp"

namespace inbetween {
namespace row_smoothing_property_test {

struct RoundedMotion {
  std::vector<double> clean, rows;
  double resolution = 1;
  std::mt19937 random;

  [[nodiscard]] double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  }
  [[nodiscard]] std::size_t whole(std::size_t low, std::size_t high) {
    return std::uniform_int_distribution<std::size_t>(low, high)(random);
  }
};

/// Two waves on a ramp, 200 to 100 000 steps of the resolution high. Where they are fastest they take ten
/// rows or more for a wave.
RoundedMotion random_motion() {
  RoundedMotion motion;
  motion.random.seed(
      static_cast<std::uint32_t>(*rc::gen::resize(rc::kNominalSize, rc::gen::inRange(0, 1'000'000'000))));
  motion.resolution = std::pow(10, -static_cast<double>(motion.whole(0, 3)));
  const std::size_t count = motion.whole(60, 260);
  const double height = motion.between(100, 200), turns = motion.between(1, static_cast<double>(count) / 25);
  const double other = motion.between(1, static_cast<double>(count) / 25), phase = motion.between(0, 6);
  for (std::size_t row = 0; row < count; ++row) {
    const double t = static_cast<double>(row) / static_cast<double>(count - 1);
    motion.clean.push_back(height * t + height / 2 * std::sin(2 * std::numbers::pi * turns * t + phase) +
                           height / 20 * std::sin(2 * std::numbers::pi * other * t));
    motion.rows.push_back(std::round(motion.clean.back() / motion.resolution) * motion.resolution);
  }
  return motion;
}

TEST(RowSmoothingProperty, RoundedRowsHaveNoSpikes) {
  int named = 0, cases = 0;
  check_property(1000, [&] {
    ++cases;
    const RoundedMotion motion = random_motion();
    // Two equal rows there are a rest, and this motion has none.
    RC_PRE(motion.rows[0] != motion.rows[1] && motion.rows.back() != motion.rows[motion.rows.size() - 2]);
    const SmoothRows smooth = smooth_rows(motion.rows, motion.resolution);
    // One in five hundred is named although nothing is wrong with it.
    if (!smooth.spikes.empty()) ++named;
    for (std::size_t row = 0; row < motion.rows.size() && smooth.spikes.empty(); ++row)
      RC_ASSERT(std::fabs(smooth.rows[row] - motion.rows[row]) <= motion.resolution * (0.5 + 1e-9));
    RC_ASSERT(largest_second_difference(smooth.rows) <=
              1.1 * largest_second_difference(motion.clean) + 0.1 * motion.resolution);
  });
  EXPECT_LE(named, 1 + cases / 200);
}

TEST(RowSmoothingProperty, ASpikeOfOneRowNeverDoublesTheAcceleration) {
  check_property(1000, [] {
    RoundedMotion motion = random_motion();
    RC_PRE(motion.rows[0] != motion.rows[1] && motion.rows.back() != motion.rows[motion.rows.size() - 2]);
    // Away from the ends, where nothing says how the motion would have gone on.
    const std::size_t at = motion.whole(10, motion.rows.size() - 13);
    motion.rows[at] += std::round(motion.between(2, 200)) * motion.resolution;
    const SmoothRows smooth = smooth_rows(motion.rows, motion.resolution);
    RC_ASSERT(largest_second_difference(smooth.rows) <=
              2 * std::max(largest_second_difference(motion.clean), motion.resolution));
  });
}

TEST(RowSmoothingProperty, AFlatSpotHardlyEverDoublesTheAcceleration) {
  int doubled = 0, cases = 0;
  check_property(1000, [&] {
    RoundedMotion motion = random_motion();
    RC_PRE(motion.rows[0] != motion.rows[1] && motion.rows.back() != motion.rows[motion.rows.size() - 2]);
    ++cases;
    const std::size_t count = motion.whole(1, 4);
    const std::size_t at = motion.whole(10, motion.rows.size() - 12 - count);
    for (std::size_t row = at; row < at + count; ++row) motion.rows[row] = motion.rows[at - 1];
    const SmoothRows smooth = smooth_rows(motion.rows, motion.resolution);
    const double share = largest_second_difference(smooth.rows) /
                         std::max(largest_second_difference(motion.clean), motion.resolution);
    // In a turn that slow a flat spot is a short hold with a corner on either side.
    if (share > 2) ++doubled;
    RC_ASSERT(share < 5);
  });
  EXPECT_LE(doubled, 1 + cases / 100);
}

}  // namespace row_smoothing_property_test
}  // namespace inbetween
