#include "host_tools/motions/transport.hpp"

#include <algorithm>
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
  goes_home_ = false;
  if (is_at_start()) turns_gone_ = 0;
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
  PlayheadPlace from = place_of(playhead_);
  // A pulse at the place to which it was carried has begun a turn further on.
  if (was_carried_) from.time.fraction = std::nextafter(from.time.fraction, 2.0);
  const LoopTick result = loop_.tick(ticks, now_ns);
  note(result);
  const bool repeats = result.event == PlayheadEvent::repeated;
  if (repeats) ++turns_gone_;
  if (lines_.cues != nullptr) {
    lines_.cues->tick(
        {.from = from, .to = place_of(playhead_), .repeated = repeats ? playhead_.repeat() : Repeat::none},
        ticks, now_ns);
  }
  was_carried_ = false;
  if (goes_round() && !goes_home_) go_round();
}

/// While its rate changes it goes on, so that a change meets the stop bounds that it was planned with; where
/// one takes longer than that, it meets those of the same place of another turn.
void Transport::go_round() {
  const WholeFrames again = lines_.turns->again();
  const std::int32_t turn = again.last - again.first;
  const std::int32_t further = playhead_.rate_change() == 0 ? 0 : again.first / 2;
  while (playhead_.time().frame >= again.last + further) {
    playhead_.shift_by(-turn);
    ++turns_gone_;
    was_carried_ = playhead_.rate() > 0;
  }
  while (turns_gone_ > 0 && playhead_.time().frame < again.first - further) {
    playhead_.shift_by(turn);
    --turns_gone_;
  }
}

/// Counted from 0; its rolls belong to the first and the last.
std::int32_t Transport::turn_on_time_line() const {
  if (!lines_.turns) return 0;
  const std::int32_t frame = std::max(playhead_.time().frame, 0);
  return std::min(frame / lines_.turns->frames, lines_.turns->turns - 1);
}

std::int32_t Transport::frames_before_turn() const {
  return lines_.turns ? turn_on_time_line() * lines_.turns->frames : 0;
}

double Transport::frame_of_turn() const {
  return playhead_.time().frame - frames_before_turn() + playhead_.time().fraction;
}

std::optional<TurnSnapshot> Transport::turn() const {
  if (!lines_.turns && playhead_.repeat() == Repeat::none) return std::nullopt;
  const bool ends = lines_.turns && !goes_round();
  return TurnSnapshot{.turn = turns_gone_ + turn_on_time_line() + 1, .of = ends ? lines_.turns->turns : 0};
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
  goes_home_ = true;  // to the beginning of the turns that are on the time line
  turns_gone_ = 0;
  direction_ = Direction::forward;
  keys_.say(playhead_.go_to(move_.first_frame()));
}

void Transport::pause_or_play() {
  if (!keys_.is_running()) {
    keys_.say("nothing runs");
  } else if (playhead_.is_resting()) {
    goes_home_ = false;
    keys_.say(playhead_.play(direction_));
  } else {
    playhead_.stop();
  }
}

void Transport::turn() {
  direction_ = direction_ == Direction::forward ? Direction::backward : Direction::forward;
  if (!keys_.is_running() || playhead_.is_resting()) return;
  goes_home_ = false;
  keys_.say(playhead_.play(direction_));
}

void Transport::step(Direction direction) {
  if (!keys_.is_running()) {
    keys_.say("nothing runs");
    return;
  }
  goes_home_ = false;
  keys_.say(playhead_.step(direction));
}

/// To the next step above or below, and at the top to the top rate itself.
void Transport::change_override(int by) {
  constexpr double rounding = 1e-9;
  const double now = playhead_.override_rate();
  const bool is_fine = by > 0 ? now < override_step - rounding : now < override_step + rounding;
  const double step = is_fine ? fine_override_step : override_step;
  const double steps = by > 0 ? std::floor(now / step + rounding) : std::ceil(now / step - rounding);
  const double wanted = (steps + by) * step;
  const double top = playhead_.top_rate();
  if (wanted < fine_override_step / 2) {
    keys_.say("slower than this is a pause");
  } else if (by > 0 && now >= top) {
    keys_.say("this is the top rate; --top-rate lets it go up to what the limits hold");
  } else {
    keys_.say(playhead_.set_override(std::min(wanted, top)));
  }
}

/// At the rate that it has or goes to; nothing while it rests, or where no end ends it.
std::optional<double> Transport::seconds_left(double frame) const {
  const bool has_no_end = goes_round() && direction_ == Direction::forward;
  if (playhead_.state() != PlayheadState::playing || playhead_.repeat() != Repeat::none || has_no_end) {
    return std::nullopt;
  }
  const double way =
      direction_ == Direction::forward ? move_.last_frame() - frame : frame - move_.first_frame();
  return way / (move_.frame_rate().frames_per_second() * playhead_.override_rate());
}

RunSnapshot Transport::snapshot() const {
  const double frame = playhead_.time().frame + playhead_.time().fraction;
  // Of turns the frames are those of each, and the share is that of what is played once.
  const double first = goes_round() ? frames_before_turn() : move_.first_frame();
  const double frames = goes_round() ? lines_.turns->frames : move_.last_frame() - move_.first_frame();
  RunSnapshot now{.state = loop_.state(),
                  .is_resting = playhead_.is_resting(),
                  .frame = frame_of_turn(),
                  .frames = move_.frames(),
                  .part = move_.part(),
                  .turn = turn(),
                  .seconds_left = seconds_left(frame),
                  .rate = playhead_.rate(),
                  .override_rate = playhead_.override_rate(),
                  .backward = direction_ == Direction::backward,
                  .share = std::clamp((frame - first) / frames, 0.0, 1.0),
                  .words = keys_.words()};
  if (!lines_.turns) return now;
  now.frames = lines_.turns->frames;
  now.part.reset();
  return now;
}

}  // namespace inbetween
