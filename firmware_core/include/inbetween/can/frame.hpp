#pragma once

#include <array>
#include <cstdint>

#include "inbetween/can/frame_id.hpp"

namespace inbetween::can {

/// A classic CAN frame. `length` is the number of bytes of `data` that count, 0 to 8.
struct Frame {
  FrameId id = {};
  bool is_remote = false;
  std::uint8_t length = 0;
  std::array<std::uint8_t, 8> data{};
  friend bool operator==(const Frame&, const Frame&) = default;
};

}  // namespace inbetween::can
