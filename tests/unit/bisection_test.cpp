#include "inbetween/base/bisection.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "inbetween/timing/speed_profile.hpp"

/// The quick search for a zero against the plain one, on ways along a speed curve.

namespace inbetween {
namespace bisection_test {

struct Calls {
  int plain = 0;
  int quick = 0;
};

/// Both searches for the place at which a way along the span is reached.
template <Precise Real>
void expect_same_bits(const SpeedSpan<Real>& span, Real way, Real begin, Calls& calls) {
  constexpr int halvings = std::numeric_limits<Real>::digits + 8;
  const auto value = [&](Real x) { return span.integral(x) - way; };
  const auto is_below = [](Real missing) { return !(missing > 0); };
  const auto plain = bisected<Real>({begin, 1}, halvings, [&](Real x) {
    ++calls.plain;
    return is_below(value(x));
  });
  const Real rounding = 64 * std::numeric_limits<Real>::epsilon() * span.integral();
  const auto counted = [&](Real x) {
    ++calls.quick;
    return value(x);
  };
  const auto slope = [&](Real x) { return span.value(x); };
  const auto quick = bisected_near_zero<Real>({begin, 1}, halvings, rounding, counted, slope, is_below);
  EXPECT_EQ(quick.low, plain.low);
  EXPECT_EQ(quick.high, plain.high);
}

template <Precise Real>
Calls compare_on_random_spans(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<Real> height(0, 100);
  std::uniform_real_distribution<Real> share(0, 1);
  std::bernoulli_distribution is_zero(0.3);
  const auto any = [&] { return is_zero(random) ? Real(0) : height(random); };
  Calls calls;
  for (int i = 0; i < 2000; ++i) {
    const SpeedSpan<Real> span{any(), any(), any(), any()};
    const Real begin = is_zero(random) ? Real(0) : share(random) / 2;
    const Real ahead = span.integral() - span.integral(begin);
    expect_same_bits(span, span.integral(begin) + share(random) * ahead, begin, calls);
    expect_same_bits(span, span.integral(begin), begin, calls);
    expect_same_bits(span, span.integral(), begin, calls);
  }
  return calls;
}

TEST(Bisection, NearAZeroItFindsTheSameBitsWithFewerValues) {
  const Calls in_double = compare_on_random_spans<double>(1);
  EXPECT_LT(3 * in_double.quick, 2 * in_double.plain);
  const Calls in_float = compare_on_random_spans<float>(2);
  EXPECT_LT(in_float.quick, in_float.plain);
}

TEST(Bisection, AWrongSlopeCostsValuesAndChangesNoBit) {
  const SpeedSpan<double> span{1, 9, 2, 4};
  const auto value = [&](double x) { return span.integral(x) - 1; };
  const auto is_below = [](double missing) { return missing < 0; };
  const auto plain = bisected<double>({0, 1}, 60, [&](double x) { return is_below(value(x)); });
  for (const double wrong : {0.0, -1.0, 1e-30, 1e30, std::numeric_limits<double>::quiet_NaN()}) {
    const auto slope = [&](double) { return wrong; };
    EXPECT_EQ(bisected_near_zero<double>({0, 1}, 60, 1e-14, value, slope, is_below).high, plain.high)
        << wrong;
  }
}

}  // namespace bisection_test
}  // namespace inbetween
