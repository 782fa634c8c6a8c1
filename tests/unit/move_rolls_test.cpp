// Moves that start or end moving: the rolls that plan, check and run give them.
#include "host_tools/plan/move_rolls.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "host_tools/check/check.hpp"
#include "host_tools/check/check_frames.hpp"
#include "host_tools/motions/run.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/roll_keeps.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace move_rolls_test {

using Json = nlohmann::ordered_json;
using testing::HasSubstr;
using testing::SizeIs;

/// Two axes, track and tilt; `min` is that of the track.
std::string rig_of(double min = 0, const std::string& jerk = "max_jerk = 8000") {
  std::vector<AxisText> axes{{.name = "tilt", .unit = "deg", .min = -90}, {.name = "track", .min = min}};
  for (AxisText& axis : axes) {
    axis.max = 1500;
    axis.max_velocity = 400;
    axis.max_acceleration = 800;
    axis.more = jerk;
  }
  return rig_text(axes, {.name = "crane", .rate_hz = 250});
}

std::string move_of(const std::string& speed, const std::string& keys = "[300], [500], [900]",
                    int frames = 120) {
  std::string list;
  std::istringstream split(keys);
  for (std::string key; std::getline(split, key, ',');) {
    list += fmt::format("{}{{ at = {} }}", list.empty() ? "" : ", ", key);
  }
  return fmt::format(
      "name = \"pass by\"\nfps = 24\nframes = {}\n[[track]]\naxes = [\"track\"]\nkeys = [ {} ]\nspeed = "
      "[{}]\n",
      frames, list, speed);
}

Plan plan_of(const std::string& move, const std::string& rig = rig_of()) {
  return {parse_move(move, "move.toml"), parse_rig(rig, "rig.toml"), {}};
}

AxisMotion motion_at(const Plan& plan, double frame) {
  std::vector<AxisMotion> motion(plan.played().axis_count());
  const double whole = std::floor(frame);
  plan.motion().motion({static_cast<std::int32_t>(whole), frame - whole}, motion);
  return motion.front();
}

TEST(Rolls, AMoveThatIsAtRestAtItsEndsHasNone) {
  const Plan plan = plan_of(move_of("0, 0, 10, 0, 0"));
  EXPECT_EQ(plan.played().first_frame(), 0);
  EXPECT_EQ(plan.played().last_frame(), 120);
  EXPECT_THAT(plan.roll_obstacles(), SizeIs(0));
}

TEST(Rolls, AMoveWithoutARigHasNoneBecauseNobodyKnowsItsLimits) {
  const Plan plan(parse_move(move_of("5, 10, 5"), "move.toml"), std::nullopt, {});
  EXPECT_EQ(plan.played().first_frame(), 0);
  EXPECT_EQ(plan.played().last_frame(), 120);
}

TEST(Rolls, AMoveThatStartsAndEndsMovingIsBroughtUpAndDownInsideItsLimits) {
  const Plan plan = plan_of(move_of("5, 10, 5"));
  EXPECT_LT(plan.played().first_frame(), 0);
  EXPECT_GT(plan.played().last_frame(), 120);
  const CheckReport report = check(plan);
  EXPECT_TRUE(report.fits());
  EXPECT_THAT(report.steps, SizeIs(0));
  const CheckedAxis& track = report.axes[1];
  EXPECT_EQ(track.range->lowest.frame, plan.played().first_frame());
  EXPECT_LT(track.range->lowest.value, 300);
  EXPECT_EQ(track.range->highest.frame, plan.played().last_frame());
  EXPECT_GT(track.range->highest.value, 900);
  double acceleration = 0;
  double jerk = 0;
  for (double frame = plan.played().first_frame(); frame <= plan.played().last_frame(); frame += 1.0 / 64) {
    acceleration = std::max(acceleration, std::abs(motion_at(plan, frame).acceleration));
    jerk = std::max(jerk, std::abs(motion_at(plan, frame).jerk));
  }
  EXPECT_LE(acceleration, track.acceleration.value);
  EXPECT_LE(track.acceleration.value, 1.01 * acceleration);
  EXPECT_LE(jerk, track.jerk.value);
  EXPECT_LE(track.jerk.value, 1.01 * jerk);
}

TEST(Rolls, OneFrameLessWouldBreakALimit) {
  const Plan plan = plan_of(move_of("5, 10, 5"));
  std::vector<AxisMotion> joints(1);
  ASSERT_TRUE(joints_of(plan.track_views(), RollEnd::before, std::span(joints)));
  const RollRequest request{RollEnd::before, 0, {24, 1}, joints, plan.limits()};
  const std::int32_t frames = -plan.played().first_frame();
  EXPECT_TRUE(roll_keeps(request, frames));
  EXPECT_FALSE(roll_keeps(request, frames - 1));
}

TEST(Rolls, EveryAxisOfEveryTrackRollsInTheSameFrames) {
  const std::string move =
      move_of("5, 10, 0, 0") +
      "[[track]]\naxes = [\"tilt\"]\nkeys = [ { at = [0] }, { at = [10] } ]\nspeed = [0, "
      "0, 10, 10]\n";
  const Plan plan = plan_of(move);
  ASSERT_THAT(plan.played().rolls().before, SizeIs(2));
  ASSERT_THAT(plan.played().rolls().after, SizeIs(2));
  EXPECT_EQ(plan.played().rolls().before[1].rest_position(), 0) << "the tilt starts at rest and stays there";
  EXPECT_EQ(plan.played().rolls().after[0].rest_position(), 900) << "the track has arrived";
  EXPECT_TRUE(check(plan).fits());
}

TEST(Rolls, AnAxisThatStartsOnItsLimitHasNoRoomHoweverSlowItIs) {
  const Plan plan = plan_of(move_of("10", "[0], [400], [900]"));
  const CheckReport report = check(plan);
  ASSERT_THAT(report.refusals, SizeIs(1));
  EXPECT_THAT(report.refusals[0].message(), HasSubstr("the move starts moving, and on a pre-roll of"));
  EXPECT_THAT(report.refusals[0].message(), HasSubstr("axis \"track\" would go to -"));
  EXPECT_THAT(report.refusals[0].message(), HasSubstr("outside 0..1500"));
  EXPECT_THAT(report.refusals[0].message(), HasSubstr("begin the speed curve with 0, 0, at rest"));
  EXPECT_FALSE(report.refusals[0].slower_helps);
  EXPECT_EQ(smallest_frames(plan, report, {}).frames, std::nullopt);
  EXPECT_THROW(run(plan, {.simulated = true, .fast = true}), LimitError);
}

TEST(Rolls, AnAxisWithLittleRoomFitsInMoreFramesAndNotInOneLess) {
  const Plan plan = plan_of(move_of("10", "[20], [400], [900]"));
  const CheckReport report = check(plan);
  ASSERT_THAT(report.refusals, SizeIs(1));
  EXPECT_TRUE(report.refusals[0].slower_helps);
  EXPECT_THAT(report.refusals[0].message(), HasSubstr("or give the move more frames"));
  const SmallestFrames smallest = smallest_frames(plan, report, {});
  ASSERT_TRUE(smallest.frames) << smallest.reason;
  EXPECT_GT(*smallest.frames, 120);
  const auto in_frames = [&](std::int32_t frames) {
    return check(Plan(with_frames(plan.move(), frames), plan.rig(), {}));
  };
  EXPECT_TRUE(in_frames(*smallest.frames).fits());
  EXPECT_FALSE(in_frames(*smallest.frames - 1).fits());
}

TEST(Rolls, ALimitThatTheMoveItselfBreaksIsSaidOnce) {
  const CheckReport report = check(plan_of(move_of("10", "[300], [500], [900]", 20)));
  ASSERT_FALSE(report.fits());
  for (const CheckRefusal& refusal : report.refusals) {
    EXPECT_THAT(refusal.message(), testing::Not(HasSubstr("roll"))) << refusal.message();
  }
}

TEST(Rolls, AMoveThatBeginsWithItsFirstKeyTwiceIsBroughtUpAllTheSame) {
  const Plan plan = plan_of(move_of("5, 10, 5", "[300], [300], [500], [900], [900]"));
  EXPECT_LT(plan.played().first_frame(), 0);
  EXPECT_GT(plan.played().last_frame(), 120);
  EXPECT_GT(motion_at(plan, 0).velocity, 50);
  EXPECT_TRUE(check(plan).fits());
}

TEST(Rolls, ASpeedThatRisesFromZeroAtOnceStepsAndHasNoPreRoll) {
  const Plan plan = plan_of(move_of("0, 10, 0, 0"));
  EXPECT_EQ(plan.played().first_frame(), 0);
  const CheckReport report = check(plan);
  ASSERT_THAT(report.steps, SizeIs(1));
  EXPECT_EQ(report.steps[0].frame, 0);
  EXPECT_GT(report.steps[0].acceleration, 0);
}

TEST(Rolls, AreRunTickByTickFromTheirFirstFrameToTheirLast) {
  const Plan plan = plan_of(move_of("5, 10, 5"));
  const RunReport report = run(plan, {.simulated = true, .fast = true});
  const std::int32_t frames = plan.played().last_frame() - plan.played().first_frame();
  EXPECT_EQ(report.ticks, last_tick(frames, {24, 1}, 250) + 1);
  EXPECT_EQ(report.axes[1].last_commanded, motion_at(plan, plan.played().last_frame()).position);
}

TEST(Rolls, AreInTheJsonTheCsvAndTheSummary) {
  const TemporaryFile move("move.toml", move_of("5, 10, 5"));
  const TemporaryFile rig("rig.toml", rig_of());
  const Plan plan = plan_of(move_of("5, 10, 5"));
  const std::vector<std::string> files{"plan", move.path().string(), "--rig", rig.path().string()};
  const auto run = [&](std::vector<std::string> more) {
    more.insert(more.begin(), files.begin(), files.end());
    const ProgramRun result = run_program(more);
    EXPECT_EQ(result.status, 0) << result.err;
    return result.out;
  };
  const std::int32_t before = -plan.played().first_frame();
  const std::int32_t after = plan.played().last_frame() - 120;
  const Json json = Json::parse(run({"--json", "-"}));
  EXPECT_EQ(json["pre_roll"]["frames"], before);
  EXPECT_EQ(json["post_roll"]["frames"], after);
  const Json& axis = json["pre_roll"]["axes"][0];
  EXPECT_EQ(axis["name"], "track");
  ASSERT_THAT(axis["position"], SizeIs(before));
  ASSERT_THAT(axis["velocity"], SizeIs(before));
  EXPECT_EQ(axis["position"][0].get<double>(), motion_at(plan, -before).position);
  EXPECT_EQ(axis["velocity"][0].get<double>(), 0);
  EXPECT_EQ(axis["acceleration"].back().get<double>(), motion_at(plan, -1).acceleration);
  EXPECT_EQ(json["post_roll"]["axes"][0]["position"].back().get<double>(),
            motion_at(plan, 120 + after).position);
  EXPECT_THAT(json["axes"][0]["position"], SizeIs(121)) << "the move itself has its N + 1 frames";

  const std::string csv = run({"--csv", "-"});
  EXPECT_THAT(csv, HasSubstr(fmt::format("\n{},{},{}\n", -before, -before / 24.0,
                                         motion_at(plan, -before).position)));
  EXPECT_THAT(csv, HasSubstr("\n0,0,300\n"));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), before + 121 + after + 1);
  const std::string ticks = run({"--csv", "-", "--per", "tick"});
  EXPECT_THAT(ticks, HasSubstr(fmt::format("\n0,0,{}\n", motion_at(plan, -before).position)));
  EXPECT_EQ(std::count(ticks.begin(), ticks.end(), '\n'), last_tick(before + 120 + after, {24, 1}, 250) + 2);
  const std::string summary = run({});
  EXPECT_THAT(summary, HasSubstr(fmt::format("pre-roll: {} frames, from rest at track", before)));
  EXPECT_THAT(summary, HasSubstr(fmt::format("post-roll: {} frames, to rest at track", after)));
}

}  // namespace move_rolls_test
}  // namespace inbetween
