#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "inbetween/timing/frame_table.hpp"
#include "inbetween/timing/track.hpp"

/// The paper's own solver, kept as a second opinion on the closed form and for the benchmark.

namespace inbetween {

struct OdeOptions {
  std::int32_t substeps = 10;  ///< k of the paper's Figure 3: Runge-Kutta steps a frame
  double tolerance = 1e-9;     ///< of K, relative; ZEROIN stops there
};

/// The speed of one segment, precomputed for the integration: sigma(t) = scale * sqrt(q(t)).
struct OdeSegment {
  double q0 = 0, q1 = 0, q2 = 0, q3 = 0, q4 = 0;
  double scale = 0;
};

/// Solves ds/da = K phi(a) / |dP/ds|, s(0) = 0, s(f) = n, by classical Runge-Kutta of order 4 with k
/// steps a frame and Dekker and Brent's ZEROIN on K (Brent 1973, ch. 4), after trial integrations
/// that bracket it. Beyond its end the path goes on for a slack of 0.5 in s along its last tangent.
/// The table carries the worst speed error, measured against the arc length.
///
/// `segments` has room for segment_count() + 1 entries, `memory` for N + 1 points.
/// Errors: singular (a speed of 0 on the path: use the closed form), not_bracketed, not_converged,
/// accuracy (worst speed error above 2 %: use a larger k), out_of_range (k; a track with breaks, or
/// timed by frames), capacity.
/// Cost: 4 k N evaluations for each of about ten integrations.
Result<FrameTable> runge_kutta_table(const Track& track, const OdeOptions& options,
                                     std::span<OdeSegment> segments, std::span<PathPoint> memory);

}  // namespace inbetween
