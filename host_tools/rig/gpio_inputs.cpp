#include "host_tools/rig/gpio_inputs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "host_tools/text/diagnostics.hpp"

namespace inbetween {
namespace {

/// As many edges in a tick need no memory; a simulated rig may have more.
constexpr std::size_t usual_events = 256;

}  // namespace

// --- what the rig has

RigInputs::RigInputs(const RigFile& rig, RigHardware& hardware) : rig_(rig), axes_(rig.axes.size()) {
  if (rig.emergency_stop) emergency_ = add(*rig.emergency_stop);
  if (rig.start_trigger) trigger_ = add(*rig.start_trigger);
  if (rig.camera && rig.camera->asks) asks_ = add(*rig.camera->asks);
  for (std::size_t a = 0; a < rig.axes.size(); ++a) {
    const RigAxis& axis = rig.axes[a];
    if (axis.home) axes_[a].home = add(axis.home->input);
    if (axis.limit_min) add_limit(a, *axis.limit_min);
    if (axis.limit_max) add_limit(a, *axis.limit_max);
  }
  // No settings but those of settings_of, which are allowed.
  if (trigger_) trigger_input_ = *SwitchInput::make(settings_of(*trigger_));
  if (asks_) asks_input_ = *SwitchInput::make(settings_of(*asks_));
  open(hardware);
}

std::size_t RigInputs::add(const InputLine& input) {
  lines_.push_back({.input = &input, .level = input.active == Level::low});
  return lines_.size() - 1;
}

void RigInputs::add_limit(std::size_t axis, const InputLine& input) {
  const std::size_t line = add(input);
  axes_[axis].limits.push_back(limits_.size());
  limits_.push_back({.axis = axis, .line = line, .input = *SwitchInput::make(settings_of(line))});
}

SwitchSettings RigInputs::settings_of(std::size_t line) const {
  return {.line = static_cast<std::uint8_t>(line), .active_level = lines_[line].input->active == Level::high};
}

void RigInputs::open(RigHardware& hardware) {
  std::vector<const InputLine*> wanted;
  for (const Line& line : lines_) wanted.push_back(line.input);
  for (RigHardware::OpenedInputs& opened : hardware.open_inputs(wanted)) {
    for (std::size_t i = 0; i < opened.lines.size(); ++i) {
      lines_[opened.lines[i]].chip = chips_.size();
      lines_[opened.lines[i]].number = i;
    }
    chips_.push_back({std::move(opened)});
  }
  events_.reserve(usual_events * std::max<std::size_t>(chips_.size(), 1));
}

bool RigInputs::is_gone() const {
  return std::ranges::any_of(chips_, [](const Chip& chip) { return chip.chip->has_gone(); });
}

// --- a tick

void RigInputs::read_chip(Chip& chip, std::int64_t now_ns) {
  chip.events = chip.chip->read(now_ns);
  for (const LineEvent& event : chip.events) {
    events_.push_back(event);
    events_.back().line = static_cast<std::uint8_t>(chip.lines[event.line]);
  }
  for (std::size_t i = 0; i < chip.lines.size(); ++i) lines_[chip.lines[i]].level = chip.chip->level(i);
}

void RigInputs::read(std::int64_t now_ns) {
  events_.clear();
  for (Chip& chip : chips_) read_chip(chip, now_ns);
  put_in_order();
  limit_hit_ = false;
  look_at_emergency_stop();
  if (!has_started_) {
    for (Limit& limit : limits_) limit.input.start(now_ns, lines_[limit.line].level);
    if (trigger_) trigger_input_->start(now_ns, lines_[*trigger_].level);
    if (asks_) asks_input_->start(now_ns, lines_[*asks_].level);
    has_started_ = true;
    return;
  }
  look_at_limits(now_ns);
  look_at_buttons(now_ns);
}

/// Each chip's are nearly so already; std::stable_sort takes memory.
void RigInputs::put_in_order() {
  for (auto next = events_.begin(); next != events_.end(); ++next) {
    const auto place =
        std::upper_bound(events_.begin(), next, *next,
                         [](const LineEvent& a, const LineEvent& b) { return a.at_ns < b.at_ns; });
    std::rotate(place, next, next + 1);
  }
}

void RigInputs::look_at_emergency_stop() {
  asks_to_stop_ = is_gone();
  if (!emergency_) return;
  const Line& line = lines_[*emergency_];
  const bool healthy_level = line.input->active == Level::low;
  // Edges that another chip has lost were none of this line's.
  const std::span<const LineEvent> events = chips_[line.chip].events;
  const EmergencyInput button{.line = static_cast<std::uint8_t>(line.number), .healthy_level = healthy_level};
  if (!button.asks_to_stop(line.level, events)) return;
  asks_to_stop_ = true;
  const bool has_edge =
      std::ranges::any_of(events, [&](const LineEvent& event) { return event.line == button.line; });
  stop_ = line.level != healthy_level || has_edge ? Stop::pressed : Stop::events_lost;
}

void RigInputs::look_at_limits(std::int64_t now_ns) {
  for (std::size_t i = 0; i < limits_.size(); ++i) {
    Limit& limit = limits_[i];
    const bool level = lines_[limit.line].level;
    const bool is_hit = limit.input.update(now_ns, level, events_) == SwitchChange::activated;
    const bool chatters = limit.input.is_chattering();
    // Begun anew, so that it is found to chatter again.
    if (chatters) limit.input.start(now_ns, level);
    if (!is_hit && !chatters) continue;
    limit.was_chattering = chatters;
    limit_hit_ = true;
    last_limit_ = i;
  }
}

void RigInputs::look_at_buttons(std::int64_t now_ns) {
  if (trigger_ &&
      trigger_input_->update(now_ns, lines_[*trigger_].level, events_) == SwitchChange::activated) {
    start_triggered_ = true;
  }
  if (!asks_) return;
  const bool was_idle = !asks_input_->is_active() && !asks_input_->is_changing();
  const SwitchChange change = asks_input_->update(now_ns, lines_[*asks_].level, events_);
  if (was_idle && change != SwitchChange::none) camera_asks_ = true;
}

SwitchSettings RigInputs::home_switch(std::size_t axis) const {
  return settings_of(axes_[axis].home.value());
}

HomingInput RigInputs::homing_input(std::size_t axis) const {
  const AxisLines& of = axes_[axis];
  HomingInput input;
  if (of.home) input.level = lines_[*of.home].level;
  input.limit_hit = std::ranges::any_of(of.limits, [&](std::size_t limit) {
    return limits_[limit].input.is_active() || (limit_hit_ && last_limit_ == limit);
  });
  return input;
}

bool RigInputs::start_triggered() {
  return std::exchange(start_triggered_, false);
}

bool RigInputs::camera_asks() {
  return std::exchange(camera_asks_, false);
}

// --- in words

std::string RigInputs::trouble() const {
  for (const Chip& chip : chips_) {
    if (!chip.chip->has_gone()) continue;
    return fmt::format("chip {} of the rig has gone; plug it in again", in_quotes(chip.label));
  }
  if (EmergencySignal::is_pressed()) {
    return "the emergency stop is pressed; remove the cause, release it";
  }
  if (stop_ != Stop::none) {
    const Line& line = lines_[*emergency_];
    const std::string name = to_string(line.input->address);
    if (stop_ == Stop::events_lost) {
      return fmt::format(
          "edges were lost on the chip of the emergency stop, {}, and it may have been pressed; find the "
          "line "
          "that changes so often",
          name);
    }
    if (line.level == (line.input->active == Level::high)) {
      return fmt::format(
          "the emergency stop is pressed, or its wire is broken ({}); remove the cause, release it", name);
    }
    return fmt::format("the emergency stop was pressed, or its wire is loose ({}); remove the cause", name);
  }
  if (last_limit_) {
    const Limit& limit = limits_[*last_limit_];
    const std::string name = in_quotes(rig_.axes[limit.axis].name);
    const std::string line = to_string(lines_[limit.line].input->address);
    if (limit.was_chattering) {
      return fmt::format("a limit switch of axis {} is never quiet ({}); look at its wire and contact", name,
                         line);
    }
    return fmt::format("axis {} reached its limit switch ({}); move it off slowly, and look why", name, line);
  }
  return "";
}

}  // namespace inbetween
