#pragma once

#include <array>
#include <cstddef>

#include "inbetween/base/precision.hpp"

namespace inbetween {

/// Velocity, acceleration and jerk of one axis, as magnitudes.
inline constexpr std::size_t motion_quantities = 3;
using MotionTriple = std::array<double, motion_quantities>;

/// A proven bound, and the frame, which need not be a whole one, near which it is reached.
struct Peak {
  double value = 0;
  double frame = 0;

  constexpr void raise(double to, double at_frame) {
    if (to > value) *this = {to, at_frame};
  }
};

/// One axis over a move or a part of it, in axis units and seconds. Velocity, acceleration and jerk are
/// suprema of the magnitude over the open stretches between keys and knots of the speed curve, and of their
/// one-sided limits: what steps at a key is listed apart. Infinity where there is no bound.
struct AxisPeaks {
  Peak lowest, highest;  ///< position
  Peak velocity, acceleration, jerk;

  /// This takes in the peaks of another part of the same axis' motion.
  constexpr void raise(const AxisPeaks& other) {
    if (other.lowest.value < lowest.value) lowest = other.lowest;
    highest.raise(other.highest.value, other.highest.frame);
    velocity.raise(other.velocity.value, other.velocity.frame);
    acceleration.raise(other.acceleration.value, other.acceleration.frame);
    jerk.raise(other.jerk.value, other.jerk.frame);
  }
};

}  // namespace inbetween
