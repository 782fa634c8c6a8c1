#include "inbetween/steps/step_generator.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "tests/support/step_run.hpp"

namespace inbetween {
namespace step_generator_test {

constexpr std::int64_t tick_ns = 1'000'000;
constexpr StepTiming timing{
    .pulse_ns = 3000, .pause_ns = 4000, .dir_setup_ns = 20'000, .dir_hold_ns = 10'000};
constexpr StepSpec spec{.steps_per_unit = 1, .timing = timing, .max_step_rate = 100'000, .tick_ns = tick_ns};

constexpr StepEdge rise(std::int64_t at_ns) {
  return {.at_ns = at_ns, .line = StepLine::step, .level = true};
}
constexpr StepEdge fall(std::int64_t at_ns) {
  return {.at_ns = at_ns, .line = StepLine::step, .level = false};
}
constexpr StepEdge dir(std::int64_t at_ns, bool level) {
  return {.at_ns = at_ns, .line = StepLine::dir, .level = level};
}
using Edges = std::vector<StepEdge>;

Edges edges_of_tick(StepRun& run, const Setpoint& end) {
  EXPECT_TRUE(run.tick(end));
  return {run.last_tick.begin(), run.last_tick.end()};
}
/// A parabola of 8 `height` u (1 - u) / 2 steps over one tick, back to where it began.
Setpoint thrown(double position, double height) {
  return {position, -4 * height * 1e3, -8 * height * 1e6};
}

TEST(StepGenerator, StepsWhereTheMotionPassesHalfAStep) {
  StepRun run(spec);
  ASSERT_TRUE(run.tick({0, 2000, 0}));  // takes up the speed of two steps a tick
  EXPECT_TRUE(run.generator.direction());
  const Edges expected{rise(250'000), fall(253'000), rise(750'000), fall(753'000)};
  EXPECT_EQ(edges_of_tick(run, {2, 2000, 0}), expected);
  EXPECT_EQ(run.generator.count(), 2);
  EXPECT_EQ(edges_of_tick(run, {4, 2000, 0}), expected);
  EXPECT_EQ(run.generator.count(), 4);
  EXPECT_EQ(run.generator.delays(), StepDelays{});
}

TEST(StepGenerator, DirIsHighWhereTheCountGrowsWhateverTheSignOfTheScale) {
  StepSpec backward = spec;
  backward.steps_per_unit = -1;
  StepRun run(backward);
  EXPECT_EQ(edges_of_tick(run, {0, -2000, 0}), Edges{dir(0, true)});
  EXPECT_EQ(edges_of_tick(run, {-2, -2000, 0}),
            (Edges{rise(250'000), fall(253'000), rise(750'000), fall(753'000)}));
  EXPECT_EQ(run.generator.count(), 2);
}

TEST(StepGenerator, ExactlyHalfAStepCountsUp) {
  StepRun run(spec);
  for (const auto& [position, count] :
       std::vector<std::pair<double, std::int64_t>>{{0.5, 1}, {-0.5, 0}, {1.5, 2}, {-1.5, -1}, {2.25, 2}}) {
    ASSERT_TRUE(run.generator.place(position));
    EXPECT_EQ(run.generator.count(), count) << position;
  }
  // Arriving at it from below is a step, at the very end of the tick: the next one begins with it.
  ASSERT_TRUE(run.generator.place(0));
  EXPECT_EQ(edges_of_tick(run, {0.5, 1000, 0}), Edges{dir(0, true)});
  EXPECT_EQ(run.generator.waiting(), 1);
  EXPECT_EQ(edges_of_tick(run, {0.5, 0, 0}), (Edges{rise(0), fall(3000)}));
  EXPECT_EQ(run.generator.count(), 1);
  EXPECT_EQ(run.generator.delays(), StepDelays{});
  // Leaving it downward is one back.
  ASSERT_TRUE(run.tick({0.4, 0, 0}));
  EXPECT_EQ(run.generator.count(), 0);
  // Arriving at it from above is none.
  ASSERT_TRUE(run.generator.place(1));
  ASSERT_TRUE(run.tick({0.5, 0, 0}));
  ASSERT_TRUE(run.tick({0.5, 0, 0}));
  EXPECT_EQ(run.generator.count(), 1);
}

TEST(StepGenerator, TheProductOfPositionAndScaleIsNotRoundedBeforeItIsCounted) {
  StepSpec tenths = spec;
  tenths.steps_per_unit = 0.3;  // a little below, so that 5 times it is a little below 1.5
  ASSERT_EQ(5 * tenths.steps_per_unit, 1.5);
  StepRun run(tenths);
  ASSERT_TRUE(run.generator.place(5));
  EXPECT_EQ(run.generator.count(), 1);
  ASSERT_TRUE(run.generator.place(-5));
  EXPECT_EQ(run.generator.count(), -1);
}

TEST(StepGenerator, TurnsWithinATickAndChangesDirAfterTheHold) {
  StepRun run(spec);
  ASSERT_TRUE(run.generator.place(0));
  ASSERT_TRUE(run.tick({0, 4000, -8e6}));
  ASSERT_TRUE(run.generator.direction());
  // x = 4 u (1 - u): 1/2 at u = (1 -+ sqrt(1/2)) / 2.
  const auto first = std::llround((1 - std::sqrt(0.5)) / 2 * 1e6);
  const auto second = std::llround((1 + std::sqrt(0.5)) / 2 * 1e6);
  EXPECT_EQ(edges_of_tick(run, thrown(0, 1)),
            (Edges{rise(first), fall(first + 3000), dir(first + 13'000, false), rise(second),
                   fall(second + 3000)}));
  EXPECT_EQ(run.generator.count(), 0);
  EXPECT_EQ(run.generator.delays(), StepDelays{});
}

TEST(StepGenerator, ATurnCloseToAStepWaitsForHoldAndSetUp) {
  StepRun run(spec);
  const double height = 0.5 + 1e-5;
  ASSERT_TRUE(run.tick({0, 4 * height * 1e3, -8 * height * 1e6}));
  const Edges edges = edges_of_tick(run, thrown(0, height));
  const double half_ns = std::sqrt((height - 0.5) / height) / 2 * 1e6;  // from the crossing to the turn
  const auto first = std::llround(0.5e6 - half_ns);
  const auto wanted = std::llround(0.5e6 + half_ns);
  const std::int64_t second = first + 3000 + 10'000 + 20'000;
  ASSERT_GT(second, wanted);
  EXPECT_EQ(edges, (Edges{rise(first), fall(first + 3000), dir(first + 13'000, false), rise(second),
                          fall(second + 3000)}));
  EXPECT_EQ(run.generator.delays(), (StepDelays{.late_steps = 1, .longest_ns = second - wanted}));
}

TEST(StepGenerator, StepsTooCloseTogetherKeepPulseAndPause) {
  StepSpec coarse = spec;
  coarse.timing.pulse_ns = 200'000;
  coarse.timing.pause_ns = 250'000;
  coarse.max_step_rate = 2000;
  StepRun run(coarse);
  // Two steps from rest to rest come less than 300 us apart.
  const Edges edges = edges_of_tick(run, {2, 0, 0});
  ASSERT_EQ(edges.size(), 4U);
  const std::int64_t first = edges[1].at_ns;
  EXPECT_EQ(edges, (Edges{dir(0, true), rise(first), fall(first + 200'000), rise(first + 450'000)}));
  EXPECT_EQ(edges_of_tick(run, {2, 0, 0}), Edges{fall(first + 650'000 - tick_ns)});
  EXPECT_EQ(run.generator.delays(),
            (StepDelays{.late_steps = 1, .longest_ns = first + 450'000 - (tick_ns - first)}));
}

TEST(StepGenerator, WhatDoesNotFitIntoATickComesInTheNext) {
  StepRun run(spec);
  ASSERT_TRUE(run.tick({0, 1000, 0}));
  // Crosses 1/2 a microsecond before the end: the pulse ends in the next tick.
  ASSERT_TRUE(run.tick({0.501, 1000, 0}));
  ASSERT_EQ(run.steps.size(), 1U);
  EXPECT_EQ(run.steps[0].rise_ns, 2 * tick_ns - 1000);
  EXPECT_EQ(run.generator.count(), 1);
  const Edges edges = edges_of_tick(run, {0.499, -1000, 0});
  // DIR after the hold of that pulse, and the step back in its time.
  EXPECT_EQ(edges, (Edges{fall(2000), dir(12'000, false), rise(999'000)}));
  EXPECT_EQ(run.generator.count(), 0);
}

TEST(StepGenerator, AStepDelayedOverTheEndOfATickIsNotLost) {
  StepSpec slow = spec;
  slow.timing.dir_setup_ns = 400'000;
  slow.timing.dir_hold_ns = 300'000;
  StepRun run(slow);
  const double height = 0.5 + 1e-5;
  ASSERT_TRUE(run.tick({0, 4 * height * 1e3, -8 * height * 1e6}));
  ASSERT_TRUE(run.tick(thrown(0, height)));
  EXPECT_EQ(run.generator.count(), 1);
  EXPECT_EQ(run.generator.waiting(), -1);
  EXPECT_FALSE(run.generator.direction());  // known to be needed, so changed already
  ASSERT_TRUE(run.tick({0, 0, 0}));
  ASSERT_EQ(run.steps.size(), 2U);
  EXPECT_EQ(run.steps[1].rise_ns, run.steps[0].rise_ns + 3000 + 300'000 + 400'000);
  const double half_ns = std::sqrt((height - 0.5) / height) / 2 * 1e6;  // from the crossing to the turn
  const std::int64_t wanted_ns = tick_ns + std::llround(0.5e6 + half_ns);
  EXPECT_EQ(run.generator.delays(),
            (StepDelays{.late_steps = 1, .longest_ns = run.steps[1].rise_ns - wanted_ns}));
  EXPECT_EQ(run.generator.count(), 0);
  EXPECT_EQ(run.generator.waiting(), 0);
}

TEST(StepGenerator, AStepThatWaitsUntilTheMotionComesBackIsCancelled) {
  StepSpec slow = spec;
  slow.timing.dir_setup_ns = 2'000'000;
  StepRun run(slow);
  ASSERT_TRUE(run.generator.place(0));
  // Up through 1/2, and soon down again, up again: the second and the third crossing cancel each other.
  ASSERT_TRUE(run.tick({0, 2000, 0}));
  ASSERT_TRUE(run.tick({0.6, 0, 0}));
  ASSERT_TRUE(run.tick({0.6, 0, 0}));
  ASSERT_TRUE(run.tick({0.6, 0, 0}));
  ASSERT_EQ(run.generator.count(), 1);
  ASSERT_TRUE(run.tick({0.4, 0, 0}));
  EXPECT_EQ(run.generator.waiting(), -1);
  ASSERT_TRUE(run.tick({0.6, 0, 0}));
  EXPECT_EQ(run.generator.waiting(), 0);
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(run.tick({0.6, 0, 0}));
  EXPECT_EQ(run.generator.count(), 1);
  EXPECT_EQ(run.steps.size(), 1U);
  EXPECT_EQ(run.generator.delays().cancelled_pairs, 1);
}

TEST(StepGenerator, OfTwoStepsThatWaitTheOneThatCameLastIsCancelled) {
  StepSpec slow = spec;
  slow.timing.dir_setup_ns = 4'000'000;
  StepRun run(slow);
  ASSERT_TRUE(run.generator.place(0));
  ASSERT_TRUE(run.tick({0, 2000, 0}));  // DIR changes
  ASSERT_TRUE(run.tick({2, 2000, 0}));  // steps at 1.25 and 1.75 ms, before DIR has settled
  ASSERT_EQ(run.generator.waiting(), 2);
  ASSERT_TRUE(run.tick({1, 0, 0}));
  ASSERT_EQ(run.generator.delays().cancelled_pairs, 1);
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(run.tick({1, 0, 0}));
  ASSERT_EQ(run.steps.size(), 1U);
  EXPECT_EQ(run.steps.front().rise_ns, 4'000'000);
  EXPECT_EQ(run.generator.delays().longest_ns, 4'000'000 - 1'250'000);
}

TEST(StepGenerator, DirIsNotChangedAgainBeforeItHasSettledThoughNoStepCame) {
  StepSpec slow = spec;
  slow.timing.dir_setup_ns = 2'000'000;
  StepRun run(slow);
  ASSERT_TRUE(run.generator.place(0));
  ASSERT_TRUE(run.tick({0.1, 100, 0}));
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(run.tick({0.1, -100, 0}));
  EXPECT_EQ(run.edges, (Edges{dir(0, true), dir(2'000'000, false)}));
}

TEST(StepGenerator, DirIsSetInTimeForAMotionThatBeginsAtRest) {
  StepSpec slow = spec;
  slow.timing.dir_setup_ns = 500'000;
  StepRun run(slow);
  ASSERT_TRUE(run.generator.place(0.49));
  ASSERT_TRUE(run.tick({0.49, 0, 400'000}));  // at rest, and about to go up
  ASSERT_TRUE(run.tick({0.7, 400, 400'000}));
  ASSERT_EQ(run.steps.size(), 1U);
  EXPECT_LT(run.steps.front().rise_ns, tick_ns + slow.timing.dir_setup_ns);
  EXPECT_EQ(run.generator.delays().late_steps, 0);
}

TEST(StepGenerator, DirIsSetAtTheEndOfATickInWhichTheMotionTurned) {
  StepRun run(spec);
  ASSERT_TRUE(run.tick({0, 400, -800'000}));
  ASSERT_TRUE(run.generator.direction());
  EXPECT_EQ(edges_of_tick(run, thrown(0, 0.1)), Edges{dir(0, false)});
  EXPECT_FALSE(run.generator.direction());
}

TEST(StepGenerator, ATickAtRestHasNoEdgesWhereverItRests) {
  StepRun run(spec);
  for (const double position : {0.0, 0.5, -0.5, 12345.499999, 1e9 + 0.5, -7e12}) {
    ASSERT_TRUE(run.generator.place(position));
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(edges_of_tick(run, {position, 0, 0}).empty()) << position;
    EXPECT_EQ(run.generator.count(), static_cast<std::int64_t>(std::floor(position + 0.5)));
  }
}

TEST(StepGenerator, AnAxisThatCannotBeFollowedStandsAndItsCountIsTrue) {
  StepRun run(spec);
  ASSERT_TRUE(run.generator.place(10));
  const Result<std::size_t> refused = run.tick({10 + 102, 0, 0});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::out_of_range);
  EXPECT_EQ(refused.error().needed, 102);
  EXPECT_EQ(run.generator.count(), 10);
  // There and back is refused as well.
  EXPECT_FALSE(run.tick({10, 0, 1e12}));
  EXPECT_FALSE(run.tick({10, 1e300, 0}));
  EXPECT_FALSE(run.tick({10, 0, -1e300}));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Setpoint& end : {Setpoint{nan, 0, 0}, {10, nan, 0}, {10, 0, nan}}) {
    const Result<std::size_t> not_finite = run.tick(end);
    ASSERT_FALSE(not_finite);
    EXPECT_EQ(not_finite.error().code, ErrorCode::not_finite);
  }
  EXPECT_EQ(run.tick({1e15, 0, 0}).error().code, ErrorCode::out_of_range);
  EXPECT_EQ(run.generator.place(1e15).error().code, ErrorCode::out_of_range);
  EXPECT_EQ(run.generator.place(nan).error().code, ErrorCode::not_finite);
  // Nothing of it has left a trace.
  EXPECT_TRUE(edges_of_tick(run, {10, 0, 0}).empty());
  EXPECT_EQ(run.generator.count(), 10);
  EXPECT_TRUE(run.tick({10 + 100, 0, 0}));  // a tick's worth at the highest rate
}

TEST(StepGenerator, TooLittleMemoryIsRefusedWithWhatIsNeeded) {
  auto generator = StepGenerator::make(spec).value();
  std::vector<StepEdge> small(generator.max_edges() - 1);
  const Result<std::size_t> refused = generator.advance({}, small);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::capacity);
  EXPECT_EQ(refused.error().needed, static_cast<std::int64_t>(generator.max_edges()));
}

TEST(StepGenerator, MoreWaitingStepsThanFitAreRefused) {
  StepSpec stuck = spec;
  stuck.timing.dir_setup_ns = 1'000'000'000;
  StepRun run(stuck);
  for (const double position : {5.0, 15.0, 25.0}) ASSERT_TRUE(run.tick({position, 10'000, 0}));
  EXPECT_EQ(run.generator.waiting(), 25);
  const Result<std::size_t> refused = run.tick({35, 10'000, 0});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::capacity);
  EXPECT_EQ(run.generator.waiting(), 25);
  EXPECT_EQ(run.generator.count(), 0);
}

TEST(StepGenerator, PlacingAnAxisTakesNoStepAndForgetsWhatWaited) {
  StepRun run(spec);
  ASSERT_TRUE(run.tick({0, 1000, 0}));
  ASSERT_TRUE(run.tick({0.5, 1000, 0}));
  ASSERT_EQ(run.generator.waiting(), 1);
  ASSERT_TRUE(run.generator.place(-3.25));
  EXPECT_EQ(run.generator.waiting(), 0);
  EXPECT_EQ(run.generator.count(), -3);
  EXPECT_TRUE(edges_of_tick(run, {-3.25, 0, 0}).empty());
}

TEST(StepGenerator, AFigureOutsideItsDomainIsRefused) {
  const auto code_of = [](auto change) {
    StepSpec changed = spec;
    change(changed);
    const auto made = StepGenerator::make(changed);
    EXPECT_FALSE(made);
    return made ? ErrorCode{} : made.error().code;
  };
  const double inf = std::numeric_limits<double>::infinity();
  EXPECT_EQ(code_of([](auto& s) { s.steps_per_unit = 0; }), ErrorCode::out_of_range);
  EXPECT_EQ(code_of([&](auto& s) { s.steps_per_unit = inf; }), ErrorCode::not_finite);
  EXPECT_EQ(code_of([&](auto& s) { s.max_step_rate = inf; }), ErrorCode::not_finite);
  EXPECT_EQ(code_of([](auto& s) { s.max_step_rate = 0; }), ErrorCode::out_of_range);
  EXPECT_EQ(code_of([](auto& s) { s.tick_ns = 999; }), ErrorCode::out_of_range);
  EXPECT_EQ(code_of([](auto& s) { s.tick_ns = 1'000'000'001; }), ErrorCode::out_of_range);
  EXPECT_EQ(code_of([](auto& s) { s.timing.pulse_ns = 0; }), ErrorCode::out_of_range);
  EXPECT_EQ(code_of([](auto& s) { s.timing.pause_ns = 0; }), ErrorCode::out_of_range);
  EXPECT_EQ(code_of([](auto& s) { s.timing.dir_setup_ns = 0; }), ErrorCode::out_of_range);
  EXPECT_EQ(code_of([](auto& s) { s.timing.dir_hold_ns = 1'000'000'001; }), ErrorCode::out_of_range);
  EXPECT_EQ(code_of([](auto& s) {
              s.timing = {.pulse_ns = 1, .pause_ns = 1, .dir_setup_ns = 1, .dir_hold_ns = 1};
              s.max_step_rate = 4e8;
              s.tick_ns = 1'000'000'000;
            }),
            ErrorCode::out_of_range);
}

TEST(StepGenerator, ARateThatPulseAndPauseDoNotPermitIsRefusedWithTheOneThatTheyDo) {
  StepSpec fast = spec;
  fast.max_step_rate = 142'857;  // 1e9 / 7000 is 142857.14...
  EXPECT_TRUE(check_step_rate(fast, 1.0));
  fast.max_step_rate = 142'858;
  const Status refused = check_step_rate(fast, 1.0);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::out_of_range);
  EXPECT_EQ(refused.error().needed, 142'857);
  EXPECT_FALSE(StepGenerator::make(fast));
}

TEST(StepGenerator, AVelocityThatNeedsMoreThanTheHighestRateIsRefusedWithWhatItNeeds) {
  StepSpec scaled = spec;
  scaled.steps_per_unit = -88.5;
  EXPECT_TRUE(check_step_rate(scaled, 100'000 / 88.5 - 1e-9));
  const Status refused = check_step_rate(scaled, 1130.0);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::out_of_range);
  EXPECT_EQ(refused.error().needed, 100'005);
  EXPECT_EQ(check_step_rate(scaled, std::numeric_limits<double>::infinity()).error().code,
            ErrorCode::not_finite);
}

}  // namespace step_generator_test
}  // namespace inbetween
