// `run --sim`: every setpoint reaches its axis, and a move that a rig cannot make moves nothing.
#include "host_tools/motions/run.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host_tools/check/check.hpp"
#include "tests/support/places.hpp"
#include "tests/support/refused_text.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace run_test {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;
using testing::StartsWith;

const std::string reveal = in_checkout("examples/reveal.toml");
const std::string camera_rig = in_checkout("examples/camera_rig.toml");

const std::string there = R"(name = "there"
fps = "24000/1001"
frames = 12
[[track]]
axes = ["x"]
keys = [ { at = [2] }, { at = [14] } ]
speed = [0, 0, 10, 0, 0]
)";

const std::string bench = rig_text(
    {{.name = "parked", .unit = "deg", .min = 5, .max = 20, .max_velocity = 100, .max_acceleration = 10000},
     {.name = "x", .min = 2, .max = 14, .max_velocity = 100, .max_acceleration = 10000}},
    {.name = "bench"});

Plan plan_of(const std::string& move, const std::string& rig = bench) {
  return {parse_move(move, "move.toml"), parse_rig(rig, "rig.toml"), {}};
}

RunReport play_fast(const Plan& plan) {
  return run(plan, {.simulated = true, .fast = true});
}

TEST(Run, PlaysEveryTickUntilTheEndAndArrives) {
  const RunReport report = play_fast(plan_of(there));
  EXPECT_EQ(report.ending, Ending::finished);
  EXPECT_EQ(report.ticks, 52);  // 0.5005 s at 100 Hz, rounded up, and tick 0
  EXPECT_EQ(report.late_ticks, 0);
  ASSERT_THAT(report.axes, SizeIs(2));
  EXPECT_EQ(report.axes[1].name, "x");
  EXPECT_EQ(report.axes[1].unit, "mm");
  EXPECT_EQ(report.axes[1].last_commanded, 14);
  EXPECT_EQ(report.axes[1].last_actual, 14);
}

TEST(Run, AnAxisInNoTrackHoldsItsPlace) {
  const RunReport report = play_fast(plan_of(there));
  EXPECT_EQ(report.axes[0].name, "parked");
  EXPECT_EQ(report.axes[0].last_commanded, 5);
  EXPECT_EQ(report.axes[0].last_actual, 5);
  EXPECT_EQ(report.axes[0].following_error_peak, 0);
}

TEST(Run, TheFollowingErrorIsTheLargestStepOfATick) {
  const Plan plan = plan_of(there);
  const Trajectory& played = plan.motion().trajectories()[0];
  double largest = 0;
  for (std::int64_t tick = 1; tick < 52; ++tick) {
    double before = 0;
    double now = 0;
    played.positions(frame_time_of_tick(tick - 1, {24000, 1001}, 100), {&before, 1});
    played.positions(frame_time_of_tick(tick, {24000, 1001}, 100), {&now, 1});
    largest = std::max(largest, now - before);
  }
  EXPECT_EQ(play_fast(plan).axes[1].following_error_peak, largest);
}

TEST(Run, TellsItsProgressFromTheFirstTickToTheLast) {
  std::vector<std::int64_t> ticks;
  std::int64_t last_tick = 0;
  run(plan_of(there),
      {.simulated = true, .fast = true, .audience = {.progress = [&](std::int64_t tick, std::int64_t last) {
                                          ticks.push_back(tick);
                                          last_tick = last;
                                        }}});
  EXPECT_EQ(ticks.front(), 0);
  EXPECT_EQ(ticks.back(), last_tick);
  EXPECT_TRUE(std::is_sorted(ticks.begin(), ticks.end()));
}

TEST(Run, AnAxisBeyondItsLimitMovesNothing) {
  bool moved = false;
  const SessionOptions options = {
      .simulated = true, .fast = true, .audience = {.progress = [&](std::int64_t, std::int64_t) {
                                         moved = true;
                                       }}};
  const Plan plan = plan_of(with(there, "[14]", "[14.5]"));
  try {
    run(plan, options);
    FAIL() << "played";
  } catch (const LimitError& error) {
    EXPECT_THAT(error.what(), StartsWith("move.toml:5:9: error: axis \"x\" would go to 14."));
    EXPECT_THAT(error.what(), HasSubstr(" mm at frame "));
    EXPECT_THAT(error.what(),
                HasSubstr("outside 2..14 mm of the rig \"bench\"; move its keys inward by 0.5 mm; inbetween "
                          "check tries what lets it fit"));
  }
  EXPECT_FALSE(moved);
}

/// The path may leave the limits where no key does, and where no frame stands.
TEST(Run, ALimitHoldsBetweenKeysAndBetweenFramesToo) {
  const std::string keys = "keys = [ { at = [2] }, { at = [14] } ]";
  const std::string more = "spline = \"catmull-rom\"\nkeys = [ { at = [2] }, { at = [14] }, { at = [13] } ]";
  const std::string swing = with(with(there, keys, more), "12\n", "1\n");
  const Plan plan = plan_of(swing, with(bench, "rate_hz = 100", "rate_hz = 1000"));
  for (const std::int32_t frame : {0, 1}) {
    double position = 0;
    plan.tracks()[0].track().positions({frame, 0}, {&position, 1});
    EXPECT_LE(position, 14);
  }
  EXPECT_THROW(play_fast(plan), LimitError);
}

TEST(Run, OneBeyondALimitIsStatus3AndNothingIsWritten) {
  const TemporaryFolder folder;
  const std::string json = (folder.path() / "report.json").string();
  const TemporaryFile move("move.toml", with(there, "{ at = [2] }", "{ at = [1.75] }"));
  const TemporaryFile rig("rig.toml", bench);
  const std::string file = move.path().string();
  const ProgramRun run =
      run_program({"run", file, "--rig", rig.path().string(), "--sim", "--fast", "--json", json});
  EXPECT_EQ(run.status, 3);
  EXPECT_EQ(run.out, "");
  EXPECT_THAT(run.err,
              StartsWith(file + ":5:9: error: axis \"x\" would go to 1.75 mm at frame 0.00, outside "));
  EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1);
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

std::vector<std::string> fields(const Json& object) {
  std::vector<std::string> names;
  for (const auto& [name, value] : object.items()) names.push_back(name);
  return names;
}

TEST(Run, ItsReportHasTheFieldsOfItsFormatInTheirOrder) {
  const ProgramRun run = run_program({"run", reveal, "--rig", camera_rig, "--sim", "--fast", "--json", "-"});
  EXPECT_EQ(run.status, 0);
  const Json json = Json::parse(run.out);
  EXPECT_THAT(fields(json), ElementsAre("format", "ended", "reason", "ticks", "late_ticks", "axes",
                                        "wake_latency_us", "buses", "drives", "chips"));
  EXPECT_EQ(json["format"], 1);
  EXPECT_EQ(json["ended"], "finished");
  EXPECT_NE(json["reason"], "");
  EXPECT_EQ(json["ticks"], 2001);
  EXPECT_EQ(json["late_ticks"], 0);
  ASSERT_THAT(json["axes"], SizeIs(3));
  EXPECT_THAT(fields(json["axes"][0]),
              ElementsAre("name", "last_commanded", "last_actual", "following_error_peak"));
  EXPECT_EQ(json["axes"][0]["name"], "slide");
  EXPECT_EQ(json["axes"][0]["last_commanded"], 1640);
  EXPECT_EQ(json["axes"][1]["last_actual"], 32);
  EXPECT_GT(json["axes"][2]["following_error_peak"], 0);
  EXPECT_THAT(fields(json["wake_latency_us"]),
              ElementsAre("p50", "p99", "p99_9", "max", "max_at_s", "histogram"));
  ASSERT_THAT(json["buses"], SizeIs(1));
  EXPECT_THAT(fields(json["buses"][0]), ElementsAre("name", "unsent", "floods", "drained"));
  EXPECT_EQ(json["buses"][0]["name"], "can0");
  EXPECT_THAT(json["chips"], testing::IsEmpty());
  ASSERT_THAT(json["drives"], SizeIs(3));
  for (const Json& drive : json["drives"]) {
    EXPECT_THAT(fields(drive), ElementsAre("axis", "feedback", "missed", "bad_frames", "duplicates",
                                           "stray_answers", "emergencies", "foreign_frames"));
    EXPECT_GE(drive["feedback"], 2001);
    EXPECT_EQ(drive["bad_frames"], 0);
    EXPECT_EQ(drive["duplicates"], 0);
  }
}

TEST(Run, ItsSummaryShowsEveryAxisAndMakesWayForTheReport) {
  const std::vector<std::string> arguments = {"run", reveal, "--rig", camera_rig, "--sim", "--fast"};
  const ProgramRun plain = run_program(arguments);
  EXPECT_EQ(plain.err, "") << "no progress bar in a pipe";
  EXPECT_THAT(plain.out, StartsWith("reveal: "));
  EXPECT_THAT(plain.out, HasSubstr("2001 ticks at 250 Hz on a virtual clock"));
  for (const char* axis : {"slide", "pan", "tilt"}) EXPECT_THAT(plain.out, HasSubstr(axis));
  std::vector<std::string> with_json = arguments;
  with_json.insert(with_json.end(), {"--json", "-"});
  EXPECT_EQ(run_program(with_json).err, plain.out);
}

TEST(Run, AReportThatCannotBeWrittenIsSaidBeforeAnythingMoves) {
  const TemporaryFolder folder;
  const std::string json = (folder.path() / "no/such/report.json").string();
  const ProgramRun run = run_program({"run", reveal, "--rig", camera_rig, "--sim", "--fast", "--json", json},
                                     {.out_path = {}, .err_path = {}, .err_on_terminal = true});
  EXPECT_EQ(run.status, 1);
  EXPECT_EQ(run.out, "");
  EXPECT_THAT(run.err, StartsWith(json + ": error: cannot be written: "));
}

TEST(ProgressBar, FillsOneLineOfATerminal) {
  const ProgramRun run = run_program({"run", reveal, "--rig", camera_rig, "--sim", "--fast"},
                                     {.out_path = {}, .err_path = {}, .err_on_terminal = true});
  EXPECT_EQ(run.status, 0);
  EXPECT_THAT(run.err, StartsWith("\r[........................................] frame 0/192  0.0 s"));
  EXPECT_THAT(run.err, HasSubstr("\r[########################################] frame 192/192  8.0 s"));
  EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << "the line is ended once";
  EXPECT_EQ(run.err.back(), '\n');
}

}  // namespace run_test
}  // namespace inbetween
