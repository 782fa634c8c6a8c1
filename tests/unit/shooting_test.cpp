// `run --step` and `run --shutter`: keys, the camera, and what is refused.
#include "host_tools/motions/shooting.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "host_tools/motions/run.hpp"
#include "tests/support/places.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace shooting_test {

using testing::HasSubstr;

const std::string reveal = in_checkout("examples/reveal.toml");
const std::string camera_rig = in_checkout("examples/camera_rig.toml");

ProgramRun run_with(std::vector<std::string> more) {
  std::vector<std::string> arguments{"run", reveal, "--rig", camera_rig, "--sim", "--fast"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_program(arguments);
}

TEST(Shooting, WithoutAKeyboardTheCameraAsksForEveryFrame) {
  const ProgramRun run = run_with({"--step", "--json", "-"});
  EXPECT_EQ(run.status, 0);
  const auto json = nlohmann::ordered_json::parse(run.out);
  EXPECT_EQ(json["exposures"], 193) << "frames 0..192";
  EXPECT_EQ(json["ended"], "finished");
  EXPECT_EQ(json["axes"][0]["last_actual"], 1640);
  EXPECT_GT(json["ticks"], 193 * (125 + 25)) << "half a second of settling and a tenth of exposing each";
  EXPECT_THAT(run.err, HasSubstr("every frame was shot"));
  EXPECT_THAT(run.err, HasSubstr("193 frames exposed"));
}

TEST(Shooting, InMotionEveryFrameIsExposedToo) {
  const ProgramRun run = run_with(
      {"--shutter", "0..180", "--exposure", "0.5", "--settle", "0.1", "--still", "tilt", "--json", "-"});
  EXPECT_EQ(run.status, 0);
  EXPECT_EQ(nlohmann::ordered_json::parse(run.out)["exposures"], 193);
}

/// The largest second difference of what the slide was told, over a tick squared, in mm/s^2.
double max_acceleration_told(const std::vector<std::string>& more) {
  const TemporaryFolder folder;
  const std::string record = folder.path() / "record.csv";
  std::vector<std::string> arguments = more;
  arguments.insert(arguments.end(), {"--record", record});
  EXPECT_EQ(run_with(arguments).status, 0);
  std::ifstream file(record);
  std::string line;
  std::getline(file, line);
  std::vector<double> told;
  while (std::getline(file, line)) {
    std::istringstream cells(line);
    std::string cell;
    for (int i = 0; i < 4; ++i) std::getline(cells, cell, ',');
    if (!cell.empty()) told.push_back(std::stod(cell));
  }
  double most = 0;
  for (std::size_t i = 2; i < told.size(); ++i) {
    most = std::max(most, std::fabs(told[i] - 2 * told[i - 1] + told[i - 2]) * 250 * 250);
  }
  return most;
}

TEST(Shooting, TheExampleKeepsItsMotionLimitsAtRestAndInMotion) {
  constexpr double max_acceleration = 800.001;
  EXPECT_LE(max_acceleration_told({"--step", "--settle", "0"}), max_acceleration);
  const double in_motion = max_acceleration_told({"--shutter", "-90..90", "--exposure", "0.05"});
  EXPECT_LE(in_motion, max_acceleration);
  EXPECT_GT(in_motion, 600) << "and is not slower than it need be";
}

/// Shoots the example with a keyboard, typing `typed[i].second` before tick `typed[i].first`.
RunReport shoot_typing(const std::vector<std::pair<int, std::string>>& typed,
                       std::vector<std::string>* lines) {
  const Plan plan(read_move_file(reveal), read_rig_file(camera_rig), {});
  int tick = 0;
  std::size_t next = 0;
  return run(plan,
             {.simulated = true,
              .fast = true,
              .audience = {.keys =
                               [&] {
                                 const bool now = next < typed.size() && typed[next].first == tick;
                                 ++tick;
                                 return now ? typed[next++].second : std::string();
                               },
                           .status =
                               [&](const RunSnapshot& now) {
                                 if (lines != nullptr) lines->push_back(status_line(now));
                               }}},
             {.shoot = ShootOptions{.settle_s = 0.1, .exposure_s = 0.1}});
}

TEST(Shooting, WithAKeyboardItWaitsForSpace) {
  const RunReport report = shoot_typing({{5000, " "}, {10000, " "}, {20000, "q"}}, nullptr);
  EXPECT_EQ(report.ending, Ending::stopped);
  EXPECT_EQ(report.exposures, 3);
  EXPECT_GE(report.ticks, 20000);
}

TEST(Shooting, OtherFramesAreLookedAtWithoutBeingExposed) {
  const RunReport report =
      shoot_typing({{5000, "\x1b[C"}, {6000, "\x1b[C"}, {7000, "\x1b[D"}, {8000, " "}, {9000, "q"}}, nullptr);
  EXPECT_EQ(report.exposures, 2);
}

TEST(Shooting, AStopIsAcknowledgedAndTheFrameShotAgain) {
  const RunReport report = shoot_typing(
      {{5000, " "}, {5003, "\x1b"}, {6000, " "}, {6100, "\r"}, {6200, "a"}, {6300, "\r"}, {9000, "q"}},
      nullptr);
  EXPECT_EQ(report.exposures, 2) << "frame 0, and frame 1 after the stop";
  EXPECT_EQ(report.ending, Ending::stopped);
}

TEST(Shooting, AnExposureThatIsTooShortIsRefusedWithItsFrameAndNothingMoves) {
  const ProgramRun run = run_with({"--shutter", "0..180", "--exposure", "0.02"});
  EXPECT_EQ(run.status, 3);
  EXPECT_EQ(run.out, "");
  EXPECT_THAT(run.err, HasSubstr("reveal.toml:5:"));
  EXPECT_THAT(run.err, HasSubstr("frame 0 cannot be exposed in motion"));
  EXPECT_THAT(run.err, HasSubstr("expose longer"));
}

TEST(Shooting, OptionsThatMakeNoSenseTogetherAreWrongUsage) {
  struct Wrong {
    std::vector<std::string> arguments;
    const char* words;
  };
  const std::vector<Wrong> wrong{
      {{"--exposure", "1"}, "belong to --step or --shutter"},
      {{"--settle", "1"}, "belong to --step or --shutter"},
      {{"--still", "pan"}, "belong to --step or --shutter"},
      {{"--step", "--still", "pan"}, "every axis stands still"},
      {{"--shutter", "0..180"}, "--exposure SECONDS"},
      {{"--shutter", "180", "--exposure", "1"}, "OPEN..CLOSE"},
      {{"--shutter", "180..0", "--exposure", "1"}, "OPEN..CLOSE"},
      {{"--shutter", "0..361", "--exposure", "1"}, "OPEN..CLOSE"},
      {{"--shutter", "-300..300", "--exposure", "1"}, "OPEN..CLOSE"},
      {{"--shutter", "nan..1", "--exposure", "1"}, "OPEN..CLOSE"},
      {{"--step", "--settle", "-1"}, "--settle"},
      {{"--step", "--exposure", "0"}, "--exposure"},
      {{"--top-rate", "0.5"}, "--top-rate"},
  };
  for (const Wrong& one : wrong) {
    const ProgramRun run = run_with(one.arguments);
    EXPECT_EQ(run.status, 2) << one.words;
    EXPECT_THAT(run.err, HasSubstr(one.words));
  }
  const ProgramRun repeated = run_program({"run", reveal, "--rig", camera_rig, "--sim", "--step", "--loop"});
  EXPECT_EQ(repeated.status, 2);
}

TEST(Shooting, AnAxisThatTheRigDoesNotHaveCannotStandStill) {
  const ProgramRun run = run_with({"--shutter", "0..180", "--exposure", "0.5", "--still", "roll"});
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.err, HasSubstr("has no axis \"roll\""));
}

TEST(Rate, BeginsSlowerThanDrawn) {
  const ProgramRun run = run_with({"--rate", "0.25", "--json", "-"});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(nlohmann::ordered_json::parse(run.out)["ticks"], 8001) << "2 000 and one to arrive, at a quarter";
  EXPECT_EQ(run_with({"--rate", "0"}).status, 2);
  EXPECT_EQ(run_with({"--rate", "1.5"}).status, 2);
  EXPECT_EQ(run_with({"--rate", "0.5", "--step"}).status, 2);
}

TEST(TopRate, AboveWhatIsCertifiedIsRefusedWithTheHighest) {
  const ProgramRun run = run_with({"--top-rate", "9"});
  EXPECT_EQ(run.status, 3);
  EXPECT_THAT(run.err, HasSubstr("at 9 times the drawn speed the move leaves the limits of the rig; lower "
                                 "--top-rate to 1.133 or less"));
}

TEST(TopRate, LetsTheOverrideGoAboveTheDrawnSpeed) {
  const Plan plan(read_move_file(reveal), read_rig_file(camera_rig), {});
  int tick = 0;
  const RunReport report = run(
      plan, {.simulated = true, .fast = true, .audience = {.keys = [&] { return tick++ == 0 ? "+++" : ""; }}},
      {.top_rate = 1.1});
  EXPECT_EQ(report.ending, Ending::finished);
  EXPECT_NEAR(static_cast<double>(report.ticks), 2001 / 1.1, 30);
}

}  // namespace shooting_test
}  // namespace inbetween
