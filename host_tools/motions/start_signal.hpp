// The signal that begins a move which waits for something outside.
#pragma once

#include <cstdint>

namespace inbetween {

/// Refers to anything with a function `bool start_triggered(std::int64_t now_ns)`, which is asked once a tick
/// while a move waits, and tells whether it shall begin. Empty: nothing is waited for.
struct StartSignal {
  void* of = nullptr;
  bool (*has_come)(void*, std::int64_t now_ns) = nullptr;
};

template <class Trigger>
StartSignal start_signal_of(Trigger& trigger) {
  return {.of = &trigger, .has_come = [](void* of, std::int64_t now_ns) {
            return static_cast<Trigger*>(of)->start_triggered(now_ns);
          }};
}

/// Comes by itself a second after it was asked for the first time.
class SimulatedTrigger {
 public:
  bool start_triggered(std::int64_t now_ns) {
    constexpr std::int64_t after_ns = 1'000'000'000;
    if (!is_asked_) asked_at_ns_ = now_ns;
    is_asked_ = true;
    return now_ns - asked_at_ns_ >= after_ns;
  }

 private:
  bool is_asked_ = false;
  std::int64_t asked_at_ns_ = 0;
};

}  // namespace inbetween
