#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "inbetween/homing/homing.hpp"
#include "inbetween/play/free_axis.hpp"
#include "sim/simulated_switch.hpp"

namespace inbetween {

/// An axis of a rig that does not know where it is, and its switch, whose place is in true positions.
struct LostAxis {
  FreeAxisLimits limits;
  HomingSpec spec;
  SimulatedSwitch::Settings there;
  double true_position = 0;  ///< where it is ...
  double position = 0;       ///< ... and where it takes itself to be
};

inline FreeAxisLimits as(const FreeAxisLimits& limits) {
  return {static_cast<double>(limits.velocity), static_cast<double>(limits.acceleration),
          static_cast<double>(limits.jerk), static_cast<double>(limits.min), static_cast<double>(limits.max)};
}
inline HomingSpec as(const HomingSpec& spec) {
  return {.towards_max = spec.towards_max,
          .at = static_cast<double>(spec.at),
          .fast = static_cast<double>(spec.fast),
          .slow = static_cast<double>(spec.slow),
          .search = static_cast<double>(spec.search),
          .leave = static_cast<double>(spec.leave),
          .back_off = static_cast<double>(spec.back_off),
          .home = spec.home};
}

/// Axes that are exactly where they were commanded to be a tick ago, and home. What they did is kept.
class SimulatedHoming {
 public:
  SimulatedHoming(const std::vector<LostAxis>& lost, int rate_hz, std::uint32_t seed)
      : lost_(lost), tick_ns_(1'000'000'000 / rate_hz) {
    axes_.reserve(lost.size());
    for (const LostAxis& each : lost_) {
      axes_.push_back(*FreeAxis::make(as(each.limits), static_cast<double>(each.position),
                                      static_cast<double>(tick_s())));
      switches_.emplace_back(each.there, each.true_position,
                             seed + static_cast<std::uint32_t>(switches_.size()));
      homings_.push_back(*AxisHoming::make(as(each.spec), axes_.back()));
    }
    at_.resize(lost.size());
    for (std::size_t i = 0; i < lost.size(); ++i) at_[i] = axes_[i].state();
    inputs.resize(lost.size());
    read_levels();
    homing_ = Homing(homings_, tick_ns_);
  }
  SimulatedHoming(const SimulatedHoming&) = delete;
  SimulatedHoming& operator=(const SimulatedHoming&) = delete;

  Status start() { return homing_.start(now_ns_, inputs); }

  /// One tick: what the lines have told is read, the setpoints are written, and the axes move to them.
  HomingState tick() {
    read_levels();
    std::ranges::sort(events_, {}, &LineEvent::at_ns);
    if (loses_events && !events_.empty()) {
      events_.erase(events_.begin());
      if (!events_.empty()) events_.front().lost_before = true;
    }
    std::vector<Setpoint> out(axes_.size());
    events_.insert(events_.end(), spikes.begin(), spikes.end());
    spikes.clear();
    std::ranges::sort(events_, {}, &LineEvent::at_ns);
    const HomingState state = homing_.tick(now_ns_, inputs, events_, out);
    events_.clear();
    for (std::size_t i = 0; i < axes_.size(); ++i) {
      switches_[i].move(now_ns_, truly(i, at_[i]), now_ns_ + tick_ns_, truly(i, out[i]), events_);
      fastest_ = std::max(fastest_, std::fabs(static_cast<double>(out[i].velocity)) / lost_[i].spec.fast);
      sharpest_ = std::max(
          sharpest_, std::fabs(static_cast<double>(out[i].acceleration)) / lost_[i].limits.acceleration);
    }
    at_ = out;
    now_ns_ += tick_ns_;
    return state;
  }
  /// Until nothing moves any more; at most ten minutes.
  HomingState run() {
    HomingState state = homing_.state();
    for (std::int64_t i = 600'000'000'000 / tick_ns_; i > 0 && state == HomingState::moving; --i)
      state = tick();
    return state;
  }
  /// Until an axis is in a phase; false: it never was.
  bool run_to(std::size_t axis, HomingPhase phase) {
    while (homings_[axis].phase() != phase) {
      if (tick() != HomingState::moving) return homings_[axis].phase() == phase;
    }
    return true;
  }

  [[nodiscard]] Homing& homing() { return homing_; }
  [[nodiscard]] const AxisHoming& axis(std::size_t i) const { return homings_[i]; }
  [[nodiscard]] FreeAxis& free_axis(std::size_t i) { return axes_[i]; }
  [[nodiscard]] SimulatedSwitch& home_switch(std::size_t i) { return switches_[i]; }
  [[nodiscard]] const Setpoint& setpoint(std::size_t i) const { return at_[i]; }
  [[nodiscard]] std::int64_t now_ns() const { return now_ns_; }
  [[nodiscard]] double tick_s() const { return static_cast<double>(tick_ns_) / 1e9; }
  /// By how much an axis is wrong about where it is, once it is referenced.
  [[nodiscard]] double error(std::size_t i) const {
    const double says = static_cast<double>(at_[i].position) + static_cast<double>(homings_[i].shift());
    return says - (lost_[i].spec.at + truly(i, at_[i]).position - lost_[i].there.closes);
  }
  /// Shares of `fast` and of the acceleration that no tick went beyond.
  [[nodiscard]] double fastest() const { return fastest_; }
  [[nodiscard]] double sharpest() const { return sharpest_; }

  /// What the lines will tell on the next tick; the levels of the home switches are read by tick().
  std::vector<HomingInput> inputs;
  /// Beside what the switches tell, on the next tick.
  std::vector<LineEvent> spikes;
  /// The first event of every tick is lost, and the next one says so.
  bool loses_events = false;

 private:
  [[nodiscard]] Setpoint truly(std::size_t i, const Setpoint& setpoint) const {
    return {.position = static_cast<double>(setpoint.position) + lost_[i].true_position - lost_[i].position,
            .velocity = static_cast<double>(setpoint.velocity),
            .acceleration = static_cast<double>(setpoint.acceleration)};
  }
  void read_levels() {
    for (std::size_t i = 0; i < switches_.size(); ++i) inputs[i].level = switches_[i].level();
  }

  std::vector<LostAxis> lost_;
  std::int64_t tick_ns_;
  std::int64_t now_ns_ = 5'000'000'000;
  std::vector<FreeAxis> axes_;
  std::vector<SimulatedSwitch> switches_;
  std::vector<AxisHoming> homings_;
  Homing homing_{{}, 0};
  std::vector<Setpoint> at_;
  std::vector<LineEvent> events_;
  double fastest_ = 0;
  double sharpest_ = 0;
};

}  // namespace inbetween
