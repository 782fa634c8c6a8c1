#include "inbetween/steps/step_generator.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <span>

#include "step_crossings.hpp"

namespace inbetween {
namespace {

constexpr std::int64_t second_ns = 1'000'000'000;
constexpr std::int64_t max_steps_per_tick = std::int64_t{1} << 20;
/// More turns than a quintic has, together with the turn of a step that waits from before and the turn
/// towards the next tick.
constexpr std::size_t max_dir_edges = 8;

/// Whole numbers beyond this are as good as any.
std::int64_t whole(double rate) {
  return static_cast<std::int64_t>(std::min(rate, 1e18));
}

Status check_timing(const StepTiming& timing) {
  for (const std::int64_t time :
       {timing.pulse_ns, timing.pause_ns, timing.dir_setup_ns, timing.dir_hold_ns}) {
    if (time < 1 || time > second_ns) {
      return Error{.code = ErrorCode::out_of_range,
                   .what = "a time of the step timing is not from 1 ns to 1 s",
                   .remedy = "take pulse, pause, set-up and hold from the data sheet of the driver"};
    }
  }
  return Done{};
}

Status check_spec(const StepSpec& spec) {
  if (!std::isfinite(spec.steps_per_unit) || !std::isfinite(spec.max_step_rate)) {
    return Error{.code = ErrorCode::not_finite,
                 .what = "steps_per_unit or max_step_rate is not a finite number",
                 .remedy = "give finite numbers"};
  }
  if (spec.steps_per_unit == 0 || !(spec.max_step_rate > 0)) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "steps_per_unit is 0, or max_step_rate is not above 0",
                 .remedy = "give how many steps a unit has, and how many the motor follows in a second"};
  }
  if (spec.tick_ns < 1000 || spec.tick_ns > second_ns) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "the tick is not from 1 us to 1 s",
                 .remedy = "give the period of the loop"};
  }
  if (const Status timing = check_timing(spec.timing); !timing) return timing;
  const double permitted = 1e9 / static_cast<double>(min_period_ns(spec.timing));
  if (static_cast<double>(spec.max_step_rate) > permitted) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "max_step_rate is more than pulse and pause permit",
                 .remedy = "lower max_step_rate, or shorten pulse and pause if the driver permits it",
                 .needed = whole(std::floor(permitted))};
  }
  return Done{};
}

/// The steps that a rate permits in a tick: one more than whole periods fit in. The millionth is for a
/// whole number of periods, which rounding may have put on either side.
std::int64_t steps_per_tick(const StepSpec& spec) {
  const double periods = static_cast<double>(spec.max_step_rate) * static_cast<double>(spec.tick_ns) * 1e-9;
  return whole(std::floor(periods * (1 + 1e-6))) + 1;
}

Status check_position(double position, double steps_per_unit) {
  if (!std::isfinite(position)) {
    return Error{
        .code = ErrorCode::not_finite, .what = "a position is not a finite number", .remedy = "give one"};
  }
  if (!(std::fabs(position * steps_per_unit) <= max_step_position)) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "a position is more steps from 0 than this precision resolves",
                 .remedy = "put 0 nearer, or use fewer steps per unit"};
  }
  return Done{};
}

/// The direction in which the motion leaves a tick: 1, -1, or 0 at rest.
int heading(const Setpoint& at, double steps_per_unit) {
  const double towards = at.velocity != 0 ? at.velocity : at.acceleration;
  if (towards == 0) return 0;
  return (towards > 0) == (steps_per_unit > 0) ? 1 : -1;
}

}  // namespace

Status check_step_rate(const StepSpec& spec, double max_velocity) {
  if (const Status status = check_spec(spec); !status) return status;
  if (!std::isfinite(max_velocity)) {
    return Error{.code = ErrorCode::not_finite,
                 .what = "max_velocity is not a finite number",
                 .remedy = "give a finite number"};
  }
  const double needed = std::fabs(max_velocity * spec.steps_per_unit);
  if (needed > static_cast<double>(spec.max_step_rate)) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "max_velocity * steps_per_unit is above max_step_rate",
                 .remedy = "lower max_velocity, use fewer microsteps, or a faster step output",
                 .needed = whole(std::ceil(needed))};
  }
  return Done{};
}

/// Writes the edges of one tick in the order of time, and keeps the minima.
class StepGenerator::Writer {
 public:
  Writer(const StepSpec& spec, State& state, std::span<StepEdge> out)
      : timing_(spec.timing), tick_ns_(spec.tick_ns), state_(state), out_(out) {
    if (state_.is_high) fall();
  }

  /// The motion crosses a half step. False: too many steps wait.
  bool cross(std::int64_t at_ns, bool up) {
    put_steps_before(at_ns);
    auto& waiting = state_.waiting_since_ns;
    if (!waiting.empty() && state_.waiting_up != up) {
      // The step that came last returns first. The motor never makes either of them, and the count stays
      // right.
      ++state_.delays.cancelled_pairs;
      return waiting.erase(waiting.size() - 1).has_value();
    }
    state_.waiting_up = up;
    return waiting.push_back(at_ns).has_value();
  }

  /// The rest of the tick, after which the motion goes on to where `heading` says. Returns how many edges.
  std::size_t finish(int heading) {
    put_steps_before(tick_ns_);
    const bool is_waiting = !state_.waiting_since_ns.empty();
    // DIR turns in this tick if the next step needs it, so that its set-up time does not delay that step.
    const bool next_up = is_waiting ? state_.waiting_up : heading > 0;
    if ((is_waiting || heading != 0) && next_up != state_.direction && state_.may_turn_ns < tick_ns_) turn();
    // The times count from the start of a tick. A time that has passed need not be told apart from 0.
    state_.may_rise_ns = std::max<std::int64_t>(0, state_.may_rise_ns - tick_ns_);
    state_.may_turn_ns = std::max<std::int64_t>(0, state_.may_turn_ns - tick_ns_);
    state_.falls_at_ns -= tick_ns_;
    for (std::int64_t& since : state_.waiting_since_ns) since -= tick_ns_;
    return size_;
  }

 private:
  void put_steps_before(std::int64_t until_ns) {
    auto& waiting = state_.waiting_since_ns;
    while (!waiting.empty()) {
      const bool turns = state_.waiting_up != state_.direction;
      const std::int64_t may_rise_ns =
          turns ? std::max(state_.may_rise_ns, state_.may_turn_ns + timing_.dir_setup_ns)
                : state_.may_rise_ns;
      // A step waits until the next crossing is known: that crossing may cancel it.
      if (std::max(waiting[0], may_rise_ns) >= until_ns) return;
      if (turns) turn();
      step(waiting[0]);
      static_cast<void>(waiting.erase(0));
    }
  }
  void turn() {
    state_.direction = !state_.direction;
    put({.at_ns = state_.may_turn_ns, .line = StepLine::dir, .level = state_.direction});
    const std::int64_t settled_ns = state_.may_turn_ns + timing_.dir_setup_ns;
    state_.may_rise_ns = std::max(state_.may_rise_ns, settled_ns);
    state_.may_turn_ns = settled_ns;
  }
  void step(std::int64_t wanted_ns) {
    const std::int64_t at_ns = std::max(wanted_ns, state_.may_rise_ns);
    if (at_ns > wanted_ns) {
      ++state_.delays.late_steps;
      state_.delays.longest_ns = std::max(state_.delays.longest_ns, at_ns - wanted_ns);
    }
    put({.at_ns = at_ns, .line = StepLine::step, .level = true});
    state_.count += state_.direction ? 1 : -1;
    state_.is_high = true;
    state_.falls_at_ns = at_ns + timing_.pulse_ns;
    state_.may_rise_ns = state_.falls_at_ns + timing_.pause_ns;
    state_.may_turn_ns = state_.falls_at_ns + timing_.dir_hold_ns;
    fall();
  }
  /// If the pulse ends in this tick.
  void fall() {
    if (state_.falls_at_ns >= tick_ns_) return;
    put({.at_ns = state_.falls_at_ns, .line = StepLine::step, .level = false});
    state_.is_high = false;
  }
  void put(const StepEdge& edge) {
    if (size_ >= out_.size()) __builtin_trap();  // max_edges() promises that it does not happen
    out_[size_++] = edge;
  }

  const StepTiming& timing_;
  std::int64_t tick_ns_;
  State& state_;
  std::span<StepEdge> out_;
  std::size_t size_ = 0;
};

Result<StepGenerator> StepGenerator::make(const StepSpec& spec) {
  if (const Status status = check_spec(spec); !status) return status.error();
  const std::int64_t steps = steps_per_tick(spec);
  if (steps > max_steps_per_tick) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "max_step_rate is more than 2^20 steps a tick",
                 .remedy = "use shorter ticks or a lower rate",
                 .needed = steps};
  }
  return StepGenerator(spec, static_cast<std::int32_t>(steps));
}

Status StepGenerator::place(double position) {
  if (const Status status = check_position(position, spec_.steps_per_unit); !status) return status;
  state_.at = {.position = position};
  state_.count = step_position(position, spec_.steps_per_unit).nearest;
  state_.waiting_since_ns.clear();
  return Done{};
}

std::size_t StepGenerator::max_edges() const {
  const auto pulses = static_cast<std::size_t>(spec_.tick_ns / min_period_ns(spec_.timing)) + 1;
  // Pulses that fit into a tick bound its edges, and so do the steps of its motion with those that waited.
  const std::size_t steps = static_cast<std::size_t>(max_steps_) + max_waiting;
  return 2 * std::min(pulses, steps) + 1 + max_dir_edges;
}

Result<std::size_t> StepGenerator::advance(const Setpoint& end, std::span<StepEdge> out) {
  if (!std::isfinite(end.velocity) || !std::isfinite(end.acceleration)) {
    return Error{.code = ErrorCode::not_finite,
                 .what = "a velocity or acceleration is not a finite number",
                 .remedy = "give finite numbers"};
  }
  if (const Status status = check_position(end.position, spec_.steps_per_unit); !status)
    return status.error();
  if (out.size() < max_edges()) {
    return Error{.code = ErrorCode::capacity,
                 .what = "the memory for the edges of a tick is too small",
                 .remedy = "give max_edges() of them",
                 .needed = static_cast<std::int64_t>(max_edges())};
  }

  const auto too_many = [](std::int64_t needed) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "a tick has more steps than max_step_rate permits",
                 .remedy = "stop the rig, and plan the move with max_velocity below the step rate",
                 .needed = needed};
  };
  const StepPosition from = step_position(state_.at.position, spec_.steps_per_unit);
  const StepPosition to = step_position(end.position, spec_.steps_per_unit);
  const std::int64_t distance = to.nearest - from.nearest;
  if (distance > max_steps_ || -distance > max_steps_) return too_many(distance > 0 ? distance : -distance);
  const double tick_s = static_cast<double>(spec_.tick_ns) * 1e-9;
  const double per_tick = spec_.steps_per_unit * tick_s;
  const StepCrossings crossings(
      {from.rest, state_.at.velocity * per_tick, state_.at.acceleration * per_tick * tick_s},
      {static_cast<double>(distance) + to.rest, end.velocity * per_tick,
       end.acceleration * per_tick * tick_s},
      static_cast<std::int32_t>(distance));
  if (crossings.count() < 0) return too_many(-1);
  if (crossings.count() > max_steps_) return too_many(crossings.count());

  // The writer works on a copy, so that a refusal leaves the generator as it was.
  State next = state_;
  next.at = end;
  Writer writer(spec_, next, out);
  const auto tick = static_cast<double>(spec_.tick_ns);
  constexpr double half_a_nanosecond = 0.5;  // what is rounded so is not negative
  // An edge is rounded to a nanosecond, so a sixteenth of one suffices; a double may not resolve even that.
  const double sixteenth_ns = 1 / (16 * tick);
  const double tolerance = std::max(sixteenth_ns, 2 * std::numeric_limits<double>::epsilon());
  bool fits = true;
  crossings.visit(tolerance, [&](double u, bool up) {
    const auto at_ns = std::min(static_cast<std::int64_t>(u * tick + half_a_nanosecond), spec_.tick_ns);
    fits = fits && writer.cross(at_ns, up);
  });
  if (!fits) {
    return Error{.code = ErrorCode::capacity,
                 .what = "too many steps wait for pauses and turns of DIR",
                 .remedy = "stop the rig; plan slower turns, or shorten the set-up and hold of DIR"};
  }
  const std::size_t size = writer.finish(heading(end, spec_.steps_per_unit));
  state_ = next;
  return size;
}

}  // namespace inbetween
