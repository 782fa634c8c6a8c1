#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "inbetween/base/precision.hpp"
#include "inbetween/timing/speed_profile.hpp"

/// The integral of a speed curve as a sum over its control values.

namespace inbetween {

/// Integral of the cardinal cubic B-spline with support (-2, 2) from -2 to x.
inline double bspline_integral(double x) {
  if (x <= -2) return 0;
  if (x >= 2) return 1;
  const double y = x > 0 ? -x : x;  // the spline is even
  const double u = y + 2;
  const double below = y <= -1 ? u * u * u * u / 24 : 0.5 + y * (2.0 / 3 - y * y * (1.0 / 3 + y / 8));
  return x > 0 ? 1 - below : below;
}

/// How the integral of phi over [begin, end], 0 <= begin <= end <= f, depends on each control value, the ends
/// of the curve included. Only values first()..last() count. A periodic curve has f different values, and
/// goes on from the last of them to the first: index() tells which one is meant.
class IntegralRow {
 public:
  IntegralRow(double begin, double end, std::int32_t f, CurveEnds ends = CurveEnds::natural)
      : begin_(begin), end_(end), f_(f), is_periodic_(ends == CurveEnds::periodic) {}

  [[nodiscard]] std::int32_t first() const {
    const std::int32_t first = static_cast<std::int32_t>(begin_) - 2;
    return is_periodic_ ? first : std::max<std::int32_t>(0, first);
  }
  [[nodiscard]] std::int32_t last() const {
    const std::int32_t last = static_cast<std::int32_t>(end_) + 3;
    return is_periodic_ ? std::min(first() + f_ - 1, last) : std::min(f_, last);
  }
  [[nodiscard]] std::size_t index(std::int32_t i) const {
    return static_cast<std::size_t>(is_periodic_ ? (i + 2 * f_) % f_ : i);
  }
  /// Whether the row reaches over the end of a periodic curve to its first values.
  [[nodiscard]] bool wraps() const { return is_periodic_ && static_cast<std::int32_t>(end_) + 3 >= f_; }

  [[nodiscard]] double weight(std::int32_t i) const {
    double sum = 0;
    if (is_periodic_) {
      const auto first = static_cast<std::int32_t>(index(i)) - f_;
      for (std::int32_t k = first; k <= f_ + 1; k += f_) sum += spline(k);
      return sum;
    }
    sum = spline(i);
    if (i == 0) sum += 2 * spline(-1);  // the phantom value is 2 v_0 - v_1
    if (i == 1) sum -= spline(-1);
    if (i == f_) sum += 2 * spline(f_ + 1);
    if (i == f_ - 1) sum -= spline(f_ + 1);
    return sum;
  }
  [[nodiscard]] double integral(std::span<const double> values) const {
    double sum = 0;
    for (std::int32_t i = first(); i <= last(); ++i) sum += weight(i) * values[index(i)];
    return sum;
  }

 private:
  [[nodiscard]] double spline(std::int32_t i) const {
    const auto centre = static_cast<double>(i);
    return bspline_integral(end_ - centre) - bspline_integral(begin_ - centre);
  }
  double begin_, end_;
  std::int32_t f_;
  bool is_periodic_;
};

}  // namespace inbetween
