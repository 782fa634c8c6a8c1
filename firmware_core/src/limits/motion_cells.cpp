#include "inbetween/limits/motion_cells.hpp"

#include <algorithm>
#include <cmath>

#include "inbetween/limits/roll_trajectory.hpp"

namespace inbetween {
namespace {

/// Beyond the rounding of the few products of a bound.
constexpr double bound_rounding = 1e-12;

}  // namespace

void raise_cells(const Trajectory& trajectory, const FrameTime<double>& from, const FrameTime<double>& to,
                 std::size_t first_axis, const MotionCells& cells) {
  bound_cells(trajectory, from, to, cells.line, cells.room.subspan(first_axis),
              cells.suprema.subspan(first_axis), cells.stride());
}

Status raise_cells(std::span<const RollAxis<double>> rolls, std::size_t first_axis, const MotionCells& cells,
                   const TrajectoryMemory& memory) {
  if (rolls.empty()) return Done{};
  const Result<Trajectory> trajectory = roll_trajectory(rolls, memory);
  if (!trajectory) return trajectory.error();
  raise_cells(*trajectory, trajectory->begin(), trajectory->end(), first_axis, cells);
  return Done{};
}

void bound_motor(const MotionCells& cells, std::size_t cell, std::size_t motor, const CalibratedMotor& by,
                 double middle) {
  const double cell_frames = static_cast<double>(cells.line.last_frame - cells.line.first_frame) /
                             static_cast<double>(cells.line.cells);
  // Beyond either end of a cell lies the rounding of a frame number.
  constexpr double beyond = 1.001;
  const double half_seconds = beyond * cell_frames / 2 / cells.fps.frames_per_second();
  const std::span<MotionTriple> suprema = cells.of_cell(cell);
  const MotionTriple& axis = suprema[by.axis];
  const double reach = axis[0] * half_seconds;
  MotionTriple& out = suprema[cells.axes + motor];
  out = motor_motion(by.calibration->bounds(middle - reach, middle + reach), axis);
  for (double& value : out) value *= 1 + bound_rounding;
}

/// First the one after it, and then, from the end on, the one before with what that has taken in.
void widen(const MotionCells& cells) {
  const std::span<MotionTriple> suprema = cells.suprema;
  const std::size_t stride = cells.stride();
  const auto take_in = [](MotionTriple& supremum, const MotionTriple& other) {
    for (std::size_t i = 0; i < motion_quantities; ++i) supremum[i] = std::max(supremum[i], other[i]);
  };
  for (std::size_t i = 0; i + stride < suprema.size(); ++i) take_in(suprema[i], suprema[i + stride]);
  for (std::size_t i = suprema.size(); i-- > stride;) take_in(suprema[i], suprema[i - stride]);
}

}  // namespace inbetween
