#pragma once

#include <cstddef>
#include <span>

#include "inbetween/limits/roll.hpp"
#include "inbetween/trajectory/bounds.hpp"

/// The time line of a move cut into cells of equal length, and how fast and how hard every axis moves in
/// each.

namespace inbetween {

/// In each cell there is a triple for every axis of all tracks, and behind them one for every motor that
/// follows an axis through a calibration.
struct MotionCells {
  CellLine line;
  FrameRate fps;
  std::size_t axes = 0;    ///< of all tracks
  std::size_t motors = 0;  ///< behind them
  /// A bound that is at most this much above the truth needs no work. There is one for each axis and motor,
  /// and bound_move() raises it to a share of the peak.
  std::span<MotionTriple> room;
  std::span<MotionTriple> suprema;  ///< of |p1|, |p2|, |p3|, cell by cell, in axis units and seconds

  [[nodiscard]] std::size_t stride() const { return axes + motors; }
  [[nodiscard]] std::span<MotionTriple> of_cell(std::size_t cell) const {
    return suprema.subspan(cell * stride(), stride());
  }
  [[nodiscard]] double middle_frame(std::size_t cell) const {
    const double frames = line.last_frame - line.first_frame;
    return line.first_frame + frames * ((static_cast<double>(cell) + 0.5) / static_cast<double>(line.cells));
  }
};

/// Raises the cells of some axes, from `first_axis` on, by a part of their trajectory (bound_cells).
void raise_cells(const Trajectory& trajectory, const FrameTime& from, const FrameTime& to,
                 std::size_t first_axis, const MotionCells& cells);

/// Raises the cells of some axes, from `first_axis` on, by their rolls. `memory` is free again behind it.
/// Errors: those of roll_trajectory.
Status raise_cells(std::span<const RollAxis> rolls, std::size_t first_axis, const MotionCells& cells,
                   const TrajectoryMemory& memory);

/// Every cell takes in its neighbours.
void widen(const MotionCells& cells);

}  // namespace inbetween
