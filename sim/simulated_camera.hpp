#pragma once

#include <cstddef>

namespace inbetween {

/// A camera that exposes for as long as it has its signal, and may ask for the next frame as soon as it is
/// done.
class SimulatedCamera {
 public:
  explicit SimulatedCamera(bool asks_for_next) : asks_for_next_(asks_for_next) {}

  void signal(bool is_exposing) {
    if (!is_exposing && is_exposing_) {
      ++exposures_;
      is_done_ = asks_for_next_;
    }
    is_exposing_ = is_exposing;
  }
  bool has_triggered() {
    const bool triggered = is_done_;
    is_done_ = false;
    return triggered;
  }
  [[nodiscard]] std::size_t exposures() const { return exposures_; }

 private:
  bool asks_for_next_;
  bool is_exposing_ = false;
  bool is_done_ = false;
  std::size_t exposures_ = 0;
};

}  // namespace inbetween
