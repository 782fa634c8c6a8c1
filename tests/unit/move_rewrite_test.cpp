// What an editor changes is written into the file of a move; comments, order and everything else stay.
#include "host_tools/move_model/move_rewrite.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <stdexcept>
#include <string>

#include "host_tools/move_model/move_file.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "tests/support/places.hpp"
#include "tests/support/run_program.hpp"

namespace inbetween {
namespace move_rewrite_test {

using testing::HasSubstr;

const std::string text = R"(# A comment above.
name = "slide"   # its name
fps = 24
frames = 96
[[track]]
axes = ["x", "y"]
# where it goes
keys = [ # all of them
  # the first
  { at = [0.0, 0] },
  { frame = 30, at = [40, 30.5] }, # met on a frame
  { at = [80, 20], ease = true }, # slow

  { at = [120, 50] } # the end
] # behind
speed = [0, 0, 10, 3, 10, 0, 0]  # drawn
)";

/// The move of a text as an editor gets it.
EditedMove unchanged(const std::string& of) {
  return edits_of(parse_move(of, "m.toml"));
}

std::string replaced(std::string in, const std::string& what, const std::string& by) {
  const std::size_t at = in.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return in.replace(at, what.size(), by);
}

TEST(MoveRewrite, WithoutAChangeEveryByteStays) {
  EXPECT_EQ(with_edits(text, "m.toml", unchanged(text)), text);
  for (const char* example :
       {"reveal", "nod", "turntable", "slide_and_pan", "track_and_focus", "blink", "jaw"}) {
    const std::string of = file_contents(in_checkout(fmt::format("examples/{}.toml", example)));
    EXPECT_EQ(with_edits(of, "m.toml", unchanged(of)), of) << example;
  }
}

TEST(MoveRewrite, ANumberIsWrittenWhereItStood) {
  EditedMove edited = unchanged(text);
  edited.tracks[0].keys[0].at = {5, 0};
  edited.tracks[0].keys[1].at = {40, 31.25};
  edited.frames = 120;
  edited.fps = "24000/1001";
  EXPECT_EQ(with_edits(text, "m.toml", edited),
            replaced(replaced(replaced(replaced(text, "[0.0, 0]", "[5.0, 0]"), "30.5", "31.25"),
                              "frames = 96", "frames = 120"),
                     "fps = 24", "fps = \"24000/1001\""));
}

TEST(MoveRewrite, FieldsComeAndGo) {
  EditedMove edited = unchanged(text);
  std::vector<EditedKey>& keys = edited.tracks[0].keys;
  keys[1].frame.reset();
  keys[2].ease = false;
  keys[3].hold = 5;
  EXPECT_EQ(with_edits(text, "m.toml", edited),
            replaced(replaced(replaced(text, "{ frame = 30, at", "{ at"), ", ease = true", ""), "[120, 50] }",
                     "[120, 50], hold = 5 }"));
}

TEST(MoveRewrite, AKeyTakesItsCommentAlong) {
  EditedMove edited = unchanged(text);
  std::vector<EditedKey>& keys = edited.tracks[0].keys;
  std::swap(keys[1], keys[2]);
  const std::string result = with_edits(text, "m.toml", edited);
  EXPECT_THAT(result, HasSubstr("  { at = [80, 20], ease = true }, # slow\n"
                                "  { frame = 30, at = [40, 30.5] }, # met on a frame\n"));
}

TEST(MoveRewrite, KeysComeAndGo) {
  EditedMove edited = unchanged(text);
  std::vector<EditedKey>& keys = edited.tracks[0].keys;
  keys.erase(keys.begin() + 1);
  keys.insert(keys.begin() + 1, EditedKey{.at = {20, 10}, .frame = 12});
  keys.push_back({.at = {130, 60.5}});
  EXPECT_EQ(
      with_edits(text, "m.toml", edited),
      replaced(replaced(text, "  { frame = 30, at = [40, 30.5] }, # met on a frame\n",
                        "  { at = [20, 10], frame = 12 },\n"),
               "{ at = [120, 50] } # the end\n", "{ at = [120, 50] }, # the end\n  { at = [130, 60.5] }\n"));
}

TEST(MoveRewrite, AListOnOneLineStaysOnOneLine) {
  const std::string line =
      replaced(text, text.substr(text.find("keys"), text.find("speed") - text.find("keys")),
               "keys = [{ at = [0, 0] }, { at = [1, 1] }]\n");
  EditedMove edited = unchanged(line);
  edited.tracks[0].keys.insert(edited.tracks[0].keys.begin() + 1, EditedKey{.at = {0.5, 0.5}});
  EXPECT_THAT(with_edits(line, "m.toml", edited),
              HasSubstr("keys = [{ at = [0, 0] }, { at = [0.5, 0.5] }, { at = [1, 1] }]\n"));
  edited = unchanged(line);
  std::swap(edited.tracks[0].keys[0], edited.tracks[0].keys[1]);
  EXPECT_THAT(with_edits(line, "m.toml", edited), HasSubstr("keys = [{ at = [1, 1] }, { at = [0, 0] }]\n"));
  edited = unchanged(line);
  edited.tracks[0].keys.erase(edited.tracks[0].keys.begin());
  EXPECT_THAT(with_edits(line, "m.toml", edited), HasSubstr("{ at = [1, 1] }]\n"));
}

TEST(MoveRewrite, AnAxisThatAKeyLeavesOutStaysWhereItWas) {
  const std::string of = replaced(text, "{ at = [80, 20], ease = true }", "{ at = { y = 20 }, ease = true }");
  EditedMove edited = unchanged(of);
  edited.tracks[0].keys[1].at[0] = 41;  // the key behind it has had its x from there
  EXPECT_THAT(with_edits(of, "m.toml", edited), HasSubstr("{ at = [40, 20], ease = true }"));
  edited.tracks[0].keys[2].at[0] = 41;
  const MoveFile read = parse_move(with_edits(of, "m.toml", edited), "m.toml");
  EXPECT_EQ(read.tracks[0].keys[2].at, (std::vector<double>{41, 20}));
}

TEST(MoveRewrite, CurveSplineAndClosedAreWritten) {
  EditedMove edited = unchanged(text);
  edited.tracks[0].speed = {0, 0, 10, 2.5, 10, 0, 0};
  edited.tracks[0].spline = Spline::tcb;
  edited.tracks[0].closed = true;
  edited.tracks[0].keys[2].tension = 0.5;
  EXPECT_EQ(
      with_edits(text, "m.toml", edited),
      replaced(replaced(replaced(text, "[\"x\", \"y\"]", "[\"x\", \"y\"]\nspline = \"tcb\"\nclosed = true"),
                        "ease = true }", "ease = true, tension = 0.5 }"),
               "10, 3, 10", "10, 2.5, 10"));
}

TEST(MoveRewrite, TheCornerOfAKeyIsWrittenWithIt) {
  const std::string of = replaced(
      replaced(text, "axes = [\"x\", \"y\"]", "axes = [\"x\", \"y\"]\nspline = \"linear\"\nround = 2.5"),
      "{ at = [120, 50] }", "{ at = [120, 50], round = 4 }");
  EXPECT_EQ(with_edits(of, "m.toml", unchanged(of)), of);
  EditedMove edited = unchanged(of);
  edited.tracks[0].keys[2].round = 7.5;
  edited.tracks[0].keys[3].round.reset();
  EXPECT_EQ(with_edits(of, "m.toml", edited),
            replaced(replaced(of, ", round = 4 }", " }"), "ease = true }", "ease = true, round = 7.5 }"));
}

const std::string row = R"(name = "fin"
fps = 24
frames = 48
[[track]]
network = true
timing = "frames"
axes = ["a", "b", "c"]
drawn = { a = [{ frame = 0, at = 0 }, { frame = 48, at = 0 }] }  # by hand
keys = [{ at = [0, 0, 0], frame = 0 }, { at = [0, 0, 0], frame = 48 }]
)";

TEST(MoveRewrite, ADrawnCurveOfANetworkIsReplacedAndANewOneComesBehind) {
  EditedMove edited = unchanged(row);
  edited.tracks[0].drawn = {{.axis = 0, .frames = {0, 12, 48}, .at = {0, 2.5, 0}}};
  const std::string once = with_edits(row, "m.toml", edited);
  EXPECT_EQ(once,
            replaced(row, "{ frame = 48, at = 0 }]", "{ frame = 12, at = 2.5 }, { frame = 48, at = 0 }]"));
  edited = unchanged(once);
  edited.tracks[0].drawn = {{.axis = 2, .frames = {0, 24, 48}, .at = {0, -1, 0}}};
  EXPECT_EQ(
      with_edits(once, "m.toml", edited),
      replaced(
          once, "}] }  # by hand",
          "}], c = [{ frame = 0, at = 0 }, { frame = 24, at = -1 }, { frame = 48, at = 0 }] }  # by hand"));
}

TEST(MoveRewrite, ACurveOfNoNetworkOrOfNoAxisIsRefused) {
  EditedMove edited = unchanged(text);
  edited.tracks[0].drawn = {{.axis = 0, .frames = {0, 96}, .at = {0, 0}}};
  EXPECT_THROW(with_edits(text, "m.toml", edited), std::invalid_argument);
  edited = unchanged(row);
  edited.tracks[0].drawn = {{.axis = 3, .frames = {0, 48}, .at = {0, 0}}};
  EXPECT_THROW(with_edits(row, "m.toml", edited), std::invalid_argument);
  edited.tracks[0].drawn = {{.axis = 0, .frames = {0, 40}, .at = {0, 0}}};  // not to the end
  EXPECT_THROW(with_edits(row, "m.toml", edited), InputError);
}

TEST(MoveRewrite, WhatIsNotOfThisMoveIsRefused) {
  EditedMove edited = unchanged(text);
  edited.tracks[0].keys[0].from = 9;
  EXPECT_THROW(with_edits(text, "m.toml", edited), std::invalid_argument);
  edited = unchanged(text);
  edited.tracks[0].keys[1].from = 0;  // twice
  EXPECT_THROW(with_edits(text, "m.toml", edited), std::invalid_argument);
  edited = unchanged(text);
  edited.tracks[0].keys[0].at.push_back(1);
  EXPECT_THROW(with_edits(text, "m.toml", edited), std::invalid_argument);
  edited = unchanged(text);
  edited.tracks.clear();
  EXPECT_THROW(with_edits(text, "m.toml", edited), std::invalid_argument);
  edited = unchanged(text);
  edited.frames = 0;
  EXPECT_THROW(with_edits(text, "m.toml", edited), InputError);
}

TEST(MoveRewrite, KeysWithUnitsAndInSectionsStayAsTheyAre) {
  const std::string units = replaced(text, "axes = [\"x\", \"y\"]", "axes = [\"x\", \"y\"]\nunit = \"mm\"");
  EXPECT_THAT(why_keys_are_fixed(units, "m.toml", 0).value_or(""), HasSubstr("units"));
  EXPECT_EQ(with_edits(units, "m.toml", unchanged(units)), units);
  EditedMove edited = unchanged(units);
  edited.tracks[0].keys[0].at[0] = 1;
  EXPECT_THROW(with_edits(units, "m.toml", edited), InputError);
  const std::string sections =
      replaced(text, text.substr(text.find("keys"), text.find("speed") - text.find("keys")), "") +
      "[[track.keys]]\nat = [0, 0]\n[[track.keys]]\nat = [1, 2]\n";
  EXPECT_THAT(why_keys_are_fixed(sections, "m.toml", 0).value_or(""), HasSubstr("sections"));
  edited = unchanged(sections);
  edited.tracks[0].speed = {0, 0, 4, 0, 0};
  EXPECT_THAT(with_edits(sections, "m.toml", edited), HasSubstr("speed = [0, 0, 4, 0, 0"));
}

}  // namespace move_rewrite_test
}  // namespace inbetween
