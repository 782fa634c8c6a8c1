#include "host_tools/rig/gpio_inputs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "host_tools/rig/rig_chips.hpp"
#include "host_tools/rig/rig_drives.hpp"

namespace inbetween {
namespace {

/// A simulated limit switch is so far beyond the limit, as a share of the axis' travel.
constexpr double limit_margin = 0.02;
/// Simulated switches open so far before they closed, as a share of the way to back off.
constexpr double hysteresis_share = 0.25;
/// Of a simulated rig, a tick; more take memory.
constexpr std::size_t usual_events = 256;

gpio::Bias bias_of(Bias bias) {
  switch (bias) {
    case Bias::pull_up:
      return gpio::Bias::pull_up;
    case Bias::pull_down:
      return gpio::Bias::pull_down;
    case Bias::none:
      break;
  }
  return gpio::Bias::none;
}

/// An axis that finds its switch at `fast` is behind it by less than this when it stands.
double overrun_of(const RigAxis& axis) {
  const double fast = axis.home->fast;
  const double ramp = axis.max_jerk ? axis.max_acceleration / *axis.max_jerk : 0;
  constexpr double seconds_until_known = 0.05;
  return fast * (fast / axis.max_acceleration + ramp + seconds_until_known);
}

/// Where the simulated limit switches of an axis are.
double limit_place(const RigAxis& axis, bool is_max) {
  const double margin = limit_margin * (axis.max - axis.min);
  double end = is_max ? axis.max : axis.min;
  if (axis.home && (axis.home->direction > 0) == is_max) {
    const double behind = axis.home->at + axis.home->direction * overrun_of(axis);
    end = is_max ? std::max(end, behind) : std::min(end, behind);
  }
  return is_max ? end + margin : end - margin;
}

}  // namespace

// --- what the rig has

RigInputs::RigInputs(const RigFile& rig) : rig_(rig), axes_(rig.axes.size()) {
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

// --- on chips

std::unique_ptr<RigInputs> RigInputs::on_chips(const RigFile& rig) {
  std::unique_ptr<RigInputs> lines(new RigInputs(rig));
  lines->find_chips();
  for (Chip& chip : lines->chips_) lines->open(chip);
  lines->events_.reserve(lines->chips_.size() * gpio::GpioInputs::max_events);
  return lines;
}

/// Every line is looked for before any is taken.
void RigInputs::find_chips() {
  std::vector<unsigned> offsets;
  for (Line& line : lines_) {
    const LineAddress& address = line.input->address;
    gpio::GpioChip chip;
    open_chip_of(address, chip);
    const gpio::LineChoice choice = choice_of(address.line);
    if (const auto no_line = chip.find(std::span(&choice, 1), offsets)) refuse(address, *no_line);
    const auto known = std::ranges::find(chips_, chip.label(), &Chip::label);
    line.chip = static_cast<std::size_t>(known - chips_.begin());
    if (known == chips_.end()) chips_.emplace_back().label = chip.label();
    line.place = chips_[line.chip].lines.size();
    chips_[line.chip].lines.push_back(static_cast<std::size_t>(&line - lines_.data()));
  }
}

void RigInputs::open(Chip& chip) {
  std::vector<gpio::InputLine> wanted;
  for (const std::size_t line : chip.lines) {
    const InputLine& input = *lines_[line].input;
    wanted.push_back({.line = choice_of(input.address.line), .bias = bias_of(input.bias)});
  }
  const LineAddress& first = lines_[chip.lines.front()].input->address;
  gpio::GpioChip machine;
  if (const auto refusal = machine.open(chip.label)) refuse(first, *refusal);
  if (const auto refusal = chip.inputs.open(machine, wanted)) refuse(first, *refusal);
}

void RigInputs::read_chip(std::size_t number) {
  Chip& chip = chips_[number];
  // The levels after the edges: they are what holds.
  chip.count = chip.inputs.read(chip.events);
  for (const LineEvent& event : std::span(chip.events).first(chip.count)) {
    events_.push_back(event);
    events_.back().line = static_cast<std::uint8_t>(chip.lines[event.line]);
  }
  const std::optional<std::uint64_t> levels = chip.inputs.levels();
  if (!levels) return;
  for (std::size_t i = 0; i < chip.lines.size(); ++i) {
    lines_[chip.lines[i]].level = (*levels >> i & 1U) != 0;
  }
}

bool RigInputs::is_gone() const {
  return std::ranges::any_of(chips_,
                             [](const Chip& chip) { return chip.inputs.state() != gpio::ChipState::there; });
}

// --- in simulation

std::unique_ptr<RigInputs> RigInputs::simulated(const RigFile& rig, const std::vector<double>& positions) {
  std::unique_ptr<RigInputs> lines(new RigInputs(rig));
  std::vector<bool> released;
  for (const Line& line : lines->lines_) released.push_back(line.level);
  SimulatedInputs& simulated = lines->simulated_.emplace(std::move(released), positions);
  const auto add_switch = [&](std::size_t axis, std::size_t line, bool is_above, double closes) {
    const RigAxis& of = rig.axes[axis];
    const double opens_after = of.home ? of.home->back_off : limit_margin * (of.max - of.min);
    const SwitchSettings settings = lines->settings_of(line);
    simulated.add_switch(axis, {.line = settings.line,
                                .active_level = settings.active_level,
                                .is_above = is_above,
                                .closes = closes,
                                .hysteresis = hysteresis_share * opens_after});
  };
  for (std::size_t a = 0; a < rig.axes.size(); ++a) {
    const RigAxis& axis = rig.axes[a];
    if (axis.home) add_switch(a, *lines->axes_[a].home, axis.home->direction > 0, axis.home->at);
    for (const std::size_t limit : lines->axes_[a].limits) {
      const std::size_t line = lines->limits_[limit].line;
      const bool is_max = axis.limit_max && lines->lines_[line].input == &*axis.limit_max;
      add_switch(a, line, is_max, limit_place(axis, is_max));
    }
  }
  lines->events_.reserve(usual_events);
  return lines;
}

void RigInputs::read_simulated(std::int64_t now_ns) {
  for (std::size_t a = 0; followed_ != nullptr && a < axes_.size(); ++a) {
    simulated_->follow(a, followed_->true_position(a), now_ns);
  }
  simulated_->take(events_);
  for (std::size_t line = 0; line < lines_.size(); ++line) lines_[line].level = simulated_->level(line);
}

std::size_t RigInputs::line_of(RigInput input) const {
  switch (input) {
    case RigInput::emergency_stop:
      return emergency_.value();
    case RigInput::start_trigger:
      return trigger_.value();
    case RigInput::camera_asks:
      break;
  }
  return asks_.value();
}

// --- a tick

void RigInputs::read(std::int64_t now_ns) {
  events_.clear();
  for (std::size_t i = 0; i < chips_.size(); ++i) read_chip(i);
  if (simulated_) read_simulated(now_ns);
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
  std::span<const LineEvent> events = events_;
  EmergencyInput button{.line = static_cast<std::uint8_t>(*emergency_), .healthy_level = healthy_level};
  if (!chips_.empty()) {
    // What another chip has lost was none of this line's edges.
    const Chip& chip = chips_[line.chip];
    events = std::span(chip.events).first(chip.count);
    button.line = static_cast<std::uint8_t>(line.place);
  }
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
    if (chip.inputs.state() == gpio::ChipState::there) continue;
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
