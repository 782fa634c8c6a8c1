#include "host_tools/motions/transport.hpp"

#include <cmath>

namespace inbetween {
namespace {

constexpr double override_step = 0.1;
constexpr double min_override = 0.1;

}  // namespace

Status Transport::begin() {
  if (const Status loaded = loop_.load(spec_); !loaded) return loaded;
  if (!lines_.start) return start();
  is_waiting_ = true;
  is_heard_ = false;
  keys_.say("waits for the start trigger");
  return Done{};
}

Status Transport::start() {
  is_waiting_ = false;
  return loop_.start(direction_);
}

void Transport::tick(std::int32_t ticks, std::int64_t now_ns) {
  // A stop of the rig ends the waiting.
  if (loop_.state() != SupervisorState::ready) is_waiting_ = false;
  if (is_waiting_) {
    // A signal from before anybody waited is dropped, as a key would be: the rig does not start for it.
    if (lines_.start(now_ns) && is_heard_) keys_.say(start());
    is_heard_ = true;
  }
  const PlayheadPlace<double> from = place_of(playhead_);
  const LoopTick result = loop_.tick(ticks, now_ns);
  keys_.note(result);
  if (lines_.cues == nullptr) return;
  const bool repeats = result.event == PlayheadEvent::repeated;
  lines_.cues->tick(
      {.from = from, .to = place_of(playhead_), .repeated = repeats ? playhead_.repeat() : Repeat::none},
      ticks, now_ns);
}

void Transport::press(TransportKey key) {
  if (keys_.press(key)) return;
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
    case TransportKey::start:
      keys_.say(is_waiting_ ? start() : begin());
      if (keys_.is_running()) keys_.begun();
      return;
    default:
      return;
  }
}

void Transport::pause_or_play() {
  if (!keys_.is_running()) {
    keys_.say("nothing runs");
  } else if (playhead_.is_resting()) {
    keys_.say(playhead_.play(direction_));
  } else {
    playhead_.stop();
  }
}

void Transport::turn() {
  direction_ = direction_ == Direction::forward ? Direction::backward : Direction::forward;
  if (keys_.is_running() && !playhead_.is_resting()) keys_.say(playhead_.play(direction_));
}

void Transport::step(Direction direction) {
  if (!keys_.is_running()) {
    keys_.say("nothing runs");
    return;
  }
  keys_.say(playhead_.step(direction));
}

void Transport::change_override(double by) {
  const double wanted = std::round((playhead_.override_rate() + by) / override_step) * override_step;
  if (wanted < min_override / 2) {
    keys_.say("slower than this is a pause");
    return;
  }
  keys_.say(playhead_.set_override(wanted));
}

RunSnapshot Transport::snapshot() const {
  const double frame = playhead_.time().frame + playhead_.time().fraction;
  return {.state = loop_.state(),
          .is_resting = playhead_.is_resting(),
          .frame = frame,
          .rate = playhead_.rate(),
          .override_rate = playhead_.override_rate(),
          .backward = direction_ == Direction::backward,
          .share = (frame - move_.first_frame()) / (move_.last_frame() - move_.first_frame()),
          .words = keys_.words()};
}

}  // namespace inbetween
