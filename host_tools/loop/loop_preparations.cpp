#include "host_tools/loop/loop_preparations.hpp"

#include <algorithm>

namespace inbetween {

Arming::Arming(RunLoop& loop) : Preparation(loop), positions_(loop.drive_states().size()) {}

Status Arming::begin() {
  if (loop_.post(SupervisorEvent::arm)) return Done{};
  return Error{.code = ErrorCode::wrong_state, .what = "the rig is in use", .remedy = "disarm it first"};
}

void Arming::press(TransportKey key) {
  if (key == TransportKey::stop || key == TransportKey::quit) loop_.post(SupervisorEvent::stop);
}

void Arming::tick(std::int32_t ticks, std::int64_t now_ns) {
  loop_.tick(ticks, now_ns);
  for (std::size_t i = 0; i < positions_.size(); ++i) positions_[i] = loop_.drive_states()[i].actual;
}

Arriving::Arriving(RunLoop& loop, std::int32_t rate_hz)
    : Preparation(loop), ticks_left_(std::max(rate_hz, 16)), positions_(loop.drive_states().size()) {}

void Arriving::tick(std::int32_t ticks, std::int64_t now_ns) {
  loop_.tick(ticks, now_ns);
  --ticks_left_;
  bool moved = false;
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    const double now = loop_.drive_states()[i].actual;
    const DriveState& drive = loop_.drive_states()[i];
    const bool arrives = !drive.is_in_position && drive.own_stop == OwnStop::none;
    moved = moved || arrives || now != positions_[i];
    positions_[i] = now;
  }
  still_ticks_ = moved ? 0 : still_ticks_ + 1;
}

Status Disarming::begin() {
  loop_.post(SupervisorEvent::disarm);
  return Done{};
}

void Disarming::tick(std::int32_t ticks, std::int64_t now_ns) {
  loop_.tick(ticks, now_ns);
  const SupervisorState state = loop_.state();
  // The first request stops what moves; another one switches it off.
  if (state != SupervisorState::stopping && state != SupervisorState::disarmed) {
    loop_.post(SupervisorEvent::disarm);
  }
  is_over_ = state == SupervisorState::disarmed &&
             std::ranges::none_of(loop_.drive_states(), &DriveState::is_leaving);
}

}  // namespace inbetween
