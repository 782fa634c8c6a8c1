// Keys stored where a rig stands: what becomes of the file, and of one that somebody else changes.
#include "host_tools/move_model/taught_move.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "host_tools/text/diagnostics.hpp"
#include "host_tools/text/file_layer.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"
#include "tests/support/terminal_screen.hpp"

namespace inbetween {
namespace taught_move_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

AxisText stepper(const std::string& name, const std::string& unit, double min, double max,
                 const std::string& lines) {
  return axis_text(name, unit, {min, max}, {}, "reference = \"operator\"\nunpowered = \"holds\"",
                   R"(type = "step-dir", chip = "gpio", )" + lines);
}
std::string slider() {
  std::vector<AxisText> axes{stepper("track", "mm", 0, 500, "step = 17, dir = 27, steps_per_unit = 40"),
                             stepper("pan", "deg", -90, 90, "step = 19, dir = 26, steps_per_unit = 50"),
                             stepper("focus", "unit", 0, 1, "step = 20, dir = 21, steps_per_unit = 1000")};
  axes[2].max_velocity = axes[2].max_acceleration = 1;
  return rig_text(axes, {.name = "slider", .rate_hz = 250});
}
constexpr std::size_t track = 0, pan = 1, focus = 2;

// The axes of the track in another order than those of the rig.
const std::string move_text = R"(# Past the flower.
name = "reveal"
fps = 24
frames = 96
[[track]]
axes = ["pan", "track"]
keys = [
  { at = [-20.0, 40.0] },  # the door
  { at = [0, 200], frame = 40 },
  # the end
  { at = [20, 400] },
]
speed = [0, 0, 10, 0, 0]  # drawn
)";

std::string replaced(std::string in, const std::string& what, const std::string& by) {
  const std::size_t at = in.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return in.replace(at, what.size(), by);
}

struct Lesson {
  TemporaryFolder folder;
  RigFile rig = parse_rig(slider(), "rig.toml");
  std::string path = folder.path() / "move.toml";

  explicit Lesson(const std::string& text = move_text) {
    if (!text.empty()) write(text);
  }
  void write(const std::string& text) const { std::ofstream(path) << text; }
  [[nodiscard]] std::string text() const { return file_contents(path); }
  [[nodiscard]] TaughtMove begin() const { return {system_files(), path, rig, {track, pan}}; }
};

const StandingAxes standing{123.4500000001, -5.0, 0.5};

TEST(TaughtMove, AKeyIsAppendedInTheOrderOfTheTrackAndEverythingElseStays) {
  const Lesson lesson;
  TaughtMove move = lesson.begin();
  move.append(track, standing);
  EXPECT_EQ(lesson.text(), replaced(move_text, "  { at = [20, 400] },\n",
                                    "  { at = [20, 400] },\n  { at = [-5, 123.45] },\n"));
  EXPECT_EQ(move.words(), "appended key 3: pan -5, track 123.45");
  EXPECT_EQ(move.stored(), 1U);
}

TEST(TaughtMove, AKeyIsInsertedBeforeTheChosenOneAndTheNextBehindIt) {
  const Lesson lesson;
  TaughtMove move = lesson.begin();
  move.choose(track, 1);
  move.insert(pan, standing);
  move.insert(pan, {130.0, -4.0, std::nullopt});
  EXPECT_EQ(lesson.text(), replaced(move_text, "  { at = [0, 200], frame = 40 },\n",
                                    "  { at = [-5, 123.45] },\n  { at = [-4, 130] },\n"
                                    "  { at = [0, 200], frame = 40 },\n"));
  EXPECT_THAT(
      move.shown(track, 3),
      ElementsAre(lesson.path + ": key 3 of 0 to 4", "inserted key 2: pan -4, track 130",
                  "  2   pan -4, track 130", "> 3   pan 0, track 200, frame 40", "  4   pan 20, track 400"));
}

TEST(TaughtMove, AKeyThatIsReplacedKeepsItsCommentAndItsFrame) {
  const Lesson lesson;
  TaughtMove move = lesson.begin();
  move.replace(track, standing);
  move.choose(track, 1);
  move.replace(track, {130.0, -4.0, std::nullopt});
  EXPECT_EQ(lesson.text(),
            replaced(replaced(move_text, "[-20.0, 40.0] },  # the door", "[-5.0, 123.45] },  # the door"),
                     "[0, 200], frame = 40", "[-4, 130], frame = 40"));
}

TEST(TaughtMove, AWriteOfSomebodyElseInTheMomentOfStoringStaysAndIsReadAgain) {
  const Lesson lesson;
  FileLayer files = system_files();
  const std::string outside = "# theirs\n" + move_text;
  bool has_come = false;
  files.swap = [&, swap = files.swap](const std::string& one, const std::string& other) {
    if (!std::exchange(has_come, true)) lesson.write(outside);
    return swap(one, other);
  };
  TaughtMove move(files, lesson.path, lesson.rig, {track, pan});
  move.append(track, standing);
  EXPECT_THAT(move.words(), HasSubstr("was changed by somebody else and is read again"));
  EXPECT_EQ(lesson.text(), outside);
  move.append(track, standing);
  EXPECT_THAT(lesson.text(), HasSubstr("# theirs"));
  EXPECT_THAT(lesson.text(), HasSubstr("{ at = [-5, 123.45] }"));
}

// Case 31: two keys a hair apart asked for 19 535 frames.
TEST(TaughtMove, APlaceThatIsThereAlreadyIsAskedForBeforeItIsStored) {
  const Lesson lesson;
  TaughtMove move = lesson.begin();
  const StandingAxes beside{400.4, 20.0, std::nullopt};
  move.append(track, beside);
  EXPECT_EQ(lesson.text(), move_text) << "nothing is stored";
  EXPECT_EQ(move.words(), "key 2 is here already (track 0.4 mm away): Enter again stores it all the same");
  move.append(track, beside);
  EXPECT_THAT(lesson.text(), HasSubstr("  { at = [20, 400] },\n  { at = [20, 400.4] },\n"))
      << "asked and answered";
  move.append(track, beside);
  EXPECT_EQ(move.words(), "key 3 is here already (the same place): Enter again stores it all the same");
  move.choose(track, -1);
  move.append(track, beside);
  EXPECT_THAT(move.words(), HasSubstr("Enter again")) << "another step was in between";
  EXPECT_EQ(move.stored(), 1U);
  move.append(track, {401.0, 20.0, std::nullopt});
  EXPECT_EQ(move.words(), "appended key 4: pan 20, track 401") << "further than a thousandth of its range";
}

TEST(TaughtMove, AKeyMayComeBackToAPlaceThatIsNotItsNeighbours) {
  const Lesson lesson;
  TaughtMove move = lesson.begin();
  move.append(track, {200.0, 0.0, std::nullopt});
  EXPECT_EQ(move.stored(), 1U) << "where key 1 is";
  move.choose(track, -1);
  move.replace(track, {200.0, 0.0, std::nullopt});
  EXPECT_THAT(move.words(), HasSubstr("key 1 is here already (the same place): t again"));
  move.replace(track, {200.0, 0.0, std::nullopt});
  EXPECT_EQ(move.stored(), 2U);
}

TEST(TaughtMove, StoredKeysAreTakenBackOneAfterTheOther) {
  const Lesson lesson;
  TaughtMove move = lesson.begin();
  move.append(track, standing);
  const std::string one = lesson.text();
  move.replace(track, {1.0, 1.0, 0.0});
  move.undo();
  EXPECT_EQ(lesson.text(), one);
  move.undo();
  EXPECT_EQ(lesson.text(), move_text);
  EXPECT_EQ(move.stored(), 0U);
  move.undo();
  EXPECT_EQ(move.words(), "there is no key to take back");
}

TEST(TaughtMove, AFileThatSomebodyElseChangedIsNeverOverwritten) {
  const Lesson lesson;
  TaughtMove move = lesson.begin();
  move.append(track, standing);
  const std::string theirs = replaced(move_text, "frames = 96", "frames = 120");
  for (const auto& step :
       {+[](TaughtMove& one) { one.append(track, standing); }, +[](TaughtMove& one) { one.undo(); }}) {
    lesson.write(lesson.text() + "# more\n");
    const std::string before = lesson.text();
    step(move);
    EXPECT_EQ(lesson.text(), before);
    EXPECT_THAT(move.words(), HasSubstr("was changed by somebody else and is read again: press again"));
  }
  lesson.write(theirs);
  move.append(track, standing);
  move.append(track, standing);
  EXPECT_THAT(lesson.text(), HasSubstr("frames = 120"));
  EXPECT_THAT(lesson.text(), HasSubstr("[-5, 123.45]"));
  lesson.write("half a mo");
  move.append(track, standing);
  EXPECT_EQ(lesson.text(), "half a mo");
  EXPECT_THAT(move.words(), HasSubstr("move.toml:1:"));
}

TEST(TaughtMove, TheFirstKeyMakesAMoveThatStandsStillAndTheSecondOneThatGoes) {
  const Lesson lesson("");
  TaughtMove move = lesson.begin();
  EXPECT_THAT(move.shown(track, 5), ElementsAre(lesson.path + " is not there yet", ""));
  move.replace(track, standing);
  EXPECT_THAT(move.words(), HasSubstr("is made, with key 0"));
  MoveFile made = parse_move(lesson.text(), "move.toml");
  EXPECT_EQ(made.name, "move");
  EXPECT_THAT(made.tracks[0].axes, ElementsAre("track", "pan"));
  EXPECT_THAT(made.tracks[0].keys[0].at, ElementsAre(123.45, -5));
  EXPECT_EQ(run_program({"plan", lesson.path}).status, 0);
  move.append(track, {200.0, 10.0, std::nullopt});
  made = parse_move(lesson.text(), "move.toml");
  ASSERT_EQ(made.tracks[0].keys.size(), 2U);
  EXPECT_THAT(made.tracks[0].keys[1].at, ElementsAre(200, 10));
  EXPECT_EQ(run_program({"plan", lesson.path}).status, 0);
  move.undo();
  move.undo();
  EXPECT_THAT(move.words(), HasSubstr("key 0 made"));
  EXPECT_EQ(parse_move(lesson.text(), "move.toml").tracks[0].keys.size(), 1U);
}

TEST(TaughtMove, UnitsOfTheTrackAreTheOnesThatAreWritten) {
  const Lesson lesson(replaced(move_text, "axes = [\"pan\", \"track\"]\n",
                               "axes = [\"pan\", \"track\"]\nunit = { track = \"cm\" }\n"));
  TaughtMove move = lesson.begin();
  move.append(track, standing);
  EXPECT_THAT(lesson.text(), HasSubstr("{ at = [-5, 12.345] },")) << move.words();
}

TEST(TaughtMove, AKeyNeverHasMoreDecimalsThanTheDriveAndIsInsideTheLimits) {
  Lesson lesson;
  lesson.rig.axes[track].max = 400.0 / 3;  // no decimal number
  TaughtMove move = lesson.begin();
  move.append(track, {400.0 / 3 + 0.01, 1e-13, std::nullopt});
  const MoveFile taught = parse_move(lesson.text(), "move.toml");
  EXPECT_THAT(taught.tracks[0].keys[3].at, ElementsAre(0, 400.0 / 3));
  move.append(track, {140.0, 0.0, std::nullopt});
  EXPECT_THAT(move.words(), HasSubstr("axis \"track\" stands at 140, outside 0..133.3333"));
}

TEST(TaughtMove, WhatCannotBeTaughtIsSaidInALineAndNothingIsWritten) {
  const std::string by_frames =
      replaced(replaced(replaced(move_text, "speed = [0, 0, 10, 0, 0]  # drawn", "timing = \"frames\""),
                        "40.0] }", "40.0], frame = 0 }"),
               "400] }", "400], frame = 96 }");
  const std::string round = replaced(move_text, "keys = [", "wrap = { pan = 360 }\nkeys = [");
  const std::string own = replaced(move_text, "[20, 400]", "[20, 400], unit = { track = \"mm\" }");
  const std::string space = R"(name = "m"
fps = 24
frames = 96
[[track]]
axes = ["pan", "track"]
space = "camera"
keys = [{ at = [0, 0, 0] }, { at = [1, 0, 0] }]
speed = [0, 0, 10, 0, 0]
)";
  for (const auto& [text, axis, where, why] :
       {std::tuple(move_text, focus, standing, "has no track of axis \"focus\": choose another axis"),
        {move_text, track, StandingAxes{std::nullopt, 1.0, 1.0},
         "axis \"track\" does not know where it is: home it, or goto --set-zero"},
        {by_frames, track, standing, "a new one would need one: add it in the file"},
        {round, track, standing, "an axis counts round (wrap)"},
        {own, track, standing, "the keys have units of their own"},
        {space, track, standing, "are places in the world"}}) {
    const Lesson lesson(text);
    TaughtMove move = lesson.begin();
    move.append(axis, where);
    EXPECT_THAT(move.words(), HasSubstr(why));
    EXPECT_THAT(move.words(), Not(HasSubstr("\n")));
    EXPECT_EQ(lesson.text(), text);
  }
  const Lesson lesson(by_frames);
  TaughtMove move = lesson.begin();
  move.replace(track, standing);
  EXPECT_THAT(lesson.text(), HasSubstr("[-5.0, 123.45], frame = 0")) << "a key that has its frame";
}

TEST(TaughtMove, AFullDiskLeavesTheFileAsItWas) {
  const Lesson lesson;
  FileLayer files = system_files();
  files.write = [](int, std::string_view, std::size_t&) { return ENOSPC; };
  TaughtMove move(files, lesson.path, lesson.rig, {track});
  move.append(track, standing);
  EXPECT_EQ(lesson.text(), move_text);
  EXPECT_THAT(move.words(), HasSubstr("could not be written completely: No space left on device"));
  EXPECT_EQ(move.stored(), 0U);
}

TEST(TaughtMove, ASymbolicLinkStaysOne) {
  const Lesson lesson;
  const std::filesystem::path link = lesson.folder.path() / "link.toml";
  std::filesystem::create_symlink("move.toml", link);
  TaughtMove move(system_files(), link, lesson.rig, {track});
  move.append(track, standing);
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_THAT(lesson.text(), HasSubstr("123.45"));
}

TEST(TaughtMove, AnAxisThatTheRigDoesNotHaveIsRefusedAtItsPlace) {
  const Lesson lesson(replaced(move_text, "\"track\"]", "\"lift\"]"));
  try {
    static_cast<void>(lesson.begin());
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("move.toml:6:16: error: the rig \"slider\" has no axis \"lift\""));
  }
}

// A whole lesson at the program: what the screen tells, what is in the file, what check says.
TEST(Teach, AMoveIsMadeKeyByKeyOnTheScreenAndCheckTakesIt) {
  const Lesson lesson("");
  const std::string rig = lesson.folder.path() / "rig.toml";
  std::ofstream(rig) << slider();
  TerminalScreen screen({"jog", "track", "--rig", rig, "--sim", "--from", "track=100", "--teach", lesson.path,
                         "--axes", "track,pan"},
                        120);
  EXPECT_THAT(screen.wait_for("track 100.000 mm"), HasSubstr("move.toml is not there yet"));
  screen.press("Enter");
  screen.wait_for("is made, with key 0");
  screen.press("5");
  screen.press("Right");
  screen.wait_for("track 105.000 mm in 0..500  reach 50  step 5: 5\n");
  screen.press("Enter");
  EXPECT_THAT(screen.wait_for("appended key 1: track 105, pan 0"), HasSubstr("> 1   track 105, pan 0"));
  screen.press("p");
  screen.wait_for("> 0   track 100, pan 0");
  screen.press("t");
  screen.wait_for("key 1 is here already (the same place): t again stores it all the same");
  screen.press("t");
  screen.wait_for("replaced key 0: track 105, pan 0");
  screen.press("u");
  screen.wait_for("the last key is taken back");
  screen.press("Left");
  screen.wait_for("track 100.000 mm in 0..500  reach 50  step 5: 5\n");
  screen.press("Down");
  screen.wait_for("pan 0.000 deg");
  screen.press("Right");
  screen.wait_for("pan 1.000 deg in -90..90  reach 18  step 5: 1\n");
  screen.press("n");
  screen.wait_for("> 1   track 105, pan 0");
  screen.press("i");
  screen.wait_for("inserted key 1: track 100, pan 1");
  screen.press("q");
  EXPECT_EQ(screen.wait_for_exit(), 0);
  EXPECT_THAT(screen.shown(), HasSubstr("move.toml: 3 keys stored"));
  const MoveFile taught = parse_move(lesson.text(), "move.toml");
  ASSERT_EQ(taught.tracks[0].keys.size(), 3U);
  EXPECT_THAT(taught.tracks[0].keys[0].at, ElementsAre(100, 0));
  EXPECT_THAT(taught.tracks[0].keys[1].at, ElementsAre(100, 1));
  EXPECT_THAT(taught.tracks[0].keys[2].at, ElementsAre(105, 0));
  EXPECT_EQ(run_program({"check", lesson.path, "--rig", rig}).status, 0);
}

TEST(Teach, WithoutAMoveItsKeysAreKeysLikeOthersAndAxesAreRefused) {
  EXPECT_EQ(run_program({"jog", "track", "--rig", "rig.toml", "--axes", "track"}).status, 2);
}

}  // namespace taught_move_test
}  // namespace inbetween
