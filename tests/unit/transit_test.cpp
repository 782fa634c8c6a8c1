// The transit of a rig, and that of a run to where its move starts.
#include "host_tools/motions/transit.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/motions/run.hpp"
#include "host_tools/motions/run_checks.hpp"
#include "host_tools/plan/move_rolls.hpp"
#include "tests/support/places.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace transit_test {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

const std::string reveal = in_checkout("examples/reveal.toml");
const std::string camera_rig = in_checkout("examples/camera_rig.toml");

Plan example() {
  return {read_move_file(reveal), read_rig_file(camera_rig), {}};
}

/// The axes of a transit, tick by tick until it rests.
std::vector<std::vector<Setpoint>> played(Transit& transit, int stopped_at = -1) {
  std::vector<std::vector<Setpoint>> ticks;
  while (!transit.is_resting()) {
    if (static_cast<int>(ticks.size()) == stopped_at) transit.stop();
    transit.tick(0, ticks.emplace_back(transit.axes().size()));
  }
  return ticks;
}

/// The highest of the n-th differences of an axis from tick `from` on, in unit/s^n.
double highest_difference(const std::vector<std::vector<Setpoint>>& ticks, std::size_t axis, int order,
                          std::size_t from = 0) {
  std::vector<double> values;
  for (std::size_t i = from; i < ticks.size(); ++i) values.push_back(ticks[i][axis].position);
  for (int i = 0; i < order; ++i) {
    for (std::size_t k = 0; k + 1 < values.size(); ++k) values[k] = (values[k + 1] - values[k]) * 250;
    values.pop_back();
  }
  double highest = 0;
  for (const double value : values) highest = std::max(highest, std::fabs(value));
  return highest;
}

TEST(Transit, IsNotNeededWhereTheRigStandsAtTheStart) {
  const Plan plan = example();
  EXPECT_TRUE(away_from_start(plan, std::vector<double>{60, -62, -4}).empty());
  EXPECT_TRUE(away_from_start(plan, std::vector<double>{60 + 1e-6, -62, -4}).empty()) << "within a tick";
}

TEST(Transit, LeadsOnAStraightLineFromWhereTheRigStandsToTheStart) {
  const Plan plan = example();
  const std::vector<double> standing{0, 10, -4};
  const std::vector<GoTarget> away = away_from_start(plan, standing);
  ASSERT_EQ(away.size(), 2U) << "the tilt stands there already";
  Transit transit(*plan.rig(), away, standing, transit_share);
  const auto ticks = played(transit);
  EXPECT_EQ(static_cast<std::int64_t>(ticks.size()), transit.ticks());
  EXPECT_NEAR(ticks.front()[0].position, 0, 1e-3);
  for (const auto& tick : ticks) {
    EXPECT_NEAR(tick[1].position, 10 - 72 * tick[0].position / 60, 1e-9);
    EXPECT_NEAR(tick[1].velocity, -72 * tick[0].velocity / 60, 1e-9);
  }
  EXPECT_EQ(ticks.back()[0].position, 60);
  EXPECT_EQ(ticks.back()[1].position, -62);
  EXPECT_EQ(ticks.back()[0].velocity, 0);
}

TEST(Transit, StaysWithinATenthOfTheLimitsAndIsNoSlowerThanThat) {
  const Plan plan = example();
  const std::vector<double> standing{900, 10, 9};
  Transit transit(*plan.rig(), away_from_start(plan, standing), standing, transit_share);
  const auto ticks = played(transit);
  double most = 0;
  for (std::size_t i = 0; i < transit.axes().size(); ++i) {
    const RigAxis& limits = plan.rig()->axes[transit.axes()[i]];
    const double velocity = highest_difference(ticks, i, 1) / limits.max_velocity;
    const double acceleration = highest_difference(ticks, i, 2) / limits.max_acceleration;
    EXPECT_LE(velocity, transit_share * (1 + 1e-9));
    EXPECT_LE(acceleration, transit_share * (1 + 1e-6));
    most = std::max({most, velocity, acceleration});
  }
  EXPECT_GT(most, 0.999 * transit_share);
}

TEST(Transit, AStopStaysOnTheLineAndIsAsQuickAsAnyOfTheRig) {
  const Plan plan = example();
  const std::vector<double> standing{900, 10, 9};
  Transit transit(*plan.rig(), away_from_start(plan, standing), standing, transit_share);
  const auto ticks = played(transit, 1000);
  const RigAxis& slide = plan.rig()->axes[0];
  const double slide_travel = 60 - 900;
  double hardest = 0;
  for (std::size_t i = 0; i < transit.axes().size(); ++i) {
    const RigAxis& axis = plan.rig()->axes[transit.axes()[i]];
    const double stop = limits_of(axis).stop_acceleration();
    const double acceleration = highest_difference(ticks, i, 2, 990);
    EXPECT_LE(acceleration, stop * (1 + 1e-6));
    hardest = std::max(hardest, acceleration / axis.max_acceleration);
    const double end = ticks.back()[i].position, target = away_from_start(plan, standing)[i].position;
    EXPECT_NEAR((end - standing[transit.axes()[i]]) / (target - standing[transit.axes()[i]]),
                (ticks.back()[0].position - 900) / slide_travel, 1e-9);
  }
  EXPECT_GT(hardest, 2 * transit_share) << "harder than it speeds up";
  const double seconds = static_cast<double>(ticks.size() - 1000) / 250;
  EXPECT_LT(seconds, 0.5 * slide.max_velocity / slide.max_acceleration + 0.2);
}

TEST(Transit, AStopTakesNoMoreJerkThanAStopMay) {
  const RigFile rig = parse_rig(
      rig_text({{.name = "slide", .more = "max_jerk = 2000\nstop_acceleration = 900\nstop_jerk = 2000"}},
               {.rate_hz = 250}),
      "rig.toml");
  Transit transit(rig, std::vector<GoTarget>{{.axis = 0, .position = 190}}, std::vector<double>{0},
                  transit_share);
  const double jerk = highest_difference(played(transit, 1000), 0, 3, 990);
  EXPECT_LE(jerk, 2000 * (1 + 1e-6));
  EXPECT_GT(jerk, 1500);
}

TEST(Transit, FromOutsideTheLimitsIsRefusedAtTheAxis) {
  const Plan plan = example();
  EXPECT_THAT(
      [&] {
        away_from_start(plan, std::vector<double>{-5, -62, -4});
      },
      testing::ThrowsMessage<InputError>(
          AllOf(HasSubstr("axis \"slide\" stands at -5 mm, outside its limits"),
                HasSubstr("bring it in with inbetween goto --rig "))));
}

TEST(Transit, IsDescribedForSomebodyWhoHasToAgree) {
  const Plan plan = example();
  const std::vector<double> standing{0, 10, -4};
  const std::string words = Transit(*plan.rig(), away_from_start(plan, standing), standing, transit_share)
                                .describe("the rig is not where the move starts:");
  EXPECT_THAT(words, StartsWith("the rig is not where the move starts:\n  slide"));
  EXPECT_THAT(words, HasSubstr("10.000 -> -62.000 deg"));
  EXPECT_THAT(words, HasSubstr("at 10 % of its limits at most"));
}

/// A drive of so many counts to a mm, at 1000 Hz and 400 mm/s^2: in a tick the acceleration covers 0.0004 mm.
Plan quick_plan(int counts_per_mm) {
  const std::string rig = rig_text(
      {axis_text("slide", "mm", {0, 1000}, {.velocity = 200}, "",
                 fmt::format(R"(type = "pipe", path = "/dev/null", counts_per_unit = {})", counts_per_mm))},
      {.rate_hz = 1000});
  const std::string move =
      "name = \"short\"\nfps = 24\nframes = 96\n[[track]]\naxes = [\"slide\"]\n"
      "keys = [ { at = [10.001] }, { at = [100] } ]\nspeed = [0, 0, 10, 0, 0]\n";
  return {parse_move(move, "move.toml"), parse_rig(rig, "rig.toml"), {}};
}

TEST(TransitToTheStart, IsNotNeededWithinACountOfTheDrive) {
  const Plan plan = quick_plan(1000);
  EXPECT_TRUE(away_from_start(plan, std::vector<double>{10.0005}).empty()) << "half a count";
  EXPECT_TRUE(away_from_start(plan, std::vector<double>{10.002}).empty()) << "a count";
  EXPECT_FALSE(away_from_start(plan, std::vector<double>{10.0031}).empty());
  EXPECT_FALSE(away_from_start(quick_plan(100'000), std::vector<double>{10.0005}).empty()) << "many counts";
}

TEST(TransitToTheStart, ARigThatRestsHalfACountFromTheStartPlaysTheMove) {
  const Plan plan = quick_plan(1000);
  const RunReport report =
      run(plan, {.simulated = true, .fast = true, .standing = {{"slide", 10.0005}}, .audience = {}});
  EXPECT_EQ(report.ending, Ending::finished);
}

TEST(TransitToTheStart, ItsWordsShowTheDigitsThatDiffer) {
  const Plan plan = quick_plan(100'000);
  const std::vector<double> standing{10.0005};
  const Transit transit(*plan.rig(), away_from_start(plan, standing), standing, transit_share);
  EXPECT_THAT(transit.describe(""), HasSubstr("10.0005 -> 10.0010 mm"));
}

const std::vector<std::string> from_elsewhere{"run",    reveal,   "--rig",  camera_rig, "--sim",
                                              "--fast", "--from", "pan=10", "--from",   "slide=0"};

// docs/faults.md 27
TEST(TransitToTheStart, WithoutSomebodyWhoAgreesNothingMoves) {
  const ProgramRun run = run_program(from_elsewhere);
  EXPECT_EQ(run.status, 1);
  EXPECT_EQ(run.out, "");
  EXPECT_THAT(run.err, HasSubstr("axis \"slide\" of the rig is not where the move starts"));
  EXPECT_THAT(run.err, HasSubstr("--yes"));
}

TEST(TransitToTheStart, WithYesTheRigGoesThereAndThenPlaysTheMove) {
  std::vector<std::string> arguments = from_elsewhere;
  arguments.emplace_back("--yes");
  const ProgramRun run = run_program(arguments);
  EXPECT_EQ(run.status, 0);
  EXPECT_THAT(run.err, HasSubstr("slide"));
  EXPECT_THAT(run.err, HasSubstr("it goes there in"));
  EXPECT_THAT(run.out, HasSubstr("2001 ticks at 250 Hz")) << "the ticks of the move";
  EXPECT_THAT(run.out, HasSubstr("1640.0000"));
}

TEST(TransitToTheStart, IsAsFastAsItWasSaidAndNoFasterThanTheLimits) {
  const Plan plan = example();
  const TemporaryFolder folder;
  std::string question;
  const auto fastest_of = [&](double share) {
    SessionOptions rig{.simulated = true, .fast = true, .standing = {{"slide", 900}}};
    rig.record = (folder.path() / fmt::format("transit{}.csv", share)).string();
    rig.audience.confirm = [&](const std::string& asked) {
      question = asked;
      return true;
    };
    // Stopped before the move, so that the record is of the transit alone.
    int tick = 0;
    rig.audience.keys = [&] { return ++tick == 400 ? "q" : ""; };
    EXPECT_EQ(run(plan, rig, {.start_share = share}).ending, Ending::stopped);
    std::ifstream file(*rig.record);
    std::string line;
    double fastest = 0;
    std::optional<double> before;
    std::getline(file, line);
    while (std::getline(file, line)) {
      std::size_t slide = 0;
      for (int columns = 0; columns < 4; ++columns) slide = line.find(',', slide) + 1;
      if (line[slide] == ',') continue;  // told nothing
      const double told = std::stod(line.substr(slide));
      if (before) fastest = std::max(fastest, std::fabs(told - *before) * plan.rig()->rate_hz);
      before = told;
    }
    return fastest;
  };
  const double max_velocity = plan.rig()->axes[0].max_velocity;
  EXPECT_NEAR(fastest_of(transit_share), 0.1 * max_velocity, 0.01 * max_velocity);
  EXPECT_THAT(question, HasSubstr("at 10 % of its limits at most"));
  const double half = fastest_of(0.5);
  EXPECT_LE(half, 0.5 * max_velocity * (1 + 1e-6));
  EXPECT_GT(half, 0.2 * max_velocity);
  EXPECT_THAT(question, HasSubstr("at 50 % of its limits at most"));
}

TEST(TransitToTheStart, ASpeedBeyondTheLimitsIsRefused) {
  for (const char* speed : {"1.01", "0", "-1", "x"}) {
    std::vector<std::string> arguments = from_elsewhere;
    arguments.insert(arguments.end(), {"--yes", "--speed", speed});
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.status, 2) << speed;
    EXPECT_THAT(run.err, HasSubstr("--speed")) << speed;
  }
  const ProgramRun jitter =
      run_program({"run", reveal, "--rig", camera_rig, "--allow-jitter", "--speed", "0.2"});
  EXPECT_EQ(jitter.status, 2);
  EXPECT_THAT(jitter.err, HasSubstr("with --allow-jitter --speed is 0.1 at most"));
}

TEST(TransitToTheStart, OneThatIsDeclinedMovesNothing) {
  const Plan plan = example();
  const RunReport report = run(plan, {.simulated = true,
                                      .fast = true,
                                      .standing = {{"pan", 10}},
                                      .audience = {.confirm = [](const std::string&) { return false; }}});
  EXPECT_EQ(report.ending, Ending::stopped);
  EXPECT_EQ(report.ticks, 0);
  EXPECT_EQ(report.axes[1].last_actual, 10);
}

TEST(TransitToTheStart, CanBeStoppedAndLeft) {
  const Plan plan = example();
  int tick = 0;
  const RunReport report = run(plan, {.simulated = true,
                                      .fast = true,
                                      .standing = {{"pan", 10}},
                                      .audience = {.keys = [&] { return ++tick == 200 ? "q" : ""; },
                                                   .confirm = [](const std::string&) { return true; }}});
  EXPECT_EQ(report.ending, Ending::stopped);
  EXPECT_THAT(report.reason, HasSubstr("stopped before its end"));
  EXPECT_LT(report.axes[1].last_actual, 10);
  EXPECT_GT(report.axes[1].last_actual, -62);
}

TEST(TransitToTheStart, AnAxisThatTheRigDoesNotHaveIsRefused) {
  const ProgramRun run =
      run_program({"run", reveal, "--rig", camera_rig, "--sim", "--fast", "--from", "roll=1"});
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.err, HasSubstr("has no axis \"roll\""));
  for (const char* wrong : {"pan", "pan=", "pan=x", "pan=1e999", "pan=nan"}) {
    const ProgramRun usage =
        run_program({"run", reveal, "--rig", camera_rig, "--sim", "--fast", "--from", wrong});
    EXPECT_EQ(usage.status, 2) << wrong;
    EXPECT_THAT(usage.err, HasSubstr("write AXIS=POSITION")) << wrong;
  }
  const ProgramRun twice = run_program(
      {"run", reveal, "--rig", camera_rig, "--sim", "--fast", "--from", "pan=1", "--from", "pan=2"});
  EXPECT_EQ(twice.status, 2);
}

}  // namespace transit_test
}  // namespace inbetween
