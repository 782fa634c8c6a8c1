// inbetween home: axes of a rig find their switches together, or say why not.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "host_tools/loop/loop_preparations.hpp"
#include "host_tools/loop/loop_runner.hpp"
#include "host_tools/loop/loop_storage.hpp"
#include "host_tools/loop/manual_motion.hpp"
#include "host_tools/motions/home.hpp"
#include "host_tools/motions/rig_homing.hpp"
#include "host_tools/plan/move_rolls.hpp"
#include "host_tools/rig/simulated_hardware.hpp"
#include "sim/simulated_switch.hpp"
#include "tests/support/places.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace home_command_test {

using testing::AllOf;
using testing::HasSubstr;

const std::string slider = rig_text(
    {axis_text(
         "slide", "mm", {0, 800}, {.velocity = 120, .acceleration = 250, .jerk = 1500},
         R"(home = { chip = "gpio", line = 23, active = "high", direction = "negative", fast = 40, slow = 4, back_off = 10, at = -5 })",
         R"(type = "step-dir", chip = "gpio", step = 17, dir = 27, steps_per_unit = 80)"),
     axis_text("focus", "deg", {0, 270}, {.velocity = 120, .acceleration = 480}, R"(reference = "operator")",
               R"(type = "step-dir", chip = "gpio", step = 5, dir = 6, steps_per_unit = 10)"),
     axis_text(
         "pan", "deg", {-90, 90}, {.velocity = 45, .acceleration = 90},
         R"(home = { chip = "gpio", line = 25, active = "high", direction = "positive", fast = 15, slow = 1.5, back_off = 4, at = 92 })",
         R"(type = "step-dir", chip = "gpio", step = 19, dir = 26, steps_per_unit = 100)")},
    {.name = "slider", .rate_hz = 250});

constexpr std::int64_t tick_ns = 4'000'000;
constexpr double tick_s = 0.004;

/// Home switches of slide and pan (HomeLines), on shafts that are somewhere else than the axes believe.
struct Switches {
  std::vector<SimulatedSwitch> of;
  std::vector<LineEvent> now, coming;
  std::vector<HomingInput> inputs = std::vector<HomingInput>(3);

  static std::size_t number(std::size_t axis) { return axis == 0 ? 0 : 1; }
  [[nodiscard]] HomingInput homing_input(std::size_t axis) const {
    HomingInput input = inputs[axis];
    input.level = of[number(axis)].level();
    return input;
  }
  [[nodiscard]] std::span<const LineEvent> events() const { return now; }
  [[nodiscard]] static SwitchSettings home_switch(std::size_t axis) {
    return {.line = static_cast<std::uint8_t>(number(axis))};
  }
};
static_assert(HomeLines<Switches>);

/// A slider that takes itself to be at 0 everywhere, and homes slide and pan.
struct Bench {
  RigFile rig = parse_rig(slider, "rig.toml");
  std::vector<double> truly;  ///< slide and pan, at the beginning
  Switches switches;
  SimulatedHardware hardware{rig, {0, 0, 0}};
  RigInputs lines{rig, hardware};
  RigDrives drives{rig, hardware};
  LoopStorage room{3, 3};
  RunLoop loop{drives, lines, room.memory()};
  LoopTrace trace{3};
  LoopAudience audience;
  std::vector<std::size_t> axes{0, 2};
  std::vector<double> positions{0, 0, 0};
  std::vector<AxisLimits> limits{limits_of(rig.axes[0]), limits_of(rig.axes[2])};
  std::optional<RigHoming<Switches>> homing;
  std::vector<Setpoint> was = std::vector<Setpoint>(2);
  std::vector<double> fastest{0, 0};
  int ticks = 0;
  std::function<void(int)> look = [](int) {};

  Bench(double slide, double pan) : truly{slide, pan} {
    for (std::size_t i = 0; i < 2; ++i) {
      const Home& home = *rig.axes[axes[i]].home;
      switches.of.emplace_back(SimulatedSwitch::Settings{.line = static_cast<std::uint8_t>(i),
                                                         .is_above = home.direction > 0,
                                                         .closes = home.at,
                                                         .hysteresis = 0.5,
                                                         .bounce_s = 0.001,
                                                         .max_bounces = 4},
                               truly[i], 7 + static_cast<std::uint32_t>(i));
    }
    homing.emplace(rig, axes, switches,
                   RigHoming<Switches>::Setting{.positions = positions,
                                                .drives = loop.drive_states(),
                                                .tick_seconds = tick_s,
                                                .delay_ns = tick_ns});
    audience.keys = [] { return std::string(); };
  }

  // A FreeSource: the homing, and the shafts, which follow within a tick.
  void tick(std::int64_t now_ns, std::span<Setpoint> out) {
    look(++ticks);
    switches.now = std::exchange(switches.coming, {});
    std::ranges::sort(switches.now, {}, &LineEvent::at_ns);
    homing->tick(now_ns, out);
    for (std::size_t i = 0; i < 2; ++i) {
      switches.of[i].move(now_ns, there(i, was[i]), now_ns + tick_ns, there(i, out[i]), switches.coming);
      fastest[i] = std::max(fastest[i], std::fabs(out[i].velocity));
      was[i] = out[i];
    }
  }
  void stop() { homing->stop(); }
  void halt() { homing->halt(); }
  [[nodiscard]] bool is_resting() const { return homing->is_resting(); }

  [[nodiscard]] Setpoint there(std::size_t i, Setpoint setpoint) const {
    setpoint.position += truly[i];
    return setpoint;
  }
  /// By how much axis `i` of both is wrong about where it is.
  [[nodiscard]] double error(std::size_t i) const {
    return std::fabs(was[i].position + homing->shift(i) - there(i, was[i]).position);
  }
  bool run() {
    FastRunner runner(loop, 250, audience, trace);
    Arming arming(loop);
    runner.run(arming, std::nullopt);
    ManualMotion play(
        loop, {.source = source_of(*this), .drive_of = axes, .limits = limits, .tick_seconds = tick_s},
        "homing");
    const ActEnd end = runner.run(play, std::nullopt);
    EXPECT_TRUE(end.begun);
    return end.begun && play.is_done() && homing->is_done();
  }
};

TEST(RigHoming, AxesThatBelieveToBeElsewhereHomeTogether) {
  Bench bench(310, -40);
  ASSERT_TRUE(bench.run()) << bench.homing->reason();
  EXPECT_LT(bench.error(0), 1.0 / 80) << "within a count";
  EXPECT_LT(bench.error(1), 1.0 / 100);
  EXPECT_EQ(bench.homing->reason(), "");
  EXPECT_LE(bench.fastest[0], 40.001);
  EXPECT_LE(bench.fastest[1], 15.001);
}

TEST(RigHoming, AnAxisThatStandsOnItsSwitchLeavesItFirst) {
  Bench bench(-8, 93);
  ASSERT_TRUE(bench.run()) << bench.homing->reason();
  EXPECT_LT(bench.error(0), 1.0 / 80);
  EXPECT_LT(bench.error(1), 1.0 / 100);
}

// docs/faults.md 33
TEST(RigHoming, ASwitchThatIsStuckEndsItAndTheAxisStaysNearIt) {
  Bench bench(-8, 60);
  bench.switches.of[0].set_fault(SimulatedSwitch::Fault::stuck);
  EXPECT_FALSE(bench.run());
  EXPECT_THAT(bench.homing->reason(), HasSubstr("axis \"slide\": "));
  EXPECT_LT(bench.was[0].position, 60) << "it does not go through the rig";
}

TEST(RigHoming, ASwitchThatIsNotThereEndsItAndTheOtherAxisStopsToo) {
  Bench bench(20, -60);
  bench.switches.of[0].set_fault(SimulatedSwitch::Fault::open);
  EXPECT_FALSE(bench.run());
  EXPECT_THAT(bench.homing->reason(),
              AllOf(HasSubstr("axis \"slide\": "), HasSubstr(words_of(HomingFailure::never_reached)),
                    HasSubstr(remedy_of(HomingFailure::never_reached))));
}

TEST(RigHoming, ALimitSwitchOnTheWayEndsItByName) {
  Bench bench(300, -60);
  bench.look = [&](int tick) { bench.switches.inputs[2].limit_hit = tick > 200; };
  EXPECT_FALSE(bench.run());
  EXPECT_THAT(bench.homing->reason(),
              AllOf(HasSubstr("axis \"pan\": "), HasSubstr(words_of(HomingFailure::limit_hit))));
}

// The loop reads its lines first and stops for them; the homing still says which it was.
TEST(RigHoming, AStopByTheLoopForALimitSwitchNamesTheAxis) {
  Bench bench(300, -60);
  bench.look = [&](int tick) {
    if (tick != 200) return;
    bench.switches.inputs[2].limit_hit = true;
    bench.loop.post(SupervisorEvent::stop);
  };
  EXPECT_FALSE(bench.run());
  EXPECT_THAT(bench.homing->reason(),
              AllOf(HasSubstr("axis \"pan\": "), HasSubstr(words_of(HomingFailure::limit_hit))));
}

TEST(RigHoming, WhoStandsOnALimitSwitchDoesNotBegin) {
  Bench bench(300, -60);
  bench.switches.inputs[0].limit_hit = true;
  EXPECT_FALSE(bench.run());
  EXPECT_THAT(bench.homing->reason(), AllOf(HasSubstr("axis \"slide\": "), HasSubstr("limit switch")));
  EXPECT_EQ(bench.was[0].position, 0);
  EXPECT_EQ(bench.was[1].position, 0);
}

TEST(RigHoming, TheOperatorStopsIt) {
  Bench bench(300, -60);
  int keys = 0;
  bench.audience.keys = [&] { return ++keys == 100 ? std::string("\x1b") : std::string(); };
  EXPECT_FALSE(bench.run());
  EXPECT_EQ(bench.homing->reason(), "") << "no axis was the reason";
  EXPECT_LT(keys, 200);
}

TEST(RigHoming, AnEmergencyStopEndsIt) {
  Bench bench(300, -60);
  bench.look = [](int tick) {
    if (tick == 100) std::raise(SIGUSR1);
  };
  EXPECT_FALSE(bench.run());
  EXPECT_LT(bench.ticks, 105);
}

// From end to end: drives that make steps, switches that follow the shafts, and edges with times.
TEST(RigHoming, OnTheLinesOfARigEveryAxisKnowsWhereItsShaftIs) {
  const RigFile rig = parse_rig(slider, "rig.toml");
  const std::vector<double> truly{310, 0, -40};
  SimulatedHardware hardware(rig, truly);
  RigInputs lines(rig, hardware);
  RigDrives drives(rig, hardware);
  for (std::size_t a = 0; a < 3; ++a) drives.place(a, 7);  // whatever was counted
  LoopStorage room(3, 3);
  RunLoop loop(drives, lines, room.memory());
  LoopTrace trace(3);
  const LoopAudience audience;
  FastRunner runner(loop, 250, audience, trace);
  Arming arming(loop);
  runner.run(arming, std::nullopt);
  const std::vector<std::size_t> axes{0, 2};
  const std::vector<AxisLimits> limits{limits_of(rig.axes[0]), limits_of(rig.axes[2])};
  RigHoming<RigInputs> homing(rig, axes, lines,
                              {.positions = arming.positions(),
                               .drives = loop.drive_states(),
                               .tick_seconds = tick_s,
                               .delay_ns = 2 * tick_ns});
  ManualMotion play(loop,
                    {.source = source_of(homing), .drive_of = axes, .limits = limits, .tick_seconds = tick_s},
                    "homing");
  ASSERT_TRUE(runner.run(play, std::nullopt).begun);
  Arriving arriving(loop, 250);
  runner.run(arriving, std::nullopt);
  ASSERT_TRUE(homing.is_done()) << homing.reason();
  for (std::size_t i = 0; i < 2; ++i) {
    const double says = loop.drive_states()[axes[i]].actual + homing.shift(i);
    EXPECT_NEAR(says, hardware.true_position(axes[i]), 1.0 / (i == 0 ? 80 : 100)) << axes[i];
  }
}

// --- and where they park

/// The slider whose slide parks at 100, on a virtual clock, with a key before a tick.
struct Parking {
  RigFile rig = parse_rig(text(), "rig.toml");
  RigReference reference{rig};
  int ticks = 0;

  static std::string text() {
    std::string text = slider;
    return text.insert(text.find("at = -5") + 7, ", park = 100");
  }
  SetupEnd home(int key_at = -1) {
    SessionOptions options{
        .simulated = true, .fast = true, .standing = {{"slide", 30}, {"focus", 40}, {"pan", 80}}};
    ticks = 0;
    options.audience.keys = [this, key_at] { return ++ticks == key_at ? "\x1b" : ""; };
    return inbetween::home(rig, home_axes(rig, {}), reference, options);
  }
};

TEST(Home, AnAxisWithAParkGoesThereSlowlyOnceAllAreHome) {
  Parking bench;
  const SetupEnd end = bench.home();
  EXPECT_TRUE(end.is_done) << end.reason;
  EXPECT_EQ(end.reason, "the axes are home, and parked");
  EXPECT_NEAR(end.positions[0], 100, 1.0 / 80);
  EXPECT_NEAR(*bench.reference.position(0), 100, 1.0 / 80) << "and that is kept";
  EXPECT_NEAR(end.positions[2], 92, 3) << "without a park it stays behind its switch";
  const int with_park = bench.ticks;
  bench.rig.axes[0].park.reset();
  EXPECT_EQ(bench.home().reason, "the axes are home");
  // From its switch at -5, at 12 mm/s, a tenth of its velocity.
  EXPECT_GT(with_park - bench.ticks, 100 / 12.0 * 250) << "no faster than any transit";
}

TEST(Home, AStopOnTheWayToItsParkIsSaidAndTheAxisIsHome) {
  Parking bench;
  ASSERT_TRUE(bench.home().is_done);
  const SetupEnd end = bench.home(bench.ticks - 500);
  EXPECT_FALSE(end.is_done);
  EXPECT_THAT(end.reason, HasSubstr("the axes are home, but not parked: stopped on the way"));
  EXPECT_GT(end.positions[0], 0);
  EXPECT_LT(end.positions[0], 99);
  EXPECT_TRUE(bench.reference.is_referenced(0));
}

TEST(Home, NothingParksWhereAHomingFailed) {
  Parking bench;
  const SetupEnd end = bench.home(100);
  EXPECT_FALSE(end.is_done);
  EXPECT_THAT(end.reason, testing::Not(HasSubstr("park")));
}

// --- the command

struct Stage {
  TemporaryFile rig{"slider.toml", slider};
  TemporaryFolder folder;
  std::string path = rig.path().string();
  std::string positions = (folder.path() / "slider.positions").string();

  [[nodiscard]] ProgramRun home(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"home", "--rig", path});
    return run_program(arguments);
  }
};

void expect_refused(const ProgramRun& run, int status, const std::vector<std::string>& words) {
  EXPECT_EQ(run.status, status) << run.err;
  EXPECT_EQ(run.out, "");
  EXPECT_EQ(std::ranges::count(run.err, '\n'), 1) << run.err;
  for (const std::string& word : words) EXPECT_THAT(run.err, HasSubstr(word));
}

/// The arguments behind the last "inbetween" of a line.
std::vector<std::string> last_command(const std::string& line) {
  std::istringstream words(line.substr(line.rfind("inbetween ") + 10));
  std::vector<std::string> command;
  for (std::string word; words >> word && word != "brings";) command.push_back(word);
  return command;
}

// An axis of every kind of drive that has no switch: the command that is named takes it.
TEST(HomeCommand, AnAxisWithoutASwitchIsToldTheCommandThatTakesIt) {
  const TemporaryFolder folder;
  const std::string bus = "[bus.can0]\nbitrate = 1000000\n";
  const std::string by_hand = "reference = \"operator\"\n";
  const std::vector<std::pair<std::string, std::string>> drives{
      {"type = \"pipe\", path = \"/dev/null\", counts_per_unit = 1", ""},
      {"type = \"step-dir\", chip = \"gpio\", step = 17, dir = 27, steps_per_unit = 40", by_hand},
      {"type = \"cia402\", bus = \"can0\", node = 1, counts_per_unit = 1000", ""},
      {"type = \"cia402\", bus = \"can0\", node = 1, counts_per_unit = 1000", by_hand},
      {"type = \"odrive\", bus = \"can0\", node = 1, firmware = \"0.6\", turns_per_unit = 0.01", by_hand},
      {"type = \"odrive\", bus = \"can0\", node = 1, firmware = \"0.6\", turns_per_unit = 0.01",
       "reference = \"drive\"\n"},
      {"type = \"moteus\", bus = \"can0\", node = 1, turns_per_unit = 0.01", by_hand},
      {"type = \"rmd\", bus = \"can0\", node = 1, turns_per_unit = 0.01", by_hand},
      {"type = \"cubemars\", bus = \"can0\", node = 1, turns_per_unit = 0.01, pole_pairs = 21, gear = 9, "
       "no_watchdog = \"accepted\"",
       by_hand}};
  for (const auto& [drive, reference] : drives) {
    for (const double min : {-100.0, 50.0}) {
      const bool is_fd = drive.find("moteus") != std::string::npos;
      const TemporaryFile rig(
          "rig.toml",
          rig_text({{.name = "x", .min = min, .more = reference + "unpowered = \"holds\"", .drive = drive}},
                   {.more = is_fd ? bus + "data_bitrate = 5000000\n" : bus}));
      const ProgramRun refused = run_program({"home", "--rig", rig.path().string(), "x", "--sim", "--fast"});
      EXPECT_EQ(refused.status, 1) << drive;
      EXPECT_THAT(refused.err, HasSubstr("axis \"x\" has no home switch; ")) << drive;
      std::vector<std::string> command = last_command(refused.err);
      const std::string positions = (folder.path() / "positions.toml").string();
      const bool says = refused.err.find("say so") != std::string::npos;
      const std::vector<std::string> simulated = says ? std::vector<std::string>{"--positions", positions}
                                                      : std::vector<std::string>{"--sim", "--fast", "--yes"};
      command.insert(command.end(), simulated.begin(), simulated.end());
      const ProgramRun taken = run_program(command);
      EXPECT_EQ(taken.status, 0) << drive << "\n" << refused.err << taken.err;
      std::filesystem::remove(positions);
    }
  }
}

TEST(HomeCommand, BadInputIsOneLine) {
  const Stage stage;
  expect_refused(stage.home({"roll", "--sim", "--fast"}), 1, {"no axis \"roll\"", "slide, focus, pan"});
  expect_refused(stage.home({"focus", "--sim", "--fast"}), 1,
                 {"slider.toml:13:1: error: axis \"focus\" has no home switch", "--set-zero focus"});
  expect_refused(
      run_program({"home", "--rig", in_checkout("examples/camera_rig.toml"), "pan", "--sim", "--fast"}), 1,
      {"axis \"pan\" has no home switch", "its drive says where it is, and inbetween goto --rig"});
  const TemporaryFile none("none.toml", rig_text({stepper_track()}));
  expect_refused(run_program({"home", "--rig", none.path().string(), "--sim", "--fast"}), 1,
                 {"no axis of the rig has a home switch"});
}

TEST(HomeCommand, WrongUsageIsOneLineWithStatus2) {
  const Stage stage;
  expect_refused(stage.home({"--fast"}), 2, {"add --sim", "home --help"});
  expect_refused(stage.home({"--from", "slide=1"}), 2, {"add --sim"});
  expect_refused(stage.home({"--sim", "--allow-jitter"}), 2, {"leave out --sim"});
  expect_refused(run_program({"home"}), 2, {"--rig is required"});
}

TEST(HomeCommand, ItsHelpTeachesIt) {
  const ProgramRun run = run_program({"home", "--help"});
  EXPECT_EQ(run.status, 0);
  for (const char* word :
       {"AXIS", "--rig ", "--sim", "--fast", "--from ", "--positions ", "Examples:", "Exit status:"}) {
    EXPECT_THAT(run.out, HasSubstr(word));
  }
}

// With the switches of the simulated rig.
TEST(HomeCommand, HomesASimulatedRigAndKeepsWhereItStands) {
  const Stage stage;
  const ProgramRun run = stage.home(
      {"--sim", "--fast", "--positions", stage.positions, "--from", "slide=300", "--from", "pan=-20"});
  EXPECT_EQ(run.status, 0) << run.out << run.err;
  EXPECT_THAT(run.out, HasSubstr("the axes are home"));
  const RigFile rig = parse_rig(slider, "rig.toml");
  const RigReference kept(rig, stage.positions);
  ASSERT_TRUE(kept.position(0) && kept.position(2));
  EXPECT_NEAR(*kept.position(0), -5, 3) << "it rests a little behind the edge";
  EXPECT_NEAR(*kept.position(2), 92, 3);
  EXPECT_FALSE(kept.is_referenced(1)) << "it has no switch";
  EXPECT_THAT(run.out,
              HasSubstr("goto --rig " + stage.path + " --sim --positions " + stage.positions + " slide=0"))
      << "of the simulated rig, and of no real one";
}

}  // namespace home_command_test
}  // namespace inbetween
