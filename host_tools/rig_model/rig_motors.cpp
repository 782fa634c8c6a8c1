#include "host_tools/rig_model/rig_motors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>

namespace inbetween {
namespace {

/// What a take-up adds to the motor: up or down by the play, against the approach.
double take_up_offset(const RigAxis& axis) {
  const bool motor_rises =
      !axis.calibration || axis.calibration->marks.back().motor > axis.calibration->marks.front().motor;
  return axis.backlash->approach_is_up == motor_rises ? -axis.backlash->play : axis.backlash->play;
}

AxisGear gear_of(const RigAxis& axis, std::int32_t rate_hz) {
  AxisGear gear;
  if (axis.calibration) gear.calibration = &axis.calibration->motor();
  if (!axis.ganged.empty()) gear.max_skew = axis.max_skew;
  if (axis.backlash) {
    const Backlash backlash{
        .distance = take_up_offset(axis),
        .approach_is_up = axis.backlash->approach_is_up,
        .ticks = std::max(static_cast<std::int32_t>(std::ceil(axis.backlash->take_up_s * rate_hz)), 1),
        .min_return = count_of(axis)};
    gear.take_up = TakeUp(backlash, 1.0 / rate_hz);
  }
  return gear;
}

}  // namespace

bool has_gear(const RigAxis& axis) {
  return axis.offset != 0 || axis.calibration || axis.backlash || !axis.ganged.empty();
}

std::string ganged_name(const RigAxis& axis, std::size_t ganged) {
  return fmt::format("{}.{}", axis.name, ganged + 2);
}

double motor_position(const RigAxis& axis, const AxisMotor& motor, double position) {
  if (!has_gear(axis)) return position;
  return (axis.calibration ? axis.calibration->motor().motor_at(position) : position) + motor.offset;
}

double axis_position(const RigAxis& axis, const AxisMotor& motor, double position) {
  if (!has_gear(axis)) return position;
  const double own = position - motor.offset;
  return axis.calibration ? axis.calibration->motor().axis_at(own) : own;
}

RigAxis motor_of(const RigAxis& axis, const AxisMotor& motor) {
  RigAxis its = axis;
  its.home.reset();
  its.limit_min.reset();
  its.limit_max.reset();
  its.offset = 0;
  its.calibration.reset();
  its.backlash.reset();
  its.ganged.clear();
  its.motor_limits.reset();
  if (axis.calibration) its.unit = axis.calibration->unit;
  std::tie(its.min, its.max) =
      std::minmax({motor_position(axis, motor, axis.min), motor_position(axis, motor, axis.max)});
  if (axis.backlash) {
    const double offset = take_up_offset(axis);
    (offset < 0 ? its.min : its.max) += offset;
  }
  if (!axis.motor_limits) return its;
  const MotorLimits& limits = *axis.motor_limits;
  its.max_velocity = limits.max_velocity;
  its.max_acceleration = limits.max_acceleration;
  its.max_jerk = limits.max_jerk;
  its.max_acceleration_step.reset();
  its.stop_acceleration = limits.stop_acceleration;
  its.stop_jerk = limits.stop_jerk;
  return its;
}

RigMotors motors_of(const RigFile& rig) {
  RigMotors motors{.rig = rig, .of = {}, .gears = {}};
  motors.rig.axes.clear();
  for (std::size_t a = 0; a < rig.axes.size(); ++a) {
    motors.of.push_back({.axis = a, .offset = rig.axes[a].offset});
    motors.rig.axes.push_back(has_gear(rig.axes[a]) ? motor_of(rig.axes[a], motors.of.back()) : rig.axes[a]);
  }
  for (std::size_t a = 0; a < rig.axes.size(); ++a) {
    const RigAxis& axis = rig.axes[a];
    for (std::size_t i = 0; i < axis.ganged.size(); ++i) {
      motors.of.push_back({.axis = a, .offset = axis.ganged[i].offset});
      RigAxis motor = motor_of(axis, motors.of.back());
      motor.name = ganged_name(axis, i);
      motor.drive = axis.ganged[i].drive;
      motor.place = axis.ganged[i].place;
      motors.rig.axes.push_back(std::move(motor));
    }
  }
  if (std::ranges::any_of(rig.axes, has_gear)) {
    for (const RigAxis& axis : rig.axes) motors.gears.push_back(gear_of(axis, rig.rate_hz));
  }
  return motors;
}

AxisLimits limits_beside_take_up(const RigAxis& axis) {
  const MotorLimits& limits = *axis.motor_limits;
  std::array<double, 3> taken{};
  if (axis.backlash) taken = take_up_peaks(axis.backlash->play, axis.backlash->take_up_s);
  const auto left = [](const std::optional<double>& limit, double part) {
    return limit ? std::optional(*limit - part) : std::nullopt;
  };
  const RigAxis motor = motor_of(axis, {.axis = 0, .offset = axis.offset});
  const auto made = AxisLimits::make({.min = motor.min,
                                      .max = motor.max,
                                      .max_velocity = limits.max_velocity - taken[0],
                                      .max_acceleration = limits.max_acceleration - taken[1],
                                      .max_jerk = left(limits.max_jerk, taken[2]),
                                      .stop_acceleration = limits.stop_acceleration - taken[1],
                                      .stop_jerk = left(limits.stop_jerk, taken[2])});
  return value_or_refuse(made, axis.place, named(axis));
}

/// In slow motion, k times as fast, a motion takes k, k^2 and k^3 of the three; and so does its motor.
RigAxis slow_enough_everywhere(const RigAxis& axis) {
  if (!axis.calibration) return axis;
  constexpr double rounding = 1 - 1e-9;
  const AxisLimits motor = limits_beside_take_up(axis);
  const CalibrationSlope slope = axis.calibration->motor().bounds(axis.calibration->marks.front().axis,
                                                                  axis.calibration->marks.back().axis);
  double share = 1;
  const auto lower = [&](const std::array<double, 3>& motion, double acceleration,
                         const std::optional<double>& jerk) {
    const std::array<double, 3> asked = motor_motion(slope, motion);
    share = std::min({share, motor.max_velocity() / asked[0], std::sqrt(acceleration / asked[1])});
    if (jerk) share = std::min(share, std::cbrt(*jerk / asked[2]));
  };
  const double stop_acceleration = stop_acceleration_of(axis);
  const double jerk = axis.max_jerk.value_or(0);
  const double stop_jerk = axis.stop_jerk.value_or(default_stop_ratio * jerk);
  lower({axis.max_velocity, axis.max_acceleration, jerk}, motor.max_acceleration(), motor.max_jerk());
  lower({axis.max_velocity, stop_acceleration, stop_jerk}, motor.stop_acceleration(), motor.stop_jerk());
  RigAxis slow = axis;
  share *= rounding;
  slow.max_velocity *= share;
  slow.max_acceleration *= share * share;
  slow.stop_acceleration = stop_acceleration * share * share;
  if (axis.max_jerk) {
    slow.max_jerk = jerk * share * share * share;
    slow.stop_jerk = stop_jerk * share * share * share;
  }
  return slow;
}

double count_of(const RigAxis& axis) {
  const double count = count_of(axis.drive);
  if (!axis.calibration) return count;
  return count / axis.calibration->motor().bounds(axis.min, axis.max).first;
}

}  // namespace inbetween
