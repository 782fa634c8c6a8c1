#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "inbetween/base/precision.hpp"

namespace inbetween {

/// An abscissa and the function there.
struct Sample {
  double x = 0;
  double y = 0;
};

/// Dekker and Brent's ZEROIN (Brent 1973, Algorithms for Minimization without Derivatives, ch. 4): bisection
/// made safe and fast by the secant and inverse quadratic interpolation. `a` and `b` bracket a zero. Ends
/// when the bracket is within 4 eps |x| + tolerance, or after `max_evaluations` evaluations. It returns the
/// best sample, whose y says how good it is.
template <class Function>
Sample zeroin(Function function, Sample a, Sample b, double tolerance, std::int32_t max_evaluations) {
  Sample c = a;  // b is the best so far, a the one before, c on the other side of the zero from b
  double step = b.x - a.x;
  double step_before = step;
  for (std::int32_t evaluations = 0; evaluations < max_evaluations; ++evaluations) {
    if ((b.y > 0) == (c.y > 0)) {
      c = a;
      step = step_before = b.x - a.x;
    }
    if (std::fabs(c.y) < std::fabs(b.y)) {
      a = b;
      b = c;
      c = a;
    }
    const double near = 2 * std::numeric_limits<double>::epsilon() * std::fabs(b.x) + tolerance / 2;
    const double half = (c.x - b.x) / 2;
    if (std::fabs(half) <= near || b.y == 0) return b;

    double next = half;
    double last = half;
    if (std::fabs(step_before) >= near && std::fabs(a.y) > std::fabs(b.y)) {
      const double s = b.y / a.y;
      double p = 2 * half * s;
      double q = 1 - s;
      if (a.x != c.x) {  // three different samples: inverse quadratic
        const double r = b.y / c.y;
        const double u = a.y / c.y;
        p = s * (2 * half * u * (u - r) - (b.x - a.x) * (r - 1));
        q = (u - 1) * (r - 1) * (s - 1);
      }
      if (p > 0) q = -q;
      p = std::fabs(p);
      // Accepted when it stays in the bracket and at least halves the step before the last.
      if (2 * p < 3 * half * q - std::fabs(near * q) && 2 * p < std::fabs(step_before * q)) {
        last = step;
        next = p / q;
      }
    }
    step_before = last;
    step = next;
    a = b;
    b.x += std::fabs(step) > near ? step : std::copysign(near, half);
    b.y = function(b.x);
  }
  return std::fabs(a.y) < std::fabs(b.y) ? a : b;
}

}  // namespace inbetween
