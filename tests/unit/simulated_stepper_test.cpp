#include "sim/simulated_stepper.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace inbetween {
namespace simulated_stepper_test {

constexpr std::int32_t step_line = 5;
constexpr std::int32_t dir_line = 9;
constexpr std::uint64_t step_bit = std::uint64_t{1} << step_line;
constexpr std::uint64_t dir_bit = std::uint64_t{1} << dir_line;
constexpr StepTiming timing{
    .pulse_ns = 3000, .pause_ns = 4000, .dir_setup_ns = 20'000, .dir_hold_ns = 10'000};

SimulatedStepper::Settings plain_settings() {
  SimulatedStepper::Settings settings;
  settings.lines = {.step = step_line, .dir = dir_line, .timing = timing};
  settings.steps_per_unit = 10;
  return settings;
}

/// 0.5 Nm at rest, 0.1 Nm at 4000 steps/s; 1e-5 kg m^2 and 0.05 Nm of friction.
SimulatedStepper::Settings settings_with_torque() {
  SimulatedStepper::Settings settings = plain_settings();
  settings.inertia_kg_m2 = 1e-5;
  settings.friction_nm = 0.05;
  settings.start_rate = 300;
  for (const TorquePoint& point : {TorquePoint{0, 0.5}, TorquePoint{4000, 0.1}})
    EXPECT_TRUE(settings.torque.push_back(point));
  return settings;
}

/// A stepper and somebody who moves its lines.
class Bench {
 public:
  explicit Bench(const SimulatedStepper::Settings& settings, double position = 0)
      : stepper(SimulatedStepper::make(settings, position).value()) {}

  void set(std::int64_t at_ns, std::uint64_t levels, std::uint64_t mask) {
    ASSERT_TRUE(stepper.take({.at_ns = at_ns, .levels = levels, .mask = mask}));
  }
  void pulse(std::int64_t at_ns) {
    set(at_ns, step_bit, step_bit);
    set(at_ns + timing.pulse_ns, 0, step_bit);
  }
  /// `count` steps from `from` to `to` steps/s at a constant acceleration.
  void ramp(double from, double to, int count) {
    for (int i = 0; i < count; ++i) {
      const double share = (i + 0.5) / count;
      now_s += 1 / std::sqrt(std::lerp(from * from, to * to, share));
      pulse(std::llround(now_s * 1e9));
    }
  }

  SimulatedStepper stepper;
  double now_s = 0.001;
};

TEST(SimulatedStepper, CountsRisingEdgesInTheDirectionOfDir) {
  Bench bench(plain_settings(), 7);
  bench.set(0, dir_bit, dir_bit);
  for (int i = 1; i <= 3; ++i) bench.pulse(i * 100'000);
  EXPECT_EQ(bench.stepper.count(), 3);
  EXPECT_DOUBLE_EQ(bench.stepper.position(), 7.3);
  bench.set(350'000, 0, dir_bit);
  for (int i = 4; i <= 8; ++i) bench.pulse(i * 100'000);
  EXPECT_EQ(bench.stepper.count(), -2);
  EXPECT_DOUBLE_EQ(bench.stepper.position(), 6.8);
  EXPECT_EQ(bench.stepper.violations(), StepViolations{});
  EXPECT_EQ(bench.stepper.lost_steps(), 0);
}

TEST(SimulatedStepper, LinesOfOthersAndLevelsThatStayDoNotConcernIt) {
  Bench bench(plain_settings());
  bench.set(0, ~(step_bit | dir_bit), ~(step_bit | dir_bit));
  bench.set(10, step_bit, step_bit);
  bench.set(20, step_bit, step_bit);
  bench.set(30, dir_bit | step_bit, 0);
  bench.set(40, step_bit, step_bit);
  EXPECT_EQ(bench.stepper.count(), -1);
  EXPECT_EQ(bench.stepper.violations(), StepViolations{});
}

TEST(SimulatedStepper, EveryMinimumIsWatched) {
  struct Case {
    const char* name;
    std::vector<EdgeInstant> instants;
    StepViolations expected;
  };
  const auto up = [](std::int64_t at) { return EdgeInstant{at, step_bit, step_bit}; };
  const auto down = [](std::int64_t at) { return EdgeInstant{at, 0, step_bit}; };
  const auto turn = [](std::int64_t at) { return EdgeInstant{at, dir_bit, dir_bit}; };
  const auto cases = std::vector<Case>{
      {"all just kept", {up(0), down(3000), up(7000), down(10'000), turn(20'000), up(40'000)}, {}},
      {"pulse", {up(0), down(2999)}, {.pulse = 1}},
      {"pause", {up(0), down(3000), up(6999)}, {.pause = 1}},
      {"set-up", {turn(0), up(19'999)}, {.dir_setup = 1}},
      {"hold", {up(0), down(3000), turn(12'999)}, {.dir_hold = 1}},
      {"DIR within a pulse", {up(0), turn(1'000'000)}, {.dir_hold = 1}},
      {"DIR together with a step", {{0, step_bit | dir_bit, step_bit | dir_bit}}, {.dir_setup = 1}},
      {"DIR together with a fall", {up(0), {5000, dir_bit, step_bit | dir_bit}}, {.dir_hold = 1}},
  };
  for (const Case& one : cases) {
    Bench bench(plain_settings());
    for (const EdgeInstant& instant : one.instants) ASSERT_TRUE(bench.stepper.take(instant));
    EXPECT_EQ(bench.stepper.violations(), one.expected) << one.name;
  }
}

TEST(SimulatedStepper, KeepsEveryStepWithinItsTorque) {
  // 2 pi / 200 * 1e-5 * a + 0.05 Nm: at 3000 steps/s 0.2 Nm are there, for 477'000 steps/s^2.
  Bench bench(settings_with_torque());
  bench.set(0, dir_bit, dir_bit);
  bench.ramp(200, 3000, 20);  // 223'000 steps/s^2
  bench.ramp(3000, 3000, 200);
  bench.ramp(3000, 200, 20);
  EXPECT_EQ(bench.stepper.lost_steps(), 0);
  EXPECT_EQ(bench.stepper.count(), 240);
  EXPECT_DOUBLE_EQ(bench.stepper.position(), 24);
}

TEST(SimulatedStepper, LosesStepsThatAskForMoreTorqueUntilTheyAreSlowAgain) {
  Bench bench(settings_with_torque());
  bench.set(0, dir_bit, dir_bit);
  bench.ramp(200, 3000, 8);  // 560'000 steps/s^2
  EXPECT_TRUE(bench.stepper.is_stalled());
  bench.ramp(3000, 310, 100);
  EXPECT_TRUE(bench.stepper.is_stalled());
  EXPECT_EQ(bench.stepper.stalls(), 1);
  const std::int64_t lost = bench.stepper.lost_steps();
  EXPECT_GE(lost, 100);
  bench.ramp(290, 290, 10);
  EXPECT_FALSE(bench.stepper.is_stalled());
  EXPECT_EQ(bench.stepper.lost_steps(), lost);
  EXPECT_EQ(bench.stepper.count(), 118);
  EXPECT_DOUBLE_EQ(bench.stepper.position(), static_cast<double>(118 - lost) / 10);
}

TEST(SimulatedStepper, FrictionHelpsABrake) {
  Bench bench(settings_with_torque());
  bench.set(0, dir_bit, dir_bit);
  bench.ramp(200, 3000, 30);
  bench.ramp(3000, 3000, 10);
  // 1'120'000 steps/s^2 need 0.35 Nm. At the 1200 steps/s of the last two periods there are 0.38: enough less
  // the friction, and too little with it.
  bench.ramp(3000, 200, 4);
  EXPECT_EQ(bench.stepper.lost_steps(), 0);
}

TEST(SimulatedStepper, StallsBeyondItsCurveAndWithAJumpFromRest) {
  SimulatedStepper::Settings settings = settings_with_torque();
  Bench fast(settings);
  fast.set(0, dir_bit, dir_bit);
  fast.ramp(200, 4100, 400);
  EXPECT_EQ(fast.stepper.stalls(), 1);
  Bench jump(settings);
  jump.set(0, dir_bit, dir_bit);
  jump.ramp(1000, 1000, 50);  // 700 steps/s within half a millisecond
  EXPECT_EQ(jump.stepper.stalls(), 1);
  EXPECT_EQ(jump.stepper.lost_steps(), 49);
  Bench slow_before(settings);
  slow_before.set(0, dir_bit, dir_bit);
  slow_before.ramp(100, 100, 6);
  slow_before.ramp(2000, 2000, 4);
  EXPECT_EQ(slow_before.stepper.stalls(), 1);
  Bench start(settings);
  start.set(0, dir_bit, dir_bit);
  start.ramp(299, 299, 50);
  EXPECT_EQ(start.stepper.lost_steps(), 0);
}

TEST(SimulatedStepper, ATurnAtSpeedStallsAndOneAboutASingleStepDoesNot) {
  Bench bench(settings_with_torque());
  bench.set(0, dir_bit, dir_bit);
  bench.ramp(200, 2000, 30);
  ASSERT_EQ(bench.stepper.stalls(), 0);
  bench.set(std::llround(bench.now_s * 1e9) + 100'000, 0, dir_bit);
  bench.ramp(2000, 2000, 5);
  EXPECT_EQ(bench.stepper.stalls(), 1);

  Bench trembling(settings_with_torque());
  for (int i = 0; i < 100; ++i) {
    const std::int64_t at_ns = (i + 1) * 200'000;
    trembling.set(at_ns, i % 2 == 0 ? dir_bit : 0, dir_bit);
    trembling.pulse(at_ns + 50'000);
  }
  EXPECT_EQ(trembling.stepper.lost_steps(), 0);
  EXPECT_EQ(trembling.stepper.position(), 0);
}

TEST(SimulatedStepper, FiguresOfNoMotorAndTimeThatRunsBackAreRefused) {
  const auto is_refused = [](auto change) {
    SimulatedStepper::Settings settings = settings_with_torque();
    change(settings);
    return !SimulatedStepper::make(settings, 0);
  };
  EXPECT_TRUE(is_refused([](auto& s) { s.lines.step = 64; }));
  EXPECT_TRUE(is_refused([](auto& s) { s.lines.dir = s.lines.step; }));
  EXPECT_TRUE(is_refused([](auto& s) { s.steps_per_unit = 0; }));
  EXPECT_TRUE(is_refused([](auto& s) { s.steps_per_turn = 0; }));
  EXPECT_TRUE(is_refused([](auto& s) { s.inertia_kg_m2 = -1; }));
  EXPECT_TRUE(is_refused([](auto& s) { s.friction_nm = std::numeric_limits<double>::quiet_NaN(); }));
  EXPECT_TRUE(is_refused([](auto& s) { s.torque[1].steps_per_s = 0; }));
  EXPECT_TRUE(is_refused([](auto& s) { s.torque[1].torque_nm = -1; }));
  EXPECT_TRUE(is_refused([](auto& s) { s.torque[0].steps_per_s = 301; }));
  EXPECT_TRUE(is_refused([](auto& s) { s.start_rate = 0; }));
  Bench bench(plain_settings());
  bench.set(10, 0, 0);
  EXPECT_FALSE(bench.stepper.take({.at_ns = 9, .levels = 0, .mask = step_bit}));
}

}  // namespace simulated_stepper_test
}  // namespace inbetween
