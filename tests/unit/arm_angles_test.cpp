#include "inbetween/joints/arm_angles.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "inbetween/joints/angle_of.hpp"

namespace inbetween {
namespace arm_angles_test {

constexpr double pi = std::numbers::pi;

/// Against the C library.
double worst_angle(double reach) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> place(-reach, reach);
  double worst = 0;
  for (int i = 0; i < 100'000; ++i) {
    const double x = place(random);
    const double y = i % 3 == 0 ? place(random) * 1e-6 : place(random);
    worst = std::max(worst, std::fabs(static_cast<double>(angle_of(x, y)) -
                                      std::atan2(static_cast<double>(y), static_cast<double>(x))));
  }
  return worst;
}

TEST(AngleOf, IsWithinTwoUnitsInTheLastPlaceOfPi) {
  for (const double reach : {1e-200, 1.0, 1e200}) EXPECT_LE(worst_angle(reach), 2 * 4.5e-16);
}

TEST(AngleOf, HasTheQuartersExactly) {
  EXPECT_EQ(angle_of(0.0, 0.0), 0);
  EXPECT_EQ(angle_of(2.0, 0.0), 0);
  EXPECT_EQ(angle_of(0.0, 3.0), pi / 2);
  EXPECT_EQ(angle_of(0.0, -3.0), -pi / 2);
  EXPECT_EQ(angle_of(-1.0, 0.0), pi);
  EXPECT_NEAR(angle_of(-5.0, 5.0), 3 * pi / 4, 1e-15);
}

struct Place {
  double x = 0, y = 0;
};

/// By the C library's sine and cosine.
Place hand_of(const TwoJointArm& arm, const ArmAngles& angles) {
  const double both = angles.shoulder + angles.elbow;
  return {arm.upper * std::cos(angles.shoulder) + arm.forearm * std::cos(both),
          arm.upper * std::sin(angles.shoulder) + arm.forearm * std::sin(both)};
}

TEST(ArmAngles, BothElbowsPutTheHandOnItsPlace) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> any(0, 1);
  double worst = 0;
  for (int i = 0; i < 20'000; ++i) {
    const TwoJointArm arm{0.1 + 2 * any(random), 0.1 + 2 * any(random)};
    const double nearest = std::fabs(arm.upper - arm.forearm);
    const double distance = nearest + (arm.upper + arm.forearm - nearest) * any(random);
    const double direction = 2 * pi * any(random);
    const Place place{distance * std::cos(direction), distance * std::sin(direction)};
    for (const ElbowSide side : {ElbowSide::left, ElbowSide::right}) {
      const auto angles = arm_angles(arm, place.x, place.y, side);
      ASSERT_TRUE(angles);
      const Place hand = hand_of(arm, *angles);
      worst = std::max({worst, std::fabs(hand.x - place.x), std::fabs(hand.y - place.y)});
      // The elbow's side of the line to the hand, by the cross product.
      const double elbow_side = place.x * std::sin(angles->shoulder) - place.y * std::cos(angles->shoulder);
      EXPECT_GE(side == ElbowSide::left ? elbow_side : -elbow_side, -1e-12);
    }
  }
  EXPECT_LE(worst, 1e-14);
}

TEST(ArmAngles, UpIsLeftWhereTheHandIsAtTheRight) {
  const TwoJointArm arm{1, 1};
  const auto up = arm_angles(arm, 1.0, 0.0, ElbowSide::left);
  EXPECT_NEAR(up->shoulder, pi / 3, 1e-15);
  EXPECT_NEAR(up->elbow, -2 * pi / 3, 1e-15);
}

/// A stretched arm has lost half its digits where the cosine rule is used.
TEST(ArmAngles, NearTheEdgeTheElbowKeepsItsDigits) {
  const TwoJointArm arm{1, 1};
  for (const double short_of : {1e-6, 1e-9, 1e-12}) {
    const auto angles = arm_angles(arm, 2 - short_of, 0.0, ElbowSide::right);
    const double left = 2 - (2 - short_of);  // what the subtraction has left of it
    // The distance is 2 cos(elbow / 2), so elbow = 4 asin(sqrt(left) / 2).
    EXPECT_NEAR(angles->elbow / (4 * std::asin(std::sqrt(left) / 2)), 1, 1e-14);
  }
  EXPECT_EQ(arm_angles(arm, 2.0, 0.0, ElbowSide::right)->elbow, 0);
}

TEST(ArmAngles, BeyondTheReachIsRefusedAndMeasured) {
  const TwoJointArm arm{0.3, 0.25};
  EXPECT_NEAR(beyond_reach(arm, 0.551), 0.001, 1e-15);
  EXPECT_NEAR(beyond_reach(arm, 0.049), -0.001, 1e-15);
  EXPECT_EQ(beyond_reach(arm, 0.3), 0);
  EXPECT_EQ(arm_angles(arm, 0.551, 0.0, ElbowSide::left).error().code, ErrorCode::no_solution);
  EXPECT_EQ(arm_angles(arm, 0.049, 0.0, ElbowSide::left).error().code, ErrorCode::no_solution);
  EXPECT_EQ(arm_angles({1.0, 1.0}, 0.0, 0.0, ElbowSide::left).error().code, ErrorCode::singular);
  EXPECT_EQ(arm_angles({1.0, 0.0}, 1.0, 0.0, ElbowSide::left).error().code, ErrorCode::out_of_range);
  EXPECT_EQ(arm_angles(arm, std::nan(""), 0.0, ElbowSide::left).error().code, ErrorCode::not_finite);
}

TEST(ArmAngles, AHeadLooksAtThePoint) {
  std::mt19937_64 random(9);
  std::uniform_real_distribution<double> any(-3, 3);
  for (int i = 0; i < 10'000; ++i) {
    const Vector3 point{any(random), any(random), any(random)};
    const auto head = aim_at(point);
    ASSERT_TRUE(head);
    const double length = std::sqrt(dot(point, point));
    EXPECT_NEAR(length * std::cos(head->tilt) * std::cos(head->pan), point.x, 1e-14);
    EXPECT_NEAR(length * std::cos(head->tilt) * std::sin(head->pan), point.y, 1e-14);
    EXPECT_NEAR(length * std::sin(head->tilt), point.z, 1e-14);
  }
  EXPECT_EQ(aim_at(Vector3{0, 0, 2}).error().code, ErrorCode::singular);
  EXPECT_EQ(aim_at(Vector3{0, std::numeric_limits<double>::infinity(), 2}).error().code,
            ErrorCode::not_finite);
}

}  // namespace arm_angles_test
}  // namespace inbetween
