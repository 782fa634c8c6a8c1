// The drive's side of the process data, and SYNC, for tests that stand in for a drive: what it hears and
// tells.
#pragma once

#include <optional>

#include "inbetween/can/canopen_id.hpp"
#include "inbetween/can/cia402.hpp"
#include "inbetween/can/little_endian.hpp"

namespace inbetween::can {

inline Frame feedback_frame(NodeId node, const DriveFeedback& feedback) {
  Frame frame{.id = tpdo1_id(node), .length = 7};
  store(frame.data, 0, feedback.statusword);
  store(frame.data, 2, static_cast<std::uint32_t>(feedback.actual));
  store(frame.data, 6, static_cast<std::uint8_t>(feedback.mode));
  return frame;
}

/// Nothing where the frame is another one or has another length.
inline std::optional<DriveCommand> read_command(const Frame& frame, NodeId node) {
  if (!is_canopen(frame) || frame.id != rpdo1_id(node) || frame.length != 6) return {};
  return DriveCommand{.controlword = load<std::uint16_t>(frame.data, 0),
                      .target = static_cast<std::int32_t>(load<std::uint32_t>(frame.data, 2))};
}

/// A SYNC that a drive has received.
struct SyncMark {
  std::optional<std::uint8_t> counter;
  friend bool operator==(const SyncMark&, const SyncMark&) = default;
};
/// Nothing where the frame is no SYNC or has more than one byte.
inline std::optional<SyncMark> read_sync(const Frame& frame) {
  if (!is_canopen(frame) || frame.id != sync_id || frame.length > 1) return {};
  if (frame.length == 0) return SyncMark{};
  return SyncMark{.counter = frame.data[0]};
}

}  // namespace inbetween::can
