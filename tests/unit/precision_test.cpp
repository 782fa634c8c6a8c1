#include "inbetween/base/precision.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <type_traits>

namespace inbetween {
namespace precision_test {

TEST(TwoSum, KeepsWhatOneNumberWouldLose) {
  const double large = 1 / std::numeric_limits<double>::epsilon() * 16;
  TwoSum sum;
  for (const double term : {large, 1.0, 0.5, -large}) sum.add(term);
  EXPECT_EQ(sum.high + sum.low, 1.5);
}

TEST(TwoSum, LosesNothingWhicheverTermIsTheLarger) {
  const double large = 1 / std::numeric_limits<double>::epsilon() * 16;
  TwoSum rising{1, 0};
  rising.add(large);
  TwoSum falling{large, 0};
  falling.add(1);
  for (const TwoSum& sum : {rising, falling}) {
    EXPECT_EQ(sum.high, large);
    EXPECT_EQ(sum.low, 1.0);
  }
}

TEST(TwoSum, AThousandTenthsAreAsExactAsTwiceTheDigits) {
  const double tenth = 0.1;
  TwoSum sum;
  double plain = 0;
  for (int i = 0; i < 1000; ++i) {
    sum.add(tenth);
    sum.renormalize();
    plain += tenth;
  }
  // 1000 times the number that stands for a tenth, exact in a long double.
  const long double expected = 1000 * static_cast<long double>(tenth);
  const long double got = static_cast<long double>(sum.high) + static_cast<long double>(sum.low);
  const auto epsilon = static_cast<long double>(std::numeric_limits<double>::epsilon());
  EXPECT_LE(std::fabs(got - expected), 1e5L * epsilon * epsilon + 1e-17L);
  EXPECT_GT(std::fabs(static_cast<long double>(plain) - expected), 100 * epsilon) << "not worth two numbers";
}

TEST(TwoSum, RenormalizingMovesDigitsUpAndKeepsTheSum) {
  TwoSum sum{1, 0.75};
  sum.renormalize();
  EXPECT_EQ(sum.high, 1.75);
  EXPECT_EQ(sum.low, 0.0);
  const double tiny = std::numeric_limits<double>::epsilon() / 8;
  sum = {1, tiny};
  sum.renormalize();
  EXPECT_EQ(sum.high, 1.0);
  EXPECT_EQ(sum.low, tiny);
}

TEST(TwoSum, TheDifferenceOfNearlyEqualSumsKeepsItsDigits) {
  const double tiny = std::numeric_limits<double>::epsilon() / 8;
  const TwoSum here{5, 3 * tiny};
  const TwoSum there{5, tiny};
  EXPECT_EQ(here.minus(there), 2 * tiny);
  EXPECT_EQ(there.minus(here), -2 * tiny);
  EXPECT_EQ(here.minus({4, 0}), 1 + 3 * tiny);
}

TEST(TwoSum, AProductKeepsEveryDigit) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> digits(1, 2);
  std::uniform_int_distribution<int> exponent(-30, 30);
  for (int i = 0; i < 10'000; ++i) {
    const double a = std::ldexp(digits(random), exponent(random) / 2);
    const double b = -std::ldexp(digits(random), exponent(random) / 2);
    const TwoSum product = two_product(a, b);
    EXPECT_EQ(product.high, a * b);
    EXPECT_EQ(product.low, std::fma(a, b, -(a * b))) << a << " times " << b;
  }
}

TEST(PathPoint, StandsBeforeAnotherBySegmentAndThenByT) {
  const PathPoint here{2, 0.5};
  EXPECT_TRUE(here.at_or_before(here));
  EXPECT_TRUE(here.at_or_before({2, 0.75}));
  EXPECT_FALSE(here.at_or_before({2, 0.25}));
  EXPECT_TRUE(here.at_or_before({3, 0.25}));
  EXPECT_FALSE(here.at_or_before({1, 0.75}));
}

TEST(PathPoint, IsEqualOnlyToTheSameSegmentAndT) {
  const PathPoint here{2, 0.5};
  EXPECT_EQ(here, (PathPoint{2, 0.5}));
  EXPECT_NE(here, (PathPoint{1, 0.5}));
  EXPECT_NE(here, (PathPoint{2, 0.25}));
  // Key 1 is written one way only: {0, 1} would be another place.
  EXPECT_NE((PathPoint{0, 1}), (PathPoint{1, 0}));
}

}  // namespace precision_test
}  // namespace inbetween
