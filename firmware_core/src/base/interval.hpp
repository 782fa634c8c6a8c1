#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "inbetween/base/precision.hpp"

/// Interval arithmetic, rounded to nearest: a proof that uses it adds the rounding at the end.

namespace inbetween {

template <Precise Real>
struct Interval {
  Real low = 0;
  Real high = 0;

  friend constexpr Interval operator+(const Interval& a, const Interval& b) {
    return {a.low + b.low, a.high + b.high};
  }
  friend constexpr Interval operator*(const Interval& a, const Interval& b) {
    const Real ll = a.low * b.low;
    const Real lh = a.low * b.high;
    const Real hl = a.high * b.low;
    const Real hh = a.high * b.high;
    return {std::min(std::min(ll, lh), std::min(hl, hh)), std::max(std::max(ll, lh), std::max(hl, hh))};
  }
  friend constexpr Interval operator*(Real a, const Interval& b) {
    return a >= 0 ? Interval{a * b.low, a * b.high} : Interval{a * b.high, a * b.low};
  }
  /// The product is not a number if an end is none (0 times infinity).
  [[nodiscard]] Real magnitude() const {
    const Real a = std::fabs(low);
    const Real b = std::fabs(high);
    return b <= a ? a : (a <= b ? b : a + b);
  }
};

/// A polynomial near a point: its value there and how far from that it can be within a radius, rounding of
/// the value included.
template <Precise Real>
struct Centred {
  Real value = 0;
  Real spread = 0;

  [[nodiscard]] Interval<Real> range() const { return {value - spread, value + spread}; }
};

/// The polynomial c[0] + c[1] x + ... about `x` >= 0, by its Taylor coefficients there (centred form).
template <Precise Real, std::size_t Size>
Centred<Real> centred(std::array<Real, Size> c, Real x, Real radius) {
  Real magnitude = 0;
  for (std::size_t i = Size; i-- > 0;) magnitude = magnitude * (x + radius) + std::fabs(c[i]);
  for (std::size_t i = 0; i + 1 < Size; ++i) {
    for (std::size_t j = Size - 1; j-- > i;) c[j] += x * c[j + 1];
  }
  Real spread = 0;
  for (std::size_t i = Size; i-- > 1;) spread = (spread + std::fabs(c[i])) * radius;
  return {c[0], spread + 32 * std::numeric_limits<Real>::epsilon() * magnitude};
}

/// The derivative of a polynomial, times `rate`.
template <Precise Real, std::size_t Size>
std::array<Real, Size - 1> derivative(const std::array<Real, Size>& c, Real rate = 1) {
  std::array<Real, Size - 1> result;
  for (std::size_t i = 1; i < Size; ++i) result[i - 1] = static_cast<Real>(i) * c[i] * rate;
  return result;
}

}  // namespace inbetween
