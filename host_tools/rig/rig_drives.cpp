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

RigDrives::RigDrives(const RigFile& rig, RigHardware& hardware)
    : hardware_(hardware), axes_(rig.axes.size()) {
  refuse_overloaded_buses(rig);
  std::vector<std::size_t> others;
  bool has_steps = false;
  for (std::size_t a = 0; a < rig.axes.size(); ++a) {
    bool is_on_bus = false;
    with_kind_of(rig.axes[a], [&]<class Kind>() { is_on_bus = true; });
    const bool is_step_dir = std::holds_alternative<StepDirDrive>(rig.axes[a].drive);
    has_steps = has_steps || is_step_dir;
    if (!is_on_bus && !is_step_dir) others.push_back(a);
  }
  std::unique_ptr<AxisDrives> other_drives;
  if (!others.empty()) other_drives = hardware.open_others(others);
  for_each_bus_kind([&]<class Kind>() {
    const std::vector<std::size_t> axes = axes_of_kind<Kind>(rig);
    if (!axes.empty()) add(axes, std::make_unique<BusDrives<Kind>>(rig, axes, hardware));
  });
  if (has_steps) {
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
  for (const Part& part : parts_) part.drives->count(counts);
  return counts;
}

std::string RigDrives::first_of(std::string (AxisDrives::*words)() const) const {
  for (const Part& part : parts_) {
    if (std::string said = (*part.drives.*words)(); !said.empty()) return said;
  }
  return "";
}

std::string RigDrives::trouble() const {
  for (const auto words : {&AxisDrives::bus_trouble, &AxisDrives::trouble, &AxisDrives::drive_trouble}) {
    if (std::string said = first_of(words); !said.empty()) return said;
  }
  return "";
}

std::string RigDrives::left_on() const {
  std::string all;
  for (const Part& part : parts_) {
    const std::string said = part.drives->left_on();
    if (!said.empty()) all += (all.empty() ? "" : ". And ") + said;
  }
  return all;
}

std::vector<std::string> RigDrives::notes() const {
  std::vector<std::string> notes;
  for (const Part& part : parts_) std::ranges::copy(part.drives->notes(), std::back_inserter(notes));
  return notes;
}

}  // namespace inbetween
