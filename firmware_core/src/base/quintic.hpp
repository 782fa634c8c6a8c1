#pragma once

#include <array>

#include "inbetween/base/precision.hpp"

/// The quintic between two states: the motion of an axis, or of a playhead, between two ticks.

namespace inbetween {

/// Coefficients of u^0, u^1, ... u^5; u runs from 0 to 1.
using Quintic = std::array<double, 6>;

/// A value with its first and second derivative by u.
struct QuinticEnd {
  double value = 0, first = 0, second = 0;
};

/// The one quintic with these values and derivatives at u = 0 and u = 1.
constexpr Quintic joining(const QuinticEnd& start, const QuinticEnd& end) {
  // The parabola from the start misses the end by this much, which the upper three coefficients make up for.
  const double d = end.value - start.value - start.first - start.second / 2;
  const double e = end.first - start.first - start.second;
  const double f = end.second - start.second;
  return {start.value,         start.first,          start.second / 2, 10 * d - 4 * e + f / 2,
          -15 * d + 7 * e - f, 6 * d - 3 * e + f / 2};
}

constexpr double value_at(const Quintic& p, double u) {
  return ((((p[5] * u + p[4]) * u + p[3]) * u + p[2]) * u + p[1]) * u + p[0];
}

}  // namespace inbetween
