#pragma once

#include <cstdint>

/// What a step generator hands to whoever drives the lines.

namespace inbetween {

/// Lines of one chip that change at the same instant. Bit i stands for line i of a request.
struct EdgeInstant {
  std::int64_t at_ns = 0;    ///< on the clock that its maker says
  std::uint64_t levels = 0;  ///< of the lines in `mask`; the other bits are 0
  std::uint64_t mask = 0;    ///< that change; not 0
};

}  // namespace inbetween
