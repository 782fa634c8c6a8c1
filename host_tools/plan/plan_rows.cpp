#include "host_tools/plan/plan_rows.hpp"

#include <algorithm>
#include <span>

namespace inbetween {
namespace {

/// A key is met on its frame as nearly as the core's lock is: 2e-12 of the length, which is this share of the
/// frames or less wherever the axes pass the key with a five-hundredth of their mean speed.
constexpr double met_share = 1e-9;

/// A row that a key is passed on, the key a rounding later: the moment of the key. Any other row as it is.
FrameTime leaving_time(const Trajectory& trajectory, const FrameTime& row) {
  const double frames = frames_between(trajectory.begin(), trajectory.end());
  const FrameTime latest = moved_by(row, met_share * frames);
  const std::span<const TrajectoryBreak> breaks = trajectory.breaks();
  const auto behind =
      std::ranges::partition_point(breaks, [&](const TrajectoryBreak& one) { return one.time <= latest; });
  if (behind == breaks.begin()) return row;
  const FrameTime& met = (behind - 1)->time;
  return row < met && met < trajectory.end() ? met : row;
}

}  // namespace

TimeLine::TimeLine(const Plan& plan, PlanRows rows)
    : move_(plan.played()), rows_(rows), rate_hz_(rows == PlanRows::tick ? plan.rig()->rate_hz : 0) {}

std::int64_t TimeLine::last() const {
  return rows_ == PlanRows::tick ? move_.last_tick_at(rate_hz_) : move_.last_frame();
}

FrameTime TimeLine::at(std::int64_t row) const {
  if (rows_ == PlanRows::frame) return {static_cast<std::int32_t>(row), 0};
  return move_.time_of_tick(row, rate_hz_);
}

double TimeLine::seconds(std::int64_t row) const {
  if (rows_ == PlanRows::tick) return static_cast<double>(row) / rate_hz_;
  return static_cast<double>(row) * move_.frame_rate().denominator / move_.frame_rate().numerator;
}

AxisColumn::AxisColumn(const Plan& plan, const PlanAxis& axis, PlanRows rows)
    : line_(plan, rows),
      rows_(rows),
      solved_(plan.tracks()[*axis.track]),
      trajectory_(plan.motion().trajectories()[*axis.track]),
      axis_(axis.track_axis),
      move_axis_(axis.move_axis) {}

double AxisColumn::position(const FrameTime& when) const {
  const Move& move = line_.move();
  const auto rolls = move.rolls_at(when);
  if (!rolls.empty()) return rolls[move_axis_].motion(when).position;
  const FrameTime within = move.within_part(when);
  const bool is_in_table = solved_.integrated() && rows_ == PlanRows::frame && within.fraction == 0;
  if (!is_in_table) return trajectory_.motion_of(axis_, within).position;
  return solved_.track().path().position(solved_.table().point(within.frame),
                                         static_cast<std::int32_t>(axis_));
}

AxisMotion AxisColumn::motion(std::int64_t row) const {
  const FrameTime when = line_.at(row);
  const auto rolls = line_.move().rolls_at(when);
  if (!rolls.empty()) return rolls[move_axis_].motion(when);
  return trajectory_.motion_of(axis_, leaving_time(trajectory_, line_.move().within_part(when)));
}

std::string unit_of(const PlanAxis& axis) {
  return axis.unit ? std::string(to_string(*axis.unit)) : "";
}

}  // namespace inbetween
