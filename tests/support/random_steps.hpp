#pragma once

#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "inbetween/steps/step_generator.hpp"

/// Random axes with STEP and DIR, and random motions for them.

namespace inbetween {

inline double between(double low, double high) {
  constexpr int places = 1'000'003;
  return low + (high - low) * (*rc::gen::inRange(0, places) / static_cast<double>(places));
}

/// At most about 40 steps a tick.
inline StepSpec random_spec() {
  StepSpec spec;
  const auto time = [](int most) -> std::int64_t { return *rc::gen::inRange(100, most); };
  spec.timing = {.pulse_ns = time(5000),
                 .pause_ns = time(5000),
                 .dir_setup_ns = time(200'000),
                 .dir_hold_ns = time(100'000)};
  spec.tick_ns = *rc::gen::element<std::int64_t>(250'000, 1'000'000, 4'000'000);
  const double most = std::min(1e9 / static_cast<double>(min_period_ns(spec.timing)),
                               40e9 / static_cast<double>(spec.tick_ns));
  spec.max_step_rate = static_cast<double>(0.999 * most * between(0.05, 1));
  const double scale = std::pow(10.0, between(-1, 3));
  spec.steps_per_unit = static_cast<double>(*rc::gen::arbitrary<bool>() ? scale : -scale);
  return spec;
}

/// A setpoint one tick behind another, so that the motion between them may turn several times.
inline Setpoint random_next(const Setpoint& at, const StepSpec& spec) {
  const double seconds = static_cast<double>(spec.tick_ns) * 1e-9;
  const double speed =
      0.8 * static_cast<double>(spec.max_step_rate) / std::fabs(static_cast<double>(spec.steps_per_unit));
  if (*rc::gen::inRange(0, 6) == 0) return {at.position, 0, 0};
  const double slowness = *rc::gen::inRange(0, 3) == 0 ? 0.02 : 1;
  const double velocity = slowness * between(-speed, speed);
  const double acceleration = slowness * between(-speed, speed) * 3 / seconds;
  const double travel = seconds * ((at.velocity + velocity) / 2 + slowness * between(-speed, speed) / 5);
  return {at.position + travel, velocity, acceleration};
}

}  // namespace inbetween
