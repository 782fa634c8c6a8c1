// A CiA 402 drive homes its axis by itself (mode of operation 6): the host's state machine, what a rig says
// of it, and the command.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <csignal>
#include <string>
#include <vector>

#include "host_tools/motions/home.hpp"
#include "inbetween/can/cia402_homing.hpp"
#include "tests/support/refused_text.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/simulated_can_rig.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace drive_home_test {

using can::DriveFinding;
using can::DriveHomingFailure;
using can::DriveHomingState;
using can::DrivePhase;
using testing::AllOf;
using testing::HasSubstr;
using Kind = DriveTrouble::Kind;

constexpr std::int64_t ms = 1'000'000;

// --- the state machine

TEST(DriveHoming, EveryStateTimesEveryEvent) {
  using enum DriveHomingState;
  const std::array<std::array<DriveHomingState, can::drive_homing_events>, can::drive_homing_states> expected{
      {
          // start, attained, failed, stop, stood, lost
          {seeking, waiting, waiting, ended, waiting, waiting},
          {seeking, done, halting, halting, seeking, ended},
          {halting, halting, halting, halting, ended, ended},
          {done, done, done, done, done, done},
          {ended, ended, ended, ended, ended, ended},
      }};
  for (std::size_t s = 0; s < can::drive_homing_states; ++s) {
    for (std::size_t e = 0; e < can::drive_homing_events; ++e) {
      EXPECT_EQ(next_state(static_cast<DriveHomingState>(s), static_cast<can::DriveHomingEvent>(e)),
                expected.at(s).at(e))
          << "state " << s << ", event " << e;
    }
  }
}

TEST(DriveHoming, TheMethodsAreThoseOfTheProfile) {
  std::string methods;
  for (int method = -128; method < 128; ++method) {
    if (can::is_homing_method(method)) methods += std::to_string(method) + " ";
  }
  EXPECT_EQ(methods,
            "1 2 3 4 5 6 7 8 9 10 11 12 13 14 17 18 19 20 21 22 23 24 25 26 27 28 29 30 33 34 35 37 ");
}

/// Ticks of 4 ms in which a drive tells bits 13, 12 and 10 of its statusword, and where it is.
struct Told {
  can::Cia402Homing homing{{.home = 500, .tolerance = 20, .max_step = 100, .timeout_ns = 5000 * ms}};
  std::int64_t now_ns = 0;

  Told() { homing.start(0); }
  void tell(unsigned bits, std::int32_t actual, int ticks = 1) {
    for (int i = 0; i < ticks; ++i) {
      const unsigned word = 0x0237U | (bits & 0b100U) << 11 | (bits & 0b010U) << 11 | (bits & 0b001U) << 10;
      homing.tick({.statusword = static_cast<std::uint16_t>(word), .actual = actual, .mode = 6},
                  now_ns += 4 * ms);
    }
  }
};

TEST(DriveHoming, IsDoneOnlyWhereItIsHomeAndStandsAndTellsItsPlace) {
  Told drive;
  drive.tell(0b001, 9000, 3);
  drive.tell(0b000, 9000);
  EXPECT_EQ(drive.homing.control_bits(), 0x0010);
  drive.tell(0b010, 480);
  EXPECT_EQ(drive.homing.state(), DriveHomingState::seeking) << "it moves";
  drive.tell(0b011, 480);
  EXPECT_EQ(drive.homing.state(), DriveHomingState::done);
  EXPECT_EQ(drive.homing.control_bits(), 0);
  Told other;
  other.tell(0b000, 9000);
  other.tell(0b011, -500);
  EXPECT_EQ(other.homing.failure(), DriveHomingFailure::elsewhere);
  EXPECT_EQ(other.homing.control_bits(), 0x0110) << "it is halted";
  other.tell(0b011, -500, 100);
  EXPECT_EQ(other.homing.state(), DriveHomingState::ended);
  EXPECT_FALSE(other.homing.start(other.now_ns)) << "nothing begins again";
}

TEST(DriveHoming, WhatIsToldOfTheOneBeforeIsNotTaken) {
  Told drive;
  drive.tell(0b011, 500, 200);
  EXPECT_EQ(drive.homing.state(), DriveHomingState::seeking) << "that may be old";
  drive.tell(0b011, 500, 100);
  EXPECT_EQ(drive.homing.state(), DriveHomingState::done) << "a second later it is not: it was over at once";
  Told failed;
  failed.tell(0b101, 9000, 3);
  failed.tell(0b000, 9000);
  EXPECT_EQ(failed.homing.failure(), DriveHomingFailure::none);
  failed.tell(0b100, 8900);
  EXPECT_EQ(failed.homing.failure(), DriveHomingFailure::error);
}

TEST(DriveHoming, OneThatIsFasterThanItWasToldIsHalted) {
  Told drive;
  drive.tell(0b000, 9000);
  drive.tell(0b000, 5000);
  drive.tell(0b000, 4900);
  EXPECT_EQ(drive.homing.state(), DriveHomingState::seeking) << "its new zero is one step";
  for (int i = 0; i < 3; ++i) drive.tell(0b000, 4900 - 101 * (i + 1));
  EXPECT_EQ(drive.homing.failure(), DriveHomingFailure::too_fast);
}

// --- the host's drive with a simulated one, whose switch is at 0 where it tells 500 then

class HomingDrive : public testing::Test {
 protected:
  SimulatedCanRig rig{1, setup()};
  double fastest = 0;

  static can::Cia402Setup setup() {
    can::Cia402Setup setup = SimulatedCanRig::default_setup();
    setup.homing =
        can::HomingSetup{.method = 17, .fast = 2000, .slow = 200, .acceleration = 10'000, .offset = 500};
    return setup;
  }
  void start() {
    ASSERT_TRUE(rig.bring_to_following())
        << words_of(rig.host_of(0).first_finding().value_or(DriveFinding::not_enabled)).what;
    for (int i = 0; i < 50; ++i) tick();
    EXPECT_EQ(rig.drive(0).position(), 1000) << "nothing moves before somebody starts it";
    ASSERT_TRUE(rig.host_of(0).homing()->start(rig.now_ns));
  }
  void tick() {
    rig.tick({1000});
    fastest = std::max(fastest, std::fabs(rig.drive(0).velocity()));
  }
  DriveHomingFailure end(int ticks = 2500) {
    for (int i = 0; i < ticks && !rig.host_of(0).homing()->is_over(); ++i) tick();
    EXPECT_TRUE(rig.host_of(0).homing()->is_over());
    return rig.host_of(0).homing()->failure();
  }
  void trouble(Kind kind) { rig.drive(0).add_trouble({.kind = kind, .at_ns = rig.now_ns + 200 * ms}); }
  void expect_rest() {
    for (int i = 0; i < 100; ++i) tick();
    EXPECT_LT(std::fabs(rig.drive(0).velocity()), 1);
  }
};

TEST_F(HomingDrive, FindsItsSwitchAndTellsThePositionOfIt) {
  start();
  EXPECT_EQ(rig.drive(0).objects().value(0x6098), 17U);
  EXPECT_EQ(rig.drive(0).objects().value(0x6099, 1), 2000U);
  EXPECT_EQ(rig.drive(0).objects().value(0x6099, 2), 200U);
  EXPECT_EQ(rig.drive(0).objects().value(0x609A), 10'000U);
  EXPECT_EQ(rig.drive(0).objects().value(0x607C), 500U);
  EXPECT_EQ(end(), DriveHomingFailure::none);
  EXPECT_EQ(rig.host_of(0).homing()->state(), DriveHomingState::done);
  EXPECT_NEAR(rig.drive(0).position(), 0, 10);
  EXPECT_NEAR(rig.host_of(0).feedback().actual, 500 + rig.drive(0).position(), 1);
  EXPECT_NEAR(fastest, 2000, 100);
  expect_rest();
  EXPECT_TRUE(rig.host_of(0).findings().empty());
  ASSERT_TRUE(rig.host_of(0).disable(rig.now_ns));
  EXPECT_TRUE(rig.tick_until([&] { return rig.all_are(DrivePhase::disabled); }));
}

// docs/faults.md
TEST_F(HomingDrive, OneThatNeverSeesItsSwitchIsHaltedInTime) {
  start();
  trouble(Kind::no_home);
  EXPECT_EQ(end(), DriveHomingFailure::timed_out);
  expect_rest();
}

TEST_F(HomingDrive, AHomingErrorHaltsIt) {
  start();
  trouble(Kind::homing_error);
  EXPECT_EQ(end(), DriveHomingFailure::error);
  expect_rest();
}

TEST_F(HomingDrive, AStopHaltsItByTheHaltBitAndItKeepsItsPower) {
  start();
  for (int i = 0; i < 70; ++i) tick();
  EXPECT_GT(std::fabs(rig.drive(0).velocity()), 1000);
  const auto target = static_cast<std::int32_t>(rig.drive(0).objects().value(0x607A));
  EXPECT_NEAR(target, rig.host_of(0).feedback().actual, 20) << "where it is, though nothing goes there";
  rig.host_of(0).homing()->stop(rig.now_ns);
  EXPECT_EQ(end(200), DriveHomingFailure::none);
  expect_rest();
  EXPECT_GT(rig.drive(0).position(), 300) << "short of its home";
  EXPECT_EQ(rig.host_of(0).homing()->state(), DriveHomingState::ended);
  EXPECT_EQ(rig.drive(0).state(), can::Cia402State::operation_enabled);
}

TEST_F(HomingDrive, OneThatLeavesItsModeIsStoppedAndHasNowhereToGo) {
  start();
  rig.drive(0).add_trouble({.kind = Kind::wrong_mode, .at_ns = rig.now_ns + 200 * ms, .value = 8});
  end();
  EXPECT_TRUE(rig.host_of(0).findings().has(DriveFinding::wrong_mode));
  EXPECT_EQ(rig.host_of(0).phase(), DrivePhase::stopping);
  expect_rest();
  EXPECT_NEAR(rig.drive(0).objects().value(0x607A), rig.host_of(0).feedback().actual, 20);
}

TEST_F(HomingDrive, WithoutSetpointsItsOwnWatchdogStopsIt) {
  start();
  for (int i = 0; i < 50; ++i) tick();
  for (int i = 0; i < 100; ++i) rig.tick();
  EXPECT_LT(std::fabs(rig.drive(0).velocity()), 1);
  EXPECT_NE(rig.drive(0).state(), can::Cia402State::operation_enabled);
  ASSERT_FALSE(rig.drive(0).record().reported.empty());
  EXPECT_EQ(rig.drive(0).record().reported.front().code, 0x8250) << "it missed them";
}

TEST_F(HomingDrive, OneThatDoesNotOfferItIsRefused) {
  rig.drive(0).add_object({.index = 0x6502}, {.value = 0x80});
  rig.connect();
  EXPECT_TRUE(rig.tick_until([&] { return rig.all_are(DrivePhase::refused); }));
  EXPECT_EQ(rig.host_of(0).refusal().finding, DriveFinding::mode_not_offered);
}

// --- what a rig says

const std::string table = rig_text(
    {axis_text(
         "slide", "mm", {0, 300}, {.velocity = 100, .acceleration = 400},
         R"(home = { by = "drive", method = 17, fast = 50, slow = 5, acceleration = 200, at = 10, timeout_s = 9 })",
         cia402_text(1, -1000)),
     axis_text("lift", "mm", {0, 300}, {.velocity = 100, .acceleration = 400}, "", cia402_text(2))},
    {.name = "table", .rate_hz = 250, .more = bus_can0});

/// The place is marked in `to`, or is the last `place` in the home of the slide. `without` is left out.
void refused(std::string_view from, std::string_view to, std::initializer_list<std::string_view> words,
             std::string_view place = "", std::string_view without = "") {
  std::string text = with(table, from, to);
  if (!without.empty()) text = with(text, without, "");
  if (!place.empty()) text.insert(text.rfind(place, text.find("name = \"lift\"")), "@");
  expect_refused([](std::string_view told, const std::string& file) { parse_rig(told, file); }, text, words);
}

TEST(DriveHomeInRig, IsReadInUnitsOfTheAxisAndOfTheDrive) {
  const RigAxis slide =
      parse_rig(with(table, "node = 1,", "node = 1, deceleration_per_unit = 2,"), "r").axes[0];
  ASSERT_TRUE(slide.drive_home);
  EXPECT_EQ(slide.reference, Reference::by_home);
  EXPECT_EQ(slide.drive_home->fast_speed, 50'000U);
  EXPECT_EQ(slide.drive_home->slow_speed, 5'000U);
  EXPECT_EQ(slide.drive_home->acceleration_rate, 400U);
  EXPECT_EQ(slide.drive_home->timeout_s, 9);
  EXPECT_NEAR(home_tolerance(slide), 0.125 + 0.05, 1e-12);
  const RigFile rpm = parse_rig(with(table, "fast = 50", "speed_per_unit = 6, fast = 50"), "r");
  EXPECT_EQ(rpm.axes[0].drive_home->fast_speed, 300U);
  const std::string usual = with(table, ", timeout_s = 9", "");
  EXPECT_EQ(parse_rig(usual, "r").axes[0].drive_home->timeout_s, 22);
}

TEST(DriveHomeInRig, WhatCannotBeIsRefusedAtItsPlace) {
  refused("method = 17", "method = @15", {"is 15, which CiA 402 does not have; write 1 to 14"});
  refused("method = 17", "method = @-1", {"which CiA 402 does not have"});
  refused("method = 17, fast", "method = 37, fast", {"fast has no meaning with method = 37"}, "50, slow");
  refused("fast = 50", "fast = @101", {"above max_velocity = 100"});
  refused("slow = 5", "slow = @50", {"not below fast = 50"});
  refused("acceleration = 200", "acceleration = @401", {"above max_acceleration = 400"});
  refused("fast = 50", "speed_per_unit = 1e-3, fast = @50", {"0 units of the drive", "takes 1 to"});
  refused("at = 10", "at = @-1", {"outside 0..300 mm"});
  refused("timeout_s = 9", "timeout_s = @0", {"write a number above 0"});
  refused("home = { by = \"drive\",", "home = @{", {"homes itself", "by = \"drive\""}, "", "method = 17, ");
  refused("node = 1,", "node = 1, reset = \"node\",", {"lets the drive forget its home"}, "\"drive\"");
  const std::string gear = "offset = 3\nhome = ";
  refused("home = ", gear, {"knows one motor"}, "\"drive\"");
  refused("home = ", "reference = @\"drive\"\nhome = ", {"the axis has a home; remove one of the two"});
  for (const char* other : {R"("odrive", firmware = "0.6", bus = "can0", node = 1, turns_per_unit = 0.1)",
                            R"("rmd", bus = "can0", node = 1, turns_per_unit = 0.1)"}) {
    refused(R"("cia402", bus = "can0", node = 1, counts_per_unit = -1000)", other,
            {"only a cia402 drive", "the tool of its maker"}, "\"drive\"");
  }
  refused(R"("cia402", bus = "can0", node = 1, counts_per_unit = -1000)",
          R"("pipe", path = "p", counts_per_unit = 1)", {"write the line of a switch"}, "\"drive\"");
}

// --- the command

/// The slide truly stands at 120, and its drive counts from there.
struct Home {
  RigFile rig;
  RigReference reference{rig};
  SessionOptions options{.simulated = true, .fast = true, .standing = {{"slide", 120}}};

  explicit Home(const std::string& text = table) : rig(parse_rig(text, "rig.toml")) {}
  SetupEnd run(const std::string& faults = "") {
    if (!faults.empty()) options.faults = parse_fault_script(faults, "faults.toml", rig);
    return home(rig, home_axes(rig, {}), reference, options);
  }
};

TEST(DriveHome, TheAxisIsWhereItsHomeSays) {
  Home home;
  const SetupEnd end = home.run();
  ASSERT_TRUE(end.is_done) << end.reason;
  EXPECT_NEAR(end.positions[0], 10, home_tolerance(home.rig.axes[0]));
  ASSERT_TRUE(home.reference.position(0) && home.reference.is_referenced(0));
  EXPECT_EQ(*home.reference.position(0), end.positions[0]);
}

TEST(DriveHome, AxesWithASwitchFollowOnceItIsHome) {
  Home home(table + R"([[axis]]
name = "pan"
unit = "deg"
min = -90
max = 90
max_velocity = 45
max_acceleration = 90
drive = { type = "step-dir", chip = "gpio", step = 19, dir = 26, steps_per_unit = 100 }
home = { chip = "gpio", line = 25, direction = "positive", fast = 15, slow = 1.5, back_off = 4, at = 92 }
)");
  home.options.standing["pan"] = 60;
  const SetupEnd end = home.run();
  ASSERT_TRUE(end.is_done) << end.reason;
  EXPECT_NEAR(end.positions[0], 10, home_tolerance(home.rig.axes[0]));
  EXPECT_NEAR(end.positions[2], 92, 3);
  EXPECT_TRUE(home.reference.is_referenced(0) && home.reference.is_referenced(2));
}

// docs/faults.md
TEST(DriveHome, EveryFaultEndsItInWordsAndTheAxisIsNotKnown) {
  const std::string fault = "[[fault]]\naxis = \"slide\"\nafter_motion = 0.3\nwhat = ";
  struct Row {
    std::string what;
    const char* words;
  };
  for (const Row& row :
       {Row{"\"no-home\"\n", "the drive has not found its home in time"},
        Row{"\"homing-error\"\n", "the drive tells a homing error"},
        Row{"\"lose-heartbeat\"\n", "the heartbeat of the drive has stopped"},
        Row{"\"emergency\"\ncode = 0x7320\n", "EMCY 7320"}, Row{"\"wrong-mode\"\nmode = 8\n", "mode"},
        Row{"\"reboot\"\n", "axis \"slide\": "}}) {
    Home home;
    const SetupEnd end = home.run(fault + row.what);
    EXPECT_FALSE(end.is_done) << row.what;
    EXPECT_THAT(end.reason, AllOf(HasSubstr("axis \"slide\": "), HasSubstr(row.words))) << row.what;
    EXPECT_FALSE(home.reference.is_referenced(0)) << row.what;
  }
}

TEST(DriveHome, TheOperatorAndTheEmergencyStopEndIt) {
  Home escaped;
  int asked = 0;
  escaped.options.audience.keys = [&] { return ++asked == 400 ? std::string("\x1b") : std::string(); };
  SetupEnd end = escaped.run();
  EXPECT_FALSE(end.is_done);
  EXPECT_EQ(end.reason, "stopped before its end");
  EXPECT_LT(end.positions[0], -0.5) << "it was on its way down, and counts from where it stood";
  EXPECT_FALSE(escaped.reference.is_referenced(0));
  Home stopped;
  asked = 0;
  stopped.options.audience.keys = [&] {
    if (++asked == 400) std::raise(SIGUSR1);
    return std::string();
  };
  end = stopped.run();
  EXPECT_FALSE(end.is_done);
  EXPECT_FALSE(stopped.reference.is_referenced(0));
}

struct Stage {
  TemporaryFile rig{"table.toml", table};
  TemporaryFolder folder;
  std::string positions = (folder.path() / "table.positions").string();

  [[nodiscard]] ProgramRun run(const char* command, std::vector<std::string> more) const {
    more.insert(more.begin(),
                {command, "--rig", rig.path().string(), "--sim", "--fast", "--positions", positions});
    return run_program(more);
  }
};

// The first target of the next command is where the drive stands: a jump would be a finding.
TEST(DriveHome, TheNextCommandGoesOnFromTheHomeWithoutAJump) {
  const Stage stage;
  EXPECT_THAT(stage.run("goto", {"--yes", "slide=50"}).err, HasSubstr("inbetween home"));
  const ProgramRun home = stage.run("home", {"--from", "slide=120"});
  ASSERT_EQ(home.status, 0) << home.out << home.err;
  EXPECT_THAT(home.out, AllOf(HasSubstr("the axes are home"), HasSubstr("slide")));
  const ProgramRun there = stage.run("goto", {"--yes", "slide=50"});
  EXPECT_EQ(there.status, 0) << there.out << there.err;
  const ProgramRun said = stage.run("goto", {"--set-zero", "slide"});
  EXPECT_EQ(said.status, 1);
}

// docs/faults.md
TEST(DriveHome, ADriveThatTellsAnotherPositionThanItWasLeftAtIsToHomeAgain) {
  const Stage stage;
  ASSERT_EQ(stage.run("home", {"--from", "slide=120"}).status, 0);
  const ProgramRun moved = stage.run("goto", {"--yes", "slide=50", "--from", "slide=11"});
  EXPECT_EQ(moved.status, 1) << moved.out;
  EXPECT_THAT(moved.err, AllOf(HasSubstr("its drive tells 11"), HasSubstr("inbetween home")));
  EXPECT_THAT(stage.run("goto", {"--yes", "slide=50"}).err, HasSubstr("does not know where it is"));
  ASSERT_EQ(stage.run("home", {"--from", "slide=11"}).status, 0);
  EXPECT_EQ(stage.run("goto", {"--yes", "slide=50"}).status, 0);
}

}  // namespace drive_home_test
}  // namespace inbetween
