// A jog that is held: the host repeats it, and when it does no longer the motor is stopped. A host that dies
// with a key pressed moves nothing for longer.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "host_tools/dragonframe/rig_port.hpp"

namespace inbetween::dragonframe {

/// The maker's devices plan half a second ahead of a jog, and hosts repeat it in less.
inline constexpr std::int64_t jog_hold_ns = 500'000'000;

class JogHold {
 public:
  void press(std::uint8_t motor, int direction, std::int64_t now_ns) {
    holds_.at(motor - 1U) = {.direction = direction, .until_ns = now_ns + jog_hold_ns};
  }
  void release(std::uint8_t motor) { holds_.at(motor - 1U).until_ns.reset(); }
  void clear() { holds_ = {}; }

  /// -1 or 1 while the last jog of this motor moves it, held or not; 0 with any other motion.
  [[nodiscard]] int direction(std::uint8_t motor) const { return holds_.at(motor - 1U).direction; }
  /// Another motion has begun.
  void forget(std::uint8_t motor) { holds_.at(motor - 1U) = {}; }

  /// A motor whose jog was not repeated in time; it is released.
  std::optional<std::uint8_t> take_expired(std::int64_t now_ns) {
    for (std::size_t i = 0; i < holds_.size(); ++i) {
      if (!holds_[i].until_ns || now_ns < *holds_[i].until_ns) continue;
      holds_[i].until_ns.reset();
      return static_cast<std::uint8_t>(i + 1);
    }
    return {};
  }
  /// What rests is no longer in a jog, unless it is held and has not begun.
  void rest(MotorMask moving) {
    for (std::size_t i = 0; i < holds_.size(); ++i) {
      if ((moving >> i & 1U) == 0 && !holds_[i].until_ns) holds_[i] = {};
    }
  }

 private:
  struct Hold {
    int direction = 0;
    std::optional<std::int64_t> until_ns;
  };
  std::array<Hold, max_motors> holds_{};
};

}  // namespace inbetween::dragonframe
