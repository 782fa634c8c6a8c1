// Everything that a move or a rig can get wrong meets one line on standard error with place and remedy, exit
// status 1, nothing on standard output, no file left behind, and neither much time nor much memory.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/refused_text.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace bad_input_test {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::StartsWith;

const std::string arc = R"(name = "arc"
fps = 24
frames = 48
[[track]]
axes = ["x", "y"]
keys = [ { at = [0, 0] }, { at = [30, 40] }, { at = [60, 7] } ]
speed = [0, 0, 10, 5, 0]
weights = [1, 2]
)";

const std::string rig =
    rig_text({{.name = "x", .min = -1, .max = 100, .max_velocity = 100, .max_acceleration = 100}});

/// One line, "file[:line:column]: error: what; what to do".
void expect_one_line_at(const ProgramRun& run, const std::string& place,
                        std::initializer_list<std::string_view> words) {
  EXPECT_EQ(run.status, 1);
  EXPECT_EQ(run.out, "");
  EXPECT_THAT(run.err, StartsWith(place + ": error: "));
  EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  EXPECT_EQ(run.err.back(), '\n');
  const std::size_t remedy = run.err.find("; ");
  EXPECT_TRUE(remedy != std::string::npos && remedy + 3 < run.err.size()) << "no remedy in: " << run.err;
  for (const std::string_view word : words) EXPECT_THAT(run.err, HasSubstr(std::string(word)));
}

/// Plans `move` with every output there is, and expects nothing but that line.
void expect_plan_refused(const fs::path& move, const std::string& place,
                         std::initializer_list<std::string_view> words,
                         const std::vector<std::string>& more = {}) {
  const TemporaryFolder outputs;
  const auto output = [&](const char* name) { return (outputs.path() / name).string(); };
  std::vector<std::string> arguments = {"plan",   move.string(),    "--csv",  output("o.csv"),
                                        "--json", output("o.json"), "--plot", output("o.svg")};
  arguments.insert(arguments.end(), more.begin(), more.end());
  expect_one_line_at(run_program(arguments), place, words);
  EXPECT_TRUE(fs::is_empty(outputs.path()));
}

/// The same for a text in which the place is marked with @.
void expect_move_refused(const std::string& marked, std::initializer_list<std::string_view> words) {
  const MarkedText text = without_mark(marked);
  const TemporaryFile move("move.toml", text.text);
  const std::string file = move.path().string();
  expect_plan_refused(file, fmt::format("{}:{}:{}", file, text.line, text.column), words);
}

TEST(BadInput, TheMoveThatTheseTestsSpoilIsGood) {
  const TemporaryFile move("move.toml", arc);
  const ProgramRun run = run_program({"plan", move.path().string()});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(run.err, "");
}

TEST(BadInput, ACoordinateIsNotANumber) {
  expect_move_refused(with(arc, "30", "@nan"), {"nan", "write a number"});
}

TEST(BadInput, ACoordinateIsInfinite) {
  expect_move_refused(with(arc, "30", "@inf"), {"inf", "write a number"});
  expect_move_refused(with(arc, "30", "@-inf"), {"-inf", "write a number"});
}

TEST(BadInput, ACoordinateIsBeyondAllMachines) {
  expect_move_refused(with(arc, "30", "@1e308"), {"1e+308", "write a number"});
}

TEST(BadInput, ACoordinateIsBeyondDoublePrecision) {
  expect_move_refused(with(arc, "30", "@1e999"), {"1e999"});
}

TEST(BadInput, NoFrames) {
  expect_move_refused(with(arc, "48", "@0"), {"frames is 0", "write a whole number from 1"});
}

TEST(BadInput, ANegativeNumberOfFrames) {
  expect_move_refused(with(arc, "48", "@-48"), {"frames is -48", "write a whole number from 1"});
}

TEST(BadInput, NoFramesPerSecond) {
  expect_move_refused(with(arc, "fps = 24", "fps = @0"), {"fps is 0"});
}

TEST(BadInput, FramesPerSecondThatAreNotExact) {
  expect_move_refused(with(arc, "fps = 24", "fps = @23.976"), {"use \"24000/1001\""});
}

TEST(BadInput, NoKeys) {
  expect_move_refused(with(arc, "[ { at = [0, 0] }, { at = [30, 40] }, { at = [60, 7] } ]", "@[]"),
                      {"keys is empty", "write at least one"});
}

TEST(BadInput, KeysOfUnequalLength) {
  expect_move_refused(with(arc, "[30, 40]", "@[30, 40, 50]"), {"key 1 has 3 numbers", "write 2"});
}

TEST(BadInput, AnUnknownField) {
  expect_move_refused(with(arc, "speed =", "@sped ="), {"has no field \"sped\"", "did you mean \"speed\"?"});
}

TEST(BadInput, ADuplicateField) {
  expect_move_refused(arc + "@speed = [1]\n", {"\"speed\" is given a second time"});
}

TEST(BadInput, AValueOfTheWrongType) {
  expect_move_refused(with(arc, "48", "@\"48\""), {"frames is text", "write a whole number"});
}

TEST(BadInput, ANegativeSpeed) {
  expect_move_refused(with(arc, "10, 5", "10, @-5"), {"speed[3] is -5", "write a number from 0 to 100"});
}

TEST(BadInput, ASpeedAbove100) {
  expect_move_refused(with(arc, "10, 5", "@100.5, 5"), {"speed[2] is 100.5", "write a number from 0 to 100"});
}

TEST(BadInput, NoSpeedAnywhereOnARealPath) {
  expect_move_refused(with(arc, "[0, 0, 10, 5, 0]", "@[0, 0, 0]"), {"raise a control value above 0"});
}

TEST(BadInput, ANegativeWeight) {
  expect_move_refused(with(arc, "[1, 2]", "[1, @-2]"), {"weights[1] is -2", "write a number from 0"});
}

TEST(BadInput, AnAxisTwiceInOneTrack) {
  expect_move_refused(with(arc, "[\"x\", \"y\"]", "[\"x\", @\"x\"]"), {"\"x\"", "name each axis once"});
}

TEST(BadInput, AnAxisInTwoTracks) {
  const std::string second =
      "[[track]]\naxes = [@\"y\"]\nkeys = [ { at = [1] }, { at = [2] } ]\nspeed = [1]\n";
  expect_move_refused(arc + second, {"\"y\"", "line 5", "name each axis once"});
}

TEST(BadInput, AnAxisThatMovesWhereThePathHasNoLength) {
  std::string text = with(arc, "[1, 2]", "[1, 0]");
  text = with(text, "{ at = [0, 0] }, { at = [30, 40] }", "{ at = [30, @0] }, { at = [30, 40] }");
  expect_move_refused(text, {"axis \"y\"", "key 0", "give the axis a weight above 0"});
}

TEST(BadInput, AMissingFile) {
  const TemporaryFolder folder;
  const std::string file = (folder.path() / "move.toml").string();
  expect_plan_refused(file, file, {"there is no such file"});
}

TEST(BadInput, AFolder) {
  const TemporaryFolder folder;
  expect_plan_refused(folder.path(), folder.path().string(), {"is a directory"});
}

/// What a run takes that reads nothing: the program itself, and the test that it was begun from.
long min_memory_kb() {
  return run_program({"plan", "/nowhere/move.toml"}).max_memory_kb;
}

TEST(BadInput, AFileOf100MegabytesIsNotEvenRead) {
  const TemporaryFile move("move.toml", arc);
  fs::resize_file(move.path(), 100'000'000);  // sparse
  const std::string file = move.path().string();
  const ProgramRun run = run_program({"plan", file});
  expect_one_line_at(run, file, {"has 100000000 bytes"});
  EXPECT_LT(run.max_memory_kb, min_memory_kb() + 50'000);
}

TEST(BadInput, AFileWithoutEndIsReadToTheLimitOnly) {
  const ProgramRun run = run_program({"plan", "/dev/zero"});
  expect_one_line_at(run, "/dev/zero", {"goes on beyond"});
  EXPECT_LT(run.max_memory_kb, min_memory_kb() + 50'000);
}

TEST(BadInput, TextThatIsNotUtf8) {
  expect_move_refused(with(arc, "arc", "arc@\xc3("), {"0xc3", "save the file as UTF-8"});
}

TEST(BadInput, BracketsThatNestDeep) {
  const std::string levels(16, '[');
  expect_move_refused("name = " + levels + "@" + std::string(1'000'000, '['),
                      {"nested deeper than 16 levels", "remove brackets or dots"});
}

TEST(BadInput, AnEmptyFile) {
  const TemporaryFile move("move.toml", "");
  const std::string file = move.path().string();
  expect_plan_refused(file, file + ":1:1", {"the file is empty"});
}

TEST(BadInput, AnAxisThatTheRigDoesNotHave) {
  const MarkedText text = without_mark(with(arc, "[\"x\", \"y\"]", "[\"x\", @\"y\"]"));
  const TemporaryFile move("move.toml", text.text);
  const TemporaryFile machine("rig.toml", rig);
  const std::string file = move.path().string();
  expect_plan_refused(file, fmt::format("{}:{}:{}", file, text.line, text.column),
                      {"the rig \"table\" has no axis \"y\"", "it has x"},
                      {"--rig", machine.path().string()});
}

TEST(BadInput, AMistakeInTheRigNamesTheRigsFile) {
  const MarkedText text = without_mark(with(rig, "\"mm\"", "@\"inch\""));
  const TemporaryFile move("move.toml", arc);
  const TemporaryFile machine("rig.toml", text.text);
  const std::string file = machine.path().string();
  expect_plan_refused(move.path(), fmt::format("{}:{}:{}", file, text.line, text.column), {"\"inch\""},
                      {"--rig", file});
}

TEST(BadInput, AMoveThatWouldTickForYears) {
  std::string text = with(arc, "fps = 24", "fps = \"1/1000000\"");
  text = with(with(text, "48", "@1000000"), "[\"x\", \"y\"]", "[\"x\"]");
  text = with(with(text, "[0, 0]", "[0]"), "[30, 40]", "[30]");
  const MarkedText marked = without_mark(with(with(text, "[60, 7]", "[60]"), "[1, 2]", "[1]"));
  const TemporaryFile move("move.toml", marked.text);
  const TemporaryFile machine("rig.toml", rig);
  const std::string file = move.path().string();
  expect_plan_refused(file, fmt::format("{}:{}:{}", file, marked.line, marked.column),
                      {"100000000000000 ticks", "lower frames or rate_hz"},
                      {"--rig", machine.path().string(), "--per", "tick"});
}

/// The table's `x` as a stepper, with lines.
const std::string stepper_rig = R"(name = "table"
rate_hz = 100
[emergency_stop]
chip = "head"
line = 5
stops_at = "high"
[output.lamp]
chip = "head"
line = 6
[[axis]]
name = "x"
unit = "mm"
min = -1
max = 100
max_velocity = 100
max_acceleration = 100
drive = { type = "step-dir", chip = "head", step = 17, dir = 27, steps_per_unit = 80 }
)";

/// Plans the arc's x on the rig in which the place is marked.
void expect_rig_refused(const std::string& marked, std::initializer_list<std::string_view> words) {
  const MarkedText text = without_mark(marked);
  const TemporaryFile move("move.toml", arc);
  const TemporaryFile machine("rig.toml", text.text);
  const std::string file = machine.path().string();
  expect_plan_refused(move.path(), fmt::format("{}:{}:{}", file, text.line, text.column), words,
                      {"--rig", file});
}

TEST(BadInput, ALineThatIsUsedTwice) {
  expect_rig_refused(with(stepper_rig, "dir = 27", "dir = @17"),
                     {"line 17 of chip \"head\"", "use each line once"});
}

TEST(BadInput, AnEmergencyStopThatABrokenWireWouldSilence) {
  expect_rig_refused(with(stepper_rig, "\"high\"", "\"high\"\nbias = @\"pull-down\""),
                     {"a broken wire would"});
}

TEST(BadInput, AnEmergencyStopWithoutItsLevel) {
  expect_rig_refused(with(with(stepper_rig, "stops_at = \"high\"\n", ""), "[emerg", "@[emerg"),
                     {"no stops_at"});
}

TEST(BadInput, StepsThatAreTooFast) {
  expect_rig_refused(with(stepper_rig, "= 80", "= @101"), {"is 10100 steps/s", "max_step_rate = 10000"});
}

TEST(BadInput, StepsThatAreTooShort) {
  expect_rig_refused(with(stepper_rig, "= 80", "= 80, pulse_us = @96"), {"lower one of the three"});
}

TEST(BadInput, AHomeThatCannotBeFound) {
  expect_rig_refused(stepper_rig +
                         "home = { chip = \"head\", line = 7, direction = \"positive\", at = @-2, fast = 2, "
                         "slow = 1, back_off = 1 }",
                     {"no way up leads", "or the other direction"});
}

TEST(BadInput, ACueBeyondTheEnd) {
  expect_move_refused(arc + "[[cue]]\nline = \"lamp\"\nframes = [1, @49]\nwidth_ms = 5\n",
                      {"frames[1] is 49"});
}

TEST(BadInput, CuesThatOverlap) {
  expect_move_refused(arc + "[[cue]]\nline = \"lamp\"\nframes = [1, @2]\nwidth_ms = 50\n",
                      {"41.6667 ms after that of frame 1", "make that narrower"});
}

TEST(BadInput, ACueOnALineThatTheRigDoesNotHave) {
  std::string text = with(with(arc, "[\"x\", \"y\"]", "[\"x\"]"), "weights = [1, 2]\n", "");
  text = with(with(with(text, "[0, 0]", "[0]"), "[30, 40]", "[30]"), "[60, 7]", "[60]");
  const MarkedText move_text = without_mark(text + "[[cue]]\nline = @\"lump\"\nframes = [1]\nwidth_ms = 5\n");
  const TemporaryFile move("move.toml", move_text.text);
  const TemporaryFile machine("rig.toml", stepper_rig);
  const std::string file = move.path().string();
  EXPECT_EQ(run_program({"plan", file}).status, 0) << "no rig, no lines";
  expect_plan_refused(file, fmt::format("{}:{}:{}", file, move_text.line, move_text.column),
                      {"the rig \"table\" has no output \"lump\"; it has lamp"},
                      {"--rig", machine.path().string()});
}

}  // namespace bad_input_test
}  // namespace inbetween
