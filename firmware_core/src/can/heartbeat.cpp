#include "inbetween/can/heartbeat.hpp"

#include <array>

namespace inbetween::can {
namespace {

using enum HeartbeatState;

constexpr std::array<std::array<HeartbeatState, heartbeat_events>, heartbeat_states> table{{
    // start, boot_up, heartbeat, deadline
    {waiting, off, off, off},                       // off
    {waiting, waiting, alive, never_came},          // waiting
    {waiting, rebooted, alive, lost},               // alive
    {waiting, rebooted, alive, lost},               // lost
    {waiting, never_came, never_came, never_came},  // never_came
    {waiting, rebooted, rebooted, rebooted},        // rebooted
}};

}  // namespace

Result<HeartbeatProducer> HeartbeatProducer::make(NodeId node, std::int64_t period_ns) {
  if (period_ns <= 0) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "the period of a heartbeat is not positive",
                 .remedy = "give a third of the time after which it shall be missed"};
  }
  return HeartbeatProducer(node, period_ns);
}

std::optional<Frame> HeartbeatProducer::poll(std::int64_t now_ns, NmtState state) {
  if (is_started_ && now_ns < deadline_ns_) return {};
  const bool is_far_behind = !is_started_ || now_ns - deadline_ns_ >= period_ns_;
  deadline_ns_ = (is_far_behind ? now_ns : deadline_ns_) + period_ns_;
  is_started_ = true;
  return heartbeat_frame(node_, state);
}

HeartbeatState next_state(HeartbeatState state, HeartbeatEvent event) {
  return table[static_cast<std::size_t>(state)][static_cast<std::size_t>(event)];
}

void HeartbeatConsumer::apply(HeartbeatEvent event, std::int64_t now_ns) {
  state_ = next_state(state_, event);
  if (state_ == waiting && event == HeartbeatEvent::start) deadline_ns_ = now_ns + times_.boot_timeout_ns;
  if (state_ == alive) deadline_ns_ = now_ns + times_.timeout_ns;
}

void HeartbeatConsumer::start(std::int64_t now_ns) {
  apply(HeartbeatEvent::start, now_ns);
}

void HeartbeatConsumer::receive(NmtState heard, std::int64_t now_ns) {
  poll(now_ns);
  apply(heard == NmtState::boot_up ? HeartbeatEvent::boot_up : HeartbeatEvent::heartbeat, now_ns);
}

HeartbeatState HeartbeatConsumer::poll(std::int64_t now_ns) {
  const bool has_deadline = state_ == waiting || state_ == alive;
  if (has_deadline && now_ns >= deadline_ns_) apply(HeartbeatEvent::deadline, now_ns);
  return state_;
}

}  // namespace inbetween::can
