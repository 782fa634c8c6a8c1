#pragma once

#include <cstddef>
#include <span>

#include "inbetween/limits/motion_bounds.hpp"
#include "inbetween/limits/move.hpp"

/// The time line of a move cut into cells of equal length, and how fast and how hard every axis moves in
/// each.

namespace inbetween {

template <Precise Real>
struct MotionCells {
  std::size_t cells = 0;
  std::span<const PeakSlack<Real>> slack;  ///< of all axes: not more than this above the truth needs no work
  std::span<MotionTriple<Real>> suprema;   ///< cell by cell, of all axes, in axis units and seconds
};

/// Suprema of |p1|, |p2|, |p3| over the open stretches within a cell, at most 2 % of what is found in the
/// cell, 0.5 % of what is found of the axis anywhere, or the slack above the truth (more where rounding hides
/// it, as bound_motion says), never below it. `turns` has an entry for every axis of the track that has most.
/// The begin of a cell is known to the rounding of a frame number: a caller that needs more looks at the
/// neighbours too.
template <Precise Real>
void bound_cells(const Move<Real>& move, std::span<AxisTurn<Real>> turns, const MotionCells<Real>& out);

}  // namespace inbetween
