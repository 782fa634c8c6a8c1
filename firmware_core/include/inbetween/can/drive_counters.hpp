#pragma once

#include <cstdint>

namespace inbetween::can {

/// The operator may see these counters. They only grow.
///
/// Process data carry no number, and one identifier stays in order on CAN. If a driver did swap two frames of
/// a drive, that would not be seen as such: the feedback of one tick would be that of the tick before, or one
/// of them would count as a duplicate.
struct DriveCounters {
  std::uint32_t feedback = 0;        ///< frames of process data taken
  std::uint32_t missed = 0;          ///< ticks without
  std::uint32_t bad_frames = 0;      ///< short, long, or not to be understood
  std::uint32_t duplicates = 0;      ///< process data that no SYNC asked for, once it has been started
  std::uint32_t stray_answers = 0;   ///< SDO answers that nobody waited for
  std::uint32_t emergencies = 0;     ///< EMCY with a code
  std::uint32_t foreign_frames = 0;  ///< frames that only the host sends, from somebody else
};

}  // namespace inbetween::can
