#include "tests/support/oracle_stop.hpp"

#include <algorithm>
#include <cmath>

namespace inbetween::oracle {

bool StoppingPlayhead::permits(const PlayheadState& state) const {
  const PlayheadBound bound = rule_.at(state.u);
  const double room = state.change < 0 ? state.rate : rule_.highest_rate - state.rate;
  return state.rate >= 0 && room >= 0 && std::fabs(state.change) <= bound.rate_change &&
         state.change * state.change <= 2 * room * bound.release_jerk;
}

PlayheadState StoppingPlayhead::after(const PlayheadState& state, double change, double dt) const {
  const double jerk = (change - state.change) / dt;
  return {state.u + side_ * dt * (state.rate + dt * (state.change / 2 + dt * jerk / 6)),
          state.rate + dt * (state.change + change) / 2, change};
}

/// A step may pass into another cell, and use its jerk bound from its beginning.
double StoppingPlayhead::max_jerk(const PlayheadState& state, double dt) const {
  return std::max(rule_.at(state.u).rate_jerk, rule_.at(after(state, state.change, dt).u).rate_jerk);
}

void StoppingPlayhead::show(const PlayheadState& from, const PlayheadState& to, double jerk, double max_jerk,
                            const std::function<void(const PlayheadStep&)>& visit) const {
  for (const PlayheadState& state : {from, to}) {
    visit({state.u, side_ * state.rate, side_ * state.change, side_ * jerk, rule_.at(state.u).rate_change,
           max_jerk});
  }
}

double StoppingPlayhead::step(PlayheadState& state, bool speeding_up,
                              const std::function<void(const PlayheadStep&)>& visit) const {
  // So slow that it would take ages to be moved by a rounding.
  if (!speeding_up && state.change <= 0 && state.rate <= 1e-12 * rule_.highest_rate) {
    state = {state.u, 0, 0};
    return dt_;
  }
  // The last bit of a release, on which rate and change reach 0 together.
  if (!speeding_up && state.change < 0 && 2 * state.rate <= -state.change * dt_) {
    const double seconds = 2 * state.rate / -state.change;
    const PlayheadState rest{state.u + side_ * state.rate * seconds / 3, 0, 0};
    show(state, rest, -state.change / seconds, max_jerk(state, seconds), visit);
    state = rest;
    return seconds;
  }
  double dt = dt_;
  for (int halvings = 0; halvings < 40; ++halvings, dt /= 2) {
    if (try_step(state, speeding_up, dt, visit)) return dt;
  }
  return 0;
}

bool StoppingPlayhead::try_step(PlayheadState& state, bool speeding_up, double dt,
                                const std::function<void(const PlayheadStep&)>& visit) const {
  const double jerk = max_jerk(state, dt);
  const double reach = dt * (1 + 1e-6) * jerk;
  double wanted = state.change + (speeding_up ? reach : -reach);
  double gentle = std::clamp(0.0, state.change - reach, state.change + reach);
  PlayheadState next = after(state, wanted, dt);
  if (!permits(next)) {
    next = after(state, gentle, dt);
    if (!permits(next)) return false;
    for (int i = 0; i < 40; ++i) {
      const double middle = gentle + (wanted - gentle) / 2;
      const PlayheadState tried = after(state, middle, dt);
      if (permits(tried)) {
        gentle = middle;
        next = tried;
      } else {
        wanted = middle;
      }
    }
  }
  show(state, next, (next.change - state.change) / dt, jerk, visit);
  state = next;
  return true;
}

}  // namespace inbetween::oracle
