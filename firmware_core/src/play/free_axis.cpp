#include "inbetween/play/free_axis.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "inbetween/base/bisection.hpp"

namespace inbetween {
namespace {

constexpr Error not_finite{
    .code = ErrorCode::not_finite, .what = "a number of a free axis is not finite", .remedy = "give numbers"};

Status check_range(double min, double max) {
  if (!std::isfinite(min) || !std::isfinite(max)) return not_finite;
  if (min < max && -min <= Precision::largest && max <= Precision::largest) return Done{};
  return Error{.code = ErrorCode::out_of_range,
               .what = "the soft limits leave an axis no room",
               .remedy = "give a min below max"};
}

bool is_magnitude(double number) {
  return number > 0 && number <= Precision::largest;
}

}  // namespace

Result<FreeAxis> FreeAxis::make(const FreeAxisLimits& limits, double position, double tick_seconds) {
  if (const Status range = check_range(limits.min, limits.max); !range) return range.error();
  for (const double number : {limits.velocity, limits.acceleration, limits.jerk, position, tick_seconds}) {
    if (!std::isfinite(number)) return not_finite;
  }
  for (const double number :
       {limits.velocity, limits.acceleration, limits.jerk, tick_seconds, limits.stop_share}) {
    if (is_magnitude(number) && limits.stop_share >= 1) continue;
    return Error{.code = ErrorCode::out_of_range,
                 .what = "a limit or the tick of a free axis is not above 0, or its stop_share below 1",
                 .remedy = "give velocity, acceleration, jerk and tick as magnitudes"};
  }
  const double longest = limits.velocity / limits.acceleration + limits.acceleration / limits.jerk;
  if (!is_magnitude(limits.velocity * longest) || !(std::fabs(position) <= Precision::largest)) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "a free axis moves too far to be computed",
                 .remedy = "use larger units, or limits that fit each other"};
  }
  return FreeAxis(limits, position, tick_seconds);
}

SpeedRamp FreeAxis::ramp_to_rest(const RampLimits& limits) const {
  return SpeedRamp::between(state_.velocity, state_.acceleration, 0, limits);
}

/// The distance of a ramp to a velocity and of the stop that follows at once.
double FreeAxis::distance_over(double velocity) const {
  return SpeedRamp::between(state_.velocity, state_.acceleration, velocity, ramp()).distance() +
         SpeedRamp::between(velocity, 0, 0, ramp()).distance();
}

/// The highest speed up to `speed`, or nearly, whose distance is at most `room`; the distance of a stop fits
/// into `room`. Call the speed that remains when the acceleration is released the released speed. Above it
/// the distance grows with the speed. Below it the ramp interrupts a slowing down, and the distance may be
/// longer than that of the released speed; there may be several roots, and any of them is good. While the
/// speed rises, the distance of the released speed is that of the stop, so that only rounding can make it
/// longer than `room`; then the axis stops.
double FreeAxis::top_speed(double direction, double speed, double room) const {
  const auto fits = [&](double tried) { return direction * distance_over(direction * tried) <= room; };
  if (fits(speed)) return speed;
  Bracket bracket{0, speed};
  const double released = direction * SpeedRamp::released(state_.velocity, state_.acceleration, limits_.jerk);
  if (0 < released && released < speed) {
    (direction * state_.acceleration >= 0 || fits(released) ? bracket.low : bracket.high) = released;
  }
  const double low = bisected(bracket, 2 * std::numeric_limits<double>::digits, fits).low;
  return low == 0 || fits(low) ? low : 0.0;
}

void FreeAxis::head_for(double position, double speed, Activity activity) {
  const double room = position - state_.position;
  // An axis that would stop beyond the place has to come back: it moves in the other direction in the end.
  const double direction = room >= ramp_to_rest(ramp()).distance() ? 1.0 : double{-1};
  const double top = top_speed(direction, speed, direction * room);
  const double left = std::max(direction * (room - distance_over(direction * top)), 0.0);
  rise_ = SpeedRamp::between(state_.velocity, state_.acceleration, direction * top, ramp());
  fall_ = SpeedRamp::between(direction * top, 0, 0, ramp());
  even_s_ = 0;
  if (top > 0) even_s_ = left / top;
  // The last bit of the speed leaves a short rest of the distance, which takes a moment at that speed. At a
  // slow speed that rest is rounding, so it gets at most a tick.
  if (top < speed) even_s_ = std::min(even_s_, tick_s_);
  from_ = state_.position;
  end_ = position;
  risen_ = top > 0 ? from_ + rise_.distance() : end_;
  ticks_ = 0;
  activity_ = activity;
}

Status FreeAxis::drive(double velocity) {
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
  const double direction = velocity > 0 ? 1.0 : double{-1};
  const double limit = velocity > 0 ? limits_.max : limits_.min;
  const double room = direction * (limit - state_.position);
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

Status FreeAxis::go_to(double position, double speed) {
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

void FreeAxis::stop() {
  if (activity_ == Activity::resting || activity_ == Activity::stopping) return;
  rise_ = stop_ramp();
  fall_ = SpeedRamp();
  even_s_ = 0;
  from_ = state_.position;
  end_ = inside(from_ + rise_.distance());
  risen_ = end_;
  ticks_ = 0;
  activity_ = Activity::stopping;
}

void FreeAxis::halt() {
  rest_at(state_.position);
}

Status FreeAxis::place(double position) {
  if (!std::isfinite(position)) return not_finite;
  if (std::fabs(position) > Precision::largest) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "an axis is given a position that is too far to be computed",
                 .remedy = "use larger units"};
  }
  if (!is_resting()) {
    return Error{.code = ErrorCode::wrong_state,
                 .what = "an axis that moves is given a position",
                 .remedy = "wait until it rests"};
  }
  rest_at(position);
  return Done{};
}

Status FreeAxis::set_range(double min, double max) {
  if (const Status range = check_range(min, max); !range) return range;
  if (!is_resting()) {
    return Error{.code = ErrorCode::wrong_state,
                 .what = "an axis that moves is given other soft limits",
                 .remedy = "wait until it rests"};
  }
  limits_.min = min;
  limits_.max = max;
  return Done{};
}

void FreeAxis::rest_at(double position) {
  state_ = {.position = position};
  from_ = position;
  end_ = position;
  activity_ = Activity::resting;
}

Setpoint FreeAxis::tick() {
  if (is_resting()) return state_;
  ++ticks_;
  const double seconds = static_cast<double>(ticks_) * tick_s_;
  if (seconds - rise_.seconds() - even_s_ >= fall_.seconds()) {
    rest_at(end_);
  } else {
    state_ = at(seconds);
    state_.position = inside(state_.position);
  }
  return state_;
}

Setpoint FreeAxis::at(double seconds) const {
  const auto along = [](const SpeedRamp& ramp, double begin, double end, double t) {
    const RampState state = ramp.at(t);
    return Setpoint{(state.to_end ? end : begin) + state.distance, state.velocity, state.acceleration};
  };
  if (seconds < rise_.seconds()) return along(rise_, from_, risen_, seconds);
  const double even = seconds - rise_.seconds();
  const double velocity = rise_.to_velocity();
  if (even < even_s_) return {risen_ + velocity * even, velocity, 0};
  return along(fall_, end_ - fall_.distance(), end_, even - even_s_);
}

/// Rounding alone could pass a soft limit, by the last bits of a position. This does not put an axis inside
/// that began outside.
double FreeAxis::inside(double position) const {
  return std::clamp(position, std::min(limits_.min, from_), std::max(limits_.max, from_));
}

}  // namespace inbetween
