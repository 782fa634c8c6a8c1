#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "inbetween/base/result.hpp"
#include "inbetween/can/canopen_id.hpp"
#include "inbetween/can/frame.hpp"
#include "inbetween/can/nmt.hpp"

/// Heartbeats, CiA 301 section 7.2.8.3.2.2. Times are nanoseconds of one monotonic clock of the caller's.

namespace inbetween::can {

/// Tells the others that this device is alive. A late call sends one heartbeat, never several.
class HeartbeatProducer {
 public:
  /// `period_ns` > 0. The first heartbeat is due at the first `poll`. Errors: out_of_range.
  static Result<HeartbeatProducer> make(NodeId node, std::int64_t period_ns);

  /// The heartbeat, if one is due.
  std::optional<Frame> poll(std::int64_t now_ns, NmtState state);
  /// When the next is due; meaningless before the first.
  [[nodiscard]] std::int64_t deadline_ns() const { return deadline_ns_; }

 private:
  HeartbeatProducer(NodeId node, std::int64_t period_ns) : node_(node), period_ns_(period_ns) {}
  NodeId node_;
  std::int64_t period_ns_;
  std::int64_t deadline_ns_ = 0;
  bool is_started_ = false;
};

enum class HeartbeatState : std::uint8_t {
  off,         ///< nobody listens
  waiting,     ///< for the first heartbeat, until the boot timer ends; a boot-up message is none
  alive,       ///< the last heartbeat is younger than the timeout
  lost,        ///< it is older; another heartbeat makes it alive again
  never_came,  ///< the boot timer has ended without one
  rebooted,    ///< a boot-up message came from a device that was alive
};
inline constexpr std::size_t heartbeat_states = 6;

enum class HeartbeatEvent : std::uint8_t { start, boot_up, heartbeat, deadline };
inline constexpr std::size_t heartbeat_events = 4;

/// The whole table. rebooted and never_came are left by `start` alone, so that nobody overlooks them.
HeartbeatState next_state(HeartbeatState state, HeartbeatEvent event);

/// Listens for the heartbeats of another device. Its first heartbeat starts the supervision (CiA 301); until
/// then a boot timer of our own runs, because the standard lets a device that never starts go unnoticed.
class HeartbeatConsumer {
 public:
  /// `timeout_ns`: two to three periods of the producer. `boot_timeout_ns`: how long the first may take.
  struct Times {
    std::int64_t timeout_ns = 0;
    std::int64_t boot_timeout_ns = 0;
  };
  constexpr explicit HeartbeatConsumer(const Times& times) : times_(times) {}

  void start(std::int64_t now_ns);
  void stop() { state_ = HeartbeatState::off; }
  void receive(NmtState heard, std::int64_t now_ns);
  /// The state at `now_ns`.
  HeartbeatState poll(std::int64_t now_ns);
  [[nodiscard]] HeartbeatState state() const { return state_; }
  /// When `poll` will find waiting or alive ended.
  [[nodiscard]] std::int64_t deadline_ns() const { return deadline_ns_; }

 private:
  void apply(HeartbeatEvent event, std::int64_t now_ns);
  Times times_;
  HeartbeatState state_ = HeartbeatState::off;
  std::int64_t deadline_ns_ = 0;
};

}  // namespace inbetween::can
