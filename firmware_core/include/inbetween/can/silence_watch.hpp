#pragma once

#include <cstdint>

namespace inbetween::can {

/// Whether a drive was silent for longer than `limit_ns`. O(1).
class SilenceWatch {
 public:
  explicit SilenceWatch(std::int64_t limit_ns) : limit_ns_(limit_ns) {}

  void hear(std::int64_t now_ns) {
    if (is_silent(now_ns)) ended_ns_ = now_ns;
    heard_ns_ = now_ns;
  }
  /// Looks for silences from now on.
  void begin() { was_silent_ = false; }
  void look(std::int64_t now_ns) { was_silent_ = was_silent_ || is_silent(now_ns); }

  [[nodiscard]] bool is_silent(std::int64_t now_ns) const { return now_ns - heard_ns_ > limit_ns_; }
  /// Somebody has looked while it was silent.
  [[nodiscard]] bool was_silent() const { return was_silent_; }
  /// No silence has ended since then, whether somebody looked or not.
  [[nodiscard]] bool was_heard_since(std::int64_t then_ns) const { return ended_ns_ < then_ns; }

 private:
  std::int64_t limit_ns_;
  std::int64_t heard_ns_ = 0;
  std::int64_t ended_ns_ = 0;  ///< the last silence
  bool was_silent_ = false;
};

}  // namespace inbetween::can
