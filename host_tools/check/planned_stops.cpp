#include "host_tools/check/planned_stops.hpp"

#include <algorithm>
#include <utility>

#include "host_tools/plan/move_rolls.hpp"
#include "host_tools/rig_model/rig_motors.hpp"

namespace inbetween {
namespace {

/// Those of the motion in place of those of a stop.
AxisLimits without_stops(const AxisLimits& limits) {
  return value_or_throw(AxisLimits::make({.min = limits.min(),
                                          .max = limits.max(),
                                          .max_velocity = limits.max_velocity(),
                                          .max_acceleration = limits.max_acceleration(),
                                          .max_jerk = limits.max_jerk(),
                                          .stop_acceleration = limits.max_acceleration(),
                                          .stop_jerk = limits.max_jerk()}));
}

std::vector<AxisLimits> motion_limits_of(const Plan& plan) {
  std::vector<AxisLimits> limits;
  for (std::size_t d = 0; d < plan.limits().size(); ++d) {
    RigAxis axis = plan.rig()->axes[plan.axis_of(d)];
    axis.stop_acceleration = axis.max_acceleration;
    axis.stop_jerk = axis.max_jerk;
    limits.push_back(limits_of(axis));
  }
  return limits;
}

}  // namespace

std::vector<AxisLimits> motor_limits(const Plan& plan) {
  std::vector<AxisLimits> limits;
  for (const CalibratedMotor& motor : plan.calibrated_motors())
    limits.push_back(limits_beside_take_up(plan.rig()->axes[plan.axis_of(motor.axis)]));
  return limits;
}

namespace {

/// Those of every axis and motor: of a stop, or of the motion in place of those of a stop.
std::vector<AxisLimits> limits_of(const Plan& plan, bool of_stops) {
  std::vector<AxisLimits> limits = of_stops ? plan.limits() : motion_limits_of(plan);
  for (const AxisLimits& motor : motor_limits(plan))
    limits.push_back(of_stops ? motor : without_stops(motor));
  return limits;
}

BoundedMove bounded_in(const Plan& plan, std::size_t cells, std::span<const AxisLimits> limits, double rate) {
  const std::vector<CalibratedMotor> motors = plan.calibrated_motors();
  std::vector<MotionTriple> room(limits.size());
  write_room(limits, rate, 1.0 / plan.rig()->rate_hz, room);
  return BoundedMove(plan.played(), plan.track_views(),
                     {.limits = plan.limits(), .motors = motors, .cells = cells, .room = std::move(room)});
}

}  // namespace

BoundedMove bounded_move(const Plan& plan, double rate, BoundedFor use) {
  const std::size_t cells =
      use == BoundedFor::stops ? stop_cells(plan.played(), plan.rig()->rate_hz, rate) : 0;
  return bounded_in(plan, cells, limits_of(plan, true), rate);
}

PlannedStops::PlannedStops(const Plan& plan, double rate) {
  const BoundedMove bounded = bounded_move(plan, rate, BoundedFor::stops);
  make(plan, {.motion = bounded.cells(), .limits = limits_of(plan, true), .rate = rate});
}

PlannedStops::PlannedStops(const Plan& plan, const BoundedMove& bounded) {
  make(plan, {.motion = bounded.cells(), .limits = limits_of(plan, true)});
}

PlannedStops PlannedStops::within_motion_limits(const Plan& plan, double rate, bool may_wait) const {
  const std::vector<AxisLimits> limits = limits_of(plan, false);
  const BoundedMove bounded = bounded_in(plan, cells_.size() - 1, limits, rate);
  PlannedStops within;
  within.make(
      plan,
      {.motion = bounded.cells(), .limits = limits, .rate = rate, .within = &*bounds_, .may_wait = may_wait});
  return within;
}

void PlannedStops::make(const Plan& plan, StopRequest request) {
  const MotionCells& motion = request.motion;
  cells_.resize(motion.line.cells + 1);
  peaks_.resize(motion.stride());
  request.tick_seconds = 1.0 / plan.rig()->rate_hz;
  const auto bounds = StopBounds::make(request, cells_, peaks_, &obstacle_);
  if (!obstacle_) {
    bounds_ = value_or_throw(bounds);
    return;
  }
  const auto found = static_cast<std::size_t>(obstacle_->axis);
  obstacle_is_of_motor_ = found >= motion.axes;
  if (obstacle_is_of_motor_) {
    const std::vector<CalibratedMotor> motors = plan.calibrated_motors();
    obstacle_->axis = static_cast<std::int32_t>(motors[found - motion.axes].axis);
  }
}

}  // namespace inbetween
