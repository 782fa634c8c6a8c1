#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <utility>

#include "inbetween/steps/edge_instant.hpp"
#include "sim/simulated_stepper.hpp"

namespace inbetween {

/// A GPIO chip with stepper drivers behind its lines (StepSink), on whatever clock it is told.
class SimulatedStepChip {
 public:
  /// Behind lines of it. Returns its number.
  std::size_t add(const SimulatedStepper& stepper) {
    steppers_.push_back(stepper);
    return steppers_.size() - 1;
  }

  // StepSink
  bool push(const EdgeInstant& instant) {
    if (has_ended_) return false;
    waiting_.push_back(instant);
    return true;
  }
  void discard() { waiting_.clear(); }
  [[nodiscard]] std::uint64_t waiting() const { return waiting_.size(); }
  [[nodiscard]] bool is_too_late() const { return false; }
  [[nodiscard]] bool has_ended() const { return has_ended_; }

  /// Plays what is due.
  void run(std::int64_t now_ns) {
    for (; !waiting_.empty() && waiting_.front().at_ns <= now_ns; waiting_.pop_front()) {
      levels_ = (levels_ & ~waiting_.front().mask) | waiting_.front().levels;
      // Instants are played in their order.
      for (SimulatedStepper& stepper : steppers_) static_cast<void>(stepper.take(waiting_.front()));
      if (tell_) tell_(waiting_.front());
    }
  }
  /// Called with each instant that was played, once its steppers have it.
  void tell_played(std::function<void(const EdgeInstant&)> tell) { tell_ = std::move(tell); }
  /// The chip is unplugged.
  void remove() { has_ended_ = true; }

  [[nodiscard]] const SimulatedStepper& stepper(std::size_t number) const { return steppers_[number]; }
  /// The levels of all lines: bit i belongs to line i.
  [[nodiscard]] std::uint64_t levels() const { return levels_; }

 private:
  std::deque<SimulatedStepper> steppers_;
  std::deque<EdgeInstant> waiting_;
  std::function<void(const EdgeInstant&)> tell_;
  std::uint64_t levels_ = 0;
  bool has_ended_ = false;
};

}  // namespace inbetween
