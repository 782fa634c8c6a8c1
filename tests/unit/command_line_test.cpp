// The command line as its users meet it: help, wrong usage, exit statuses, and where words go.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/places.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace command_line_test {

namespace fs = std::filesystem;
using testing::ContainsRegex;
using testing::EndsWith;
using testing::HasSubstr;
using testing::MatchesRegex;
using testing::StartsWith;

const std::string move = in_checkout("examples/reveal.toml");
const std::string rig = in_checkout("examples/camera_rig.toml");

std::size_t lines(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

/// Status 2 and one line that says what is wrong and where help is.
void expect_wrong_usage(const std::vector<std::string>& arguments,
                        std::initializer_list<std::string_view> words) {
  const ProgramRun run = run_program(arguments);
  EXPECT_EQ(run.status, 2) << run.err;
  EXPECT_EQ(run.out, "");
  EXPECT_EQ(lines(run.err), 1U) << run.err;
  EXPECT_THAT(run.err, StartsWith("inbetween: error: "));
  EXPECT_THAT(run.err, EndsWith("--help\n"));
  for (const std::string_view word : words) EXPECT_THAT(run.err, HasSubstr(std::string(word)));
}

void expect_help(const std::vector<std::string>& arguments, std::initializer_list<const char*> words) {
  const ProgramRun run = run_program(arguments);
  EXPECT_EQ(run.status, 0);
  EXPECT_EQ(run.err, "");
  for (const char* word : words) EXPECT_THAT(run.out, HasSubstr(word));
}

TEST(CommandLine, EveryCommandSaysInTheSameWordsWhatItWritesAsJson) {
  for (const char* command : {"plan", "check", "run", "doctor"}) {
    const std::string help = run_program({command, "--help"}).out;
    const std::size_t option = help.find("\n  --json TEXT"), end = help.find("\n  -", option + 1);
    ASSERT_NE(option, std::string::npos) << command;
    const std::string words = help.substr(option, end - option);
    EXPECT_THAT(words, HasSubstr(" write ")) << command;
    EXPECT_THAT(words, HasSubstr("(- is standard output)")) << command;
  }
}

TEST(CommandLine, ItsHelpNamesEveryCommandAndEveryExitStatus) {
  expect_help({"--help"}, {"\n  plan ", "\n  check ", "\n  run ", "\n  goto ", "\n  home ", "\n  jog ",
                           "\n  sim-drives ", "--version", "--help", "0 done", "1 bad input", "2 wrong usage",
                           "3 a limit would be exceeded", "4 stopped by a fault", "docs/formats.md"});
}

TEST(CommandLine, TheHelpOfPlanNamesEveryOption) {
  expect_help({"plan", "--help"},
              {"MOVE", "--rig ", "--per", "--solver", "--csv", "--json", "--plot", "--help", "frame", "tick",
               "closed-form", "runge-kutta", "svg", "png", "pdf"});
}

TEST(CommandLine, TheHelpOfRunShowsEveryOptionInAGroup) {
  const std::string help = run_program({"run", "--help"}).out;
  const std::size_t options = help.find("\nOptions:\n");
  const std::size_t first_group = help.find("\nThe rig, or one that is simulated:\n");
  ASSERT_LT(options, first_group);
  EXPECT_THAT(help.substr(options, first_group - options), HasSubstr("--help"));
  EXPECT_EQ(help.substr(options, first_group - options).find("\n  --"), std::string::npos)
      << "an option without a group";
  const std::size_t played = help.find("\nWhat is played, and how fast:\n");
  const std::size_t written = help.find("\nWhat is written:\n");
  EXPECT_LT(first_group, played);
  EXPECT_LT(played, help.find("\n  --frames "));
  EXPECT_LT(help.find("\n  --frames "), written);
  EXPECT_LT(written, help.find("\nStop motion and go-motion:\n"));
}

TEST(CommandLine, TheHelpOfRunNamesEveryOption) {
  expect_help({"run", "--help"}, {"MOVE", "--rig ", "--sim ", "--fast ", "--json ", "--help", "--cue-log ",
                                  "start = \"trigger\"", "[start_trigger]", "[camera]", "[output.NAME]"});
}

TEST(CommandLine, SaysItsVersion) {
  const ProgramRun run = run_program({"--version"});
  EXPECT_EQ(run.status, 0);
  EXPECT_THAT(run.out, MatchesRegex("inbetween [0-9]+\\.[0-9]+\\.[0-9]+\n"));
}

TEST(CommandLine, WrongUsageIsOneLineWithStatus2) {
  expect_wrong_usage({}, {"no command is given"});
  expect_wrong_usage({"dance"}, {"there is no command \"dance\"; there are plan, check, edit, run, goto,"});
  expect_wrong_usage({"plan"}, {"MOVE is required", "inbetween plan --help"});
  expect_wrong_usage({"plan", move, "--speed", "3"}, {"--speed"});
  expect_wrong_usage({"plan", move, move}, {move});
  expect_wrong_usage({"plan", move, "--json"}, {"--json"});
  expect_wrong_usage({"plan", move, "--per", "second"}, {"--per", "second", "frame", "tick"});
  expect_wrong_usage({"plan", move, "--solver", "euler"}, {"--solver", "euler", "runge-kutta"});
  expect_wrong_usage({"plan", move, "--csv", "a", "--csv", "b"}, {"--csv"});
  expect_wrong_usage({"run", move}, {"--rig is required", "inbetween run --help"});
  expect_wrong_usage({"run", "--rig", rig, "--sim"}, {"MOVE is required"});
}

TEST(CommandLine, ANumberOutsideItsRangeIsToldTheRangeThatTheHelpShows) {
  expect_help({"goto", "--help"}, {" FLOAT:0.001 to 1="});
  expect_wrong_usage({"goto", "--rig", rig, "x=1", "--speed", "3"},
                     {"--speed: 3 is not in the range 0.001 to 1;"});
  expect_wrong_usage({"goto", "--rig", rig, "x=1", "--speed", "fast"},
                     {"fast is not in the range 0.001 to 1"});
}

TEST(CommandLine, AWordThatNamesNothingIsToldWithTheOneThatIsProbablyMeant) {
  expect_wrong_usage({"chek"}, {"there is no command \"chek\"; did you mean check? See inbetween --help"});
  expect_wrong_usage({"chek", move}, {"did you mean check?"});
  expect_wrong_usage({"plan", move, "--jsn", "a"}, {"there is no option --jsn; did you mean --json? See"});
  expect_wrong_usage({"run", "--foo=1"}, {"there is no option --foo; see inbetween run --help"});
  expect_wrong_usage({"plan", move, "twice"}, {"\"twice\" is one argument too many; see"});
  expect_wrong_usage({"plan", move, "--json"}, {"--json needs a value; see"});
}

TEST(CommandLine, OptionsThatDoNotGoTogetherAreRefused) {
  expect_wrong_usage({"plan", move, "--per", "tick"}, {"--per tick needs --rig"});
  expect_wrong_usage({"plan", move, "--rig", rig, "--per", "tick", "--solver", "runge-kutta"},
                     {"--solver runge-kutta", "frames only"});
  expect_wrong_usage({"plan", move, "--csv", "-", "--json", "-"}, {"--csv and --json", "standard output"});
  expect_wrong_usage({"run", move, "--rig", rig, "--from", "pan=1"}, {"add --sim"});
  expect_wrong_usage({"run", move, "--rig", rig, "--sim", "--allow-jitter"}, {"leave out --sim"});
  expect_wrong_usage({"run", move, "--rig", rig, "--fast"}, {"add --sim"});
}

TEST(CommandLine, APictureOfAnUnknownKindIsRefusedBeforeAnythingIsWritten) {
  const TemporaryFolder folder;
  const std::string csv = (folder.path() / "a.csv").string();
  expect_wrong_usage({"plan", move, "--csv", csv, "--plot", "a.gif"}, {"--plot a.gif", ".svg, .png or .pdf"});
  expect_wrong_usage({"plan", move, "--plot", "-"}, {"--plot -", ".svg, .png or .pdf"});
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(CommandLine, NoOutputGoesOverAnother) {
  const TemporaryFolder folder;
  const std::string file = (folder.path() / "a").string();
  const std::string same = (folder.path() / "." / "a").string();
  expect_wrong_usage({"plan", move, "--csv", file, "--json", same}, {"--csv and --json", "its own file"});
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(CommandLine, NoOutputGoesOverAnInput) {
  const TemporaryFile copy("move.toml", file_contents(move));
  const TemporaryFile machine("rig.toml", file_contents(rig));
  const std::string text = file_contents(move);
  expect_wrong_usage({"plan", copy.path().string(), "--json", copy.path().string()}, {"MOVE and --json"});
  expect_wrong_usage(
      {"plan", copy.path().string(), "--rig", machine.path().string(), "--csv", machine.path().string()},
      {"--rig and --csv"});
  expect_wrong_usage({"run", copy.path().string(), "--rig", machine.path().string(), "--sim", "--json",
                      copy.path().string()},
                     {"MOVE and --json"});
  EXPECT_EQ(file_contents(copy.path().string()), text);
}

TEST(CommandLine, TwoOutputsMayGoToOneDevice) {
  EXPECT_EQ(run_program({"plan", move, "--csv", "/dev/null", "--json", "/dev/null"}).status, 0);
}

TEST(CommandLine, PlanPrintsASummary) {
  const ProgramRun run = run_program({"plan", move, "--rig", rig});
  EXPECT_EQ(run.status, 0);
  EXPECT_EQ(run.err, "");
  EXPECT_THAT(run.out, HasSubstr("reveal: 192 frames at 24 fps, 8.000 s\n"));
  EXPECT_THAT(run.out, HasSubstr("slide, pan, tilt: 5 keys, length "));
  EXPECT_THAT(run.out, HasSubstr("closed form, speed within 1e-06"));
}

TEST(CommandLine, TheSummarySaysWhatTheDrawnSpeedIs) {
  const TemporaryFile steady(
      "steady.toml",
      "name = 'steady'\nfps = 24\nframes = 48\n[[track]]\naxes = ['x']\nspline = 'linear'\n"
      "keys = [{ at = [0] }, { at = [96] }]\nspeed = [10, 10, 10]\n");
  EXPECT_THAT(run_program({"plan", steady.path()}).out, HasSubstr(", 10 on the speed curve is 48 a second;"));
}

TEST(CommandLine, TheSummaryOfThePapersSolverSaysHowFarOffItIs) {
  const ProgramRun run = run_program({"plan", move, "--solver", "runge-kutta"});
  EXPECT_EQ(run.status, 0);
  EXPECT_THAT(run.out, ContainsRegex("Runge-Kutta, [0-9]+ integrations of 10 steps a frame, speed within "
                                     "[0-9.e-]+ .frame [0-9]+."));
}

TEST(CommandLine, ADashIsStandardOutputAndTheSummaryMakesWay) {
  const ProgramRun json = run_program({"plan", move, "--json", "-"});
  EXPECT_EQ(json.status, 0);
  EXPECT_EQ(nlohmann::json::parse(json.out)["name"], "reveal");
  EXPECT_THAT(json.err, StartsWith("reveal: 192 frames"));
  const ProgramRun csv = run_program({"plan", move, "--csv", "-"});
  EXPECT_EQ(lines(csv.out), 194U);
  EXPECT_THAT(csv.err, StartsWith("reveal: 192 frames"));
}

TEST(CommandLine, EveryOutputOfAPlanIsWritten) {
  const TemporaryFolder folder;
  const auto file = [&](const char* name) { return (folder.path() / name).string(); };
  const ProgramRun run =
      run_program({"plan", move, "--csv", file("a.csv"), "--json", file("a.json"), "--plot", file("a.svg")});
  EXPECT_EQ(run.status, 0);
  EXPECT_THAT(run.out, StartsWith("reveal: "));
  EXPECT_EQ(file_contents(file("a.csv")), run_program({"plan", move, "--csv", "-"}).out);
  EXPECT_EQ(file_contents(file("a.json")), run_program({"plan", move, "--json", "-"}).out);
  EXPECT_THAT(file_contents(file("a.svg")), HasSubstr("<svg"));
}

TEST(CommandLine, AWarningGoesToStandardErrorAndThePlanIsMade) {
  const std::string text = file_contents(move);
  const std::size_t weights = text.find("weights");
  const TemporaryFile unweighted("move.toml", text.substr(0, weights));
  const ProgramRun run = run_program({"plan", unweighted.path().string(), "--rig", rig});
  EXPECT_EQ(run.status, 0);
  EXPECT_EQ(lines(run.err), 1U);
  EXPECT_THAT(run.err, StartsWith(unweighted.path().string() + ":7:1: warning: 1 mm counts as 1 deg"));
}

TEST(CommandLine, AFullDiskIsStatus1) {
  for (const char* option : {"--csv", "--json"}) {
    const ProgramRun run = run_program({"plan", move, option, "/dev/full"});
    EXPECT_EQ(run.status, 1) << option;
    EXPECT_EQ(run.out, "") << option;
    EXPECT_EQ(lines(run.err), 1U) << run.err;
    EXPECT_THAT(run.err, StartsWith("/dev/full: error: "));
    EXPECT_THAT(run.err, HasSubstr("No space left on device; "));
  }
  const ProgramRun run = run_program({"run", move, "--rig", rig, "--sim", "--fast", "--json", "/dev/full"});
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.err, StartsWith("/dev/full: error: "));
}

TEST(CommandLine, StandardOutputThatIsFullIsStatus1) {
  const std::vector<std::vector<std::string>> commands = {{"plan", move},
                                                          {"plan", move, "--json", "-"},
                                                          {"plan", move, "--csv", "-"},
                                                          {"check", move, "--rig", rig},
                                                          {"check", move, "--rig", rig, "--json", "-"},
                                                          {"run", move, "--rig", rig, "--sim", "--fast"},
                                                          {"--help"},
                                                          {"--version"}};
  for (const auto& command : commands) {
    const ProgramRun run = run_program(command, {.out_path = "/dev/full", .err_path = {}});
    EXPECT_EQ(run.status, 1) << command.front();
    EXPECT_THAT(run.err, HasSubstr("standard output: error: cannot be written: No space left on device; "))
        << fmt::format("{}", fmt::join(command, " "));
  }
  // Line by line, as on a terminal, it is found where it is printed.
  const ProgramRun by_line =
      run_command({"/usr/bin/stdbuf", "-oL", in_build("inbetween"), "check", move, "--rig", rig},
                  {.out_path = "/dev/full", .err_path = {}});
  EXPECT_EQ(by_line.status, 1);
  EXPECT_EQ(
      by_line.err,
      "standard output: error: cannot be written: No space left on device; redirect it to another file\n");
}

TEST(CommandLine, WhereNobodyReadsTheErrorTheStatusStillTells) {
  EXPECT_EQ(run_program({"plan", "no.toml"}, {.out_path = {}, .err_path = "/dev/full"}).status, 1);
  EXPECT_EQ(run_program({"dance"}, {.out_path = {}, .err_path = "/dev/full"}).status, 2);
}

TEST(CommandLine, AnEmptyNameIsNoName) {
  for (const char* option : {"--csv", "--json", "--rig"}) {
    const ProgramRun run = run_program({"plan", move, option, ""});
    EXPECT_NE(run.status, 0) << option;
    EXPECT_EQ(lines(run.err), 1U) << run.err;
  }
}

}  // namespace command_line_test
}  // namespace inbetween
