// Pulses of moves on the outputs of rigs: in a run from end to end, and the object by itself.
#include "host_tools/rig/cue_outputs.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "host_tools/motions/run.hpp"
#include "host_tools/motions/start_signal.hpp"
#include "host_tools/move_model/move_file.hpp"
#include "host_tools/plan/plan.hpp"
#include "host_tools/rig/simulated_hardware.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "tests/support/places.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace cue_outputs_test {

const std::string slide_and_pan = in_checkout("examples/slide_and_pan.toml");
const std::string slider_rig = in_checkout("examples/slider_rig.toml");

Plan plan_of(const std::string& move, const std::string& rig) {
  return {read_move_file(move), read_rig_file(rig), {.solver = Solver::closed_form}};
}

struct Row {
  double seconds = 0;
  std::string line;
  double frame = 0;
  double width_ms = 0;
  bool is_merged = false;
  std::string late_us;
};

/// Without the header.
std::vector<Row> rows_of(const std::string& path) {
  std::vector<Row> rows;
  std::ifstream file(path);
  std::string text;
  std::getline(file, text);
  EXPECT_EQ(text, "seconds,line,frame,width_ms,merged,late_us");
  while (std::getline(file, text)) {
    std::istringstream fields(text);
    std::vector<std::string> field(6);
    for (std::string& one : field) std::getline(fields, one, ',');
    rows.push_back(
        {std::stod(field[0]), field[1], std::stod(field[2]), std::stod(field[3]), field[4] == "1", field[5]});
  }
  return rows;
}

const SessionOptions simulated{.simulated = true, .fast = true};

TEST(CueOutputs, EveryFrameOfARunHasItsPulseAtItsTimeAndTheClapperFramesIt) {
  const TemporaryFolder folder;
  const std::string file = folder.path() / "cues.csv";
  const Plan plan = plan_of(slide_and_pan, slider_rig);
  const RunReport report = run(plan, simulated, {.cue_log = file});
  EXPECT_EQ(report.ending, Ending::finished) << report.reason;
  const std::vector<Row> rows = rows_of(file);
  ASSERT_EQ(rows.size(), 2U + 288U);
  EXPECT_EQ(rows.front().line, "clapper");
  EXPECT_EQ(rows.front().frame, 0);
  EXPECT_EQ(rows.back().line, "clapper");
  EXPECT_EQ(rows.back().frame, 288);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_NEAR(rows[i].seconds - rows.front().seconds, rows[i].frame / 24, 1e-6) << "pulse " << i;
    EXPECT_FALSE(rows[i].is_merged);
    EXPECT_EQ(rows[i].late_us, "0");
    if (rows[i].line != "camera") continue;
    EXPECT_EQ(rows[i].frame, static_cast<double>(i - 1) + 0.25);
    EXPECT_EQ(rows[i].width_ms, 15);
  }
}

TEST(CueOutputs, OfAPartOfAMoveItsOwnPulsesHappenAndTheClapperFramesIt) {
  const TemporaryFolder folder;
  const std::string file = folder.path() / "cues.csv";
  const Plan plan(read_move_file(slide_and_pan), read_rig_file(slider_rig), {.frames = {100, 150}});
  const RunReport report = run(plan, simulated, {.cue_log = file});
  EXPECT_EQ(report.ending, Ending::finished) << report.reason;
  const std::vector<Row> rows = rows_of(file);
  ASSERT_EQ(rows.size(), 2U + 51U);
  EXPECT_EQ(rows.front().line, "clapper");
  EXPECT_EQ(rows.front().frame, 100);
  EXPECT_EQ(rows[1].frame, 100.25);
  EXPECT_EQ(rows[51].line, "clapper");
  EXPECT_EQ(rows[51].frame, 150);
  EXPECT_EQ(rows[52].line, "camera");
  EXPECT_EQ(rows[52].frame, 150.25);
  for (const Row& row : rows) {
    EXPECT_NEAR(row.seconds - rows.front().seconds, (row.frame - 100) / 24, 1e-6);
  }
}

TEST(CueOutputs, TheReportTellsHowManyPulsesAreInTheLogAndWhatWentWrongWithThem) {
  const TemporaryFolder folder;
  const ProgramRun run = run_program({"run", slide_and_pan, "--rig", slider_rig, "--sim", "--fast", "--yes",
                                      "--cue-log", (folder.path() / "cues.csv").string(), "--json", "-"});
  EXPECT_EQ(run.status, 0) << run.err;
  const auto json = nlohmann::ordered_json::parse(run.out);
  EXPECT_EQ(json["cue_log"].dump(), R"({"pulses":290,"lost":0,"why":""})");
  EXPECT_EQ(json["pulses"].dump(), R"({"merged":0,"lost":0,"late_ends":0})");
}

TEST(CueOutputs, AfterAStopInTheMiddleNoPulseBegins) {
  const TemporaryFolder folder;
  const std::string file = folder.path() / "cues.csv";
  const Plan plan = plan_of(slide_and_pan, slider_rig);
  SessionOptions rig = simulated;
  int asked = 0;
  rig.audience.interrupted = [&] { return ++asked == 2000; };
  const RunReport report = run(plan, rig, {.cue_log = file});
  EXPECT_EQ(report.ending, Ending::stopped);
  const std::vector<Row> rows = rows_of(file);
  ASSERT_GT(rows.size(), 10U);
  ASSERT_LT(rows.size(), 280U);
  EXPECT_EQ(rows.back().line, "camera");
  for (std::size_t i = 1; i < rows.size(); ++i) EXPECT_EQ(rows[i].frame, static_cast<double>(i - 1) + 0.25);
}

TEST(CueOutputs, ARigWithoutOutputsHasNoneToLog) {
  const TemporaryFolder folder;
  const Plan plan = plan_of(in_checkout("examples/reveal.toml"), in_checkout("examples/camera_rig.toml"));
  EXPECT_THROW(run(plan, simulated, {.cue_log = folder.path() / "cues.csv"}), InputError);
}

/// The pulses of the example, the loop's ticks being the test's.
class Ticked : public testing::Test {
 protected:
  Ticked() : plan_(plan_of(slide_and_pan, slider_rig)) {
    cues_ = CueOutputs::open(plan_.move(), *plan_.rig(), {0, 288}, {0, 288}, hardware_);
  }
  static PlayheadPlace at(double frame, double rate) {
    return {.time = moved_by({0, 0.0}, frame), .rate = rate, .rate_change = 0};
  }
  /// At the drawn speed a tick of the rig, 4 ms, is 0.096 frames.
  void go(double from, double to) {
    now_ns_ += 4'000'000;
    const double rate = (to - from) / 0.096;
    cues_->tick({.from = at(from, rate), .to = at(to, rate)}, 1, now_ns_);
  }

  Plan plan_;
  SimulatedHardware hardware_{*plan_.rig(), std::vector<double>(plan_.rig()->axes.size())};
  std::unique_ptr<CueOutputs> cues_;
  std::int64_t now_ns_ = 0;
};

TEST_F(Ticked, BackwardNoLineGoesOn) {
  for (int i = 100; i > 0; --i) {
    go(i * 0.096, (i - 1) * 0.096);
    ASSERT_FALSE(cues_->is_on("camera"));
    ASSERT_FALSE(cues_->is_on("clapper"));
  }
  go(0, 0.096);
  EXPECT_TRUE(cues_->is_on("clapper"));
}

TEST_F(Ticked, TheSignalOfTheCameraIsItsLine) {
  EXPECT_FALSE(cues_->is_on("camera"));
  cues_->signal(true, 1);
  EXPECT_TRUE(cues_->is_on("camera"));
  EXPECT_FALSE(cues_->is_on("clapper"));
  cues_->signal(false, 2);
  EXPECT_FALSE(cues_->is_on("camera"));
}

TEST_F(Ticked, WhatHasBegunEndsThoughNoTickFollows) {
  go(0, 0.096);
  ASSERT_TRUE(cues_->is_on("clapper"));
  cues_->finish({});
  EXPECT_FALSE(cues_->is_on("clapper"));
  EXPECT_EQ(cues_->trouble(), "");
}

TEST(SimulatedTrigger, ComesASecondAfterItIsAskedFirst) {
  const StartSignal signal = SimulatedTrigger();
  EXPECT_FALSE(signal(5'000'000'000));
  EXPECT_FALSE(signal(5'999'999'999));
  EXPECT_TRUE(signal(6'000'000'000));
}

TEST(CueOutputs, AMoveThatStartsByATriggerWaitsASecondInSimulation) {
  const TemporaryFolder folder;
  const auto text_of = [](const std::string& path) {
    std::ifstream file(path);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const std::string move = folder.path() / "move.toml";
  const std::string rig = folder.path() / "rig.toml";
  std::ofstream(move) << "start = \"trigger\"\n" << text_of(slide_and_pan);
  std::ofstream(rig) << text_of(slider_rig)
                     << "\n[start_trigger]\nchip = \"pinctrl-bcm2711\"\nline = 4\nactive = \"low\"\nbias = "
                        "\"pull-up\"\n";
  std::vector<double> begins;
  for (const auto& [m, r] : {std::pair{slide_and_pan, slider_rig}, std::pair{move, rig}}) {
    const std::string file = folder.path() / (std::to_string(begins.size()) + ".csv");
    const Plan plan = plan_of(m, r);
    const RunReport report = run(plan, simulated, {.cue_log = file});
    EXPECT_EQ(report.ending, Ending::finished) << report.reason;
    const std::vector<Row> rows = rows_of(file);
    ASSERT_EQ(rows.size(), 290U);
    begins.push_back(rows.front().seconds);
  }
  EXPECT_NEAR(begins[1] - begins[0], 1, 0.005);
}

}  // namespace cue_outputs_test
}  // namespace inbetween
