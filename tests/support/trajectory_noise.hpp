// What double precision leaves uncertain in the derivatives of a trajectory.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "host_tools/plan/fitted_trajectory.hpp"
#include "inbetween/limits/motion_cells.hpp"
#include "inbetween/trajectory/axis_peaks.hpp"

namespace inbetween {

/// What the rounding of positions, and of the distance, may add to the derivatives on the piece at a frame.
inline MotionTriple noise_at(const FittedTrajectory& fitted, std::size_t axis, double frame) {
  const double whole = std::floor(frame);
  const FrameTime time{static_cast<std::int32_t>(whole), frame - whole};
  const std::size_t here = time < fitted->end() ? fitted->piece_at(time) : fitted->pieces().size() - 1;
  // The peak may stand at a joint.
  double seconds = fitted->pieces()[here].seconds;
  for (const std::size_t beside : {here - 1, here + 1}) {
    if (beside < fitted->pieces().size()) seconds = std::min(seconds, fitted->pieces()[beside].seconds);
  }
  const double position = std::fabs(fitted->values()[fitted->pieces()[here].begin_row + axis]);
  const double weight = fitted.sampler().weight(axis);
  const double size = 8 * std::numeric_limits<double>::epsilon() *
                      (position + (weight > 0 ? fitted.sampler().length() / weight : position));
  // Where the path nearly stands still the chain rule takes large numbers from each other.
  const double chain =
      1e-9 * std::fabs(fitted->values()[fitted->pieces()[here].begin_row + fitted->axis_count() + axis]);
  // The largest coefficients of the derivatives of Hermite's septic.
  return {4 * size / seconds, (84 * size / seconds + chain) / seconds,
          (1680 * size / seconds + chain) / seconds / seconds};
}

/// Of each derivative, where it is largest.
inline MotionTriple noise_at_peaks(const FittedTrajectory& fitted, std::size_t axis, const AxisPeaks& peaks) {
  return {noise_at(fitted, axis, peaks.velocity.frame)[0],
          noise_at(fitted, axis, peaks.acceleration.frame)[1], noise_at(fitted, axis, peaks.jerk.frame)[2]};
}

}  // namespace inbetween
