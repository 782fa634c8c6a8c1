#include "inbetween/base/bisection.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "inbetween/timing/speed_profile.hpp"

/// The quick search for a zero against the plain one, on distances along a speed curve.

namespace inbetween {
namespace bisection_test {

struct Calls {
  int plain = 0;
  int quick = 0;
};

/// Both searches for the place at which a distance along the span is reached.
void expect_same_bits(const SpeedSpan& span, double distance, double begin, Calls& calls) {
  constexpr int halvings = std::numeric_limits<double>::digits + 8;
  const auto value = [&](double x) { return span.integral(x) - distance; };
  const auto is_below = [](double missing) { return !(missing > 0); };
  const auto plain = bisected({begin, 1}, halvings, [&](double x) {
    ++calls.plain;
    return is_below(value(x));
  });
  const double rounding = 64 * std::numeric_limits<double>::epsilon() * span.integral();
  const auto counted = [&](double x) {
    ++calls.quick;
    return value(x);
  };
  const auto slope = [&](double x) { return span.value(x); };
  const auto quick = bisected_near_zero({begin, 1}, halvings, rounding, counted, slope, is_below);
  EXPECT_EQ(quick.low, plain.low);
  EXPECT_EQ(quick.high, plain.high);
}

Calls compare_on_random_spans(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> height(0, 100);
  std::uniform_real_distribution<double> share(0, 1);
  std::bernoulli_distribution is_zero(0.3);
  const auto any = [&] { return is_zero(random) ? 0.0 : height(random); };
  Calls calls;
  for (int i = 0; i < 2000; ++i) {
    const SpeedSpan span{any(), any(), any(), any()};
    const double begin = is_zero(random) ? 0.0 : share(random) / 2;
    const double ahead = span.integral() - span.integral(begin);
    expect_same_bits(span, span.integral(begin) + share(random) * ahead, begin, calls);
    expect_same_bits(span, span.integral(begin), begin, calls);
    expect_same_bits(span, span.integral(), begin, calls);
  }
  return calls;
}

TEST(Bisection, NearAZeroItFindsTheSameBitsWithFewerValues) {
  const Calls calls = compare_on_random_spans(1);
  EXPECT_LT(3 * calls.quick, 2 * calls.plain);
}

TEST(Bisection, AWrongSlopeCostsValuesAndChangesNoBit) {
  const SpeedSpan span{1, 9, 2, 4};
  const auto value = [&](double x) { return span.integral(x) - 1; };
  const auto is_below = [](double missing) { return missing < 0; };
  const auto plain = bisected({0, 1}, 60, [&](double x) { return is_below(value(x)); });
  for (const double wrong : {0.0, -1.0, 1e-30, 1e30, std::numeric_limits<double>::quiet_NaN()}) {
    const auto slope = [&](double) { return wrong; };
    EXPECT_EQ(bisected_near_zero({0, 1}, 60, 1e-14, value, slope, is_below).high, plain.high) << wrong;
  }
}

}  // namespace bisection_test
}  // namespace inbetween
