#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iostream>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "inbetween/steps/step_generator.hpp"
#include "sim/simulated_stepper.hpp"
#include "tests/support/oracle_steps.hpp"
#include "tests/support/property.hpp"
#include "tests/support/random_steps.hpp"
#include "tests/support/step_run.hpp"

namespace inbetween {
namespace step_generator_property_test {

/// In steps and ticks.
OracleMotion scaled(const Setpoint& at, const StepSpec& spec) {
  const auto scale = static_cast<long double>(spec.steps_per_unit);
  const long double seconds = static_cast<long double>(spec.tick_ns) * 1e-9L;
  return {static_cast<long double>(at.position) * scale,
          static_cast<long double>(at.velocity) * scale * seconds,
          static_cast<long double>(at.acceleration) * scale * seconds * seconds};
}
std::int64_t nearest_step(double position, const StepSpec& spec) {
  const auto scale = static_cast<long double>(spec.steps_per_unit);
  return static_cast<std::int64_t>(std::floor(static_cast<long double>(position) * scale + 0.5L));
}

/// A crossing in nanoseconds from the first tick.
struct Wanted {
  long double at_ns = 0;
  long double steps_per_tick = 0;
  bool up = false;
  std::int64_t tick_start_ns = 0;
};

/// A generator on a random motion, and what the oracle says of it.
struct RandomRun {
  explicit RandomRun(const StepSpec& spec) : run(spec) {}

  /// False if it was refused; then nothing has changed.
  bool tick(const Setpoint& end) {
    const std::int64_t start_ns = run.start_ns;
    const std::int64_t before = run.generator.count() + run.generator.waiting();
    const Result<std::size_t> done = run.tick(end);
    const StepSpec& spec = run.generator.spec();
    if (!done) {
      RC_ASSERT(done.error().code == ErrorCode::out_of_range);
      RC_ASSERT(run.generator.count() + run.generator.waiting() == before);
      return false;
    }
    const OracleMotion from = scaled(at, spec);
    const OracleMotion to = scaled(end, spec);
    const auto x = [&](long double u) { return oracle_quintic(from, to, u); };
    const auto tick_ns = static_cast<long double>(spec.tick_ns);
    for (const OracleCrossing& crossing : oracle_crossings(x, 0, 1, 400))
      wanted.push_back({static_cast<long double>(start_ns) + crossing.at * tick_ns, crossing.speed,
                        crossing.up, start_ns});
    at = end;
    RC_ASSERT(run.generator.count() + run.generator.waiting() == nearest_step(end.position, spec));
    return true;
  }
  void play(int ticks) {
    const StepSpec& spec = run.generator.spec();
    at = {.position = static_cast<double>((between(-3000, 3000) + 0.123456789) /
                                          static_cast<double>(spec.steps_per_unit))};
    RC_ASSERT(run.generator.place(at.position).has_value());
    first_count = run.generator.count();
    for (int i = 0; i < ticks; ++i) {
      const std::optional<Setpoint> next = random_next(at, spec);
      if (!tick(*next)) ++refused;
    }
    while (!tick({at.position, at.velocity / 2, 0})) at.velocity /= 2;
    for (int i = 0; i < 4 || run.generator.waiting() != 0; ++i) {
      RC_ASSERT(i < 20);
      RC_ASSERT(tick({at.position, 0, 0}));
    }
  }

  StepRun run;
  Setpoint at;
  std::vector<Wanted> wanted;
  std::int64_t first_count = 0;
  int refused = 0;
};

/// The step at its crossing, or where the minima ask for it and no later.
void check_step(const PutStep& step, const Wanted& wanted, const StepTiming& timing,
                long double tolerance_ns) {
  RC_ASSERT(step.up == wanted.up);
  const auto late_ns = static_cast<long double>(step.rise_ns) - wanted.at_ns;
  RC_ASSERT(late_ns >= -tolerance_ns);
  if (late_ns <= tolerance_ns) return;
  const std::int64_t after_pause_ns = step.fall_before_ns + timing.pause_ns;
  const std::int64_t after_setup_ns = step.dir_change_ns + timing.dir_setup_ns;
  RC_ASSERT(step.rise_ns == std::max(after_pause_ns, after_setup_ns));
  if (after_setup_ns <= after_pause_ns) return;
  const std::int64_t may_turn_ns =
      std::max(step.fall_before_ns + timing.dir_hold_ns, step.dir_before_ns + timing.dir_setup_ns);
  RC_ASSERT(step.dir_change_ns <= std::max(may_turn_ns, wanted.tick_start_ns));
}

/// Runs the edges past a driver that knows the minima.
SimulatedStepper driven(const RandomRun& random) {
  SimulatedStepper::Settings settings;
  settings.lines = {.step = 0, .dir = 1, .timing = random.run.generator.spec().timing};
  settings.steps_per_unit = static_cast<double>(random.run.generator.spec().steps_per_unit);
  SimulatedStepper stepper = SimulatedStepper::make(settings, 0).value();
  for (const StepEdge& edge : random.run.edges) {
    const std::uint64_t bit = edge.line == StepLine::step ? 1 : 2;
    RC_ASSERT(stepper.take({.at_ns = edge.at_ns, .levels = edge.level ? bit : 0, .mask = bit}).has_value());
  }
  return stepper;
}

TEST(StepGeneratorProperties, EveryEdgeIsAtItsCrossingOrAsLateAsTheMinimaAsk) {
  int compared = 0;
  int late = 0;
  int refused = 0;
  int cancelled = 0;
  check_property(400, [&] {
    RandomRun random(random_spec());
    random.play(40);
    refused += random.refused;
    const SimulatedStepper stepper = driven(random);
    RC_ASSERT(stepper.violations() == StepViolations{});
    RC_ASSERT(stepper.count() == random.run.generator.count() - random.first_count);
    RC_ASSERT(random.run.generator.count() == nearest_step(random.at.position, random.run.generator.spec()));
    if (random.run.generator.delays().cancelled_pairs > 0) {
      ++cancelled;
      return;
    }
    RC_ASSERT(random.run.steps.size() == random.wanted.size());
    for (std::size_t i = 0; i < random.wanted.size(); ++i) {
      const Wanted& wanted = random.wanted[i];
      const long double tolerance_ns = wanted.steps_per_tick > 1e-3L ? 3 : 1000;
      check_step(random.run.steps[i], wanted, random.run.generator.spec().timing, tolerance_ns);
      ++compared;
    }
    const StepDelays& delays = random.run.generator.delays();
    late += static_cast<int>(delays.late_steps);
    long double longest_ns = 0;
    for (std::size_t i = 0; i < random.wanted.size(); ++i)
      longest_ns = std::max(longest_ns,
                            static_cast<long double>(random.run.steps[i].rise_ns) - random.wanted[i].at_ns);
    RC_ASSERT(std::fabs(static_cast<long double>(delays.longest_ns) - longest_ns) < 1000);
  });
  std::cout << compared << " steps compared, " << late << " late; " << refused << " ticks refused, "
            << cancelled << " runs with cancelled steps\n";
  if (counts_mean_something()) {
    EXPECT_GT(compared, 10'000);
    EXPECT_GT(late, 50);
    EXPECT_LT(cancelled, 100);
  }
}

TEST(StepGeneratorProperties, AMotionThatTremblesAboutAHalfStepKeepsTheMinimaAndTheCount) {
  std::int64_t cancelled = 0;
  check_property(100, [&] {
    StepSpec spec = random_spec();
    spec.timing.dir_setup_ns *= 10;
    spec.timing.dir_hold_ns *= 10;
    RandomRun random(spec);
    const double half = *rc::gen::inRange(-1000, 1000) + 0.5;
    random.at.position = (half + 0.1) / spec.steps_per_unit;
    RC_ASSERT(random.run.generator.place(random.at.position).has_value());
    random.first_count = random.run.generator.count();
    for (int i = 0; i < 60; ++i) {
      const double position = (half + between(-0.3, 0.3)) / spec.steps_per_unit;
      RC_ASSERT(random.tick({position, between(-1, 1) / spec.steps_per_unit, 0}));
    }
    for (int i = 0; i < 40; ++i) RC_ASSERT(random.tick({random.at.position, 0, 0}));
    RC_ASSERT(random.run.generator.waiting() == 0);
    const SimulatedStepper stepper = driven(random);
    RC_ASSERT(stepper.violations() == StepViolations{});
    RC_ASSERT(stepper.count() == random.run.generator.count() - random.first_count);
    const StepDelays& delays = random.run.generator.delays();
    RC_ASSERT(random.run.steps.size() + 2 * static_cast<std::size_t>(delays.cancelled_pairs) ==
              random.wanted.size());
    cancelled += delays.cancelled_pairs;
  });
  std::cout << cancelled << " pairs of steps cancelled\n";
  if (counts_mean_something()) {
    EXPECT_GT(cancelled, 20);
  }
}

/// A x sin^3, which starts without speed and acceleration.
struct Swing {
  double amplitude = 0;
  double hertz = 0;
};
constexpr long double two_pi = 2 * std::numbers::pi_v<long double>;

OracleMotion swung(std::span<const Swing> swings, long double seconds) {
  OracleMotion at;
  for (const Swing& swing : swings) {
    const long double omega = two_pi * static_cast<long double>(swing.hertz);
    const long double s = std::sin(omega * seconds);
    const long double c = std::cos(omega * seconds);
    const auto amplitude = static_cast<long double>(swing.amplitude);
    at.position += amplitude * s * s * s;
    at.velocity += 3 * amplitude * omega * s * s * c;
    at.acceleration += 3 * amplitude * omega * omega * s * (2 * c * c - s * s);
  }
  return at;
}
Setpoint rounded(const OracleMotion& at) {
  return {static_cast<double>(at.position), static_cast<double>(at.velocity),
          static_cast<double>(at.acceleration)};
}

struct Deviation {
  std::size_t steps = 0;
  long double fast_ns = 0;  ///< the largest where the motion is faster than asked
  long double any_ns = 0;   ///< the largest of all
};

/// Ten seconds of a motion that the generator knows only at its ticks, against the motion itself.
Deviation deviation(std::span<const Swing> swings, long double fast_steps_per_s) {
  StepSpec spec{.steps_per_unit = 1,
                .timing = {.pulse_ns = 1, .pause_ns = 1, .dir_setup_ns = 1, .dir_hold_ns = 1},
                .max_step_rate = 40'000,
                .tick_ns = 1'000'000};
  StepRun run(spec);
  constexpr int ticks = sanitized ? 1000 : 10'000;
  for (int i = 1; i <= ticks; ++i) {
    EXPECT_TRUE(run.tick(rounded(swung(swings, i * 1e-3L))));
  }
  const auto crossings =
      oracle_crossings([&](long double t) { return swung(swings, t).position; }, 0, ticks * 1e-3L, 4 * ticks);
  Deviation result;
  result.steps = crossings.size();
  EXPECT_EQ(run.steps.size(), crossings.size());
  for (std::size_t i = 0; i < std::min(crossings.size(), run.steps.size()); ++i) {
    EXPECT_EQ(run.steps[i].up, crossings[i].up);
    const long double error =
        std::fabs(static_cast<long double>(run.steps[i].rise_ns) - crossings[i].at * 1e9L);
    result.any_ns = std::max(result.any_ns, error);
    if (crossings[i].speed > fast_steps_per_s) result.fast_ns = std::max(result.fast_ns, error);
  }
  std::cout << result.steps << " steps; off by at most " << result.fast_ns << " ns above " << fast_steps_per_s
            << " steps/s, " << result.any_ns << " ns anywhere\n";
  return result;
}

TEST(StepGeneratorProperties, StepsOfASmoothMotionAreWithinAMicrosecondOfIt) {
  const std::vector<Swing> swings{{800, 2}, {300, 3.1}, {50, 7.3}};
  const Deviation found = deviation(swings, 0.25L);
  EXPECT_GT(found.steps, sanitized ? 5000U : 50'000U);
  EXPECT_LE(found.fast_ns, 2);
  EXPECT_LE(found.any_ns, 1000);
}

TEST(StepGeneratorProperties, TheCountIsExactAfterTenMillionSteps) {
  const StepSpec spec{
      .steps_per_unit = -123.456789,
      .timing = {.pulse_ns = 1000, .pause_ns = 1000, .dir_setup_ns = 5000, .dir_hold_ns = 2000},
      .max_step_rate = 400'000,
      .tick_ns = 1'000'000};
  const std::vector<Swing> swings{{100, 2}, {10, 7.7}, {0.01, 41}};
  StepGenerator generator = StepGenerator::make(spec).value();
  std::vector<StepEdge> edges(generator.max_edges());
  const double offset = 98765.4321;
  ASSERT_TRUE(generator.place(offset));
  std::int64_t count = nearest_step(offset, spec);
  std::int64_t steps = 0;
  std::int64_t turns = 0;
  bool dir = false;
  long double seconds = 0;
  const std::int64_t wanted = sanitized ? 500'000 : 10'000'000;
  for (int tick = 1; steps < wanted; ++tick) {
    const bool holds = tick % 1000 > 990;  // wherever it is
    if (!holds) seconds += 1e-3L;
    Setpoint end = rounded(swung(swings, seconds));
    end.position += offset;
    if (holds) end.velocity = end.acceleration = 0;
    const Result<std::size_t> size = generator.advance(end, edges);
    ASSERT_TRUE(size);
    for (const StepEdge& edge : std::span(edges).first(*size)) {
      if (edge.line == StepLine::dir) {
        dir = edge.level;
        ++turns;
      } else if (edge.level) {
        count += dir ? 1 : -1;
        ++steps;
      }
    }
    ASSERT_EQ(count, generator.count());
    ASSERT_EQ(count + generator.waiting(), nearest_step(end.position, spec));
  }
  EXPECT_GT(turns, sanitized ? 50 : 1000);
  std::cout << steps << " steps, " << turns << " turns, " << generator.delays().late_steps << " late, by "
            << generator.delays().longest_ns << " ns at most\n";
}

}  // namespace step_generator_property_test
}  // namespace inbetween
