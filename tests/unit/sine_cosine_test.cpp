#include "inbetween/joints/sine_cosine.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace inbetween {
namespace sine_cosine_test {

/// How far `found` is from `exact`, in units of the last place of the exact value.
double places_off(double found, long double exact) {
  const auto rounded = static_cast<double>(std::fabs(exact));
  const double next = std::nextafter(rounded, std::numeric_limits<double>::infinity());
  return static_cast<double>(std::fabs(static_cast<long double>(found) - exact) /
                             (static_cast<long double>(next) - rounded));
}

double worst_of(double angle) {
  const SineCosine found = sine_cosine(angle);
  return std::max(places_off(found.sine, std::sin(static_cast<long double>(angle))),
                  places_off(found.cosine, std::cos(static_cast<long double>(angle))));
}

/// The C library's functions of long double have 11 more digits than double.
void expect_within_a_place(double largest) {
  std::mt19937_64 random(7);
  double worst = 0;
  for (const double reach : {1.0, 10.0, 100.0, largest}) {
    std::uniform_real_distribution<double> angles(-reach, reach);
    for (int i = 0; i < 50'000; ++i) worst = std::max(worst, worst_of(angles(random)));
  }
  // Beside the zeros and the ends of the series, where digits cancel.
  const auto last = static_cast<int>(largest * 4 / std::numbers::pi_v<double>) - 1;
  for (int eighth = -last; eighth <= last; eighth += 1 + last / 20'000) {
    const auto angle =
        static_cast<double>(static_cast<long double>(eighth) * std::numbers::pi_v<long double> / 4);
    for (const double near : {std::nextafter(angle, 0.0), angle, std::nextafter(angle, 2 * angle)}) {
      worst = std::max(worst, worst_of(near));
    }
  }
  EXPECT_LE(worst, 1.0);
}

TEST(SineCosine, IsWithinAUnitInTheLastPlace) {
  expect_within_a_place(max_angle);
}

TEST(SineCosine, IsExactAtZeroAndOdd) {
  EXPECT_EQ(sine_cosine(0.0).sine, 0.0);
  EXPECT_EQ(sine_cosine(0.0).cosine, 1.0);
  EXPECT_EQ(sine_cosine(1e-300).sine, 1e-300);
  for (const double angle : {0.1, 1.0, 2.5, 4.0, 6.0, 1234.5}) {
    EXPECT_EQ(sine_cosine(-angle).sine, -sine_cosine(angle).sine);
    EXPECT_EQ(sine_cosine(-angle).cosine, sine_cosine(angle).cosine);
  }
}

}  // namespace sine_cosine_test
}  // namespace inbetween
