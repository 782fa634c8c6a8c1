#include "host_tools/motions/transport.hpp"

#include <cmath>

namespace inbetween {
namespace {

/// Steps of the override rate: fine below the coarse one.
constexpr double override_step = 0.1;
constexpr double fine_override_step = 0.01;

}  // namespace

Status Transport::begin() {
  is_heard_ = false;
  if (keys_.is_running()) return Done{};  // on its way home while a take was noted
  if (const Status loaded = loop_.load(spec_); !loaded) return loaded;
  if (is_between_takes()) {
    if (take_ == Take::asked) begin_take();
    return Done{};
  }
  if (!lines_.start) return start();
  is_waiting_ = true;
  keys_.say("waits for the start trigger");
  return Done{};
}

Status Transport::start() {
  is_waiting_ = false;
  is_back_ = false;
  return loop_.start(direction_);
}

/// A rig that cannot begin, because it does not stand any more where it did, ends the take at once.
void Transport::begin_take() {
  take_ = Take::playing;
  was_whole_ = false;
  direction_ = Direction::forward;
  trace_->record_to(record_);
  keys_.begun();
  if (lines_.start) {
    is_waiting_ = true;
    keys_.say("waits for the start trigger");
  } else if (const Status started = start(); !started) {
    keys_.say(started);
    end_take(false);
  }
}

void Transport::end_take(bool is_whole) {
  if (take_ != Take::playing) return;
  was_whole_ = is_whole;
  is_waiting_ = false;
  take_ = Take::ended;
}

void Transport::take_is_ready(LoopTrace& trace, RunRecord* record) {
  trace_ = &trace;
  record_ = record;
  ask_ = Ask::none;
}

void Transport::take_is_noted() {
  take_ = Take::none;
  ask_ = Ask::none;
}

void Transport::tick(std::int32_t ticks, std::int64_t now_ns) {
  if (take_ == Take::ended) {  // its last tick is in its record
    trace_->record_to(nullptr);
    take_ = Take::closed;
  }
  // A stop of the rig ends the waiting.
  if (loop_.state() != SupervisorState::ready) is_waiting_ = false;
  // A signal from before anybody waited is dropped, as a key would be: the rig does not start for it.
  if (is_waiting_ && lines_.start(now_ns) && is_heard_) keys_.say(start());
  is_heard_ = true;
  const PlayheadPlace from = place_of(playhead_);
  const LoopTick result = loop_.tick(ticks, now_ns);
  note(result);
  if (lines_.cues == nullptr) return;
  const bool repeats = result.event == PlayheadEvent::repeated;
  lines_.cues->tick(
      {.from = from, .to = place_of(playhead_), .repeated = repeats ? playhead_.repeat() : Repeat::none},
      ticks, now_ns);
}

/// Played backward to its beginning by somebody, a move rests there and waits for them.
void Transport::note(const LoopTick& tick) {
  keys_.note(tick);
  if (tick.event == PlayheadEvent::finished) {
    is_back_ = is_at_start();
    end_take(!is_back_);
    if (is_back_) keys_.say("back at the beginning: Enter plays, q leaves");
  }
  if (!has_takes_) return;
  if (keys_.has_left() && trace_ != nullptr) trace_->record_to(nullptr);
  const bool is_home = keys_.is_running() && take_ != Take::playing && is_at_start();
  if (is_home) keys_.say(loop_.finish());
  const bool rests = loop_.state() != SupervisorState::running && loop_.state() != SupervisorState::stopping;
  if (take_ == Take::closed && rests) ask_ = Ask::end_take;
}

void Transport::press(TransportKey key) {
  if (keys_.press(key)) return;
  switch (key) {
    case TransportKey::home:
      return go_home();
    case TransportKey::faster:
      return change_override(1);
    case TransportKey::slower:
      return change_override(-1);
    case TransportKey::start:
      return press_start();
    default:
      break;
  }
  if (is_between_takes()) {
    playhead_.stop();
    keys_.say("no take is under way: Home goes to the start, Enter begins one there");
    return;
  }
  switch (key) {
    case TransportKey::pause:
      return pause_or_play();
    case TransportKey::reverse:
      return turn();
    case TransportKey::step_forward:
      return step(Direction::forward);
    case TransportKey::step_backward:
      return step(Direction::backward);
    default:
      return;
  }
}

void Transport::press_start() {
  if (!is_between_takes()) {
    // What was played backward to its beginning is played forward from there.
    if (is_back_) direction_ = Direction::forward;
    keys_.say(is_waiting_          ? start()
              : keys_.is_running() ? Status(Error{.what = "it runs already"})
                                   : begin());
    if (keys_.is_running()) keys_.begun();
  } else if (loop_.state() != SupervisorState::ready || take_ != Take::none) {
    keys_.say("not before it rests");
  } else if (!is_at_start()) {
    keys_.say("a take begins at the start of the move: Home goes there");
  } else if (is_heard_) {  // a key from before anybody could see that it waits begins nothing
    take_ = Take::asked;
    ask_ = Ask::begin_take;
  }
}

/// As a travel along the path, whether it plays, rests, or was stopped and acknowledged.
void Transport::go_home() {
  if (is_waiting_ || take_ == Take::asked) {
    keys_.say("it is where the move begins");
    return;
  }
  if (!keys_.is_running()) {
    Status begun = loop_.load(spec_);
    if (begun) begun = loop_.begin();
    if (!begun) return keys_.say(begun);
    keys_.begun();
  }
  end_take(false);
  is_back_ = false;
  direction_ = Direction::forward;
  keys_.say(playhead_.go_to(move_.first_frame()));
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

void Transport::change_override(int by) {
  const double now = playhead_.override_rate();
  const double border = override_step - by * fine_override_step / 2;
  const double step = now < border ? fine_override_step : override_step;
  const double wanted = std::round((now + by * step) / step) * step;
  if (wanted < fine_override_step / 2) {
    keys_.say("slower than this is a pause");
    return;
  }
  keys_.say(playhead_.set_override(wanted));
}

/// At the rate that it has or goes to; nothing while it rests, or where no end ends it.
std::optional<double> Transport::seconds_left(double frame) const {
  if (playhead_.state() != PlayheadState::playing || playhead_.repeat() != Repeat::none) return std::nullopt;
  const double way =
      direction_ == Direction::forward ? move_.last_frame() - frame : frame - move_.first_frame();
  return way / (move_.frame_rate().frames_per_second() * playhead_.override_rate());
}

RunSnapshot Transport::snapshot() const {
  const double frame = playhead_.time().frame + playhead_.time().fraction;
  return {.state = loop_.state(),
          .is_resting = playhead_.is_resting(),
          .frame = frame,
          .frames = move_.frames(),
          .part = move_.part(),
          .seconds_left = seconds_left(frame),
          .rate = playhead_.rate(),
          .override_rate = playhead_.override_rate(),
          .backward = direction_ == Direction::backward,
          .share = (frame - move_.first_frame()) / (move_.last_frame() - move_.first_frame()),
          .words = keys_.words()};
}

}  // namespace inbetween
