#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "inbetween/can/canopen_id.hpp"
#include "inbetween/can/frame.hpp"

/// EMCY, CiA 301 section 7.2.7: what a device says once when an error appears or goes.

namespace inbetween::can {

struct Emergency {
  std::uint16_t code = 0;           ///< 0: the error is gone
  std::uint8_t error_register = 0;  ///< object 1001, a bit for each kind of error that is there now
  std::array<std::uint8_t, 5> manufacturer{};
  friend bool operator==(const Emergency&, const Emergency&) = default;
};

Frame emergency_frame(NodeId node, const Emergency& emergency);
/// Nothing where the frame is not an EMCY of `node` with eight bytes.
std::optional<Emergency> read_emergency(const Frame& frame, NodeId node);

/// The code in words (CiA 301 table 26, CiA 402-2): "following error". A code that has none of its own gets
/// the words of its class, "temperature".
const char* words_of_emergency(std::uint16_t code);
/// Whether the code says that frames of the other side are missing or wrong: the drive itself is well.
bool is_of_communication(std::uint16_t code);

}  // namespace inbetween::can
