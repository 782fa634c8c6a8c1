#include "inbetween/homing/setpoint_trail.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

namespace inbetween {
namespace setpoint_trail_test {

std::int64_t ms(double milliseconds) {
  return std::llround(milliseconds * 1e6);
}

/// t^3 - 2 t^2 + 3 t - 4, which one polynomial of the fifth degree joins exactly.
TEST(SetpointTrail, IsExactlyWhereAnAxisOfEvenJerkWas) {
  const auto at = [](double t) {
    return Setpoint{((t - 2) * t + 3) * t - 4, (3 * t - 4) * t + 3, 6 * t - 4};
  };
  SetpointTrail trail;
  EXPECT_EQ(trail.position_at(0), std::nullopt);
  for (int i = 0; i <= 20; ++i) trail.push(ms(100 * i), at(0.1 * i));
  const double oldest = 100 * (20 - static_cast<double>(SetpointTrail::capacity) + 1);
  EXPECT_EQ(trail.position_at(ms(oldest) - 1), std::nullopt);
  EXPECT_EQ(trail.position_at(ms(2000) + 1), std::nullopt);
  for (int i = 0; oldest + 7 * i <= 2000; ++i) {
    const double now = oldest + 7 * i;
    ASSERT_TRUE(trail.position_at(ms(now)));
    EXPECT_NEAR(*trail.position_at(ms(now)), at(now / 1000).position, 1e-14);
  }
  EXPECT_EQ(trail.position_at(ms(2000)), at(2).position);
  trail.clear();
  EXPECT_EQ(trail.position_at(ms(1900)), std::nullopt);
}

/// t^4 and t^5 are told apart from their chord and their cubic.
TEST(SetpointTrail, IsTheQuinticBetweenItsEnds) {
  SetpointTrail trail;
  const auto at = [](double t) {
    return Setpoint{std::pow(t, 5) - std::pow(t, 4), 5 * std::pow(t, 4) - 4 * std::pow(t, 3),
                    20 * std::pow(t, 3) - 12 * t * t};
  };
  trail.push(ms(500), at(0.5));
  trail.push(ms(1500), at(1.5));
  for (int i = 0; i < 10; ++i) {
    const double t = 0.5 + 0.1 * i;
    EXPECT_NEAR(*trail.position_at(ms(1000 * t)), at(t).position, 1e-14);
  }
}

}  // namespace setpoint_trail_test
}  // namespace inbetween
