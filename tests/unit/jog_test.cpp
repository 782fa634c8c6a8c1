// Hold to run: an axis moves as long as its key comes, and rests soon after it does not.
#include "host_tools/motions/jog.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/loop/loop_preparations.hpp"
#include "host_tools/plan/move_rolls.hpp"
#include "host_tools/rig/simulated_hardware.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace jog_test {

using testing::HasSubstr;

const std::string crane = R"(name = "crane"
rate_hz = 250
[[axis]]
name = "track"
unit = "mm"
min = 0
max = 500
max_velocity = 250
max_acceleration = 1000
max_jerk = 20000
reference = "operator"
drive = { type = "step-dir", chip = "gpio", step = 17, dir = 27, steps_per_unit = 40 }
[[axis]]
name = "pan"
unit = "deg"
min = -90
max = 90
max_velocity = 120
max_acceleration = 700
reference = "operator"
drive = { type = "step-dir", chip = "gpio", step = 19, dir = 26, steps_per_unit = 50 }
)";

const std::string left = "\x1b[D", right = "\x1b[C", up = "\x1b[A", down = "\x1b[B";
constexpr std::int64_t tick_ns = 4'000'000;
constexpr double tick_s = 0.004;
constexpr double speed = 5;

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
  std::vector<AxisLimits<double>> limits{limits_of(rig.axes[0]), limits_of(rig.axes[1])};
  std::optional<FreeAxes> free;
  std::optional<Jog> jog;
  std::optional<FastRunner> runner;

  std::map<int, std::string> typed;                 ///< by tick
  std::vector<std::vector<Setpoint<double>>> path;  ///< of both axes, as they were when a tick began
  std::vector<std::size_t> marks;
  int keeps = 0;
  std::function<void(int)> look = [](int) {};

  explicit Bench(const std::vector<double>& at = {100, 0}, bool is_referenced = true) : hardware(rig, at) {
    loop.emplace(drives, lines, room.memory());
    std::vector<FreeAxis<double>> axes;
    std::vector<JogAxis> jogged;
    for (std::size_t a = 0; a < 2; ++a) {
      axes.push_back(*FreeAxis<double>::make(free_limits_of(rig.axes[a], 1), at[a], tick_s));
      jogged.push_back({.name = rig.axes[a].name.c_str(),
                        .unit = "mm",
                        .speed = speed,
                        .is_referenced = is_referenced,
                        .way = 2});
    }
    free.emplace(std::move(axes));
    jog.emplace(*loop,
                FreeSpec<double>{.source = source_of<double>(*free),
                                 .drive_of = drive_of,
                                 .limits = limits,
                                 .tick_seconds = tick_s},
                *free, jogged, 0);
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
      } else {
        ++keeps;
        jog->kept();
      }
    }
  }
  [[nodiscard]] double at(int tick, std::size_t axis = 0) const {
    return path[static_cast<std::size_t>(tick) - 1][axis].position;
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

TEST(Jog, AHeldKeyMovesTheAxisAtItsSpeed) {
  Bench bench;
  bench.hold(right, 10, 260);
  bench.run(400);
  EXPECT_NEAR(bench.at(200) - bench.at(150), 50 * tick_s * speed, 1e-9);
  EXPECT_EQ(bench.at(400, 1), 0) << "the other one stands still";
  EXPECT_TRUE(bench.jog->was_left());
}

TEST(Jog, BothPairsOfKeysDoTheSame) {
  for (const auto& [key, sign] :
       {std::pair(right, 1), {left, -1}, {std::string("+"), 1}, {std::string("-"), -1}}) {
    Bench bench;
    bench.hold(key, 10, 260);
    bench.run(400);
    EXPECT_GT(sign * (bench.at(400) - 100), 3) << key;
  }
}

// docs/faults.md 41: whatever the period of the repeat and the moment of the last key, also while the speed
// rises.
TEST(Jog, RestsWithin200MillisecondsOfTheLastKey) {
  const Bench one;
  const double most = jog_speed(one.rig.axes[0], 1, tick_s);
  ASSERT_GT(most, 5);
  for (int period = 1; period <= 23; period += 2) {
    for (int count = 1; count <= 12; ++count) {
      Bench bench;
      bench.free->axes()[0] = *FreeAxis<double>::make(free_limits_of(bench.rig.axes[0], 1), 100, tick_s);
      std::vector<JogAxis> axes(2, {.name = "track", .unit = "mm", .speed = most});
      bench.jog.emplace(*bench.loop,
                        FreeSpec<double>{.source = source_of<double>(*bench.free),
                                         .drive_of = bench.drive_of,
                                         .limits = bench.limits,
                                         .tick_seconds = tick_s},
                        *bench.free, axes, 0);
      const int last = 10 + (count - 1) * period;
      bench.hold(right, 10, last, period);
      bench.run(last + 100);
      const int late = bench.last_motion() - last;
      ASSERT_GT(bench.last_motion(), 0);
      // The setpoint of a tick is reached by a stepper two ticks later.
      EXPECT_LE((late + 2) * tick_ns, 200'000'000) << "period " << period << ", " << count << " keys";
    }
  }
}

TEST(Jog, TheSpeedLeavesTimeForTheStopWhateverTheTick) {
  const RigFile rig = parse_rig(crane, "rig.toml");
  for (const double rate : {50.0, 100.0, 250.0, 1000.0}) {
    const double v = jog_speed(rig.axes[0], 1, 1 / rate);
    EXPECT_GT(v, 0) << rate;
    auto axis = *FreeAxis<double>::make(free_limits_of(rig.axes[0], 1), 100, 1 / rate);
    ASSERT_TRUE(axis.drive(v));
    for (int i = 0; i < 1000; ++i) axis.tick();
    EXPECT_LE(jog_key_missed_s + axis.stop_seconds() + 4 / rate, jog_stops_within_s) << rate;
  }
  EXPECT_EQ(jog_speed(rig.axes[0], 1, 1.0 / 20), 0) << "a tick is 50 ms";
  EXPECT_LE(jog_speed(rig.axes[0], 0.001, tick_s), 0.25) << "a thousandth of the limit";
}

TEST(Jog, AnyOtherKeyStops) {
  Bench bench;
  bench.hold(right, 10, 60);
  bench.typed[62] = " ";
  bench.run(200);
  EXPECT_LE(bench.last_motion(), 62 + 25);
}

TEST(Jog, TurningRoundNeedsNoStop) {
  Bench bench;
  bench.hold(right, 10, 260);
  bench.hold(left, 264, 700);
  bench.run(900);
  EXPECT_LT(bench.at(700), bench.at(264));
}

TEST(Jog, UpAndDownChooseTheAxisAndStopTheOther) {
  Bench bench;
  bench.hold(right, 10, 60);
  bench.typed[64] = down;
  bench.hold(right, 70, 120);
  bench.typed[200] = up;
  bench.hold(right, 208, 260);
  bench.run(400);
  EXPECT_GT(bench.at(100, 1), 0);
  EXPECT_EQ(bench.at(100), bench.at(200)) << "it rests";
  EXPECT_GT(bench.at(260), bench.at(200));
  EXPECT_EQ(bench.marks, (std::vector<std::size_t>{0, 1})) << "nothing was written in between";
}

TEST(Jog, StaysInsideTheSoftLimits) {
  Bench bench({499, 0});
  bench.hold(right, 10, 900);
  bench.run(1000);
  EXPECT_EQ(bench.at(1000), 500);
  for (int tick = 1; tick <= 1000; ++tick) ASSERT_LE(bench.at(tick), 500);
}

TEST(Jog, AnUnreferencedAxisGoesAShortWayUntilTheKeyIsLetGo) {
  Bench bench({100, 0}, false);
  bench.hold(right, 10, 500);
  std::string words;
  bench.look = [&](int tick) {
    if (tick == 490) words = bench.jog->snapshot().words;
  };
  bench.hold(right, 600, 1000);
  bench.run(1200);
  EXPECT_EQ(bench.at(500), 102);
  EXPECT_EQ(bench.at(599), 102);
  EXPECT_EQ(bench.at(1200), 104);
  EXPECT_THAT(words, HasSubstr("let go"));
}

// The range of an axis that does not know where it is has nothing to do with its limits.
TEST(Jog, AnUnreferencedAxisHasNoSoftLimits) {
  Bench bench({500, 0}, false);
  bench.hold(right, 10, 500);
  bench.run(700);
  EXPECT_EQ(bench.at(700), 502);
}

TEST(Jog, NothingMovesBeforeItIsMarkedAndItIsKeptAfterRest) {
  Bench bench;
  bench.look = [&](int tick) {
    if (bench.marks.empty()) {
      EXPECT_EQ(bench.at(tick), 100);
    }
  };
  bench.hold(right, 10, 60);
  bench.hold(right, 400, 460);
  bench.run(900);
  EXPECT_EQ(bench.marks, (std::vector<std::size_t>{0, 0}));
  EXPECT_EQ(bench.keeps, 2);
}

// A disk that took longer than the key may be missed: the key is not held any more, as far as anybody knows.
TEST(Jog, AKeyFromBeforeASlowDiskMovesNothing) {
  Bench bench;
  bench.typed[10] = right;
  ASSERT_TRUE(bench.runner->run(*bench.jog, std::nullopt).begun);
  ASSERT_EQ(bench.jog->asks(), Jog::Ask::mark);
  for (int i = 0; i < 30; ++i) bench.loop->tick(1, (1000 + i) * tick_ns);
  bench.jog->marked();
  ASSERT_TRUE(bench.jog->begin());
  for (int i = 0; i < 30; ++i) bench.jog->tick(1, (1030 + i) * tick_ns);
  EXPECT_EQ(bench.loop->setpoints()[0].position, 100);
}

TEST(Jog, AnEmergencyStopIsTheEndAndNotTheOperators) {
  Bench bench;
  bench.hold(right, 10, 260);
  bench.look = [](int tick) {
    if (tick == 100) std::raise(SIGUSR1);
  };
  bench.run(900);
  EXPECT_FALSE(bench.jog->was_left());
  EXPECT_LT(bench.path.size(), 110U);
}

TEST(Jog, ALateTickDoesNotLengthenTheStop) {
  Bench bench;
  bench.hold(right, 10, 60);
  bench.run(900);
  // 60 was the last key; the watch is on time, not on ticks.
  Bench late;
  ASSERT_TRUE(late.jog->begin());
  late.jog->tick(1, tick_ns);
  late.jog->press(TransportKey::step_forward);
  late.jog->marked();
  late.jog->press(TransportKey::step_forward);
  for (int i = 2; i < 12; ++i) late.jog->tick(1, i * tick_ns);
  EXPECT_GT(late.jog->snapshot().jog->velocity, 0);
  late.jog->tick(1, 12 * tick_ns + 100'000'000);
  const double velocity = late.jog->snapshot().jog->velocity;
  late.jog->tick(1, 13 * tick_ns + 100'000'000);
  EXPECT_LT(late.jog->snapshot().jog->velocity, velocity);
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
  static std::map<int, std::string> held(const std::string& key, int from, int to, int end) {
    std::map<int, std::string> typed{{end, "q"}};
    for (int tick = from; tick <= to; tick += 8) typed[tick] = key;
    return typed;
  }
};

TEST(Jog, ItsEndIsKept) {
  Hands hands;
  RigReference(hands.rig, hands.file).stands_at(0, 100);
  RigReference reference(hands.rig, hands.file);
  const SetupEnd end = hands.jog(reference, Hands::held(right, 10, 500, 520));
  EXPECT_TRUE(end.is_done) << end.reason;
  EXPECT_GT(end.positions[0], 102);
  EXPECT_EQ(RigReference(hands.rig, hands.file).position(0), end.positions[0]);
  EXPECT_EQ(RigReference(hands.rig, hands.file).position(1), std::nullopt) << "nobody knew before, either";
}

TEST(Jog, AnUnreferencedAxisIsSlowerAndStaysUnreferenced) {
  Hands hands;
  RigReference(hands.rig, hands.file).stands_at(0, 100);
  RigReference referenced(hands.rig, hands.file);
  const double way = hands.jog(referenced, Hands::held(right, 10, 250, 300)).positions[0] - 100;
  const TemporaryFolder elsewhere;
  RigReference lost(hands.rig, (elsewhere.path() / "p").string());
  hands.ticks = 0;
  const SetupEnd end = hands.jog(lost, Hands::held(right, 10, 250, 300));
  const double share = jog_speed(hands.rig.axes[0], 0.01, tick_s) / jog_speed(hands.rig.axes[0], 0.1, tick_s);
  EXPECT_LT(share, 0.5);
  EXPECT_NEAR(end.positions[0], way * share, way * 0.02);
  EXPECT_FALSE(lost.is_referenced(0));
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
  for (const char* word :
       {"AXIS", "--rig ", "--sim", "--speed ", "200 ms", "unreferenced", "Examples:", "Exit status:"}) {
    EXPECT_THAT(run.out, HasSubstr(word));
  }
}

}  // namespace jog_test
}  // namespace inbetween
