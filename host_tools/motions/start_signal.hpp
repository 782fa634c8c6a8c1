// The signal that begins a move which waits for something outside.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

namespace inbetween {

/// Asked once a tick while a move waits; true: the move shall begin. Empty: nothing is waited for.
using StartSignal = std::function<bool(std::int64_t now_ns)>;

/// A StartSignal that comes by itself a second after it was asked for the first time.
class SimulatedTrigger {
 public:
  bool operator()(std::int64_t now_ns) {
    constexpr std::int64_t after_ns = 1'000'000'000;
    if (!asked_at_ns_) asked_at_ns_ = now_ns;
    return now_ns - *asked_at_ns_ >= after_ns;
  }

 private:
  std::optional<std::int64_t> asked_at_ns_;
};

}  // namespace inbetween
