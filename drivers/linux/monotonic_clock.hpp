#pragma once

#include <cstdint>

namespace inbetween {

/// The machine's monotonic clock. Steps of the wall clock do not touch it.
class MonotonicClock {
 public:
  /// Nanoseconds since an arbitrary start.
  [[nodiscard]] std::int64_t now_ns() const;
  /// Returns at or after a time of this clock; at once if it has passed. Signals do not shorten it.
  void sleep_until_ns(std::int64_t deadline_ns) const;
};

}  // namespace inbetween
