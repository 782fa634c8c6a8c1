#pragma once

#include "inbetween/base/precision.hpp"

namespace inbetween {

/// The largest magnitude of an angle whose sine is computed, in radians: up to here the number of quarter
/// turns times the leading parts of pi/2 has no rounding error.
inline constexpr double max_angle = 1e6;

struct SineCosine {
  double sine = 0;
  double cosine = 1;
};

/// Sine and cosine of an angle in radians, |angle| <= max_angle, each within one unit in the last place
/// of the exact value. Same bits on every target: sums and products only, and no call of a mathematical
/// library, whose results differ from one to the next.
///
/// Method: subtraction of quarter turns with pi/2 in three parts (Cody and Waite, Software Manual for the
/// Elementary Functions, 1980), then the Taylor series on [-pi/4, pi/4]. About 60 operations.
SineCosine sine_cosine(double angle);

}  // namespace inbetween
