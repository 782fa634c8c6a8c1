// What is proven of a move: the core's bounds with memory from the heap, as large as it needs to be.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "inbetween/limits/move_bounds.hpp"

namespace inbetween {

/// What is asked of the bounds beside peaks and steps.
struct BoundRequest {
  std::span<const AxisLimits> limits = {};  ///< one for every axis, or none (bound_move)
  std::span<const CalibratedMotor> motors = {};
  std::size_t cells = 0;                ///< of the time line
  std::vector<MotionTriple> room = {};  ///< of every axis and motor in the cells; MotionCells::room
};

/// It refers to nothing when it is made.
class BoundedMove {
 public:
  /// Throws SolverError where a track has more axes than the core can bound.
  BoundedMove(const Move& move, std::span<const Track> tracks, BoundRequest request = {});
  BoundedMove(BoundedMove&&) noexcept = default;
  BoundedMove& operator=(BoundedMove&&) noexcept = default;

  /// Every axis, and behind them every motor, has an entry.
  [[nodiscard]] const std::vector<AxisPeaks>& peaks() const { return peaks_; }
  [[nodiscard]] std::span<const MoveStep> steps() const {
    return std::span(steps_).first(bounds_.step_count);
  }
  [[nodiscard]] const MotionCells& cells() const { return bounds_.cells; }

 private:
  std::vector<AxisPeaks> peaks_;
  std::vector<MoveStep> steps_;
  std::vector<MotionTriple> room_;
  std::vector<MotionTriple> suprema_;
  MoveBounds bounds_;
};

}  // namespace inbetween
