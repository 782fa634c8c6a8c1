// How many frames of a shoot there are, and were shot.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace inbetween {

/// How many frames were shot.
struct ShootCount {
  std::int32_t first = 0, last = 0;  ///< the frames that were due
  std::int32_t shot = 0;             ///< once or more
  std::int32_t shot_again = 0;       ///< more than once
  std::int32_t skipped = 0;          ///< not shot, before one that was
  std::int32_t left = 0;             ///< not shot, behind all that were
  std::int64_t cut_off = 0;          ///< exposures during which the rig was stopped; they do not count
  std::optional<std::int32_t> last_shot = {};

  /// `shots` says of each frame from `first` on how often it was shot.
  static ShootCount of(std::int32_t first, std::span<const std::int32_t> shots) {
    ShootCount count{.first = first, .last = first + static_cast<std::int32_t>(shots.size()) - 1};
    std::int32_t missing = 0;
    for (std::int32_t frame = first; frame <= count.last; ++frame) {
      const std::int32_t times = shots[static_cast<std::size_t>(frame - first)];
      if (times == 0) {
        ++missing;
        continue;
      }
      ++count.shot;
      if (times > 1) ++count.shot_again;
      count.skipped = missing;
      count.last_shot = frame;
    }
    count.left = missing - count.skipped;
    return count;
  }

  [[nodiscard]] std::int32_t due() const { return last - first + 1; }
  [[nodiscard]] bool has_all() const { return shot == due(); }
};

}  // namespace inbetween
