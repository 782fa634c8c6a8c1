#include "host_tools/transport.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace inbetween {
namespace {

constexpr double override_step = 0.1;
constexpr double least_override = 0.1;

std::string_view hint_of(SupervisorState state, bool rests) {
  switch (state) {
    case SupervisorState::running:
      return rests ? "space plays, arrows step, r turns, q leaves"
                   : "space pauses, r turns, + - rate, Esc stops";
    case SupervisorState::stopping:
      return "slowing down on the path";
    case SupervisorState::latched:
    case SupervisorState::cut_off:
      return "stopped; a acknowledges, q leaves";
    case SupervisorState::ready:
      return "Enter starts from here, q leaves";
    default:
      return "";
  }
}

}  // namespace

void Transport::press(TransportKey key) {
  words_.clear();
  switch (key) {
    case TransportKey::pause:
      return pause_or_play();
    case TransportKey::reverse:
      return turn();
    case TransportKey::step_forward:
      return step(Direction::forward);
    case TransportKey::step_backward:
      return step(Direction::backward);
    case TransportKey::faster:
      return change_override(override_step);
    case TransportKey::slower:
      return change_override(-override_step);
    case TransportKey::stop:
      was_stopped_ = was_stopped_ || is_running();
      loop_.post(SupervisorEvent::stop);
      return;
    case TransportKey::acknowledge:
      if (!loop_.post(SupervisorEvent::acknowledge)) words_ = "there is nothing to acknowledge";
      return;
    case TransportKey::start:
      say(loop_.start(direction_));
      if (is_running()) was_stopped_ = false;
      return;
    case TransportKey::quit:
      break;
  }
  if (wants_to_leave_) return;
  wants_to_leave_ = true;
  loop_.post(SupervisorEvent::stop);
}

void Transport::pause_or_play() {
  if (!is_running()) {
    words_ = "nothing runs";
  } else if (playhead_.is_resting()) {
    say(playhead_.play(direction_));
  } else {
    playhead_.stop();
  }
}

void Transport::turn() {
  direction_ = direction_ == Direction::forward ? Direction::backward : Direction::forward;
  if (is_running() && !playhead_.is_resting()) say(playhead_.play(direction_));
}

void Transport::step(Direction direction) {
  if (!is_running()) {
    words_ = "nothing runs";
    return;
  }
  say(playhead_.step(direction));
}

void Transport::change_override(double by) {
  const double wanted = std::round((playhead_.override_rate() + by) / override_step) * override_step;
  if (wanted < least_override / 2) {
    words_ = "slower than this is a pause";
    return;
  }
  say(playhead_.set_override(wanted));
}

void Transport::say(const Status& status) {
  if (!status) words_ = status.error().what;
}

std::string Transport::status() const {
  const double frame = playhead_.time().frame + playhead_.time().fraction;
  const bool paused = is_running() && playhead_.is_resting();
  return fmt::format("{}  frame {:.1f}  rate {:+.2f} of {:.1f}{} | {}",
                     paused ? "paused" : name_of(loop_.state()), frame, playhead_.rate(),
                     playhead_.override_rate(), direction_ == Direction::backward ? ", backward" : "",
                     words_.empty() ? std::string(hint_of(loop_.state(), playhead_.is_resting())) : words_);
}

double Transport::share(const Move<double>& move) const {
  const double frame = playhead_.time().frame + playhead_.time().fraction;
  return (frame - move.first_frame()) / (move.last_frame() - move.first_frame());
}

}  // namespace inbetween
