#pragma once

#include <cstdint>
#include <optional>

#include "inbetween/can/canopen_id.hpp"
#include "inbetween/can/frame.hpp"

/// Network management, CiA 301 section 7.2.8.3.1: which services a device offers, told by the host, and what
/// the device says about itself.

namespace inbetween::can {

enum class NmtCommand : std::uint8_t {
  start = 0x01,  ///< to Operational: process data flow
  stop = 0x02,   ///< to Stopped: nothing but NMT and heartbeats
  enter_pre_operational = 0x80,
  reset_node = 0x81,
  reset_communication = 0x82,
};

/// The state in a heartbeat. A device sends boot_up once, after power-on and after a reset.
enum class NmtState : std::uint8_t {
  boot_up = 0x00,
  stopped = 0x04,
  operational = 0x05,
  pre_operational = 0x7F,
};

/// A command and whom it is for; node 0 is all of them. Nobody answers it: heartbeats show what it did.
struct NmtOrder {
  NmtCommand command = NmtCommand::start;
  std::uint8_t node = 0;
  friend bool operator==(const NmtOrder&, const NmtOrder&) = default;
};

Frame nmt_frame(const NmtOrder& order);
/// Nothing where the frame is none, is too short or long, or has an unknown command.
std::optional<NmtOrder> read_nmt(const Frame& frame);

Frame heartbeat_frame(NodeId node, NmtState state);
/// Nothing where the frame is not a heartbeat of `node` with one byte and a known state.
std::optional<NmtState> read_heartbeat(const Frame& frame, NodeId node);

/// A drive answers with this when the host asks whether it lives (CiA 301 section 7.2.8.3.2.1). A drive that
/// is asked so does not send heartbeats; its boot-up message is the same. It stops by itself where the
/// questions cease for the guard time (100C) times the life time factor (100D).
struct GuardAnswer {
  NmtState state = NmtState::boot_up;
  bool toggle = false;  ///< false in the first answer after boot-up, and another one each time
};
/// The question: a remote frame.
Frame guard_request_frame(NodeId node);
Frame guard_answer_frame(NodeId node, const GuardAnswer& answer);
/// Returns nothing where the frame is no answer of `node` with one byte and a known state. A boot-up is one.
std::optional<GuardAnswer> read_guard_answer(const Frame& frame, NodeId node);

}  // namespace inbetween::can
