#include "host_tools/loop/operator_keys.hpp"

namespace inbetween {
namespace {

/// Nothing moves any more, and nobody has acknowledged why.
bool is_stopped(SupervisorState state) {
  return state == SupervisorState::latched || state == SupervisorState::faulted ||
         state == SupervisorState::cut_off;
}

}  // namespace

bool OperatorKeys::press(TransportKey key) {
  words_ = "";
  switch (key) {
    case TransportKey::stop:
      was_stopped_ = was_stopped_ || is_running();
      loop_.post(SupervisorEvent::stop);
      return true;
    case TransportKey::acknowledge:
      if (!loop_.post(SupervisorEvent::acknowledge)) words_ = "there is nothing to acknowledge";
      return true;
    case TransportKey::quit:
      if (!wants_to_leave_) loop_.post(SupervisorEvent::stop);
      wants_to_leave_ = true;
      return true;
    case TransportKey::refused:
      words_ = "the rig file was changed; leave with q, and run again";
      return true;
    default:
      return false;
  }
}

void OperatorKeys::note(const LoopTick& tick) {
  has_lost_time_ = has_lost_time_ || tick.lost_time;
  was_stopped_ = was_stopped_ || tick.state == SupervisorState::stopping || is_stopped(tick.state);
}

bool OperatorKeys::has_left() const {
  const SupervisorState state = loop_.state();
  if (state == SupervisorState::running || state == SupervisorState::stopping) return false;
  return wants_to_leave_ || (is_stopped(state) && !is_attended_);
}

}  // namespace inbetween
