#include "inbetween/limits/motion_cells.hpp"

#include <algorithm>

#include "inbetween/limits/roll_trajectory.hpp"

namespace inbetween {

void raise_cells(const Trajectory& trajectory, const FrameTime& from, const FrameTime& to,
                 std::size_t first_axis, const MotionCells& cells) {
  bound_cells(trajectory, from, to, cells.line, cells.room.subspan(first_axis),
              cells.suprema.subspan(first_axis), cells.stride());
}

Status raise_cells(std::span<const RollAxis> rolls, std::size_t first_axis, const MotionCells& cells,
                   const TrajectoryMemory& memory) {
  if (rolls.empty()) return Done{};
  const Result<Trajectory> trajectory = roll_trajectory(rolls, memory);
  if (!trajectory) return trajectory.error();
  raise_cells(*trajectory, trajectory->begin(), trajectory->end(), first_axis, cells);
  return Done{};
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
