// Tables, as who bakes an animation meets them: the rows play as they are, and a wrong row is told by its
// line.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "host_tools/check/check.hpp"
#include "host_tools/check/check_frames.hpp"
#include "host_tools/edit/edit_document.hpp"
#include "host_tools/move_model/move_rewrite.hpp"
#include "host_tools/plan/fitted_trajectory.hpp"
#include "host_tools/plan/plan.hpp"
#include "host_tools/plan/plan_output.hpp"
#include "host_tools/text/csv_table.hpp"
#include "tests/support/refused_text.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace table_track_test {

using Json = nlohmann::json;
using testing::HasSubstr;
using testing::Not;

const std::string move = R"(name = "baked"
fps = 24
frames = 12
[[track]]
axes = ["neck", "nod"]
table = "rows.csv"
)";

/// The neck rests at both ends, and nod moves there. There is a row on every frame, and then on few.
const std::string rows =
    "frame,neck,nod\n0,0,5\n1,0,7\n2,1.5,8\n3,4,8\n4,7,7.5\n6,11,4\n9,12.25,-1\n11,12,-2.5\n12,12,-3\n";

const std::string rig =
    rig_text({{.name = "neck", .max_acceleration = 4000}, {.name = "nod", .max_acceleration = 4000}});

MoveFile parsed(const std::string& csv, const std::string& text = move) {
  return parse_move_beside([&](const std::filesystem::path&, std::size_t) { return csv; }, text, "move.toml");
}

Plan planned(const std::string& csv = rows, const std::string& text = move) {
  return {parsed(csv, text), std::nullopt, {}};
}

Plan planned_on(const std::string& rig_of, const std::string& csv = rows, const std::string& text = move) {
  return {parsed(csv, text), parse_rig(rig_of, "rig.toml"), {}};
}

template <class Action>
std::string refusal_of(const Action& action) {
  try {
    action();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), Not(HasSubstr("\n")));
    EXPECT_THAT(error.what(), HasSubstr("; "));
    return error.what();
  }
  return "accepted";
}

std::string refusal_of_csv(const std::string& csv) {
  return refusal_of([&] { static_cast<void>(parsed(csv)); });
}

std::string refusal_of_text(const std::string& text) {
  return refusal_of([&] { static_cast<void>(parsed(rows, text)); });
}

/// A move and its table as files.
class TableFolder {
 public:
  explicit TableFolder(const std::string& csv = rows, const std::string& text = move) {
    for (const auto& [name, bytes] : {std::pair("move.toml", text), {"rows.csv", csv}, {"rig.toml", rig}})
      std::ofstream(path(name), std::ios::binary) << bytes;
  }
  [[nodiscard]] std::string path(const std::string& name) const { return (folder_.path() / name).string(); }

 private:
  TemporaryFolder folder_;
};

TEST(TableTrack, EveryRowIsMetToTheLastBitAndNothingStepsThere) {
  const Plan plan = planned();
  const MoveTable& table = plan.move().tracks[0].table.value();
  const FittedTrajectory fitted(plan.tracks()[0].track());
  std::vector<AxisMotion> motion(2);
  for (std::size_t row = 0; row + 1 < table.frames.size(); ++row) {
    fitted->motion({table.frames[row], 0}, motion);
    for (std::size_t d = 0; d < 2; ++d) EXPECT_EQ(motion[d].position, table.at[2 * row + d]) << row;
  }
  fitted->motion({12, 0}, motion);
  EXPECT_NEAR(motion[0].position, 12, 1e-12);
  EXPECT_NEAR(motion[1].position, -3, 1e-12);
  for (std::size_t piece = 1; piece < fitted->pieces().size(); ++piece) {
    for (std::size_t d = 0; d < 2; ++d) {
      for (const std::size_t derivative : {0U, 1U, 2U}) {
        const double before = at_end_of_piece(*fitted, fitted->pieces()[piece - 1], d, derivative, true);
        const double behind = at_end_of_piece(*fitted, fitted->pieces()[piece], d, derivative, false);
        EXPECT_NEAR(before, behind, 1e-9 * std::pow(24, derivative))
            << piece << " " << d << " " << derivative;
      }
    }
  }
}

TEST(TableTrack, WhatPlaysAreTheCubicsThemselves) {
  const Plan plan = planned();
  const FittedTrajectory fitted(plan.tracks()[0].track());
  // A piece from row to row, and one more beside the rest of the neck at either end.
  EXPECT_EQ(fitted->pieces().size(), 8U + 2U);
  for (const TrajectoryPiece& piece : fitted->pieces()) EXPECT_TRUE(piece.degree <= 3 && piece.is_exact);
}

TEST(TableTrack, AnAxisRestsWhereItsFirstTwoOrLastTwoRowsAreEqual) {
  const Plan plan = planned();
  const FittedTrajectory fitted(plan.tracks()[0].track());
  const AxisMotion neck = fitted->motion_of(0, {0, 0});
  EXPECT_EQ(neck.velocity, 0);
  EXPECT_EQ(neck.acceleration, 0);
  const AxisMotion nod = fitted->motion_of(1, {0, 0});
  EXPECT_GT(nod.velocity, 24);
  EXPECT_NEAR(nod.acceleration, 0, 1e-9);
  EXPECT_TRUE(plan.is_moving(0, RollEnd::before));
  const Plan still = planned("frame,neck,nod\n0,0,5\n4,0,5\n8,3,6\n11,4,9\n12,4,9\n");
  EXPECT_FALSE(still.is_moving(0, RollEnd::before));
  EXPECT_FALSE(still.is_moving(0, RollEnd::after));
}

TEST(TableTrack, RestSaysOtherwiseOfAllAxes) {
  for (const auto& [rest, starts_moving, ends_moving] :
       {std::tuple("both", false, false), std::tuple("start", false, true), std::tuple("end", true, false),
        std::tuple("none", true, true)}) {
    const Plan plan = planned(rows, with(move, "table =", fmt::format("rest = \"{}\"\ntable =", rest)));
    EXPECT_EQ(plan.is_moving(0, RollEnd::before), starts_moving) << rest;
    EXPECT_EQ(plan.is_moving(0, RollEnd::after), ends_moving) << rest;
    EXPECT_NEAR(FittedTrajectory(plan.tracks()[0].track())->motion_of(0, {6, 0}).position, 11, 1e-12) << rest;
  }
}

TEST(TableTrack, TwoRowsAreATableToo) {
  const std::string two = "frame,neck,nod\n0,0,1\n12,6,1\n";
  const Plan line = planned(two);
  // The neck has nothing that bends it: a straight line.
  EXPECT_NEAR(FittedTrajectory(line.tracks()[0].track())->motion_of(0, {3, 0}).position, 1.5, 1e-12);
  const Plan eased = planned(two, with(move, "table =", "rest = \"both\"\ntable ="));
  const FittedTrajectory fitted(eased.tracks()[0].track());
  EXPECT_NEAR(fitted->motion_of(0, {6, 0}).position, 3, 1e-12);
  EXPECT_LT(fitted->motion_of(0, {3, 0}).position, 1);
  EXPECT_EQ(fitted->motion_of(1, {5, 0.5}).position, 1);
}

TEST(TableTrack, NothingRestsBetweenEqualRowsInside) {
  // Whole degrees, as servos are baked.
  const Plan plan = planned("frame,neck,nod\n0,0,0\n2,1,0\n4,2,0\n6,2,0\n8,3,0\n10,4,0\n12,5,0\n");
  const FittedTrajectory fitted(plan.tracks()[0].track());
  EXPECT_GT(std::fabs(fitted->motion_of(0, {4, 0}).velocity), 1);
}

TEST(TableTrack, AColumnCountsInItsUnitOrThatOfTheTrackOrTheRig) {
  const std::string degrees = rig_text({{.name = "neck", .unit = "deg"}, {.name = "nod", .unit = "deg"}});
  for (const auto& [head, unit] : {std::pair("frame,neck (turn),nod", ""),
                                   std::pair("frame,neck,nod (deg)", "unit = { neck = \"turn\" }\n"),
                                   std::pair("nod ,other, frame,\"neck (turn)\"", "")}) {
    const bool has_other = std::string(head).find("other") != std::string::npos;
    const std::string csv =
        std::string(head) + (has_other ? "\n2,x,0,0.25\n1,,12,0.5\n" : "\n0,0.25,2\n12,0.5,1\n");
    const Plan plan = planned_on(degrees, csv, move + unit);
    EXPECT_NEAR(plan.move().tracks[0].table->at[0], 90, 1e-12) << head;
    EXPECT_NEAR(plan.move().tracks[0].keys[1].at[0], 180, 1e-12) << head;
    EXPECT_EQ(plan.move().tracks[0].table->at[1], 2) << head;
  }
  EXPECT_THAT(refusal_of([&] { planned_on(degrees, "frame,neck (mm),nod\n0,0,0\n12,1,1\n"); }),
              HasSubstr("rows.csv:2: error: axis \"neck\" is given in mm, and it counts deg"));
}

TEST(TableTrack, AWrongRowIsToldWithItsLine) {
  const std::vector<std::pair<const char*, const char*>> files = {
      {"", "rows.csv: error: the file is empty"},
      {"frame;neck;nod\n0;0;0\n", "rows.csv:1: error: the first row names no column \"frame\""},
      {"frame,neck\n0,0\n12,0\n", "rows.csv:1: error: the first row names no column \"nod\""},
      {"frame,neck,nod (parsec)\n0,0,0\n", "rows.csv:1: error: the first row names no column \"nod\""},
      {"frame,neck,nod,neck (deg)\n0,0,0,0\n",
       "rows.csv:1: error: the columns \"neck\" and \"neck (deg)\" are both"},
      {"frame,neck,nod\n", "rows.csv:1: error: the table has no row"},
      {"frame,neck,nod\n0,0,0\n", "rows.csv:2: error: the table ends on frame 0; give it a row on frame 12"},
      {"frame,neck,nod\n0,0,0\n9,1,1\n", "rows.csv:3: error: the table ends on frame 9"},
      {"frame,neck,nod\n1,0,0\n12,1,1\n",
       "rows.csv:2: error: the table begins on frame 1; count its frames from 0"},
      {"frame,neck,nod\n0,0,0\n13,1,1\n", "rows.csv:3: error: frame 13 is none of the move"},
      {"frame,neck,nod\n0,0,0\n-1,1,1\n", "rows.csv:3: error: frame -1 is none of the move"},
      {"frame,neck,nod\n0,0,0\n2.5,1,1\n", "rows.csv:3: error: frame 2.5 is none of the move"},
      {"frame,neck,nod\n0,0,0\n5,1,1\n5,2,2\n12,1,1\n", "rows.csv:4: error: frame 5 comes behind frame 5"},
      {"frame,neck,nod\n0,0,0\n5,1,1\n4,2,2\n12,1,1\n", "rows.csv:4: error: frame 4 comes behind frame 5"},
      {"frame,neck,nod\n0,0,0\n5,nan,1\n12,1,1\n", "rows.csv:3: error: \"neck\" is \"nan\"; write a number"},
      {"frame,neck,nod\n0,0,0\n5,1,-inf\n12,1,1\n", "rows.csv:3: error: \"nod\" is \"-inf\"; write a number"},
      {"frame,neck,nod\n0,0,0\n5,1e300,1\n12,1,1\n", "rows.csv:3: error: \"neck\" is \"1e300\""},
      {"frame,neck,nod\n0,0,0\n5,,1\n12,1,1\n", "rows.csv:3: error: \"neck\" is \"\""},
      {"frame,neck,nod\n0,0,0\n5,1,5,2,5\n12,1,1\n",
       "rows.csv:3: error: the row has 5 fields, and the first row names 3"},
      {"frame,neck,nod\n0,0,0\n5,\"1,5\",2\n12,1,1\n",
       "rows.csv:3: error: \"neck\" is \"1,5\"; write a number such as 12.5"},
      {"frame,neck,nod\n0,0,0\n\n\n5,\"1\n12,1,1\n", "rows.csv:5: error: a quote is not closed"},
  };
  for (const auto& [csv, words] : files) EXPECT_THAT(refusal_of_csv(csv), HasSubstr(words)) << csv;
}

TEST(TableTrack, WhatElseSaysWhereTheAxesAreIsRefusedBesideATable) {
  for (const char* const field :
       {"keys = [{ at = [0, 0] }]", "speed = [1]",         "weights = [1, 1]",    "timing = \"frames\"",
        "kinetic = \"curves\"",     "spline = \"smooth\"", "closed = true",       "periodic = true",
        "overshoot = false",        "corners = \"ease\"",  "ease_in = 2",         "ease_out = 2",
        "through = true",           "overlap = 2",         "round = 2",           "space = \"hand\"",
        "aim = \"hand\"",           "elbow = \"up\"",      "near = { neck = 1 }", "distance = \"hand\"",
        "network = true",           "places = [0, 1]",     "drawn = {}",          "wrap = 360"}) {
    EXPECT_THAT(refusal_of_text(move + field + "\n"), HasSubstr("move.toml:7:")) << field;
    EXPECT_THAT(refusal_of_text(move + field + "\n"), HasSubstr("is for other tracks")) << field;
  }
  EXPECT_THAT(refusal_of_text(with(move, "rows.csv", "../rows.csv")),
              HasSubstr("put the file beside that of the move"));
  EXPECT_THAT(refusal_of_text(with(move, "\"rows.csv\"", "3")), HasSubstr("table"));
}

TEST(TableTrack, OtherTracksAndCuesStandBesideIt) {
  const std::string text =
      move +
      "[[track]]\naxes = [\"jaw\"]\nkeys = [{ at = [0] }, { at = [9] }]\nspeed = [0, 0, 9, 0, 0]\n"
      "[[cue]]\nline = \"lamp\"\nframes = [6]\nwidth_ms = 5\n";
  const Plan plan = planned(rows, text);
  EXPECT_EQ(plan.tracks().size(), 2U);
  EXPECT_EQ(plan.move().cues.size(), 1U);
  const std::vector<std::string> files = files_beside(plan.move());
  EXPECT_THAT(files, testing::ElementsAre("rows.csv"));
  EXPECT_THAT(refusal_of([&] { static_cast<void>(parsed(rows, with(text, "\"jaw\"", "\"nod\""))); }),
              HasSubstr("which line 5 has already"));
}

TEST(TableTrack, TheHashCountsRowsAndFrames) {
  const std::string hash = hash_in_words(parsed(rows));
  EXPECT_NE(hash_in_words(parsed(with(rows, "7.5", "7.6"))), hash);
  EXPECT_NE(hash_in_words(parsed(with(rows, "\n9,", "\n8,"))), hash);
  EXPECT_EQ(hash_in_words(parsed(with(rows, "7.5", "7.50"))), hash);
}

TEST(TableTrack, APartOfItIsTheWholeToTheLastBit) {
  const Plan whole = planned_on(rig);
  const Plan part(parsed(rows), parse_rig(rig, "rig.toml"), {.frames = {.first = 3, .last = 9}});
  std::vector<AxisMotion> here(2);
  std::vector<AxisMotion> there(2);
  for (std::int32_t frame = 3; frame < 9; ++frame) {
    for (const double fraction : {0.0, 0.375}) {
      whole.motion().motion({frame, fraction}, here);
      part.motion().motion({frame, fraction}, there);
      for (std::size_t d = 0; d < 2; ++d) EXPECT_EQ(here[d].position, there[d].position) << frame;
    }
  }
}

TEST(TableTrack, WhatARunCommandsIsWhatAPlanPerTickSays) {
  const TableFolder folder;
  const std::vector<std::string> files = {folder.path("move.toml"), "--rig", folder.path("rig.toml")};
  const auto table_of = [&](std::vector<std::string> words, const std::string& out) {
    words.insert(words.begin() + 1, files.begin(), files.end());
    words.push_back(folder.path(out));
    const ProgramRun run = run_program(words);
    EXPECT_EQ(run.status, 0) << run.err;
    return parse_csv(file_contents(folder.path(out)), out);
  };
  const CsvTable plan = table_of({"plan", "--per", "tick", "--csv"}, "plan.csv");
  const CsvTable record = table_of({"run", "--sim", "--fast", "--record"}, "record.csv");
  const auto column = [](const CsvTable& table, const std::string& name) {
    return static_cast<std::size_t>(std::ranges::find(table.columns, name) - table.columns.begin());
  };
  ASSERT_GT(plan.rows.size(), 50U);
  ASSERT_GE(record.rows.size(), plan.rows.size());
  for (std::size_t tick = 0; tick < plan.rows.size(); ++tick) {
    for (const std::string name : {"neck", "nod"}) {
      EXPECT_EQ(csv_number(plan, plan.rows[tick], column(plan, name + " (mm)")),
                csv_number(record, record.rows[tick], column(record, name)))
          << tick;
    }
  }
}

TEST(TableTrack, ARowOutsideTheRigIsToldByItsLineAndWhatASplineAddsByItsFrame) {
  const Plan far = planned_on(rig_text({{.name = "neck", .max = 11.5}, {.name = "nod"}}));
  ASSERT_EQ(far.keys_outside().size(), 1U);
  EXPECT_EQ(far.keys_outside()[0].place.file, "rows.csv");
  EXPECT_EQ(far.keys_outside()[0].place.line, 8U);
  EXPECT_THAT(far.keys_outside()[0].message, HasSubstr("frame 9: axis \"neck\" is at 12.25"));
  const CheckReport report = check(far);
  ASSERT_FALSE(report.fits());
  EXPECT_THAT(report.refusals.front().message(), HasSubstr("move its rows there inward by"));
}

TEST(TableTrack, WhatIsTooFastIsToldByTheRowBeforeIt) {
  const std::string slow = rig_text({{.name = "neck", .max_velocity = 65, .max_acceleration = 4000},
                                     {.name = "nod", .max_acceleration = 4000}});
  const CheckReport report = check(planned_on(slow));
  ASSERT_FALSE(report.fits());
  // From frame 3 to 4 the neck goes up by 3.
  EXPECT_EQ(report.refusals.front().place.file, "rows.csv");
  EXPECT_EQ(report.refusals.front().place.line, 5U) << report.refusals.front().message();
  EXPECT_THAT(report.refusals.front().message(), HasSubstr("; bake the rows slower there, on more frames"));
}

TEST(TableTrack, OtherFramesAreNotTried) {
  EXPECT_THAT(why_frames_are_fixed(parsed(rows)).value_or(""),
              HasSubstr("rows of a table are on the frames"));
}

TEST(TableTrack, AHundredThousandRowsAreReadOneByOneAndProven) {
  std::string csv = "frame,neck,nod\n";
  for (int frame = 0; frame <= 99'999; ++frame) {
    fmt::format_to(std::back_inserter(csv), "{},{:.5f},{:.5f}\n", frame, 40 * std::sin(frame / 50.0),
                   30 * std::cos(frame / 70.0));
  }
  const Plan plan = planned_on(rig, csv, with(move, "frames = 12\n", "frames = 99999\n"));
  EXPECT_EQ(plan.move().tracks[0].table->frames.size(), 100'000U);
  const CheckReport report = check(plan);
  EXPECT_TRUE(report.fits()) << report.refusals.front().message();
  EXPECT_NEAR(report.axes[0].velocity.value, 40 / 50.0 * 24, 1e-3);
}

TEST(TableTrack, AFileBeyondItsBoundIsNotRead) {
  const TableFolder folder;
  std::filesystem::resize_file(folder.path("rows.csv"), max_table_bytes + 1);
  EXPECT_THAT(refusal_of([&] { static_cast<void>(read_move_file(folder.path("move.toml"))); }),
              HasSubstr("has 67108865 bytes, more than the 67108864 allowed"));
}

TEST(TableTrack, ItsKeysCannotBeEditedAndTheRestOfTheFileCan) {
  const TableFolder folder;
  const std::string name = folder.path("move.toml");
  EXPECT_EQ(why_keys_are_fixed(move, name, 0).value_or(""),
            "the motion is that of \"rows.csv\", row by row; edit that file");
  EditedMove edited = edits_of(read_move_file(name));
  EXPECT_EQ(with_edits(move, name, edited), move);
  edited.fps = "25";
  EXPECT_EQ(with_edits(move, name, edited), with(move, "fps = 24", "fps = 25"));
  edited.tracks[0].keys[0].at[0] = 1;
  EXPECT_THAT(refusal_of([&] { static_cast<void>(with_edits(move, name, edited)); }),
              HasSubstr("edit that file"));
}

TEST(TableTrack, ThePageIsGivenThePathAndToldWhyKeysAreFixed) {
  const TableFolder folder;
  const std::string name = folder.path("move.toml");
  const Plan plan(read_move_file(name), std::nullopt, {});
  const Json document = Json::parse(
      document_of(plan, {.file = name, .id = "", .revision = "", .rig_revision = "", .text = move}));
  const Json& track = document["tracks"][0];
  EXPECT_FALSE(track["live"].get<bool>());
  EXPECT_THAT(track["fixed_keys"].get<std::string>(), HasSubstr("row by row"));
  EXPECT_EQ(track["path"]["knots"].size(), 4U * 10);
  EXPECT_TRUE(track["speed"].is_null());
  EXPECT_EQ(track["keys"].size(), 2U);
}

TEST(TableTrack, ThePageSaysThatATableIsTooLongForIt) {
  std::string csv = "frame,neck,nod\n";
  for (int frame = 0; frame <= 4001; ++frame) csv += fmt::format("{},{},0\n", frame, frame % 7);
  const Plan plan = planned(csv, with(move, "frames = 12\n", "frames = 4001\n"));
  EXPECT_THAT(
      refusal_of([&] { static_cast<void>(document_of(plan, {})); }),
      HasSubstr("move.toml:6:9: error: the table has 4002 rows on 4001 frames, and the page does not show"));
}

}  // namespace table_track_test
}  // namespace inbetween
