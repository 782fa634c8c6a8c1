#include "inbetween/base/precision.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <type_traits>

namespace inbetween {
namespace precision_test {

using Precisions = testing::Types<double, float>;

struct PrecisionName {
  template <class Real>
  static std::string GetName(int) {
    return std::is_same_v<Real, double> ? "double" : "float";
  }
};

template <class Real>
class TwoSumIn : public testing::Test {};
TYPED_TEST_SUITE(TwoSumIn, Precisions, PrecisionName);

TYPED_TEST(TwoSumIn, KeepsWhatOneNumberWouldLose) {
  using Real = TypeParam;
  const Real large = 1 / std::numeric_limits<Real>::epsilon() * 16;
  TwoSum<Real> sum;
  for (const Real term : {large, Real(1), Real(0.5), -large}) sum.add(term);
  EXPECT_EQ(sum.high + sum.low, Real(1.5));
}

TYPED_TEST(TwoSumIn, LosesNothingWhicheverTermIsTheLarger) {
  using Real = TypeParam;
  const Real large = 1 / std::numeric_limits<Real>::epsilon() * 16;
  TwoSum<Real> rising{1, 0};
  rising.add(large);
  TwoSum<Real> falling{large, 0};
  falling.add(1);
  for (const TwoSum<Real>& sum : {rising, falling}) {
    EXPECT_EQ(sum.high, large);
    EXPECT_EQ(sum.low, Real(1));
  }
}

TYPED_TEST(TwoSumIn, AThousandTenthsAreAsExactAsTwiceTheDigits) {
  using Real = TypeParam;
  const Real tenth = Real(0.1);
  TwoSum<Real> sum;
  Real plain = 0;
  for (int i = 0; i < 1000; ++i) {
    sum.add(tenth);
    sum.renormalize();
    plain += tenth;
  }
  // 1000 times the number that stands for a tenth, exact in a long double.
  const long double expected = 1000 * static_cast<long double>(tenth);
  const long double got = static_cast<long double>(sum.high) + static_cast<long double>(sum.low);
  const auto epsilon = static_cast<long double>(std::numeric_limits<Real>::epsilon());
  EXPECT_LE(std::fabs(got - expected), 1e5L * epsilon * epsilon + 1e-17L);
  EXPECT_GT(std::fabs(static_cast<long double>(plain) - expected), 100 * epsilon) << "not worth two numbers";
}

TYPED_TEST(TwoSumIn, RenormalizingMovesDigitsUpAndKeepsTheSum) {
  using Real = TypeParam;
  TwoSum<Real> sum{1, Real(0.75)};
  sum.renormalize();
  EXPECT_EQ(sum.high, Real(1.75));
  EXPECT_EQ(sum.low, Real(0));
  const Real tiny = std::numeric_limits<Real>::epsilon() / 8;
  sum = {1, tiny};
  sum.renormalize();
  EXPECT_EQ(sum.high, Real(1));
  EXPECT_EQ(sum.low, tiny);
}

TYPED_TEST(TwoSumIn, TheDifferenceOfNearlyEqualSumsKeepsItsDigits) {
  using Real = TypeParam;
  const Real tiny = std::numeric_limits<Real>::epsilon() / 8;
  const TwoSum<Real> here{5, 3 * tiny};
  const TwoSum<Real> there{5, tiny};
  EXPECT_EQ(here.minus(there), 2 * tiny);
  EXPECT_EQ(there.minus(here), -2 * tiny);
  EXPECT_EQ(here.minus({4, 0}), 1 + 3 * tiny);
}

TYPED_TEST(TwoSumIn, AProductKeepsEveryDigit) {
  using Real = TypeParam;
  std::mt19937 random(5);
  std::uniform_real_distribution<Real> digits(1, 2);
  std::uniform_int_distribution<int> exponent(-30, 30);
  for (int i = 0; i < 10'000; ++i) {
    const Real a = std::ldexp(digits(random), exponent(random) / 2);
    const Real b = -std::ldexp(digits(random), exponent(random) / 2);
    const TwoSum<Real> product = two_product(a, b);
    EXPECT_EQ(product.high, a * b);
    EXPECT_EQ(product.low, std::fma(a, b, -(a * b))) << a << " times " << b;
  }
}

TEST(PathPoint, StandsBeforeAnotherBySegmentAndThenByT) {
  const PathPoint<double> here{2, 0.5};
  EXPECT_TRUE(here.at_or_before(here));
  EXPECT_TRUE(here.at_or_before({2, 0.75}));
  EXPECT_FALSE(here.at_or_before({2, 0.25}));
  EXPECT_TRUE(here.at_or_before({3, 0.25}));
  EXPECT_FALSE(here.at_or_before({1, 0.75}));
}

TEST(PathPoint, IsEqualOnlyToTheSameSegmentAndT) {
  const PathPoint<double> here{2, 0.5};
  EXPECT_EQ(here, (PathPoint<double>{2, 0.5}));
  EXPECT_NE(here, (PathPoint<double>{1, 0.5}));
  EXPECT_NE(here, (PathPoint<double>{2, 0.25}));
  // Key 1 is written one way only: {0, 1} would be another place.
  EXPECT_NE((PathPoint<double>{0, 1}), (PathPoint<double>{1, 0}));
}

}  // namespace precision_test
}  // namespace inbetween
