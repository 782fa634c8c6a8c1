// What a move or a rig gets wrong meets one line on standard error with place and remedy, exit status 1,
// nothing on standard output, no file left behind, and not much memory. What each reader refuses, and where
// it says so, is in move_file_test.cpp, move_cue_test.cpp, rig_file_test.cpp and rig_gpio_test.cpp.
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
    rig_text({{.name = "x", .min = -1, .max = 100, .max_velocity = 100, .max_acceleration = 100}},
             {.more = "[output.lamp]\nline = \"LAMP\"\n"});

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

TEST(BadInput, NoSpeedAnywhereOnARealPath) {
  expect_move_refused(with(arc, "[0, 0, 10, 5, 0]", "@[0, 0, 0]"), {"raise a control value above 0"});
}

TEST(BadInput, AnAxisThatMovesWhereThePathHasNoLength) {
  std::string text = with(arc, "[1, 2]", "[1, 0]");
  text = with(text, "{ at = [0, 0] }, { at = [30, 40] }", "{ at = [30, @0] }, { at = [30, 40] }");
  expect_move_refused(text, {"axis \"y\"", "key 0", "give the axis a weight above 0"});
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

TEST(BadInput, ACueOnALineThatTheRigDoesNotHave) {
  std::string text = with(with(arc, "[\"x\", \"y\"]", "[\"x\"]"), "weights = [1, 2]\n", "");
  text = with(with(with(text, "[0, 0]", "[0]"), "[30, 40]", "[30]"), "[60, 7]", "[60]");
  const MarkedText move_text = without_mark(text + "[[cue]]\nline = @\"lump\"\nframes = [1]\nwidth_ms = 5\n");
  const TemporaryFile move("move.toml", move_text.text);
  const TemporaryFile machine("rig.toml", rig);
  const std::string file = move.path().string();
  EXPECT_EQ(run_program({"plan", file}).status, 0) << "no rig, no lines";
  expect_plan_refused(file, fmt::format("{}:{}:{}", file, move_text.line, move_text.column),
                      {"the rig \"table\" has no output \"lump\"; it has lamp"},
                      {"--rig", machine.path().string()});
}

}  // namespace bad_input_test
}  // namespace inbetween
