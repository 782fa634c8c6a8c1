#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "inbetween/base/result.hpp"
#include "inbetween/can/canopen_id.hpp"
#include "inbetween/can/cia402_drive.hpp"
#include "inbetween/can/frame.hpp"
#include "inbetween/can/heartbeat.hpp"
#include "inbetween/can/sync.hpp"

namespace inbetween::can {

/// The host's side of a bus with CiA 402 drives. In tick k it sends, in this order: SYNC, by which every
/// drive applies the target of tick k and samples its feedback; the targets of tick k + 1, in the order of
/// the drives; the host's heartbeat when it is due, with the questions to guarded drives; at most one frame
/// of NMT or SDO, the drives taking turns. So SYNC never waits for another frame, and a target acts exactly
/// one tick after it was given.
///
/// Only tick() sends, so that the drives stop by themselves as soon as nobody calls it.
class Cia402Bus {
 public:
  using Drive = Cia402Drive;
  using Frame = can::Frame;
  struct Settings {
    NodeId host;
    std::uint8_t sync_overflow = 0;
    std::int64_t heartbeat_period_ns = 30'000'000;  ///< at most a third of every drive's host_timeout_ms
  };
  /// `drives` stays the caller's. Errors: wrong_count (none), out_of_range with `axis` (a drive has another
  /// host or SYNC counter, its timeout is less than three heartbeats), no_solution with `axis` (two
  /// drives have the same node).
  static Result<Cia402Bus> make(std::span<Cia402Drive> drives, const Settings& settings);

  [[nodiscard]] std::span<Cia402Drive> drives() { return drives_; }
  [[nodiscard]] std::span<const Cia402Drive> drives() const { return drives_; }
  /// The frames that a tick may send.
  static constexpr std::size_t frames_per_tick(std::size_t drives) { return 2 * drives + 3; }

  /// A frame that has arrived. Those of others are no concern of ours. O(drives).
  void receive(const Frame& frame, std::int64_t now_ns);
  /// A target for each drive, in counts, or none at all: then nothing is sent to those that follow targets,
  /// nor the host's heartbeat nor a question, and their own watchdogs stop them. Returns how many frames were
  /// put into `frames`. Errors: capacity, wrong_count, before anything has changed.
  Result<std::size_t> tick(std::int64_t now_ns, std::span<const std::int32_t> targets,
                           std::span<Frame> frames);

 private:
  Cia402Bus(std::span<Cia402Drive> drives, const SyncProducer& sync, const HeartbeatProducer& heartbeat,
            NodeId host)
      : drives_(drives), sync_(sync), heartbeat_(heartbeat), host_(host) {}
  [[nodiscard]] bool wants_heartbeat(std::span<const std::int32_t> targets) const;
  std::optional<Frame> next_service(std::int64_t now_ns);

  std::span<Cia402Drive> drives_;
  SyncProducer sync_;
  HeartbeatProducer heartbeat_;
  NodeId host_;
  std::size_t next_served_ = 0;
};

}  // namespace inbetween::can
