// `run --step` and `run --shutter`: keys, the camera, and what is refused.
#include "host_tools/motions/shooting.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "host_tools/motions/run.hpp"
#include "host_tools/motions/run_checks.hpp"
#include "tests/support/places.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"
#include "tests/support/ticked_rig.hpp"

namespace inbetween {
namespace shooting_test {

using testing::HasSubstr;

const std::string reveal = in_checkout("examples/reveal.toml");
const std::string camera_rig = in_checkout("examples/camera_rig.toml");

ProgramRun run_with(std::vector<std::string> more) {
  std::vector<std::string> arguments{"run", reveal, "--rig", camera_rig, "--sim", "--fast"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_program(arguments);
}

TEST(Shooting, WithoutAKeyboardTheCameraAsksForEveryFrame) {
  const ProgramRun run = run_with({"--step", "--json", "-"});
  EXPECT_EQ(run.status, 0);
  const auto json = nlohmann::ordered_json::parse(run.out);
  EXPECT_EQ(json["exposures"], 193) << "frames 0..192";
  EXPECT_EQ(json["ended"], "finished");
  EXPECT_EQ(json["axes"][0]["last_actual"], 1640);
  EXPECT_GT(json["ticks"], 193 * (125 + 25)) << "half a second of settling and a tenth of exposing each";
  EXPECT_THAT(run.err, HasSubstr("every frame was shot"));
  EXPECT_THAT(run.err, HasSubstr("frames 0..192: 193 due, 193 shot\n"));
}

TEST(Shooting, InMotionEveryFrameIsExposedToo) {
  const ProgramRun run = run_with(
      {"--shutter", "0..180", "--exposure", "0.5", "--settle", "0.1", "--still", "tilt", "--json", "-"});
  EXPECT_EQ(run.status, 0);
  EXPECT_EQ(nlohmann::ordered_json::parse(run.out)["exposures"], 193);
}

/// The largest second difference of what the slide was told, over a tick squared, in mm/s^2.
double max_acceleration_told(const std::vector<std::string>& more) {
  const TemporaryFolder folder;
  const std::string record = folder.path() / "record.csv";
  std::vector<std::string> arguments = more;
  arguments.insert(arguments.end(), {"--record", record});
  EXPECT_EQ(run_with(arguments).status, 0);
  std::ifstream file(record);
  std::string line;
  std::getline(file, line);
  std::vector<double> told;
  while (std::getline(file, line)) {
    std::istringstream cells(line);
    std::string cell;
    for (int i = 0; i < 5; ++i) std::getline(cells, cell, ',');
    if (!cell.empty()) told.push_back(std::stod(cell));
  }
  double most = 0;
  for (std::size_t i = 2; i < told.size(); ++i) {
    most = std::max(most, std::fabs(told[i] - 2 * told[i - 1] + told[i - 2]) * 250 * 250);
  }
  return most;
}

TEST(Shooting, TheExampleKeepsItsMotionLimitsAtRestAndInMotion) {
  constexpr double max_acceleration = 800.001;
  EXPECT_LE(max_acceleration_told({"--step", "--settle", "0"}), max_acceleration);
  const double in_motion = max_acceleration_told({"--shutter", "-90..90", "--exposure", "0.05"});
  EXPECT_LE(in_motion, max_acceleration);
  EXPECT_GT(in_motion, 600) << "and is not slower than it need be";
}

/// Shoots the example with a keyboard, typing `typed[i].second` before tick `typed[i].first`.
RunReport shoot_typing(const std::vector<std::pair<int, std::string>>& typed,
                       std::vector<std::string>* lines) {
  const Plan plan(read_move_file(reveal), read_rig_file(camera_rig), {});
  int tick = 0;
  std::size_t next = 0;
  return run(plan,
             {.simulated = true,
              .fast = true,
              .audience = {.keys =
                               [&] {
                                 const bool now = next < typed.size() && typed[next].first == tick;
                                 ++tick;
                                 return now ? typed[next++].second : std::string();
                               },
                           .status =
                               [&](const RunSnapshot& now) {
                                 if (lines != nullptr) lines->push_back(status_line(now));
                               }}},
             {.shoot = ShootOptions{.settle_s = 0.1, .exposure_s = 0.1}});
}

TEST(Shooting, OneThatGoesOnBeginsOnTheFirstFrameThatIsMissingAndTellsWhatWasShot) {
  const Plan plan(read_move_file(reveal), read_rig_file(camera_rig), {});
  const ShootOptions options{
      .settle_s = 0.1, .exposure_s = 0.1, .before = {{0, 1}, {1, 1}, {2, 0, false}, {3, 1}}};
  TickedRig rig(plan);
  const std::unique_ptr<StagedMove> staged = checked_shoot(plan, 1, options);
  SimulatedCamera camera(false);
  Shooting shooting(rig.loop, *staged, camera, options, true);
  ASSERT_TRUE(shooting.begin());
  rig.tick(shooting, 2000);
  EXPECT_EQ(state_line(shooting.snapshot()), "standing  frame 2 of 192  3 shot");
  shooting.press(TransportKey::pause);
  rig.tick(shooting, 200);
  EXPECT_EQ(shooting.snapshot().shoot->exposures, 4);
  EXPECT_EQ(shooting.count().shot, 4);
}

TEST(Shooting, WithAKeyboardNothingIsExposedBeforeSpace) {
  EXPECT_EQ(shoot_typing({{20000, "q"}}, nullptr).exposures, 0);
  const RunReport report = shoot_typing({{5000, " "}, {10000, " "}, {20000, "q"}}, nullptr);
  EXPECT_EQ(report.ending, Ending::stopped);
  EXPECT_EQ(report.exposures, 2);
  EXPECT_GE(report.ticks, 20000);
}

TEST(Shooting, OtherFramesAreLookedAtWithoutBeingExposed) {
  const RunReport report =
      shoot_typing({{5000, "\x1b[C"}, {6000, "\x1b[C"}, {7000, "\x1b[D"}, {8000, " "}, {9000, "q"}}, nullptr);
  EXPECT_EQ(report.exposures, 1);
  EXPECT_EQ(report.shoot->skipped, 1) << "frame 0";
}

TEST(Shooting, AfterAStopTheFrameIsExposedOnlyIfSomebodyAsks) {
  std::vector<std::pair<int, std::string>> typed{{5000, " "}, {5003, "\x1b"}, {6000, " "},  {6100, "\r"},
                                                 {6200, "a"}, {6300, "\r"},   {7000, "\r"}, {9000, "q"}};
  EXPECT_EQ(shoot_typing(typed, nullptr).exposures, 0) << "nor by a second Enter";
  typed.insert(typed.end() - 1, {8000, " "});
  EXPECT_EQ(shoot_typing(typed, nullptr).exposures, 1);
}

TEST(Shooting, AnExposureThatAStopCutsOffDoesNotCount) {
  const RunReport report = shoot_typing({{5000, " "}, {5035, "\x1b"}, {9000, "q"}}, nullptr);
  EXPECT_EQ(report.exposures, 0);
  EXPECT_EQ(report.shoot->cut_off, 1);
  EXPECT_EQ(report.shoot->left, 193);
}

/// Shoots with a log, typing as many spaces as are wanted; the camera asks where nobody types.
ProgramRun shoot_on(const std::string& log, const std::vector<std::string>& more) {
  std::vector<std::string> words{"--step",      "--settle", "0",      "--exposure", "0.01",
                                 "--shoot-log", log,        "--json", "-"};
  words.insert(words.end(), more.begin(), more.end());
  return run_with(words);
}

TEST(Shooting, AShootThatWasInterruptedGoesOnByItsLogWithTheFramesThatItLacks) {
  const TemporaryFolder folder;
  const std::string log = folder.path() / "shoot.csv";
  EXPECT_EQ(shoot_on(log, {"--resume"}).status, 1) << "there is nothing to go on with";
  ASSERT_EQ(shoot_on(log, {"--frames", "0..40"}).status, 0);
  ASSERT_EQ(shoot_on(log, {"--frames", "44..50"}).status, 0);
  std::ofstream(log, std::ios::app) << "2026-01-01T12:00:00Z,51,0,0\n";  // cut off by a stop
  const ProgramRun resumed = shoot_on(log, {"--resume"});
  EXPECT_EQ(resumed.status, 0) << resumed.err;
  const auto json = nlohmann::ordered_json::parse(resumed.out);
  EXPECT_EQ(json["exposures"], 193 - 41 - 7);
  EXPECT_EQ(json["shoot"]["shot"], 193);
  EXPECT_EQ(json["shoot"]["shot_again"], 0);
  const std::string text = file_contents(log);
  EXPECT_EQ(std::ranges::count(text, '\n'), 1 + 193 + 1);
  EXPECT_LT(text.find(",41,1,1"), text.find(",43,1,1"));
  EXPECT_LT(text.find(",43,1,1"), text.find(",51,1,1")) << "44..50 are not shot again";
  const ProgramRun again = shoot_on(log, {"--resume"});
  EXPECT_EQ(again.status, 0);
  EXPECT_THAT(again.err, HasSubstr("every frame was shot before"));
  EXPECT_THAT(again.err, HasSubstr("frames 0..192: 193 due, 193 shot\n"));
}

TEST(Shooting, ALogThatIsNoneOfTheMoveIsNotGoneOnWith) {
  const auto refused = [](const std::string& lines) {
    const TemporaryFile log("shoot.csv", "at,frame,shots,whole\n" + lines);
    const ProgramRun run = run_with({"--step", "--shoot-log", log.path().string(), "--resume"});
    EXPECT_EQ(run.status, 1);
    return run.err;
  };
  EXPECT_THAT(refused("2026-01-01T12:00:00Z,193,1,1\n"),
              HasSubstr(":2: error: frame 193 was shot, and the move has "));
  EXPECT_THAT(refused("2026-01-01T12:00:00Z,3,1,1\n2026-01-01T12:0"),
              HasSubstr(":3: error: this is no line of a"));
  EXPECT_THAT(run_with({"--step", "--resume"}).err, HasSubstr("name it with --shoot-log FILE"));
  EXPECT_THAT(run_with({"--resume"}).err, HasSubstr("--resume belongs to --step or --shutter"));
}

TEST(Shooting, GoingToAFrameAndTheWheelLookAtIt) {
  const RunReport report =
      shoot_typing({{5000, "g12\r"}, {9000, "\x1b[<64;1;1M"}, {9500, " "}, {11000, "q"}}, nullptr);
  EXPECT_EQ(report.exposures, 1);
  EXPECT_EQ(report.shoot->last_shot, 13);
}

const std::string pan_of_two_seconds = R"(name = "pan of two seconds"
fps = 24
frames = 48
[[track]]
axes = ["pan"]
keys = [{ at = [-60] }, { at = [60] }]
speed = [0, 0, 10, 4, 2, 0, 0]
)";

/// The frame and `whole` of every line of a shoot log.
std::vector<std::string> logged(const std::string& file) {
  std::istringstream lines(file_contents(file));
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, "at,frame,shots,whole");
  std::vector<std::string> frames;
  while (std::getline(lines, line)) frames.push_back(line.substr(line.find(',') + 1));
  return frames;
}

/// Shoots with a keyboard, a key of the script every four seconds of the virtual clock.
RunReport shoot_by_script(const Plan& plan, const std::string& log, std::vector<std::string> script) {
  int tick = 0;
  std::size_t next = 0;
  return run(plan,
             {.simulated = true,
              .fast = true,
              .audience = {.keys =
                               [&] {
                                 return ++tick % 1000 == 0 && next < script.size() ? script[next++]
                                                                                   : std::string();
                               }}},
             {.shoot = ShootOptions{.settle_s = 0.02, .exposure_s = 0.02, .log = log}});
}

TEST(Shooting, AStoppedShootThatIsGoneOnWithTellsWhatIsThere) {
  const TemporaryFolder folder;
  const std::string log = folder.path() / "shoot.csv";
  const Plan plan(parse_move(pan_of_two_seconds, "move.toml"), read_rig_file(camera_rig), {});
  std::vector<std::string> script(20, " ");  // frames 0..19
  // On its way to frame 20 it is stopped; then two frames backward are looked at, and it goes on.
  script.insert(script.end(), {" \x1b", "a", "\r", "\x1b[D", "\x1b[D", " "});
  script.insert(script.end(), {"e", "\x1b[C", "\x1b[C", " "});  // 20 again, 21 skipped, 22
  script.insert(script.end(), 26, " ");                         // 23..48
  script.push_back(" ");
  const RunReport report = shoot_by_script(plan, log, script);
  EXPECT_EQ(report.ending, Ending::finished);
  EXPECT_EQ(report.reason, "the shoot was ended with frames missing");
  EXPECT_EQ(report.exposures, 49);
  EXPECT_EQ(report.shoot->due(), 49);
  EXPECT_EQ(report.shoot->shot, 48);
  EXPECT_EQ(report.shoot->shot_again, 1);
  EXPECT_EQ(report.shoot->skipped, 1);
  EXPECT_EQ(report.shoot->left, 0);
  EXPECT_FALSE(report.shoot->has_all());
  std::vector<std::string> wanted;
  for (int frame = 0; frame <= 48; ++frame) {
    if (frame != 21) wanted.push_back(std::to_string(frame) + ",1,1");
    if (frame == 20) wanted.push_back("20,2,1");
  }
  EXPECT_EQ(logged(log), wanted);
}

ProgramRun shoot_pan(const TemporaryFolder& folder, std::vector<std::string> more) {
  const std::string move = folder.path() / "pan.toml";
  std::ofstream(move) << pan_of_two_seconds;
  std::vector<std::string> arguments{
      "run",    move,     "--rig",    camera_rig,    "--sim",
      "--fast", "--step", "--settle", "0.02",        "--exposure",
      "0.02",   "--json", "-",        "--shoot-log", folder.path() / "shoot.csv"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_program(arguments);
}

TEST(Shooting, GoesOnLaterFromAFrameOnAndTheLogGoesOnWithIt) {
  const TemporaryFolder folder;
  EXPECT_EQ(shoot_pan(folder, {"--frames", "..36"}).status, 0);
  EXPECT_EQ(logged(folder.path() / "shoot.csv").back(), "36,1,1");
  const ProgramRun rest = shoot_pan(folder, {"--frames", "37.."});
  EXPECT_EQ(rest.status, 0);
  EXPECT_THAT(rest.err, HasSubstr("frames 37..48: 12 due, 12 shot"));
  const auto json = nlohmann::ordered_json::parse(rest.out);
  EXPECT_EQ(json["shoot"]["due"], 12);
  EXPECT_EQ(json["shoot"]["last_shot"], 48);
  const std::vector<std::string> all = logged(folder.path() / "shoot.csv");
  ASSERT_EQ(all.size(), 49U);
  for (std::size_t frame = 0; frame < all.size(); ++frame) {
    EXPECT_EQ(all[frame], std::to_string(frame) + ",1,1");
  }
}

TEST(Shooting, AFileThatIsNoShootLogIsNotWrittenTo) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "shoot.csv") << "to buy: milk\n";
  const ProgramRun run = shoot_pan(folder, {});
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.err, HasSubstr("no shoot log"));
  EXPECT_EQ(file_contents(folder.path() / "shoot.csv"), "to buy: milk\n");
}

TEST(Shooting, FramesThatTheMoveHasNotAreRefused) {
  const TemporaryFolder folder;
  const ProgramRun beyond = shoot_pan(folder, {"--frames", "37..49"});
  EXPECT_EQ(beyond.status, 1);
  EXPECT_THAT(beyond.err, HasSubstr("frame 49"));
  for (const char* text : {"37", "48..37", "..", "a..b", "-1..3", "1..2..3"}) {
    EXPECT_EQ(shoot_pan(folder, {"--frames", text}).status, 2) << text;
  }
}

TEST(Shooting, AnExposureWaitsUntilThePlayOfAGearIsTakenUpThereAndBack) {
  const RigFile rig = parse_rig(
      rig_text(
          {{.name = "tilt", .more = R"(backlash = { play = 0.2, take_up_s = 0.4, approach = "positive" })"},
           {.name = "pan"}},
          {.rate_hz = 250}),
      "rig.toml");
  EXPECT_GE(shoot_spec({.settle_s = 0}, rig).settle_ticks, 2 * 100);
  EXPECT_LE(shoot_spec({.settle_s = 0}, rig).settle_ticks, 2 * 100 + 3);
  EXPECT_GE(shoot_spec({.settle_s = 1}, rig).settle_ticks, 250 + 2 * 100);
}

/// 120 degrees in two seconds on an axis that could do 3 in that time, with a corner on the way.
AxisText slow_axis(const std::string& name) {
  return axis_text(name, "deg", {-90, 90}, {.velocity = 1.5, .acceleration = 3, .jerk = 30}, "",
                   R"(type = "pipe", path = "/dev/null", counts_per_unit = 1e7)");
}
const std::string slow_rig = rig_text({slow_axis("pan"), slow_axis("tilt")}, {.rate_hz = 250});
const std::string cornered = R"(name = "cornered"
fps = 24
frames = 48
[[track]]
axes = ["pan", "tilt"]
spline = "linear"
keys = [{ at = [-60, 0] }, { at = [-5, 0] }, { at = [10, 45] }]
speed = [10, 10]
)";

/// The largest velocity, acceleration and jerk of a column of a record, by differences.
std::array<double, 3> told(const std::string& record, int column) {
  std::ifstream file(record);
  std::string line;
  std::getline(file, line);
  std::array<double, 4> last{};
  std::array<double, 3> most{};
  for (int rows = 0; std::getline(file, line);) {
    std::istringstream cells(line);
    std::string cell;
    for (int i = 0; i <= column; ++i) std::getline(cells, cell, ',');
    if (cell.empty()) continue;
    std::ranges::copy_backward(std::array{last[0], last[1], last[2]}, last.end());
    last[0] = std::stod(cell);
    if (++rows < 4) continue;
    const double first = (last[0] - last[1]) * 250;
    const double second = (last[0] - 2 * last[1] + last[2]) * 250 * 250;
    const double third = (last[0] - 3 * last[1] + 3 * last[2] - last[3]) * 250 * 250 * 250;
    most = {std::max(most[0], std::fabs(first)), std::max(most[1], std::fabs(second)),
            std::max(most[2], std::fabs(third))};
  }
  return most;
}

TEST(Shooting, IsHeldToWhatMovesAndRestsWhereTheMotionSteps) {
  const TemporaryFolder folder;
  const std::string move = folder.path() / "move.toml";
  const std::string rig = folder.path() / "rig.toml";
  const std::string record = folder.path() / "record.csv";
  std::ofstream(move) << cornered;
  std::ofstream(rig) << slow_rig;
  const std::vector<std::string> play{"run", move, "--rig", rig, "--sim", "--fast"};
  EXPECT_EQ(run_program(play).status, 3) << "played, it is far beyond every limit";
  std::vector<std::string> shoot = play;
  shoot.insert(shoot.end(), {"--step", "--settle", "0", "--record", record});
  const ProgramRun run = run_program(shoot);
  ASSERT_EQ(run.status, 0) << run.err;
  for (const int column : {4, 6}) {
    const auto [velocity, acceleration, jerk] = told(record, column);
    EXPECT_LE(velocity, 1.5);
    EXPECT_LE(acceleration, 3.0001);
    EXPECT_LE(jerk, 30.1);
    EXPECT_GT(velocity, 0.3) << "and is not slower than it need be";
  }
}

TEST(Shooting, InMotionNoExposurePassesAStep) {
  const TemporaryFolder folder;
  const std::string move = folder.path() / "move.toml";
  const std::string rig = folder.path() / "rig.toml";
  std::ofstream(move) << cornered;
  std::ofstream(rig) << slow_rig;
  const auto shoot = [&](const char* shutter, const char* exposure, const char* frames) {
    return run_program({"run", move, "--rig", rig, "--sim", "--fast", "--shutter", shutter, "--exposure",
                        exposure, "--frames", frames});
  };
  const ProgramRun fast = shoot("0..180", "0.5", "5..10");
  EXPECT_EQ(fast.status, 3);
  EXPECT_THAT(fast.err, HasSubstr("frame 5 cannot be exposed in motion"));
  EXPECT_THAT(fast.err, HasSubstr("s at least"));
  EXPECT_EQ(shoot("0..180", "2", "5..10").status, 0);
  const ProgramRun across = shoot("0..360", "4", "20..30");
  EXPECT_EQ(across.status, 3);
  EXPECT_THAT(across.err, HasSubstr("the motion steps while the rig exposes it"));
}

TEST(Shooting, APositionBeyondALimitOnTheWayIsRefused) {
  const TemporaryFolder folder;
  const std::string move = folder.path() / "move.toml";
  const std::string rig = folder.path() / "rig.toml";
  std::ofstream(move) << "name = \"peak\"\nfps = 24\nframes = 2\n[[track]]\naxes = [\"pan\"]\n"
                         "keys = [{ at = [0] }, { at = [95] }, { at = [20] }, { at = [0] }]\n"
                         "speed = [0, 0, 10, 0, 0]\n";
  std::ofstream(rig) << slow_rig;
  const ProgramRun run = run_program({"run", move, "--rig", rig, "--sim", "--fast", "--step"});
  EXPECT_EQ(run.status, 3);
  EXPECT_THAT(run.err, HasSubstr("outside -90..90 deg of the rig"));
}

TEST(Shooting, AnExposureThatIsTooShortIsRefusedWithItsFrameAndNothingMoves) {
  const ProgramRun run = run_with({"--shutter", "0..180", "--exposure", "0.02"});
  EXPECT_EQ(run.status, 3);
  EXPECT_EQ(run.out, "");
  EXPECT_THAT(run.err, HasSubstr("reveal.toml:5:"));
  EXPECT_THAT(run.err, HasSubstr("frame 0 cannot be exposed in motion"));
  EXPECT_THAT(run.err, HasSubstr("expose longer"));
}

TEST(Shooting, OptionsThatMakeNoSenseTogetherAreWrongUsage) {
  struct Wrong {
    std::vector<std::string> arguments;
    const char* words;
  };
  const std::vector<Wrong> wrong{
      {{"--exposure", "1"}, "belong to --step or --shutter"},
      {{"--settle", "1"}, "belong to --step or --shutter"},
      {{"--still", "pan"}, "belong to --step or --shutter"},
      {{"--step", "--still", "pan"}, "every axis stands still"},
      {{"--shutter", "0..180"}, "--exposure SECONDS"},
      {{"--shutter", "180", "--exposure", "1"}, "OPEN..CLOSE"},
      {{"--shutter", "180..0", "--exposure", "1"}, "OPEN..CLOSE"},
      {{"--shutter", "0..361", "--exposure", "1"}, "OPEN..CLOSE"},
      {{"--shutter", "-300..300", "--exposure", "1"}, "OPEN..CLOSE"},
      {{"--shutter", "nan..1", "--exposure", "1"}, "OPEN..CLOSE"},
      {{"--step", "--settle", "-1"}, "--settle"},
      {{"--step", "--exposure", "0"}, "--exposure"},
      {{"--shoot-log", "log.csv"}, "belongs to --step or --shutter"},
      {{"--step", "--top-rate", "1.5"}, "are for a move that is played"},
      {{"--top-rate", "0.5"}, "--top-rate"},
  };
  for (const Wrong& one : wrong) {
    const ProgramRun run = run_with(one.arguments);
    EXPECT_EQ(run.status, 2) << one.words;
    EXPECT_THAT(run.err, HasSubstr(one.words));
  }
  const ProgramRun repeated = run_program({"run", reveal, "--rig", camera_rig, "--sim", "--step", "--loop"});
  EXPECT_EQ(repeated.status, 2);
}

TEST(Shooting, AnAxisThatTheRigDoesNotHaveCannotStandStill) {
  const ProgramRun run = run_with({"--shutter", "0..180", "--exposure", "0.5", "--still", "roll"});
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.err, HasSubstr("has no axis \"roll\""));
}

TEST(Rate, BeginsSlowerThanDrawn) {
  const ProgramRun run = run_with({"--rate", "0.25", "--json", "-"});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(nlohmann::ordered_json::parse(run.out)["ticks"], 8001) << "2 000 and one to arrive, at a quarter";
  EXPECT_EQ(run_with({"--rate", "0"}).status, 2);
  EXPECT_EQ(run_with({"--rate", "1.5"}).status, 2);
  EXPECT_EQ(run_with({"--rate", "0.5", "--step"}).status, 2);
}

TEST(TopRate, AboveWhatIsCertifiedIsRefusedWithTheHighest) {
  const ProgramRun run = run_with({"--top-rate", "9"});
  EXPECT_EQ(run.status, 3);
  EXPECT_THAT(run.err, HasSubstr("at 9 times the drawn speed the move leaves the limits of the rig; lower "
                                 "--top-rate to 1.137 or less"));
}

TEST(TopRate, LetsTheOverrideGoAboveTheDrawnSpeed) {
  const Plan plan(read_move_file(reveal), read_rig_file(camera_rig), {});
  int tick = 0;
  const RunReport report = run(
      plan, {.simulated = true, .fast = true, .audience = {.keys = [&] { return tick++ == 0 ? "+++" : ""; }}},
      {.top_rate = 1.1});
  EXPECT_EQ(report.ending, Ending::finished);
  EXPECT_NEAR(static_cast<double>(report.ticks), 2001 / 1.1, 30);
}

}  // namespace shooting_test
}  // namespace inbetween
