#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/setpoint.hpp"
#include "inbetween/limits/calibration.hpp"
#include "inbetween/loop/ports.hpp"
#include "inbetween/loop/take_up.hpp"

/// The axes of a rig on their motors: one or several each, through a calibration, with an offset, with the
/// play of the gear taken up.

namespace inbetween {

/// What lies between an axis and its motors.
struct AxisGear {
  const Calibration* calibration = nullptr;  ///< none: the motor counts in axis units
  std::optional<TakeUp> take_up = {};        ///< of all its motors
  /// How far another motor of the axis may be from where the first one is, in units of the motor; beside
  /// their offsets. A gantry racks beyond it.
  std::optional<double> max_skew = {};
  bool is_skewed = false;  ///< kept by the port, for whoever wants to know what is wrong
  /// The motor is told this, without take-up and offset, while the axis is told that. The port keeps it.
  struct Planned {
    Setpoint axis, motor;
  };
  std::optional<Planned> planned = {};

  /// The motor is told this for its axis, before take-up and offset are added.
  [[nodiscard]] Setpoint of_motor(const Setpoint& axis) const {
    if (planned && planned->axis == axis) return planned->motor;
    return calibration == nullptr ? axis : calibration->motor_of(axis);
  }
  /// The position of the motor for one of the axis, without its offset; and back.
  [[nodiscard]] double motor_at(double axis) const {
    const double motor = calibration == nullptr ? axis : calibration->motor_at(axis);
    return take_up ? motor + take_up->now().position : motor;
  }
  [[nodiscard]] double axis_at(double motor) const {
    const double taken = take_up ? motor - take_up->now().position : motor;
    return calibration == nullptr ? taken : calibration->axis_at(taken);
  }
};

/// A motor of an axis.
struct AxisMotor {
  std::size_t axis = 0;
  double offset = 0;  ///< its position where the axis is at 0, or the calibration is
  /// How much further it stands than the first motor of the axis, both without their offsets, since it was
  /// switched on; kept by the port.
  double apart = 0;
};

/// The memory of the port, owned by the caller. The first motors are the first ones of the axes, in their
/// order; behind them come the others of axes that have several.
struct MotorMemory {
  std::span<AxisGear> axes;
  std::span<AxisMotor> motors;
  std::span<DriveState> states;   ///< motors
  std::span<Setpoint> setpoints;  ///< motors
};

/// Drives of which one can be stopped, or lose its power, while the others go on.
template <class Motors>
concept StopsOne = requires(Motors& motors, std::size_t motor, OwnStop how) {
  motors.stop_one(motor, how);
};

/// A DrivePort of the axes over one of their motors (`Motors`). Refers to the caller's memory.
///
/// An axis is where its first motor says. It is on when all its motors are, and has the worst of their
/// conditions: a fault of one stops all axes. Motors of one axis that are further apart than it allows while
/// they are on cannot follow. Nothing moves them together: each keeps the distance with which it was switched
/// on, so that no motor moves by being switched on. Where one is stopped alone, or has lost its power, so do
/// the others of its axis (StopsOne). O(motors), no allocation.
template <DrivePort Motors>
class MotorPort {
 public:
  MotorPort(Motors& motors, const MotorMemory& memory) : motors_(&motors), memory_(memory) {}

  void read(std::span<DriveState> states, std::int64_t now_ns) {
    motors_->read(memory_.states, now_ns);
    const std::size_t axes = memory_.axes.size();
    for (std::size_t a = 0; a < axes; ++a) {
      states[a] = memory_.states[a];
      states[a].actual = memory_.axes[a].axis_at(place(a));
    }
    for (std::size_t m = axes; m < memory_.motors.size(); ++m) {
      const DriveState& motor = memory_.states[m];
      DriveState& axis = states[memory_.motors[m].axis];
      axis.is_on = axis.is_on && motor.is_on;
      axis.is_leaving = axis.is_leaving || motor.is_leaving;
      axis.condition = std::max(axis.condition, motor.condition);
      axis.is_in_position = axis.is_in_position && motor.is_in_position;
      axis.own_stop = std::max(axis.own_stop, motor.own_stop);
    }
    if constexpr (StopsOne<Motors>) stop_together(states);
    for (std::size_t m = axes; m < memory_.motors.size(); ++m) supervise_skew(m, states);
  }

  void write(std::span<const Setpoint> setpoints, std::int64_t now_ns) {
    if (setpoints.empty()) {
      if (is_following_) halt();
      motors_->write({}, now_ns);
      return;
    }
    if (!is_following_) begin();
    for (std::size_t m = 0; m < memory_.motors.size(); ++m) {
      const AxisMotor& motor = memory_.motors[m];
      AxisGear& gear = memory_.axes[motor.axis];
      const Setpoint& axis = setpoints[motor.axis];
      // The motors of an axis share what its first one was told.
      Setpoint& out = memory_.setpoints[m];
      out = m < memory_.axes.size() ? through(gear, axis) : without_offset(motor.axis);
      out.position += motor.offset + motor.apart;
    }
    motors_->write(memory_.setpoints, now_ns);
  }

  /// While axis `axis` is told `told`, its motor is told this, in units of the motor: what was proven of a
  /// move (fit_motor), in place of what the calibration makes of the axis at this moment.
  void plan_motor(std::size_t axis, const Setpoint& told, const Setpoint& motor) {
    memory_.axes[axis].planned = {told, motor};
  }

  void enable() {
    for (AxisGear& gear : memory_.axes) gear.is_skewed = false;
    motors_->enable();
  }
  void disable() { motors_->disable(); }
  void quick_stop() { motors_->quick_stop(); }

  /// Where motor `motor` is when its axis is at `position`.
  [[nodiscard]] double motor_at(std::size_t motor, double position) const {
    const AxisMotor& of = memory_.motors[motor];
    return memory_.axes[of.axis].motor_at(position) + of.offset;
  }
  /// The motors of all axes rest when their axes do.
  [[nodiscard]] bool is_resting() const {
    return std::ranges::none_of(
        memory_.axes, [](const AxisGear& gear) { return gear.take_up && gear.take_up->is_under_way(); });
  }

 private:
  /// Without its offset.
  [[nodiscard]] double place(std::size_t motor) const {
    return memory_.states[motor].actual - memory_.motors[motor].offset;
  }
  [[nodiscard]] Setpoint without_offset(std::size_t axis) const {
    Setpoint told = memory_.setpoints[axis];
    told.position -= memory_.motors[axis].offset;
    return told;
  }
  static Setpoint through(AxisGear& gear, const Setpoint& axis) {
    Setpoint motor = gear.of_motor(axis);
    if (!gear.take_up) return motor;
    const Setpoint more = gear.take_up->follow(axis.position);
    motor.position += more.position;
    motor.velocity += more.velocity;
    motor.acceleration += more.acceleration;
    return motor;
  }

  void stop_together(std::span<const DriveState> axes) {
    for (std::size_t m = 0; m < memory_.motors.size(); ++m) {
      const OwnStop how = axes[memory_.motors[m].axis].own_stop;
      if (memory_.states[m].own_stop < how) motors_->stop_one(m, how);
    }
  }
  void supervise_skew(std::size_t m, std::span<DriveState> states) {
    const std::size_t a = memory_.motors[m].axis;
    AxisGear& gear = memory_.axes[a];
    if (!gear.max_skew || !states[a].is_on) return;
    if (std::fabs(place(m) - place(a)) <= *gear.max_skew) return;
    gear.is_skewed = true;
    states[a].condition = std::max(states[a].condition, DriveCondition::cannot_follow);
  }

  /// The first setpoint is where each motor stands.
  void begin() {
    is_following_ = true;
    for (std::size_t m = memory_.axes.size(); m < memory_.motors.size(); ++m) {
      memory_.motors[m].apart = place(m) - place(memory_.motors[m].axis);
    }
  }
  void halt() {
    is_following_ = false;
    for (AxisGear& gear : memory_.axes) {
      if (gear.take_up) gear.take_up->halt();
    }
  }

  Motors* motors_;
  MotorMemory memory_;
  bool is_following_ = false;
};

}  // namespace inbetween
