#pragma once

#include <cstddef>

namespace inbetween {

/// A camera that exposes for as long as it has its signal, and may ask for a frame whenever it does not.
class SimulatedCamera {
 public:
  explicit SimulatedCamera(bool is_ready) : is_ready_(is_ready) {}

  void signal(bool is_exposing) {
    if (!is_exposing && is_exposing_) ++exposures_;
    is_exposing_ = is_exposing;
  }
  [[nodiscard]] bool asks() const { return is_ready_ && !is_exposing_; }
  [[nodiscard]] std::size_t exposures() const { return exposures_; }

 private:
  bool is_ready_;
  bool is_exposing_ = false;
  std::size_t exposures_ = 0;
};

}  // namespace inbetween
