// The motion beside the joints of a track that is cubic in time, from its positions alone.
#pragma once

#include <cstdint>

#include "host_tools/plan/solved_track.hpp"

namespace inbetween {

/// Derivatives on one side of a frame, per second.
struct Sided {
  double velocity = 0, acceleration = 0;
};

/// From four positions of a cubic (Lagrange), `step` frames apart.
Sided rediff(const SolvedTrack& track, std::int32_t axis, double frame, double step);

/// The largest of a quantity of an axis, four times a frame.
double largest(const SolvedTrack& track, std::int32_t axis, double AxisMotion::*quantity);

/// At every joint the velocity of an axis, and the acceleration where that is asked for, are the same on both
/// sides but for 1e-9 of the largest and what rounding of a position of this size becomes (RC_ASSERT).
void expect_no_steps(const SolvedTrack& track, std::int32_t axis, double size, bool of_acceleration);

}  // namespace inbetween
