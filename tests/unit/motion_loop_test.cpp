// The loop that moves a rig, on a simulated one: who may move when, and what happens when something fails.
#include "inbetween/loop/motion_loop.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "host_tools/check/planned_stops.hpp"
#include "host_tools/loop/loop_storage.hpp"
#include "host_tools/motions/free_axes.hpp"
#include "host_tools/plan/plan.hpp"
#include "inbetween/loop/motor_port.hpp"
#include "sim/simulated_rig.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/simulated_lines.hpp"

namespace inbetween {
namespace motion_loop_test {

using testing::ElementsAre;
using testing::HasSubstr;

const std::string glide = R"(name = "glide"
fps = 24
frames = 48
[[track]]
axes = ["pan", "track"]
keys = [ { at = [10, 100] }, { at = [20, 180] }, { at = [-5, 260] } ]
speed = [0, 0, 10, 0, 0]
)";

const std::string crane_rig =
    rig_text({axis_text("track", "mm", {0, 500}, {.velocity = 250, .acceleration = 1000, .jerk = 20000}),
              {.name = "lamp", .unit = "unit", .min = 0, .max = 1, .max_velocity = 1, .max_acceleration = 1},
              axis_text("pan", "deg", {-90, 90}, {.velocity = 120, .acceleration = 700, .jerk = 12000})},
             {.name = "crane", .rate_hz = 250});

constexpr double tick_s = 1.0 / 250;

/// A rig whose axes stand at the start of the move, the lamp at 0.25.
struct Crane {
  Plan plan{parse_move(glide, "move.toml"), parse_rig(crane_rig, "rig.toml"), {}};
  PlannedStops stops{plan};
  Playhead playhead{plan.played(), *stops.bounds(), 250};
  std::vector<std::size_t> drive_of{2, 0};
  SimulatedRig rig;
  SimulatedLines lines;
  LoopStorage room{3, 2};
  MotionLoop<SimulatedRig, SimulatedLines> loop{rig, lines, room.memory()};

  explicit Crane(const std::vector<double>& at = {100, 0.25, 10}) : rig(at) {
    EXPECT_TRUE(loop.load({&plan.motion(), &playhead, drive_of, plan.limits(), tick_s}));
  }
  void tick(int count, std::int32_t ticks = 1) {
    for (int i = 0; i < count; ++i) loop.tick(ticks, 0);
  }
  void arm() {
    EXPECT_TRUE(loop.post(SupervisorEvent::arm));
    tick(2);
    EXPECT_EQ(loop.state(), SupervisorState::ready);
  }
  /// Arms the rig, starts the move and plays so many ticks of it.
  void play(int ticks) {
    arm();
    EXPECT_TRUE(loop.post(SupervisorEvent::start));
    tick(ticks);
  }
  void run_until_rest() {
    for (int i = 0;
         i < 5000 && (loop.state() == SupervisorState::running || loop.state() == SupervisorState::stopping);
         ++i) {
      loop.tick(1, 0);
    }
  }
  [[nodiscard]] std::vector<Setpoint> moving() const {
    return {loop.setpoints().begin(), loop.setpoints().end()};
  }
  [[nodiscard]] std::vector<double> at() const { return room.targets(); }
};

TEST(MotionLoop, RunsAMoveFromArmingToItsLastFrame) {
  Crane crane;
  crane.tick(3);
  EXPECT_EQ(crane.rig.writes(), 0U) << "nothing is sent before somebody arms the rig";
  crane.arm();
  EXPECT_THAT(crane.at(), ElementsAre(100, 0.25, 10));
  ASSERT_TRUE(crane.loop.post(SupervisorEvent::start));
  std::vector<double> expected(2);
  const std::int64_t last = last_tick(48, {24, 1}, 250);
  for (std::int64_t tick = 1; tick <= last; ++tick) {
    EXPECT_EQ(crane.loop.state(), SupervisorState::running);
    crane.loop.tick(1, 0);
    crane.plan.motion().positions(frame_time_of_tick(tick, {24, 1}, 250), expected);
    ASSERT_THAT(crane.at(), ElementsAre(expected[1], 0.25, expected[0])) << tick;
  }
  EXPECT_EQ(crane.loop.state(), SupervisorState::ready);
  EXPECT_THAT(crane.at(), ElementsAre(260, 0.25, -5));
}

TEST(MotionLoop, NothingStartsThatIsNotReady) {
  Crane crane;
  EXPECT_FALSE(crane.loop.post(SupervisorEvent::start));
  EXPECT_EQ(crane.loop.state(), SupervisorState::disarmed);
  crane.arm();
  EXPECT_EQ(crane.lines.begins, 0);
  ASSERT_TRUE(crane.loop.post(SupervisorEvent::start));
  EXPECT_FALSE(crane.loop.post(SupervisorEvent::start)) << "it runs already";
  EXPECT_EQ(crane.lines.begins, 1) << "of what was begun the lines know";
  EXPECT_FALSE(crane.loop.post(SupervisorEvent::acknowledge));
  EXPECT_FALSE(
      crane.loop.load({&crane.plan.motion(), &crane.playhead, crane.drive_of, crane.plan.limits(), tick_s}));
}

// docs/faults.md 27
TEST(MotionLoop, AnAxisThatIsNotWhereTheMoveStartsIsNamedAndNothingMoves) {
  Crane crane({100, 0.25, 11});
  crane.arm();
  const Status refused = crane.loop.start(Direction::forward);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().axis, 0);
  EXPECT_THAT(refused.error().remedy, HasSubstr("go to the start slowly"));
  EXPECT_EQ(crane.loop.state(), SupervisorState::ready);
  crane.tick(10);
  EXPECT_THAT(crane.at(), ElementsAre(100, 0.25, 11)) << "the first setpoint is the actual position";
}

// docs/faults.md 40
TEST(MotionLoop, AStopLatchesAndGoesOnOnlyWhenAcknowledgedAndStarted) {
  Crane crane;
  crane.play(200);
  ASSERT_TRUE(crane.loop.post(SupervisorEvent::stop));
  EXPECT_EQ(crane.loop.state(), SupervisorState::stopping);
  crane.run_until_rest();
  EXPECT_EQ(crane.loop.state(), SupervisorState::latched);
  const std::vector<double> rest = crane.at();
  EXPECT_FALSE(crane.loop.post(SupervisorEvent::start));
  crane.tick(100);
  EXPECT_EQ(crane.at(), rest) << "no motion after a stop";
  ASSERT_TRUE(crane.loop.post(SupervisorEvent::acknowledge));
  crane.tick(3);
  EXPECT_EQ(crane.loop.state(), SupervisorState::ready);
  EXPECT_EQ(crane.at(), rest);
  ASSERT_TRUE(crane.loop.post(SupervisorEvent::start));
  crane.run_until_rest();
  EXPECT_EQ(crane.loop.state(), SupervisorState::ready);
  EXPECT_THAT(crane.at(), ElementsAre(260, 0.25, -5));
}

TEST(MotionLoop, APauseIsNoStop) {
  Crane crane;
  crane.play(200);
  crane.playhead.stop();
  crane.tick(500);
  EXPECT_EQ(crane.loop.state(), SupervisorState::running);
  EXPECT_TRUE(crane.playhead.is_resting());
  ASSERT_TRUE(crane.playhead.play(Direction::forward));
  crane.run_until_rest();
  EXPECT_THAT(crane.at(), ElementsAre(260, 0.25, -5));
}

TEST(MotionLoop, AStopWhilePausedIsAtRestAtOnce) {
  Crane crane;
  crane.play(200);
  crane.playhead.stop();
  crane.tick(500);
  ASSERT_TRUE(crane.loop.post(SupervisorEvent::stop));
  crane.tick(1);
  EXPECT_EQ(crane.loop.state(), SupervisorState::latched);
}

// docs/faults.md 28
TEST(MotionLoop, WithoutPowerNothingIsSentAndNothingResumesByItself) {
  Crane crane;
  crane.play(200);
  crane.lines.is_pressed = true;
  crane.tick(1);
  EXPECT_EQ(crane.loop.state(), SupervisorState::faulted);
  const std::size_t writes = crane.rig.writes();
  crane.tick(50);
  EXPECT_EQ(crane.rig.writes(), writes);
  EXPECT_FALSE(crane.loop.post(SupervisorEvent::acknowledge)) << "it is still pressed";
  crane.rig.move_by_hand(2, 33);
  crane.lines.is_pressed = false;
  crane.tick(50);
  EXPECT_EQ(crane.loop.state(), SupervisorState::cut_off);
  EXPECT_EQ(crane.rig.writes(), writes) << "old targets would snap the arm back";
  ASSERT_TRUE(crane.loop.post(SupervisorEvent::acknowledge));
  crane.tick(3);
  EXPECT_EQ(crane.loop.state(), SupervisorState::ready);
  EXPECT_EQ(crane.at()[2], 33) << "positions were read again";
  EXPECT_FALSE(crane.loop.post(SupervisorEvent::start)) << "it has been moved";
  crane.tick(50);
  EXPECT_EQ(crane.at()[2], 33);
}

TEST(MotionLoop, AfterLostPowerNoSpeedIsLeftOver) {
  Crane crane;
  crane.play(200);
  crane.rig.disconnect();
  crane.tick(1);
  EXPECT_TRUE(crane.playhead.is_resting()) << "no speed is left over";
  crane.rig.reconnect();
  crane.tick(1);
  EXPECT_EQ(crane.loop.state(), SupervisorState::cut_off);
  ASSERT_TRUE(crane.loop.post(SupervisorEvent::acknowledge));
  crane.tick(3);
  // The drives have come to rest a tick behind the last setpoint: somebody has to take them there slowly.
  EXPECT_FALSE(crane.loop.post(SupervisorEvent::start));
  crane.playhead = Playhead(crane.plan.played(), *crane.stops.bounds(), 250);
  crane.rig.move_by_hand(0, 100);
  crane.rig.move_by_hand(2, 10);
  ASSERT_TRUE(crane.loop.post(SupervisorEvent::disarm));
  crane.arm();
  ASSERT_TRUE(crane.loop.post(SupervisorEvent::start));
  crane.run_until_rest();
  EXPECT_THAT(crane.at(), ElementsAre(260, 0.25, -5));
}

// docs/faults.md 23
TEST(MotionLoop, AFaultOfOneDriveSlowsAllDownOnThePath) {
  Crane crane;
  crane.play(200);
  crane.rig.set_fault(0, true);
  crane.tick(1);
  EXPECT_EQ(crane.loop.state(), SupervisorState::stopping);
  std::vector<double> expected(2);
  for (int i = 0; i < 2000 && crane.loop.state() == SupervisorState::stopping; ++i) {
    crane.loop.tick(1, 0);
    crane.plan.motion().positions(crane.playhead.time(), expected);
    ASSERT_THAT(crane.at(), ElementsAre(expected[1], 0.25, expected[0]));
  }
  crane.tick(1);
  EXPECT_EQ(crane.loop.state(), SupervisorState::faulted) << "the drive is still faulty";
  EXPECT_FALSE(crane.loop.post(SupervisorEvent::acknowledge));
  crane.rig.set_fault(0, false);
  crane.tick(1);
  EXPECT_EQ(crane.loop.state(), SupervisorState::cut_off);
}

// docs/faults.md 36
TEST(MotionLoop, ALateTickIsMadeUpForWhereNoAxisGoesBeyondItsVelocity) {
  Crane crane;
  crane.play(30);
  EXPECT_FALSE(crane.loop.tick(3, 0).lost_time) << "it is slow here";
  EXPECT_EQ(crane.loop.state(), SupervisorState::running);
  std::vector<double> expected(2);
  crane.plan.motion().positions(frame_time_of_tick(33, {24, 1}, 250), expected);
  EXPECT_EQ(crane.at()[0], expected[1]);
}

// docs/faults.md 36
TEST(MotionLoop, ALongStallIsAControlledStopAndNeverABurst) {
  Crane crane;
  crane.play(230);
  std::vector<double> before = crane.at();
  EXPECT_TRUE(crane.loop.tick(100, 0).lost_time);
  EXPECT_EQ(crane.loop.state(), SupervisorState::stopping);
  while (crane.loop.state() == SupervisorState::stopping) {
    EXPECT_LE(std::abs(crane.at()[0] - before[0]), 250 * tick_s);
    EXPECT_LE(std::abs(crane.at()[2] - before[2]), 120 * tick_s);
    before = crane.at();
    crane.loop.tick(1, 0);
  }
  EXPECT_EQ(crane.loop.state(), SupervisorState::latched);
}

// A jerk of J takes velocities J tick^2 / 12 from the mean of both ends of a tick, and accelerations J tick.
TEST(MotionLoop, ItsSetpointsTellHowTheAxesMove) {
  Crane crane;
  crane.arm();
  ASSERT_TRUE(crane.playhead.set_override(0.8));
  ASSERT_TRUE(crane.loop.post(SupervisorEvent::start));
  constexpr double jerk = 1.5 * 40'000;
  double fastest = 0;
  for (int tick = 0; tick < 400; ++tick) {
    const std::vector<Setpoint> before = crane.moving();
    const bool stops = tick == 250 && crane.loop.post(SupervisorEvent::stop);
    ASSERT_EQ(stops, tick == 250);
    crane.tick(1);
    const std::vector<Setpoint> after = crane.moving();
    for (std::size_t i = 0; i < 3; ++i) {
      const Setpoint& from = before[i];
      const Setpoint& to = after[i];
      ASSERT_NEAR((to.position - from.position) / tick_s, (from.velocity + to.velocity) / 2,
                  jerk * tick_s * tick_s / 12)
          << tick;
      ASSERT_NEAR((to.velocity - from.velocity) / tick_s, (from.acceleration + to.acceleration) / 2,
                  jerk * tick_s)
          << tick;
      fastest = std::max(fastest, std::abs(to.velocity));
    }
  }
  EXPECT_GT(fastest, 100);
  EXPECT_EQ(crane.loop.state(), SupervisorState::latched);
  EXPECT_EQ(crane.moving()[2].velocity, 0);
}

/// The crane with a calibration on its track, over a MotorPort.
struct GearedCrane {
  static RigFile geared() {
    std::string text = crane_rig;
    const std::string jerk = "max_jerk = 20000";
    text.replace(text.find(jerk), jerk.size(),
                 jerk +
                     "\ncalibration = { unit = \"deg\", marks = [[0, 0], [150, 100], [500, 400]], "
                     "max_velocity = 900, max_acceleration = 9000 }");
    return parse_rig(text, "rig.toml");
  }
  Plan plan{parse_move(glide, "move.toml"), geared(), {}};
  PlannedStops stops{plan};
  Playhead playhead{plan.played(), *stops.bounds(), 250};
  std::vector<std::size_t> drive_of{2, 0};
  const Calibration& curve = plan.rig()->axes[0].calibration->motor();
  SimulatedRig rig{std::vector<double>{curve.motor_at(100), 0.25, 10}};
  SimulatedLines lines;
  LoopStorage room{3, 2};
  std::array<AxisGear, 3> gears{{{.calibration = &curve}, {}, {}}};
  std::array<AxisMotor, 3> motors{{{.axis = 0}, {.axis = 1}, {.axis = 2}}};
  std::array<DriveState, 3> states;
  std::array<Setpoint, 3> told;
  MotorPort<SimulatedRig> port{rig, {gears, motors, states, told}};
  MotionLoop<MotorPort<SimulatedRig>, SimulatedLines> loop{port, lines, room.memory()};
};

TEST(MotionLoop, AMotorBehindACalibrationIsToldWhatWasFittedToItAlsoWhileTheRigSlowsDown) {
  GearedCrane crane;
  ASSERT_EQ(crane.plan.motion().motors().size(), 1U);
  const PlayedMotor& motor = crane.plan.motion().motors()[0];
  ASSERT_TRUE(
      crane.loop.load({&crane.plan.motion(), &crane.playhead, crane.drive_of, crane.plan.limits(), tick_s}));
  ASSERT_TRUE(crane.loop.post(SupervisorEvent::arm));
  crane.loop.tick(1, 0);
  crane.loop.tick(1, 0);
  ASSERT_TRUE(crane.loop.post(SupervisorEvent::start));
  int slowed = 0;
  for (int i = 0; i < 2000; ++i) {
    if (i == 200) {
      ASSERT_TRUE(crane.loop.post(SupervisorEvent::stop));
    }
    crane.loop.tick(1, 0);
    const double rate = crane.playhead.rate();
    const AxisMotion fitted = crane.plan.motion().motion_of(motor, crane.playhead.time());
    ASSERT_EQ(crane.told[0].position, fitted.position) << i;
    ASSERT_EQ(crane.told[0].velocity, fitted.velocity * rate) << i;
    ASSERT_EQ(crane.told[0].acceleration,
              fitted.acceleration * rate * rate + fitted.velocity * crane.playhead.rate_change())
        << i;
    const double of_axis = crane.curve.motor_at(crane.loop.setpoints()[0].position);
    ASSERT_NEAR(fitted.position, of_axis, 1e-6);
    slowed += rate > 0 && rate < 1 ? 1 : 0;
  }
  EXPECT_GT(slowed, 5);
  EXPECT_EQ(crane.loop.state(), SupervisorState::latched) << "it holds what it was told last";
}

TEST(MotionLoop, DrivesThatCannotPlayAMotorAreNotLoadedWithOne) {
  const GearedCrane geared;
  Crane crane;
  const Status loaded =
      crane.loop.load({&geared.plan.motion(), &crane.playhead, crane.drive_of, geared.plan.limits(), tick_s});
  ASSERT_FALSE(loaded);
  EXPECT_EQ(loaded.error().code, ErrorCode::out_of_range);
}

TEST(MotionLoop, DisarmingStopsFirst) {
  Crane crane;
  crane.play(200);
  EXPECT_TRUE(crane.loop.post(SupervisorEvent::disarm));
  EXPECT_EQ(crane.loop.state(), SupervisorState::stopping);
  crane.run_until_rest();
  EXPECT_EQ(crane.loop.state(), SupervisorState::latched);
  EXPECT_TRUE(crane.loop.post(SupervisorEvent::disarm));
  EXPECT_EQ(crane.loop.state(), SupervisorState::disarmed);
}

// --- without a move

/// The crane's pan and track as free axes, from where they stand; they begin at `from`.
struct FreeCrane : Crane {
  FreeAxes axes;

  explicit FreeCrane(const std::vector<double>& from = {10, 100}, double share = 0.5)
      : axes(axes_at(from, share)) {
    EXPECT_TRUE(loop.load(FreeSpec{
        .source = source_of(axes), .drive_of = drive_of, .limits = plan.limits(), .tick_seconds = tick_s}));
  }
  static std::vector<FreeAxis> axes_at(const std::vector<double>& from, double share = 0.5) {
    const RigFile rig = parse_rig(crane_rig, "rig.toml");
    return {*FreeAxis::make(free_limits_of(rig.axes[2], share), from[0], tick_s),
            *FreeAxis::make(free_limits_of(rig.axes[0], share), from[1], tick_s)};
  }
  void begin() {
    arm();
    ASSERT_TRUE(axes.axes()[0].go_to(40));
    ASSERT_TRUE(axes.axes()[1].go_to(300));
    ASSERT_TRUE(loop.begin());
  }
};

TEST(MotionLoop, PlaysWhatIsNotOnATimeLineUntilItRests) {
  FreeCrane crane;
  crane.begin();
  FreeAxis pan = FreeCrane::axes_at({10, 100})[0];
  ASSERT_TRUE(pan.go_to(40));
  crane.tick(1);
  EXPECT_EQ(crane.loop.finish().error().code, ErrorCode::wrong_state) << "it moves";
  for (int tick = 1; !crane.axes.is_resting(); ++tick) {
    ASSERT_EQ(crane.at()[2], pan.tick().position) << tick;
    ASSERT_EQ(crane.at()[1], 0.25) << "the lamp holds its place";
    ASSERT_EQ(crane.loop.state(), SupervisorState::running);
    crane.tick(1);
  }
  EXPECT_THAT(crane.at(), ElementsAre(300, 0.25, 40));
  EXPECT_EQ(crane.loop.state(), SupervisorState::running) << "whoever began it says when it is over";
  ASSERT_TRUE(crane.loop.finish());
  EXPECT_EQ(crane.loop.state(), SupervisorState::ready);
  crane.tick(3);
  EXPECT_THAT(crane.at(), ElementsAre(300, 0.25, 40));
}

// Where a motion came from far away, the last bits of its positions are more than those of a position near 0.
TEST(MotionLoop, AFreeAxisAtAllOfItsSpeedPassesItsZero) {
  FreeCrane crane({10, 100}, 1);
  crane.arm();
  ASSERT_TRUE(crane.loop.begin());
  for (int way = 1; way <= 200; ++way) {
    const double to = (way % 2 == 0 ? -1 : 1) * (40 + 0.237 * way);
    ASSERT_TRUE(crane.axes.axes()[0].go_to(to));
    do {
      ASSERT_FALSE(crane.loop.tick(1, 0).lost_time) << "to " << to << ", from " << crane.at()[2];
    } while (!crane.axes.is_resting());
  }
}

TEST(MotionLoop, WithoutAMoveThereIsNoneToStart) {
  FreeCrane crane;
  EXPECT_EQ(crane.loop.begin().error().code, ErrorCode::wrong_state) << "not armed";
  crane.arm();
  const Status refused = crane.loop.start(Direction::forward);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().what, HasSubstr("no move"));
  ASSERT_TRUE(crane.loop.begin());
  EXPECT_FALSE(crane.loop.load(FreeSpec{.source = source_of(crane.axes),
                                        .drive_of = crane.drive_of,
                                        .limits = crane.plan.limits(),
                                        .tick_seconds = tick_s}))
      << "it runs";
}

TEST(MotionLoop, AStopSlowsEveryFreeAxisAndLatches) {
  FreeCrane crane;
  crane.begin();
  crane.tick(100);
  ASSERT_TRUE(crane.loop.post(SupervisorEvent::stop));
  crane.run_until_rest();
  EXPECT_EQ(crane.loop.state(), SupervisorState::latched);
  EXPECT_TRUE(crane.axes.is_resting());
  EXPECT_LT(crane.at()[0], 300);
  const std::vector<double> there = crane.at();
  crane.tick(10);
  EXPECT_EQ(crane.at(), there);
}

TEST(MotionLoop, ALimitSwitchStopsFreeAxes) {
  FreeCrane crane;
  crane.begin();
  crane.tick(100);
  crane.lines.is_at_limit = true;
  crane.tick(1);
  EXPECT_EQ(crane.loop.state(), SupervisorState::stopping);
  crane.run_until_rest();
  EXPECT_EQ(crane.loop.state(), SupervisorState::latched);
}

// docs/faults.md 36: what has no time line has no lost time either.
TEST(MotionLoop, ALateTickIsOneTickOfAFreeAxis) {
  FreeCrane crane;
  FreeCrane punctual;
  crane.begin();
  punctual.begin();
  crane.tick(50);
  crane.tick(1, 20);
  punctual.tick(51);
  EXPECT_EQ(crane.at(), punctual.at());
  EXPECT_EQ(crane.loop.state(), SupervisorState::running);
}

// docs/faults.md 27
TEST(MotionLoop, FreeAxesThatBelieveToBeElsewhereMoveNothing) {
  FreeCrane crane({12, 100});
  crane.begin();
  const LoopTick tick = crane.loop.tick(1, 0);
  EXPECT_TRUE(tick.lost_time);
  crane.run_until_rest();
  EXPECT_EQ(crane.loop.state(), SupervisorState::latched);
  EXPECT_THAT(crane.at(), ElementsAre(100, 0.25, 10));
}

// docs/faults.md 28
TEST(MotionLoop, WithoutPowerFreeAxesRestWhereTheyWereAtOnce) {
  FreeCrane crane;
  crane.begin();
  crane.tick(100);
  crane.rig.disconnect();
  crane.tick(2);
  EXPECT_EQ(crane.loop.state(), SupervisorState::faulted);
  EXPECT_TRUE(crane.axes.is_resting());
  EXPECT_FALSE(crane.loop.sends_setpoints());
}

}  // namespace motion_loop_test
}  // namespace inbetween
