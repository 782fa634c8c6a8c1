// The paper's own solver, kept as a second opinion on the closed form and for the benchmark.
#pragma once

#include <cstdint>
#include <span>

#include "inbetween/timing/frame_table.hpp"
#include "inbetween/timing/track.hpp"

namespace inbetween {

/// Who makes a table of frames.
enum class Solver : std::uint8_t {
  closed_form,  ///< L(s) = K Phi(a), inverted
  runge_kutta,  ///< Bartels and Hardtke 1989, Figure 3: integration, with a root finder on K
};

struct OdeOptions {
  std::int32_t substeps = 10;  ///< k of the paper's Figure 3: Runge-Kutta steps a frame
  double tolerance = 1e-9;     ///< of K, relative; ZEROIN stops there
};

/// A table by integration, and how it came about.
struct OdeTable {
  FrameTable table;
  std::int32_t integrations = 0;        ///< of the whole move
  std::int32_t substeps = 0;            ///< k
  std::int32_t speed_error_frame = -1;  ///< the step that ends on this frame is the worst
};

/// Solves ds/da = K phi(a) / |dP/ds|, s(0) = 0, s(f) = n, by classical Runge-Kutta of order 4 with k
/// steps a frame and Dekker and Brent's ZEROIN on K (Brent 1973, ch. 4), after trial integrations
/// that bracket it. Beyond its end the path goes on for a slack of 0.5 in s along its last tangent.
/// The table carries the worst speed error, measured against the arc length.
///
/// `memory` has room for N + 1 points.
/// Errors: singular (a speed of 0 on the path: use the closed form), not_bracketed, not_converged,
/// accuracy (worst speed error above 2 %: use a larger k), out_of_range (k; a track with breaks, or
/// timed by frames), capacity.
/// Cost: 4 k N evaluations for each of about ten integrations.
Result<OdeTable> runge_kutta_table(const Track& track, const OdeOptions& options,
                                   std::span<PathPoint> memory);

}  // namespace inbetween
