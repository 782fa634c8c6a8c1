// The lines of a rig (LinePort), which are released until a test says otherwise.
#pragma once

#include <cstdint>

namespace inbetween {

struct SimulatedLines {
  bool is_pressed = false;
  bool is_at_limit = false;
  int begins = 0;
  void read(std::int64_t /*now_ns*/) {}
  void begin() { ++begins; }
  [[nodiscard]] bool limit_hit() const { return is_at_limit; }
  [[nodiscard]] bool emergency_stop() const { return is_pressed; }
};

}  // namespace inbetween
