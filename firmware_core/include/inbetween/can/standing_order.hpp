#pragma once

#include <cstdint>
#include <optional>

#include "inbetween/can/servo_report.hpp"

namespace inbetween::can {

/// One order to a drive at a time: sent at once, and again in every `repeat_ns` until it is withdrawn. The
/// next one takes its place. O(1).
class StandingOrder {
 public:
  explicit StandingOrder(std::int64_t repeat_ns) : repeat_ns_(repeat_ns) {}

  /// A new phase, in which nothing has been ordered.
  void begin() { *this = StandingOrder(repeat_ns_); }
  void give(ServoOrder order) {
    order_ = order;
    due_ns_.reset();
  }
  void withdraw() { order_.reset(); }
  /// What is to be sent now, if anything.
  std::optional<ServoOrder> next(std::int64_t now_ns) {
    if (!order_ || (due_ns_ && now_ns < *due_ns_)) return {};
    const bool is_first = !due_ns_;
    due_ns_ = now_ns + repeat_ns_;
    if (is_first) sent_ns_ = now_ns;
    // Asked for again a drive would leave its loop and come back.
    if (order_ == ServoOrder::switch_on && !is_first) return {};
    return order_;
  }

  [[nodiscard]] bool stands() const { return order_.has_value(); }
  [[nodiscard]] bool is(ServoOrder order) const { return order_ == order; }
  [[nodiscard]] bool was_sent() const { return due_ns_.has_value(); }
  /// What a drive tells at this time it tells after it was sent an order of this phase.
  [[nodiscard]] bool is_answered(std::int64_t told_ns) const { return sent_ns_ && told_ns > *sent_ns_; }

 private:
  std::int64_t repeat_ns_;
  std::optional<ServoOrder> order_;
  std::optional<std::int64_t> due_ns_;   ///< none: at once
  std::optional<std::int64_t> sent_ns_;  ///< the last one, for the first time
};

}  // namespace inbetween::can
