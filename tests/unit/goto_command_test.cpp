// inbetween goto as its users meet it, and what it leaves behind.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include "host_tools/motions/go_to.hpp"
#include "tests/support/places.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace goto_command_test {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const std::string crane = rig_text({stepper_track(),
                                    axis_text("pan", "deg", {-90, 90}, {.velocity = 120, .acceleration = 700},
                                              R"(reference = "operator")", cia402_text(1)),
                                    axis_text("tilt", "deg", {-30, 30}, {.velocity = 60, .acceleration = 100},
                                              R"(reference = "drive")", cia402_text(2))},
                                   {.name = "crane", .rate_hz = 250, .more = bus_can0});

/// The rig in a file, and a file for its positions.
struct Stage {
  TemporaryFile rig{"crane.toml", crane};
  TemporaryFolder folder;
  std::string path = rig.path().string();
  std::string positions = (folder.path() / "crane.positions").string();

  [[nodiscard]] ProgramRun go(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"goto", "--rig", path});
    return run_program(arguments);
  }
  /// Simulated, with the positions kept.
  [[nodiscard]] ProgramRun go_kept(std::vector<std::string> arguments) const {
    arguments.insert(arguments.end(), {"--sim", "--fast", "--yes", "--positions", positions});
    return go(arguments);
  }
};

/// One line to standard error, this status, and nothing else.
void expect_refused(const ProgramRun& run, int status, const std::vector<std::string>& words) {
  EXPECT_EQ(run.status, status) << run.err;
  EXPECT_EQ(run.out, "");
  EXPECT_EQ(std::ranges::count(run.err, '\n'), 1) << run.err;
  for (const std::string& word : words) EXPECT_THAT(run.err, HasSubstr(word));
}

TEST(GotoCommand, SaysWhatMovesAndGoesThere) {
  const Stage stage;
  const ProgramRun run = stage.go({"track=120", "pan=-10", "--from", "pan=20", "--sim", "--fast", "--yes"});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.err,
              AllOf(HasSubstr("track                  0.000 -> 120.000 mm"),
                    HasSubstr("pan                   20.000 -> -10.000 deg"), HasSubstr(" s, at 10 %")));
  EXPECT_THAT(run.out, AllOf(HasSubstr("the axes are there"), HasSubstr("track               120.0000 mm"),
                             HasSubstr("pan                 -10.0000 deg"), Not(HasSubstr("tilt"))));
}

// Ten times as fast takes a tenth of the time, and more where the acceleration counts.
TEST(GotoCommand, TheShareSaysHowFast) {
  const Stage stage;
  EXPECT_THAT(stage.go({"track=450", "--sim", "--fast", "--yes"}).err, HasSubstr("in 18.3 s, at 10 %"));
  EXPECT_THAT(stage.go({"track=450", "--sim", "--fast", "--yes", "--speed", "1"}).err,
              HasSubstr("in 2.1 s, at 100 %"));
}

// The rounding of a position is no jump: at its limit an axis was stopped on the way.
TEST(GotoCommand, AllOfTheLimitsIsNotMoreThanThem) {
  for (const char* from : {"slide=0.1", "slide=1", "slide=333.3"}) {
    for (const char* to : {"slide=555.5", "slide=803", "slide=1799"}) {
      const ProgramRun run = run_program({"goto", "--rig", in_checkout("examples/camera_rig.toml"), to,
                                          "--sim", "--fast", "--from", from, "--speed", "1", "--yes"});
      EXPECT_EQ(run.status, 0) << from << " " << to << "\n" << run.out;
    }
  }
}

TEST(GotoCommand, AnAxisThatIsThereDoesNotMove) {
  const Stage stage;
  const ProgramRun run = stage.go({"track=0", "--sim", "--fast", "--yes"});
  EXPECT_EQ(run.status, 0);
  EXPECT_THAT(run.out, HasSubstr("there already"));
  EXPECT_EQ(run.err, "");
}

// docs/faults.md 49
TEST(GotoCommand, AnAxisOutsideItsLimitsComesInSlowlyFromEitherSide) {
  for (const char* type : {R"(type = "cia402", bus = "can0", node = 1, counts_per_unit = 1000)",
                           R"(type = "step-dir", chip = "gpio", step = 17, dir = 27, steps_per_unit = 40)"}) {
    const bool is_stepper = std::string(type).find("step-dir") != std::string::npos;
    const TemporaryFile rig(
        "rig.toml",
        rig_text({axis_text("slide", "mm", {0, 1200}, {.velocity = 250, .acceleration = 500, .jerk = 5000},
                            is_stepper ? R"(reference = "operator")" : R"(reference = "drive")", type)},
                 {.rate_hz = 250, .more = bus_can0}));
    for (const auto& [stands, to] :
         {std::pair{"-3", "0"}, {"-20", "0"}, {"1203", "1200"}, {"1260", "1100"}}) {
      const std::vector<std::string> words{"goto",
                                           "--rig",
                                           rig.path().string(),
                                           "--sim",
                                           "--fast",
                                           "--yes",
                                           std::string("slide=") + to,
                                           "--from",
                                           std::string("slide=") + stands};
      const ProgramRun there = run_program(words);
      EXPECT_EQ(there.status, 0) << stands << there.out << there.err;
      EXPECT_THAT(there.err, AllOf(HasSubstr(std::string(stands) + ".000 -> " + to + ".000 mm"),
                                   HasSubstr("at 10 % of its limits")));
      EXPECT_THAT(there.out, HasSubstr("the axes are there"));
      std::vector<std::string> hurried = words;
      hurried.insert(hurried.end(), {"--speed", "0.5"});
      const ProgramRun refused = run_program(hurried);
      EXPECT_EQ(refused.status, 1);
      EXPECT_THAT(refused.err,
                  HasSubstr("outside its limits 0..1200 mm, and comes in at --speed 0.1 at most"));
    }
  }
}

TEST(GotoCommand, OutsideTheLimitsNothingMoves) {
  const Stage stage;
  expect_refused(stage.go({"tilt=31", "--sim", "--fast", "--yes"}), 3,
                 {"crane.toml:24:1: error: axis \"tilt\"", "31 deg", "-30..30"});
}

TEST(GotoCommand, BadInputIsOneLine) {
  const Stage stage;
  expect_refused(stage.go({"roll=1", "--sim", "--fast", "--yes"}), 1,
                 {"no axis \"roll\"", "track, pan, tilt"});
  expect_refused(stage.go({"--set-zero", "roll", "--positions", stage.positions}), 1, {"no axis \"roll\""});
  expect_refused(stage.go({"--set-zero", "tilt", "--positions", stage.positions}), 1,
                 {"axis \"tilt\"", "its drive says where it is", "reference = \"operator\""});
  expect_refused(run_program({"goto", "--rig", "/nowhere.toml", "pan=1", "--yes"}), 1, {"/nowhere.toml"});
}

TEST(GotoCommand, WrongUsageIsOneLineWithStatus2) {
  const Stage stage;
  expect_refused(stage.go({}), 2, {"AXIS=POSITION is required"});
  expect_refused(stage.go({"pan"}), 2, {"\"pan\": not a position", "goto --help"});
  expect_refused(stage.go({"pan=nan", "--yes"}), 2, {"not a position"});
  expect_refused(stage.go({"pan=1", "pan=2", "--yes"}), 2, {"a position already"});
  expect_refused(stage.go({"pan=1", "--sim", "--fast"}), 2, {"add --yes"});
  expect_refused(stage.go({"pan=1", "--fast", "--yes"}), 2, {"add --sim"});
  expect_refused(stage.go({"pan=1", "--from", "pan=2", "--yes"}), 2, {"add --sim"});
  expect_refused(stage.go({"pan=1", "--speed", "0", "--sim"}), 2, {"--speed"});
  expect_refused(stage.go({"pan=1", "--speed", "0.2", "--allow-jitter", "--yes"}), 2, {"0.1 at most"});
  expect_refused(stage.go({"pan=1", "--stands-at", "track=0"}), 2, {"two commands"});
  expect_refused(stage.go({"--set-zero", "pan", "--sim"}), 2, {"--positions"});
  expect_refused(stage.go({"--set-zero", "pan", "--stands-at", "pan=1"}), 2, {"a position already"});
}

TEST(GotoCommand, NobodySaysThatAnAxisStandsWhereItCannot) {
  const Stage stage;
  expect_refused(stage.go({"--stands-at", "pan=9999"}), 1,
                 {"axis \"pan\" cannot stand at 9999 deg, outside "});
}

TEST(GotoCommand, ItsHelpTeachesIt) {
  const ProgramRun run = run_program({"goto", "--help"});
  EXPECT_EQ(run.status, 0);
  for (const char* word : {"AXIS=POSITION", "--rig ", "--sim", "--fast", "--from ", "--speed ", "--yes",
                           "--set-zero ", "--stands-at ", "--positions ", "Examples:", "Exit status:"}) {
    EXPECT_THAT(run.out, HasSubstr(word));
  }
}

TEST(GotoCommand, AnUnreferencedAxisIsRefusedWithTheRemedy) {
  const Stage stage;
  expect_refused(
      stage.go_kept({"pan=10"}), 1,
      {"crane.toml:15:1: error: axis \"pan\" does not know where it is", stage.positions, "goto --set-zero"});
  EXPECT_EQ(stage.go_kept({"tilt=10"}).status, 0) << "its drive knows";
}

TEST(GotoCommand, WhatIsSaidIsKeptAndWhereItRestsAfterwards) {
  const Stage stage;
  const ProgramRun said =
      stage.go({"--set-zero", "track", "--stands-at", "pan=40", "--positions", stage.positions});
  EXPECT_EQ(said.status, 0) << said.err;
  EXPECT_EQ(said.out, "pan: stands at 40 deg\ntrack: stands at 0 mm\n");
  EXPECT_THAT(stage.go_kept({"pan=30", "track=100"}).err,
              AllOf(HasSubstr("40.000 -> 30.000"), HasSubstr("0.000 -> 100.000")));
  EXPECT_THAT(stage.go_kept({"pan=20", "track=50"}).err,
              AllOf(HasSubstr("30.000 -> 20.000"), HasSubstr("100.000 -> 50.000")));
}

// A drive that has counted something else: the coordinate is the operator's.
TEST(GotoCommand, TheDriveTakesTheKeptPosition) {
  const Stage stage;
  ASSERT_EQ(stage.go({"--stands-at", "pan=40", "track=5", "--positions", stage.positions}).status, 0);
  const ProgramRun run = stage.go_kept({"pan=30", "track=10", "--from", "pan=-7", "--from", "track=300"});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.err, AllOf(HasSubstr("40.000 -> 30.000"), HasSubstr("5.000 -> 10.000")));
  EXPECT_THAT(run.out, AllOf(HasSubstr(" 30.0000 deg"), HasSubstr(" 10.0000 mm")));
}

// docs/faults.md 42: what is said would be overwritten where the axes rest, or be said of axes that move.
TEST(GotoCommand, NothingIsSaidOrMovedWhileAnotherProgramHasThePositions) {
  const Stage stage;
  const RigFile rig = read_rig_file(stage.path);
  {
    const RigReference other = reference_of(rig, stage.positions, false);
    expect_refused(stage.go({"--set-zero", "pan", "--positions", stage.positions}), 1,
                   {stage.positions + ": error: another inbetween uses these positions; end it first"});
    expect_refused(stage.go_kept({"tilt=10"}), 1, {"another inbetween uses these positions"});
    EXPECT_TRUE(std::filesystem::is_empty(stage.folder.path()));
  }
  EXPECT_EQ(stage.go({"--set-zero", "pan", "--positions", stage.positions}).status, 0);
}

TEST(GotoCommand, WithoutAFileASimulationWritesNothing) {
  const Stage stage;
  EXPECT_EQ(stage.go({"pan=10", "--sim", "--fast", "--yes"}).status, 0);
  EXPECT_TRUE(std::filesystem::is_empty(stage.folder.path()));
}

// --- stopped on the way

SessionOptions simulated_and_agreed(bool agrees) {
  return {.simulated = true, .fast = true, .audience = {.confirm = [agrees](const std::string&) {
                                             return agrees;
                                           }}};
}

/// goto track=400 from 0, with something at its tick number `when`.
struct Journey {
  RigFile rig = parse_rig(crane, "rig.toml");
  TemporaryFolder folder;
  std::string file = (folder.path() / "crane.positions").string();
  int ticks = 0;

  template <class Something>
  SetupEnd go(int when, Something something) {
    RigReference reference(rig, file);
    reference.stands_at(0, 0);
    reference.stands_at(1, 12);
    GoOptions options{.session = simulated_and_agreed(true)};
    options.session.audience.keys = [&, when] { return ++ticks == when ? something() : std::string(); };
    return go_to(rig, {{.axis = 0, .position = 400}, {.axis = 1, .position = 0}}, reference, options);
  }
  [[nodiscard]] std::optional<double> kept(std::size_t axis) const {
    return RigReference(rig, file).position(axis);
  }
};

TEST(GotoCommand, AStopOnTheWayRestsThereAndKnowsWhere) {
  Journey journey;
  const SetupEnd end = journey.go(1000, [] { return std::string("\x1b"); });
  EXPECT_FALSE(end.is_done);
  EXPECT_EQ(end.reason, "stopped on the way");
  // A tenth of the velocity for about four seconds.
  EXPECT_GT(end.positions[0], 90);
  EXPECT_LT(end.positions[0], 110);
  EXPECT_EQ(journey.kept(0), end.positions[0]);
  ASSERT_TRUE(journey.kept(1));
  EXPECT_NEAR(*journey.kept(1), 12 - 12 * end.positions[0] / 400, 1e-2) << "on the line to where both go";
  EXPECT_LT(journey.ticks, 1200) << "it was over soon";
}

// docs/faults.md 28, 32
TEST(GotoCommand, AnEmergencyStopOnTheWayLosesWhatNothingReports) {
  Journey journey;
  const SetupEnd end = journey.go(1000, [] {
    std::raise(SIGUSR1);
    return std::string();
  });
  EXPECT_FALSE(end.is_done);
  EXPECT_THAT(end.reason, HasSubstr("emergency stop"));
  EXPECT_EQ(journey.kept(0), std::nullopt);
  EXPECT_NE(journey.kept(1), std::nullopt) << "its drive counts on";
}

TEST(GotoCommand, WhoeverDoesNotAgreeMovesNothing) {
  const RigFile rig = parse_rig(crane, "rig.toml");
  RigReference reference(rig);
  const SetupEnd end =
      go_to(rig, {{.axis = 0, .position = 400}}, reference, {.session = simulated_and_agreed(false)});
  EXPECT_FALSE(end.is_done);
  EXPECT_EQ(end.positions[0], 0);
}

TEST(GotoCommand, NothingIsBegunWithARigThatHasChanged) {
  const RigFile rig = parse_rig(crane, "rig.toml");
  RigReference reference(rig);
  GoOptions options{.session = simulated_and_agreed(true)};
  options.session.audience.rig_has_changed = [] { return true; };
  EXPECT_THROW(go_to(rig, {{.axis = 0, .position = 400}}, reference, options), InputError);
}

}  // namespace goto_command_test
}  // namespace inbetween
