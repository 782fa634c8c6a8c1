#include "inbetween/can/nmt.hpp"

namespace inbetween::can {
namespace {

constexpr std::uint8_t guard_toggle_bit = 0x80;

}  // namespace

Frame nmt_frame(const NmtOrder& order) {
  return {.id = nmt_id, .length = 2, .data = {static_cast<std::uint8_t>(order.command), order.node}};
}

std::optional<NmtOrder> read_nmt(const Frame& frame) {
  if (!is_canopen(frame) || frame.id != nmt_id || frame.length != 2 || frame.data[1] > 127) return {};
  switch (const auto command = static_cast<NmtCommand>(frame.data[0])) {
    case NmtCommand::start:
    case NmtCommand::stop:
    case NmtCommand::enter_pre_operational:
    case NmtCommand::reset_node:
    case NmtCommand::reset_communication:
      return NmtOrder{.command = command, .node = frame.data[1]};
  }
  return {};
}

Frame heartbeat_frame(NodeId node, NmtState state) {
  return {.id = heartbeat_id(node), .length = 1, .data = {static_cast<std::uint8_t>(state)}};
}

std::optional<NmtState> read_heartbeat(const Frame& frame, NodeId node) {
  if (!is_canopen(frame) || frame.id != heartbeat_id(node) || frame.length != 1) return {};
  switch (const auto state = static_cast<NmtState>(frame.data[0])) {
    case NmtState::boot_up:
    case NmtState::stopped:
    case NmtState::operational:
    case NmtState::pre_operational:
      return state;
  }
  return {};
}

Frame guard_request_frame(NodeId node) {
  return {.id = heartbeat_id(node), .is_remote = true, .length = 1};
}

Frame guard_answer_frame(NodeId node, const GuardAnswer& answer) {
  Frame frame = heartbeat_frame(node, answer.state);
  frame.data[0] |= answer.toggle ? guard_toggle_bit : std::uint8_t{0};
  return frame;
}

std::optional<GuardAnswer> read_guard_answer(const Frame& frame, NodeId node) {
  Frame plain = frame;
  plain.data[0] &= static_cast<std::uint8_t>(~guard_toggle_bit);
  const std::optional<NmtState> state = read_heartbeat(plain, node);
  if (!state) return {};
  return GuardAnswer{.state = *state, .toggle = (frame.data[0] & guard_toggle_bit) != 0};
}

}  // namespace inbetween::can
