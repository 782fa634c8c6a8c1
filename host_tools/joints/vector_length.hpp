// The length of a vector.
#pragma once

#include <cmath>

#include "inbetween/joints/pose.hpp"

namespace inbetween {

inline double length(const Vector3& v) {
  return std::sqrt(dot(v, v));
}

}  // namespace inbetween
