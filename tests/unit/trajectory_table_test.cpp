// `plan --trajectory`: what a microcontroller plays, by the program itself. tests/property plays random
// tables.
#include "host_tools/table/trajectory_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/places.hpp"
#include "tests/support/refused_text.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace trajectory_table_test {

using Json = nlohmann::ordered_json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

const std::string examples = in_checkout("examples/");

ProgramRun plan_table(const std::string& move, const std::string& rig, const std::string& table,
                      std::vector<std::string> more = {}) {
  std::vector<std::string> words{"plan", move, "--rig", rig, "--trajectory", table};
  words.insert(words.end(), more.begin(), more.end());
  return run_program(words);
}

Json table_of(const std::string& move, const std::string& rig, const std::vector<std::string>& more = {}) {
  const TemporaryFolder folder;
  const std::string file = folder.path() / "table.json";
  const ProgramRun run = plan_table(move, rig, file, more);
  EXPECT_EQ(run.status, 0) << run.err;
  return Json::parse(file_contents(file));
}

/// The position of a motor on a frame, powers and all.
double position_at(const Json& table, std::size_t position, std::int32_t frame) {
  for (const Json& group : table["groups"]) {
    for (std::size_t i = 0; i < group["positions"].size(); ++i) {
      if (group["positions"][i] != position) continue;
      if (frame >= table["last"]) return group["end"][i];
      const Json* piece = &group["pieces"][0];
      for (const Json& next : group["pieces"]) {
        if (next["frame"] < frame || (next["frame"] == frame && next["fraction"] == 0)) piece = &next;
      }
      const double u = (frame - (*piece)["frame"].get<double>() - (*piece)["fraction"].get<double>()) *
                       (*piece)["per_frame"].get<double>();
      double sum = 0;
      double power = 1;
      for (const double c : (*piece)["coefficients"][i]) {
        sum += c * power;
        power *= u;
      }
      return sum;
    }
  }
  ADD_FAILURE() << "no group has position " << position;
  return NAN;
}

TEST(TrajectoryTable, HasWhatTheDocumentSays) {
  const Json table = table_of(examples + "reveal.toml", examples + "camera_rig.toml");
  std::vector<std::string> fields;
  for (const auto& [name, value] : table.items()) fields.push_back(name);
  EXPECT_THAT(fields, ElementsAre("format", "name", "rig", "hash", "fps", "rate_hz", "first", "last",
                                  "motors", "groups", "stops"));
  EXPECT_EQ(table["format"], 1);
  EXPECT_EQ(table["name"], "reveal");
  EXPECT_EQ(table["fps"], Json::array({24, 1}));
  EXPECT_EQ(table["rate_hz"], 250);
  EXPECT_EQ(table["last"], 192);
  EXPECT_EQ(table["motors"][1]["name"], "pan");
  EXPECT_EQ(table["motors"][1]["drive_unit"], "counts");
  EXPECT_EQ(table["groups"][0]["end"], Json::array({1640, 32, 6}));
  EXPECT_EQ(table["stops"].size(), 192U);
  EXPECT_EQ(position_at(table, 0, 0), 60);
  const Json plan = Json::parse(
      run_program({"plan", examples + "reveal.toml", "--rig", examples + "camera_rig.toml", "--json", "-"})
          .out);
  EXPECT_EQ(table["hash"], plan["hash"]);
  for (const int frame : {1, 64, 100, 128, 191}) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(position_at(table, axis, frame),
                  plan["axes"][axis]["position"][static_cast<std::size_t>(frame)], 1e-10);
  }
}

TEST(TrajectoryTable, BeginsAndEndsWithTheRollsOfAMoveAndOfItsPart) {
  const Json part = table_of(examples + "reveal.toml", examples + "camera_rig.toml", {"--frames", "60..100"});
  const std::int32_t first = part["first"];
  EXPECT_LT(first, 60) << "it is moving on frame 60";
  EXPECT_GT(part["last"], 100);
  const Json plan =
      Json::parse(run_program({"plan", examples + "reveal.toml", "--rig", examples + "camera_rig.toml",
                               "--frames", "60..100", "--json", "-"})
                      .out);
  EXPECT_EQ(plan["pre_roll"]["frames"], 60 - first);
  EXPECT_NEAR(position_at(part, 0, first), plan["pre_roll"]["axes"][0]["position"][0], 1e-10);
  EXPECT_NEAR(position_at(part, 0, 60), plan["axes"][0]["position"][0], 1e-10);
  EXPECT_NEAR(position_at(part, 0, 77), plan["axes"][0]["position"][17], 1e-10);
  EXPECT_EQ(position_at(part, 0, part["last"]), plan["post_roll"]["axes"][0]["position"].back());
}

TEST(TrajectoryTable, AMotorBehindACalibrationHasItsOwnPositionsAndMotorsOfOneAxisShareThem) {
  const std::string rig = file_contents(examples + "gantry_rig.toml");
  const TemporaryFile stiff(
      "rig.toml", with(rig, "backlash = { play = 0.1, take_up_s = 0.3, approach = \"positive\" }\n", ""));
  const Json table = table_of(examples + "rack_focus.toml", stiff.path());
  const Json& motors = table["motors"];
  ASSERT_EQ(motors.size(), 4U);
  EXPECT_EQ(motors[3]["name"], "gantry.2");
  EXPECT_EQ(motors[3]["position"], motors[0]["position"]);
  EXPECT_EQ(motors[3]["offset"], 3.2);
  EXPECT_EQ(motors[3]["scale"], -1000);
  EXPECT_EQ(motors[1]["unit"], "deg");
  EXPECT_EQ(table["groups"].size(), 2U);
  EXPECT_NEAR(position_at(table, 1, 0), 200, 1e-9) << "the mark of 3 m";
  EXPECT_NEAR(position_at(table, 1, 72), 90, 1e-9) << "the mark of 0.8 m";
}

TEST(TrajectoryTable, ItsCountsAreThoseOfARun) {
  const Json table = table_of(examples + "reveal.toml", examples + "camera_rig.toml");
  const TemporaryFolder folder;
  const std::string record = folder.path() / "run.csv";
  const ProgramRun run = run_program({"run", examples + "reveal.toml", "--rig", examples + "camera_rig.toml",
                                      "--sim", "--fast", "--record", record});
  ASSERT_EQ(run.status, 0) << run.err;
  std::ifstream lines(record);
  std::string line;
  std::vector<std::vector<double>> told;
  while (std::getline(lines, line)) {
    if (line.find(",running,") == std::string::npos) continue;
    std::vector<double> row;
    std::stringstream words(line);
    std::string word;
    for (int column = 0; std::getline(words, word, ','); ++column) {
      if (column == 4 || column == 6 || column == 8) row.push_back(std::stod(word));
    }
    told.push_back(row);
  }
  ASSERT_GE(told.size(), 1999U);  // the ticks between the first, on which it is still ready, and the last
  int frames = 0;
  for (std::int32_t frame = 12; frame < 192; frame += 12) {  // 125 ticks are 12 frames
    const std::vector<double>& row = told.at(static_cast<std::size_t>(frame / 12 * 125 - 1));
    for (std::size_t m = 0; m < 3; ++m) {
      const double scale = table["motors"][m]["scale"];
      EXPECT_EQ(std::floor(position_at(table, m, frame) * scale + 0.5), std::floor(row[m] * scale + 0.5))
          << "frame " << frame;
    }
    ++frames;
  }
  EXPECT_EQ(frames, 15);
}

TEST(TrajectoryTable, SaysWhatItWroteAndNamesWhatTheHeaderDefinesAfterItsFile) {
  EXPECT_EQ(table_name_of("/tmp/a/move 1.v2.h"), "move_1_v2");
  EXPECT_EQ(table_name_of("2nd.h"), "_2nd");
  EXPECT_EQ(table_name_of(".h"), "_h");
  const TemporaryFolder folder;
  const std::string file = folder.path() / "fly-in.h";
  const ProgramRun run = plan_table(examples + "reveal.toml", examples + "camera_rig.toml", file);
  EXPECT_THAT(run.out,
              HasSubstr(file + ": 35 pieces of 3 motors, and a stop for each of 192 places, which takes"));
  EXPECT_THAT(file_contents(file), HasSubstr("static const inbetween_trajectory fly_in_table = {"));
}

TEST(TrajectoryTable, TextOfAMoveEndsNoCommentAndNoStringAndItsFileMayBeCalledAsAWordOfC) {
  const std::string text = file_contents(examples + "reveal.toml");
  const std::size_t name = text.find("name");
  const TemporaryFile move("move.toml",
                           "name = \"a */ int x; \\\\\\\" ?\?/\"\n" + text.substr(text.find('\n', name)));
  const TemporaryFolder folder;
  const std::string file = folder.path() / "int.h";
  const ProgramRun run = plan_table(move.path(), examples + "camera_rig.toml", file);
  ASSERT_EQ(run.status, 0) << run.err;
  const ProgramRun compiled = run_command(
      {"/usr/bin/cc", "-std=c99", "-Wall", "-Wextra", "-Werror", "-x", "c", "-fsyntax-only", file});
  EXPECT_EQ(compiled.status, 0) << compiled.err;
}

TEST(TrajectoryTable, IsRefusedWithoutWhatItNeeds) {
  const std::string reveal = examples + "reveal.toml";
  const std::string rig = examples + "camera_rig.toml";
  const TemporaryFolder folder;
  const std::string file = folder.path() / "table.h";
  EXPECT_EQ(run_program({"plan", reveal, "--trajectory", file}).err,
            "inbetween: error: --trajectory needs --rig RIG, whose limits say how the move is stopped; see "
            "inbetween "
            "plan --help\n");
  EXPECT_THAT(plan_table(reveal, rig, folder.path() / "table.csv").err,
              HasSubstr("must end in .json, or in .h"));
  EXPECT_THAT(plan_table(reveal, rig, file, {"--solver", "runge-kutta"}).err,
              HasSubstr("--solver runge-kutta knows frames only"));
  EXPECT_EQ(plan_table(reveal, rig, file, {"--solver", "runge-kutta"}).status, 2);
  const ProgramRun geared = plan_table(examples + "rack_focus.toml", examples + "gantry_rig.toml", file);
  EXPECT_EQ(geared.status, 1);
  EXPECT_THAT(geared.err, HasSubstr("rack_focus.toml:6:28: error: axis \"tilt\" takes up its backlash"));
  EXPECT_FALSE(std::filesystem::exists(file));
}

TEST(TrajectoryTable, AMoveBeyondTheLimitsIsRefusedAsByARun) {
  const TemporaryFile fast("fast.toml",
                           with(file_contents(examples + "reveal.toml"), "frames = 192", "frames = 60"));
  const TemporaryFolder folder;
  const std::string file = folder.path() / "table.h";
  const ProgramRun run = plan_table(fast.path(), examples + "camera_rig.toml", file);
  EXPECT_EQ(run.status, 3);
  EXPECT_THAT(run.err, HasSubstr("max_"));
  EXPECT_FALSE(std::filesystem::exists(file));
}

}  // namespace trajectory_table_test
}  // namespace inbetween
