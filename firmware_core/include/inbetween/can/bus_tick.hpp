#pragma once

#include <cstddef>
#include <cstdint>

#include "inbetween/base/result.hpp"

namespace inbetween::can {

/// What a bus is given for a tick, in numbers.
struct TickSizes {
  std::size_t drives = 0;
  std::size_t targets = 0;
  std::size_t room = 0;    ///< for frames
  std::size_t frames = 0;  ///< that the tick may have
};
/// Before anything changes. Errors: wrong_count (neither a target for each drive nor none), capacity (no room
/// for the frames); `needed` says how many.
constexpr Status check_tick(const TickSizes& sizes) {
  if (sizes.targets != 0 && sizes.targets != sizes.drives) {
    return Error{.code = ErrorCode::wrong_count,
                 .what = "there is not a target for each drive",
                 .remedy = "give one for each, or none at all",
                 .needed = static_cast<std::int64_t>(sizes.drives)};
  }
  if (sizes.room < sizes.frames) {
    return Error{.code = ErrorCode::capacity,
                 .what = "the frames of a tick do not fit",
                 .remedy = "give room for frames_per_tick()",
                 .needed = static_cast<std::int64_t>(sizes.frames)};
  }
  return Done{};
}

}  // namespace inbetween::can
