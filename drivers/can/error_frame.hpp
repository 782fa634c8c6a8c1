#pragma once

#include <array>
#include <cstdint>

namespace inbetween::can {

/// A report of a controller about itself and its bus, in a frame that was never on the bus, as far as
/// somebody acts on it.
struct ErrorFrame {
  bool is_receive_overflow = false;   ///< the controller was not emptied in time: frames are lost
  bool is_transmit_overflow = false;  ///< the controller was given more than it can hold
  bool is_warning = false;            ///< one of its error counters is at 96 or above
  bool is_passive = false;            ///< at 128 or above: it cannot make others hear its errors any more
  bool is_active = false;             ///< back to normal
  bool is_unacknowledged = false;     ///< nobody on the bus has heard a frame
  bool is_bus_off = false;            ///< its transmit counter reached 256: it has left the bus
  bool is_restarted = false;          ///< it is on the bus again after bus-off
  friend bool operator==(const ErrorFrame&, const ErrorFrame&) = default;
};

/// Reads an error frame as Linux makes it: `id` as in struct can_frame, flags included, and its eight bytes.
/// Source: linux/can/error.h. Constant time.
[[nodiscard]] ErrorFrame decode_error_frame(std::uint32_t id, const std::array<std::uint8_t, 8>& data);

}  // namespace inbetween::can
