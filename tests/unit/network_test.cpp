// Networks of moving points, as an animator meets them: a mouth whose corners are drawn, a fin whose tip a
// hand has drawn into a file.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "host_tools/edit/edit_session.hpp"
#include "host_tools/move_model/move_rewrite.hpp"
#include "host_tools/plan/plan.hpp"
#include "host_tools/plan/plan_output.hpp"
#include "host_tools/text/csv_table.hpp"
#include "tests/support/places.hpp"
#include "tests/support/refused_text.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/run_on.hpp"

namespace inbetween {
namespace network_test {

using Json = nlohmann::json;
using testing::HasSubstr;
using testing::Not;

/// Three axes, the first and the last drawn.
const std::string mouth = R"(name = "mouth"
fps = 24
frames = 24
[[track]]
axes = ["left", "lip", "right"]
network = true
timing = "frames"
drawn = { left = [{ frame = 0, at = 0 }, { frame = 10, at = 6 }, { frame = 24, at = 0 }], right = [{ frame = 0, at = 0 }, { frame = 12, at = -2 }, { frame = 24, at = 0 }] }
keys = [{ at = [0, 0, 0], frame = 0 }, { at = [0, 0, 0], frame = 24 }]
)";

/// The same with a file for the left corner.
const std::string from_file =
    with(mouth, "[{ frame = 0, at = 0 }, { frame = 10, at = 6 }, { frame = 24, at = 0 }]", "\"left.csv\"");

const std::string rig = rig_text({{.name = "left", .more = "max_jerk = 40000"},
                                  {.name = "lip", .more = "max_jerk = 40000"},
                                  {.name = "right", .more = "max_jerk = 40000"}});

Plan planned(const std::string& text) {
  return {parse_move(text, "move.toml"), std::nullopt, {}};
}

std::vector<double> at(const Plan& plan, std::int32_t frame, double fraction = 0) {
  std::vector<double> positions(plan.axes().size());
  plan.tracks().front().track().positions({frame, fraction}, positions);
  return positions;
}

/// A move with files beside it.
class MoveFolder {
 public:
  MoveFolder(const std::string& move, const std::vector<std::pair<std::string, std::string>>& files) {
    write("move.toml", move);
    for (const auto& [name, bytes] : files) write(name, bytes);
  }
  [[nodiscard]] std::string path(const std::string& name = "move.toml") const {
    return (folder_.path() / name).string();
  }
  [[nodiscard]] Plan plan() const { return {read_move_file(path()), std::nullopt, {}}; }
  [[nodiscard]] std::string refusal() const {
    try {
      static_cast<void>(plan());
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), Not(HasSubstr("\n")));
      return error.what();
    }
    return "";
  }

 private:
  void write(const std::string& name, const std::string& bytes) const {
    std::ofstream(path(name), std::ios::binary) << bytes;
  }
  TemporaryFolder folder_;
};

std::string refusal_of_csv(const std::string& csv) {
  return MoveFolder(from_file, {{"left.csv", csv}}).refusal();
}

TEST(Network, TheMiddleOfAMouthGoesHalfWayWithItsCorners) {
  const Plan plan = planned(mouth);
  for (std::int32_t frame = 0; frame < 24; ++frame) {
    for (const double fraction : {0.0, 0.375}) {
      const std::vector<double> here = at(plan, frame, fraction);
      EXPECT_NEAR(here[1], (here[0] + here[2]) / 2, 1e-12) << frame;
    }
  }
  EXPECT_NEAR(at(plan, 10)[0], 6, 1e-12);
  EXPECT_NEAR(at(plan, 12)[2], -2, 1e-12);
}

TEST(Network, AKeyOfAnAxisThatIsNotDrawnIsMetBesideWhatIsDrawn) {
  const Plan plan = planned(with(mouth, "{ at = [0, 0, 0], frame = 24 }",
                                 "{ at = { lip = 7 }, frame = 16 }, { at = [0, 0, 0], frame = 24 }"));
  EXPECT_NEAR(at(plan, 16)[1], 7, 1e-12);
  EXPECT_NEAR(at(plan, 10)[0], 6, 1e-12);
}

TEST(Network, AtAnEndOfTheRowThatIsNotDrawnNothingIsAdded) {
  const std::string fin = with(
      with(mouth, "left = [{ frame = 0, at = 0 }, { frame = 10, at = 6 }, { frame = 24, at = 0 }], ", ""),
      "network = true", "network = true\nplaces = [0, 1, 4]");
  const Plan plan = planned(fin);
  for (std::int32_t frame = 0; frame <= 24; ++frame) {
    const std::vector<double> here = at(plan, frame);
    EXPECT_NEAR(here[0], 0, 1e-12) << frame;
    EXPECT_NEAR(here[1], here[2] / 4, 1e-12) << frame;
  }
}

TEST(Network, AnAxisBesideDrawnOnesOfItsPlaceSeesTheirMean) {
  const Plan plan = planned(with(mouth, "network = true", "network = true\nplaces = [2, 2, 2]"));
  for (std::int32_t frame = 0; frame <= 24; ++frame) {
    const std::vector<double> here = at(plan, frame);
    EXPECT_NEAR(here[1], (here[0] + here[2]) / 2, 1e-12) << frame;
  }
}

TEST(Network, AKeyThatLeavesOutADrawnAxisIsOnItsCurve) {
  const std::string text = with(mouth, "{ at = [0, 0, 0], frame = 24 }",
                                "{ at = { lip = 1 }, frame = 5 }, { at = { lip = 0 }, frame = 24 }");
  const Plan plan = planned(text);
  EXPECT_NEAR(plan.move().tracks[0].keys[1].at[0], at(plan, 5)[0], 1e-12);
  EXPECT_GT(plan.move().tracks[0].keys[1].at[0], 1);
  EXPECT_NEAR(at(plan, 5)[1], 1, 1e-12);
}

TEST(Network, ItRestsAtItsEndsAndNeedsNoRolls) {
  const ProgramRun run = run_on(rig, "check", mouth);
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("no step of velocity or acceleration"));
  const ProgramRun plan = run_on(rig, "plan", mouth, {"--json", "-"});
  ASSERT_EQ(plan.status, 0) << plan.err;
  EXPECT_TRUE(Json::parse(plan.out)["pre_roll"].is_null());
  EXPECT_TRUE(Json::parse(plan.out)["post_roll"].is_null());
  const ProgramRun moving =
      run_on(rig, "plan", with(mouth, "network = true", "network = true\nrest = \"start\""), {"--json", "-"});
  ASSERT_EQ(moving.status, 0) << moving.err;
  EXPECT_TRUE(Json::parse(moving.out)["pre_roll"].is_null());
  EXPECT_FALSE(Json::parse(moving.out)["post_roll"].is_null());
}

TEST(Network, ACurveInAFileIsTheCurveOfItsPoints) {
  const std::string wanted = hash_in_words(planned(mouth).move());
  for (const char* csv :
       {"frame,left\n0,0\n10,6\n24,0\n", "\xEF\xBB\xBF\"frame\" , \"left\"\r\n0,0\r\n\r\n 10 , 6.0\r\n24,0",
        "time_s,left,frame,right\n0,0,0,9\n0.1,,4,8\n0.4,6,10,7\n1,0,24,6\n"}) {
    EXPECT_EQ(hash_in_words(MoveFolder(from_file, {{"left.csv", csv}}).plan().move()), wanted) << csv;
  }
}

TEST(Network, ATableThatPlanHasWrittenCanBeDrawn) {
  const std::string cm = with(mouth, "network = true", "network = true\nunit = \"mm\"");
  const TemporaryFile move("move.toml", cm);
  const ProgramRun csv = run_program({"plan", move.path().string(), "--csv", "-"});
  ASSERT_EQ(csv.status, 0) << csv.err;
  EXPECT_THAT(csv.out, HasSubstr("left (mm)"));
  const std::string drawn = with(from_file, "network = true", "network = true\nunit = \"cm\"");
  const Plan plan = MoveFolder(drawn, {{"left.csv", csv.out}}).plan();
  EXPECT_NEAR(at(plan, 10)[0], 6, 1e-9);  // the header says mm
}

TEST(Network, TheUnitOfTheTrackCountsForWhatIsDrawn) {
  const Plan plan = planned(with(mouth, "network = true", "network = true\nunit = \"cm\""));
  EXPECT_NEAR(at(plan, 10)[0], 60, 1e-9);
}

TEST(Network, TheHashCountsPlacesAndWhatIsDrawn) {
  const std::string hash = hash_in_words(parse_move(mouth, "move.toml"));
  for (const auto& [from, to] : {std::pair("network = true", "network = true\nplaces = [0, 1, 3]"),
                                 std::pair("at = 6", "at = 6.5"), std::pair("frame = 10", "frame = 11")}) {
    EXPECT_NE(hash_in_words(parse_move(with(mouth, from, to), "move.toml")), hash) << to;
  }
  EXPECT_EQ(hash_in_words(
                parse_move(with(mouth, "network = true", "network = true\nplaces = [0, 1, 2]"), "move.toml")),
            hash);
}

TEST(Network, TheJsonOfAPlanTellsPlacesAndCurves) {
  const TemporaryFile move("move.toml", mouth);
  const ProgramRun run = run_program({"plan", move.path().string(), "--json", "-"});
  ASSERT_EQ(run.status, 0) << run.err;
  const Json wanted = {{"places", {0, 1, 2}},
                       {"drawn", {{{"axis", "left"}, {"points", 3}}, {{"axis", "right"}, {"points", 3}}}}};
  EXPECT_EQ(Json::parse(run.out)["tracks"][0]["network"], wanted);
}

TEST(Network, AKeyBesideItsCurveIsToldWithFrameAxisAndDifference) {
  const std::string text = with(mouth, "{ at = [0, 0, 0], frame = 24 }",
                                "{ at = [@6.5, 0, -1], frame = 10 }, { at = [0, 0, 0], frame = 24 }");
  expect_refused([](const std::string& move,
                    const std::string& name) { Plan(parse_move(move, name), std::nullopt, {}); },
                 text,
                 {"frame 10: key 1 has axis \"left\" at 6.5", "its drawn curve is at 6, 0.5 away",
                  "leave the axis out of the key"});
}

TEST(Network, WhatIsNoNetworkIsRefusedAtItsPlace) {
  const std::string keys = "keys = [{ at = [0, 0, 0], frame = 0 }, { at = [0, 0, 0], frame = 24 }]";
  const std::vector<std::tuple<const char*, const char*, const char*>> fields = {
      {"timing = \"frames\"", "spline = \"smooth\"", "timing"},
      {"network = true", "network = false", "add network = true"},
      {"network = true", "network = true\nspline = \"tcb\"", "a network is \"smooth\""},
      {"network = true", "network = true\nkinetic = \"pace\"", "a network has \"curves\""},
      {"network = true", "network = true\novershoot = false", "overshoot is for other tracks"},
      {"network = true", "network = true\nclosed = true", "a network is open"},
      {"network = true", "network = true\nperiodic = true", "played once"},
      {"network = true", "network = true\nspace = \"hand\"", "a network has a row of them"},
      {"network = true", "network = true\ndistance = \"hand\"", "goes by the frames of its keys"},
      {"network = true", "network = true\nwrap = 360", "do not count round"},
      {"network = true", "network = true\noverlap = 2", "overlap"},
      {"network = true", "network = true\nround = 2", "round"},
      {"network = true", "network = true\nplaces = [0, 2, 1]", "places[2] is 1, behind 2"},
      {"network = true", "network = true\nplaces = [0, 1]", "has 2 numbers; write 3"},
      {"left = [", "lefd = [", "did you mean \"left\""},
      {"frame = 10, at = 6", "frame = 0, at = 6", "frame 0 comes behind frame 0"},
      {"[{ frame = 0, at = 0 }, { frame = 10, at = 6 }", "[{ frame = 10, at = 6 }", "begins on frame 10"},
      {"{ frame = 10, at = 6 }, { frame = 24, at = 0 }", "{ frame = 10, at = 6 }", "ends on frame 10"},
      {"frame = 10, at = 6", "frame = 10", "has no at"},
      {"frame = 10, at = 6", "frame = 10.5, at = 6", "whole number"},
      {"frame = 10, at = 6", "frame = 25, at = 6", "25"},
      {"frame = 10, at = 6", "frame = 10, at = \"6\"", "number"},
      {keys.c_str(), "keys = [{ at = [0, 0, 0], frame = 0 }]", "two or more"},
      {keys.c_str(), "keys = [{ at = [0, 0, 0] }, { at = [0, 0, 0], frame = 24 }]", "key 0 has no frame"},
      {keys.c_str(), "keys = [{ at = [0, 0, 0], frame = 1 }, { at = [0, 0, 0], frame = 24 }]",
       "the first key"},
      {keys.c_str(), "keys = [{ at = [0, 0, 0], frame = 0 }, { at = [0, 0, 0], frame = 23 }]",
       "the last key"},
      {keys.c_str(), "keys = [{ at = { right = 0 }, frame = 0 }, { at = [0, 0, 0], frame = 24 }]",
       "leaves out axis \"lip\""},
      {keys.c_str(), "keys = [{ at = [0, 0, 0], frame = 0, ease = true }, { at = [0, 0, 0], frame = 24 }]",
       "hold, ease or break"},
  };
  for (const auto& [from, to, words] : fields) {
    try {
      static_cast<void>(planned(with(mouth, from, to)));
      ADD_FAILURE() << "accepted: " << to;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(words)) << to;
      EXPECT_THAT(error.what(), HasSubstr("; ")) << to;
      EXPECT_THAT(error.what(), Not(HasSubstr("\n"))) << to;
      EXPECT_GT(error.place().line, 0U) << to;
    }
  }
}

TEST(Network, WithoutADrawnCurveATrackIsNone) {
  const std::size_t begin = mouth.find("drawn");
  const std::string without = mouth.substr(0, begin) + mouth.substr(mouth.find("keys"));
  EXPECT_THAT(MoveFolder(without, {}).refusal(), HasSubstr("drawn = { NAME_OF_AN_AXIS"));
  const std::string empty = mouth.substr(0, begin) + "drawn = {}\n" + mouth.substr(mouth.find("keys"));
  EXPECT_THAT(MoveFolder(empty, {}).refusal(), HasSubstr("drawn names no axis"));
}

TEST(Network, ABrokenFileIsToldWithItsLine) {
  const std::vector<std::pair<const char*, const char*>> files = {
      {"", "left.csv: error: the file is empty"},
      {"frame;left\n0;0\n", "left.csv:1: error: the first row names no column \"frame\""},
      {"frame,lip\n0,0\n", "left.csv:1: error: the first row names no column \"left\""},
      {"frame,left (parsec)\n0,0\n", "left.csv:1: error: the first row names no column \"left\""},
      {"frame,left\n0,0\n10,6,5\n24,0\n", "left.csv:3: error: the row has 3 fields"},
      {"frame,left\n0,0\n10,six\n24,0\n", "left.csv:3: error: \"left\" is \"six\""},
      {"frame,left\n0,0\n10,nan\n24,0\n", "left.csv:3: error: \"left\" is \"nan\""},
      {"frame,left\n0,0\n10,1e300\n24,0\n", "left.csv:3: error: \"left\" is \"1e300\""},
      {"frame,left\n0,0\n10.5,6\n24,0\n", "left.csv:3: error: frame 10.5 is none of the move"},
      {"frame,left\n0,0\n25,6\n24,0\n", "left.csv:3: error: frame 25 is none of the move"},
      {"frame,left\n0,0\n10,6\n10,7\n24,0\n", "left.csv:4: error: frame 10 comes behind frame 10"},
      {"frame,left\n1,0\n24,0\n", "left.csv:2: error: the curve begins on frame 1"},
      {"frame,left\n0,0\n10,6\n", "left.csv:3: error: the curve ends on frame 10"},
      {"frame,left\n0,\n", "left.csv:2: error: the curve has no point"},
      {"frame,left\n", "left.csv:1: error: the curve has no point"},
      {"frame,left\n0,\"0\n", "left.csv:2: error: a quote is not closed"},
      {"frame,left\n0,\"0\"1\n", "left.csv:2: error: text stands behind a closing quote"},
  };
  for (const auto& [csv, words] : files) EXPECT_THAT(refusal_of_csv(csv), HasSubstr(words)) << csv;
  EXPECT_THAT(MoveFolder(from_file, {}).refusal(), HasSubstr("left.csv: error: there is no such file"));
  EXPECT_THAT(MoveFolder(with(from_file, "left.csv", "/etc/passwd"), {}).refusal(),
              HasSubstr("drawn.left is \"/etc/passwd\"; put the file beside that of the move"));
}

TEST(Network, ACurveInAUnitOfAnotherKindIsRefusedAtItsLine) {
  const MoveFolder folder(with(from_file, "network = true", "network = true\nunit = \"mm\""),
                          {{"left.csv", "frame,left (deg)\n0,0\n24,0\n"}});
  EXPECT_THAT(folder.refusal(), HasSubstr("left.csv:2: error: axis \"left\" is given in deg"));
}

TEST(Network, TooManyPiecesAreRefused) {
  std::string text = with(with(mouth, "frames = 24\n", "frames = 60000\n"), "{ at = [0, 0, 0], frame = 24 }",
                          "{ at = [0, 0, 0], frame = 60000 }");
  // Each curve has points of its own, and each pair of equal ones rests.
  text = text.substr(0, text.find("drawn"));
  const auto curve = [](int begin) {
    std::string list = "[{ frame = 0, at = 0 }";
    for (int i = 0; i < 9'998; ++i)
      list += fmt::format(", {{ frame = {}, at = {} }}", begin + 6 * i, i / 2 % 2);
    return list + ", { frame = 60000, at = 0 }]";
  };
  text += fmt::format("drawn = {{ left = {}, right = {} }}\n", curve(1), curve(3)) +
          "keys = [{ at = [0, 0, 0], frame = 0 }, { at = [0, 0, 0], frame = 60000 }]\n";
  EXPECT_THAT(MoveFolder(text, {}).refusal(), HasSubstr("pieces, and 40000 are allowed; draw fewer points"));
}

TEST(Network, OtherFramesAreNotTriedBecauseItsCurvesAreDrawnOnThese) {
  const std::string slow =
      rig_text({{.name = "left", .max_velocity = 5}, {.name = "lip"}, {.name = "right"}});
  const ProgramRun run = run_on(slow, "check", mouth);
  EXPECT_EQ(run.status, 3) << run.err;
  EXPECT_THAT(run.out, HasSubstr("the curves of a network are drawn on the frames of the move"));
  const std::string low = rig_text({{.name = "left", .max = 5}, {.name = "lip"}, {.name = "right"}});
  EXPECT_THAT(run_on(low, "check", with(mouth, "at = 6", "at = 4.9")).err,
              HasSubstr("; move its keys and the drawn curves inward by"));
  const TemporaryFolder folder;
  const std::string out = (folder.path() / "fitted.toml").string();
  EXPECT_EQ(run_on(slow, "check", mouth, {"--fit", out, "--fewest"}).status, 3);
  EXPECT_EQ(run_on(rig, "check", mouth, {"--fit", out, "--fewest"}).status, 0);
  EXPECT_EQ(file_contents(out), mouth);
}

TEST(Network, AnEditorShowsItAndLeavesItsKeysAlone) {
  const TemporaryFile move("move.toml", mouth);
  EditSession session(system_files(), move.path().string(), std::nullopt, "id");
  const Json track = Json::parse(session.open().json)["tracks"][0];
  EXPECT_EQ(track["live"], false);
  EXPECT_FALSE(track["path"].is_null());
  EXPECT_THAT(track["fixed_keys"].get<std::string>(), HasSubstr("network"));
  EditedMove edited = edits_of(parse_move(mouth, "move.toml"));
  edited.fps = "25";
  EXPECT_EQ(with_edits(mouth, "move.toml", edited), with(mouth, "fps = 24", "fps = 25"));
  edited.tracks[0].keys[1].at[1] = 3;
  EXPECT_THROW(static_cast<void>(with_edits(mouth, "move.toml", edited)), InputError);
}

}  // namespace network_test
}  // namespace inbetween
