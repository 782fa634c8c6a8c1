#pragma once

#include <cstdint>

/// The unit in which edges go to the driver of the lines.

namespace inbetween {

/// Lines of one chip that change at the same instant. Bit i stands for line i of a request.
struct EdgeInstant {
  std::int64_t at_ns = 0;    ///< on the clock of its maker
  std::uint64_t levels = 0;  ///< of the lines in `mask`; the other bits are 0
  std::uint64_t mask = 0;    ///< the lines that change; not 0
};

}  // namespace inbetween
