#pragma once

#include <cmath>
#include <cstddef>

#include "inbetween/base/precision.hpp"

namespace inbetween {

/// sqrt of the sum of squares of component(0)..component(count - 1), free of overflow and underflow:
/// where the largest component is far from 1, everything is first scaled by a power of two, which
/// rounds nothing.
template <class Component>
double scaled_norm(std::size_t count, Component component) {
  double largest = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double magnitude = std::fabs(component(i));
    if (magnitude > largest) largest = magnitude;
  }
  if (largest == 0) return 0;
  // Inside this range no square over- or underflows, and scaling would change no bit of the result.
  if (largest > Precision::smallest_square_root && largest < Precision::largest_square_root) {
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i) sum += component(i) * component(i);
    return std::sqrt(sum);
  }
  int exponent = 0;
  static_cast<void>(std::frexp(largest, &exponent));
  double sum = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double scaled = std::ldexp(component(i), -exponent);
    sum += scaled * scaled;
  }
  return std::ldexp(std::sqrt(sum), exponent);
}

}  // namespace inbetween
