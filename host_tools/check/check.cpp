#include "host_tools/check/check.hpp"

#include <algorithm>
#include <utility>

#include "host_tools/check/check_refusals.hpp"
#include "host_tools/check/planned_stops.hpp"
#include "inbetween/limits/verdict.hpp"

namespace inbetween {
namespace {

CheckedAxis axis_at_rest(const RigAxis& axis) {
  return {.name = axis.name,
          .unit = std::string(to_string(axis.unit)),
          .range = std::nullopt,
          .limit_min = axis.min,
          .limit_max = axis.max,
          .velocity = {.limit = axis.max_velocity},
          .acceleration = {.limit = axis.max_acceleration},
          .jerk = {.limit = axis.max_jerk}};
}

/// The larger of two peaks; where they are equal, the first.
void raise(CheckedPeak& peak, const Peak& found) {
  if (!(found.value > peak.value)) return;
  peak.value = found.value;
  peak.frame = found.frame;
}

void raise(CheckedAxis& axis, const AxisPeaks& peaks) {
  if (!axis.range) axis.range = CheckedRange{peaks.lowest, peaks.highest};
  if (peaks.lowest.value < axis.range->lowest.value) axis.range->lowest = peaks.lowest;
  if (peaks.highest.value > axis.range->highest.value) axis.range->highest = peaks.highest;
  raise(axis.velocity, peaks.velocity);
  raise(axis.acceleration, peaks.acceleration);
  raise(axis.jerk, peaks.jerk);
}

void list_steps(const Plan& plan, const BoundedMove& bounded, CheckReport& report) {
  for (const MoveStep& step : bounded.steps()) {
    report.steps.push_back({.key = step.key < 0 ? std::nullopt : std::optional(step.key),
                            .frame = step.frame,
                            .axis = plan.axis_of(step.axis),
                            .velocity = step.velocity,
                            .acceleration = step.acceleration});
  }
}

void take_motors(const Plan& plan, std::span<const AxisPeaks> peaks, CheckReport& report) {
  const std::vector<CalibratedMotor> motors = plan.calibrated_motors();
  const std::vector<AxisLimits> limits_of_motors = motor_limits(plan);
  for (std::size_t m = 0; m < peaks.size(); ++m) {
    const std::size_t a = plan.axis_of(motors[m].axis);
    const AxisLimits& limits = limits_of_motors[m];
    report.motors.push_back({.axis = a,
                             .unit = std::string(to_string(plan.rig()->axes[a].calibration->unit)),
                             .velocity = {.limit = limits.max_velocity()},
                             .acceleration = {.limit = limits.max_acceleration()},
                             .jerk = {.limit = limits.max_jerk()}});
    CheckedMotor& motor = report.motors.back();
    raise(motor.velocity, peaks[m].velocity);
    raise(motor.acceleration, peaks[m].acceleration);
    raise(motor.jerk, peaks[m].jerk);
    refuse_motor(plan, motor, report);
  }
}

void prove_stops(const Plan& plan, const BoundedMove& bounded, CheckReport& report) {
  report.planned_stops = std::make_shared<const PlannedStops>(plan, bounded);
  const PlannedStops& planned = *report.planned_stops;
  if (planned.obstacle()) return refuse_stop(plan, planned, report);
  CheckedStops stops{.longest = planned.bounds()->longest_in_time(), .axes = {}};
  for (const CheckedAxis& axis : report.axes) {
    stops.axes.push_back({.velocity = axis.velocity, .acceleration = {}, .jerk = {}});
  }
  for (std::size_t d = 0; d < plan.limits().size(); ++d) {
    const AxisPeaks& peaks = planned.peaks()[d];
    const AxisLimits& limits = plan.limits()[d];
    CheckedStopAxis& axis = stops.axes[plan.axis_of(d)];
    axis.acceleration.limit = limits.stop_acceleration();
    axis.jerk.limit = limits.stop_jerk();
    raise(axis.acceleration, peaks.acceleration);
    raise(axis.jerk, peaks.jerk);
    // The bounds were made to reach the limit: what is above it is the rounding of this sum.
    axis.acceleration.value = std::min(axis.acceleration.value, limits.stop_acceleration());
    if (limits.stop_jerk()) axis.jerk.value = std::min(axis.jerk.value, *limits.stop_jerk());
  }
  report.stops = std::move(stops);
}

void find_highest_rate(const Plan& plan, const BoundedMove& bounded, CheckReport& report) {
  std::vector<AxisLimits> limits = plan.limits();
  for (const AxisLimits& motor : motor_limits(plan)) limits.push_back(motor);
  const HighestRate rate =
      highest_rate({bounded.peaks(), bounded.steps(), limits, plan.played().axis_count()});
  report.highest_rate = rate.whole;
  report.highest_rate_between_steps = rate.between_steps;
}

}  // namespace

bool CheckedPeak::is_exceeded() const {
  return inbetween::is_exceeded(value, limit);
}

CheckReport check_motion(const Plan& plan, const BoundedMove& bounded) {
  CheckReport report;
  for (const RigAxis& axis : plan.rig()->axes) report.axes.push_back(axis_at_rest(axis));
  const std::size_t axes = plan.played().axis_count();
  for (std::size_t d = 0; d < axes; ++d) raise(report.axes[plan.axis_of(d)], bounded.peaks()[d]);
  list_steps(plan, bounded, report);
  for (const SolvedTrack& solved : plan.tracks()) {
    if (!solved.track().has_profile()) continue;
    report.speed_error = std::max(report.speed_error, solved.track().arc_length().delta());
  }
  for (std::size_t a = 0; a < report.axes.size(); ++a) {
    if (report.axes[a].range) refuse_axis(plan, a, report);
  }
  take_motors(plan, std::span(bounded.peaks()).subspan(axes), report);
  for (const RollObstacle& obstacle : plan.roll_obstacles()) refuse_roll(plan, obstacle, report);
  return report;
}

CheckReport check_motion(const Plan& plan) {
  return check_motion(plan, bounded_move(plan, 1, BoundedFor::motion));
}

CheckReport check_until_refused(const Plan& plan) {
  return check_until_refused(plan, bounded_move(plan, 1, BoundedFor::stops));
}

CheckReport check_until_refused(const Plan& plan, const BoundedMove& bounded) {
  CheckReport report = check_motion(plan, bounded);
  if (report.fits()) prove_stops(plan, bounded, report);
  return report;
}

CheckReport check(const Plan& plan) {
  const BoundedMove bounded = bounded_move(plan, 1, BoundedFor::stops);
  CheckReport report = check_motion(plan, bounded);
  prove_stops(plan, bounded, report);
  find_highest_rate(plan, bounded, report);
  return report;
}

void refuse_beyond_limits(const CheckReport& report) {
  if (report.fits()) return;
  throw LimitError(report.refusals.front().place,
                   report.refusals.front().message() + "; inbetween check tries what lets it fit");
}

}  // namespace inbetween
