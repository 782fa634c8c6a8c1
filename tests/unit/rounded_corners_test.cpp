#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host_tools/move_model/move_file.hpp"
#include "host_tools/plan/passed_keys.hpp"
#include "host_tools/plan/plan.hpp"
#include "host_tools/plan/solved_track.hpp"
#include "tests/support/refused_text.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/run_on.hpp"

/// Straight lines whose corners are rounded: overlapping actions, and a tolerance along a path.

namespace inbetween {
namespace rounded_corners_test {

using testing::HasSubstr;

Plan planned(const std::string& track, int frames = 96) {
  return {parse_move("name = \"m\"\nfps = 24\nframes = " + std::to_string(frames) +
                         "\n[[track]]\naxes = [\"x\"]\nspline = \"linear\"\n" + track,
                     "file.toml"),
          std::nullopt,
          {}};
}

Plan planned_of_two(const std::string& track) {
  return {parse_move("name = \"m\"\nfps = 24\nframes = 96\n[[track]]\naxes = [\"x\", \"y\"]\nspline = "
                     "\"linear\"\n" +
                         track,
                     "file.toml"),
          std::nullopt,
          {}};
}

AxisMotion at(const Plan& plan, double frame) {
  std::vector<AxisMotion> motion(plan.tracks()[0].track().path().weights().size());
  const auto whole = static_cast<std::int32_t>(frame);
  plan.tracks()[0].track().motion({whole, frame - whole}, motion);
  return motion[0];
}

const std::string three_keys =
    "timing = \"frames\"\nkeys = [ {at=[0], frame=0}, {at=[24], frame=48}, {at=[0], frame=96} ]\n";

TEST(Overlap, AKeyIsMissedByATwelfthOfTheChangeOfVelocity) {
  const Plan plan = planned(three_keys + "overlap = 12\nrest = \"none\"\n");
  // From half a unit a frame to as much back: 12 / 12 of 1.
  EXPECT_NEAR(at(plan, 48).position, 24 - 1, 1e-12);
  EXPECT_NEAR(at(plan, 48).velocity, 0, 1e-12);
  // On a triangle 12 frames wide the acceleration has a peak of twice the change over the width.
  EXPECT_NEAR(at(plan, 48).acceleration, -2 / 12.0 * 24 * 24, 1e-9);
  EXPECT_NEAR(at(plan, 42).position, 21, 1e-12);
  EXPECT_NEAR(at(plan, 42).acceleration, 0, 1e-9);
  const std::vector<PassedKey> passed = passed_keys(plan, 0);
  ASSERT_EQ(passed.size(), 1U);
  EXPECT_EQ(passed[0].key, 1U);
  EXPECT_EQ(passed[0].frame, 48);
  EXPECT_NEAR(passed[0].missed[0], -1, 1e-12);
}

TEST(Overlap, AnActionFromRestIsShorterByHalfTheOverlapAndMeetsItsKey) {
  const Plan plan = planned(three_keys + "overlap = 16\n");
  EXPECT_EQ(at(plan, 0).position, 0);
  EXPECT_EQ(at(plan, 0).velocity, 0);
  EXPECT_EQ(at(plan, 0).acceleration, 0);
  EXPECT_NEAR(at(plan, 24).velocity, 24.0 / (48 - 8) * 24, 1e-9);
  EXPECT_EQ(at(plan, 96).position, 0);
  EXPECT_NEAR(at(plan, 96).velocity, 0, 1e-9);
}

TEST(Overlap, AnEndThatMovesGoesStraightOn) {
  const Plan plan = planned(three_keys + "overlap = 16\nrest = \"end\"\n");
  EXPECT_EQ(at(plan, 0).position, 0);
  EXPECT_NEAR(at(plan, 0).velocity, 12, 1e-12);
  EXPECT_EQ(at(plan, 0).acceleration, 0);
  EXPECT_NEAR(at(plan, 96).velocity, 0, 1e-9);
}

TEST(Overlap, AKeyMayHaveItsOwn) {
  const Plan plan = planned(
      "timing = \"frames\"\nrest = \"none\"\noverlap = 4\nkeys = [ {at=[0], frame=0}, {at=[24], frame=24, "
      "overlap=0}, "
      "{at=[24], frame=72}, {at=[0], frame=96} ]\n");
  EXPECT_EQ(at(plan, 24).position, 24);
  EXPECT_NEAR(at(plan, 72).position, 24 - 4 / 12.0, 1e-12);
}

TEST(Overlap, TheSeamOfALoopIsOneAsAnyOther) {
  const Plan plan = planned(
      "timing = \"frames\"\nclosed = true\nperiodic = true\noverlap = 12\nkeys = [ {at=[0], frame=0}, "
      "{at=[24], "
      "frame=48} ]\n");
  EXPECT_NEAR(at(plan, 0).position, 1, 1e-12);
  EXPECT_NEAR(at(plan, 0).velocity, 0, 1e-12);
  EXPECT_EQ(at(plan, 96).position, at(plan, 0).position);
  EXPECT_EQ(passed_keys(plan, 0).size(), 2U);
}

TEST(Overlap, MoreThanAnActionIsRefusedWithWhatGoesIn) {
  const auto plan = [](const std::string& text, const std::string& file) {
    return Plan(parse_move(text, file), std::nullopt, {});
  };
  const std::string head =
      "name = \"m\"\nfps = 24\nframes = 96\n[[track]]\naxes = [\"x\"]\nspline = \"linear\"\ntiming = "
      "\"frames\"\n";
  expect_refused(plan,
                 head +
                     "overlap = 30\nrest = \"none\"\nkeys = [ {at=[0], frame=0}, @{at=[24], frame=40}, "
                     "{at=[0], frame=60}, {at=[4], frame=96} ]\n",
                 {"key 1", "an overlap of 20 frames at both of its keys goes in"});
  // What just goes in is taken, and half a frame more is not.
  const std::string last = "rest = \"none\"\nkeys = [ {at=[0], frame=0}, @{at=[24], frame=40, overlap=20}, ";
  expect_refused(plan, head + last + "{at=[0], frame=60, overlap=21}, {at=[4], frame=96} ]\n", {"key 1"});
  EXPECT_NO_THROW(
      plan(head + without_mark(last + "{at=[0], frame=60, overlap=20}, {at=[4], frame=96} ]\n").text, "m"));
  // A rest takes half of its own as well.
  expect_refused(
      plan, head + "overlap = 33\nkeys = [ @{at=[0], frame=0}, {at=[24], frame=48}, {at=[0], frame=96} ]\n",
      {"key 0", "an overlap of 32 frames at both of its keys goes in"});
}

TEST(Overlap, IsForStraightLinesTimedByFrames) {
  const std::string head = "name = \"m\"\nfps = 24\nframes = 96\n[[track]]\naxes = [\"x\"]\n";
  const std::string keys = "keys = [ {at=[0], frame=0}, {at=[24], frame=96} ]\n";
  for (const std::string track :
       {"timing = \"frames\"\n", "timing = \"frames\"\nspline = \"linear\"\nkinetic = \"pace\"\n",
        "spline = \"linear\"\nspeed = [1]\n"}) {
    expect_refused(parse_move, head + track + "overlap = @4\n" + keys,
                   {"overlap is for straight lines timed by frames", "use round"});
  }
  expect_refused(
      parse_move,
      head + "timing = \"frames\"\nkeys = [ {at=[0], frame=0, overlap = @4}, {at=[24], frame=96} ]\n",
      {"overlap is for straight lines"});
  expect_refused(parse_move, head + "timing = \"frames\"\nspline = \"linear\"\noverlap = @-1\n" + keys,
                 {"overlap"});
}

const std::string square = "keys = [ {at=[0, 0]}, {at=[100, 0]}, {at=[100, 40]}, {at=[0, 40]} ]\n";

TEST(Round, TheCornerIsPassedAtItsTolerance) {
  const Plan plan = planned_of_two("speed = [0, 0, 5, 5, 0, 0]\nround = 3\n" + square);
  const std::vector<PassedKey> passed = passed_keys(plan, 0);
  ASSERT_EQ(passed.size(), 2U);
  for (const PassedKey& key : passed) {
    EXPECT_NEAR(key.distance, 3, 1e-12);
    EXPECT_NEAR(std::fabs(key.missed[0]), std::fabs(key.missed[1]), 1e-12);
  }
  EXPECT_LT(plan.tracks()[0].track().arc_length().total(), 240);
}

TEST(Round, HalfOfTheShorterLegIsTheMostThatIsUsed) {
  const Plan plan = planned_of_two("speed = [0, 0, 5, 5, 0, 0]\nround = 30\n" + square);
  // A right angle over 20 units of either leg: sqrt(2) * 20 / 6.
  for (const PassedKey& key : passed_keys(plan, 0)) EXPECT_NEAR(key.distance, std::sqrt(2.0) * 20 / 6, 1e-9);
}

TEST(Round, AKeyOnAStraightLineAndOneThatTurnsStraightBackAreMet) {
  const Plan plan = planned_of_two(
      "speed = [0, 0, 5, 5, 0, 0]\nround = 3\nkeys = [ {at=[0, 0]}, {at=[10, 10]}, {at=[30, 30]}, {at=[5, "
      "5]} ]\n");
  EXPECT_TRUE(passed_keys(plan, 0).empty());
  EXPECT_EQ(plan.tracks()[0].track().path().segment_count(), 3);
}

TEST(Round, WeightsSayWhatADistanceIs) {
  const Plan plan = planned_of_two("speed = [0, 0, 5, 5, 0, 0]\nweights = [1, 10]\nround = 3\n" + square);
  for (const PassedKey& key : passed_keys(plan, 0)) {
    EXPECT_NEAR(key.distance, 3, 1e-12);
    EXPECT_NEAR(std::hypot(key.missed[0], 10 * key.missed[1]), 3, 1e-12);
  }
}

TEST(Round, ALockedKeyIsPassedOnItsFrame) {
  const Plan plan = planned_of_two(
      "speed = [0, 0, 5, 5, 5, 5, 0, 0]\nround = 3\nkeys = [ {at=[0, 0]}, {at=[100, 0], frame=40}, {at=[100, "
      "40], "
      "hold=12}, {at=[0, 40]} ]\n");
  const std::vector<PassedKey> passed = passed_keys(plan, 0);
  ASSERT_EQ(passed.size(), 2U);
  EXPECT_NEAR(passed[0].frame, 40, 1e-9);
  const Track& track = plan.tracks()[0].track();
  EXPECT_NEAR(track.path().parameter(track.locate({40, 0})), 1, 1e-9);
}

TEST(Round, IsForAStraightPathWithASpeedCurve) {
  const std::string head = "name = \"m\"\nfps = 24\nframes = 96\n[[track]]\naxes = [\"x\"]\n";
  const std::string keys = "keys = [ {at=[0], frame=0}, {at=[24], frame=96} ]\n";
  for (const std::string track : {"speed = [1]\n", "timing = \"frames\"\nspline = \"linear\"\n"}) {
    expect_refused(parse_move, head + track + "round = @4\n" + keys,
                   {"round is for a straight path with a speed curve", "use overlap"});
  }
  expect_refused(parse_move, head + "spline = \"linear\"\nspeed = [1]\nround = @-4\n" + keys, {"round"});
}

TEST(RoundedPath, TheCoreRefusesWhatDoesNotGoTogether) {
  const std::array<double, 3> keys{0, 1, 0};
  const std::array<std::int32_t, 3> frames{0, 10, 20};
  std::array<Cubic, 16> cubics{};
  std::array<double, 1> weights{};
  std::array<FrameKnot, 15> knots{};
  const auto made = [&](const PathSpec& spec) { return Path::make(spec, {cubics, weights, knots}); };
  const std::array<std::int32_t, 3> overlaps{4, 4, 4};
  const std::array<double, 3> tolerances{0.1, 0.1, 0.1};
  const PathSpec good{.spline = Spline::linear,
                      .axis_count = 1,
                      .keys = keys,
                      .key_frames = frames,
                      .overlap_frames = overlaps};
  ASSERT_TRUE(made(good).has_value());
  PathSpec smooth = good;
  smooth.spline = Spline::smooth;
  EXPECT_EQ(made(smooth).error().code, ErrorCode::wrong_count);
  PathSpec both = good;
  both.path_tolerances = tolerances;
  EXPECT_EQ(made(both).error().code, ErrorCode::wrong_count);
  PathSpec few = good;
  few.overlap_frames = std::span(overlaps).first(2);
  EXPECT_EQ(made(few).error().code, ErrorCode::wrong_count);
  const std::array<std::int32_t, 3> negative{4, -1, 4};
  PathSpec below = good;
  below.overlap_frames = negative;
  EXPECT_EQ(made(below).error().code, ErrorCode::out_of_range);
  EXPECT_EQ(made(below).error().key, 1);
  const std::array<double, 3> endless{0, std::numeric_limits<double>::infinity(), 0};
  PathSpec infinite = good;
  infinite.key_frames = {};
  infinite.overlap_frames = {};
  infinite.path_tolerances = endless;
  EXPECT_EQ(made(infinite).error().code, ErrorCode::not_finite);
  EXPECT_EQ(Path::make(good, {cubics, weights, std::span(knots).first(3)}).error().code, ErrorCode::capacity);
}

const std::string rig =
    rig_text({axis_text("pan", "deg", {-200, 200}, {.velocity = 200, .acceleration = 2000, .jerk = 40000})},
             {.rate_hz = 250});
const std::string panned =
    "name = \"m\"\nfps = 24\nframes = 96\n[[track]]\naxes = [\"pan\"]\nspline = \"linear\"\n" + three_keys;

TEST(PassedKeys, PlanAndCheckTellByHowMuchAKeyIsMissed) {
  for (const char* command : {"plan", "check"}) {
    const ProgramRun run = run_on(rig, command, panned + "overlap = 12\n");
    EXPECT_EQ(run.status, 0) << run.err;
    EXPECT_THAT(run.out, HasSubstr("key 1 is missed on frame 48: pan by -1.143 deg")) << command;
  }
  const ProgramRun json = run_on(rig, "plan", panned + "overlap = 12\n", {"--json", "-"});
  const auto passed = nlohmann::json::parse(json.out)["tracks"][0]["passed_keys"];
  ASSERT_EQ(passed.size(), 1U);
  EXPECT_EQ(passed[0]["key"], 1);
  EXPECT_EQ(passed[0]["frame"], 48);
}

TEST(PassedKeys, AnAxisWithLimitsOfJerkFitsOnlyWhenItsActionsOverlap) {
  EXPECT_EQ(run_on(rig, "check", panned).status, 3);
  EXPECT_EQ(run_on(rig, "check", panned + "overlap = 12\n").status, 0);
}

}  // namespace rounded_corners_test
}  // namespace inbetween
