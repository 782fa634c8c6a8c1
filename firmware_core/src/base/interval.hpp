#pragma once

#include <array>
#include <cstddef>
#include <limits>

#include "base/lanes.hpp"
#include "inbetween/base/precision.hpp"

/// Interval arithmetic, rounded to nearest: a proof that uses it adds the rounding at the end. A Number is a
/// double or Lanes of them.

namespace inbetween {

template <class Number>
struct Interval {
  Number low{};
  Number high{};

  /// The same in all lanes.
  static constexpr Interval of(const Interval<double>& range) { return {range.low, range.high}; }
  friend constexpr Interval operator+(const Interval& a, const Interval& b) {
    return {a.low + b.low, a.high + b.high};
  }
  friend constexpr Interval operator*(const Interval& a, const Interval& b) {
    const Number ll = a.low * b.low;
    const Number lh = a.low * b.high;
    const Number hl = a.high * b.low;
    const Number hh = a.high * b.high;
    return {least(least(ll, lh), least(hl, hh)), greatest(greatest(ll, lh), greatest(hl, hh))};
  }
  /// Of a number that is not below 0.
  [[nodiscard]] constexpr Interval times(const Number& a) const { return {a * low, a * high}; }
  /// `a` has nothing below 0.
  [[nodiscard]] constexpr Interval times(const Interval& a) const {
    return {least(low * a.low, low * a.high), greatest(high * a.low, high * a.high)};
  }
  /// The product is not a number if an end is none (0 times infinity).
  [[nodiscard]] Number magnitude() const {
    const Number a = absolute(low);
    const Number b = absolute(high);
    const Number sum = a + b;
    return if_less(Number(-1), sum, greatest(a, b), sum);
  }
};

/// A polynomial near a point: its value there and how far from that it can be within a radius, rounding of
/// the value included.
template <class Number>
struct Centred {
  Number value{};
  Number spread{};

  [[nodiscard]] Interval<Number> range() const { return {value - spread, value + spread}; }
};

/// The same of the derivative, too, and the rounding alone.
template <class Number>
struct CentredSlope {
  Centred<Number> value;
  Centred<Number> slope;
  Number rounding{};  ///< of the value
};

/// The polynomial c[0] + c[1] x + ... about `x` >= 0, by its Taylor coefficients there (centred form).
template <class Number, std::size_t Size>
CentredSlope<Number> centred_slope(const std::array<Number, Size>& coefficients, double x, double radius) {
  std::array<Number, Size> c = coefficients;
  constexpr double rounding = 32 * std::numeric_limits<double>::epsilon();
  const double reach = x + radius;
  Number magnitude{};
  for (std::size_t i = Size; i-- > 0;) magnitude = magnitude * reach + absolute(c[i]);
  for (std::size_t i = 0; i + 1 < Size; ++i) {
    for (std::size_t j = Size - 1; j-- > i;) c[j] = c[j] + x * c[j + 1];
  }
  Number spread{};
  Number slope_spread{};
  for (std::size_t i = Size; i-- > 1;) {
    if (i > 1) slope_spread = (slope_spread + static_cast<double>(i) * absolute(c[i])) * radius;
    spread = (spread + absolute(c[i])) * radius;
  }
  return {{c[0], spread + rounding * magnitude},
          {c[1], slope_spread + (static_cast<double>(Size) * rounding / reach) * magnitude},
          rounding * magnitude};
}
template <class Number, std::size_t Size>
Centred<Number> centred(const std::array<Number, Size>& c, double x, double radius) {
  return centred_slope(c, x, radius).value;
}

/// The derivative of a polynomial, times `rate`.
template <std::size_t Size>
std::array<double, Size - 1> derivative(const std::array<double, Size>& c, double rate = 1) {
  std::array<double, Size - 1> result;
  for (std::size_t i = 1; i < Size; ++i) result[i - 1] = static_cast<double>(i) * c[i] * rate;
  return result;
}

}  // namespace inbetween
