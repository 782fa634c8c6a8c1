#include "host_tools/check/check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "host_tools/check/check_refusals.hpp"
#include "host_tools/check/planned_stops.hpp"
#include "host_tools/files/rig_motors.hpp"
#include "inbetween/limits/motion_steps.hpp"

namespace inbetween {
namespace {

/// Nothing is refined that is further from its limit than this share of it.
constexpr double slack_share = 1e-6;

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

/// The axes of one track, as indexes into those of the rig.
std::vector<std::size_t> axes_of_track(const Plan& plan, std::size_t track) {
  std::vector<std::size_t> axes(plan.move().tracks[track].axes.size());
  for (std::size_t a = 0; a < plan.axes().size(); ++a) {
    if (plan.axes()[a].track == track) axes[plan.axes()[a].track_axis] = a;
  }
  return axes;
}

/// The larger of two peaks; where they are equal, the first.
void raise(CheckedPeak& peak, const Peak<double>& found) {
  if (!(found.value > peak.value)) return;
  peak.value = found.value;
  peak.frame = found.frame;
}

void raise(CheckedAxis& axis, const AxisPeaks<double>& peaks) {
  if (!axis.range) axis.range = CheckedRange{peaks.lowest, peaks.highest};
  if (peaks.lowest.value < axis.range->lowest.value) axis.range->lowest = peaks.lowest;
  if (peaks.highest.value > axis.range->highest.value) axis.range->highest = peaks.highest;
  raise(axis.velocity, peaks.velocity);
  raise(axis.acceleration, peaks.acceleration);
  raise(axis.jerk, peaks.jerk);
}

void bound_track(const Plan& plan, std::size_t index, CheckReport& report) {
  const std::vector<std::size_t> axes = axes_of_track(plan, index);
  std::vector<MotionTriple<double>> slack;
  for (const std::size_t a : axes) {
    const RigAxis& axis = plan.rig()->axes[a];
    slack.push_back({slack_share * axis.max_velocity, slack_share * axis.max_acceleration,
                     slack_share * axis.max_jerk.value_or(0)});
  }
  std::vector<AxisTurn<double>> turns(axes.size());
  std::vector<AxisPeaks<double>> peaks(axes.size());
  value_or_throw(bound_motion<double>(plan.tracks()[index].track(), slack, {turns}, peaks, plan.part()));
  for (std::size_t d = 0; d < axes.size(); ++d) raise(report.axes[axes[d]], peaks[d]);
}

void bound_rolls(const Plan& plan, CheckReport& report) {
  const MoveRolls<double>& rolls = plan.played().rolls();
  for (const std::span<const RollAxis<double>> roll : {rolls.before, rolls.after}) {
    for (std::size_t d = 0; d < roll.size(); ++d) raise(report.axes[plan.axis_of(d)], roll[d].peaks());
  }
}

/// A step that is no larger is no more than rounding.
double rounding_of(const CheckedPeak& peak) {
  return step_rounding * std::max(std::isfinite(peak.value) ? peak.value : 0, peak.limit.value_or(0));
}
double without_rounding(double step, const CheckedPeak& peak) {
  return step > rounding_of(peak) ? step : 0;
}

void add_steps(const std::vector<std::size_t>& axes, const std::vector<AxisStep<double>>& steps,
               std::optional<std::int32_t> key, double frame, CheckReport& report) {
  for (std::size_t d = 0; d < axes.size(); ++d) {
    const CheckedAxis& axis = report.axes[axes[d]];
    const CheckedStep step{.key = key,
                           .frame = frame,
                           .axis = axes[d],
                           .velocity = without_rounding(steps[d].velocity, axis.velocity),
                           .acceleration = without_rounding(steps[d].acceleration, axis.acceleration)};
    if (step.velocity > 0 || step.acceleration > 0) report.steps.push_back(step);
  }
}

/// A key so near to a frame is met on it.
constexpr double frame_rounding = 1e-9;

/// Whether the step on a frame is one of what is played. At the ends a move that is moving meets its roll, or
/// is refused because there is none; inside the whole it rests there otherwise. By the frame: several keys
/// may lie in one place there.
bool is_played(const Plan& plan, std::size_t track, double frame) {
  const auto& [first, last] = plan.part();
  if (frame <= first + (first > 0 ? frame_rounding : 0)) {
    return first == 0 && !plan.is_moving(track, RollEnd::before);
  }
  if (frame >= last - (last < plan.move().frames ? frame_rounding : 0)) {
    return last == plan.move().frames && !plan.is_moving(track, RollEnd::after);
  }
  return true;
}

void list_steps(const Plan& plan, std::size_t index, CheckReport& report) {
  const std::vector<std::size_t> axes = axes_of_track(plan, index);
  const Track<double>& track = plan.tracks()[index].track();
  const std::int32_t segments = track.path().segment_count();
  std::vector<AxisStep<double>> steps(axes.size());
  const PaceBounds<double> pace = pace_bounds(track);
  const auto may_step = [&](std::int32_t key) {
    bound_steps_at_key<double>(track, key, pace, steps);
    for (std::size_t d = 0; d < axes.size(); ++d) {
      const CheckedAxis& axis = report.axes[axes[d]];
      const bool is_rounding = 2 * steps[d].velocity <= rounding_of(axis.velocity) &&
                               2 * steps[d].acceleration <= rounding_of(axis.acceleration);
      if (!is_rounding) return true;
    }
    return false;
  };
  for (std::int32_t i = 0; i <= segments; ++i) {
    if (may_step(i)) {
      const double frame = steps_at_key<double>(track, i, steps);
      if (is_played(plan, index, frame)) add_steps(axes, steps, track.path().key_at(i), frame, report);
    }
    if (i == segments) break;
    const Standstills<double> standstills = standstills_within(track, i);
    for (std::size_t k = 0; k < standstills.count; ++k) {
      const double turn = steps_at_standstill<double>(track, {i, standstills.t[k]}, steps);
      if (is_played(plan, index, turn)) add_steps(axes, steps, std::nullopt, turn, report);
    }
  }
}

void bound_motors_of(const Plan& plan, CheckReport& report) {
  const PlannedMotors planned = planned_motors(plan);
  const std::vector<AxisPeaks<double>> peaks = peaks_of_motors(plan, planned);
  for (std::size_t m = 0; m < peaks.size(); ++m) {
    const std::size_t a = plan.axis_of(planned.motors[m].axis);
    const AxisLimits<double>& limits = planned.limits[m];
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

void prove_stops(const Plan& plan, CheckReport& report) {
  report.planned_stops = std::make_shared<const PlannedStops>(plan);
  const PlannedStops& planned = *report.planned_stops;
  if (planned.obstacle()) return refuse_stop(plan, planned, report);
  CheckedStops stops{.longest = planned.bounds()->longest_in_time(), .axes = {}};
  for (const CheckedAxis& axis : report.axes) {
    stops.axes.push_back({.velocity = axis.velocity, .acceleration = {}, .jerk = {}});
  }
  for (std::size_t d = 0; d < plan.limits().size(); ++d) {
    const AxisPeaks<double>& peaks = planned.peaks()[d];
    const AxisLimits<double>& limits = plan.limits()[d];
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

void find_highest_rate(const Plan& plan, CheckReport& report) {
  std::vector<PlayedAxis<double>> played(plan.limits().size());
  std::vector<AxisLimits<double>> limits = plan.limits();
  const auto peak = [](const CheckedPeak& found) { return Peak<double>{found.value, found.frame}; };
  for (std::size_t d = 0; d < played.size(); ++d) {
    const CheckedAxis& axis = report.axes[plan.axis_of(d)];
    played[d].peaks = {.lowest = axis.range->lowest,
                       .highest = axis.range->highest,
                       .velocity = peak(axis.velocity),
                       .acceleration = peak(axis.acceleration),
                       .jerk = peak(axis.jerk)};
  }
  for (const CheckedMotor& motor : report.motors) {
    played.push_back({.peaks = {.lowest = {},
                                .highest = {},
                                .velocity = peak(motor.velocity),
                                .acceleration = peak(motor.acceleration),
                                .jerk = peak(motor.jerk)}});
    limits.push_back(limits_beside_take_up(plan.rig()->axes[motor.axis]));
  }
  report.highest_rate_between_steps = highest_rate<double>(played, limits);
  for (std::size_t d = 0; d < plan.limits().size(); ++d) {
    for (const CheckedStep& step : report.steps) {
      if (step.axis != plan.axis_of(d)) continue;
      played[d].acceleration_step = std::max(played[d].acceleration_step, step.acceleration);
    }
  }
  report.highest_rate = highest_rate<double>(played, limits);
  const bool steps =
      std::ranges::any_of(report.steps, [](const CheckedStep& step) { return step.velocity > 0; });
  if (steps) report.highest_rate = 0;
}

}  // namespace

bool CheckedPeak::is_exceeded() const {
  return limit && !(value <= *limit);
}

CheckReport check_motion(const Plan& plan) {
  CheckReport report;
  for (const RigAxis& axis : plan.rig()->axes) report.axes.push_back(axis_at_rest(axis));
  for (std::size_t t = 0; t < plan.tracks().size(); ++t) {
    bound_track(plan, t, report);
    list_steps(plan, t, report);
    const Track<double>& track = plan.tracks()[t].track();
    if (track.has_profile()) report.speed_error = std::max(report.speed_error, track.arc_length().delta());
  }
  bound_rolls(plan, report);
  for (std::size_t a = 0; a < report.axes.size(); ++a) {
    if (report.axes[a].range) refuse_axis(plan, a, report);
  }
  bound_motors_of(plan, report);
  for (const RollObstacle& obstacle : plan.roll_obstacles()) refuse_roll(plan, obstacle, report);
  return report;
}

CheckReport check_until_refused(const Plan& plan) {
  CheckReport report = check_motion(plan);
  if (report.fits()) prove_stops(plan, report);
  return report;
}

CheckReport check(const Plan& plan) {
  CheckReport report = check_motion(plan);
  prove_stops(plan, report);
  find_highest_rate(plan, report);
  return report;
}

void refuse_beyond_limits(const CheckReport& report) {
  if (report.fits()) return;
  throw LimitError(report.refusals.front().place,
                   report.refusals.front().message() + "; inbetween check tries what lets it fit");
}

}  // namespace inbetween
