// How a plan can be stopped on its rig: the core's stop bounds with memory from the heap.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "host_tools/plan/bounded_move.hpp"
#include "host_tools/plan/plan.hpp"
#include "inbetween/limits/stop_bounds.hpp"

namespace inbetween {

/// What the take-up of the backlash leaves of the limits of each of Plan::calibrated_motors().
std::vector<AxisLimits> motor_limits(const Plan& plan);

/// What bounds are asked for.
enum class BoundedFor : std::uint8_t { motion, stops };
/// What is proven of the plan's motion, for rates up to `rate` times the drawn speed. A cell of the time line
/// is about a frame, never shorter than two ticks, and never less than a 4096th of the move. Throws
/// SolverError where a track has more axes than the core can bound.
BoundedMove bounded_move(const Plan& plan, double rate, BoundedFor use);

/// Movable. The bounds refer to memory that a move does not displace.
class PlannedStops {
 public:
  /// For rates up to `rate` times the drawn speed. The plan has a rig. Throws as bounded_move().
  explicit PlannedStops(const Plan& plan, double rate = 1);
  /// The same for the drawn speed, from what has been proven for stops; its cells are widened by it.
  PlannedStops(const Plan& plan, const BoundedMove& bounded);
  /// For what is no stop, within the bounds of these stops and for a rate up to theirs: with the limits of
  /// the motion in place of those of a stop. If it may wait there is no obstacle: where the motion leaves
  /// nothing of its limits the rate stays what it is.
  [[nodiscard]] PlannedStops within_motion_limits(const Plan& plan, double rate, bool may_wait) const;
  PlannedStops(PlannedStops&&) noexcept = default;
  PlannedStops& operator=(PlannedStops&&) noexcept = default;

  /// Nothing where there is an obstacle.
  [[nodiscard]] const std::optional<StopBounds>& bounds() const { return bounds_; }
  /// A place from which no stop keeps the limits; its axis is one of Plan::played().
  [[nodiscard]] const std::optional<StopObstacle>& obstacle() const { return obstacle_; }
  /// ... whose motor it is, if it is not the axis itself.
  [[nodiscard]] bool is_of_motor() const { return obstacle_is_of_motor_; }
  /// The most that any playing and stopping asks of each axis of Plan::played(), and behind them of each of
  /// Plan::calibrated_motors().
  [[nodiscard]] const std::vector<AxisPeaks>& peaks() const { return peaks_; }

 private:
  PlannedStops() = default;
  void make(const Plan& plan, StopRequest request);

  std::vector<StopCell> cells_;
  std::vector<AxisPeaks> peaks_;
  std::optional<StopBounds> bounds_;
  std::optional<StopObstacle> obstacle_;
  bool obstacle_is_of_motor_ = false;
};

}  // namespace inbetween
