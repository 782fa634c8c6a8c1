// Steps by keys: a press moves an axis by its increment, a key that is held moves it on, and nothing further.
#include "host_tools/motions/jog.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <fstream>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/loop/loop_preparations.hpp"
#include "host_tools/plan/move_rolls.hpp"
#include "host_tools/rig/simulated_hardware.hpp"
#include "host_tools/rig_model/rig_motors.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace jog_test {

using testing::HasSubstr;

const std::string crane = rig_text(
    {stepper_track(),
     axis_text("pan", "deg", {-90, 90}, {.velocity = 120, .acceleration = 700}, R"(reference = "operator")",
               R"(type = "step-dir", chip = "gpio", step = 19, dir = 26, steps_per_unit = 50)")},
    {.name = "crane", .rate_hz = 250});

const std::string left = "\x1b[D", right = "\x1b[C", up = "\x1b[A", down = "\x1b[B";
constexpr std::int64_t tick_ns = 4'000'000;
constexpr double tick_s = 0.004;
constexpr int silence_ticks = 38;
/// From the full velocity of the axis, while it still speeds up, to rest at its limits: HeldJog's
/// stop_ticks().
constexpr int stop_ticks = 98;
const JogIncrements increments{0.01, 0.05, 0.2, 1, 5};

/// Two axes under somebody's keys, on a virtual clock. A key is typed before the tick of that number.
struct Bench {
  RigFile rig = parse_rig(crane, "rig.toml");
  SimulatedHardware hardware;
  RigInputs lines{rig, hardware};
  RigDrives drives{rig, hardware};
  LoopStorage room{2, 2};
  std::optional<RunLoop> loop;
  LoopTrace trace{2};
  LoopAudience audience;
  std::vector<std::size_t> drive_of{0, 1};
  std::vector<AxisLimits> limits{limits_of(rig.axes[0]), limits_of(rig.axes[1])};
  std::optional<FreeAxes> free;
  std::optional<Jog> jog;
  std::optional<FastRunner> runner;

  std::map<int, std::string> typed;         ///< by tick
  std::vector<std::vector<Setpoint>> path;  ///< of both axes, as they were when a tick began
  std::vector<std::size_t> marks;
  int keeps = 0;
  std::function<void(int)> look = [](int) {};

  std::vector<TransportKey> taught = {};

  explicit Bench(const std::vector<double>& at = {100, 0}, bool is_referenced = true, bool teaches = false,
                 double reach = 300)
      : hardware(rig, at) {
    loop.emplace(drives, lines, room.memory());
    std::vector<FreeAxis> axes;
    std::vector<JogAxis> jogged;
    for (std::size_t a = 0; a < 2; ++a) {
      axes.push_back(*FreeAxis::make(free_limits_of(rig.axes[a], 1), at[a], tick_s));
      jogged.push_back({.name = rig.axes[a].name.c_str(),
                        .unit = "mm",
                        .increments = increments,
                        .min = rig.axes[a].min,
                        .max = rig.axes[a].max,
                        .count = 1.0 / 50,
                        .is_referenced = is_referenced,
                        .reach = reach});
    }
    free.emplace(std::move(axes));
    jog.emplace(
        *loop,
        FreeSpec{.source = source_of(*free), .drive_of = drive_of, .limits = limits, .tick_seconds = tick_s},
        *free, jogged, 0, JogKeys{.teach = teaches});
    audience.keys = [this] {
      path.push_back({loop->setpoints().begin(), loop->setpoints().end()});
      const int tick = static_cast<int>(path.size());
      look(tick);
      return typed.contains(tick) ? typed[tick] : std::string();
    };
    runner.emplace(*loop, 250, audience, trace);
    Arming arming(*loop);
    runner->run(arming, std::nullopt);
    EXPECT_EQ(loop->state(), SupervisorState::ready);
  }

  /// A key every `period` ticks.
  void hold(const std::string& key, int from, int to, int period = 8) {
    for (int tick = from; tick <= to; tick += period) typed[tick] = key;
  }
  /// Until somebody leaves: at tick `end` at the latest.
  void run(int end) {
    typed[end] = "q";
    for (;;) {
      ASSERT_TRUE(runner->run(*jog, std::nullopt).begun);
      if (jog->asks() == Jog::Ask::none) return;
      if (jog->asks() == Jog::Ask::mark) {
        marks.push_back(jog->selected());
        jog->marked();
      } else if (jog->asks() == Jog::Ask::teach) {
        taught.push_back(jog->taught());
        jog->has_taught();
      } else {
        ++keeps;
        jog->kept();
      }
    }
  }
  [[nodiscard]] double at(int tick, std::size_t axis = 0) const {
    return path.at(static_cast<std::size_t>(tick) - 1)[axis].position;
  }
  /// The last tick in which the axis had another position than in the one before.
  [[nodiscard]] int last_motion(std::size_t axis = 0) const {
    int last = 0;
    for (int tick = 2; tick <= static_cast<int>(path.size()); ++tick) {
      if (at(tick, axis) != at(tick - 1, axis)) last = tick;
    }
    return last;
  }
};

TEST(Jog, APressMovesTheAxisByItsIncrement) {
  for (const auto& [key, sign] :
       {std::pair(right, 1), {left, -1}, {std::string("+"), 1}, {std::string("-"), -1}}) {
    Bench bench;
    bench.typed[10] = key;
    bench.run(400);
    EXPECT_DOUBLE_EQ(bench.at(400), 100 + sign * 0.2) << key;
    EXPECT_EQ(bench.at(400, 1), 0) << "the other one stands still";
    EXPECT_TRUE(bench.jog->was_left());
  }
}

TEST(Jog, FiveKeysChooseTheIncrement) {
  for (const auto& [key, increment] : {std::pair("2", 0.05), {"3", 0.2}, {"4", 1.0}, {"5", 5.0}}) {
    Bench bench;
    bench.typed[10] = key;
    bench.typed[20] = right;
    bench.run(600);
    EXPECT_DOUBLE_EQ(bench.at(600), 100 + increment) << key;
  }
}

// docs/faults.md 41: most terminals do not tell when a key is let go.
TEST(Jog, AKeyThatIsRepeatedMovesTheAxisOnUntilTheRepeatsEnd) {
  for (const int delay : {45, 63, 125, 165, 250}) {   // 180 ms to 1 s until a terminal begins to repeat
    for (const int period : {4, 5, 8, 15, 23, 29}) {  // 62 to 9 a second
      SCOPED_TRACE(testing::Message() << delay << " " << period);
      Bench bench;
      bench.typed[10] = right;
      bench.hold(right, 10 + delay, 10 + delay + 200, period);
      const int last = 10 + delay + 200 / period * period;
      std::string words;
      bench.look = [&](int tick) {
        if (tick == last) words = state_line(bench.jog->snapshot());
      };
      bench.run(900);
      EXPECT_GT(bench.at(last), 105) << "further than its step";
      EXPECT_THAT(words, HasSubstr("stops in ")) << "and it moves";
      EXPECT_LE(bench.last_motion(), last + silence_ticks + stop_ticks);
      EXPECT_LT(bench.at(900), 400);
      if (delay > silence_ticks + 20) {
        EXPECT_DOUBLE_EQ(bench.at(10 + delay), 100.2) << "a step first, for the press";
      }
    }
  }
}

TEST(Jog, RepeatsThatAreNoKeyboardsMoveOneIncrement) {
  for (const int period : {1, 32, 36}) {  // 250 a second, and less than 8
    Bench bench;
    bench.typed[10] = right;
    bench.hold(right, 73, 1073, period);
    bench.run(1500);
    EXPECT_DOUBLE_EQ(bench.at(1500), 100.2) << period;
  }
}

// A terminal that hung, a connection that was interrupted: whoever pressed them has let go long ago.
TEST(Jog, KeysThatComeLateAndAllAtOnceMoveNothing) {
  for (const int chunk : {1, 3, 20}) {
    Bench bench;
    std::string words;
    for (int i = 0; i < 120 / chunk; ++i) {
      for (int key = 0; key < chunk; ++key) bench.typed[10 + 3 * i / (chunk == 1 ? 3 : 1)] += right;
    }
    bench.look = [&](int tick) {
      if (tick == 140) words = bench.jog->snapshot().words;
    };
    bench.run(600);
    EXPECT_EQ(bench.last_motion(), 0) << chunk;
    EXPECT_THAT(words, HasSubstr("let go, and press again")) << chunk;
  }
}

TEST(Jog, AHeldKeyMovesByItsReachAndIsPressedAnew) {
  Bench bench({100, 0}, true, false, 20);
  bench.typed[10] = right;
  bench.hold(right, 73, 2000);
  bench.typed[2100] = left;
  bench.hold(left, 2163, 2300);
  std::string words;
  bench.look = [&](int tick) {
    if (tick == 1500) words = bench.jog->snapshot().words;
  };
  bench.run(2700);
  EXPECT_NEAR(bench.at(2000), 120.2, 1e-9);
  EXPECT_THAT(words, HasSubstr("as far as a held key goes"));
  EXPECT_LT(bench.at(2700), 119.9) << "back again";
}

TEST(Jog, AHeldKeyEndsAtTheSoftLimit) {
  Bench bench({450, 0});
  bench.typed[10] = right;
  bench.hold(right, 73, 1000);
  bench.run(1200);
  EXPECT_EQ(bench.at(1200), 500);
  for (int tick = 1; tick <= 1200; ++tick) ASSERT_LE(bench.at(tick), 500);
}

TEST(Jog, AnotherKeyEndsAHoldAndWhatIsStillHeldMovesNothing) {
  for (const std::string& other : {left, std::string(" "), std::string("4"), down}) {
    Bench bench;
    bench.typed[10] = right;
    bench.hold(right, 73, 500);
    bench.typed[200] = other;
    bench.run(800);
    EXPECT_GT(bench.at(200), 105);
    EXPECT_LE(bench.last_motion(), 201 + stop_ticks) << other;
  }
}

// --- terminals with kitty's keyboard protocol

const std::string tells = "\x1b[?2u", repeated = "\x1b[1;129:2C", let_go = "\x1b[1;129:3C";

TEST(KittyJog, AHeldKeyMovesOnAndRestsWhenItIsLetGo) {
  Bench bench;
  bench.typed = {{5, tells}, {10, right}, {200, let_go}};
  bench.hold(repeated, 73, 199);
  bench.run(700);
  EXPECT_GT(bench.at(16), 100) << "a press counts at once";
  EXPECT_DOUBLE_EQ(bench.at(72), 100.2);
  EXPECT_GT(bench.at(200), 110);
  EXPECT_LE(bench.last_motion(), 200 + stop_ticks);
}

TEST(KittyJog, AReleaseThatIsLostEndsItAfterTheSilenceAndRepeatsAloneBeginNothing) {
  Bench bench;
  bench.typed = {{5, tells}, {10, right}};
  bench.hold(repeated, 73, 199);
  bench.hold(repeated, 400, 900);
  bench.typed[1000] = let_go;
  bench.typed[1100] = left;
  bench.run(1400);
  EXPECT_LE(bench.last_motion(), 1400);
  const double rested = bench.at(199 + silence_ticks + stop_ticks);
  EXPECT_GT(rested, 110);
  EXPECT_EQ(bench.at(1099), rested);
  EXPECT_NEAR(bench.at(1400), rested - 0.2, 1e-9) << "the next press counts";
}

TEST(KittyJog, AKeyThatIsTappedMovesAStepAtOnceHoweverQuickly) {
  Bench bench;
  bench.typed[5] = tells;
  for (int i = 0; i < 10; ++i) bench.typed[10 + 30 * i] = right + let_go;
  bench.run(600);
  EXPECT_NEAR(bench.at(600), 102, 1e-9);
}

TEST(KittyJog, ATerminalThatHungAndTellsAllAtOnceLeavesNothingHeld) {
  Bench bench;
  bench.typed[5] = tells;
  bench.typed[10] = right;
  for (int i = 0; i < 60; ++i) bench.typed[100] += repeated;
  bench.typed[110] = let_go;
  bench.run(600);
  EXPECT_DOUBLE_EQ(bench.at(600), 100.2);
}

TEST(Jog, EachPressCountsThatComesByItself) {
  Bench bench;
  for (int i = 0; i < 10; ++i) bench.typed[10 + 60 * i] = right;
  bench.run(900);
  EXPECT_NEAR(bench.at(900), 102, 1e-12);
}

TEST(Jog, OneStepAtATimeAndNothingWaitsForItsTurn) {
  Bench bench;
  bench.typed[10] = "5";
  bench.typed[20] = right;
  bench.typed[62] = right;
  std::string words;
  bench.look = [&](int tick) {
    if (tick == 105) {
      EXPECT_GT(bench.at(104), 100.1);
      EXPECT_LT(bench.at(104), 104.9) << "it moves when the second press would count";
    }
    if (tick == 110) words = bench.jog->snapshot().words;
  };
  bench.free->axes()[0] = *FreeAxis::make(free_limits_of(bench.rig.axes[0], 0.05), 100, tick_s);
  bench.run(1200);
  EXPECT_DOUBLE_EQ(bench.at(1200), 105);
  EXPECT_THAT(words, HasSubstr("one step at a time"));
}

TEST(Jog, AnyOtherKeyStopsOrTakesBackThePress) {
  Bench moving;
  moving.free->axes()[0] = *FreeAxis::make(free_limits_of(moving.rig.axes[0], 0.05), 100, tick_s);
  moving.typed[10] = "5";
  moving.typed[20] = right;
  moving.typed[100] = " ";
  moving.run(600);
  EXPECT_GT(moving.at(600), 100.1);
  EXPECT_LT(moving.at(600), 104.9);
  for (const std::string& other : {std::string(" "), std::string("4"), down, std::string("r")}) {
    Bench pressed;
    pressed.typed[10] = right;
    pressed.typed[30] = other;
    pressed.run(300);
    EXPECT_EQ(pressed.at(300), 100) << "before it was taken";
  }
}

TEST(Jog, TwoKeysAtOnceMoveNothing) {
  Bench bench;
  bench.typed[10] = right;
  bench.typed[20] = left;
  bench.typed[200] = right + left;
  bench.run(500);
  EXPECT_EQ(bench.last_motion(), 0);
}

TEST(Jog, UpAndDownChooseTheAxisAndStopTheOther) {
  Bench bench;
  bench.typed[10] = right;
  bench.typed[100] = down;
  bench.typed[120] = right;
  bench.typed[190] = up;
  bench.typed[200] = right;
  bench.run(500);
  EXPECT_NEAR(bench.at(500), 100.4, 1e-12);
  EXPECT_DOUBLE_EQ(bench.at(500, 1), 0.2);
  EXPECT_EQ(bench.marks, (std::vector<std::size_t>{0, 1})) << "nothing was written in between";
}

TEST(Jog, StaysInsideTheSoftLimits) {
  Bench bench({498.5, 0});
  std::string words;
  bench.typed[5] = "5";
  bench.typed[10] = right;
  bench.look = [&](int tick) {
    if (tick == 100) words = bench.jog->snapshot().words;
  };
  bench.typed[200] = "4";
  bench.typed[210] = right;
  bench.typed[400] = right;
  bench.run(700);
  EXPECT_THAT(words, HasSubstr("its limit is nearer"));
  EXPECT_EQ(bench.at(700), 499.5);
}

TEST(Jog, AnAxisBeyondItsLimitComesInStepByStepAndNoFurtherOut) {
  Bench bench({503, 0});
  bench.typed[10] = right;
  bench.typed[100] = "4";
  bench.typed[110] = left;
  bench.typed[250] = left;
  bench.typed[400] = right;
  bench.run(600);
  EXPECT_DOUBLE_EQ(bench.at(600), 501);
  for (int tick = 1; tick <= 600; ++tick) ASSERT_LE(bench.at(tick), 503);
}

// The range of an axis that does not know where it is has nothing to do with its limits.
TEST(Jog, AnUnreferencedAxisHasNoSoftLimits) {
  Bench bench({500, 0}, false);
  bench.typed[10] = "5";
  bench.typed[20] = right;
  bench.run(700);
  EXPECT_EQ(bench.at(700), 505);
}

TEST(Jog, AStepIsNeverLessThanACountOfTheDriveAndTheScreenSaysSo) {
  Bench bench;
  std::string fine, coarse;
  bench.typed = {{10, "1"}, {20, right}, {200, "4"}};
  bench.look = [&](int tick) {
    if (tick == 15) fine = state_line(bench.jog->snapshot());
    if (tick == 205) coarse = state_line(bench.jog->snapshot());
  };
  bench.run(300);
  EXPECT_DOUBLE_EQ(bench.at(300), 100.02) << "a step of 0.01 is half a count";
  EXPECT_THAT(fine, HasSubstr("step 1: 0.02 (a count)"));
  EXPECT_THAT(coarse, HasSubstr("step 4: 1"));
  EXPECT_THAT(coarse, testing::Not(HasSubstr("count")));
}

// A focus ring: where the motor turns little for its travel, a count is a longer travel than elsewhere.
TEST(Jog, AStepOfACalibratedAxisMovesItsMotorByACountWhereverItIs) {
  const std::vector<CalibrationMark> marks{{0, 100}, {10, 60}, {20, 40}, {40, 20}, {100, 0}};
  const CalibrationCurve curve(marks);
  const JogAxis axis{
      .increments = {0.01, 0.05, 0.2, 1, 5}, .count = 0.5, .calibration = &curve.curve().value()};
  for (const double position : {-5.0, 0.0, 3.0, 15.0, 39.0, 99.0, 120.0}) {
    for (const int direction : {-1, 1}) {
      for (std::size_t size = 0; size < 5; ++size) {
        const double step = axis.increment(size, position, direction);
        const double motor = std::fabs(axis.calibration->motor_at(position + direction * step) -
                                       axis.calibration->motor_at(position));
        EXPECT_GE(motor, 0.5 * (1 - 1e-9)) << position << " " << size;
        if (step > axis.increments[size]) {
          EXPECT_NEAR(motor, 0.5, 1e-9) << "and no further than it must";
        }
      }
    }
  }
}

TEST(Jog, ItsIncrementsAreRoundAndTheLargestAHundredthOfTheRange) {
  const RigFile rig = parse_rig(crane, "rig.toml");
  EXPECT_THAT(jog_increments(rig.axes[0]), testing::ElementsAre(0.025, 0.05, 0.2, 1, 5));
  EXPECT_THAT(jog_increments(rig.axes[1]), testing::ElementsAre(0.02, 0.02, 0.05, 0.2, 1));
  RigAxis axis = rig.axes[0];
  for (const double range : {1e-3, 0.99, 1.0, 2.0, 199.999, 200.0, 99'999.0}) {
    axis.min = -range / 2;
    axis.max = range / 2;
    const JogIncrements of_range = jog_increments(axis);
    const double most = std::max(range / 100, count_of(axis)) * (1 + 1e-8);
    EXPECT_LE(of_range.back(), most) << range;
    EXPECT_GT(of_range.back(), range / 100 / 2.6) << range;
    EXPECT_GE(of_range.front(), count_of(axis)) << range;
    EXPECT_TRUE(std::ranges::is_sorted(of_range));
  }
}

TEST(Jog, NothingMovesBeforeItIsMarkedAndItIsKeptAfterRest) {
  Bench bench;
  bench.look = [&](int tick) {
    if (bench.marks.empty()) {
      EXPECT_EQ(bench.at(tick), 100);
    }
  };
  bench.typed[10] = right;
  bench.typed[400] = right;
  bench.run(900);
  EXPECT_EQ(bench.marks, (std::vector<std::size_t>{0, 0}));
  EXPECT_EQ(bench.keeps, 2);
}

// A disk that took long: whoever pressed does not look any more.
TEST(Jog, APressFromBeforeASlowDiskMovesNothing) {
  Bench bench;
  bench.typed[10] = right;
  ASSERT_TRUE(bench.runner->run(*bench.jog, std::nullopt).begun);
  ASSERT_EQ(bench.jog->asks(), Jog::Ask::mark);
  auto now = static_cast<std::int64_t>(bench.path.size());
  for (int i = 0; i < 150; ++i) bench.loop->tick(1, ++now * tick_ns);
  bench.jog->marked();
  ASSERT_TRUE(bench.jog->begin());
  for (int i = 0; i < 30; ++i) bench.jog->tick(1, ++now * tick_ns);
  EXPECT_EQ(bench.loop->state(), SupervisorState::running);
  EXPECT_EQ(bench.loop->setpoints()[0].position, 100);
  EXPECT_THAT(bench.jog->snapshot().words, HasSubstr("press again"));
}

TEST(Jog, TheScreenComparesWithAnActualPositionTheSetpointThatItAnswers) {
  Bench bench;
  bench.typed = {{10, "5"}, {20, right}};
  double furthest = 0;
  bench.look = [&](int tick) {
    if (tick < 2) return;
    const AxisPlace axis = bench.trace.shown(*bench.jog).axes[0];
    EXPECT_NEAR(axis.commanded - axis.actual, axis.following_error, 1e-12) << tick;
    EXPECT_LE(std::fabs(axis.following_error), 1.0 / 40) << "a stepper is where its last steps took it";
    if (tick > 2) furthest = std::max(furthest, bench.at(tick) - bench.at(tick - 1));
  };
  bench.run(400);
  EXPECT_GT(furthest, 0.1) << "though it goes further in a tick";
}

TEST(Jog, AKeyIsStoredWhereTheRigRestsAndNeverWhileItMoves) {
  Bench bench({100, 0}, true, true);
  bench.free->axes()[0] = *FreeAxis::make(free_limits_of(bench.rig.axes[0], 0.05), 100, tick_s);
  std::string words;
  bench.typed = {{10, "5"}, {20, right}, {100, "t"}, {900, "n"}, {910, "\r"}};
  bench.look = [&](int tick) {
    if (tick == 110) words = bench.jog->snapshot().words;
  };
  bench.run(1000);
  EXPECT_THAT(words, HasSubstr("it still moves"));
  EXPECT_THAT(bench.taught, testing::ElementsAre(TransportKey::teach_next, TransportKey::start));
  EXPECT_EQ(bench.at(1000), 105) << "and the step went on";
}

TEST(Jog, WithoutAMoveToTeachItsKeysStopLikeOthers) {
  Bench bench;
  bench.free->axes()[0] = *FreeAxis::make(free_limits_of(bench.rig.axes[0], 0.05), 100, tick_s);
  bench.typed = {{10, "5"}, {20, right}, {100, "t"}};
  bench.run(900);
  EXPECT_TRUE(bench.taught.empty());
  EXPECT_LT(bench.at(900), 104.9);
}

TEST(Jog, AnEmergencyStopIsTheEndAndNotTheOperators) {
  Bench bench;
  bench.free->axes()[0] = *FreeAxis::make(free_limits_of(bench.rig.axes[0], 0.01), 100, tick_s);
  bench.typed[10] = "5";
  bench.typed[20] = right;
  bench.look = [](int tick) {
    if (tick == 100) std::raise(SIGUSR1);
  };
  bench.run(900);
  EXPECT_FALSE(bench.jog->was_left());
  EXPECT_LT(bench.path.size(), 110U);
}

/// Whoever leaves in the middle of a step waits for no more than a stop at the limits of the motion. Esc
/// leaves as q does, and is no fault.
TEST(Jog, LeavingInAStepStopsIt) {
  for (const char* key : {"q", "\x1b"}) {
    Bench bench;
    bench.free->axes()[0] = *FreeAxis::make(free_limits_of(bench.rig.axes[0], 0.05), 100, tick_s);
    bench.typed[10] = "5";
    bench.typed[20] = right;
    bench.typed[100] = key;
    bench.run(900);
    EXPECT_GT(bench.loop->setpoints()[0].position, 100.1);
    EXPECT_LT(bench.loop->setpoints()[0].position, 104.9);
    EXPECT_TRUE(bench.jog->was_left()) << key[0];
  }
}

// --- with its file and its session

struct Hands {
  RigFile rig = parse_rig(crane, "rig.toml");
  TemporaryFolder folder;
  std::string file = (folder.path() / "crane.positions").string();
  int ticks = 0;

  SetupEnd jog(RigReference& reference, std::map<int, std::string> typed) {
    JogOptions options{.session = {.simulated = true, .fast = true}};
    options.session.audience.keys = [&, typed]() mutable { return std::exchange(typed[++ticks], ""); };
    return inbetween::jog(rig, 0, reference, options);
  }
  /// Steps of size 4, a second each.
  static std::map<int, std::string> steps(int count) {
    std::map<int, std::string> typed{{5, "4"}, {250 * (count + 1), "q"}};
    for (int i = 0; i < count; ++i) typed[10 + 250 * i] = right;
    return typed;
  }
};

TEST(Jog, LeftByEscItIsDoneAtRestAndInAStep) {
  Hands hands;
  RigReference(hands.rig, hands.file).stands_at(0, 100);
  RigReference reference(hands.rig, hands.file);
  for (const int tick : {400, 55}) {
    hands.ticks = 0;
    const SetupEnd end = hands.jog(reference, {{5, "5"}, {10, right}, {tick, "\x1b"}});
    EXPECT_TRUE(end.is_done) << end.reason;
    EXPECT_EQ(end.reason, "left");
  }
}

TEST(Jog, ItsEndIsKept) {
  Hands hands;
  RigReference(hands.rig, hands.file).stands_at(0, 100);
  RigReference reference(hands.rig, hands.file);
  const SetupEnd end = hands.jog(reference, Hands::steps(3));
  EXPECT_TRUE(end.is_done) << end.reason;
  EXPECT_NEAR(end.positions[0], 103, 0.02);
  EXPECT_EQ(RigReference(hands.rig, hands.file).position(0), end.positions[0]);
  EXPECT_EQ(RigReference(hands.rig, hands.file).position(1), std::nullopt) << "nobody knew before, either";
}

/// What a FIFO was told.
struct Lines {
  explicit Lines(const std::string& path) {
    EXPECT_EQ(::mkfifo(path.c_str(), 0600), 0);
    file = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  }
  ~Lines() { ::close(file); }
  Lines(const Lines&) = delete;
  Lines& operator=(const Lines&) = delete;
  void read() {
    std::array<char, 65536> part{};
    for (ssize_t count = 0; (count = ::read(file, part.data(), part.size())) > 0;) {
      all.append(part.data(), static_cast<std::size_t>(count));
    }
  }
  int file = -1;
  std::string all;
};

// A servo that nobody has asked where it stands would jump to what it is told.
TEST(Jog, AnUnreferencedServoIsMovedAloneAndNothingIsSentToTheOthers) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "servos").string();
  std::vector<AxisText> servos;
  for (const char* name : {"jaw", "lid"}) {
    servos.push_back({.name = name,
                      .unit = "deg",
                      .more = "unpowered = \"holds\"",
                      .drive = "type = \"pipe\", path = \"" + path +
                               "\", counts_per_unit = 10, no_watchdog = \"accepted\""});
  }
  const RigFile rig = parse_rig(rig_text(servos, {.rate_hz = 50}), "rig.toml");
  RigReference reference(rig, (folder.path() / "positions").string());
  EXPECT_EQ(jogged_axes(rig, 1, reference), std::vector<std::size_t>{1});
  Lines lines(path);
  JogOptions options{.session = {.allow_jitter = true, .standing = {}, .audience = {}}};
  int looks = 0;
  std::string words;
  std::size_t axes = 0;
  options.session.audience.keys = [&]() -> std::string {
    lines.read();
    ++looks;
    return looks == 40 ? right : looks == 120 ? down : looks == 200 ? "q" : "";
  };
  options.session.audience.status = [&](const RunSnapshot& now) {
    if (!now.jog) return;
    axes = now.axis_count;
    words = hint_line(now);
  };
  const SetupEnd end = jog(rig, 1, reference, options);
  lines.read();
  EXPECT_THAT(lines.all, HasSubstr("lid="));
  EXPECT_THAT(lines.all, testing::Not(HasSubstr("jaw="))) << "another servo";
  EXPECT_EQ(end.positions.size(), 2U);
  EXPECT_EQ(axes, 1U);
  EXPECT_FALSE(reference.is_referenced(1)) << "nobody has said where it stands";
  EXPECT_THAT(words, testing::Not(HasSubstr("up down axis")));
}

TEST(Jog, AnAxisThatDoesNotKnowWhereItIsIsNotTaught) {
  Hands hands;
  RigReference reference(hands.rig, hands.file);
  JogOptions options{.session = {.simulated = true, .fast = true}};
  options.teach = [](TransportKey, std::size_t, const std::vector<double>&) {};
  EXPECT_THAT([&] { jog(hands.rig, 0, reference, options); },
              testing::ThrowsMessage<InputError>(HasSubstr("axis \"track\" does not know where it is")));
}

TEST(Jog, AnUnreferencedAxisIsSlowerAndStaysUnreferenced) {
  Hands hands;
  RigReference(hands.rig, hands.file).stands_at(0, 100);
  RigReference referenced(hands.rig, hands.file);
  auto typed = Hands::steps(1);
  typed[5] = "5";
  typed.erase(500);
  typed[200] = "q";
  EXPECT_NEAR(hands.jog(referenced, typed).positions[0], 105, 0.02);
  const TemporaryFolder elsewhere;
  RigReference lost(hands.rig, (elsewhere.path() / "p").string());
  hands.ticks = 0;
  const SetupEnd end = hands.jog(lost, typed);
  EXPECT_GT(end.positions[0], 0.1);
  EXPECT_LT(end.positions[0], 2) << "a tenth as fast";
  EXPECT_FALSE(lost.is_referenced(0));
}

/// Where the one axis of a record was, while it was told where to be.
std::vector<double> places_of(const std::string& record) {
  std::vector<double> places;
  std::ifstream file(record);
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    const bool is_told = line.find(",,,") == std::string::npos;  // by hand there is no frame
    if (is_told) places.push_back(std::stod(line.substr(line.rfind(',') + 1)));
  }
  return places;
}

// docs/faults.md 49. The drive would take it in by itself, if its limits were narrower.
TEST(Jog, AnAxisOutsideItsLimitsStandsStillUntilAKeyIsPressedAndComesInSlowly) {
  const RigFile rig = parse_rig(
      rig_text({axis_text("slide", "mm", {0, 1200}, {.velocity = 250, .acceleration = 500, .jerk = 5000},
                          R"(reference = "drive")",
                          R"(type = "cia402", bus = "can0", node = 1, counts_per_unit = 1000)")},
               {.rate_hz = 250, .more = bus_can0}),
      "rig.toml");
  constexpr double increment = 10, max_step = 0.1 * 250 * tick_s;
  constexpr double count = 0.0015;  // one of 0.001, and rounding
  const TemporaryFolder folder;
  for (const double stands : {-3.0, -20.0, 1203.0, 1260.0}) {
    const double inwards = stands < 0 ? 1 : -1;
    const std::string in = stands < 0 ? right : left;
    const std::string out = stands < 0 ? left : right;
    for (const std::string& key : {std::string(), out, in}) {
      const double travel = key == in ? increment : 0;
      SCOPED_TRACE(testing::Message() << stands << ", then " << travel);
      RigReference reference(rig, (folder.path() / "positions").string());
      JogOptions options{.session = {.simulated = true, .fast = true, .standing = {{"slide", stands}}}};
      options.share = 1;
      const TemporaryFolder recorded;
      options.session.record = (recorded.path() / "record.csv").string();
      int ticks = 0;
      options.session.audience.keys = [&]() -> std::string {
        ++ticks;
        return ticks == 500 ? "5" : ticks == 510 ? key : ticks == 1000 ? "q" : "";
      };
      const SetupEnd end = jog(rig, 0, reference, options);
      EXPECT_TRUE(end.is_done) << end.reason;
      const std::vector<double> places = places_of(*options.session.record);
      ASSERT_GT(places.size(), 400U);
      EXPECT_NEAR(places.front(), stands, count);
      EXPECT_NEAR(places.back(), stands + inwards * travel, 2 * count);
      double fastest = 0;
      for (std::size_t i = 1; i < places.size(); ++i) {
        const double step = inwards * (places[i] - places[i - 1]);
        ASSERT_GE(step, -count) << "no further out";
        fastest = std::max(fastest, step);
      }
      EXPECT_LE(fastest, travel > 0 ? max_step + count : count);
    }
  }
}

TEST(JogCommand, WrongUsageIsOneLineWithStatus2) {
  const TemporaryFile rig("crane.toml", crane);
  const std::string path = rig.path().string();
  for (const auto& [arguments, status, words] :
       {std::tuple(std::vector<std::string>{"jog", "--rig", path, "--sim"}, 2, "AXIS is required"),
        {{"jog", "--rig", path, "track", "--sim"}, 2, "terminal"},
        {{"jog", "--rig", path, "track", "--from", "track=2"}, 2, "add --sim"},
        {{"jog", "--rig", path, "track", "--speed", "2"}, 2, "--speed"}}) {
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.status, status) << run.err;
    EXPECT_THAT(run.err, HasSubstr(words));
    EXPECT_EQ(std::ranges::count(run.err, '\n'), 1);
  }
}

TEST(JogCommand, ItsHelpTeachesIt) {
  const ProgramRun run = run_program({"jog", "--help"});
  EXPECT_EQ(run.status, 0);
  for (const char* word : {"AXIS", "--rig ", "--sim", "--speed ", "1 to 5", "150 ms", "unreferenced",
                           "--reach ", "kitty", "Examples:", "Exit status:"}) {
    EXPECT_THAT(run.out, HasSubstr(word));
  }
}

}  // namespace jog_test
}  // namespace inbetween
