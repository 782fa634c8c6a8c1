// Whether a move stays inside the limits of its rig: peaks, positions, steps, and in how many frames it
// would.
#include "host_tools/check/check.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/check/check_frames.hpp"
#include "tests/support/bounded_cells.hpp"
#include "tests/support/oracle_limits.hpp"
#include "tests/support/places.hpp"
#include "tests/support/refused_text.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/solved_move.hpp"

namespace inbetween {
namespace check_test {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using testing::StartsWith;

/// Two axes that are limited alike; without max_jerk unless a test gives one.
std::string rig_with(const std::string& jerk = "", double acceleration = 400) {
  return rig_text({{.name = "x", .max_acceleration = acceleration, .more = jerk},
                   {.name = "y", .max_acceleration = acceleration, .more = jerk}});
}

const std::string bends =
    "keys = [ { at = [10, 0] }, { at = [60, 40] }, { at = [110, -20] }, { at = [160, 10] } ]\n";
const std::string gently = "speed = [0, 0, 10, 10, 0, 0]\n";

std::string move_of(const std::string& track, int frames = 192) {
  return fmt::format("name = \"m\"\nfps = 24\nframes = {}\n[[track]]\naxes = [\"x\", \"y\"]\n{}", frames,
                     track);
}

Plan plan_of(const std::string& move, const std::string& rig = rig_with()) {
  return {parse_move(move, "move.toml"), parse_rig(rig, "rig.toml"), {}};
}

CheckReport check_of(const std::string& track, const std::string& rig = rig_with(), int frames = 192) {
  return check(plan_of(move_of(track, frames), rig));
}

SmallestFrames smallest_of(const Plan& plan) {
  return smallest_frames(plan, check(plan), {});
}

double largest_step(const CheckReport& report, double CheckedStep::*size) {
  double largest = 0;
  for (const CheckedStep& step : report.steps) largest = std::max(largest, step.*size);
  return largest;
}

TEST(Check, AGentleMoveFitsAndItsPeaksAreThoseOfItsMotion) {
  const Plan plan = plan_of(move_of(bends + gently));
  const CheckReport report = check(plan);
  EXPECT_TRUE(report.fits());
  EXPECT_THAT(report.steps, IsEmpty());
  EXPECT_EQ(report.speed_error, 1e-6);
  const CheckedAxis& x = report.axes[0];
  std::vector<AxisMotion> motion(2);
  double fastest = 0;
  for (std::int32_t i = 0; i <= 192 * 64; ++i) {
    plan.tracks()[0].track().motion({i / 64, (i % 64) / 64.0}, motion);
    fastest = std::max(fastest, std::abs(motion[0].velocity));
  }
  EXPECT_GE(x.velocity.value, fastest);
  EXPECT_LE(x.velocity.value, 1.011 * fastest);
  EXPECT_EQ(x.velocity.limit, 150);
  EXPECT_EQ(x.jerk.limit, std::nullopt);
  EXPECT_EQ(x.range->lowest.value, 10);
  EXPECT_EQ(x.range->highest.value, 160);
}

TEST(Check, ASpikeBetweenTwoKeysAMillimetreApartIsFoundThatASampleAFrameMisses) {
  const std::string spike =
      "keys = [ { at = [10, 0] }, { at = [80, 60] }, { at = [81, 60] }, { at = [151, 0] } ]\n";
  const Plan plan = plan_of(move_of(spike + gently, 67), rig_with("", 1500));
  std::vector<AxisMotion> motion(2);
  double sampled = 0;  // 24 times a second, on every frame
  for (std::int32_t frame = 0; frame <= 67; ++frame) {
    plan.tracks()[0].track().motion({frame, 0}, motion);
    sampled = std::max(sampled, std::abs(motion[1].acceleration));
  }
  EXPECT_LT(sampled, 200) << "to a sampler the move is harmless";
  const CheckReport report = check(plan);
  ASSERT_FALSE(report.fits());
  const CheckedPeak& peak = report.axes[1].acceleration;
  EXPECT_GT(peak.value, 300 * sampled);
  const auto whole = static_cast<std::int32_t>(peak.frame);
  plan.tracks()[0].track().motion({whole, peak.frame - whole}, motion);
  EXPECT_GE(1.011 * std::abs(motion[1].acceleration), peak.value) << "it is there";
  EXPECT_THAT(report.refusals.back().message(), HasSubstr("mm/s^2 at frame"));
  EXPECT_TRUE(report.refusals.back().slower_helps);
}

TEST(Check, LimitsOfAPositionAreInclusive) {
  const std::string line = "keys = [ { at = [-100, 0] }, { at = [200, 10] } ]\n";
  EXPECT_TRUE(check_of(line + gently).fits());
  const CheckReport report = check_of(with(line, "200", "200.001") + gently);
  ASSERT_THAT(report.refusals, SizeIs(1));
  ASSERT_FALSE(report.fits());
  EXPECT_THAT(
      report.refusals[0].message(),
      StartsWith("axis \"x\" would go to 200.001 mm at frame 192.00, outside -100..200 mm of the rig"));
  EXPECT_EQ(report.refusals[0].place.line, 5U);
  EXPECT_FALSE(report.refusals[0].slower_helps);
}

TEST(Check, APathThatSwingsBeyondALimitBetweenItsKeysIsRefused) {
  const std::string swing =
      "keys = [ { at = [0, 0] }, { at = [199, 50] }, { at = [199, 100] }, { at = [0, 150] } ]\n";
  const CheckReport report = check_of(swing + gently, rig_with("", 4000), 400);
  ASSERT_THAT(report.refusals, SizeIs(1));
  EXPECT_GT(report.axes[0].range->highest.value, 200);
  ASSERT_FALSE(report.fits());
  const std::string_view either =
      "keep the curve between its keys with overshoot = false, or move its keys inward by ";
  const std::string message = report.refusals[0].message();
  ASSERT_THAT(message, HasSubstr(either));
  const double inward = std::stod(message.substr(message.find(either) + either.size()));
  EXPECT_GE(inward, report.axes[0].range->highest.value - 200);
  EXPECT_LE(inward, 1.01 * (report.axes[0].range->highest.value - 200));
  const std::string moved = fmt::format(
      "keys = [ {{ at = [0, 0] }}, {{ at = [{0}, 50] }}, {{ at = [{0}, 100] }}, {{ at = [0, 150] }} ]\n",
      199 - inward);
  EXPECT_TRUE(check_of(moved + gently, rig_with("", 4000), 400).fits()) << "as the words say";
  EXPECT_TRUE(check_of("overshoot = false\n" + swing + gently, rig_with("", 4000), 400).fits());
}

// Case 53: what is rounded on the way to a key on a limit exceeds nothing.
TEST(Check, AKeyOnALimitIsInside) {
  for (const int frame : {40, 41, 43, 44}) {
    const std::string blink = fmt::format(
        "overshoot = false\ntiming = \"frames\"\nkeys = [ {{ at = [0, 0], frame = 0 }}, {{ at = [0, 0], "
        "frame = 37 }}, "
        "{{ at = [200, 1], frame = {} }}, {{ at = [0, 0], frame = 48 }}, {{ at = [0, 0], frame = 96 }} ]\n",
        frame);
    for (const CheckRefusal& refusal : check_of(blink, rig_with("", 4000), 96).refusals) {
      EXPECT_THAT(refusal.message(), testing::Not(HasSubstr("outside"))) << frame;
    }
  }
}

TEST(Check, AnAxisInNoTrackStaysAndHasNoRange) {
  const Plan plan = plan_of(
      "name = \"m\"\nfps = 24\nframes = 96\n[[track]]\naxes = [\"y\"]\n"
      "keys = [ { at = [0] }, { at = [10] } ]\n" +
      gently);
  const CheckReport report = check(plan);
  EXPECT_TRUE(report.fits());
  EXPECT_EQ(report.axes[0].range, std::nullopt);
  EXPECT_EQ(report.axes[0].velocity.value, 0);
  EXPECT_GT(report.axes[1].velocity.value, 0);
}

TEST(Check, TheCornerOfALinearPathIsAStepThatNoSlownessCures) {
  const Plan plan = plan_of(move_of("spline = \"linear\"\n" + bends + gently, 400));
  const CheckReport report = check(plan);
  ASSERT_THAT(report.steps, SizeIs(4)) << "two axes at two keys";
  ASSERT_THAT(report.refusals, SizeIs(2));
  EXPECT_EQ(report.steps[0].key, 1);
  for (const CheckRefusal& refusal : report.refusals) {
    EXPECT_THAT(refusal.message(), HasSubstr("which no drive can follow; use spline = \"smooth\""));
    EXPECT_EQ(refusal.place.line, 7U) << "the key";
  }
  const SmallestFrames smallest = smallest_of(plan);
  EXPECT_EQ(smallest.frames, std::nullopt);
  EXPECT_EQ(smallest.reason, report.refusals[0].message());
}

TEST(Check, ACornerAtWhichTheRigRestsIsNoStep) {
  const std::string rests =
      "spline = \"linear\"\nkeys = [ { at = [10, 0] }, { at = [60, 40], frame = 80, hold = 7 }, { at = [160, "
      "10] } ]\n";
  const CheckReport report = check_of(rests + gently, rig_with("max_jerk = 100000"));
  EXPECT_THAT(report.steps, IsEmpty());
  EXPECT_TRUE(report.fits());
}

TEST(Check, AStepOfTheAccelerationBreaksAJerkLimitUnlessItIsAllowed) {
  const std::string track = "spline = \"catmull-rom\"\n" + bends + gently;
  const std::string quick_rig = rig_with("", 4000);
  const CheckReport free = check_of(track, quick_rig);
  EXPECT_TRUE(free.fits()) << "without max_jerk it is listed and allowed";
  EXPECT_EQ(largest_step(free, &CheckedStep::velocity), 0) << "a common tangent";
  const double largest = largest_step(free, &CheckedStep::acceleration);
  EXPECT_GT(largest, 10);
  const CheckReport bound = check_of(track, rig_with("max_jerk = 1e9", 4000));
  ASSERT_FALSE(bound.fits());
  EXPECT_THAT(bound.refusals[0].message(), HasSubstr("max_jerk allows no step; use spline = \"smooth\""));
  EXPECT_FALSE(bound.refusals[0].slower_helps);
  const auto allowing = [&](double step) {
    return rig_with(fmt::format("max_jerk = 1e9\nmax_acceleration_step = {}", step), 4000);
  };
  EXPECT_TRUE(check_of(track, allowing(1.000001 * largest)).fits());
  const CheckReport just_beyond = check_of(track, allowing(0.999999 * largest));
  ASSERT_THAT(just_beyond.refusals, SizeIs(1));
  ASSERT_FALSE(just_beyond.fits());
  EXPECT_THAT(just_beyond.refusals[0].message(), HasSubstr("max_acceleration_step is"));
  EXPECT_TRUE(just_beyond.refusals[0].slower_helps);
}

TEST(Check, AnAccelerationThatStepsAtAnEndIsToldToBeginAtRest) {
  const CheckReport soft = check_of(bends + "speed = [0, 5, 0, 0]\n", rig_with("max_jerk = 1e9"));
  ASSERT_FALSE(soft.fits());
  EXPECT_EQ(largest_step(soft, &CheckedStep::velocity), 0);
  ASSERT_FALSE(soft.steps.empty());
  EXPECT_EQ(soft.steps[0].frame, 0);
  EXPECT_EQ(soft.steps[0].key, 0);
  EXPECT_THAT(soft.refusals[0].message(),
              HasSubstr("max_jerk allows no step; begin the speed curve with 0, 0"));
  const CheckReport late = check_of(bends + "speed = [0, 0, 5, 0]\n", rig_with("max_jerk = 1e9"));
  ASSERT_FALSE(late.fits());
  EXPECT_THAT(late.refusals[0].message(), HasSubstr("end the speed curve with 0, 0"));
}

TEST(Check, AMoveThatStepsAtBothEndsIsToldToRestAtBoth) {
  const CheckReport report = check_of(bends + "speed = [0, 5, 0]\n", rig_with("max_jerk = 1e9"));
  ASSERT_FALSE(report.fits());
  EXPECT_THAT(report.refusals[0].message(), HasSubstr("begin and end the speed curve with 0, 0, at rest"));
  EXPECT_THAT(report.refusals[0].message(),
              testing::ContainsRegex("at key (0|3), .*, and at key (0|3), and"));
}

TEST(Check, WhatATrackHasIsNotItsRemedy) {
  const CheckReport report = check_of(
      "corners = \"ease\"\novershoot = false\nkeys = [ { at = [45, 3.4] }, { at = [45, 3.4] }, { at = [25.5, "
      "13.2], ease = true }, { at = [0, 0], ease = true }, { at = [45, 45] } ]\nspeed = [0, 10, 10, 0]\n");
  ASSERT_FALSE(report.fits());
  for (const CheckRefusal& refusal : report.refusals)
    EXPECT_THAT(refusal.message(), testing::Not(HasSubstr("corners")));
  EXPECT_THAT(report.refusals[0].message(), HasSubstr("turns on the spot"));
  EXPECT_THAT(report.refusals[0].message(), HasSubstr("; begin the speed curve with 0, 0, at rest"));
}

TEST(Check, APositionIsRoundedButNotOntoItsLimit) {
  const std::string line = "keys = [ { at = [-100, 0] }, { at = [200.0000001, 10] } ]\n";
  const std::string far = with(line, "200.0000001", "1145.9155902616465");
  EXPECT_THAT(check_of(line + gently).refusals[0].message(), HasSubstr("would go to 200.0000001 mm"));
  EXPECT_THAT(check_of(far + gently).refusals[0].message(), HasSubstr("would go to 1145.92 mm"));
}

TEST(Check, ANumberOfFramesSaysWhatMovesWithIt) {
  const auto words_of = [](const std::string& track) {
    return in_proportion(parse_move(move_of(track + gently), "move.toml"));
  };
  EXPECT_EQ(words_of(bends), "");
  EXPECT_EQ(words_of(with(bends, "40] }", "40], hold = 4 }")), ", with the holds of the keys in proportion");
  EXPECT_EQ(words_of(with(bends, "40] }", "40], hold = 4, frame = 60 }")),
            ", with the frames and holds of the keys in proportion");
  EXPECT_EQ(words_of("ease_in = 4\n" + bends), ", with ease_in and ease_out in proportion");
}

TEST(Check, ABreakInTheSpeedIsAStepOnItsFrame) {
  const CheckReport report =
      check_of(with(bends, "{ at = [60, 40] }", "{ at = [60, 40], frame = 100, break = true }") + gently,
               rig_with("", 4000));
  ASSERT_THAT(report.steps, SizeIs(2));
  EXPECT_EQ(report.steps[0].key, 1);
  EXPECT_EQ(report.steps[0].frame, 100);
  EXPECT_GT(report.steps[0].velocity, 0);
  ASSERT_FALSE(report.fits());
  EXPECT_THAT(report.refusals[0].message(), HasSubstr("take away the break"));
}

TEST(Check, ALineThatTurnsBackBetweenKeysIsAStepWithoutAKey) {
  const std::string back =
      "spline = \"catmull-rom\"\nkeys = [ { at = [10, 0] }, { at = [110, 0] }, { at = [60, 0] }, { at = "
      "[150, 0] } ]\n";
  const Plan plan = plan_of(move_of(back + gently, 2000));
  const CheckReport report = check(plan);
  ASSERT_THAT(report.steps, SizeIs(2));
  std::vector<AxisMotion> before(2);
  std::vector<AxisMotion> after(2);
  for (const CheckedStep& step : report.steps) {
    EXPECT_EQ(step.key, std::nullopt);
    const auto frame = static_cast<std::int32_t>(step.frame);
    const double fraction = step.frame - frame;
    plan.tracks()[0].track().motion({frame, fraction - 1e-6}, before);
    plan.tracks()[0].track().motion({frame, fraction + 1e-6}, after);
    EXPECT_NEAR(step.velocity, std::abs(after[0].velocity - before[0].velocity), 1e-5 * step.velocity);
    EXPECT_NEAR(step.acceleration, std::abs(after[0].acceleration - before[0].acceleration), 1e-3);
  }
  ASSERT_FALSE(report.fits());
  EXPECT_THAT(report.refusals[0].message(), HasSubstr("let the speed touch 0 there with corners = \"ease\""));
  EXPECT_EQ(smallest_of(plan).frames, std::nullopt);
}

TEST(Check, ALineThatTurnsBackAtAKeyWhereItRestsFits) {
  const std::string back = "keys = [ { at = [10, 0] }, { at = [110, 0], hold = 2 }, { at = [60, 0] } ]\n";
  const CheckReport report = check_of(back + gently, rig_with("max_jerk = 100000"), 400);
  EXPECT_TRUE(report.fits());
}

TEST(Check, AMoveThatGoesOutHoldsAndComesBackTheSameWayFits) {
  const std::string move =
      "name = \"m\"\nfps = 24\nframes = 480\n[[track]]\naxes = [\"slide\", \"pan\", \"tilt\"]\n"
      "keys = [ { at = [60, -40, -4] }, { at = [420, -30, -3] }, { at = [860, 0, 4], hold = 24 },\n"
      "  { at = [420, -30, -3] }, { at = [60, -40, -4] } ]\n"
      "speed = [0, 0, 6, 6, 6, 6, 0, 0]\nweights = [1, 6, 6]\n";
  const Plan plan{parse_move(move, "move.toml"), read_rig_file(in_checkout("examples/camera_rig.toml")), {}};
  const CheckReport report = check(plan);
  EXPECT_TRUE(report.fits());
  EXPECT_TRUE(report.stops.has_value());
  const CheckedPeak& hardest = report.axes[0].acceleration;
  EXPECT_NEAR(hardest.value, 112.0, 0.6);
  std::vector<AxisMotion> there(3);
  const auto frame = static_cast<std::int32_t>(hardest.frame);
  plan.tracks()[0].track().motion({frame, hardest.frame - frame}, there);
  EXPECT_NEAR(std::fabs(there[0].acceleration), hardest.value, 0.01 * hardest.value);
  EXPECT_EQ(smallest_of(plan).frames, 181);
}

TEST(Check, ACuspThatIsPassedAtASpeedIsRefused) {
  // The derivative of the one segment with bends is 0 at key 1, where the path comes back another way.
  const std::string cusp =
      "spline = \"tcb\"\nkeys = [ { at = [0, 0] }, { at = [50, 50], tension = 1 }, { at = [100, 0] }, { at = "
      "[150, 0] } ]\n";
  const CheckReport report = check_of(cusp + gently, rig_with("", 1e6), 400);
  ASSERT_FALSE(report.fits());
  ASSERT_FALSE(report.steps.empty());
  EXPECT_EQ(report.steps[0].key, 1);
  EXPECT_FALSE(report.refusals[0].slower_helps);
}

TEST(Check, AMoveTimedByFramesStepsAtItsCornersAndMeetsItsRollsAtItsEnds) {
  const std::string timed =
      "spline = \"linear\"\ntiming = \"frames\"\nkeys = [ { at = [0, 0], frame = 0 }, { at = [50, 0], frame "
      "= 96 }, { at = [50, 30], frame = 192 } ]\n";
  const CheckReport report = check_of(timed);
  EXPECT_EQ(report.speed_error, 0) << "no fitted inverse";
  ASSERT_THAT(report.steps, SizeIs(2));
  EXPECT_NEAR(report.steps[0].velocity, 50 / 4.0, 1e-12);
  EXPECT_EQ(report.steps[1].frame, 96);
  EXPECT_NEAR(report.steps[1].velocity, 30 / 4.0, 1e-12);
  ASSERT_FALSE(report.fits());
  EXPECT_THAT(report.refusals[0].message(), HasSubstr("use spline = \"smooth\" and kinetic = \"curves\""));
}

MoveStep step_at(const BoundedMove& bounded, const oracle::Step& expected) {
  const auto found = std::ranges::find_if(bounded.steps(), [&](const MoveStep& step) {
    return step.key == expected.key && step.axis == static_cast<std::size_t>(expected.axis);
  });
  return found != bounded.steps().end() ? *found : MoveStep{};
}

/// Product and oracle agree on what steps, where and by how much.
void expect_steps_of_oracle(const RandomMove& move) {
  const SolvedTrack solved = solve(move);
  const oracle::IdealMotion ideal(move.keys, oracle::Profile(move.speed), move.frames, 24);
  const BoundedMove bounded = bounds_of_track(solved.track());
  for (const oracle::Step& expected : ideal.extremes(16).steps) {
    if (expected.frame == 0 || expected.frame == move.frames) continue;  // it meets its roll
    const MoveStep found = step_at(bounded, expected);
    if (expected.velocity < 1e-9 && expected.acceleration < 1e-9) continue;  // its rounding
    EXPECT_NEAR(found.frame, static_cast<double>(expected.frame), 1e-6 * move.frames)
        << "key " << expected.key;
    EXPECT_NEAR(found.velocity, static_cast<double>(expected.velocity), 1e-6) << "key " << expected.key;
    EXPECT_NEAR(found.acceleration, static_cast<double>(expected.acceleration), 1e-5)
        << "key " << expected.key;
  }
}

TEST(MotionSteps, AreThoseOfTheOracleOnEveryKindOfPath) {
  for (const oracle::Kind kind :
       {oracle::Kind::smooth, oracle::Kind::catmull_rom, oracle::Kind::tcb, oracle::Kind::linear}) {
    for (const bool closed : {false, true}) {
      RandomMove move;
      move.keys.kind = kind;
      move.keys.closed = closed;
      move.keys.at = {{10, 0}, {60, 40}, {110, -20}, {160, 10}};
      if (kind == oracle::Kind::tcb)
        move.keys.tension_continuity_bias = {{0, 0, 0}, {0.25L, 0.5L, 0}, {0, -0.25L, 0.125L}, {0, 0, 0}};
      move.speed = {3, 5, 10, 1, 4};
      move.frames = 77;
      SCOPED_TRACE(fmt::format("kind {}, closed {}", static_cast<int>(kind), closed));
      expect_steps_of_oracle(move);
    }
  }
}

TEST(MotionSteps, WhereThePathStandsStillAtAKeyTheDirectionIsItsLimit) {
  RandomMove move;
  move.keys.kind = oracle::Kind::tcb;
  move.keys.at = {{10, 0}, {60, 40}, {110, -20}, {160, 10}};
  move.keys.tension_continuity_bias = {{0, 0, 0}, {1, 0, 0}, {0, 0, 0}, {1, 0, 0}};
  move.speed = {3, 5, 10, 1, 4};
  move.frames = 77;
  const SolvedTrack solved = solve(move);
  const oracle::IdealMotion ideal(move.keys, oracle::Profile(move.speed), move.frames, 24);
  const BoundedMove bounded = bounds_of_track(solved.track());
  for (const oracle::Step& expected : ideal.extremes(16).steps) {
    if (expected.key == 0 || expected.key == 3) continue;  // it meets its roll
    EXPECT_NEAR(step_at(bounded, expected).velocity, static_cast<double>(expected.velocity),
                1e-5 * static_cast<double>(expected.velocity) + 1e-9)
        << "key " << expected.key;
  }
}

TEST(MotionSteps, OfKeysInOnePlaceTheFirstHasThem) {
  const Plan plan =
      plan_of(move_of("spline = \"linear\"\nkeys = [ { at = [0, 0] }, { at = [50, 0] }, { at = [50, 0] }, { "
                      "at = [50, 50] } ]\n" +
                      gently));
  const CheckReport report = check(plan);
  ASSERT_THAT(report.steps, SizeIs(2));
  EXPECT_EQ(report.steps[0].key, 1);
  EXPECT_EQ(report.steps[1].key, 1);
}

/// Solved again from its file, at `frames` and at one less.
bool fits_in(const Plan& plan, std::int32_t frames) {
  return check(Plan(with_frames(plan.move(), frames), plan.rig(), {})).fits();
}

TEST(SmallestFrames, FitsAndOneFrameLessDoesNot) {
  for (const int frames : {1, 20, 97, 192, 5000}) {
    for (const char* jerk : {"", "max_jerk = 900", "max_jerk = 60"}) {
      const Plan plan = plan_of(move_of(bends + gently, frames), rig_with(jerk));
      const SmallestFrames smallest = smallest_of(plan);
      ASSERT_TRUE(smallest.frames) << smallest.reason;
      EXPECT_TRUE(fits_in(plan, *smallest.frames)) << frames << jerk;
      EXPECT_FALSE(fits_in(plan, *smallest.frames - 1)) << frames << jerk;
      EXPECT_EQ(smallest.reason, "");
    }
  }
}

TEST(SmallestFrames, AStepWithinItsAllowanceWhenSlowerIsCured) {
  const Plan plan = plan_of(move_of("spline = \"catmull-rom\"\n" + bends + gently, 60),
                            rig_with("max_jerk = 1e6\nmax_acceleration_step = 5", 4000));
  const SmallestFrames smallest = smallest_of(plan);
  ASSERT_TRUE(smallest.frames) << smallest.reason;
  EXPECT_TRUE(fits_in(plan, *smallest.frames));
  EXPECT_FALSE(fits_in(plan, *smallest.frames - 1));
}

TEST(SmallestFrames, LockedKeysAndHoldsMoveInProportion) {
  const std::string locked =
      "keys = [ { at = [10, 0] }, { at = [60, 40], frame = 20 }, { at = [110, -20], frame = 30, hold = 5 }, "
      "{ at = [160, 10] } ]\n";
  const Plan plan = plan_of(move_of(locked + gently, 48));
  const MoveFile doubled = with_frames(plan.move(), 96);
  EXPECT_EQ(doubled.frames, 96);
  EXPECT_EQ(doubled.tracks[0].keys[1].frame, 40);
  EXPECT_EQ(doubled.tracks[0].keys[2].frame, 60);
  EXPECT_EQ(doubled.tracks[0].keys[2].hold, 10);
  const MoveFile stretched = with_frames(plan.move(), 49);
  EXPECT_EQ(stretched.tracks[0].keys[1].frame, 20) << "20.42";
  EXPECT_EQ(stretched.tracks[0].keys[2].frame, 31) << "30.63";
  EXPECT_EQ(with_frames(plan.move(), 4).tracks[0].keys[2].hold, 1) << "a hold stays one";
  const SmallestFrames smallest = smallest_of(plan);
  ASSERT_TRUE(smallest.frames) << smallest.reason;
  EXPECT_GT(*smallest.frames, 48);
  EXPECT_TRUE(fits_in(plan, *smallest.frames));
  EXPECT_FALSE(fits_in(plan, *smallest.frames - 1));
}

TEST(SmallestFrames, IsProvenWhereTheRoundingOfLockedFramesLeadsTheFirstGuessAstray) {
  const std::string locked =
      "keys = [ { at = [10, 0] }, { at = [60, 40], frame = 450 }, { at = [110, -20], frame = 545 }, { at = "
      "[160, 10] } ]\n";
  for (int frames = 900; frames < 1200; frames += 7) {
    const Plan plan = plan_of(move_of(locked + gently, frames), rig_with("", 4e4));
    const SmallestFrames smallest = smallest_of(plan);
    ASSERT_TRUE(smallest.frames) << smallest.reason;
    EXPECT_TRUE(fits_in(plan, *smallest.frames)) << frames;
    EXPECT_FALSE(fits_in(plan, *smallest.frames - 1)) << frames;
  }
}

TEST(SmallestFrames, ThereIsNoneWhereAPositionIsBeyondItsLimit) {
  const Plan plan = plan_of(move_of(with(bends, "160", "260") + gently));
  const SmallestFrames smallest = smallest_of(plan);
  EXPECT_EQ(smallest.frames, std::nullopt);
  EXPECT_THAT(smallest.reason, HasSubstr("would go to 260 mm"));
}

TEST(SmallestFrames, AMoveThatNeedsMoreThanAreAllowedHasNone) {
  const Plan plan =
      plan_of(move_of(bends + gently),
              with(with(rig_with(), "name = \"x\"\nunit = \"mm\"\nmin = -100\nmax = 200\nmax_velocity = 150",
                        "name = \"x\"\nunit = \"mm\"\nmin = -100\nmax = 200\nmax_velocity = 1e-4"),
                   "rate_hz = 100", "rate_hz = 100"));
  const SmallestFrames smallest = smallest_of(plan);
  EXPECT_EQ(smallest.frames, std::nullopt);
  EXPECT_THAT(smallest.reason, HasSubstr("it does not fit in 1000000 frames either"));
}

TEST(SmallestFrames, TellsWhatItTries) {
  const Plan plan = plan_of(move_of(bends + gently, 20));
  std::vector<double> shares;
  std::vector<std::int32_t> tried;
  const SmallestFrames smallest = smallest_frames(plan, check(plan), [&](double share, std::int32_t frames) {
    shares.push_back(share);
    tried.push_back(frames);
  });
  EXPECT_TRUE(std::ranges::is_sorted(shares));
  EXPECT_GE(shares.front(), 0);
  EXPECT_LT(shares.back(), 1);
  EXPECT_THAT(tried, testing::Contains(*smallest.frames));
}

/// Every number of frames rounds the frames of the locked keys anew, and one of these needs the most.
TEST(SmallestFrames, OfManyLockedKeysTakeFewTrials) {
  std::string track = "keys = [";
  for (int key = 0; key <= 600; ++key) {
    track += fmt::format("{{ at = [{:.4f}, {:.4f}]", 10 * key + 2 * std::sin(1.7 * key), std::cos(1.7 * key));
    if (key % 2 == 1) track += fmt::format(", frame = {}", 20 * key + key % 3 - 1);
    track += " },";
  }
  track += "]\nspeed = [0, 0, 30, 32, 30, 28, 30, 0, 0]\n";
  const std::string rig =
      rig_text({{.name = "x", .min = -1e4, .max = 1e4, .max_velocity = 30, .max_acceleration = 1e3},
                {.name = "y", .min = -1e4, .max = 1e4, .max_velocity = 1e3, .max_acceleration = 1e3}});
  const Plan plan = plan_of(move_of(track, 12000), rig);
  int trials = 0;
  const SmallestFrames smallest = smallest_frames(plan, check(plan), [&](double, std::int32_t) { ++trials; });
  ASSERT_TRUE(smallest.frames.has_value()) << smallest.reason;
  EXPECT_LE(trials, 12);
  const auto fits_in = [&](std::int32_t frames) {
    return check(Plan(with_frames(plan.move(), frames), plan)).fits();
  };
  EXPECT_TRUE(fits_in(*smallest.frames));
  EXPECT_FALSE(fits_in(*smallest.frames - 1));
}

TEST(SmallestFrames, AreMoreWhereTheMotionFitsAndAStopDoesNot) {
  // A stop may take no more than the motion, which takes nearly all in 192 frames and too much in 191.
  const CheckReport in_192 = check_of(bends + gently);
  const double peak = std::max(in_192.axes[0].acceleration.value, in_192.axes[1].acceleration.value);
  const double limit = peak * (1 + 1e-5);
  const std::string rig = rig_with(fmt::format("stop_acceleration = {}\n", limit), limit);
  const CheckReport refused = check_of(bends + gently, rig);
  ASSERT_FALSE(refused.fits());
  EXPECT_THAT(refused.refusals[0].message(), HasSubstr("could not be stopped"));
  EXPECT_FALSE(check_of(bends + gently, rig, 191).fits());
  EXPECT_EQ(smallest_of(plan_of(move_of(bends + gently, 150), rig)).frames, 193);
  EXPECT_TRUE(check_of(bends + gently, rig, 193).fits());
}

}  // namespace check_test
}  // namespace inbetween
