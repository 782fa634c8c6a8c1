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
  use_rate(asked_rate_);
  return is_at_start() && !lines_.followed.empty() ? follow() : loop_.start(direction_);
}

Status Transport::follow() {
  if (const Status begun = loop_.begin(); !begun) return begun;
  return playhead_.follow(lines_.followed);
}

/// What is followed may rest anywhere, and is over there.
void Transport::end_following() {
  static_cast<void>(loop_.finish());
  end_take(true);
}

/// A rig that cannot begin, because it does not stand any more where it did, ends the take at once.
void Transport::begin_take() {
  take_ = Take::playing;
  was_whole_ = false;
  direction_ = Direction::forward;
  trace_->record_to(sinks_);
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

void Transport::take_is_ready(LoopTrace& trace, const TickSinks& sinks) {
  trace_ = &trace;
  sinks_ = sinks;
  ask_ = Ask::none;
}

void Transport::take_is_noted() {
  take_ = Take::none;
  ask_ = Ask::none;
}

void Transport::tick(std::int32_t ticks, std::int64_t now_ns) {
  now_ns_ = now_ns;
  look_at_arrow();
  if (take_ == Take::ended) {  // its last tick is in its record
    trace_->record_to({});
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
  const bool follows = playhead_.state() == PlayheadState::following;
  const bool moves = loop_.state() == SupervisorState::running || loop_.state() == SupervisorState::stopping;
  const LoopTick result = loop_.tick(ticks, now_ns);
  const bool repeats = result.event == PlayheadEvent::repeated;
  if (repeats) ++turns_gone_;
  played_.reset();
  if (moves && loop_.sends_setpoints()) played_ = {place_of(playhead_), turns_gone_};
  note(result);
  if (follows && playhead_.is_resting()) end_following();
  if (result.event == PlayheadEvent::arrived) keys_.say("");
  if (lines_.cues != nullptr) {
    lines_.cues->tick(
        {.from = from, .to = place_of(playhead_), .repeated = repeats ? playhead_.repeat() : Repeat::none},
        ticks, now_ns);
  }
  was_carried_ = false;
  set_off();
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
  if (keys_.has_left() && trace_ != nullptr) trace_->record_to({});
  // Between takes it rests wherever somebody has gone.
  const bool has_gone = keys_.is_running() && take_ != Take::playing && playhead_.is_resting();
  if (has_gone && !sets_off_) static_cast<void>(loop_.finish());
  const bool rests = loop_.state() != SupervisorState::running && loop_.state() != SupervisorState::stopping;
  if (take_ == Take::closed && rests) ask_ = Ask::end_take;
}

void Transport::press(TransportKey key) {
  const bool is_of_entry = entry_.press(key);
  if (is_of_entry) keys_.say("");
  if (const auto place = entry_.take()) go_to(*place);
  if (is_of_entry || press_arrow(key)) return;
  arrow_.forget();
  if (keys_.press(key) || press_always(key)) return;
  if (is_between_takes()) {
    go_nowhere();
    playhead_.stop();
    keys_.say("no take is under way: Home goes to the start, Enter begins one there");
    return;
  }
  if (key == TransportKey::pause) pause_or_play();
  if (key == TransportKey::reverse) turn();
}

/// What means the same in a take and between two.
bool Transport::press_always(TransportKey key) {
  switch (key) {
    case TransportKey::home:
      go_home();
      return true;
    case TransportKey::faster:
      change_override(1);
      return true;
    case TransportKey::slower:
      change_override(-1);
      return true;
    case TransportKey::start:
      press_start();
      return true;
    case TransportKey::pause:
    case TransportKey::reverse:
      return false;
    default:
      return true;
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

/// Whether the rig follows the playhead, as from here on where it rested.
bool Transport::is_on_path() {
  if (keys_.is_running()) return true;
  Status begun = loop_.load(spec_);
  if (begun) begun = loop_.begin();
  keys_.say(begun);
  if (begun) keys_.begun();
  return static_cast<bool>(begun);
}

/// A key from before anybody could see that it waits moves nothing.
bool Transport::can_go() {
  if (is_waiting_ || take_ == Take::asked) keys_.say("it waits to be started");
  return !is_waiting_ && take_ != Take::asked && is_heard_;
}

/// Of turns that in which it is.
void Transport::go_to(const WantedPlace& place) {
  const std::int32_t frames = lines_.turns ? lines_.turns->frames : move_.frames();
  const WholeFrames part = lines_.turns ? WholeFrames{0, frames} : move_.part();
  const auto number = static_cast<std::size_t>(place.number);
  if (place.is_key && number >= lines_.key_frames.size())
    return keys_.say("the move has no such key; the first is 0");
  const double frame = place.is_key ? lines_.key_frames[number] : place.number;
  if (frame < part.first || frame > part.last) return keys_.say("that is not on the frames that are played");
  if (!can_go() || !is_on_path()) return;
  arrow_.forget();
  go_nowhere();
  end_take(false);
  is_back_ = false;
  goes_home_ = false;
  goal_ = moved_by({0, 0}, frame);
  sets_off_ = true;
  playhead_.stop();
  keys_.say("goes there slowly, along the path: space rests, Esc stops");
}

/// For what was asked for, as soon as it rests; nothing where a stop came between.
void Transport::set_off() {
  if (!sets_off_) return;
  if (!keys_.is_running()) return go_nowhere();
  if (!playhead_.is_resting()) return;
  sets_off_ = false;
  use_rate(std::min(asked_rate_, slow_rate_));
  FrameTime to = goal_.value_or(FrameTime{move_.first_frame(), 0});
  if (goal_) to.frame += frames_before_turn();
  if (scrubs_ == Direction::forward) to = {move_.last_frame(), 0};
  goal_.reset();
  if (to != playhead_.time()) keys_.say(playhead_.go_to(to));
}

void Transport::go_nowhere() {
  goal_.reset();
  scrubs_.reset();
  sets_off_ = false;
}

/// Arrows of a terminal, those of a device that are held, and a wheel. Whether the key was one of them.
bool Transport::press_arrow(TransportKey key) {
  const int direction = direction_of(key);
  switch (key) {
    case TransportKey::tells_releases:
      arrow_.tells_releases();
      return true;
    case TransportKey::step_forward:
    case TransportKey::step_backward:
      arrow_.press(direction, now_ns_);
      if (arrow_.is_refused()) {
        keys_.say(refused_keys_in_words);
      } else if (arrow_.held(now_ns_) == 0) {
        step(static_cast<Direction>(direction));
      }
      return true;
    case TransportKey::repeat_forward:
    case TransportKey::repeat_backward:
      arrow_.repeat(direction, now_ns_);
      return true;
    case TransportKey::hold_forward:
    case TransportKey::hold_backward:
      arrow_.hold(direction, now_ns_);
      return true;
    case TransportKey::still_held:
      arrow_.hear(now_ns_);
      return true;
    case TransportKey::let_go:
      arrow_.release();
      return true;
    case TransportKey::device_gone:
      arrow_.release();
      keys_.say("the device is gone");
      return true;
    case TransportKey::detent_forward:
    case TransportKey::detent_backward:
      if (!scrubs_) step(static_cast<Direction>(direction));
      return true;
    default:
      return false;
  }
}

/// A move that plays is paused first.
bool Transport::can_step() {
  if (!can_go()) return false;
  const bool plays_now = plays();
  const bool is_there = !plays_now && (keys_.is_running() || is_between_takes());
  if (!is_there) keys_.say(plays_now ? "space pauses it first" : "nothing runs");
  if (!is_there || !is_on_path()) return false;
  goes_home_ = false;
  return true;
}

void Transport::step(Direction direction) {
  if (!can_step()) return;
  go_nowhere();
  use_rate(std::min(asked_rate_, slow_rate_));
  keys_.say(playhead_.step(direction));
}

/// It scrubs as soon as an arrow is known to be held, and comes to rest when it is not any more.
void Transport::look_at_arrow() {
  const int held = arrow_.held(now_ns_);
  const int scrubbed = !scrubs_ ? 0 : *scrubs_ == Direction::forward ? 1 : -1;
  if (held == scrubbed) return;
  if (scrubbed != 0) {
    go_nowhere();
    if (keys_.is_running()) playhead_.stop();
  } else {
    scrub(held > 0 ? Direction::forward : Direction::backward);
  }
}

/// As far as the time line goes.
void Transport::scrub(Direction direction) {
  if (!can_step()) return arrow_.forget();
  goal_.reset();
  scrubs_ = direction;
  const FrameTime end{direction == Direction::forward ? move_.last_frame() : move_.first_frame(), 0};
  if (playhead_.time() == end) return keys_.say("the move is at that end");
  sets_off_ = true;
  playhead_.stop();
}

/// As a travel along the path, whether it plays, rests, or was stopped and acknowledged.
void Transport::go_home() {
  if (is_waiting_ || take_ == Take::asked) {
    keys_.say("it is where the move begins");
    return;
  }
  if (!is_on_path()) return;
  go_nowhere();
  use_rate(asked_rate_);
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
    go_nowhere();
    use_rate(asked_rate_);
    keys_.say(playhead_.play(direction_));
  } else {
    go_nowhere();
    playhead_.stop();
  }
}

void Transport::turn() {
  direction_ = direction_ == Direction::forward ? Direction::backward : Direction::forward;
  if (!keys_.is_running() || playhead_.is_resting()) return;
  goes_home_ = false;
  go_nowhere();
  use_rate(asked_rate_);
  keys_.say(playhead_.play(direction_));
}

/// To the next step above or below, and at the top to the top rate itself.
void Transport::change_override(int by) {
  constexpr double rounding = 1e-9;
  const double now = asked_rate_;
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
    asked_rate_ = std::min(wanted, top);
    if (playhead_.state() == PlayheadState::playing) use_rate(asked_rate_);
  }
}

/// At the rate that it has or goes to; nothing while it rests, or where no end ends it.
std::optional<double> Transport::seconds_left(double frame) const {
  const bool has_no_end = goes_round() && direction_ == Direction::forward;
  if (playhead_.state() != PlayheadState::playing || playhead_.repeat() != Repeat::none || has_no_end) {
    return std::nullopt;
  }
  const double distance =
      direction_ == Direction::forward ? move_.last_frame() - frame : frame - move_.first_frame();
  return distance / (move_.frame_rate().frames_per_second() * asked_rate_);
}

const char* Transport::doing() const {
  if (playhead_.state() != PlayheadState::travelling) return "";
  return goes_home_ ? "going to the start" : "going along the path";
}

/// None that does nothing now.
const char* Transport::keys_that_work() const {
  if (keys_.is_running()) {
    if (playhead_.state() == PlayheadState::travelling) return "space rests here, Esc stops, q leaves";
    return playhead_.is_resting()
               ? "space plays, arrows step, r turns, Home, g frame, k key, Esc stops, q leaves"
               : "space pauses, r turns, + - rate, Home, g frame, k key, Esc stops, q leaves";
  }
  if (loop_.state() != SupervisorState::ready) return "";
  if (is_waiting_) return "Enter starts without the trigger, + - rate, Esc stops, q leaves";
  if (!has_takes_) return "Enter starts from here, + - rate, Home, g frame, k key, q leaves";
  return is_at_start() ? "Enter begins a take, + - rate, arrows step, g frame, k key, q leaves"
                       : "Home goes to the start, arrows step, g frame, k key, + - rate, q leaves";
}

RunSnapshot Transport::snapshot() const {
  const double frame = playhead_.time().frame + playhead_.time().fraction;
  // Of turns the frames are those of each, and the share is that of what is played once.
  const double first = goes_round() ? frames_before_turn() : move_.first_frame();
  const double frames = goes_round() ? lines_.turns->frames : move_.last_frame() - move_.first_frame();
  RunSnapshot now{.state = loop_.state(),
                  .doing = doing(),
                  .is_resting = playhead_.is_resting(),
                  .frame = frame_of_turn(),
                  .frames = move_.frames(),
                  .part = move_.part(),
                  .turn = turn(),
                  .seconds_left = seconds_left(frame),
                  .rate = playhead_.rate(),
                  .override_rate = asked_rate_,
                  .backward = direction_ == Direction::backward,
                  .share = std::clamp((frame - first) / frames, 0.0, 1.0),
                  .words = keys_.words(),
                  .keys = keys_that_work(),
                  .entry = entry_.shown()};
  if (!lines_.turns) return now;
  now.frames = lines_.turns->frames;
  now.part.reset();
  return now;
}

}  // namespace inbetween
