#pragma once

#include <cstdint>

/// What an input line tells of its edges.

namespace inbetween {

/// One edge of an input line.
struct LineEvent {
  std::int64_t at_ns = 0;    ///< when it came, on the clock that its reader says
  std::uint8_t line = 0;     ///< its place in the request of its reader
  bool level = false;        ///< after the edge
  bool lost_before = false;  ///< edges between this event and the one before were lost: of any line
};

}  // namespace inbetween
