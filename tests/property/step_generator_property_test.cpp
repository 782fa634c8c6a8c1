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

#include "inbetween/step_generator.hpp"
#include "inbetween/step_merge.hpp"
#include "sim/simulated_stepper.hpp"
#include "tests/support/oracle_steps.hpp"
#include "tests/support/property.hpp"
#include "tests/support/step_run.hpp"

namespace inbetween {
namespace {

double between(double low, double high) {
  constexpr int places = 1'000'003;
  return low + (high - low) * (*rc::gen::inRange(0, places) / static_cast<double>(places));
}

/// At most about 40 steps a tick.
template <Precise Real>
StepSpec<Real> random_spec() {
  StepSpec<Real> spec;
  const auto time = [](int most) -> std::int64_t { return *rc::gen::inRange(100, most); };
  spec.timing = {.pulse_ns = time(5000),
                 .pause_ns = time(5000),
                 .dir_setup_ns = time(200'000),
                 .dir_hold_ns = time(100'000)};
  spec.tick_ns = *rc::gen::element<std::int64_t>(250'000, 1'000'000, 4'000'000);
  const double most = std::min(1e9 / static_cast<double>(least_period_ns(spec.timing)),
                               40e9 / static_cast<double>(spec.tick_ns));
  spec.max_step_rate = static_cast<Real>(0.999 * most * between(0.05, 1));
  const double scale = std::pow(10.0, between(-1, 3));
  spec.steps_per_unit = static_cast<Real>(*rc::gen::arbitrary<bool>() ? scale : -scale);
  return spec;
}

/// A setpoint one tick behind another, so that the motion between them may turn several times.
template <Precise Real>
Setpoint<Real> random_next(const Setpoint<Real>& at, const StepSpec<Real>& spec) {
  const double seconds = static_cast<double>(spec.tick_ns) * 1e-9;
  const double speed = 0.8 * double{spec.max_step_rate} / std::fabs(double{spec.steps_per_unit});
  if (*rc::gen::inRange(0, 6) == 0) return {at.position, 0, 0};
  const double slowness = *rc::gen::inRange(0, 3) == 0 ? 0.02 : 1;
  const double velocity = slowness * between(-speed, speed);
  const double acceleration = slowness * between(-speed, speed) * 3 / seconds;
  const double way = seconds * ((double{at.velocity} + velocity) / 2 + slowness * between(-speed, speed) / 5);
  return {static_cast<Real>(double{at.position} + way), static_cast<Real>(velocity),
          static_cast<Real>(acceleration)};
}

/// In steps and ticks.
template <Precise Real>
OracleMotion scaled(const Setpoint<Real>& at, const StepSpec<Real>& spec) {
  const long double scale = spec.steps_per_unit;
  const long double seconds = static_cast<long double>(spec.tick_ns) * 1e-9L;
  return {at.position * scale, at.velocity * scale * seconds, at.acceleration * scale * seconds * seconds};
}
template <Precise Real>
std::int64_t nearest_step(Real position, const StepSpec<Real>& spec) {
  return static_cast<std::int64_t>(
      std::floor(static_cast<long double>(position) * spec.steps_per_unit + 0.5L));
}

/// A crossing in nanoseconds from the first tick.
struct Wanted {
  long double at_ns = 0;
  long double steps_per_tick = 0;
  bool up = false;
  std::int64_t tick_start_ns = 0;
};

/// A generator on a random motion, and what the oracle says of it.
template <Precise Real>
struct RandomRun {
  explicit RandomRun(const StepSpec<Real>& spec) : run(spec) {}

  /// False if it was refused; then nothing has changed.
  bool tick(const Setpoint<Real>& end) {
    const std::int64_t start_ns = run.start_ns;
    const std::int64_t before = run.generator.count() + run.generator.waiting();
    const Result<std::size_t> done = run.tick(end);
    const StepSpec<Real>& spec = run.generator.spec();
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
    const StepSpec<Real>& spec = run.generator.spec();
    at = {.position = static_cast<Real>((between(-3000, 3000) + 0.123456789) / double{spec.steps_per_unit})};
    RC_ASSERT(run.generator.place(at.position).has_value());
    first_count = run.generator.count();
    for (int i = 0; i < ticks; ++i) {
      const std::optional<Setpoint<Real>> next = random_next(at, spec);
      if (!tick(*next)) ++refused;
    }
    while (!tick({at.position, at.velocity / 2, 0})) at.velocity /= 2;
    for (int i = 0; i < 4 || run.generator.waiting() != 0; ++i) {
      RC_ASSERT(i < 20);
      RC_ASSERT(tick({at.position, 0, 0}));
    }
  }

  StepRun<Real> run;
  Setpoint<Real> at;
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
template <Precise Real>
SimulatedStepper driven(const RandomRun<Real>& random) {
  SimulatedStepper::Settings settings;
  settings.lines = {.step = 0, .dir = 1, .timing = random.run.generator.spec().timing};
  settings.steps_per_unit = random.run.generator.spec().steps_per_unit;
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
    RandomRun<double> random(random_spec<double>());
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
    late += static_cast<int>(random.run.generator.delays().late_steps);
  });
  std::cout << compared << " steps compared, " << late << " late; " << refused << " ticks refused, "
            << cancelled << " runs with cancelled steps\n";
  if (counts_mean_something()) {
    EXPECT_GT(compared, 10'000);
    EXPECT_GT(late, 50);
    EXPECT_LT(cancelled, 100);
  }
}

TEST(StepGeneratorProperties, SinglePrecisionKeepsTheSamePromiseToItsDigits) {
  check_property(200, [] {
    RandomRun<float> random(random_spec<float>());
    random.play(40);
    const StepSpec<float>& spec = random.run.generator.spec();
    const SimulatedStepper stepper = driven(random);
    RC_ASSERT(stepper.violations() == StepViolations{});
    RC_ASSERT(stepper.count() == random.run.generator.count() - random.first_count);
    RC_ASSERT(random.run.generator.count() == nearest_step(random.at.position, spec));
    // A turn within rounding of a half step may be a pair of steps for one and none for the other.
    if (random.run.generator.delays().cancelled_pairs > 0) return;
    if (random.run.steps.size() != random.wanted.size()) return;
    for (std::size_t i = 0; i < random.wanted.size(); ++i) {
      const Wanted& wanted = random.wanted[i];
      if (wanted.steps_per_tick < 0.25L) continue;
      // 40 steps a tick to a few times 2^-24.
      const long double tolerance_ns =
          1 + 1e-4L / wanted.steps_per_tick * static_cast<long double>(spec.tick_ns);
      check_step(random.run.steps[i], wanted, spec.timing, tolerance_ns);
    }
  });
}

TEST(StepGeneratorProperties, AMotionThatTremblesAboutAHalfStepKeepsTheMinimaAndTheCount) {
  std::int64_t cancelled = 0;
  check_property(100, [&] {
    StepSpec<double> spec = random_spec<double>();
    spec.timing.dir_setup_ns *= 10;
    spec.timing.dir_hold_ns *= 10;
    RandomRun<double> random(spec);
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

TEST(StepGeneratorProperties, MergedEdgesKeepTheMinimaOfEveryAxisAndAreAtMostAGrainLate) {
  std::size_t edge_count = 0;
  std::size_t instant_count = 0;
  check_property(200, [&] {
    constexpr std::size_t axes = 4;
    const std::int64_t tick_ns = 1'000'000;
    const std::int64_t grain_ns = *rc::gen::element<std::int64_t>(0, 1000, 10'000, 50'000);
    std::vector<StepRun<double>> runs;
    std::vector<StepLines> lines;
    std::vector<SimulatedStepper> steppers;
    std::vector<Setpoint<double>> at(axes);
    for (std::size_t i = 0; i < axes; ++i) {
      StepSpec<double> spec = random_spec<double>();
      spec.tick_ns = tick_ns;
      spec.max_step_rate = std::min(spec.max_step_rate, 40e3);
      const auto first = static_cast<std::int32_t>(63 - 2 * i);
      lines.push_back({.step = first, .dir = first - 1, .timing = spec.timing});
      runs.emplace_back(spec);
      SimulatedStepper::Settings settings;
      settings.lines = lines.back();
      settings.steps_per_unit = spec.steps_per_unit;
      steppers.push_back(SimulatedStepper::make(settings, 0).value());
    }
    const StepMerge merge = StepMerge::make(lines, grain_ns).value();
    std::vector<StepInstant> memory(4000);
    std::int64_t last_ns = -1;
    for (int tick = 0; tick < 25; ++tick) {
      std::vector<std::span<const StepEdge>> edges(axes);
      for (std::size_t i = 0; i < axes; ++i) {
        const Setpoint<double> next = random_next(at[i], runs[i].generator.spec());
        if (!runs[i].tick(next)) continue;
        at[i] = next;
        edges[i] = runs[i].last_tick;
        edge_count += edges[i].size();
      }
      const std::int64_t start_ns = tick * tick_ns;
      const std::size_t size = merge.merge(start_ns, edges, memory).value();
      instant_count += size;
      std::vector<std::size_t> next(axes, 0);
      for (const StepInstant& instant : std::span(memory).first(size)) {
        RC_ASSERT(instant.at_ns > last_ns);
        RC_ASSERT(instant.at_ns < start_ns + tick_ns);
        RC_ASSERT(instant.mask != 0U);
        RC_ASSERT((instant.levels & ~instant.mask) == 0U);
        last_ns = instant.at_ns;
        for (std::size_t i = 0; i < axes; ++i) {
          RC_ASSERT(steppers[i].take(instant).has_value());
          const std::uint64_t step = std::uint64_t{1} << lines[i].step;
          const std::uint64_t dir = std::uint64_t{1} << lines[i].dir;
          if ((instant.mask & (step | dir)) == 0) continue;
          RC_ASSERT(next[i] < edges[i].size());
          const StepEdge& edge = edges[i][next[i]++];
          const std::uint64_t bit = edge.line == StepLine::step ? step : dir;
          RC_ASSERT((instant.mask & (step | dir)) == bit);
          RC_ASSERT(((instant.levels & bit) != 0) == edge.level);
          RC_ASSERT(instant.at_ns >= start_ns + edge.at_ns);
          RC_ASSERT(instant.at_ns <= start_ns + edge.at_ns + grain_ns);
        }
      }
      for (std::size_t i = 0; i < axes; ++i) RC_ASSERT(next[i] == edges[i].size());
    }
    for (std::size_t i = 0; i < axes; ++i) {
      RC_ASSERT(steppers[i].violations() == StepViolations{});
      RC_ASSERT(steppers[i].count() == runs[i].generator.count());
    }
  });
  std::cout << edge_count << " edges in " << instant_count << " instants\n";
  if (counts_mean_something()) {
    EXPECT_LT(instant_count * 100, edge_count * 99);
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
    const long double omega = two_pi * swing.hertz;
    const long double s = std::sin(omega * seconds);
    const long double c = std::cos(omega * seconds);
    const long double amplitude = swing.amplitude;
    at.position += amplitude * s * s * s;
    at.velocity += 3 * amplitude * omega * s * s * c;
    at.acceleration += 3 * amplitude * omega * omega * s * (2 * c * c - s * s);
  }
  return at;
}
template <Precise Real>
Setpoint<Real> rounded(const OracleMotion& at) {
  return {static_cast<Real>(at.position), static_cast<Real>(at.velocity), static_cast<Real>(at.acceleration)};
}

struct Deviation {
  std::size_t steps = 0;
  long double fast_ns = 0;  ///< the largest where the motion is faster than asked
  long double any_ns = 0;   ///< the largest of all
};

/// Ten seconds of a motion that the generator knows only at its ticks, against the motion itself.
template <Precise Real>
Deviation deviation(std::span<const Swing> swings, long double fast_steps_per_s) {
  StepSpec<Real> spec{.steps_per_unit = 1,
                      .timing = {.pulse_ns = 1, .pause_ns = 1, .dir_setup_ns = 1, .dir_hold_ns = 1},
                      .max_step_rate = 40'000,
                      .tick_ns = 1'000'000};
  StepRun<Real> run(spec);
  constexpr int ticks = sanitized ? 1000 : 10'000;
  for (int i = 1; i <= ticks; ++i) {
    EXPECT_TRUE(run.tick(rounded<Real>(swung(swings, i * 1e-3L))));
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
  const Deviation found = deviation<double>(swings, 0.25L);
  EXPECT_GT(found.steps, sanitized ? 5000U : 50'000U);
  EXPECT_LE(found.fast_ns, 2);
  EXPECT_LE(found.any_ns, 1000);
}

TEST(StepGeneratorProperties, StepsOfASmoothMotionAreWithinAMicrosecondInSinglePrecisionWhereItIsFast) {
  const std::vector<Swing> swings{{800, 2}, {300, 3.1}, {50, 7.3}};
  const Deviation found = deviation<float>(swings, 250);
  EXPECT_GT(found.steps, sanitized ? 5000U : 50'000U);
  EXPECT_LE(found.fast_ns, 1000);
}

TEST(StepGeneratorProperties, TheCountIsExactAfterTenMillionSteps) {
  const StepSpec<double> spec{
      .steps_per_unit = -123.456789,
      .timing = {.pulse_ns = 1000, .pause_ns = 1000, .dir_setup_ns = 5000, .dir_hold_ns = 2000},
      .max_step_rate = 400'000,
      .tick_ns = 1'000'000};
  const std::vector<Swing> swings{{100, 2}, {10, 7.7}, {0.01, 41}};
  StepGenerator<double> generator = StepGenerator<double>::make(spec).value();
  std::vector<StepEdge> edges(generator.most_edges());
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
    Setpoint<double> end = rounded<double>(swung(swings, seconds));
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

}  // namespace
}  // namespace inbetween
