// Cubic splines through given values, in the form that a path has.
#pragma once

#include <span>
#include <vector>

#include "inbetween/path/path.hpp"

namespace inbetween {

/// Values at the ends of each step of a parameter, and the derivatives by it at both ends.
struct SplineRun {
  std::vector<double> steps;
  std::vector<double> values;  // one more than steps
  double first_slope = 0;
  double last_slope = 0;
  bool periodic = false;  // instead of the slopes: the end goes on as the start, a lap higher
};

/// The C2 cubic spline (de Boor, A Practical Guide to Splines, ch. IV): a cubic for each step on t from 0
/// to 1. O(steps).
std::vector<Cubic> spline_through(const SplineRun& run);

/// The derivative at the first of five values with equal steps between, exact for polynomials of degree 4.
double first_slope_of(std::span<const double, 5> values, double step);

/// c(begin + size t) as a cubic in t.
inline Cubic cut(const Cubic& c, double begin, double size) {
  return {c.value(begin), size * c.derivative(begin), size * size * c.second(begin) / 2,
          size * size * size * c.c3};
}

}  // namespace inbetween
