// inbetween import and export as their users meet them.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host_tools/move_model/move_file.hpp"
#include "host_tools/plan/plan.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "host_tools/text/csv_table.hpp"
#include "tests/support/places.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace import_command_test {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

class ImportCommand : public testing::Test {
 protected:
  [[nodiscard]] std::string in_folder(const std::string& name) const { return folder_.path() / name; }
  std::string written(const std::string& name, const std::string& text) const {
    std::ofstream(in_folder(name)) << text;
    return in_folder(name);
  }
  [[nodiscard]] ProgramRun import_rows(const std::string& file, const std::string& to,
                                       const std::vector<std::string>& more) const {
    std::vector<std::string> words = {"import", file, "--rig", rig_, "--to", in_folder(to)};
    words.insert(words.end(), more.begin(), more.end());
    return run_program(words);
  }
  [[nodiscard]] ProgramRun export_move(const std::string& to, const std::vector<std::string>& more) const {
    std::vector<std::string> words = {"export", move_, "--rig", rig_, "--to", to == "-" ? to : in_folder(to)};
    words.insert(words.end(), more.begin(), more.end());
    return run_program(words);
  }

  TemporaryFolder folder_;
  std::string rig_ = in_checkout("examples/camera_rig.toml");
  std::string move_ = in_checkout("examples/reveal.toml");
};

const std::vector<std::string> all_of_pan = {"--fps",  "24",  "--axis",  "1=pan",
                                             "--unit", "deg", "--phase", "boundary"};

TEST_F(ImportCommand, RowsBecomeAMoveAndTheRowsBesideIt) {
  const std::string file = written("in.txt", "0\n10\n20.5\n");
  const ProgramRun run = import_rows(file, "pan.toml", all_of_pan);
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("2 frames of pan at 24 fps, 0.083 s"));
  EXPECT_EQ(file_contents(in_folder("pan.csv")), "frame,pan\n0,0\n1,10\n2,20.5\n");
  EXPECT_THAT(file_contents(in_folder("pan.toml")),
              AllOf(HasSubstr("name = \"pan\"\nfps = 24\nframes = 2\n"), HasSubstr("table = \"pan.csv\"")));
}

TEST_F(ImportCommand, WhatNobodyHasSaidIsOneLineAndNothingIsWritten) {
  const std::string file = written("in.txt", "0\n10\n20.5\n");
  const ProgramRun run = import_rows(file, "pan.toml", {"--unit", "deg"});
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.err, AllOf(StartsWith(file + ": error: "), HasSubstr("--fps RATE"),
                             HasSubstr("--axis \"column 1=AXIS\""), HasSubstr("--phase centre")));
  EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1);
  EXPECT_FALSE(std::filesystem::exists(in_folder("pan.toml")));
  EXPECT_FALSE(std::filesystem::exists(in_folder("pan.csv")));
}

TEST_F(ImportCommand, NothingIsWrittenOverUnlessSomebodySaysSo) {
  const std::string file = written("in.txt", "0\n10\n");
  written("pan.csv", "mine");
  const ProgramRun kept = import_rows(file, "pan.toml", all_of_pan);
  EXPECT_EQ(kept.status, 1);
  EXPECT_THAT(kept.err, HasSubstr("pan.csv: error: is there already; add --over"));
  EXPECT_EQ(file_contents(in_folder("pan.csv")), "mine");
  EXPECT_FALSE(std::filesystem::exists(in_folder("pan.toml")));
  std::vector<std::string> over = all_of_pan;
  over.emplace_back("--over");
  EXPECT_EQ(import_rows(file, "pan.toml", over).status, 0);
  // What is read is never written over, whatever is said: the rows get another name.
  const std::string own = written("own.csv", "frame,pan\n0,0\n1,1\n");
  const ProgramRun itself =
      import_rows(own, "own.toml", {"--fps", "24", "--unit", "deg", "--phase", "boundary", "--over"});
  EXPECT_EQ(itself.status, 0) << itself.err;
  EXPECT_EQ(file_contents(own), "frame,pan\n0,0\n1,1\n");
  EXPECT_THAT(file_contents(in_folder("own.toml")), HasSubstr("table = \"own_rows.csv\""));
}

TEST_F(ImportCommand, EveryWrongRowHasItsLine) {
  const std::string file = written("in.txt", "0\nx\n20\n200\n");
  EXPECT_THAT(import_rows(file, "pan.toml", all_of_pan).err, StartsWith(file + ":2:1: error: "));
  const ProgramRun range = import_rows(written("far.txt", "0\n200\n0\n-181\n"), "pan.toml", all_of_pan);
  EXPECT_EQ(range.status, 1);
  EXPECT_THAT(range.err, AllOf(HasSubstr("far.txt:2: error: axis \"pan\" is at 200 deg"),
                               HasSubstr("far.txt:4: error: axis \"pan\" is at -181 deg")));
}

TEST_F(ImportCommand, WhatIsExportedComesBackToWithinItsDecimals) {
  const std::vector<std::string> columns = {"--axis", "vTrack=-slide", "--axis", "vPan=pan", "--unit", "cm"};
  std::vector<std::string> out = columns;
  out.insert(out.end(), {"--format", "kuper"});
  const ProgramRun exported = export_move("kuper.txt", out);
  EXPECT_EQ(exported.status, 0) << exported.err;
  EXPECT_THAT(exported.out,
              AllOf(HasSubstr("kuper has no rate: 24 rows a second\n"),
                    HasSubstr("kuper has no units: vTrack in cm, vPan in deg\n"), HasSubstr("keep it\n")));
  EXPECT_THAT(exported.err, HasSubstr("axis \"tilt\" is not in the file"));
  std::vector<std::string> back = columns;
  back.insert(back.end(), {"--unit", "deg", "--fps", "24", "--phase", "boundary"});
  EXPECT_EQ(import_rows(in_folder("kuper.txt"), "back.toml", back).status, 0);
  const Plan plan(read_move_file(move_), read_rig_file(rig_), {});
  const CsvTable rows = parse_csv(file_contents(in_folder("back.csv")), "back.csv");
  ASSERT_EQ(rows.rows.size(), 193U);
  const Plan back_again(read_move_file(in_folder("back.toml")), read_rig_file(rig_), {});
  std::vector<double> positions(plan.motion().axis_count());
  std::vector<double> played(back_again.motion().axis_count());
  for (std::size_t frame = 0; frame < rows.rows.size(); ++frame) {
    plan.motion().positions({static_cast<std::int32_t>(frame), 0}, positions);
    EXPECT_NEAR(csv_number(rows, rows.rows[frame], 1), positions[0], 0.00051) << "0.00005 cm";
    EXPECT_NEAR(csv_number(rows, rows.rows[frame], 2), positions[1], 0.000051);
    back_again.motion().positions({static_cast<std::int32_t>(frame), 0}, played);
    EXPECT_NEAR(played[0], positions[0], 0.00051) << "a table meets its rows";
    EXPECT_NEAR(played[1], positions[1], 0.000051);
  }
}

TEST_F(ImportCommand, ATakeIsExportedAsItWasMeasuredAndImportedTickByTick) {
  const std::string db = in_folder("takes.db");
  ASSERT_EQ(run_program({"run", move_, "--rig", rig_, "--sim", "--fast", "--takes-in", db}).status, 0);
  const ProgramRun told = run_program({"export", db, "--take", "1", "--to", in_folder("told.csv")});
  const ProgramRun measured =
      run_program({"export", db, "--take", "1", "--measured", "--to", in_folder("measured.csv")});
  ASSERT_EQ(told.status, 0) << told.err;
  ASSERT_EQ(measured.status, 0) << measured.err;
  EXPECT_EQ(export_move("plan.csv", {}).status, 0);
  const CsvTable plan = parse_csv(file_contents(in_folder("plan.csv")), "plan");
  const CsvTable takes = parse_csv(file_contents(in_folder("told.csv")), "told");
  const CsvTable seen = parse_csv(file_contents(in_folder("measured.csv")), "measured");
  ASSERT_EQ(takes.rows.size(), plan.rows.size());
  ASSERT_EQ(seen.rows.size(), plan.rows.size());
  double farthest = 0;
  for (std::size_t row = 0; row < plan.rows.size(); ++row) {
    // Between two ticks on a line: at 250 Hz and 800 mm/s^2 that is 0.0016 mm at most.
    EXPECT_NEAR(csv_number(takes, takes.rows[row], 1), csv_number(plan, plan.rows[row], 1), 0.002);
    farthest = std::max(farthest,
                        std::abs(csv_number(seen, seen.rows[row], 1) - csv_number(plan, plan.rows[row], 1)));
  }
  // As takes show has it of every tick, of which frames are a tenth.
  const ProgramRun shown = run_program({"takes", "show", "1", "--in", db, "--errors", "--json", "-"});
  const double worst = nlohmann::json::parse(shown.out)["measures"][0]["all"]["worst"];
  EXPECT_LE(farthest, std::abs(worst) + 0.002);
  EXPECT_GE(farthest, 0.99 * std::abs(worst));
  const ProgramRun ticks = import_rows(db, "take.toml", {"--take", "1"});
  EXPECT_EQ(ticks.status, 0) << ticks.err;
  EXPECT_THAT(ticks.out, HasSubstr("1999 frames of slide, pan, tilt at 250 fps"));
}

TEST_F(ImportCommand, ARobotBecomesARigThatOnlySimulates) {
  std::filesystem::copy(in_checkout("examples/crane/crane.urdf"), in_folder("crane.urdf"));
  const ProgramRun made =
      run_program({"import", in_folder("crane.urdf"), "--to", in_folder("rig.toml"), "--rate-hz", "250",
                   "--reach", "0.5", "--axis", "track", "--axis", "swing"});
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_THAT(made.out, HasSubstr("for --sim"));
  const RigFile rig = read_rig_file(in_folder("rig.toml"));
  ASSERT_FALSE(rig.axes.empty());
  EXPECT_EQ(rig.kinematics->urdf, "crane.urdf");
  const RigAxis& axis = rig.axes.front();
  const double middle = (axis.min + axis.max) / 2;
  const std::string move = written(
      "move.toml", fmt::format("name = \"m\"\nfps = 24\nframes = 96\n[[track]]\naxes = [\"{0}\"]\n"
                               "keys = [{{ at = [{1}] }}, {{ at = [{2}] }}]\nspeed = [0, 0, 1, 0, 0]\n",
                               axis.name, middle, middle + (axis.max - middle) / 20));
  const ProgramRun simulated =
      run_program({"run", move, "--rig", in_folder("rig.toml"), "--sim", "--fast", "--no-take", "--yes"});
  EXPECT_EQ(simulated.status, 0) << simulated.err;
  // A real run is refused until somebody says what holds the axes, and again for want of a drive.
  const std::string positions = in_folder("positions");
  const auto run_really = [&](const std::string& name) {
    std::vector<std::string> words = {"goto",        "--rig",   in_folder(name),
                                      "--positions", positions, "--stands-at"};
    for (const RigAxis& one : rig.axes)
      words.push_back(fmt::format("{}={}", one.name, (one.min + one.max) / 2));
    EXPECT_EQ(run_program(words).status, 0);
    return run_program(
        {"run", move, "--rig", in_folder(name), "--positions", positions, "--no-take", "--yes"});
  };
  const ProgramRun real = run_really("rig.toml");
  EXPECT_EQ(real.status, 1);
  EXPECT_THAT(real.err, HasSubstr("does not say what it does without power"));
  std::string held = file_contents(in_folder("rig.toml"));
  for (std::size_t at = 0; (at = held.find("\ndrive", at)) != std::string::npos; at += 30)
    held.insert(at, "\nunpowered = \"holds\"");
  written("held.toml", held);
  const ProgramRun piped = run_really("held.toml");
  EXPECT_EQ(piped.status, 1);
  EXPECT_THAT(piped.err, HasSubstr("no_watchdog"));
}

TEST_F(ImportCommand, ARobotsRateIsSaidAndWhatIsOpenIsTold) {
  std::filesystem::copy(in_checkout("examples/crane/crane.urdf"), in_folder("crane.urdf"));
  const ProgramRun asked = run_program({"import", in_folder("crane.urdf"), "--to", in_folder("rig.toml")});
  EXPECT_EQ(asked.status, 1);
  EXPECT_THAT(asked.err, HasSubstr("--rate-hz 250"));
  const ProgramRun open =
      run_program({"import", in_folder("crane.urdf"), "--to", in_folder("rig.toml"), "--rate-hz", "250"});
  EXPECT_EQ(open.status, 0) << open.err;
  EXPECT_THAT(open.out, HasSubstr(": max_acceleration"));
  const std::string broken =
      written("robot.urdf", "<robot name=\"r\">\n<link name=\"a\"/>\n<joint name=\"j\"/>\n</robot>\n");
  const ProgramRun refused =
      run_program({"import", broken, "--to", in_folder("other.toml"), "--rate-hz", "250"});
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.err, AllOf(StartsWith(broken + ":3: error: "), HasSubstr("; ")));
}

TEST_F(ImportCommand, ASceneWithoutMotionIsARigWithQuestions) {
  const std::string scene =
      written("set.arcx",
              "<scen:scene xmlns:scen=\"http://caliri.com/motion/scene\">\n<scen:axis name=\"PAN\" "
              "connectionChannel=\"1\" stepsPerUnit=\"100\"/>\n</scen:scene>\n");
  const ProgramRun made = run_program({"import", scene, "--to", in_folder("rig.toml"), "--rate-hz", "250"});
  EXPECT_EQ(made.status, 0) << made.err;
  EXPECT_THAT(made.out, HasSubstr("1 axis of " + scene));
  EXPECT_THAT(file_contents(in_folder("rig.toml")),
              AllOf(HasSubstr("name = \"PAN\""), HasSubstr("# min = ?")));
}

TEST_F(ImportCommand, ServosAreWrittenInCountsThatSomebodyStates) {
  const ProgramRun positions = export_move("pan.json", {"--axis", "Pan=pan"});
  EXPECT_EQ(positions.status, 1);
  EXPECT_THAT(positions.err, HasSubstr("--count \"Pan=ZERO,STEP\""));
  const std::vector<std::string> words = {"--axis", "Pan=pan", "--count", "Pan=1500,-0.1deg"};
  EXPECT_EQ(export_move("pan.json", words).status, 0);
  std::vector<std::string> back = words;
  back.insert(back.end(), {"--phase", "boundary"});
  const ProgramRun read = import_rows(in_folder("pan.json"), "pan.toml", back);
  EXPECT_EQ(read.status, 0) << read.err;
  EXPECT_THAT(file_contents(in_folder("pan.csv")), StartsWith("frame,pan\n0,-62\n"));
}

TEST_F(ImportCommand, WrongUsageSaysWhatIsMeant) {
  const std::string file = written("in.txt", "0\n10\n");
  EXPECT_EQ(import_rows(file, "pan.csv", {}).status, 2);
  const ProgramRun rate = import_rows(file, "pan.toml", {"--fps", "23.976"});
  EXPECT_EQ(rate.status, 2);
  EXPECT_THAT(rate.err, HasSubstr("--fps \"23.976\": write an exact rate, 24 or 24000/1001"));
  EXPECT_THAT(export_move("-", {}).err, HasSubstr("say the format with --format"));
  EXPECT_THAT(export_move("a.txt", {}).err, HasSubstr("with --format"));
  EXPECT_THAT(import_rows(written("bare", "0 1\n1 2\n"), "pan.toml", {}).err, HasSubstr("(--format)"));
}

/// 0 to 50 degrees in whole degrees, as a servo's animation is baked.
std::string rows_in_whole_degrees() {
  std::string text;
  for (int frame = 0; frame <= 150; ++frame) {
    const double t = frame / 150.0;
    text += fmt::format("{:.0f}\n", 50 * t * t * t * (10 - 15 * t + 6 * t * t));
  }
  return text;
}

TEST_F(ImportCommand, AStaircaseOfWholeDegreesIsAMoveOfFewKeysThatTheRigCanFollow) {
  const std::string file = written("in.txt", rows_in_whole_degrees());
  std::vector<std::string> more = all_of_pan;
  more.insert(more.end(), {"--smooth", "1", "--fit", "pan=0.2", "--plot", in_folder("fit.svg")});
  const ProgramRun run = import_rows(file, "pan.toml", more);
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("by its rounding it would be 576"),
                             HasSubstr("misses its rows by up to 0."), HasSubstr(" of 151 numbers")));
  EXPECT_FALSE(std::filesystem::exists(in_folder("pan.csv")));
  EXPECT_THAT(file_contents(in_folder("fit.svg")), HasSubstr("rows and the move that was fitted to them"));
  const MoveFile move = read_move_file(in_folder("pan.toml"));
  EXPECT_LE(move.tracks.at(0).keys.size(), 6U);
  const ProgramRun check = run_program({"check", in_folder("pan.toml"), "--rig", rig_});
  EXPECT_EQ(check.status, 0) << check.out << check.err;
}

TEST_F(ImportCommand, ASpikeIsALineAndNothingIsWrittenUntilItIsLeftOut) {
  std::string text;
  for (int frame = 0; frame <= 60; ++frame)
    text += fmt::format("{:.2f}\n", frame == 30 ? 44.0 : 20 * std::sin(frame / 20.0));
  const std::string file = written("in.txt", text);
  std::vector<std::string> more = all_of_pan;
  more.insert(more.end(), {"--smooth", "0.01"});
  const ProgramRun run = import_rows(file, "pan.toml", more);
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.err, AllOf(StartsWith(file + ":31"),
                             HasSubstr("axis \"pan\" is 24.05 deg off the motion around it on frame 30"),
                             HasSubstr("--without-spikes")));
  EXPECT_FALSE(std::filesystem::exists(in_folder("pan.toml")));
  more.emplace_back("--without-spikes");
  const ProgramRun without = import_rows(file, "pan.toml", more);
  EXPECT_EQ(without.status, 0) << without.err;
  EXPECT_THAT(without.err, HasSubstr("it follows that motion instead"));
  const CsvTable rows = parse_csv(file_contents(in_folder("pan.csv")), "pan.csv");
  EXPECT_NEAR(std::stod(rows.rows.at(30).fields.at(1)), 20 * std::sin(1.5), 0.01);
}

TEST_F(ImportCommand, TolerancesAreSaidOfEveryAxisOnce) {
  const std::string file = written("in.txt", "0\n10\n20\n30\n");
  const auto refusal = [&](std::vector<std::string> last) {
    std::vector<std::string> more = all_of_pan;
    more.insert(more.end(), last.begin(), last.end());
    const ProgramRun run = import_rows(file, "pan.toml", more);
    EXPECT_EQ(run.status, 2);
    EXPECT_FALSE(std::filesystem::exists(in_folder("pan.toml")));
    return run.err;
  };
  EXPECT_THAT(refusal({"--fit", "0"}), HasSubstr("write a number above 0, or AXIS=NUMBER"));
  EXPECT_THAT(refusal({"--fit", "tilt=1"}), HasSubstr("no column is this axis"));
  EXPECT_THAT(refusal({"--fit", "1", "--fit", "2"}), HasSubstr("was said before"));
  EXPECT_THAT(refusal({"--fit", "pan=1", "--fit", "pan=2"}), HasSubstr("has a number already"));
  EXPECT_THAT(refusal({"--without-spikes"}), HasSubstr("--without-spikes is for --smooth"));
  EXPECT_THAT(refusal({"--plot", "x.svg"}), HasSubstr("--plot draws what --fit misses"));
}

}  // namespace import_command_test
}  // namespace inbetween
