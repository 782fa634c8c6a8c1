// Stepper drives under the motion loop: what reaches the shafts is the plan, step by step.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "host_tools/check/planned_stops.hpp"
#include "host_tools/loop/loop_storage.hpp"
#include "inbetween/loop/motion_loop.hpp"
#include "inbetween/steps/step_port.hpp"
#include "sim/simulated_rig.hpp"
#include "sim/simulated_step_chip.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/simulated_lines.hpp"

namespace inbetween {
namespace step_loop_test {

using State = SupervisorState;

constexpr std::int32_t rate_hz = 250;
constexpr std::int64_t tick_ns = 4'000'000;
constexpr double tick_s = 1.0 / 250;

const std::string slide_and_turn = R"(name = "slide and turn"
fps = 24
frames = 120
[[track]]
axes = ["slide", "turn"]
keys = [ { at = [10, 100] }, { at = [40, 130] }, { at = [5, 160] } ]
speed = [0, 0, 10, 0, 0]
)";

const std::string slider_rig = rig_text(
    {{.name = "slide",
      .max = 100,
      .max_velocity = 600,
      .max_acceleration = 4000,
      .more = "max_jerk = 80000",
      .drive =
          R"(type = "step-dir", chip = "io", step = 0, dir = 1, enable = 2, steps_per_unit = -80, max_step_rate = 60000)"},
     {.name = "turn",
      .unit = "deg",
      .min = 0,
      .max_velocity = 600,
      .max_acceleration = 4000,
      .more = "max_jerk = 80000",
      .drive =
          R"(type = "step-dir", chip = "io", step = 3, dir = 4, steps_per_unit = 9, max_step_rate = 10000)"}},
    {.name = "slider", .rate_hz = 250});

using Port = StepPort<SimulatedStepChip>;

/// Two motors on one chip, with an ENABLE line that is low while they are on.
struct Slider {
  Plan plan{parse_move(slide_and_turn, "move.toml"), parse_rig(slider_rig, "rig.toml"), {}};
  PlannedStops stops{plan};
  Playhead playhead{plan.played(), *stops.bounds(), 250};
  std::vector<std::size_t> drive_of{0, 1};
  std::array<double, 2> steps_per_unit{-80, 9};
  SimulatedStepChip chip;
  std::array<StepLines, 2> wires{};
  std::vector<StepLane> lanes;
  std::vector<std::vector<StepEdge>> edges;
  std::vector<EdgeInstant> instants;
  std::vector<StepChip<SimulatedStepChip>> chips;
  std::vector<StepLaneState> states{2};
  std::vector<std::span<const StepEdge>> lists{2};
  std::vector<Port> ports;
  SimulatedLines lines;
  LoopStorage room{2, 2};
  std::vector<MotionLoop<Port, SimulatedLines>> loops;
  std::int64_t now_ns = 1'000'000'000;

  Slider() {
    EXPECT_TRUE(stops.bounds()) << "the move is beyond the limits of its rig";
    const StepTiming timing{.pulse_ns = 5000, .pause_ns = 5000, .dir_setup_ns = 5000, .dir_hold_ns = 5000};
    wires = {{{0, 1, timing}, {3, 4, timing}}};
    std::size_t room_for_instants = 1;
    for (std::size_t i = 0; i < 2; ++i) {
      auto generator =
          StepGenerator::make({steps_per_unit[i], timing, i == 0 ? 60'000.0 : 10'000.0, tick_ns}).value();
      edges.emplace_back(generator.max_edges());
      room_for_instants += edges.back().size();
      lanes.push_back({.generator = generator, .edges = {}});
      const double at = i == 0 ? 10 : 100;
      chip.add(
          SimulatedStepper::make({.lines = wires[i], .steps_per_unit = steps_per_unit[i], .torque = {}}, at)
              .value());
    }
    for (std::size_t i = 0; i < 2; ++i) lanes[i].edges = edges[i];
    instants.resize(room_for_instants);
    chips.push_back({&chip, StepMerge::make(wires).value(), wires, 0, 2, 0b100, 0, instants});
    ports.push_back(Port::make(lanes, chips, states, lists, {rate_hz, tick_ns, 500'000}).value());
    EXPECT_TRUE(port().place(0, 10));
    EXPECT_TRUE(port().place(1, 100));
    loops.emplace_back(port(), lines, room.memory());
    EXPECT_TRUE(loop().load({&plan.motion(), &playhead, drive_of, plan.limits(), tick_s}));
  }
  Slider(const Slider&) = delete;
  Slider& operator=(const Slider&) = delete;

  Port& port() { return ports.front(); }
  MotionLoop<Port, SimulatedLines>& loop() { return loops.front(); }
  void tick(int count = 1, std::int64_t late_ns = 0) {
    for (int i = 0; i < count; ++i) {
      now_ns += tick_ns;
      chip.run(now_ns + late_ns);
      loop().tick(1, now_ns + late_ns);
    }
  }
  bool tick_until(State state, int most = 5000) {
    for (int i = 0; i < most && loop().state() != state; ++i) tick();
    return loop().state() == state;
  }
  void start() {
    ASSERT_TRUE(loop().post(SupervisorEvent::arm));
    ASSERT_TRUE(tick_until(State::ready));
    ASSERT_TRUE(loop().start(Direction::forward));
  }
  [[nodiscard]] std::int64_t steps_at(std::size_t axis, double position) const {
    return static_cast<std::int64_t>(std::floor(position * steps_per_unit[axis] + 0.5));
  }
  [[nodiscard]] bool stands_where_it_was_told() const {
    const std::vector<double> told = room.targets();
    return steps_at(0, chip.stepper(0).position()) == steps_at(0, told[0]) &&
           steps_at(1, chip.stepper(1).position()) == steps_at(1, told[1]);
  }
  void expect_no_violations() const {
    EXPECT_EQ(chip.stepper(0).violations(), StepViolations{});
    EXPECT_EQ(chip.stepper(1).violations(), StepViolations{});
  }
};

TEST(StepLoop, DrivesThatAreSwitchedOnBeforeTheFirstTickAreSoAfterIt) {
  Slider slider;
  ASSERT_TRUE(slider.loop().post(SupervisorEvent::arm));
  EXPECT_EQ(slider.chip.waiting(), 0U) << "nobody knows for when";
  slider.now_ns += tick_ns;
  slider.loop().tick(1, slider.now_ns);
  ASSERT_EQ(slider.chip.waiting(), 1U);
  slider.chip.run(slider.now_ns);
  EXPECT_EQ(slider.chip.waiting(), 1U) << "it is still to come";
  EXPECT_TRUE(slider.tick_until(State::ready));
}

TEST(StepLoop, EveryShaftStandsOnTheRoundedSetpointTwoTicksLater) {
  Slider slider;
  slider.start();
  std::vector<double> before = slider.room.targets();
  std::vector<double> before_that = before;
  for (int i = 0; slider.loop().state() == State::running && i < 2000; ++i) {
    slider.tick();
    // What was written a tick ago begins now; what was written before that has been made.
    for (std::size_t axis = 0; axis < 2; ++axis) {
      ASSERT_EQ(slider.steps_at(axis, slider.chip.stepper(axis).position()),
                slider.steps_at(axis, before_that[axis]))
          << i << " " << axis;
    }
    before_that = before;
    before = slider.room.targets();
  }
  EXPECT_EQ(slider.loop().state(), State::ready);
  slider.tick(3);
  EXPECT_DOUBLE_EQ(slider.chip.stepper(0).position(), 5);
  EXPECT_NEAR(slider.chip.stepper(1).position(), 160, 0.5 / 9);
  EXPECT_TRUE(slider.stands_where_it_was_told());
  EXPECT_FALSE(slider.states[0].has_lost_steps);
  slider.expect_no_violations();
}

TEST(StepLoop, EnableIsActiveFromArmingToDisarming) {
  Slider slider;
  EXPECT_EQ(slider.chip.levels() & 0b100U, 0U);
  ASSERT_TRUE(slider.loop().post(SupervisorEvent::arm));
  ASSERT_TRUE(slider.tick_until(State::ready));
  EXPECT_EQ(slider.chip.levels() & 0b100U, 0U) << "it is low while they are on";
  ASSERT_TRUE(slider.loop().post(SupervisorEvent::disarm));
  slider.tick(3);
  EXPECT_EQ(slider.chip.levels() & 0b100U, 0b100U);
  EXPECT_EQ(slider.chip.stepper(0).count(), 0) << "no step was made";
}

TEST(StepLoop, AControlledStopLosesNoStep) {
  Slider slider;
  slider.start();
  slider.tick(200);
  ASSERT_TRUE(slider.loop().post(SupervisorEvent::stop));
  ASSERT_TRUE(slider.tick_until(State::latched));
  slider.tick(3);
  EXPECT_TRUE(slider.stands_where_it_was_told());
  const double rest = slider.chip.stepper(0).position();
  slider.tick(200);
  EXPECT_EQ(slider.chip.stepper(0).position(), rest) << "no motion after a stop";
  EXPECT_FALSE(slider.states[0].has_lost_steps);
}

// docs/faults.md 32
TEST(StepLoop, AnEmergencyStopEndsTheStepsWithinATickAndThePositionIsLost) {
  Slider slider;
  slider.start();
  slider.tick(200);
  slider.lines.is_pressed = true;
  slider.tick();
  const std::int64_t count = slider.chip.stepper(0).count();
  slider.tick(100);
  EXPECT_EQ(slider.chip.stepper(0).count(), count);
  EXPECT_EQ(slider.loop().state(), State::faulted);
  EXPECT_TRUE(slider.states[0].has_lost_steps);
  EXPECT_TRUE(slider.states[1].has_lost_steps);
}

// docs/faults.md 34
TEST(StepLoop, AChipThatIsRemovedEndsTheSetpointsOfAllAxes) {
  Slider slider;
  slider.start();
  slider.tick(200);
  slider.chip.remove();
  slider.tick(2);
  EXPECT_EQ(slider.loop().state(), State::faulted);
  EXPECT_FALSE(slider.loop().post(SupervisorEvent::start));
}

// docs/faults.md 36
TEST(StepLoop, ATickThatLeavesAGapInTheStepsIsAControlledStop) {
  Slider slider;
  slider.start();
  slider.tick(200);
  slider.tick(1, tick_ns + 600'000);
  slider.now_ns += tick_ns + 600'000;
  slider.tick();
  EXPECT_EQ(slider.loop().state(), State::stopping);
  EXPECT_EQ(slider.port().gaps(), 1U);
  for (int i = 0; i < 500 && slider.loop().state() == State::stopping; ++i) slider.tick();
  slider.tick(3);
  EXPECT_FALSE(slider.states[0].has_lost_steps);
  slider.expect_no_violations();
}

TEST(StepLoop, MoreStepsThanTheRatePermitsAreAFaultOfThatAxisAndStopAll) {
  Slider slider;
  slider.start();
  slider.tick(200);
  // The generator of the first axis is told another scale than the plan was checked with.
  slider.lanes[0].generator =
      StepGenerator::make({-800, slider.lanes[0].generator.spec().timing, 60'000, tick_ns}).value();
  slider.tick(2);
  EXPECT_EQ(slider.loop().state(), State::stopping);
  EXPECT_TRUE(slider.states[0].has_lost_steps);
  EXPECT_FALSE(slider.states[1].has_lost_steps);
}

TEST(StepPort, WrongSizesAreRefused) {
  Slider slider;
  const StepPortTiming timing{rate_hz, tick_ns, 1};
  EXPECT_EQ(Port::make(slider.lanes, slider.chips, {}, slider.lists, timing).error().code,
            ErrorCode::wrong_count);
  EXPECT_EQ(Port::make(slider.lanes, slider.chips, slider.states, slider.lists, {rate_hz, 0, 1}).error().code,
            ErrorCode::out_of_range);
  slider.chips[0].instants = {};
  EXPECT_EQ(Port::make(slider.lanes, slider.chips, slider.states, slider.lists, timing).error().code,
            ErrorCode::capacity);
  slider.lanes[1].edges = {};
  EXPECT_EQ(Port::make(slider.lanes, slider.chips, slider.states, slider.lists, timing).error().axis, 1);
}

}  // namespace step_loop_test
}  // namespace inbetween
