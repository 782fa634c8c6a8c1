#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "inbetween/trajectory/axis_peaks.hpp"
#include "inbetween/trajectory/trajectory.hpp"

/// How far, how fast and how hard a trajectory goes, proven for every moment.

namespace inbetween {

/// Peaks of every axis from one time to another, one-sided at joints and at both: true <= peak <= 1.00001
/// true; lowest and highest within 1e-9 of the distance. Infinity, with the frame, where the asked motion has
/// no bound (Trajectory::unbounded).
///
/// Method: on a piece a derivative is a polynomial, and lies in the hull of its Bernstein coefficients
/// (Farouki 2012, "The Bernstein polynomial basis: a centennial retrospective", section 5); pieces are halved
/// (de Casteljau) until the hull is within 1e-5 of what is reached. `out` has an entry for every axis.
/// Domain: begin() <= from < to <= end(). O(pieces * axes), no allocation.
void bound_trajectory(const Trajectory& trajectory, const FrameTime& from, const FrameTime& to,
                      std::span<AxisPeaks> out);
/// The same from its begin to its end.
void bound_trajectory(const Trajectory& trajectory, std::span<AxisPeaks> out);

/// A time line cut into cells of equal length. A piece belongs to every cell that it has a part of.
struct CellLine {
  std::int32_t first_frame = 0, last_frame = 1;
  std::size_t cells = 0;
};

/// Raises the suprema of |velocity|, |acceleration| and |jerk| of every axis in every cell, so that they are
/// not below those of the trajectory there, and above those of the cell and its two neighbours by no more
/// than 2 % or `room` (of every axis). Infinity where there is no bound. `out` has a triple for every axis of
/// a cell, cell by cell, each `stride` behind the one before. Domain: begin() <= from < to <= end().
/// O((pieces + cells) * axes).
void bound_cells(const Trajectory& trajectory, const FrameTime& from, const FrameTime& to,
                 const CellLine& line, std::span<const MotionTriple> room, std::span<MotionTriple> out,
                 std::size_t stride);

/// How much an axis steps at a break: leaving less arriving, with its sign, in axis units and seconds.
struct TrajectoryStep {
  double velocity = 0;
  double acceleration = 0;
};

/// Those of every axis at a break of the trajectory, which is not that of a part's begin or end. `out` has an
/// entry for every axis. A step of what is not known on both sides is 0. O(axes).
void steps_at(const Trajectory& trajectory, const TrajectoryBreak& at, std::span<TrajectoryStep> out);

}  // namespace inbetween
