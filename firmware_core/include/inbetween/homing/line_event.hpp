#pragma once

#include <cstdint>

/// The edges of an input line.

namespace inbetween {

/// One edge of an input line.
struct LineEvent {
  std::int64_t at_ns = 0;    ///< its time, on the clock of its reader
  std::uint8_t line = 0;     ///< its place in the request of its reader
  bool level = false;        ///< after the edge
  bool lost_before = false;  ///< edges of some line between this event and the one before were lost
};

}  // namespace inbetween
