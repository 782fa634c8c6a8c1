#pragma once

#include <limits>

namespace inbetween {

/// The whole core computes in double. These numbers say what a double can hold and tell apart.
struct Precision {
  /// The largest magnitude of a coordinate, a weight or a product of both: its square times the
  /// number of axes stays finite after the per-segment scaling by a power of two.
  static constexpr double largest = 1e120;
  static constexpr double default_delta = 1e-6;
  /// A step of 1e-6 of the length at this delta is 4 ulp of the length: less cannot be represented.
  static constexpr double smallest_delta = 1e-9;
  /// A piece of the inverse whose error is below this share of the length needs no further division.
  static constexpr double negligible_share = 1e-16;
  /// Sums of squares of numbers between these two neither overflow nor lose digits to underflow.
  static constexpr double smallest_square_root = 1e-130;
  static constexpr double largest_square_root = 1e150;
};

/// A sum carried in two numbers: `high` is the rounded sum, `low` what the rounding lost.
/// Lengths along a path are kept this way so that a distance *within* a segment has the full
/// precision of a double however far the segment is from the start of the path.
struct TwoSum {
  double high = 0;
  double low = 0;

  friend constexpr bool operator==(const TwoSum&, const TwoSum&) = default;
  /// Exact to about twice the precision of double (Knuth, TAOCP vol. 2, 4.2.2, Theorem B).
  constexpr void add(double term) {
    const double sum = high + term;
    const double part = sum - high;
    low += (high - (sum - part)) + (term - part);
    high = sum;
  }
  /// Puts as much as possible into `high`.
  constexpr void renormalize() {
    const double sum = high + low;
    low = low - (sum - high);
    high = sum;
  }
  /// high + low - other, rounded once where the two are close.
  [[nodiscard]] constexpr double minus(const TwoSum& other) const {
    return (high - other.high) + (low - other.low);
  }
};

/// a * b as a rounded product and what the rounding lost (Dekker 1971, with Veltkamp's splitting; no
/// fused multiply-add, which not every target has).
constexpr TwoSum two_product(double a, double b) {
  constexpr int half = (std::numeric_limits<double>::digits + 1) / 2;
  constexpr double splitter = static_cast<double>((1 << half) + 1);
  const double a_scaled = a * splitter;
  const double a_high = a_scaled - (a_scaled - a);
  const double b_scaled = b * splitter;
  const double b_high = b_scaled - (b_scaled - b);
  const double a_low = a - a_high;
  const double b_low = b - b_high;
  const double high = a * b;
  return {high, ((a_high * b_high - high) + a_high * b_low + a_low * b_high) + a_low * b_low};
}

/// (segment, t) on a path: s = segment + t. Two numbers, because s = 99.x in one number loses the digits of
/// t. The end of an open path of n segments is {n, 0}.
struct PathPoint {
  int segment = 0;
  double t = 0;

  friend constexpr bool operator==(const PathPoint&, const PathPoint&) = default;
  /// Whether this place comes before the other, or is the same.
  [[nodiscard]] constexpr bool at_or_before(const PathPoint& other) const {
    return segment < other.segment || (segment == other.segment && t <= other.t);
  }
};

}  // namespace inbetween
