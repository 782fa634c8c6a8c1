// Cubic splines through given values, in the form that a path has.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "inbetween/path/path.hpp"

namespace inbetween {

/// What is asked of a spline at one end beside its value.
enum class SplineEnd : std::uint8_t {
  slope,  ///< a derivative
  free,   ///< nothing: the second derivative is 0, as a thin rod has it
  rest,   ///< both derivatives are 0, by one more knot, a quarter of the step from the end
};

/// Values at the ends of each step of a parameter, and the derivatives by it at both ends.
struct SplineRun {
  std::vector<double> steps;
  std::vector<double> values;  // one more than steps
  double first_slope = 0;
  double last_slope = 0;
  SplineEnd first_end = SplineEnd::slope;
  SplineEnd last_end = SplineEnd::slope;
  bool periodic = false;  // instead of the ends: the end goes on as the start, a lap higher
};

/// The C2 cubic spline (de Boor, A Practical Guide to Splines, ch. IV): a cubic for each step on t from 0
/// to 1, and one more for each end at rest. O(steps).
std::vector<Cubic> spline_through(const SplineRun& run);

/// The derivative at the first of five values with equal steps between, exact for polynomials of degree 4.
double first_slope_of(std::span<const double, 5> values, double step);

/// Cubics over frames as Path::make_of_cubics takes them, with `over_frames`.
struct CubicsOverFrames {
  std::vector<Cubic> cubics;  ///< segment after segment, in each all axes
  std::vector<FrameKnot> knots;
};

/// c(begin + size t) as a cubic in t.
inline Cubic cut(const Cubic& c, double begin, double size) {
  return {c.value(begin), size * c.derivative(begin), size * size * c.second(begin) / 2,
          size * size * size * c.c3};
}

}  // namespace inbetween
