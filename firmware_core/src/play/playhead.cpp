#include "inbetween/play/playhead.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace inbetween {
namespace {

/// Rounding may make the last jerk phase steeper than it began by this share.
inline constexpr double jerk_rounding = 1e-9;
/// The seconds of an exposure are a whole number of ticks within this share of a tick.
inline constexpr double tick_rounding = 1e-9;
/// The bounds of an exposure may prove to be lower this often, because its run-up reaches further. Two or
/// three times are usual: each time it reaches further by less.
inline constexpr int max_narrowings = 64;

constexpr Direction opposite(Direction direction) {
  return direction == Direction::forward ? Direction::backward : Direction::forward;
}
constexpr double sign_of(Direction direction) {
  return static_cast<double>(static_cast<int>(direction));
}

Error not_on_time_line() {
  return {.code = ErrorCode::out_of_range,
          .what = "there is no such frame on the time line",
          .remedy = "name one from the first frame of the move to its last"};
}

}  // namespace

Playhead::Playhead(const Move& move, const StopBounds& bounds, std::int32_t rate_hz,
                   std::span<const StopBounds> rungs)
    : move_(&move),
      bounds_(&bounds),
      rungs_(rungs),
      unit_(static_cast<std::int64_t>(rate_hz) * move.frame_rate().denominator),
      tick_s_(1.0 / static_cast<double>(rate_hz)),
      fps_(static_cast<double>(move.frame_rate().numerator) /
           static_cast<double>(move.frame_rate().denominator)),
      time_{move.first_frame(), 0},
      override_(std::min(1.0, bounds.rate())) {}

// --- commands

Status Playhead::play(Direction direction) {
  // An exposure may reach beyond an end. Nothing moves there, so that the move is played from the end itself,
  // as if it rested there. From beyond, a repeat would take the whole distance beyond for what one tick
  // passed.
  const FrameTime here = std::clamp(time_, end_towards(Direction::backward), end_towards(Direction::forward));
  const bool rests = is_resting() || here != time_;
  if (rests && here == end_towards(direction)) {
    if (repeat_ == Repeat::none) {
      return Error{.code = ErrorCode::wrong_state,
                   .what = "the move is at that end already",
                   .remedy = "play it the other way, or go to a frame first"};
    }
    if (repeat_ == Repeat::ping_pong) direction = opposite(direction);
  }
  // The rate means nothing at the end from which the move starts, because nothing moves there.
  if (rests && (here == end_towards(Direction::backward) || here == end_towards(Direction::forward))) {
    time_ = end_towards(opposite(direction));
    rate_ = sign_of(direction) * override_;
    change_ = 0;
    anchor_here();
  }
  direction_ = direction;
  state_ = PlayheadState::playing;
  has_next_ = false;
  return Done{};
}

void Playhead::stop() {
  has_next_ = false;
  if (!is_resting() && !travel_ends_like_a_stop()) state_ = PlayheadState::slowing;
}

void Playhead::halt() {
  has_next_ = false;
  rest();
}

Status Playhead::go_to(const FrameTime& place) {
  if (!is_on_time_line(place)) return not_on_time_line();
  if (is_resting()) {
    begin_travel(place);
  } else {
    stop();
    next_ = place;
    has_next_ = true;
  }
  return Done{};
}

Status Playhead::step(Direction direction) {
  FrameTime from = time_;
  if (has_next_) {
    from = next_;
  } else if (state_ == PlayheadState::travelling) {
    from = travel_.to;
  } else if (!is_resting()) {
    return Error{.code = ErrorCode::wrong_state,
                 .what = "a step needs a move that rests",
                 .remedy = "stop it first, or go to a frame"};
  }
  const bool is_between = from.fraction > 0;
  return go_to(direction == Direction::forward ? from.frame + 1 : from.frame - (is_between ? 0 : 1));
}

Status Playhead::follow(std::span<const PlayheadPlace> places) {
  if (!is_resting()) {
    return Error{.code = ErrorCode::wrong_state, .what = "the move is running", .remedy = "stop it first"};
  }
  if (places.empty()) {
    return Error{.code = ErrorCode::wrong_count,
                 .what = "there is no place to follow",
                 .remedy = "give the places of a playhead that has moved"};
  }
  followed_ = places;
  state_ = PlayheadState::following;
  return Done{};
}

Status Playhead::can_follow(std::span<const PlayheadPlace> places) const {
  Playhead tried = *this;
  if (const Status possible = tried.follow(places); !possible) return possible;
  PlayheadPlace last{time_, 0, 0};
  for (std::size_t i = 0; i < places.size(); ++i) {
    const bool rests = places[i].rate == 0 && places[i].rate_change == 0;
    if (!leads_to(last, places[i]) || (i + 1 == places.size() && !rests)) {
      return Error{.code = ErrorCode::out_of_range,
                   .what = "the places that are followed are not those of a playhead of this move",
                   .remedy = "follow one of the same move, rig and tick",
                   .frame = places[i].time.frame,
                   .needed = static_cast<std::int64_t>(i)};
    }
    last = places[i];
  }
  return Done{};
}

/// What every way of moving on keeps: within V, no jump of time, and no jump of the rate or its change but at
/// an end of the time line, where nothing moves at any rate. A tick may end one jerk and begin another.
bool Playhead::leads_to(const PlayheadPlace& last, const PlayheadPlace& next) const {
  constexpr double more = 1 + 1e-6;
  const double side = next.rate != 0 ? std::copysign(1.0, next.rate) : 1.0;
  if (!is_on_time_line(next.time) || !bounds_->permits(next.time, side * next.rate, side * next.rate_change))
    return false;
  // As far as the tick might have reached: see follow_to.
  const double here = bounds_->rate_jerk(last.time);
  const double reach =
      std::fabs(last.rate) + std::fabs(last.rate_change) * tick_s_ / 2 + here * tick_s_ * tick_s_ / 6;
  const FrameTime ahead =
      moved_by(last.time, std::copysign(reach * tick_s_ * fps_, last.rate != 0 ? last.rate : side));
  const double jerk = std::max({here, bounds_->rate_jerk(ahead), bounds_->rate_jerk(next.time)});
  const double turn = jerk * tick_s_ * more;  // of the rate change
  const double sway =
      (std::max(std::fabs(last.rate_change), std::fabs(next.rate_change)) + turn) * tick_s_ * more;
  const double step = seconds_between(last.time, next.time) / tick_s_;
  const double rounding = 1e-9 * bounds_->rate();
  if (!(step >= std::min(last.rate, next.rate) - sway - rounding &&
        step <= std::max(last.rate, next.rate) + sway + rounding))
    return false;
  if (is_end(last.time) || is_end(next.time)) return true;
  return std::fabs(next.rate - last.rate) <= sway + rounding &&
         std::fabs(next.rate_change - last.rate_change) <= turn + rounding / tick_s_;
}

bool Playhead::is_end(const FrameTime& time) const {
  return time == end_towards(Direction::backward) || time == end_towards(Direction::forward);
}

Status Playhead::set_override(double rate) {
  if (!(rate > 0 && rate <= bounds_->rate())) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "the override is not above 0, or beyond the rate for which stops are proven",
                 .remedy = "use a lower rate"};
  }
  override_ = rate;
  return Done{};
}

Status Playhead::place_on(std::int32_t frame) {
  if (!is_on_time_line({frame, 0})) return not_on_time_line();
  if (!is_resting()) {
    return Error{.code = ErrorCode::wrong_state, .what = "the move is running", .remedy = "stop it first"};
  }
  time_ = {frame, 0};
  return Done{};
}

/// The whole frames of a cruise go into its anchor, and the part of a frame that it has come goes on.
void Playhead::shift_by(std::int32_t frames) {
  anchor_.frame += (rate_ < 0 ? -cruise_frames_ : cruise_frames_) + frames;
  cruise_frames_ = 0;
  time_.frame += frames;
  if (has_next_) next_.frame += frames;
  if (state_ != PlayheadState::travelling) return;
  travel_.from.frame += frames;
  travel_.to.frame += frames;
}

// --- a tick

PlayheadEvent Playhead::tick() {
  switch (state_) {
    case PlayheadState::resting:
      return PlayheadEvent::none;
    case PlayheadState::playing:
      return tick_ramp(sign_of(direction_) * override_);
    case PlayheadState::slowing:
      return tick_ramp(0);
    case PlayheadState::following:
      return tick_following();
    case PlayheadState::travelling:
      break;
  }
  return tick_travel();
}

PlayheadEvent Playhead::tick_ramp(double target) {
  if (rate_ * target < 0) target = 0;  // a turn is a stop and a start
  if (rate_ == target && change_ == 0) {
    cruise();
  } else {
    change_to(target);
    anchor_here();
  }
  for (const Direction direction : {Direction::forward, Direction::backward}) {
    if (!(rate_ * sign_of(direction) > 0)) continue;
    const FrameTime end = end_towards(direction);
    const bool is_inside = direction == Direction::forward ? time_ < end : end < time_;
    if (!is_inside) return pass_end(direction);
  }
  if (state_ == PlayheadState::slowing && rate_ == 0 && change_ == 0) return settle();
  return PlayheadEvent::none;
}

/// Comes to rest after a slowing down.
PlayheadEvent Playhead::settle() {
  rest();
  if (!has_next_) return PlayheadEvent::stopped;
  has_next_ = false;
  begin_travel(next_);
  return PlayheadEvent::none;
}

PlayheadEvent Playhead::pass_end(Direction direction) {
  const FrameTime end = end_towards(direction);
  if (state_ == PlayheadState::playing && repeat_ == Repeat::loop) {
    shift_by(end_towards(opposite(direction)).frame - end.frame);
    return PlayheadEvent::repeated;
  }
  if (state_ == PlayheadState::playing && repeat_ == Repeat::ping_pong) {
    time_ = moved_by(end, -frames_between(end, time_));
    rate_ = -rate_;
    change_ = -change_;
    direction_ = opposite(direction);
    anchor_here();
    return PlayheadEvent::repeated;
  }
  time_ = end;
  if (state_ == PlayheadState::slowing) return settle();
  rest();
  return PlayheadEvent::finished;
}

void Playhead::rest() {
  rate_ = change_ = 0;
  state_ = PlayheadState::resting;
}

/// Time runs evenly. At the drawn speed whole ticks are counted, so that nothing is lost to rounding.
void Playhead::cruise() {
  if (std::fabs(rate_) != 1) return advance_by(rate_ * tick_s_);
  cruise_phase_ += move_->frame_rate().numerator;
  if (cruise_phase_ >= unit_) {
    cruise_frames_ += static_cast<std::int32_t>(cruise_phase_ / unit_);
    cruise_phase_ %= unit_;
  }
  const double fraction = static_cast<double>(cruise_phase_) / static_cast<double>(unit_);
  const std::int32_t frames = rate_ > 0 ? cruise_frames_ : -cruise_frames_;
  time_ = moved_by({anchor_.frame + frames, anchor_.fraction}, rate_ > 0 ? fraction : -fraction);
}

void Playhead::anchor_here() {
  anchor_ = time_;
  cruise_frames_ = 0;
  cruise_phase_ = 0;
}

/// A stop, and the first half of a turn, keeps the stop limits, everything else those of the motion.
void Playhead::change_to(double target) {
  if (is_turning() || state_ == PlayheadState::slowing || rungs_.empty()) {
    rung_ = nullptr;
    return follow_to(target, *bounds_);
  }
  if (change_ == 0) rung_ = rung_from(target);
  const double side = rate_ != 0 ? std::copysign(1.0, rate_) : std::copysign(1.0, change_);
  const auto permits = [&](const StopBounds& rung) {
    return rung.permits(time_, side * rate_, side * change_);
  };
  if (rung_ == nullptr || !permits(*rung_)) {
    const auto permitting = std::ranges::find_if(rungs_, permits);
    if (permitting == rungs_.end()) return release();
    rung_ = &*permitting;
  }
  follow_to(std::clamp(target, -rung_->rate(), rung_->rate()), *rung_);
}

/// The lowest rung that leads from the present rate towards another.
const StopBounds* Playhead::rung_from(double target) const {
  const double rate = std::fabs(rate_);
  const bool rises = std::fabs(target) > rate;
  const auto above = std::ranges::find_if(
      rungs_, [&](const StopBounds& rung) { return rises ? rung.rate() > rate : rung.rate() >= rate; });
  return above == rungs_.end() ? &rungs_.back() : &*above;
}

/// A rate change that a stop began ends as quickly as stops may.
void Playhead::release() {
  rung_ = nullptr;
  const double step = bounds_->rate_jerk(time_) * tick_s_;
  const double next = std::copysign(std::max(std::fabs(change_) - step, 0.0), change_);
  move_on((next - change_) / tick_s_, tick_s_);
  if (next == 0) change_ = 0;
}

/// One tick of the quickest change to a rate. The rate change a1 at its end is the largest that the bounds
/// allow and from which the last phase, with r'' = Q, still meets the rate:
///     a1^2 <= 2 Q (gap - (a + a1) / 2 tick).
void Playhead::follow_to(double target, const StopBounds& within) {
  // The furthest place that the tick may reach.
  const double last_rate = within.rate_jerk(time_) * tick_s_ * tick_s_ / 6;
  const double reach = std::fabs(rate_) + std::fabs(change_) * tick_s_ / 2 + last_rate;
  const double gap = target - rate_;
  const FrameTime ahead = moved_by(time_, std::copysign(reach * tick_s_ * fps_, rate_ != 0 ? rate_ : gap));
  const bool is_forward = time_ < ahead;
  const StopBound bound = within.min_between(is_forward ? time_ : ahead, is_forward ? ahead : time_);
  // Each bound holds within a cell of its place, so on both sides of a border that this tick may cross.
  const double jerk = std::max(within.rate_jerk(time_), within.rate_jerk(ahead));
  if (is_steady(target)) return settle_on(target);
  if (lands_within_tick(target, jerk)) return land(target);
  const double side = gap != 0 ? std::copysign(1.0, gap) : std::copysign(1.0, -change_);
  const double change = side * change_;
  const double last_change = bound.release_jerk * tick_s_ / 2;
  const double under_root =
      last_change * last_change + 4 * last_change / tick_s_ * (side * gap - change * tick_s_ / 2);
  const double step = jerk * tick_s_;
  double next = under_root > 0 ? std::sqrt(under_root) - last_change : change - step;
  next = std::min(next, bound.rate_change);
  next = std::clamp(next, change - step, change + step);
  move_on(side * (next - change) / tick_s_, tick_s_);
}

/// Whether nothing but rounding is left of a change to a rate. A rounding of the rate change would turn into
/// its opposite from tick to tick, for ever, and a stop would never be over.
bool Playhead::is_steady(double target) const {
  const double rounding = 8 * std::numeric_limits<double>::epsilon() * bounds_->rate();
  return std::fabs(target - rate_) <= rounding && std::fabs(change_) * tick_s_ <= rounding;
}
void Playhead::settle_on(double target) {
  rate_ = target;
  change_ = 0;
  advance_by(target * tick_s_);
}

/// Whether rate and rate change can arrive together before the tick is over.
bool Playhead::lands_within_tick(double target, double jerk) const {
  const double gap = target - rate_;
  if (!(change_ * gap > 0) || 2 * gap / change_ > tick_s_) return false;
  return change_ * change_ <= 2 * jerk * std::fabs(gap) * (1 + jerk_rounding);
}
void Playhead::land(double target) {
  const double gap = target - rate_;
  const double seconds = 2 * gap / change_;
  move_on(-change_ / seconds, seconds);
  rate_ = target;
  change_ = 0;
  advance_by(target * (tick_s_ - seconds));
}

/// Moves on for so many seconds at a constant r''.
void Playhead::move_on(double jerk, double seconds) {
  advance_by(seconds * (rate_ + seconds * (change_ / 2 + seconds * jerk / 6)));
  rate_ += seconds * (change_ + seconds * jerk / 2);
  change_ += seconds * jerk;
}

void Playhead::advance_by(double seconds_of_time_line) {
  time_ = moved_by(time_, seconds_of_time_line * fps_);
}

// --- from rest to rest

double Playhead::seconds_between(const FrameTime& from, const FrameTime& to) const {
  return frames_between(from, to) / fps_;
}

/// A course that is below both bounds can be stopped anywhere: it is among the states that the stop bounds
/// certify.
StopBound Playhead::travel_bound(const FrameTime& from, const FrameTime& to) const {
  const StopBound stops = bounds_->min_between(from, to);
  if (rungs_.empty()) return stops;
  return stops.lower(rungs_.front().min_between(from, to));
}

double Playhead::top_travel_rate() const {
  return rungs_.empty() ? bounds_->rate() : std::min(bounds_->rate(), rungs_.front().rate());
}

void Playhead::begin_travel(const FrameTime& to) {
  const bool backward = to < time_;
  const StopBound bounds = travel_bound(backward ? to : time_, backward ? time_ : to);
  const double distance_s = std::fabs(seconds_between(time_, to));
  travel_ = {.from = time_,
             .to = to,
             .sign = backward ? double{-1} : 1.0,
             .course = Travel::shortest(distance_s, std::min(override_, top_travel_rate()), bounds)};
  state_ = PlayheadState::travelling;
}

PlayheadEvent Playhead::tick_travel() {
  const std::int64_t ticks = ++travel_.ticks;
  const double t = static_cast<double>(ticks) * tick_s_;
  if (!(t < travel_.course.seconds())) {
    time_ = travel_.to;
    if (has_next_) return settle();
    rest();
    return PlayheadEvent::arrived;
  }
  const TravelState now = travel_.course.at(t);
  const double frames = travel_.sign * now.distance_s * fps_;
  time_ = now.to_end ? moved_by(travel_.to, -frames) : moved_by(travel_.from, frames);
  rate_ = travel_.sign * now.rate;
  change_ = travel_.sign * now.rate_change;
  anchor_here();  // somebody may play on at this rate
  if (ticks == travel_.opening_tick) return PlayheadEvent::opened;
  return ticks == travel_.closing_tick ? PlayheadEvent::closed : PlayheadEvent::none;
}

PlayheadEvent Playhead::tick_following() {
  const PlayheadPlace& place = followed_.front();
  followed_ = followed_.subspan(1);
  time_ = place.time;
  rate_ = place.rate;
  change_ = place.rate_change;
  if (rate_ != 0) direction_ = rate_ > 0 ? Direction::forward : Direction::backward;
  anchor_here();  // somebody may play on at this rate
  if (!followed_.empty()) return PlayheadEvent::none;
  rest();
  return time_ == end_towards(direction_) ? PlayheadEvent::finished : PlayheadEvent::stopped;
}

/// A stop keeps at least the bounds of the distance that is left, and falls tick by tick, a little later than
/// the travel: with the same bounds it would pass its end.
bool Playhead::travel_ends_like_a_stop() const {
  if (state_ != PlayheadState::travelling || rate_ == 0) return false;
  const bool backward = travel_.sign < 0;
  const StopBound bounds = bounds_->min_between(backward ? travel_.to : time_, backward ? time_ : travel_.to);
  const double left_s = travel_.sign * seconds_between(time_, travel_.to);
  return Travel::stop_distance_s(travel_.sign * rate_, travel_.sign * change_, bounds, tick_s_) > left_s;
}

// --- exposures in motion

/// The rise takes no whole number of ticks, but the even stretch begins early enough for a tick to open on,
/// and lasts until a tick. The wider the course, the lower its bounds may be, and the wider it has to be.
Result<typename Playhead::Journey> Playhead::journey_of(const Exposure& exposure) const {
  const double distance_s = seconds_between(exposure.open, exposure.close);
  if (!(distance_s > 0 && exposure.seconds > 0)) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "an exposure in motion covers no time",
                 .remedy = "let it close after it opens, and last longer than 0 s"};
  }
  const double rate = distance_s / exposure.seconds;
  if (rate > top_travel_rate()) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "an exposure is so short that the rig would go faster than drawn",
                 .remedy = "expose longer, or open the shutter for a smaller share of the frame"};
  }
  const double open_ticks = std::ceil(exposure.seconds / tick_s_ - tick_rounding);
  StopBound bounds = travel_bound(exposure.open, exposure.close);
  for (int narrower = 0; narrower < max_narrowings; ++narrower) {
    const double rise_s = Travel::rise_to(rate, bounds);
    const double rise_ticks = std::ceil(rise_s / tick_s_);
    const double run_up_s = rate * (rise_ticks * tick_s_ - rise_s / 2);
    Journey journey{.from = moved_by(exposure.open, -run_up_s * fps_),
                    .to = moved_by(exposure.open, rate * (open_ticks * tick_s_ + rise_s / 2) * fps_),
                    .course = Travel::even(rate, (rise_ticks + open_ticks) * tick_s_ - rise_s, bounds),
                    .opening_tick = static_cast<std::int64_t>(rise_ticks),
                    .closing_tick = static_cast<std::int64_t>(rise_ticks + open_ticks)};
    const StopBound within = travel_bound(journey.from, journey.to);
    if (within.rate_change >= bounds.rate_change && within.release_jerk >= bounds.release_jerk)
      return journey;
    bounds = within;
  }
  return Error{.code = ErrorCode::not_converged,
               .what = "no run-up to an exposure was found",
               .remedy = "expose longer"};
}

Result<ExposureTravel> Playhead::travel_of(const Exposure& exposure) const {
  const Result<Journey> journey = journey_of(exposure);
  if (!journey) return journey.error();
  return ExposureTravel{journey->from, journey->to};
}

Status Playhead::go_to_run_up(const Exposure& exposure) {
  if (!is_resting()) {
    return Error{.code = ErrorCode::wrong_state, .what = "the move is running", .remedy = "stop it first"};
  }
  const Result<Journey> journey = journey_of(exposure);
  if (!journey) return journey.error();
  begin_travel(journey->from);
  return Done{};
}

Status Playhead::expose(const Exposure& exposure) {
  const Result<Journey> journey = journey_of(exposure);
  if (!journey) return journey.error();
  if (!is_resting() || time_ != journey->from) {
    return Error{.code = ErrorCode::wrong_state,
                 .what = "the run-up to an exposure starts elsewhere",
                 .remedy = "go to the start of its run-up first"};
  }
  travel_ = *journey;
  state_ = PlayheadState::travelling;
  return Done{};
}

bool Playhead::is_on_time_line(const FrameTime& time) const {
  return time.fraction >= 0 && time.fraction < 1 && time.frame >= move_->first_frame() &&
         time <= FrameTime{move_->last_frame(), 0};
}

FrameTime Playhead::end_towards(Direction direction) const {
  return {direction == Direction::forward ? move_->last_frame() : move_->first_frame(), 0};
}

}  // namespace inbetween
