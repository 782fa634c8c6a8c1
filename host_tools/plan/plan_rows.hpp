// The rows in which a plan is shown, and the positions of an axis on them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "host_tools/plan/plan.hpp"

namespace inbetween {

enum class PlanRows {
  frame,  ///< the frames that are played; in the CSV also those of the rolls before and behind them
  tick,  ///< ticks of the rig's rate_hz from 0, on the first frame of the pre-roll or of the move, to the end
};

/// The rows of a plan in time, rolls included: frames first_frame()..last_frame(), or ticks from 0. Refers to
/// the plan.
class TimeLine {
 public:
  TimeLine(const Plan& plan, PlanRows rows);

  [[nodiscard]] std::int64_t first() const { return rows_ == PlanRows::tick ? 0 : move_.first_frame(); }
  [[nodiscard]] std::int64_t last() const;
  [[nodiscard]] FrameTime at(std::int64_t row) const;
  [[nodiscard]] const Move& move() const { return move_; }
  /// Counts from the beginning of the move, or of its pre-roll if the rows are ticks.
  [[nodiscard]] double seconds(std::int64_t row) const;

 private:
  const Move& move_;
  PlanRows rows_;
  std::int32_t rate_hz_;
};

/// One axis of a track on the rows of a plan: what plays. Where a move is solved by Runge-Kutta it is on a
/// frame where the frame table has it. Refers to the plan.
class AxisColumn {
 public:
  AxisColumn(const Plan& plan, const PlanAxis& axis, PlanRows rows);

  [[nodiscard]] const TimeLine& line() const { return line_; }
  [[nodiscard]] double position(std::int64_t row) const { return position(line_.at(row)); }
  /// Between the first row and the last.
  [[nodiscard]] double position(const FrameTime& when) const;
  /// Velocity and acceleration are those of what plays; on a key, which may be met a rounding later, those
  /// with which the axis leaves it.
  [[nodiscard]] AxisMotion motion(std::int64_t row) const;

 private:
  TimeLine line_;
  PlanRows rows_;
  const SolvedTrack& solved_;
  const Trajectory& trajectory_;
  std::size_t axis_;
  std::size_t move_axis_;
};

/// "mm"; "" where the plan has no rig.
std::string unit_of(const PlanAxis& axis);

}  // namespace inbetween
