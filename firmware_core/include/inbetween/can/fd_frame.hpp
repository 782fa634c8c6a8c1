#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "inbetween/can/frame_id.hpp"

/// CAN FD (ISO 11898-1:2015): up to 64 bytes, which may be sent faster than the identifier.
///
/// This is a type of its own beside Frame: a classic bus then moves 16 bytes for each frame and not 72, and
/// what speaks classic CAN cannot be given a frame that its bus does not carry.

namespace inbetween::can {

/// A frame on a bus that carries CAN FD. `length` is the number of bytes of `data` that count, one of those
/// that a frame can have.
struct FdFrame {
  FrameId id = {};
  bool is_classic = false;    ///< a classic frame among the others: at most 8 bytes
  bool has_fast_data = true;  ///< its bytes are sent at the bitrate of data (bit rate switch)
  std::uint8_t length = 0;
  std::array<std::uint8_t, 64> data{};
  friend bool operator==(const FdFrame&, const FdFrame&) = default;
};

/// The least length that a frame can have for so many bytes, at most 64.
constexpr std::size_t fd_length_for(std::size_t bytes) {
  if (bytes <= 8) return bytes;
  for (const std::size_t length : {12U, 16U, 20U, 24U, 32U, 48U}) {
    if (bytes <= length) return length;
  }
  return 64;
}
constexpr bool is_fd_length(std::size_t length) {
  return length <= 64 && fd_length_for(length) == length;
}

}  // namespace inbetween::can
