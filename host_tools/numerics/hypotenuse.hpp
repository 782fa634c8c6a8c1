// The length of a vector of two numbers, to the same bits on every processor.
#pragma once

#include <algorithm>
#include <cmath>

namespace inbetween {

/// The length of (a, b), both finite, within 3 ulp. The last bit of std::hypot is another on 64-bit Arm than
/// on x86-64, because the C library uses a fused multiply-add where there is one; these operations are
/// rounded the same way everywhere. The larger of the two is taken out, so that no square overflows.
inline double hypotenuse(double a, double b) {
  const double larger = std::max(std::fabs(a), std::fabs(b));
  if (larger == 0) return 0;
  const double share = std::min(std::fabs(a), std::fabs(b)) / larger;
  return larger * std::sqrt(1 + share * share);
}

}  // namespace inbetween
