// The three peaks of an axis by their names.
#pragma once

#include <array>

#include "host_tools/check/check.hpp"

namespace inbetween {

struct NamedPeak {
  const char* name;
  const char* per;
  const CheckedPeak& peak;
};

/// Of a CheckedAxis or a CheckedMotor.
template <class Axis>
std::array<NamedPeak, 3> peaks_of(const Axis& axis) {
  return {{{"velocity", "/s", axis.velocity},
           {"acceleration", "/s^2", axis.acceleration},
           {"jerk", "/s^3", axis.jerk}}};
}

}  // namespace inbetween
