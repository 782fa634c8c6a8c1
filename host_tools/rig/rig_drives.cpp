#include "host_tools/rig/rig_drives.hpp"

#include <fmt/format.h>

#include <iterator>
#include <utility>
#include <variant>

#include "host_tools/rig/bus_drives.hpp"

namespace inbetween {

void refuse_falling_axes(const RigFile& rig) {
  for (const RigAxis& axis : rig.axes) {
    if (!axis.unpowered) {
      throw InputError(
          axis.place,
          fmt::format("axis {} does not say what it does without power; write unpowered = \"holds\" if "
                      "it keeps its place (a brake, a self-locking gear, a balanced load), otherwise "
                      "unpowered = \"falls\"",
                      in_quotes(axis.name)));
    }
    if (axis.unpowered->holds) continue;
    throw InputError(
        axis.unpowered->place,
        fmt::format("axis {} falls without power, so no drive is switched on; fit a brake on the brake "
                    "output of its drive, a self-locking gear or a counterweight, then write unpowered = "
                    "\"holds\"",
                    in_quotes(axis.name)));
  }
}

RigDrives::RigDrives(const RigFile& rig, RigHardware& hardware) : hardware_(hardware), rig_(motors_of(rig)) {
  motors_.of.resize(rig_.rig.axes.size());
  const RigFile& motors = rig_.rig;
  refuse_overloaded_buses(motors);
  std::vector<std::size_t> others;
  bool has_steps = false;
  for (std::size_t a = 0; a < motors.axes.size(); ++a) {
    bool is_on_bus = false;
    with_kind_of(motors.axes[a], [&]<class Kind>() { is_on_bus = true; });
    const bool is_step_dir = std::holds_alternative<StepDirDrive>(motors.axes[a].drive);
    has_steps = has_steps || is_step_dir;
    if (!is_on_bus && !is_step_dir) others.push_back(a);
  }
  std::unique_ptr<AxisDrives> other_drives;
  if (!others.empty()) other_drives = hardware.open_others(others);
  for_each_bus_kind([&]<class Kind>() {
    const std::vector<std::size_t> axes = axes_of_kind<Kind>(motors);
    if (!axes.empty()) add(axes, std::make_unique<BusDrives<Kind>>(motors, axes, hardware));
  });
  if (has_steps) {
    auto steps = std::make_unique<StepDrives>(motors, hardware);
    steps_ = steps.get();
    add(steps_->indices(), std::move(steps));
  }
  if (!others.empty()) add(others, std::move(other_drives));
  if (rig_.gears.empty()) return;
  states_.resize(motors_.of.size());
  setpoints_.resize(motors_.of.size());
  axes_.emplace(motors_, MotorMemory{rig_.gears, rig_.of, states_, setpoints_});
}

void RigDrives::add(std::span<const std::size_t> axes, std::unique_ptr<AxisDrives> drives) {
  for (std::size_t i = 0; i < axes.size(); ++i) motors_.of[axes[i]] = {.drives = drives.get(), .number = i};
  motors_.parts.push_back({.axes = {axes.begin(), axes.end()}, .drives = std::move(drives)});
}

void RigDrives::MotorDrives::read(std::span<DriveState> states, std::int64_t now_ns) {
  for (Part& part : parts) {
    part.drives->read(part.states, now_ns);
    for (std::size_t i = 0; i < part.axes.size(); ++i) states[part.axes[i]] = part.states[i];
  }
}

void RigDrives::MotorDrives::write(std::span<const Setpoint> setpoints, std::int64_t now_ns) {
  const bool may = std::ranges::all_of(parts, [](const Part& part) { return part.drives->is_set_up(); });
  for (Part& part : parts) {
    part.drives->let_switch_on(may);
    if (setpoints.empty()) {
      part.drives->write({}, now_ns);
      continue;
    }
    for (std::size_t i = 0; i < part.axes.size(); ++i) part.setpoints[i] = setpoints[part.axes[i]];
    part.drives->write(part.setpoints, now_ns);
  }
}

void RigDrives::MotorDrives::enable() {
  for (const Part& part : parts) part.drives->enable();
}

void RigDrives::MotorDrives::disable() {
  for (const Part& part : parts) part.drives->disable();
}

void RigDrives::MotorDrives::quick_stop() {
  for (const Part& part : parts) part.drives->quick_stop();
}

void RigDrives::read(std::span<DriveState> states, std::int64_t now_ns) {
  hardware_.advance(now_ns);
  axes_ ? axes_->read(states, now_ns) : motors_.read(states, now_ns);
}

void RigDrives::write(std::span<const Setpoint> setpoints, std::int64_t now_ns) {
  axes_ ? axes_->write(setpoints, now_ns) : motors_.write(setpoints, now_ns);
}

void RigDrives::enable() {
  axes_ ? axes_->enable() : motors_.enable();
}

void RigDrives::disable() {
  motors_.disable();
}

void RigDrives::quick_stop() {
  motors_.quick_stop();
}

void RigDrives::plan_motor(std::size_t axis, const Setpoint& told, const Setpoint& motor) {
  if (axes_) axes_->plan_motor(axis, told, motor);
}

void RigDrives::place(std::size_t axis, double position) {
  for (std::size_t m = 0; m < motors_.of.size(); ++m) {
    if (rig_.of[m].axis != axis) continue;
    motors_.of[m].drives->place(motors_.of[m].number, axes_ ? axes_->motor_at(m, position) : position);
  }
}

std::vector<double> RigDrives::zeros(std::size_t axis) const {
  std::vector<double> zeros;
  for (std::size_t m = 0; m < motors_.of.size(); ++m) {
    if (rig_.of[m].axis != axis) continue;
    const std::optional<double> zero = motors_.of[m].drives->zero(motors_.of[m].number);
    if (!zero) return {};
    zeros.push_back(*zero);
  }
  return zeros;
}

void RigDrives::set_zeros(std::size_t axis, std::span<const double> zeros) {
  auto zero = zeros.begin();
  for (std::size_t m = 0; m < motors_.of.size() && zero != zeros.end(); ++m) {
    if (rig_.of[m].axis == axis) motors_.of[m].drives->set_zero(motors_.of[m].number, *zero++);
  }
}

bool RigDrives::has_lost_position(std::size_t axis) const {
  for (std::size_t m = 0; m < motors_.of.size(); ++m) {
    if (rig_.of[m].axis == axis && motors_.of[m].drives->has_lost_position(motors_.of[m].number)) return true;
  }
  return false;
}

double RigDrives::as_approached(std::size_t axis, double position) const {
  if (!axes_) return position;
  const AxisGear& gear = rig_.gears[axis];
  const double motor = gear.motor_at(position);
  return gear.calibration == nullptr ? motor : gear.calibration->axis_at(motor);
}

bool RigDrives::is_resting() const {
  return !axes_ || axes_->is_resting();
}

Counters RigDrives::counts() const {
  Counters counts;
  for (const Part& part : motors_.parts) part.drives->count(counts);
  return counts;
}

std::string RigDrives::first_of(std::string (AxisDrives::*words)() const) const {
  for (const Part& part : motors_.parts) {
    if (std::string said = (*part.drives.*words)(); !said.empty()) return said;
  }
  return "";
}

std::string RigDrives::trouble() const {
  for (const auto words : {&AxisDrives::bus_trouble, &AxisDrives::trouble, &AxisDrives::drive_trouble}) {
    if (std::string said = first_of(words); !said.empty()) return said;
  }
  return skew_trouble();
}

std::string RigDrives::skew_trouble() const {
  for (std::size_t a = 0; a < rig_.gears.size(); ++a) {
    if (!rig_.gears[a].is_skewed) continue;
    const RigAxis& motor = rig_.rig.axes[a];
    return fmt::format(
        "{}: its motors are more than max_skew = {:g} {} apart; look at what holds one of them back, and "
        "square the axis before it moves again",
        named(motor), *rig_.gears[a].max_skew, to_string(motor.unit));
  }
  return "";
}

std::string RigDrives::left_on() const {
  std::string all;
  for (const Part& part : motors_.parts) {
    const std::string said = part.drives->left_on();
    if (!said.empty()) all += (all.empty() ? "" : ". And ") + said;
  }
  return all;
}

std::vector<std::string> RigDrives::notes() const {
  std::vector<std::string> notes;
  for (const Part& part : motors_.parts) std::ranges::copy(part.drives->notes(), std::back_inserter(notes));
  return notes;
}

}  // namespace inbetween
