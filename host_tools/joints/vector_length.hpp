// The length of a vector.
#pragma once

#include <algorithm>
#include <cmath>

#include "inbetween/joints/pose.hpp"

namespace inbetween {

inline double length(const Vector3& v) {
  return std::sqrt(dot(v, v));
}

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
