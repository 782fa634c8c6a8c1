#include "host_tools/loop/operator_keys.hpp"

namespace inbetween {

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
  switch (tick.state) {
    case SupervisorState::stopping:
    case SupervisorState::latched:
    case SupervisorState::faulted:
    case SupervisorState::cut_off:
      was_stopped_ = true;
      return;
    default:
      return;
  }
}

bool OperatorKeys::has_left() const {
  switch (loop_.state()) {
    case SupervisorState::running:
    case SupervisorState::stopping:
      return false;
    case SupervisorState::latched:
    case SupervisorState::faulted:
    case SupervisorState::cut_off:
      return wants_to_leave_ || !is_attended_;
    default:
      return wants_to_leave_;
  }
}

}  // namespace inbetween
