#pragma once

#include <concepts>
#include <limits>

namespace inbetween {

/// Precision is one template parameter of the whole core, named Real. Every class is compiled once for double
/// (Linux, Cortex-M7) and once for float (Cortex-M4F, whose hardware knows nothing wider) from the same
/// source. All differences between the two stand here.
template <class Real>
struct Precision;

template <>
struct Precision<double> {
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

template <>
struct Precision<float> {
  static constexpr float largest = 1e15F;
  static constexpr float default_delta = 1e-5F;
  /// The residual of a piece is itself known to a few 2^-24.
  static constexpr float smallest_delta = 4e-6F;
  static constexpr float negligible_share = 1e-8F;
  static constexpr float smallest_square_root = 1e-12F;
  static constexpr float largest_square_root = 1e18F;
};

template <class Real>
concept Precise = std::same_as<Real, double> || std::same_as<Real, float>;

/// A sum carried in two numbers: `high` is the rounded sum, `low` what the rounding lost.
/// Lengths along a path are kept this way so that a distance *within* a segment has the full
/// precision of Real however far the segment is from the start of the path.
template <Precise Real>
struct TwoSum {
  Real high = 0;
  Real low = 0;

  friend constexpr bool operator==(const TwoSum&, const TwoSum&) = default;
  /// Exact to about twice the precision of Real (Knuth, TAOCP vol. 2, 4.2.2, Theorem B).
  constexpr void add(Real term) {
    const Real sum = high + term;
    const Real part = sum - high;
    low += (high - (sum - part)) + (term - part);
    high = sum;
  }
  /// Puts as much as possible into `high`.
  constexpr void renormalize() {
    const Real sum = high + low;
    low = low - (sum - high);
    high = sum;
  }
  /// high + low - other, rounded once where the two are close.
  [[nodiscard]] constexpr Real minus(const TwoSum& other) const {
    return (high - other.high) + (low - other.low);
  }
};

/// a * b as a rounded product and what the rounding lost (Dekker 1971, with Veltkamp's splitting; no
/// fused multiply-add, which not every target has).
template <Precise Real>
constexpr TwoSum<Real> two_product(Real a, Real b) {
  constexpr int half = (std::numeric_limits<Real>::digits + 1) / 2;
  constexpr Real splitter = static_cast<Real>((1 << half) + 1);
  const Real a_scaled = a * splitter;
  const Real a_high = a_scaled - (a_scaled - a);
  const Real b_scaled = b * splitter;
  const Real b_high = b_scaled - (b_scaled - b);
  const Real a_low = a - a_high;
  const Real b_low = b - b_high;
  const Real high = a * b;
  return {high, ((a_high * b_high - high) + a_high * b_low + a_low * b_high) + a_low * b_low};
}

/// (segment, t) on a path: s = segment + t. Two numbers, because s = 99.x in one number loses the digits of
/// t. The end of an open path of n segments is {n, 0}.
template <Precise Real>
struct PathPoint {
  int segment = 0;
  Real t = 0;

  friend constexpr bool operator==(const PathPoint&, const PathPoint&) = default;
  /// Whether this place comes before the other, or is the same.
  [[nodiscard]] constexpr bool at_or_before(const PathPoint& other) const {
    return segment < other.segment || (segment == other.segment && t <= other.t);
  }
};

}  // namespace inbetween
