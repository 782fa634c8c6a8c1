#include "host_tools/check/planned_stops.hpp"

#include <algorithm>

#include "host_tools/files/rig_motors.hpp"
#include "host_tools/plan/move_rolls.hpp"

namespace inbetween {
namespace {

constexpr std::int64_t max_cells = 4096;
constexpr std::int64_t min_cells = 64;

/// The slopes of a calibration are those of the worst place in a cell: shorter ones are nearer to the truth.
constexpr std::int64_t cells_per_calibrated_frame = 8;

std::size_t cell_count(const Plan& plan, double rate, bool has_motors) {
  const std::int64_t frames = plan.played().last_frame() - plan.played().first_frame();
  const std::int64_t ticks =
      last_tick(static_cast<std::int32_t>(frames), plan.played().frame_rate(), plan.rig()->rate_hz);
  const auto longest = static_cast<std::int64_t>(static_cast<double>(ticks) / (2 * std::max(rate, 1.0)));
  const std::int64_t per_frame = has_motors ? cells_per_calibrated_frame : 1;
  const std::int64_t wanted = std::clamp(per_frame * frames, min_cells, max_cells);
  return static_cast<std::size_t>(std::max<std::int64_t>(std::min(wanted, longest), 1));
}

/// Those of the motion in place of those of a stop.
AxisLimits<double> without_stops(const AxisLimits<double>& limits) {
  return value_or_throw(AxisLimits<double>::make({.min = limits.min(),
                                                  .max = limits.max(),
                                                  .max_velocity = limits.max_velocity(),
                                                  .max_acceleration = limits.max_acceleration(),
                                                  .max_jerk = limits.max_jerk(),
                                                  .stop_acceleration = limits.max_acceleration(),
                                                  .stop_jerk = limits.max_jerk()}));
}

std::vector<AxisLimits<double>> motion_limits_of(const Plan& plan) {
  std::vector<AxisLimits<double>> limits;
  for (std::size_t d = 0; d < plan.limits().size(); ++d) {
    RigAxis axis = plan.rig()->axes[plan.axis_of(d)];
    axis.stop_acceleration = axis.max_acceleration;
    axis.stop_jerk = axis.max_jerk;
    limits.push_back(limits_of(axis));
  }
  return limits;
}

}  // namespace

PlannedMotors planned_motors(const Plan& plan) {
  PlannedMotors planned;
  for (std::size_t d = 0; d < plan.played().axis_count(); ++d) {
    const RigAxis& axis = plan.rig()->axes[plan.axis_of(d)];
    if (!axis.calibration) continue;
    planned.motors.push_back({.axis = d, .calibration = &axis.calibration->motor()});
    planned.limits.push_back(limits_beside_take_up(axis));
  }
  return planned;
}

std::vector<AxisPeaks<double>> peaks_of_motors(const Plan& plan, const PlannedMotors& motors) {
  const Move<double>& move = plan.played();
  std::vector<AxisPeaks<double>> peaks(motors.motors.size());
  if (peaks.empty()) return peaks;
  const std::size_t cells = cell_count(plan, 1, true);
  const std::size_t all = move.axis_count() + peaks.size();
  std::vector<MotionTriple<double>> slack(all);
  std::vector<MotionTriple<double>> suprema(cells * all);
  std::vector<AxisTurn<double>> turns(move.axis_count());
  std::vector<double> places(move.axis_count());
  const MotionCells<double> found{
      .cells = cells, .slack = slack, .suprema = suprema, .motors = peaks.size(), .places = places};
  bound_cells<double>(move, turns, found);
  bound_motors<double>(move, motors.motors, found);
  const double frames = move.last_frame() - move.first_frame();
  for (std::size_t cell = 0; cell < cells; ++cell) {
    const double frame =
        move.first_frame() + frames * ((static_cast<double>(cell) + 0.5) / static_cast<double>(cells));
    for (std::size_t m = 0; m < peaks.size(); ++m) {
      const auto [velocity, acceleration, jerk] = suprema[cell * all + move.axis_count() + m];
      if (velocity > peaks[m].velocity.value) peaks[m].velocity = {velocity, frame};
      if (acceleration > peaks[m].acceleration.value) peaks[m].acceleration = {acceleration, frame};
      if (jerk > peaks[m].jerk.value) peaks[m].jerk = {jerk, frame};
    }
  }
  return peaks;
}

PlannedStops::PlannedStops(const Plan& plan, double rate)
    : PlannedStops(plan, {.move = plan.played(), .limits = {}, .rate = rate}, plan.limits(),
                   cell_count(plan, rate, !planned_motors(plan).motors.empty())) {}

PlannedStops PlannedStops::within_motion_limits(const Plan& plan, double rate, bool may_wait) const {
  return {plan,
          {.move = plan.played(), .limits = {}, .rate = rate, .within = &*bounds_, .may_wait = may_wait},
          motion_limits_of(plan),
          cells_.size() - 1};
}

PlannedStops::PlannedStops(const Plan& plan, StopRequest<double> request,
                           std::vector<AxisLimits<double>> limits, std::size_t cells)
    : motors_(planned_motors(plan)), cells_(cells + 1) {
  const std::size_t axes = plan.played().axis_count();
  const bool is_within = request.within != nullptr;
  for (const AxisLimits<double>& motor : motors_.limits) {
    limits.push_back(is_within ? without_stops(motor) : motor);
  }
  peaks_.resize(limits.size());
  std::vector<MotionTriple<double>> suprema((cells_.size() - 1) * peaks_.size());
  std::vector<AxisTurn<double>> turns(axes);
  std::vector<MotionTriple<double>> slack(peaks_.size());
  std::vector<double> places(axes);
  request.limits = limits;
  request.motors = motors_.motors;
  request.tick_seconds = 1.0 / plan.rig()->rate_hz;
  const StopBoundsMemory<double> memory{
      .cells = cells_, .suprema = suprema, .slack = slack, .turns = turns, .places = places};
  const auto bounds = StopBounds<double>::make(request, memory, peaks_);
  if (bounds || bounds.error().code != ErrorCode::no_solution) {
    bounds_ = value_or_throw(bounds);
    return;
  }
  obstacle_ = value_or_throw(stop_obstacle(request, memory));
  const auto found = static_cast<std::size_t>(obstacle_->axis);
  obstacle_is_of_motor_ = found >= axes;
  if (obstacle_is_of_motor_) obstacle_->axis = static_cast<std::int32_t>(motors_.motors[found - axes].axis);
}

}  // namespace inbetween
