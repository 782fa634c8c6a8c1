#include "inbetween/play/free_axis.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "inbetween/base/bisection.hpp"

namespace inbetween {
namespace {

constexpr Error not_finite{
    .code = ErrorCode::not_finite, .what = "a number of a free axis is not finite", .remedy = "give numbers"};

template <Precise Real>
Status check_range(Real min, Real max) {
  if (!std::isfinite(min) || !std::isfinite(max)) return not_finite;
  if (min < max && -min <= Precision<Real>::largest && max <= Precision<Real>::largest) return Done{};
  return Error{.code = ErrorCode::out_of_range,
               .what = "the soft limits leave an axis no way",
               .remedy = "give a min below max"};
}

template <Precise Real>
bool is_magnitude(Real number) {
  return number > 0 && number <= Precision<Real>::largest;
}

}  // namespace

template <Precise Real>
Result<FreeAxis<Real>> FreeAxis<Real>::make(const FreeAxisLimits<Real>& limits, Real position,
                                            Real tick_seconds) {
  if (const Status range = check_range(limits.min, limits.max); !range) return range.error();
  for (const Real number : {limits.velocity, limits.acceleration, limits.jerk, position, tick_seconds}) {
    if (!std::isfinite(number)) return not_finite;
  }
  for (const Real number :
       {limits.velocity, limits.acceleration, limits.jerk, tick_seconds, limits.stop_share}) {
    if (is_magnitude(number) && limits.stop_share >= 1) continue;
    return Error{.code = ErrorCode::out_of_range,
                 .what = "a limit or the tick of a free axis is not above 0, or its stop_share below 1",
                 .remedy = "give velocity, acceleration, jerk and tick as magnitudes"};
  }
  const Real longest = limits.velocity / limits.acceleration + limits.acceleration / limits.jerk;
  if (!is_magnitude(limits.velocity * longest) || !(std::fabs(position) <= Precision<Real>::largest)) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "a free axis moves too far to be computed",
                 .remedy = "use larger units, or limits that fit each other"};
  }
  return FreeAxis(limits, position, tick_seconds);
}

template <Precise Real>
SpeedRamp<Real> FreeAxis<Real>::ramp_to_rest(const RampLimits<Real>& limits) const {
  return SpeedRamp<Real>::between(state_.velocity, state_.acceleration, 0, limits);
}

/// The way of a ramp to a velocity and of the stop that follows at once.
template <Precise Real>
Real FreeAxis<Real>::way_over(Real velocity) const {
  return SpeedRamp<Real>::between(state_.velocity, state_.acceleration, velocity, ramp()).way() +
         SpeedRamp<Real>::between(velocity, 0, 0, ramp()).way();
}

/// The highest speed up to `speed`, or nearly, whose way is at most `room`; the way of a stop fits into
/// `room`. Call the speed that remains when the acceleration is released the released speed. Above it the way
/// grows with the speed. Below it the ramp interrupts a slowing down, and the way may be longer than that of
/// the released speed; there may be several roots, and any of them is good. While the speed rises, the way of
/// the released speed is that of the stop, so that only rounding can make it longer than `room`; then the
/// axis stops.
template <Precise Real>
Real FreeAxis<Real>::top_speed(Real direction, Real speed, Real room) const {
  const auto fits = [&](Real tried) { return direction * way_over(direction * tried) <= room; };
  if (fits(speed)) return speed;
  Bracket<Real> bracket{0, speed};
  const Real released =
      direction * SpeedRamp<Real>::released(state_.velocity, state_.acceleration, limits_.jerk);
  if (0 < released && released < speed) {
    (direction * state_.acceleration >= 0 || fits(released) ? bracket.low : bracket.high) = released;
  }
  const Real low = bisected(bracket, 2 * std::numeric_limits<Real>::digits, fits).low;
  return low == 0 || fits(low) ? low : Real{0};
}

template <Precise Real>
void FreeAxis<Real>::head_for(Real position, Real speed, Activity activity) {
  const Real room = position - state_.position;
  // An axis that would stop beyond the place has to come back: it moves in the other direction in the end.
  const Real direction = room >= ramp_to_rest(ramp()).way() ? Real{1} : Real{-1};
  const Real top = top_speed(direction, speed, direction * room);
  const Real left = std::max(direction * (room - way_over(direction * top)), Real{0});
  rise_ = SpeedRamp<Real>::between(state_.velocity, state_.acceleration, direction * top, ramp());
  fall_ = SpeedRamp<Real>::between(direction * top, 0, 0, ramp());
  even_s_ = 0;
  if (top > 0) even_s_ = left / top;
  // The last bit of the speed leaves a short rest of the way, which takes a moment at that speed. At a slow
  // speed that rest is rounding, so it gets at most a tick.
  if (top < speed) even_s_ = std::min(even_s_, tick_s_);
  from_ = state_.position;
  end_ = position;
  risen_ = top > 0 ? from_ + rise_.way() : end_;
  ticks_ = 0;
  activity_ = activity;
}

template <Precise Real>
Status FreeAxis<Real>::drive(Real velocity) {
  if (!std::isfinite(velocity)) return not_finite;
  if (std::fabs(velocity) > limits_.velocity) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "a free axis is driven faster than its limit",
                 .remedy = "drive it more slowly"};
  }
  if (velocity == 0) {
    stop();
    return Done{};
  }
  // A key that is held repeats its command. Planning anew each time would restart the ramp.
  if (activity_ == Activity::driving && velocity == driven_) return Done{};
  const Real direction = velocity > 0 ? Real{1} : Real{-1};
  const Real limit = velocity > 0 ? limits_.max : limits_.min;
  const Real room = direction * (limit - state_.position);
  if (room < 0 || (room == 0 && is_resting())) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "the axis is at its soft limit or beyond it",
                 .remedy = "drive it the other way"};
  }
  // The soft limit is the target, so that the axis rests there even if no other command comes.
  head_for(limit, std::fabs(velocity), Activity::driving);
  driven_ = velocity;
  return Done{};
}

template <Precise Real>
Status FreeAxis<Real>::go_to(Real position, Real speed) {
  if (!std::isfinite(position) || !std::isfinite(speed)) return not_finite;
  if (position < limits_.min || position > limits_.max) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "the position is outside the soft limits of the axis",
                 .remedy = "go to one between min and max"};
  }
  if (!(speed > 0 && speed <= limits_.velocity)) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "the speed of a free axis is not above 0, or above its limit",
                 .remedy = "give a speed up to the limit"};
  }
  if (is_resting() && position == state_.position) return Done{};
  head_for(position, speed, Activity::travelling);
  return Done{};
}

template <Precise Real>
void FreeAxis<Real>::stop() {
  if (activity_ == Activity::resting || activity_ == Activity::stopping) return;
  rise_ = stop_ramp();
  fall_ = SpeedRamp<Real>();
  even_s_ = 0;
  from_ = state_.position;
  end_ = inside(from_ + rise_.way());
  risen_ = end_;
  ticks_ = 0;
  activity_ = Activity::stopping;
}

template <Precise Real>
void FreeAxis<Real>::halt() {
  rest_at(state_.position);
}

template <Precise Real>
Status FreeAxis<Real>::place(Real position) {
  if (!std::isfinite(position)) return not_finite;
  if (!is_resting() || std::fabs(position) > Precision<Real>::largest) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "an axis that moves is given a position, or one that is too far to be computed",
                 .remedy = "wait until it rests"};
  }
  rest_at(position);
  return Done{};
}

template <Precise Real>
Status FreeAxis<Real>::set_range(Real min, Real max) {
  if (const Status range = check_range(min, max); !range) return range;
  if (!is_resting()) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "an axis that moves is given other soft limits",
                 .remedy = "wait until it rests"};
  }
  limits_.min = min;
  limits_.max = max;
  return Done{};
}

template <Precise Real>
void FreeAxis<Real>::rest_at(Real position) {
  state_ = {.position = position};
  from_ = position;
  end_ = position;
  activity_ = Activity::resting;
}

template <Precise Real>
Setpoint<Real> FreeAxis<Real>::tick() {
  if (is_resting()) return state_;
  ++ticks_;
  const Real seconds = static_cast<Real>(ticks_) * tick_s_;
  if (seconds - rise_.seconds() - even_s_ >= fall_.seconds()) {
    rest_at(end_);
  } else {
    state_ = at(seconds);
    state_.position = inside(state_.position);
  }
  return state_;
}

template <Precise Real>
Setpoint<Real> FreeAxis<Real>::at(Real seconds) const {
  const auto along = [](const SpeedRamp<Real>& ramp, Real begin, Real end, Real t) {
    const RampState<Real> state = ramp.at(t);
    return Setpoint<Real>{(state.to_end ? end : begin) + state.way, state.velocity, state.acceleration};
  };
  if (seconds < rise_.seconds()) return along(rise_, from_, risen_, seconds);
  const Real even = seconds - rise_.seconds();
  const Real velocity = rise_.to_velocity();
  if (even < even_s_) return {risen_ + velocity * even, velocity, 0};
  return along(fall_, end_ - fall_.way(), end_, even - even_s_);
}

/// Rounding alone could pass a soft limit, by the last bits of a position. This does not put an axis inside
/// that began outside.
template <Precise Real>
Real FreeAxis<Real>::inside(Real position) const {
  return std::clamp(position, std::min(limits_.min, from_), std::max(limits_.max, from_));
}

/// The stop is longest where the acceleration is largest and the speed is v once the acceleration is
/// released: it takes a / jerk seconds, and then the time from v to rest. Between -v and v the acceleration
/// reaches sqrt(2 jerk v), if the limit allows it; on the way to rest it reaches sqrt(jerk v).
template <Precise Real>
Real FreeAxis<Real>::velocity_that_stops_within(Real seconds) const {
  if (!(seconds > 0)) return 0;
  const Real jerk = limits_.jerk;
  const Real acceleration = limits_.acceleration;
  const Real jerk_s = acceleration / jerk;
  const Real share = seconds / (2 + std::sqrt(Real{2}));
  Real velocity = jerk * share * share;
  if (velocity > acceleration * jerk_s / 2) {
    const Real half = (seconds - jerk_s) / 2;
    velocity = half <= jerk_s ? jerk * half * half : acceleration * (seconds - 2 * jerk_s);
  }
  return std::min(velocity, limits_.velocity);
}

template class FreeAxis<double>;
template class FreeAxis<float>;

}  // namespace inbetween
