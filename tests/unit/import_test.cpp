// A motion of another program on the axes of a rig: what is asked, what its move plays, what an export has.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <string>
#include <vector>

#include "host_tools/cli/asked_answers.hpp"
#include "host_tools/exchange/exchange_format.hpp"
#include "host_tools/exchange/export_choices.hpp"
#include "host_tools/exchange/import_answers.hpp"
#include "host_tools/exchange/raw_move.hpp"
#include "host_tools/exchange/rows_move.hpp"
#include "host_tools/exchange/table_csv.hpp"
#include "host_tools/exchange/wrong_rows.hpp"
#include "tests/support/rig_text.hpp"

namespace inbetween {
namespace import_test {

using testing::AllOf;
using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

/// Two axes: `track` in mm, `pan` in degrees.
RigFile camera_rig() {
  return parse_rig(rig_text({axis_text("track", "mm", {-1000, 1000}), axis_text("pan", "deg", {-90, 90})}),
                   "rig.toml");
}

std::string refusal(const std::function<void()>& act) {
  try {
    act();
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

std::vector<std::string> options_of(const std::vector<OpenQuestion>& questions) {
  std::vector<std::string> options;
  for (const OpenQuestion& question : questions) options.push_back(question.option);
  return options;
}

const char* const bare = "0 0\n10 45\n20 90\n";

ImportSaid all_of_bare(ShutterPhase phase = ShutterPhase::frame_boundary) {
  return {.fps = FrameRate{24, 1},
          .axes = {*axis_word_of("1=track"), *axis_word_of("2=-pan")},
          .units = {*unit_word_of("cm"), *unit_word_of("deg")},
          .phase = phase};
}

TEST(Import, WordsOfAnOptionAreTakenOrRefused) {
  EXPECT_EQ(frame_rate_of_word("24000/1001"), (FrameRate{24000, 1001}));
  for (const char* const none : {"23.976", "0", "24/0", "-24", "2000", "24/", "24 fps", ""})
    EXPECT_FALSE(frame_rate_of_word(none)) << none;
  EXPECT_EQ(axis_word_of("a=b=pan")->column, "a=b");
  EXPECT_TRUE(axis_word_of("tz=-dolly")->is_reversed);
  EXPECT_TRUE(axis_word_of("tz=-")->is_left_out);
  EXPECT_EQ(axis_word_of("pan")->axis, "pan");
  for (const char* const none : {"", "=pan", "tz="}) EXPECT_FALSE(axis_word_of(none)) << none;
  EXPECT_EQ(unit_word_of("rig")->unit, MoveUnit::of_rig);
  EXPECT_EQ(*unit_word_of("tz=cm")->column, "tz");
  EXPECT_FALSE(unit_word_of("parsec"));
  EXPECT_EQ(count_word_of("Pan=1500,-0.1deg")->count, -0.1);
  for (const char* const none : {"Pan=1500", "Pan=1500,0deg", "Pan=1500,1", "1500,1deg", "Pan=nan,1deg"})
    EXPECT_FALSE(count_word_of(none)) << none;
}

TEST(Import, EveryOpenQuestionHasTheOptionThatAnswersIt) {
  const BakedTable table = read_raw_move(bare, "a.txt");
  EXPECT_THAT(options_of(open_questions(table, camera_rig(), {})),
              ElementsAre("--fps RATE", R"(--axis "column 1=AXIS")", R"(--axis "column 2=AXIS")",
                          "--phase centre or --phase boundary"));
  ImportSaid said;
  said.axes = {*axis_word_of("1=track"), *axis_word_of("2=pan")};
  said.units = {*unit_word_of("deg")};
  EXPECT_THAT(options_of(open_questions(table, camera_rig(), said)),
              ElementsAre("--fps RATE", R"(--unit "column 1=UNIT")", "--phase centre or --phase boundary"))
      << "deg is no unit of the track";
  EXPECT_THAT(open_questions(table, camera_rig(), all_of_bare()), IsEmpty());
}

TEST(Import, WithoutATerminalOneLineNamesAllThatIsOpen) {
  ImportSaid said;
  const std::string line =
      refusal([&] { ask_open_questions(read_raw_move(bare, "a.txt"), camera_rig(), LineReader(), said); });
  EXPECT_THAT(line, AllOf(HasSubstr("a.txt: error: "), HasSubstr("--fps RATE"), HasSubstr("column 2=AXIS"),
                          HasSubstr("--phase centre"), Not(HasSubstr("\n"))));
}

TEST(Import, AtATerminalEachIsAskedUntilAllAreAnswered) {
  // A rate that is none is asked again, Enter takes the axis that is suggested, - leaves a column out, and a
  // track does not count in degrees.
  std::deque<std::string> typed = {"23.976", "24", "", "-", "furlong", "deg", "cm", "boundary"};
  const LineReader read = [&]() -> std::optional<std::string> {
    if (typed.empty()) return std::nullopt;
    const std::string line = typed.front();
    typed.pop_front();
    return line;
  };
  ImportSaid said;
  const BakedTable table = read_raw_move(bare, "a.txt");
  EXPECT_TRUE(ask_open_questions(table, camera_rig(), read, said));
  EXPECT_THAT(typed, IsEmpty());
  EXPECT_EQ(as_options(said),
            R"( --fps 24 --axis "column 1=track" --axis "column 2=-" --unit "column 1=cm" --phase boundary)");
  const BakedTable imported = imported_table(table, camera_rig(), said);
  ASSERT_EQ(imported.columns.size(), 1U);
  EXPECT_THAT(imported.columns[0].values, ElementsAre(0, 100, 200)) << "mm of the rig";
  EXPECT_THAT(refusal([&] {
                ImportSaid nothing;
                ask_open_questions(table, camera_rig(), read, nothing);
              }),
              HasSubstr("--fps RATE"))
      << "who was asked has left";
}

TEST(Import, AColumnGoesByItselfToTheAxisOfExactlyItsName) {
  const BakedTable table = read_table_csv("frame,PAN [deg],track [mm]\n1,0,0\n2,1,1\n", "a.csv");
  const std::vector<OpenQuestion> open = open_questions(table, camera_rig(), {.fps = FrameRate{}});
  ASSERT_EQ(open.size(), 2U);
  EXPECT_EQ(open[0].option, R"(--axis "PAN=AXIS")");
  EXPECT_EQ(open[0].suggestion, "pan");
}

TEST(Import, OnceAnAxisIsNamedColumnsWithoutOneAreLeftOut) {
  const BakedTable table =
      read_table_csv("frame,PAN [deg],heat [deg],track [mm]\n1,1,0,3\n2,2,1,4\n", "a.csv");
  const ImportSaid said{.fps = FrameRate{24, 1},
                        .axes = {*axis_word_of("PAN=pan")},
                        .leaves_others_out = true,
                        .phase = ShutterPhase::frame_boundary};
  EXPECT_THAT(open_questions(table, camera_rig(), said), IsEmpty());
  const BakedTable imported = imported_table(table, camera_rig(), said);
  ASSERT_EQ(imported.columns.size(), 2U) << "the column with the name of an axis stays";
  EXPECT_EQ(imported.columns[1].name, "track");
  ASSERT_EQ(imported.warnings.size(), 1U);
  EXPECT_THAT(imported.warnings[0].message, HasSubstr("column \"heat\" is of no axis"));
}

TEST(Import, AWrongNameSaysWhichIsMeantAndAWrongUnitIsRefused) {
  const BakedTable table = read_raw_move(bare, "a.txt");
  ImportSaid said = all_of_bare();
  said.axes[1] = *axis_word_of("2=pam");
  EXPECT_THAT(refusal([&] { open_questions(table, camera_rig(), said); }),
              HasSubstr("did you mean \"pan\"?"));
  said = all_of_bare();
  said.axes[1] = *axis_word_of("3=pan");
  EXPECT_THAT(refusal([&] { open_questions(table, camera_rig(), said); }),
              HasSubstr("there is no column \"column 3\"; did you mean"));
  said = all_of_bare();
  said.units = {*unit_word_of("1=deg"), *unit_word_of("2=deg")};
  EXPECT_THAT(refusal([&] { imported_table(table, camera_rig(), said); }),
              HasSubstr("axis \"track\" counts in deg, and the axis in mm; correct the unit"));
}

TEST(Import, TheMoveOfBoundaryRowsIsTheRows) {
  const RigFile rig = camera_rig();
  const RowsMove move =
      rows_move_of(imported_table(read_raw_move(bare, "a.txt"), rig, all_of_bare()), rig, "a");
  EXPECT_EQ(rows_text_of(move, "a.csv"), "frame,track,pan\n0,0,0\n1,100,-45\n2,200,-90\n");
  EXPECT_THAT(move_text_of(move, "a.csv"),
              EndsWith("name = \"a\"\nfps = 24\nframes = 2\n\n[[track]]\naxes = [\"track\", \"pan\"]\n"
                       "table = \"a.csv\"\n"));
  EXPECT_THAT(move.warnings, IsEmpty());
}

TEST(Import, RowsInTheMiddleOfExposuresAreHalfAFrameLater) {
  // A cubic of time, sampled half a frame behind each frame: the frames between are exact, to rounding.
  const auto at = [](double frame) { return 3 + frame * (2 + frame * (0.5 - 0.03 * frame)); };
  std::string rows;
  constexpr int count = 9;
  for (int row = 0; row < count; ++row) rows += fixed_number(at(row + 0.5), 12) + "\n";
  const RigFile rig = camera_rig();
  const ImportSaid said{.fps = FrameRate{24, 1},
                        .axes = {*axis_word_of("1=pan")},
                        .units = {*unit_word_of("deg")},
                        .phase = ShutterPhase::exposure_centre};
  const RowsMove move = rows_move_of(imported_table(read_raw_move(rows, "a.txt"), rig, said), rig, "a");
  ASSERT_EQ(move.frames(), 9U);
  for (int frame = 1; frame < count; ++frame)
    EXPECT_NEAR(move.positions[0][static_cast<std::size_t>(frame)], at(frame), 1e-10) << frame;
  EXPECT_NEAR(move.positions[0][0], at(0), 0.5) << "a straight line through two rows";
  EXPECT_THAT(move.warnings, ElementsAre(HasSubstr("half a frame before row k")));
}

TEST(Import, AMoveThatIsTooLongIsRefusedBeforeItIsWritten) {
  const RigFile rig = camera_rig();
  BakedTable table{.file = "a.txt"};
  table.fps = FrameRate{1000, 1};
  table.phase = ShutterPhase::exposure_centre;
  table.columns = {
      {.name = "pan", .unit = MoveUnit::deg, .values = std::vector<double>(max_table_rows, 1.0)}};
  EXPECT_THAT(refusal([&] { rows_move_of(table, rig, "a"); }),
              HasSubstr("a.txt: error: 1000001 frames are more than the 1000000 that a move has; import"));
  table.phase = ShutterPhase::frame_boundary;
  EXPECT_EQ(rows_move_of(table, rig, "a").frames(), 1'000'000U);
  RowsMove wide{.name = "a", .fps = {}, .axes = {}, .positions = {}};
  for (int axis = 0; axis < 4; ++axis) {
    wide.axes.push_back(fmt::format("a{}", axis));
    wide.positions.emplace_back(1'000'000, 1.0 / 3);
  }
  EXPECT_THAT(refusal([&] { static_cast<void>(rows_text_of(wide, "a.csv")); }),
              HasSubstr("a.csv: error: the rows would be more than 64 MiB"));
}

TEST(Import, EveryRowOutsideTheRangeIsToldWithItsLine) {
  const RigFile rig = camera_rig();
  ImportSaid said = all_of_bare();
  said.axes[1] = *axis_word_of("2=pan");
  const BakedTable table =
      imported_table(read_raw_move("0 0\n1 91\n2 0\n3 -90.5\n150 0\n", "a.txt"), rig, said);
  EXPECT_EQ(
      refusal([&] { rows_move_of(table, rig, "a"); }),
      "a.txt:2: error: axis \"pan\" is at 91 deg, beyond its range -90..90 deg; correct the row, its unit, "
      "or the rig\n"
      "a.txt:4: error: axis \"pan\" is at -90.5 deg, beyond its range -90..90 deg; correct the row, its "
      "unit, or the rig\n"
      "a.txt:5: error: axis \"track\" is at 1500 mm, beyond its range -1000..1000 mm; correct the row, its "
      "unit, or the rig");
}

TEST(Import, EveryWrongRowOfAFileIsToldAtOnce) {
  const std::string raw = refusal([] { read_raw_move("1 2\n1 x\n3 4\n5\n6 7\nnan 1\n", "a.txt"); });
  EXPECT_THAT(raw,
              AllOf(HasSubstr("a.txt:2:3: error: \"x\""), HasSubstr("\na.txt:4: error: the row has 1 number"),
                    HasSubstr("\na.txt:6:1: error: ")));
  const std::string csv = refusal(
      [] { read_table_csv("frame,a [mm],b [mm]\n1,0,0\n2,0\n3,x,0\n5,0,0\n6,0,0\n8,0,0\n", "a.csv"); });
  EXPECT_THAT(csv,
              AllOf(HasSubstr("a.csv:3: error: the row has 2 fields"), HasSubstr("\na.csv:4:3: error: "),
                    HasSubstr("\na.csv:5:1: error: frame 5 follows frame 3"),
                    HasSubstr("\na.csv:7:1: error: frame 8 follows frame 6"), Not(HasSubstr("a.csv:6"))));
}

TEST(Import, MoreThanTwentyWrongRowsAreCounted) {
  std::string rows = "0 0\n";
  for (int i = 0; i < 25; ++i) rows += "0 x\n";
  EXPECT_THAT(refusal([&] { read_raw_move(rows, "a.txt"); }),
              EndsWith("\na.txt: error: 5 more rows are wrong; correct those above first"));
  for (int i = 0; i < 2'000; ++i) rows += "0 x\n";
  EXPECT_THAT(refusal([&] { read_raw_move(rows, "a.txt"); }),
              EndsWith("\na.txt: error: 980 or more rows are wrong; correct those above first"));
}

BakedTable played() {
  BakedTable table{.file = "move"};
  table.fps = FrameRate{24000, 1001};
  table.first_frame = 0;
  table.phase = ShutterPhase::frame_boundary;
  table.columns = {{.name = "track", .unit = MoveUnit::mm, .values = {0, 100, 250}},
                   {.name = "pan", .unit = MoveUnit::deg, .values = {0, 45, 90}}};
  return table;
}

TEST(Export, WhatWasImportedIsWrittenWithTheSameOptions) {
  const RigFile rig = camera_rig();
  const BakedTable table = imported_table(read_raw_move(bare, "a.txt"), rig, all_of_bare());
  const BakedTable back =
      exported_table(table, {.axes = {*axis_word_of("column 1=track"), *axis_word_of("column 2=-pan")},
                             .units = {*unit_word_of("cm"), *unit_word_of("deg")}});
  const BakedTable again = read_raw_move(write_raw_move(back), "a.txt");
  EXPECT_THAT(again.columns[0].values, ElementsAre(0, 10, 20));
  EXPECT_THAT(again.columns[1].values, ElementsAre(0, 45, 90));
}

TEST(Export, CountsOfServosAreThoseThatImportReadsBack) {
  const CountWord count = *count_word_of("Pan=1500,-0.1deg");
  const BakedTable counts = exported_table(played(), {.axes = {*axis_word_of("Pan=pan")}, .counts = {count}});
  EXPECT_THAT(counts.columns[0].values, ElementsAre(1500, 1050, 600));
  ASSERT_EQ(counts.warnings.size(), 1U);
  EXPECT_THAT(counts.warnings[0].message, HasSubstr("axis \"track\" is not in the file"));
}

TEST(Export, WhatAFormatDoesNotHoldIsALineEach) {
  EXPECT_THAT(
      losses_of(ExchangeFormat::raw_move, played()),
      ElementsAre("no rate: 24000/1001 rows a second", "no names: the columns are track, pan",
                  "no units: track in mm, pan in deg", "no frame numbers: the first row is frame 0",
                  "no phase: a row is the boundary before its frame (boundary)", "no more than 6 decimals"));
  EXPECT_THAT(
      losses_of(ExchangeFormat::csv, played(), 3),
      ElementsAre("no rate: 24000/1001 rows a second", HasSubstr("no phase"), "no more than 3 decimals"));
  EXPECT_THAT(losses_of(ExchangeFormat::flair, played())[0], HasSubstr("no exact rate"));
}

TEST(Export, WhatIsNotThereIsRefused) {
  EXPECT_THAT(refusal([] { exported_table(played(), {.axes = {*axis_word_of("X=pam")}}); }),
              HasSubstr("no axis \"pam\" moves; did you mean \"pan\"?"));
  EXPECT_THAT(refusal([] { exported_table(played(), {.units = {*unit_word_of("pan=cm")}}); }),
              HasSubstr("\"pan\" counts in deg, which is not converted to cm"));
  EXPECT_THAT(refusal([] { exported_table(played(), {.units = {*unit_word_of("tilt=deg")}}); }),
              HasSubstr("the file would have no column \"tilt\"; name one of track, pan"));
}

}  // namespace import_test
}  // namespace inbetween
