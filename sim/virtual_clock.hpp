#pragma once

#include <cstdint>

namespace inbetween {

/// A clock that stands still until somebody waits for it, and then has the time that was waited for: an
/// hour of motion takes as long as its arithmetic.
class VirtualClock {
 public:
  [[nodiscard]] std::int64_t now_ns() const { return now_ns_; }
  void sleep_until_ns(std::int64_t deadline_ns) {
    if (deadline_ns > now_ns_) now_ns_ = deadline_ns;
  }

 private:
  std::int64_t now_ns_ = 0;
};

}  // namespace inbetween
