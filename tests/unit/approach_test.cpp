// The slow way of a rig from where it stands to where a move starts.
#include "host_tools/motions/approach.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "host_tools/check/check.hpp"
#include "host_tools/motions/run.hpp"
#include "tests/support/places.hpp"
#include "tests/support/run_program.hpp"

namespace inbetween {
namespace approach_test {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

const std::string reveal = in_checkout("examples/reveal.toml");
const std::string camera_rig = in_checkout("examples/camera_rig.toml");

Plan example() {
  return {read_move_file(reveal), read_rig_file(camera_rig), {}};
}

std::vector<double> ends_of(const Plan& plan, const FrameTime<double>& time) {
  std::vector<double> at(plan.played().axis_count());
  plan.played().positions(time, at);
  return at;
}

TEST(Approach, IsNotNeededWhereTheRigStandsAtTheStart) {
  const Plan plan = example();
  EXPECT_FALSE(plan_approach(plan, std::vector<double>{60, -62, -4}));
  EXPECT_FALSE(plan_approach(plan, std::vector<double>{60 + 1e-6, -62, -4})) << "within a tick";
}

TEST(Approach, LeadsFromWhereTheRigStandsToTheStartAndRestsAtBothEnds) {
  const Plan plan = example();
  const std::vector<double> standing{0, 10, -4};
  const std::optional<Plan> approach = plan_approach(plan, standing);
  ASSERT_TRUE(approach);
  ASSERT_EQ(approach->played().axis_count(), 2U) << "the tilt stands there already";
  EXPECT_EQ(ends_of(*approach, {0, 0}), (std::vector<double>{0, 10}));
  EXPECT_EQ(ends_of(*approach, {approach->move().frames, 0}), (std::vector<double>{60, -62}));
  EXPECT_EQ(approach->played().first_frame(), 0);
  EXPECT_EQ(approach->played().last_frame(), approach->move().frames);
}

TEST(Approach, StaysWithinATenthOfTheLimitsAndIsNoSlowerThanThat) {
  const Plan plan = example();
  const std::optional<Plan> approach = plan_approach(plan, std::vector<double>{900, 10, 9});
  ASSERT_TRUE(approach);
  const CheckReport report = check(*approach);
  EXPECT_TRUE(report.fits());
  double most = 0;
  for (std::size_t a = 0; a < report.axes.size(); ++a) {
    const RigAxis& limits = plan.rig()->axes[a];
    const double velocity = report.axes[a].velocity.value / limits.max_velocity;
    const double acceleration = report.axes[a].acceleration.value / limits.max_acceleration;
    EXPECT_LE(velocity, approach_share);
    EXPECT_LE(acceleration, approach_share);
    most = std::max({most, velocity, acceleration});
    if (limits.max_jerk) most = std::max(most, report.axes[a].jerk.value / *limits.max_jerk);
  }
  EXPECT_GT(most, 0.97 * approach_share) << "one frame less would be too quick";
}

TEST(Approach, FromOutsideTheLimitsIsRefusedAtTheAxis) {
  const Plan plan = example();
  try {
    plan_approach(plan, std::vector<double>{-5, -62, -4});
    FAIL() << "planned";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(),
                AllOf(HasSubstr("axis \"slide\" stands at -5 mm, outside its limits"), HasSubstr("by hand")));
  }
}

TEST(Approach, IsDescribedForSomebodyWhoHasToAgree) {
  const Plan plan = example();
  const std::string words = describe_approach(*plan_approach(plan, std::vector<double>{0, 10, -4}));
  EXPECT_THAT(words, StartsWith("the rig is not where the move starts:\n  slide"));
  EXPECT_THAT(words, HasSubstr("10.000 -> -62.000 deg"));
  EXPECT_THAT(words, HasSubstr("at 10 % of its limits at most"));
}

/// Of so many counts to a mm, at 1000 Hz and 400 mm/s^2: in a tick the acceleration covers 0.0004 mm.
Plan quick_plan(int counts_per_mm) {
  const std::string rig =
      "name = \"quick\"\nrate_hz = 1000\n[[axis]]\nname = \"slide\"\nunit = \"mm\"\nmin = 0\nmax = 1000\n"
      "max_velocity = 200\nmax_acceleration = 400\ndrive = { type = \"pipe\", path = \"/dev/null\", "
      "counts_per_unit = " +
      std::to_string(counts_per_mm) + " }\n";
  const std::string move =
      "name = \"short\"\nfps = 24\nframes = 96\n[[track]]\naxes = [\"slide\"]\n"
      "keys = [ { at = [10.001] }, { at = [100] } ]\nspeed = [0, 0, 10, 0, 0]\n";
  return {parse_move(move, "move.toml"), parse_rig(rig, "rig.toml"), {}};
}

TEST(Approach, IsNotNeededWithinACountOfTheDrive) {
  const Plan plan = quick_plan(1000);
  EXPECT_FALSE(plan_approach(plan, std::vector<double>{10.0005})) << "half a count";
  EXPECT_FALSE(plan_approach(plan, std::vector<double>{10.002})) << "a count";
  EXPECT_TRUE(plan_approach(plan, std::vector<double>{10.0031}));
  EXPECT_TRUE(plan_approach(quick_plan(100'000), std::vector<double>{10.0005})) << "many counts";
}

TEST(Approach, ARigThatRestsHalfACountFromTheStartPlaysTheMove) {
  const Plan plan = quick_plan(1000);
  const RunReport report =
      run(plan, {.simulated = true, .fast = true, .standing = {{"slide", 10.0005}}, .audience = {}});
  EXPECT_EQ(report.ending, Ending::finished);
}

TEST(Approach, ItsWordsShowTheDigitsThatDiffer) {
  const Plan plan = quick_plan(100'000);
  const std::string words = describe_approach(*plan_approach(plan, std::vector<double>{10.0005}));
  EXPECT_THAT(words, HasSubstr("10.0005 -> 10.0010 mm"));
}

const std::vector<std::string> from_elsewhere{"run",    reveal,   "--rig",  camera_rig, "--sim",
                                              "--fast", "--from", "pan=10", "--from",   "slide=0"};

// docs/faults.md 27
TEST(Approach, WithoutSomebodyWhoAgreesNothingMoves) {
  const ProgramRun run = run_program(from_elsewhere);
  EXPECT_EQ(run.status, 1);
  EXPECT_EQ(run.out, "");
  EXPECT_THAT(run.err, HasSubstr("axis \"slide\" of the rig is not where the move starts"));
  EXPECT_THAT(run.err, HasSubstr("--yes"));
}

TEST(Approach, WithYesTheRigGoesThereAndThenPlaysTheMove) {
  std::vector<std::string> arguments = from_elsewhere;
  arguments.emplace_back("--yes");
  const ProgramRun run = run_program(arguments);
  EXPECT_EQ(run.status, 0);
  EXPECT_THAT(run.err, HasSubstr("slide"));
  EXPECT_THAT(run.err, HasSubstr("it goes there in"));
  EXPECT_THAT(run.out, HasSubstr("2001 ticks at 250 Hz")) << "the ticks of the move";
  EXPECT_THAT(run.out, HasSubstr("1640.0000"));
}

TEST(Approach, OneThatIsDeclinedMovesNothing) {
  const Plan plan = example();
  const RunReport report = run(plan, {.simulated = true,
                                      .fast = true,
                                      .standing = {{"pan", 10}},
                                      .audience = {.confirm = [](const std::string&) { return false; }}});
  EXPECT_EQ(report.ending, Ending::stopped);
  EXPECT_EQ(report.ticks, 0);
  EXPECT_EQ(report.axes[1].last_actual, 10);
}

TEST(Approach, CanBeStoppedAndLeft) {
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

TEST(Approach, AnAxisThatTheRigDoesNotHaveIsRefused) {
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

}  // namespace approach_test
}  // namespace inbetween
