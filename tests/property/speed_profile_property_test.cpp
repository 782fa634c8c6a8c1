#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "inbetween/timing/speed_profile.hpp"
#include "tests/support/oracle_profile.hpp"
#include "tests/support/property.hpp"

/// The speed curve against the oracle's Cox-de Boor recursion, on random control values.

namespace inbetween {
namespace speed_profile_property_test {

constexpr int many_curves = 2000;

/// 1 to 24 values in 0..100 with zeros and hundreds among them.
std::vector<double> random_values() {
  const auto count = *rc::gen::resize(rc::kNominalSize, rc::gen::inRange<std::size_t>(1, 25));
  std::vector<double> values(count);
  for (double& value : values) {
    const int drawn = *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(-2000, 12'001));
    value = static_cast<double>(std::clamp(drawn, 0, 10'000)) / 100;
  }
  return values;
}

/// Ten places on a curve: its ends, the knots and what lies between them.
std::vector<double> random_places(std::int32_t spans) {
  std::vector<double> places{0, static_cast<double>(spans)};
  for (int i = 0; i < 8; ++i) {
    const auto knot = static_cast<double>(*rc::gen::inRange(0, spans));
    const int part = *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(-100, 1000));
    places.push_back(knot + static_cast<double>(std::max(part, 0)) / 1000);
  }
  return places;
}

/// A curve with the memory it stands in.
struct RandomCurve {
  std::vector<double> values = random_values();
  SpeedProfileStorage<24> storage;
  SpeedProfile curve = *SpeedProfile::make(values, storage.memory());
  oracle::Profile expected{std::vector<long double>(values.begin(), values.end())};
};

void log(const auto& values) {
  for (const auto value : values) RC_LOG() << value << ' ';
  RC_LOG() << '\n';
}

void expect_near(double value, long double expected, long double tolerance) {
  RC_LOG() << value << " is off by " << static_cast<long double>(value) - expected << ", allowed "
           << tolerance << '\n';
  RC_ASSERT(std::fabs(static_cast<long double>(value) - expected) <= tolerance);
}

void expect_the_oracles_curve() {
  constexpr auto epsilon = static_cast<long double>(std::numeric_limits<double>::epsilon());
  const RandomCurve random;
  log(random.values);
  const long double largest = static_cast<long double>(*std::ranges::max_element(random.values));
  for (const double a : random_places(random.curve.span_count())) {
    const auto exact_a = static_cast<long double>(a);
    RC_LOG() << "a = " << exact_a << '\n';
    // Value and integral are sums of numbers >= 0 and keep their relative precision, the derivatives
    // that of the largest control value.
    const long double value = random.expected.value(exact_a);
    expect_near(random.curve.value(a), value, 8 * epsilon * value);
    const long double integral = random.expected.integral(exact_a);
    expect_near(random.curve.integral(a), integral, 8 * epsilon * integral);
    expect_near(random.curve.derivative(a), random.expected.derivative(1, exact_a), 16 * epsilon * largest);
    expect_near(random.curve.second(a), random.expected.derivative(2, exact_a), 64 * epsilon * largest);
  }
  expect_near(random.curve.total_integral(),
              random.expected.integral(static_cast<long double>(random.curve.span_count())),
              8 * epsilon * static_cast<long double>(random.curve.total_integral()));
}

TEST(SpeedProfileProperty, IsTheOraclesCurve) {
  check_property(many_curves, [] { expect_the_oracles_curve(); });
}

void expect_hull_and_ends() {
  const RandomCurve random;
  log(random.values);
  const SpeedProfile& curve = random.curve;
  const auto [least, largest] = std::ranges::minmax(random.values);
  const double rounding = 4 * std::numeric_limits<double>::epsilon() * largest;
  RC_ASSERT(curve.value(0) == random.values.front());
  RC_ASSERT(curve.value(static_cast<double>(curve.span_count())) == random.values.back());
  for (const double a : random_places(curve.span_count())) {
    RC_ASSERT(curve.value(a) >= least - rounding);
    RC_ASSERT(curve.value(a) <= largest + rounding);
    RC_ASSERT(curve.value(a) >= 0);
  }
}

TEST(SpeedProfileProperty, StaysInTheHullAndMeetsItsEnds) {
  check_property(many_curves, [] { expect_hull_and_ends(); });
}

TEST(SpeedProfileProperty, TheIntegralNeverFalls) {
  check_property(many_curves, [] {
    const RandomCurve random;
    log(random.values);
    double before = 0;
    for (std::int32_t span = 0; span < random.curve.span_count(); ++span) {
      for (int part = 0; part <= 16; ++part) {
        const double integral = random.curve.integral(span + part / 16.0);
        // The quartic is rounded a few times, and over a dwell it has nothing to grow by.
        RC_ASSERT(integral >= before * (1 - 4 * std::numeric_limits<double>::epsilon()));
        before = integral;
      }
    }
  });
}

}  // namespace speed_profile_property_test
}  // namespace inbetween
