#pragma once

#include <cstdint>

#include "inbetween/loop/tick_time.hpp"

namespace inbetween {

/// When the motion of each tick of a loop is played: a lead after the tick, and each behind the one before it
/// without a gap, however unevenly the loop wakes up. Ticks are counted from the first of a series, so that
/// nothing adds up where a tick is no whole number of nanoseconds.
class TickChain {
 public:
  TickChain(std::int32_t rate_hz, std::int64_t lead_ns) : rate_hz_(rate_hz), lead_ns_(lead_ns) {}

  /// The motion of this tick begins a series, at `start_ns`.
  void begin(std::int64_t start_ns) {
    anchor_ns_ = start_ns;
    number_ = 0;
    is_running_ = true;
  }
  /// The next, `ticks` after the last one. Returns by how much the loop is too late for it: where that is
  /// above 0, or no series has begun, one begins a lead after `now_ns`.
  std::int64_t next(std::int64_t now_ns, std::int32_t ticks = 1) {
    number_ += ticks;
    const std::int64_t late_ns = is_running_ && start_ns() < now_ns ? now_ns - start_ns() : 0;
    if (late_ns > 0 || !is_running_) begin(now_ns + lead_ns_);
    return late_ns;
  }
  void end() { is_running_ = false; }

  [[nodiscard]] bool is_running() const { return is_running_; }
  [[nodiscard]] std::int64_t lead_ns() const { return lead_ns_; }
  /// The times of the tick that `begin` or `next` spoke of last.
  [[nodiscard]] std::int64_t start_ns() const { return anchor_ns_ + time_of_tick(number_, rate_hz_); }
  [[nodiscard]] std::int64_t end_ns() const { return anchor_ns_ + time_of_tick(number_ + 1, rate_hz_); }

 private:
  std::int32_t rate_hz_;
  std::int64_t lead_ns_;
  std::int64_t anchor_ns_ = 0;
  std::int64_t number_ = 0;
  bool is_running_ = false;
};

}  // namespace inbetween
