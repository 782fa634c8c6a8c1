#include "host_tools/rig/rig_drives.hpp"

#include <fmt/format.h>

#include <utility>
#include <variant>

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

RigDrives::RigDrives(const RigFile& rig, RigHardware& hardware)
    : hardware_(hardware), axes_(rig.axes.size()) {
  std::vector<std::size_t> on_can, on_steps, others;
  for (std::size_t a = 0; a < rig.axes.size(); ++a) {
    const Drive& drive = rig.axes[a].drive;
    if (std::holds_alternative<Cia402Drive>(drive)) {
      on_can.push_back(a);
    } else {
      (std::holds_alternative<StepDirDrive>(drive) ? on_steps : others).push_back(a);
    }
  }
  refuse_overloaded_buses(rig);
  std::unique_ptr<AxisDrives> other_drives;
  if (!others.empty()) other_drives = hardware.open_others(others);
  if (!on_can.empty()) {
    auto can = std::make_unique<CanDrives>(rig, on_can, hardware);
    can_ = can.get();
    add(on_can, std::move(can));
  }
  if (!on_steps.empty()) {
    auto steps = std::make_unique<StepDrives>(rig, hardware);
    steps_ = steps.get();
    add(steps_->indices(), std::move(steps));
  }
  if (!others.empty()) add(others, std::move(other_drives));
}

void RigDrives::add(std::span<const std::size_t> axes, std::unique_ptr<AxisDrives> drives) {
  for (std::size_t i = 0; i < axes.size(); ++i) axes_[axes[i]] = {.drives = drives.get(), .number = i};
  parts_.push_back({.axes = {axes.begin(), axes.end()}, .drives = std::move(drives)});
}

void RigDrives::read(std::span<DriveState<double>> states, std::int64_t now_ns) {
  hardware_.advance(now_ns);
  for (Part& part : parts_) {
    part.drives->read(part.states, now_ns);
    for (std::size_t i = 0; i < part.axes.size(); ++i) states[part.axes[i]] = part.states[i];
  }
}

void RigDrives::write(std::span<const Setpoint<double>> setpoints, std::int64_t now_ns) {
  for (Part& part : parts_) {
    if (setpoints.empty()) {
      part.drives->write({}, now_ns);
      continue;
    }
    for (std::size_t i = 0; i < part.axes.size(); ++i) part.setpoints[i] = setpoints[part.axes[i]];
    part.drives->write(part.setpoints, now_ns);
  }
}

void RigDrives::enable() {
  for (const Part& part : parts_) part.drives->enable();
}

void RigDrives::disable() {
  for (const Part& part : parts_) part.drives->disable();
}

void RigDrives::quick_stop() {
  for (const Part& part : parts_) part.drives->quick_stop();
}

void RigDrives::place(std::size_t axis, double position) {
  axes_[axis].drives->place(axes_[axis].number, position);
}

bool RigDrives::has_lost_position(std::size_t axis) const {
  return axes_[axis].drives->has_lost_position(axes_[axis].number);
}

Counters RigDrives::counts() const {
  Counters counts;
  if (can_ != nullptr) can_->count(counts);
  for (const Part& part : parts_) {
    if (part.drives.get() != can_) part.drives->count(counts);
  }
  return counts;
}

std::string RigDrives::trouble() const {
  std::string trouble = can_ != nullptr ? can_->bus_trouble() : "";
  for (const Part& part : parts_) {
    if (trouble.empty()) trouble = part.drives->trouble();
  }
  if (trouble.empty() && can_ != nullptr) trouble = can_->drive_trouble();
  return trouble;
}

}  // namespace inbetween
