#pragma once

#include <cstddef>
#include <span>

#include "inbetween/limits/calibration.hpp"
#include "inbetween/limits/motion_bounds.hpp"
#include "inbetween/limits/move.hpp"

/// The time line of a move cut into cells of equal length, and how fast and how hard every axis moves in
/// each.

namespace inbetween {

template <Precise Real>
struct MotionCells {
  std::size_t cells = 0;
  /// A bound of an axis that is at most this much above the truth needs no work. There is one for each of all
  /// axes, and bound_cells() changes them.
  std::span<MotionTriple<Real>> slack;
  std::span<MotionTriple<Real>> suprema;  ///< cell by cell, of all axes, in axis units and seconds
  /// Of so many motors that follow an axis through a calibration, behind the axes in each cell.
  std::size_t motors = 0;
  std::span<Real> places = {};  ///< axes; only with motors
};

/// A motor that follows an axis of the move through a calibration.
template <Precise Real>
struct CalibratedMotor {
  std::size_t axis = 0;  ///< counted through the tracks
  const Calibration<Real>* calibration = nullptr;
};

/// Suprema of |p1|, |p2|, |p3| over the open stretches within a cell, at most 2 % of what is found in the
/// cell, 0.5 % of what is found of the axis anywhere, or the slack above the truth (more where rounding hides
/// it, as bound_motion says), never below it. `turns` has an entry for every axis of the track that has most.
/// The begin of a cell is known to the rounding of a frame number: a caller that needs more looks at the
/// neighbours too.
template <Precise Real>
void bound_cells(const Move<Real>& move, std::span<AxisTurn<Real>> turns, const MotionCells<Real>& out);

/// The same of motors, as many as MotionCells::motors, from what bound_cells has found of their axes. T being
/// the calibration, its slopes are those of the worst place that the axis can have in the cell: the place in
/// its middle, and |p1| times half a cell on either side. Then |T'| |p1|, |T''| |p1|^2 + |T'| |p2| and
/// |T'''| |p1|^3 + 3 |T''| |p1| |p2| + |T'| |p3|. Never below the truth. Above it where T'' p1^2 and T' p2
/// have opposite signs, by at most twice the smaller of them, and where T bends within a cell. O(cells x
/// motors).
template <Precise Real>
void bound_motors(const Move<Real>& move, std::span<const CalibratedMotor<Real>> motors,
                  const MotionCells<Real>& out);

}  // namespace inbetween
