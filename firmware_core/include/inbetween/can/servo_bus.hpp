#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "inbetween/base/result.hpp"
#include "inbetween/can/bus_tick.hpp"
#include "inbetween/can/servo_drive.hpp"

namespace inbetween::can {

/// The host's side of a bus with servo drives of one protocol (DriveBus). In a tick it sends the positions of
/// all drives one after the other, so that they act as nearly together as the bus can carry them, then at
/// most one order for each.
template <ServoProtocol Protocol>
class ServoBus {
 public:
  using Drive = ServoDrive<Protocol>;
  using Frame = typename Protocol::Frame;

  /// `drives` stays the caller's. Errors: wrong_count (none).
  static Result<ServoBus> make(std::span<Drive> drives) {
    if (drives.empty()) {
      return Error{.code = ErrorCode::wrong_count, .what = "a bus has no drive", .remedy = "give it one"};
    }
    return ServoBus(drives);
  }

  [[nodiscard]] std::span<Drive> drives() { return drives_; }
  [[nodiscard]] std::span<const Drive> drives() const { return drives_; }
  static constexpr std::size_t frames_per_tick(std::size_t drives) { return 2 * drives; }

  /// O(drives).
  void receive(const Frame& frame, std::int64_t now_ns) {
    for (Drive& drive : drives_) {
      if (drive.protocol().is_concerned(frame)) drive.receive(frame, now_ns);
    }
  }

  /// A target for each drive, or none at all: then nothing is sent to those that have followed targets.
  /// Errors: capacity, wrong_count, before anything has changed.
  Result<std::size_t> tick(std::int64_t now_ns, std::span<const ServoTarget> targets,
                           std::span<Frame> frames) {
    const Status is_possible = check_tick({.drives = drives_.size(),
                                           .targets = targets.size(),
                                           .room = frames.size(),
                                           .frames = frames_per_tick(drives_.size())});
    if (!is_possible) return is_possible.error();
    std::size_t count = 0;
    const auto send = [&](const std::optional<Frame>& frame) {
      if (frame) frames[count++] = *frame;
    };
    for (Drive& drive : drives_) drive.tick(now_ns);
    for (std::size_t i = 0; i < drives_.size(); ++i) {
      send(drives_[i].command(targets.empty() ? std::optional<ServoTarget>{} : targets[i]));
    }
    for (Drive& drive : drives_) send(drive.service(now_ns));
    return count;
  }

 private:
  explicit ServoBus(std::span<Drive> drives) : drives_(drives) {}
  std::span<Drive> drives_;
};

}  // namespace inbetween::can
