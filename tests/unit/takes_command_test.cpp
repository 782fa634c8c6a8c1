// inbetween takes as its users meet it: what takes were like, and what is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host_tools/takes/take_store.hpp"
#include "tests/support/places.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace takes_command_test {

using testing::AllOf;
using testing::HasSubstr;
using testing::MatchesRegex;
using testing::Not;
using testing::StartsWith;

/// A folder with takes, into which runs are kept.
class TakesCommand : public testing::Test {
 protected:
  [[nodiscard]] std::string in_folder(const std::string& name) const { return folder_.path() / name; }

  /// A simulated run of a move that is kept.
  void play(const std::string& move, const std::string& rig, const std::vector<std::string>& others = {}) {
    std::vector<std::string> words{"run", move, "--rig", rig, "--sim", "--fast", "--takes-in", db_};
    words.insert(words.end(), others.begin(), others.end());
    const ProgramRun run = run_program(words);
    ASSERT_EQ(run.status, 0) << run.err;
  }
  void play_crane(const std::vector<std::string>& others = {}) {
    play(in_checkout("examples/crane/round_the_puppet.toml"), in_checkout("examples/crane/rig.toml"), others);
  }
  [[nodiscard]] ProgramRun takes(std::vector<std::string> words) const {
    words.insert(words.begin(), "takes");
    words.insert(words.end(), {"--in", db_});
    return run_program(words);
  }

  TemporaryFolder folder_;
  std::string db_ = folder_.path() / "takes.db";
};

TEST_F(TakesCommand, AFasterPassIsComparedWithASlowOneAndHeldToABudget) {
  play_crane({"--rate", "0.5"});
  play_crane();
  const ProgramRun apart = takes({"compare", "1", "2"});
  EXPECT_EQ(apart.status, 0) << apart.err;
  EXPECT_THAT(apart.out, AllOf(StartsWith("take 2 differs from take 1 by at most"),
                               HasSubstr("camera, distance"), HasSubstr("camera, picture"), HasSubstr("px")));
  const ProgramRun over = takes({"compare", "1", "2", "--budget", "0.1px"});
  EXPECT_EQ(over.status, 3);
  EXPECT_THAT(over.out, HasSubstr("over the budget of 0.1 px"));
  const ProgramRun within = takes({"compare", "1", "2", "--budget", "100px"});
  EXPECT_EQ(within.status, 0);
  EXPECT_THAT(within.out, HasSubstr("within the budget of 100 px"));
}

TEST_F(TakesCommand, TheSamePassTwiceIsTheSameToTheLastCount) {
  play_crane();
  play_crane();
  const ProgramRun same = takes({"compare", "1", "2", "--budget", "0px"});
  EXPECT_EQ(same.status, 0) << same.err;
  EXPECT_THAT(same.out, StartsWith("take 2 was where take 1 was, to the last count\n"));
  EXPECT_THAT(same.out, Not(HasSubstr("e-")));
}

TEST_F(TakesCommand, ThreeTakesHavePathAccuracyAndRepeatability) {
  for (const char* const rate : {"0.5", "1", "1"}) play_crane({"--rate", rate});
  const ProgramRun passes = takes({"compare", "1", "2", "3", "--json", "-"});
  ASSERT_EQ(passes.status, 0) << passes.err;
  const auto json = nlohmann::json::parse(passes.out);
  EXPECT_EQ(json["takes"], (std::vector<int>{1, 2, 3}));
  EXPECT_EQ(json["comparisons"].size(), 2U);
  EXPECT_GT(json["measures"][6]["repeatability"], 0.0);
  EXPECT_THAT(takes({"compare", "1", "2", "3"}).out, HasSubstr("3 takes at"));
}

TEST_F(TakesCommand, ErrorsAgainstThePlanAreShownAndJudged) {
  play_crane();
  const ProgramRun errors = takes({"show", "1", "--errors", "--json", "-", "--budget", "1mm"});
  EXPECT_EQ(errors.status, 3) << errors.err;
  const auto json = nlohmann::json::parse(errors.out);
  EXPECT_EQ(json["measures"].size(), 9U);
  EXPECT_EQ(json["budget"]["holds"], false);
  EXPECT_THAT(takes({"show", "1", "--errors"}).out, StartsWith("take 1: actual less commanded, at "));
}

TEST_F(TakesCommand, WhatChangesFromTakeToTakeIsOnePicture) {
  play_crane({"--rate", "0.5"});
  play_crane();
  const ProgramRun trend = takes({"plot", "--trend", "--plot", in_folder("trend.svg")});
  EXPECT_EQ(trend.status, 0) << trend.err;
  EXPECT_THAT(trend.out, HasSubstr("trend.svg: 2 takes are drawn"));
  EXPECT_THAT(file_contents(in_folder("trend.svg")), HasSubstr("</svg>"));
}

TEST_F(TakesCommand, PulsesAreAmongWhatHappened) {
  play(in_checkout("examples/slide_and_pan.toml"), in_checkout("examples/slider_rig.toml"));
  EXPECT_THAT(takes({"show", "1"}).out, HasSubstr(" pulse "));
}

TEST_F(TakesCommand, AFaultIsToldInTheTickThatTheStopBeganIn) {
  const ProgramRun run = run_program({"run", in_checkout("examples/reveal.toml"), "--rig",
                                      in_checkout("examples/camera_rig.toml"), "--sim", "--fast", "--faults",
                                      in_checkout("examples/faults/lost_axis.toml"), "--takes-in", db_});
  ASSERT_EQ(run.status, 4);
  const nlohmann::json events = nlohmann::json::parse(takes({"show", "1", "--json", "-"}).out)["events"];
  const auto of_kind = [&](const std::string& kind, const std::string& text) {
    return std::ranges::find_if(events, [&](const nlohmann::json& event) {
      return event["kind"] == kind && event["text"].get<std::string>().find(text) != std::string::npos;
    });
  };
  const auto stop = of_kind("state", "stopping"), fault = of_kind("fault", "tilt");
  ASSERT_NE(stop, events.end()) << events;
  ASSERT_NE(fault, events.end()) << events;
  EXPECT_EQ((*stop)["tick"], (*fault)["tick"]);
}

TEST_F(TakesCommand, ATakeIsMeasuredThoughItsRigIsAnotherByNow) {
  std::filesystem::copy(in_checkout("examples/crane"), in_folder("crane"));
  play(in_folder("crane/round_the_puppet.toml"), in_folder("crane/rig.toml"));
  std::filesystem::remove_all(in_folder("crane"));
  EXPECT_EQ(takes({"show", "1", "--errors"}).status, 0);
  EXPECT_EQ(takes({"export", "1", "--trajectory", in_folder("take.json")}).status, 0);
}

TEST_F(TakesCommand, ACurveBesideTheMoveIsAFileOfTheTake) {
  for (const char* const file : {"fish.toml", "fish_fin.csv", "fish_rig.toml"})
    std::filesystem::copy(in_checkout("examples/") + file, in_folder(file));
  play(in_folder("fish.toml"), in_folder("fish_rig.toml"));
  EXPECT_THAT(takes({"show", "1"}).out, HasSubstr("fish_fin.csv  "));
  std::ofstream(in_folder("fish_fin.csv"), std::ios::app) << "\n";
  const ProgramRun again = run_program({"run", in_folder("fish.toml"), "--rig", in_folder("fish_rig.toml"),
                                        "--sim", "--fast", "--takes-in", db_, "--take", "1"});
  EXPECT_EQ(again.status, 1);
  EXPECT_THAT(again.err, HasSubstr("fish_fin.csv: error: "));
  std::filesystem::remove(in_folder("fish_fin.csv"));
  EXPECT_EQ(takes({"export", "1", "--trajectory", in_folder("take.json")}).status, 0);
}

TEST_F(TakesCommand, WhatItCannotDoIsOneLine) {
  play(in_checkout("examples/reveal.toml"), in_checkout("examples/camera_rig.toml"));
  struct Refused {
    std::vector<std::string> words;
    int status;
    std::string says;
  };
  const std::vector<Refused> all = {
      {{"compare", "1"}, 2, "TAKE"},
      {{"compare", "1", "7"}, 1, "takes.db: error: there is no take 7; inbetween takes list shows all"},
      {{"show", "1", "--budget", "1px"}, 2, "--budget is for errors; add --errors"},
      {{"show", "1", "--errors", "--budget", "1px"}, 1, "px"},
      {{"compare", "1", "1", "--budget", "1 parsec"}, 1, "\"1 parsec\" is no budget; write a number from 0"},
      {{"plot", "--plot", in_folder("one.svg")}, 2, "name the take to draw"},
      {{"plot", "1", "--plot", in_folder("one.svg"), "--json", "-"}, 2, "--json is for --trend"},
  };
  for (const Refused& refused : all) {
    const ProgramRun run = takes(refused.words);
    EXPECT_EQ(run.status, refused.status) << refused.says;
    EXPECT_THAT(run.err, HasSubstr(refused.says));
    EXPECT_THAT(run.err, MatchesRegex("[^\n]*\n([^\n]*\n)?")) << run.err;
  }
}

}  // namespace takes_command_test
}  // namespace inbetween
