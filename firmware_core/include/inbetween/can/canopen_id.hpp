#pragma once

#include <cstdint>

#include "inbetween/can/device_number.hpp"
#include "inbetween/can/frame.hpp"

/// Who sends what under which identifier: the pre-defined connection set of CiA 301, section 7.3.5.

namespace inbetween::can {

struct NodeIdRange {
  static constexpr std::int64_t min = 1, max = 127;
  static constexpr const char* what = "a CANopen node is not a number from 1 to 127";
  static constexpr const char* remedy = "give the number that is set on the drive";
};
/// The number of a device on a CANopen bus, 1 to 127.
using NodeId = DeviceNumber<NodeIdRange>;

inline constexpr FrameId nmt_id = 0x000;
inline constexpr FrameId sync_id = 0x080;
constexpr FrameId emergency_id(NodeId node) {
  return FrameId::standard(0x080U + node.value());
}
/// From the drive, with its first set of process data.
constexpr FrameId tpdo1_id(NodeId node) {
  return FrameId::standard(0x180U + node.value());
}
/// To the drive, with one of its four sets of process data, 1 to 4 (pre-defined connection set, CiA 301).
constexpr FrameId rpdo_id(NodeId node, std::uint32_t number) {
  return FrameId::standard(0x100U + 0x100U * number + node.value());
}
constexpr FrameId rpdo1_id(NodeId node) {
  return rpdo_id(node, 1);
}
constexpr FrameId sdo_answer_id(NodeId node) {
  return FrameId::standard(0x580U + node.value());
}
constexpr FrameId sdo_request_id(NodeId node) {
  return FrameId::standard(0x600U + node.value());
}
constexpr FrameId heartbeat_id(NodeId node) {
  return FrameId::standard(0x700U + node.value());
}

/// Whether CiA 301 forbids a PDO to have this identifier.
constexpr bool is_restricted(std::uint32_t id) {
  const auto within = [id](std::uint32_t first, std::uint32_t last) { return id >= first && id <= last; };
  return within(0x000, 0x07F) || within(0x101, 0x180) || within(0x581, 0x5FF) || within(0x601, 0x67F) ||
         within(0x6E0, 0x6FF) || within(0x701, 0x7FF);
}

/// CANopen knows data frames with 11-bit identifiers only.
constexpr bool is_canopen(const Frame& frame) {
  return !frame.id.is_extended() && !frame.is_remote && frame.length <= 8;
}

}  // namespace inbetween::can
