#include "inbetween/limits/verdict.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <optional>
#include <vector>

namespace inbetween {
namespace verdict_test {

constexpr double infinity = std::numeric_limits<double>::infinity();

AxisLimits limits_with(double velocity, double acceleration, std::optional<double> jerk,
                       std::optional<double> step = std::nullopt) {
  return *AxisLimits::make({.min = -1,
                            .max = 1,
                            .max_velocity = velocity,
                            .max_acceleration = acceleration,
                            .max_jerk = jerk,
                            .max_acceleration_step = step});
}

AxisPeaks peaks_of(double velocity, double acceleration, double jerk) {
  return {{}, {}, {velocity, 3}, {acceleration, 4}, {jerk, 5}};
}

/// One axis, with a step of its acceleration where there is one.
struct OneAxis {
  std::vector<AxisPeaks> peaks;
  std::vector<AxisLimits> limits;
  std::vector<MoveStep> steps;

  OneAxis(const AxisPeaks& peak, const AxisLimits& limit, double acceleration_step = 0,
          double velocity_step = 0)
      : peaks{peak}, limits{limit} {
    if (acceleration_step > 0 || velocity_step > 0)
      steps.push_back({0, -1, 6, 0, velocity_step, acceleration_step});
  }
  [[nodiscard]] JudgedMove judged() const { return {peaks, steps, limits, 1}; }
  [[nodiscard]] double highest() const { return highest_rate(judged()).whole; }
  [[nodiscard]] std::optional<BreachKind> breach() const {
    const std::optional<Breach> found = first_breach(judged());
    return found ? std::optional(found->kind) : std::nullopt;
  }
};

TEST(HighestRate, IsTheLeastThatVelocityAccelerationJerkAndStepAllow) {
  EXPECT_NEAR(OneAxis(peaks_of(10, 1, 1), limits_with(30, 1e6, 1e9)).highest(), 3, 1e-12);
  EXPECT_NEAR(OneAxis(peaks_of(1, 10, 1), limits_with(1e6, 40, 1e9)).highest(), 2, 1e-12);
  EXPECT_NEAR(OneAxis(peaks_of(1, 1, 2), limits_with(1e6, 1e6, 250)).highest(), 5, 1e-12);
  EXPECT_NEAR(OneAxis(peaks_of(1, 1, 1), limits_with(1e6, 1e6, 1e9, 90), 10).highest(), 3, 1e-12);
  for (double jerk = 1e-30; jerk < 1e30; jerk *= 7.3) {
    const double rate = OneAxis(peaks_of(0, 0, jerk), limits_with(1, 1, 1)).highest();
    EXPECT_NEAR(rate * rate * rate * jerk, 1, 1e-13);
    EXPECT_LE(rate * rate * rate * jerk, 1);
  }
}

TEST(HighestRate, AStepCountsOnlyBesideAJerkLimit) {
  EXPECT_EQ(OneAxis(peaks_of(1, 1, 1), limits_with(1, 1e6, 1e9), 10).highest(), 0);
  EXPECT_NEAR(OneAxis(peaks_of(1, 1, 1), limits_with(2, 1e6, std::nullopt), 10).highest(), 2, 1e-12);
}

TEST(HighestRate, AStepOfTheVelocityIsPlayedAtNoRateButBetweenTheSteps) {
  const OneAxis axis(peaks_of(10, 1, 1), limits_with(30, 1e6, std::nullopt), 0, 1e-3);
  EXPECT_EQ(highest_rate(axis.judged()).whole, 0);
  EXPECT_NEAR(highest_rate(axis.judged()).between_steps, 3, 1e-12);
}

TEST(HighestRate, NothingThatMovesMayBePlayedAsFastAsYouLike) {
  EXPECT_EQ(OneAxis(peaks_of(0, 0, 0), limits_with(1, 1, 1)).highest(), infinity);
  EXPECT_EQ(OneAxis(peaks_of(1, infinity, 1), limits_with(1, 1, 1)).highest(), 0);
}

TEST(HighestRate, OfSeveralAxesIsThatOfTheOneNearestItsLimit) {
  OneAxis both(peaks_of(10, 1, 1), limits_with(30, 1e6, 1e9));
  both.peaks.push_back(peaks_of(10, 1, 1));
  both.limits.push_back(limits_with(20, 1e6, 1e9));
  EXPECT_NEAR(both.highest(), 2, 1e-12);
}

TEST(FirstBreach, IsNothingWhereEverythingIsOnItsLimit) {
  OneAxis axis(peaks_of(1, 2, 3), limits_with(1, 2, 3, 4), 4);
  axis.peaks[0].lowest = {-1 - 1e-13, 0};  // by rounding
  axis.peaks[0].highest = {1 + 1e-13, 0};
  EXPECT_EQ(axis.breach(), std::nullopt);
}

TEST(FirstBreach, NamesWhatIsExceededAndWhere) {
  const OneAxis fast(peaks_of(1.5, 2, 3), limits_with(1, 2, 3));
  const std::optional<Breach> found = first_breach(fast.judged());
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(found->kind, BreachKind::velocity);
  EXPECT_EQ(found->value, 1.5);
  EXPECT_EQ(found->limit, 1);
  EXPECT_EQ(found->frame, 3);
  EXPECT_EQ(OneAxis(peaks_of(1, infinity, 3), limits_with(1, 2, 3)).breach(), BreachKind::acceleration);
  EXPECT_EQ(OneAxis(peaks_of(1, 2, 4), limits_with(1, 2, 3)).breach(), BreachKind::jerk);
  EXPECT_EQ(OneAxis(peaks_of(1, 2, 4), limits_with(1, 2, std::nullopt)).breach(), std::nullopt);
}

TEST(FirstBreach, JudgesTheRangeOfAnAxisAndNotThatOfItsMotor) {
  OneAxis axis(peaks_of(0, 0, 0), limits_with(1, 1, 1));
  axis.peaks[0].lowest.value = -1.01;
  EXPECT_EQ(axis.breach(), BreachKind::below_range);
  axis.peaks[0].lowest.value = 0;
  axis.peaks[0].highest.value = 1.01;
  EXPECT_EQ(axis.breach(), BreachKind::above_range);
  JudgedMove motor = axis.judged();
  motor.axes = 0;
  EXPECT_EQ(first_breach(motor), std::nullopt);
}

TEST(FirstBreach, RefusesEveryStepOfTheVelocityAndOneOfTheAccelerationBesideAJerkLimit) {
  const AxisPeaks still = peaks_of(0, 0, 0);
  EXPECT_EQ(OneAxis(still, limits_with(1, 1, std::nullopt), 0, 1e-9).breach(), BreachKind::velocity_step);
  EXPECT_EQ(OneAxis(still, limits_with(1, 1, std::nullopt), 5).breach(), std::nullopt);
  EXPECT_EQ(OneAxis(still, limits_with(1, 1, 1), 5).breach(), BreachKind::acceleration_step);
  EXPECT_EQ(OneAxis(still, limits_with(1, 1, 1, 4.9), 5).breach(), BreachKind::acceleration_step);
  EXPECT_EQ(OneAxis(still, limits_with(1, 1, 1, 5), 5).breach(), std::nullopt);
}

}  // namespace verdict_test
}  // namespace inbetween
