#include "host_tools/fit/control_curve.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace inbetween {
namespace control_curve_test {

using testing::ElementsAre;

const std::vector<double> drawn = {3, 0, 7, -2, 5, 11};

TEST(ControlCurve, IsTheCurveOfTheSpeedProfile) {
  const std::vector<double> values = {3, 0, 7, 2, 5, 11};
  std::vector<SpeedSpan> spans(5);
  std::vector<TwoSum> integrals(6);
  const auto profile = SpeedProfile::make(values, {spans, integrals});
  const ControlCurve curve(values);
  for (const double a : {0.0, 0.3, 1.0, 2.7, 4.5, 5.0}) {
    const CurveValues at = curve.at(place_at(a, 5));
    EXPECT_NEAR(at.area, profile->integral(a), 1e-13) << a;
    EXPECT_NEAR(at.value, profile->value(a), 1e-13) << a;
    EXPECT_NEAR(at.first, profile->derivative(a), 1e-12) << a;
    EXPECT_NEAR(at.second, profile->second(a), 1e-12) << a;
  }
  EXPECT_NEAR(curve.at({1, 0.5}).third, curve.at({1, 0.75}).second / 0.25 - curve.at({1, 0.5}).second / 0.25,
              1e-11);
}

TEST(ControlCurve, TheMeanSquareIsThatOfTheCurve) {
  double simpson = 0;
  constexpr int steps = 10'000;
  for (int i = 0; i <= steps; ++i) {
    const double value = ControlCurve(drawn).at(place_at(5.0 * i / steps, 5)).value;
    simpson += (i == 0 || i == steps ? 1 : i % 2 == 1 ? 4 : 2) * value * value;
  }
  EXPECT_NEAR(mean_square(drawn), simpson / (3 * steps), 1e-8);
}

TEST(ControlCurve, RefinedItIsTheSameCurve) {
  const std::vector<double> fine = refined(drawn);
  ASSERT_EQ(fine.size(), 11U);
  for (const double a : {0.0, 0.4, 1.5, 3.2, 5.0}) {
    EXPECT_NEAR(ControlCurve(fine).at(place_at(2 * a, 10)).value,
                ControlCurve(drawn).at(place_at(a, 5)).value, 1e-13);
  }
}

TEST(ControlCurve, PeriodicItIsWhatTheSpeedProfileIsAllRound) {
  constexpr CurveEnds ends = CurveEnds::periodic;
  const std::vector<double> loop = {3, 8, 0, 11, 6, 3};
  const std::size_t f = loop.size() - 1;
  SpeedProfileStorage<6> storage;
  const auto profile = SpeedProfile::make(loop, storage.memory(), ends);
  ASSERT_TRUE(profile.has_value());
  const ControlCurve curve(loop, ends);
  const ControlCurve fine(refined(loop, ends), ends);
  for (int i = 0; i <= 100; ++i) {
    const double a = static_cast<double>(f) * i / 100;
    const CurveValues at = curve.at(place_at(a, f));
    EXPECT_NEAR(at.value, profile->value(a), 1e-13) << a;
    EXPECT_NEAR(at.area, profile->integral(a), 1e-12) << a;
    EXPECT_NEAR(fine.at(place_at(2 * a, 2 * f)).value, at.value, 1e-13) << a;
  }
}

TEST(ControlCurve, FindsThePlaceOfAnArea) {
  const ControlCurve curve(std::vector<double>{0, 0, 4, 9, 0, 0, 0, 5, 5});
  for (const double a : {0.2, 1.0, 2.6, 7.9}) {
    const CurvePlace place = curve.place_of_area(curve.at(place_at(a, 8)).area);
    EXPECT_NEAR(place.span + place.t, a, 1e-7) << a;
  }
  EXPECT_EQ(curve.place_of_area(-1).span, 0);
  EXPECT_EQ(curve.place_of_area(1e9).span, 7);
  EXPECT_EQ(curve.place_of_area(1e9).t, 1);
}

TEST(ControlCurve, TheLargestMagnitudeMayLieBetweenKnots) {
  const ControlCurve::Largest largest = ControlCurve(std::vector<double>{0, 0, -6, -5, 0, 0}).largest();
  double sampled = 0;
  for (int i = 0; i <= 5000; ++i) {
    const double value =
        ControlCurve(std::vector<double>{0, 0, -6, -5, 0, 0}).at(place_at(i / 1000.0, 5)).value;
    sampled = std::max(sampled, std::abs(value));
  }
  EXPECT_NEAR(largest.value, sampled, 1e-6);
  EXPECT_GE(largest.value, sampled - 1e-12);
  EXPECT_GT(largest.a, 2);
  EXPECT_LT(largest.a, 3);
}

TEST(ControlCurve, RestsAreTwoZerosAtAnEndAndThreeInside) {
  EXPECT_THAT(rests_of(std::vector<double>{0, 0, 1, 0, 0, 2, 0, 0, 0, 3, 0}),
              ElementsAre(true, true, false, false, false, false, true, true, true, false, false));
}

}  // namespace control_curve_test
}  // namespace inbetween
