#include "inbetween/limits/limits.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

namespace inbetween {
namespace limits_test {

AxisLimitsSpec slider() {
  return {.min = 0, .max = 1500, .max_velocity = 400, .max_acceleration = 800, .max_jerk = 8000.0};
}

TEST(AxisLimits, StopsMayUseHalfAsMuchAgainWhereTheRigDoesNotSay) {
  const auto limits = AxisLimits::make(slider());
  ASSERT_TRUE(limits.has_value());
  EXPECT_EQ(limits->min(), 0);
  EXPECT_EQ(limits->max(), 1500);
  EXPECT_EQ(limits->max_velocity(), 400);
  EXPECT_EQ(limits->max_acceleration(), 800);
  EXPECT_EQ(limits->max_jerk(), 8000.0);
  EXPECT_EQ(limits->stop_acceleration(), 1200);
  EXPECT_EQ(limits->stop_jerk(), 12000.0);
  EXPECT_EQ(limits->max_acceleration_step(), 0);
}

TEST(AxisLimits, WhatTheRigSaysOfStopsHolds) {
  AxisLimitsSpec spec = slider();
  spec.stop_acceleration = 800.0;
  spec.stop_jerk = 9000.0;
  spec.max_acceleration_step = 50.0;
  const auto limits = AxisLimits::make(spec);
  ASSERT_TRUE(limits.has_value());
  EXPECT_EQ(limits->stop_acceleration(), 800);
  EXPECT_EQ(limits->stop_jerk(), 9000.0);
  EXPECT_EQ(limits->max_acceleration_step(), 50);
}

TEST(AxisLimits, WithoutAJerkLimitThereIsNoneForStops) {
  AxisLimitsSpec spec = slider();
  spec.max_jerk.reset();
  const auto limits = AxisLimits::make(spec);
  ASSERT_TRUE(limits.has_value());
  EXPECT_FALSE(limits->max_jerk().has_value());
  EXPECT_FALSE(limits->stop_jerk().has_value());
}

TEST(AxisLimits, AJerkLimitCanHoldForStopsAlone) {
  AxisLimitsSpec spec = slider();
  spec.max_jerk.reset();
  spec.stop_jerk = 100.0;
  const auto limits = AxisLimits::make(spec);
  ASSERT_TRUE(limits.has_value());
  EXPECT_FALSE(limits->max_jerk().has_value());
  EXPECT_EQ(limits->stop_jerk(), 100.0);
}

TEST(AxisLimits, IllegalValuesAreRefusedByName) {
  using Spec = AxisLimitsSpec;
  struct Case {
    std::string named;
    ErrorCode code;
    std::function<void(Spec&)> spoil;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  const double huge = std::numeric_limits<double>::max();
  const std::vector<Case> cases = {
      {"range", ErrorCode::not_finite, [&](Spec& s) { s.min = nan; }},
      {"range", ErrorCode::not_finite, [&](Spec& s) { s.max = infinity; }},
      {"range", ErrorCode::out_of_range, [&](Spec& s) { s.max = huge; }},
      {"range", ErrorCode::out_of_range, [&](Spec& s) { s.min = -huge; }},
      {"range", ErrorCode::out_of_range, [&](Spec& s) { s.max = s.min; }},
      {"range", ErrorCode::out_of_range, [&](Spec& s) { s.min = 1501; }},
      {"max_velocity", ErrorCode::out_of_range, [&](Spec& s) { s.max_velocity = 0; }},
      {"max_velocity", ErrorCode::out_of_range, [&](Spec& s) { s.max_velocity = huge; }},
      {"max_velocity", ErrorCode::not_finite, [&](Spec& s) { s.max_velocity = infinity; }},
      {"max_acceleration", ErrorCode::out_of_range, [&](Spec& s) { s.max_acceleration = -1; }},
      {"max_acceleration", ErrorCode::not_finite, [&](Spec& s) { s.max_acceleration = nan; }},
      {"max_jerk", ErrorCode::out_of_range, [&](Spec& s) { s.max_jerk = 0.0; }},
      {"max_jerk", ErrorCode::not_finite, [&](Spec& s) { s.max_jerk = nan; }},
      {"max_acceleration_step", ErrorCode::out_of_range, [&](Spec& s) { s.max_acceleration_step = 0.0; }},
      {"stop_acceleration", ErrorCode::not_finite, [&](Spec& s) { s.stop_acceleration = nan; }},
      {"stop_acceleration is below", ErrorCode::out_of_range, [&](Spec& s) { s.stop_acceleration = 799.0; }},
      {"stop_jerk", ErrorCode::out_of_range, [&](Spec& s) { s.stop_jerk = double{-1}; }},
      {"stop_jerk is not a limit", ErrorCode::out_of_range,
       [&](Spec& s) {
         s.max_jerk.reset();
         s.stop_jerk = 0.0;
       }},
      {"stop_jerk is below", ErrorCode::out_of_range, [&](Spec& s) { s.stop_jerk = 7999.0; }},
  };
  for (const Case& one : cases) {
    Spec spec = slider();
    one.spoil(spec);
    const auto limits = AxisLimits::make(spec);
    ASSERT_FALSE(limits.has_value()) << one.named;
    EXPECT_EQ(limits.error().code, one.code) << limits.error().what;
    EXPECT_NE(std::string(limits.error().what).find(one.named), std::string::npos) << limits.error().what;
    EXPECT_NE(std::string(limits.error().remedy), "");
  }
}

TEST(PositionRounding, IsAShareOfTheEndOfTheRangeThatIsFurtherFromZero) {
  EXPECT_EQ(position_rounding(-50, 100), 1e-12 * 100);
  EXPECT_EQ(position_rounding(-100, 50), 1e-12 * 100);
  EXPECT_EQ(position_rounding(-1500, -20), 1e-12 * 1500);
  EXPECT_EQ(position_rounding(20, 1500), 1e-12 * 1500);
}

}  // namespace limits_test
}  // namespace inbetween
