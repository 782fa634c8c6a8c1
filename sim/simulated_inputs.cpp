#include "sim/simulated_inputs.hpp"

#include <algorithm>
#include <utility>

namespace inbetween {
namespace {

/// So many edges in a tick need no memory.
constexpr std::size_t usual_events = 256;

}  // namespace

SimulatedInputs::SimulatedInputs(std::vector<bool> levels, std::span<const double> positions)
    : levels_(std::move(levels)) {
  for (const double position : positions) stands_.push_back({.position = position, .at_ns = {}});
  coming_.reserve(usual_events);
}

void SimulatedInputs::add_switch(std::size_t axis, const SimulatedSwitch::Settings& settings) {
  const SimulatedSwitch of(settings, stands_[axis].position, settings.line);
  levels_[settings.line] = of.level();
  switches_.push_back({.axis = axis, .line = settings.line, .of = of});
}

void SimulatedInputs::follow(std::size_t axis, double position, std::int64_t now_ns) {
  Stand& stand = stands_[axis];
  const std::int64_t from_ns = stand.at_ns.value_or(now_ns - 1);
  if (now_ns <= from_ns) return;
  const double seconds = static_cast<double>(now_ns - from_ns) * 1e-9;
  const double velocity = (position - stand.position) / seconds;
  const Setpoint from{.position = stand.position, .velocity = velocity};
  const Setpoint to{.position = position, .velocity = velocity};
  for (OnAxis& one : switches_) {
    if (one.axis != axis) continue;
    one.of.move(from_ns, from, now_ns, to, coming_);
    levels_[one.line] = one.of.level();
  }
  stand = {.position = position, .at_ns = now_ns};
}

void SimulatedInputs::set(std::size_t line, bool level, std::int64_t now_ns) {
  if (level == levels_[line]) return;
  levels_[line] = level;
  coming_.push_back({.at_ns = now_ns, .line = static_cast<std::uint8_t>(line), .level = level});
}

void SimulatedInputs::set_fault(std::size_t line, SimulatedSwitch::Fault fault) {
  std::ranges::find(switches_, line, &OnAxis::line)->of.set_fault(fault);
}

void SimulatedInputs::take(std::vector<LineEvent>& events) {
  events.insert(events.end(), coming_.begin(), coming_.end());
  coming_.clear();
}

}  // namespace inbetween
