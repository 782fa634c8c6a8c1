#pragma once

#include <cmath>

#include "inbetween/base/precision.hpp"

namespace inbetween {

/// The cube root of x >= 0: not below the root, and at most 4 roundings above it. Newton's method from above:
/// of libm the core uses only functions that are exact on every target.
inline double cube_root(double x) {
  if (!(x > 0) || !std::isfinite(x)) return x;
  int exponent = 0;
  double mantissa = std::frexp(x, &exponent);
  while (exponent % 3 != 0) {
    mantissa /= 2;
    ++exponent;
  }
  double root = 1;
  for (int i = 0; i < 10; ++i) root = (2 * root + mantissa / (root * root)) / 3;
  return std::ldexp(root, exponent / 3);
}

}  // namespace inbetween
