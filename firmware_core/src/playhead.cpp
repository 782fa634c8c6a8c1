#include "inbetween/playhead.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "cube_root.hpp"

namespace inbetween {
namespace {

/// By how much rounding may make a bend down steeper than it was begun.
template <Precise Real>
inline constexpr Real bend_rounding = std::numeric_limits<Real>::digits > 30 ? Real(1e-9) : Real(1e-4);
/// The ends of a loop are in one place where they are within this share of the position.
template <Precise Real>
inline constexpr Real loop_rounding = std::numeric_limits<Real>::digits > 30 ? Real(1e-12) : Real(1e-6);
/// So near its target scrubbing comes to rest, and travels the rest of the way.
inline constexpr double scrub_rest_frames = 0.05;

constexpr Direction opposite(Direction direction) {
  return direction == Direction::forward ? Direction::backward : Direction::forward;
}
template <Precise Real>
constexpr Real sign_of(Direction direction) {
  return static_cast<Real>(static_cast<int>(direction));
}

/// `time` moved by frames, of which the fraction is brought back to [0, 1).
template <Precise Real>
FrameTime<Real> moved(const FrameTime<Real>& time, Real frames) {
  const Real sum = time.fraction + frames;
  Real whole = std::floor(sum);
  Real fraction = sum - whole;
  if (fraction >= 1) {  // a tiny negative number is rounded up
    fraction = 0;
    whole += 1;
  }
  return {time.frame + static_cast<std::int32_t>(whole), fraction};
}

template <Precise Real>
constexpr bool is_before(const FrameTime<Real>& a, const FrameTime<Real>& b) {
  return a.frame < b.frame || (a.frame == b.frame && a.fraction < b.fraction);
}
template <Precise Real>
constexpr bool is_same(const FrameTime<Real>& a, const FrameTime<Real>& b) {
  return a.frame == b.frame && a.fraction == b.fraction;
}

Error not_on_time_line() {
  return {.code = ErrorCode::out_of_range,
          .what = "there is no such frame on the time line",
          .remedy = "name one from the first frame of the move to its last"};
}

}  // namespace

template <Precise Real>
Playhead<Real>::Playhead(const Move<Real>& move, const StopBounds<Real>& bounds, std::int32_t rate_hz)
    : move_(&move),
      bounds_(&bounds),
      unit_(static_cast<std::int64_t>(rate_hz) * move.frame_rate().denominator),
      tick_s_(Real{1} / static_cast<Real>(rate_hz)),
      fps_(static_cast<Real>(move.frame_rate().numerator) / static_cast<Real>(move.frame_rate().denominator)),
      time_{move.first_frame(), 0},
      override_(std::min(Real{1}, bounds.rate())) {}

// --- commands

template <Precise Real>
Status Playhead<Real>::play(Direction direction) {
  if (is_resting() && is_same(time_, end_towards(direction))) {
    if (repeat_ == Repeat::none) {
      return Error{.code = ErrorCode::out_of_range,
                   .what = "the move is at that end already",
                   .remedy = "play it the other way, or go to a frame first"};
    }
    if (repeat_ == Repeat::loop) time_ = end_towards(opposite(direction));
    if (repeat_ == Repeat::ping_pong) direction = opposite(direction);
  }
  // At its own end nothing moves.
  if (is_resting() && is_same(time_, end_towards(opposite(direction)))) {
    rate_ = sign_of<Real>(direction) * override_;
    anchor_here();
  }
  direction_ = direction;
  state_ = PlayheadState::playing;
  has_next_frame_ = false;
  return Done{};
}

template <Precise Real>
void Playhead<Real>::stop() {
  has_next_frame_ = false;
  if (!is_resting()) state_ = PlayheadState::slowing;
}

template <Precise Real>
void Playhead<Real>::halt() {
  has_next_frame_ = false;
  rest();
}

template <Precise Real>
Status Playhead<Real>::go_to(std::int32_t frame) {
  if (!is_on_time_line({frame, 0})) return not_on_time_line();
  if (is_resting()) {
    begin_travel({frame, 0});
  } else {
    stop();
    next_frame_ = frame;
    has_next_frame_ = true;
  }
  return Done{};
}

template <Precise Real>
Status Playhead<Real>::step(Direction direction) {
  FrameTime<Real> from = time_;
  if (has_next_frame_) {
    from = {next_frame_, 0};
  } else if (state_ == PlayheadState::travelling) {
    from = travel_.to;
  } else if (!is_resting()) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "a step needs a move that rests",
                 .remedy = "stop it first, or go to a frame"};
  }
  const bool is_between = from.fraction > 0;
  return go_to(direction == Direction::forward ? from.frame + 1 : from.frame - (is_between ? 0 : 1));
}

template <Precise Real>
Status Playhead<Real>::scrub_to(const FrameTime<Real>& target) {
  if (!is_on_time_line(target)) return not_on_time_line();
  scrub_target_ = target;
  has_next_frame_ = false;
  state_ = PlayheadState::scrubbing;
  return Done{};
}

template <Precise Real>
Status Playhead<Real>::set_override(Real rate) {
  if (!(rate > 0 && rate <= bounds_->rate())) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "the override is not above 0, or beyond the rate for which stops are proven",
                 .remedy = "use a lower rate"};
  }
  override_ = rate;
  return Done{};
}

template <Precise Real>
Status Playhead<Real>::set_repeat(Repeat repeat) {
  if (repeat == Repeat::loop) {
    std::array<Real, most_bounded_axes> first;
    std::array<Real, most_bounded_axes> last;
    const std::size_t axes = move_->axis_count();
    if (axes > most_bounded_axes) {
      return Error{.code = ErrorCode::capacity,
                   .what = "the move has more axes than a loop can compare",
                   .remedy = "use 64 at most",
                   .needed = static_cast<std::int64_t>(axes)};
    }
    move_->positions({move_->first_frame(), 0}, first);
    move_->positions({move_->last_frame(), 0}, last);
    for (std::size_t d = 0; d < axes; ++d) {
      const Real size = std::max(std::fabs(first[d]), std::fabs(last[d]));
      if (std::fabs(first[d] - last[d]) <= loop_rounding<Real> * size) continue;
      return Error{.code = ErrorCode::no_solution,
                   .what = "a loop would step: the axis rests elsewhere at the end than at the start",
                   .remedy = "end the move where it starts, at rest, or play it to and fro",
                   .axis = static_cast<std::int32_t>(d)};
    }
  }
  repeat_ = repeat;
  return Done{};
}

template <Precise Real>
Status Playhead<Real>::place_on(std::int32_t frame) {
  if (!is_on_time_line({frame, 0})) return not_on_time_line();
  if (!is_resting()) {
    return Error{.code = ErrorCode::out_of_range, .what = "the move is running", .remedy = "stop it first"};
  }
  time_ = {frame, 0};
  return Done{};
}

// --- a tick

template <Precise Real>
PlayheadEvent Playhead<Real>::tick() {
  switch (state_) {
    case PlayheadState::resting:
      return PlayheadEvent::none;
    case PlayheadState::playing:
      return tick_ramp(sign_of<Real>(direction_) * override_);
    case PlayheadState::slowing:
      return tick_ramp(0);
    case PlayheadState::travelling:
      return tick_travel();
    case PlayheadState::scrubbing:
      break;
  }
  if (rate_ == 0 && change_ == 0 && scrub_rate() == 0) {
    begin_travel(scrub_target_);
    return tick_travel();
  }
  return tick_ramp(scrub_rate());
}

template <Precise Real>
PlayheadEvent Playhead<Real>::tick_ramp(Real target) {
  if (rate_ * target < 0) target = 0;  // a turn is a stop and a start
  if (rate_ == target && change_ == 0) {
    cruise();
  } else {
    follow_to(target);
    anchor_here();
  }
  for (const Direction direction : {Direction::forward, Direction::backward}) {
    if (!(rate_ * sign_of<Real>(direction) > 0)) continue;
    const FrameTime<Real> end = end_towards(direction);
    const bool is_inside = direction == Direction::forward ? is_before(time_, end) : is_before(end, time_);
    if (!is_inside) return pass_end(direction);
  }
  if (state_ == PlayheadState::slowing && rate_ == 0 && change_ == 0) return settle();
  return PlayheadEvent::none;
}

/// At rest where it was told to slow down.
template <Precise Real>
PlayheadEvent Playhead<Real>::settle() {
  rest();
  if (!has_next_frame_) return PlayheadEvent::stopped;
  has_next_frame_ = false;
  begin_travel({next_frame_, 0});
  return PlayheadEvent::none;
}

template <Precise Real>
PlayheadEvent Playhead<Real>::pass_end(Direction direction) {
  const FrameTime<Real> end = end_towards(direction);
  if (state_ == PlayheadState::playing && repeat_ != Repeat::none) {
    const Real beyond = static_cast<Real>(time_.frame - end.frame) + time_.fraction;
    time_ = moved(repeat_ == Repeat::loop ? end_towards(opposite(direction)) : end,
                  repeat_ == Repeat::loop ? beyond : -beyond);
    if (repeat_ == Repeat::ping_pong) {
      rate_ = -rate_;
      change_ = -change_;
      direction_ = opposite(direction);
    }
    anchor_here();
    return PlayheadEvent::repeated;
  }
  time_ = end;
  if (state_ == PlayheadState::scrubbing) {
    rate_ = change_ = 0;
    return PlayheadEvent::none;
  }
  if (state_ == PlayheadState::slowing) return settle();
  rest();
  return PlayheadEvent::finished;
}

template <Precise Real>
void Playhead<Real>::rest() {
  rate_ = change_ = 0;
  state_ = PlayheadState::resting;
}

/// Time runs evenly. At the drawn speed whole ticks are counted, so that nothing is lost to rounding.
template <Precise Real>
void Playhead<Real>::cruise() {
  if (std::fabs(rate_) != 1) return advance_by(rate_ * tick_s_);
  cruise_phase_ += move_->frame_rate().numerator;
  if (cruise_phase_ >= unit_) {
    cruise_frames_ += static_cast<std::int32_t>(cruise_phase_ / unit_);
    cruise_phase_ %= unit_;
  }
  const Real fraction = static_cast<Real>(cruise_phase_) / static_cast<Real>(unit_);
  const std::int32_t frames = rate_ > 0 ? cruise_frames_ : -cruise_frames_;
  time_ = moved({anchor_.frame + frames, anchor_.fraction}, rate_ > 0 ? fraction : -fraction);
}

template <Precise Real>
void Playhead<Real>::anchor_here() {
  anchor_ = time_;
  cruise_frames_ = 0;
  cruise_phase_ = 0;
}

/// The quickest way to a rate, for one tick: the rate change a1 at its end is the largest that the bounds
/// allow and from which the bend down, with r'' = Q, still meets the rate:
///     a1^2 <= 2 Q (gap - (a + a1) / 2 tick).
template <Precise Real>
void Playhead<Real>::follow_to(Real target) {
  // As far as the tick may reach at most.
  const Real bend_rate = bounds_->rate_jerk(time_) * tick_s_ * tick_s_ / 6;
  const Real reach = std::fabs(rate_) + std::fabs(change_) * tick_s_ / 2 + bend_rate;
  const FrameTime<Real> ahead = moved(time_, std::copysign(reach * tick_s_ * fps_, rate_));
  const bool is_forward = is_before(time_, ahead);
  const StopBound<Real> bound = bounds_->least(is_forward ? time_ : ahead, is_forward ? ahead : time_);
  // Either holds within a cell of its place, so on both sides of a border that this tick may cross.
  const Real jerk = std::max(bounds_->rate_jerk(time_), bounds_->rate_jerk(ahead));
  if (lands_within_tick(target, jerk)) return land(target);
  const Real gap = target - rate_;
  const Real side = gap != 0 ? std::copysign(Real{1}, gap) : std::copysign(Real{1}, -change_);
  const Real change = side * change_;
  const Real bend = bound.release_jerk * tick_s_ / 2;
  const Real under_root = bend * bend + 4 * bend / tick_s_ * (side * gap - change * tick_s_ / 2);
  const Real step = jerk * tick_s_;
  Real next = under_root > 0 ? std::sqrt(under_root) - bend : change - step;
  next = std::min(next, bound.rate_change);
  next = std::clamp(next, change - step, change + step);
  move_on(side * (next - change) / tick_s_, tick_s_);
}

/// Whether rate and rate change can arrive together before the tick is over.
template <Precise Real>
bool Playhead<Real>::lands_within_tick(Real target, Real jerk) const {
  const Real gap = target - rate_;
  if (!(change_ * gap > 0) || 2 * gap / change_ > tick_s_) return false;
  return change_ * change_ <= 2 * jerk * std::fabs(gap) * (1 + bend_rounding<Real>);
}
template <Precise Real>
void Playhead<Real>::land(Real target) {
  const Real gap = target - rate_;
  const Real seconds = 2 * gap / change_;
  move_on(-change_ / seconds, seconds);
  rate_ = target;
  change_ = 0;
  advance_by(target * (tick_s_ - seconds));
}

/// So many seconds with one r''.
template <Precise Real>
void Playhead<Real>::move_on(Real jerk, Real seconds) {
  advance_by(seconds * (rate_ + seconds * (change_ / 2 + seconds * jerk / 6)));
  rate_ += seconds * (change_ + seconds * jerk / 2);
  change_ += seconds * jerk;
}

template <Precise Real>
void Playhead<Real>::advance_by(Real seconds_of_time_line) {
  time_ = moved(time_, seconds_of_time_line * fps_);
}

// --- from rest to rest

template <Precise Real>
Real Playhead<Real>::seconds_between(const FrameTime<Real>& from, const FrameTime<Real>& to) const {
  return (static_cast<Real>(to.frame - from.frame) + (to.fraction - from.fraction)) / fps_;
}

/// With bends of t seconds and a straight stretch the rate rises to `top` in top / change + change / jerk
/// seconds, or, if it is reached before the bend ends, in 2 sqrt(top / jerk); on the way top / 2 times as
/// many seconds of the time line pass.
template <Precise Real>
void Playhead<Real>::begin_travel(const FrameTime<Real>& to) {
  Travel travel{.from = time_, .to = to};
  const Real way = seconds_between(time_, to);
  travel.sign = way < 0 ? Real{-1} : Real{1};
  travel.way_s = std::fabs(way);
  const StopBound<Real> bounds = bounds_->least(way < 0 ? to : time_, way < 0 ? time_ : to);
  const Real change = bounds.rate_change;
  const Real jerk = bounds.release_jerk;
  travel.jerk = jerk;
  const Real bend_s = change / jerk;
  const Real bend_rate = change * bend_s;
  const auto rise = [&](Real top) {
    return top <= bend_rate ? 2 * std::sqrt(top / jerk) : top / change + bend_s;
  };
  travel.top_rate = override_;
  if (travel.top_rate * rise(travel.top_rate) > travel.way_s) {
    const Real t = cube_root(travel.way_s / (2 * jerk));
    travel.top_rate = jerk * t * t;
    if (travel.top_rate > bend_rate) {
      const Real root = std::sqrt(bend_s * bend_s + 4 * travel.way_s / change);
      travel.top_rate = change / 2 * (root - bend_s);
    }
  }
  travel.rise_s = rise(travel.top_rate);
  travel.bend_s = std::min(bend_s, travel.rise_s / 2);
  travel.cruise_s =
      travel.top_rate > 0 ? std::max(travel.way_s / travel.top_rate - travel.rise_s, Real{0}) : Real{0};
  travel_ = travel;
  state_ = PlayheadState::travelling;
}

/// So long after rest, while the rate rises.
template <Precise Real>
typename Playhead<Real>::Rise Playhead<Real>::rise_at(Real t) const {
  const Travel& travel = travel_;
  const Real j = travel.jerk;
  const Real b = travel.bend_s;
  if (t <= b) return {j * t * t * t / 6, j * t * t / 2, j * t};
  const Real left = travel.rise_s - t;
  if (left <= b) {
    return {travel.top_rate * (travel.rise_s / 2 - left) + j * left * left * left / 6,
            travel.top_rate - j * left * left / 2, j * left};
  }
  const Real y = t - b;
  return {b * b * b * j / 6 + y * (j * b * b / 2 + y * j * b / 2), j * b * (b / 2 + y), j * b};
}

template <Precise Real>
PlayheadEvent Playhead<Real>::tick_travel() {
  Travel& travel = travel_;
  const Real t = static_cast<Real>(++travel.ticks) * tick_s_;
  const Real left = 2 * travel.rise_s + travel.cruise_s - t;
  if (!(left > 0)) {
    time_ = travel.to;
    rest();
    return PlayheadEvent::arrived;
  }
  if (t < travel.rise_s) {
    const Rise rise = rise_at(t);
    set_travelled(travel.from, travel.sign * rise.way_s, rise.rate, rise.change);
  } else if (left > travel.rise_s) {
    set_travelled(travel.from, travel.sign * travel.top_rate * (t - travel.rise_s / 2), travel.top_rate, 0);
  } else {
    const Rise rise = rise_at(left);
    set_travelled(travel.to, -travel.sign * rise.way_s, rise.rate, -rise.change);
  }
  return PlayheadEvent::none;
}

template <Precise Real>
void Playhead<Real>::set_travelled(const FrameTime<Real>& from, Real way_s, Real rate, Real change) {
  time_ = moved(from, way_s * fps_);
  rate_ = travel_.sign * rate;
  change_ = travel_.sign * change;
  anchor_here();  // somebody may play on at this rate
}

// --- after a target

/// Slower the nearer it is, so that it can be followed: from the override rate it takes as long as a stop.
template <Precise Real>
Real Playhead<Real>::scrub_rate() const {
  const Real way = seconds_between(time_, scrub_target_);
  if (std::fabs(way) * fps_ <= Real(scrub_rest_frames)) return 0;
  const StopBound<Real> bounds = bounds_->at(time_);
  const Real lag_s = 2 * (override_ / bounds.rate_change + bounds.rate_change / bounds.release_jerk);
  return std::clamp(way / lag_s, -override_, override_);
}

template <Precise Real>
bool Playhead<Real>::is_on_time_line(const FrameTime<Real>& time) const {
  return time.fraction >= 0 && time.fraction < 1 && time.frame >= move_->first_frame() &&
         !is_before(FrameTime<Real>{move_->last_frame(), 0}, time);
}

template <Precise Real>
FrameTime<Real> Playhead<Real>::end_towards(Direction direction) const {
  return {direction == Direction::forward ? move_->last_frame() : move_->first_frame(), 0};
}

template class Playhead<double>;
template class Playhead<float>;

}  // namespace inbetween
