#pragma once

#include <array>

#include "inbetween/base/precision.hpp"

/// The quintic between two states: the motion of an axis, or of a playhead, between two ticks.

namespace inbetween {

/// Coefficients of u^0, u^1, ... u^5; u runs from 0 to 1.
template <Precise Real>
using Quintic = std::array<Real, 6>;

/// A value with its first and second derivative by u.
template <Precise Real>
struct QuinticEnd {
  Real value = 0, first = 0, second = 0;
};

/// The one quintic with these values and derivatives at u = 0 and u = 1.
template <Precise Real>
constexpr Quintic<Real> joining(const QuinticEnd<Real>& start, const QuinticEnd<Real>& end) {
  // The parabola from the start misses the end by this much, which the upper three coefficients make up for.
  const Real d = end.value - start.value - start.first - start.second / 2;
  const Real e = end.first - start.first - start.second;
  const Real f = end.second - start.second;
  return {start.value,         start.first,          start.second / 2, 10 * d - 4 * e + f / 2,
          -15 * d + 7 * e - f, 6 * d - 3 * e + f / 2};
}

template <Precise Real>
constexpr Real value_at(const Quintic<Real>& p, Real u) {
  return ((((p[5] * u + p[4]) * u + p[3]) * u + p[2]) * u + p[1]) * u + p[0];
}

}  // namespace inbetween
