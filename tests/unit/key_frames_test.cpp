#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/plan/plan_output.hpp"
#include "tests/support/places.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/run_on.hpp"
#include "tests/support/temporary_file.hpp"

/// What an animator expects of keys, as the program's users meet it: keys on frames, turns that ease, holds
/// that hold.

namespace inbetween {
namespace key_frames_test {

using Json = nlohmann::json;
using testing::HasSubstr;
using testing::Not;

const std::string rig =
    rig_text({axis_text("zoom", "mm", {-1000, 1000}, {.velocity = 200, .acceleration = 2000, .jerk = 40000})},
             {.rate_hz = 250});

std::string move_of(const std::string& track, int frames = 96) {
  return "name = \"move\"\nfps = 24\nframes = " + std::to_string(frames) +
         "\n[[track]]\naxes = [\"zoom\"]\n" + track;
}

const std::string zoom =
    "timing = \"frames\"\n"
    "keys = [ {at=[10], frame=0}, {at=[11], frame=24}, {at=[30], frame=72}, {at=[32], frame=96} ]\n";

Json planned(const std::string& text) {
  const TemporaryFile move_file("move.toml", text);
  const ProgramRun run = run_program({"plan", move_file.path().string(), "--json", "-"});
  EXPECT_EQ(run.status, 0) << run.err;
  return run.status == 0 ? Json::parse(run.out) : Json();
}

std::vector<double> positions(const Json& plan) {
  return plan["axes"][0]["position"].get<std::vector<double>>();
}

std::vector<double> velocities(const std::string& text) {
  return planned(text)["axes"][0]["velocity"].get<std::vector<double>>();
}

TEST(KeyFrames, APlainZoomOfFourKeysFits) {
  for (const char* way : {"", "kinetic = \"curves\"\n", "kinetic = \"pace\"\n"}) {
    const std::string text = move_of(way + zoom);
    const ProgramRun run = run_on(rig, "check", text);
    EXPECT_EQ(run.status, 0) << way << run.err;
    EXPECT_THAT(run.out, HasSubstr("no step of velocity or acceleration")) << way;
    const std::vector<double> at = positions(planned(text));
    ASSERT_EQ(at.size(), 97U);
    EXPECT_NEAR(at[0], 10, 1e-9);
    EXPECT_NEAR(at[24], 11, 1e-9);
    EXPECT_NEAR(at[72], 30, 1e-9);
    EXPECT_NEAR(at[96], 32, 1e-9);
  }
}

TEST(KeyFrames, WhatStepsNamesCurvesAsTheRemedy) {
  for (const char* way : {"kinetic = \"monotone\"\n", "kinetic = \"linear\"\n"}) {
    const ProgramRun run = run_on(rig, "check", move_of(way + zoom));
    EXPECT_EQ(run.status, 3) << way;
    EXPECT_THAT(run.err, HasSubstr("note: it fits with kinetic = \"curves\"; this was tried")) << way;
  }
  const ProgramRun old = run_on(rig, "check", move_of("kinetic = \"smooth\"\n" + zoom));
  EXPECT_EQ(old.status, 1);
  EXPECT_THAT(old.err, HasSubstr("called \"monotone\""));
}

TEST(KeyFrames, APaceIsShownAsASpeedCurve) {
  const Json track = planned(move_of("kinetic = \"pace\"\n" + zoom))["tracks"][0];
  const auto speed = track["speed"].get<std::vector<double>>();
  ASSERT_GT(speed.size(), 8U);
  EXPECT_EQ(track["f"], speed.size() - 1);
  EXPECT_EQ(*std::max_element(speed.begin(), speed.end()), 100);
  EXPECT_TRUE(track["speed_drawn"].empty());
}

TEST(KeyFrames, AKeyWrittenTwiceIsAHoldOnEveryPath) {
  const std::string keys =
      "timing = \"frames\"\nkeys = [ {at=[0], frame=0}, {at=[20], frame=30}, {at=[20], frame=60}, "
      "{at=[5], frame=96} ]\n";
  for (const char* spline : {"smooth", "catmull-rom", "tcb"}) {
    const std::string text = move_of("spline = \"" + std::string(spline) + "\"\n" + keys);
    const std::vector<double> at = positions(planned(text));
    for (std::size_t frame = 30; frame <= 60; ++frame) EXPECT_EQ(at[frame], 20) << spline << " " << frame;
    const ProgramRun run = run_on(rig, "check", text, {"--json", "-"});
    const Json json = Json::parse(run.out);
    for (const auto& step : json["steps"]) EXPECT_EQ(step["velocity_step"], 0) << spline;
  }
  EXPECT_EQ(run_on(rig, "check", move_of(keys)).status, 0);
}

TEST(KeyFrames, AnEndWithoutRestIsPassedAtASpeedWithARoll) {
  const Json json =
      Json::parse(run_on(rig, "check", move_of("rest = \"end\"\n" + zoom), {"--json", "-"}).out);
  EXPECT_TRUE(json["fits"]);
  const std::vector<double> moving = planned(move_of("rest = \"none\"\n" + zoom))["axes"][0]["velocity"];
  const std::vector<double> resting = planned(move_of(zoom))["axes"][0]["velocity"];
  EXPECT_NE(moving.front(), 0);
  EXPECT_NE(moving.back(), 0);
  EXPECT_EQ(resting.front(), 0);
  EXPECT_EQ(resting.back(), 0);
}

// --- a drawn speed that touches 0

TEST(KeyFrames, ANodOnOneAxisEasesAtItsTurningPoint) {
  const std::string keys =
      "keys = [ {at=[0]}, {at=[-15]}, {at=[0]} ]\nspeed = [0, 0, 10, 10, 10, 10, 10, 0, 0]\n";
  const ProgramRun passed = run_on(rig, "check", move_of(keys, 48));
  EXPECT_EQ(passed.status, 3);
  EXPECT_THAT(passed.err, HasSubstr("ease"));
  const std::string eased_keys =
      "keys = [ {at=[0]}, {at=[-15], ease=true}, {at=[0]} ]\nspeed = [0, 0, 10, 10, 10, 10, 10, 0, 0]\n";
  for (const std::string& text : {move_of("corners = \"ease\"\n" + keys, 48), move_of(eased_keys, 48)}) {
    const ProgramRun run = run_on(rig, "check", text);
    EXPECT_EQ(run.status, 0) << run.err;
    const Json plan = planned(text);
    const std::vector<double> at = positions(plan);
    EXPECT_NEAR(*std::min_element(at.begin(), at.end()), -15, 1e-9);
    EXPECT_EQ(std::count(at.begin(), at.end(), at[24]), 1) << "it does not stand still";
  }
}

TEST(KeyFrames, CornersEaseBetweenKeysToo) {
  const std::string keys =
      "keys = [ {at=[0]}, {at=[-15]}, {at=[3]}, {at=[0]} ]\nspeed = [0, 0, 10, 10, 10, 10, 10, 0, 0]\n";
  EXPECT_EQ(run_on(rig, "check", move_of(keys, 48)).status, 3);
  const ProgramRun run = run_on(rig, "check", move_of("corners = \"ease\"\n" + keys, 48));
  EXPECT_EQ(run.status, 0) << run.err;
}

TEST(KeyFrames, ACornerWhoseKeyIsWrittenTwiceEasesOnce) {
  const std::string speed = "speed = [0, 0, 10, 10, 10, 10, 10, 0, 0]\ncorners = \"ease\"\n";
  const std::string once = move_of("keys = [ {at=[0]}, {at=[-15]}, {at=[0]} ]\n" + speed, 48);
  const std::string twice = move_of("keys = [ {at=[0]}, {at=[-15]}, {at=[-15]}, {at=[0]} ]\n" + speed, 48);
  EXPECT_EQ(run_on(rig, "check", twice).status, 0) << run_on(rig, "check", twice).err;
  const std::vector<double> expected = positions(planned(once));
  const std::vector<double> actual = positions(planned(twice));
  ASSERT_EQ(actual.size(), expected.size());
  for (std::size_t frame = 0; frame < actual.size(); ++frame)
    EXPECT_NEAR(actual[frame], expected[frame], 1e-9);
}

TEST(KeyFrames, AnEasedKeyIsLockedOnAKnotAndTheNearestFrameIsNamed) {
  const auto locked = [](int frame) {
    return move_of("keys = [ {at=[0]}, {at=[-15], ease=true, frame=" + std::to_string(frame) +
                       "}, {at=[0]} ]\nspeed = [0, 0, 10, 10, 10, 10, 10, 0, 0]\n",
                   51);
  };
  const ProgramRun refused = run_on(rig, "check", locked(20));
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.err, HasSubstr("the nearest frame that is possible is "));
  const ProgramRun even = run_on(rig, "check",
                                 move_of("keys = [ {at=[0]}, {at=[-15], ease=true, frame=21}, {at=[0]} ]\n"
                                         "speed = [0, 0, 10, 10, 10, 10, 10, 0, 0]\n",
                                         48));
  EXPECT_EQ(even.status, 0) << even.err;
}

TEST(KeyFrames, APaceEasesAtACornerOnItsFrame) {
  const std::string keys =
      "timing = \"frames\"\nkinetic = \"pace\"\nkeys = [ {at=[0], frame=0}, {at=[-15], frame=31}, {at=[0], "
      "frame=96} "
      "]\n";
  EXPECT_EQ(run_on(rig, "check", move_of(keys)).status, 3);
  const ProgramRun run = run_on(rig, "check", move_of("corners = \"ease\"\n" + keys));
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_NEAR(positions(planned(move_of("corners = \"ease\"\n" + keys)))[31], -15, 1e-9);
  EXPECT_NEAR(velocities(move_of("corners = \"ease\"\n" + keys))[31], 0, 1e-9);
}

// --- ends and values of a drawn curve

TEST(KeyFrames, EaseInAndOutBringAPlainSpeedFromRestAndToRest) {
  const std::string keys = "keys = [ {at=[0]}, {at=[100]} ]\n";
  for (const char* speed : {"speed = [10]\n", "speed = [10, 10, 10, 10, 10]\n"}) {
    const std::string text = move_of(std::string("ease_in = 12\nease_out = 24\n") + keys + speed);
    EXPECT_EQ(run_on(rig, "check", text).status, 0);
    const std::vector<double> v = velocities(text);
    EXPECT_EQ(v[0], 0);
    EXPECT_EQ(v[96], 0);
    EXPECT_LT(v[8], 0.999 * v[12]);
    EXPECT_LT(v[96 - 16], 0.999 * v[12]);
    for (std::size_t frame = 12; frame <= 72; ++frame) EXPECT_NEAR(v[frame], v[40], 1e-9 * v[40]) << frame;
  }
}

TEST(KeyFrames, RestWithoutAnEaseTakesADrawnSpan) {
  const std::string keys = "keys = [ {at=[0]}, {at=[100]} ]\nspeed = [10, 10, 10, 10, 10]\n";
  const std::vector<double> both = velocities(move_of("rest = \"both\"\n" + keys));
  EXPECT_EQ(both[0], 0);
  EXPECT_EQ(both[96], 0);
  EXPECT_NEAR(both[24], both[72], 1e-9);
  const std::vector<double> start = velocities(move_of("rest = \"start\"\n" + keys));
  EXPECT_EQ(start[0], 0);
  EXPECT_GT(start[96], 0);
  EXPECT_EQ(run_on(rig, "check", move_of("rest = \"both\"\n" + keys)).status, 0);
  const ProgramRun both_ways = run_on(rig, "check", move_of("rest = \"end\"\nease_in = 12\n" + keys));
  EXPECT_EQ(both_ways.status, 1);
  EXPECT_THAT(both_ways.err, HasSubstr("ease_in contradicts rest"));
}

TEST(KeyFrames, ACurveThroughItsValuesHasThem) {
  const std::string text =
      move_of("through = true\nkeys = [ {at=[0]}, {at=[100]} ]\nspeed = [4, 8, 3, 6, 2]\n");
  const std::vector<double> v = velocities(text);
  const std::vector<double> values = {4, 8, 3, 6, 2};
  for (std::size_t i = 0; i < values.size(); ++i) {
    EXPECT_NEAR(v[24 * i] / v[0], values[i] / 4, 1e-9) << i;
  }
  const ProgramRun below = run_on(
      rig, "check", move_of("through = true\nkeys = [ {at=[0]}, {at=[100]} ]\nspeed = [0, 0, 10, 0, 0]\n"));
  EXPECT_EQ(below.status, 1);
  EXPECT_THAT(below.err, HasSubstr("the curve through these values goes below 0"));
}

TEST(KeyFrames, AFitKeepsAnEasedEndAndWritesTheCurveThatIsPlayed) {
  const TemporaryFolder folder;
  const std::string fitted = (folder.path() / "fitted.toml").string();
  const std::string text = move_of(
      "ease_in = 10\nease_out = 10\nkeys = [ {at=[0]}, {at=[20]}, {at=[320]} ]\nspeed = [2, 20, 2]\n", 56);
  EXPECT_EQ(run_on(rig, "check", text).status, 3);
  const ProgramRun run = run_on(rig, "check", text, {"--fit", fitted});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(file_contents(fitted), HasSubstr("ease_in = 0\nease_out = 0\n"));
  const std::vector<double> v = velocities(file_contents(fitted));
  EXPECT_EQ(v.front(), 0);
  EXPECT_EQ(v.back(), 0);
  EXPECT_EQ(run_on(rig, "check", file_contents(fitted)).status, 0);
}

// --- overshoot

/// Kochanek and Bartels 1984, adjusted to the frames: half the way from neighbour to neighbour, shared out
/// over half of the frames that it takes.
TEST(KeyFrames, ATangentOfCatmullRomCountsTheFramesOnBothSides) {
  const MoveFile move = parse_move(
      "name = \"m\"\nfps = 24\nframes = 96\n[[track]]\naxes = [\"x\"]\nspline = \"catmull-rom\"\ntiming = "
      "\"frames\"\nkeys = [{ at = [10], frame = 0 }, { at = [11], frame = 24 }, { at = [30], frame = 72 }, { "
      "at = "
      "[32], frame = 96 }]\n",
      "m.toml");
  const Plan plan(move, std::nullopt, {});
  std::vector<AxisMotion> motion(1);
  plan.tracks().front().track().motion({24, 0}, motion);
  EXPECT_NEAR(motion[0].velocity, (30 - 10) / 72.0 * 24, 1e-12);
  plan.tracks().front().track().motion({72, 0}, motion);
  EXPECT_NEAR(motion[0].velocity, (32 - 11) / 72.0 * 24, 1e-12);
}

TEST(KeyFrames, TheSpeedIsDrawnBetweenFramesToo) {
  const Plan plan(read_move_file(in_checkout("examples/blink.toml")), std::nullopt, {});
  const PlotTrack plot = plot_of(plan).tracks.front();
  ASSERT_EQ(plot.speed_line.size() - 1, (plot.speed.size() - 1) * 32);
  for (std::size_t frame = 0; frame < plot.speed.size(); ++frame) {
    EXPECT_NEAR(plot.speed_line[32 * frame], plot.speed[frame], 1e-9);
  }
  EXPECT_NEAR(plot.speed_line[16], plot.speed[1] / 4, 1e-9) << "from rest the speed rises with its square";
}

TEST(KeyFrames, WithoutOvershootAHeldEyeStaysWhereItIs) {
  const std::string two = "name = \"eyes\"\nfps = 24\nframes = 96\n[[track]]\naxes = [\"x\", \"y\"]\n";
  const auto lowest = [&](const std::string& more) {
    const std::string text = two + more +
                             "keys = [ {at=[0,0]}, {at=[-25,5]}, {at=[-25,-5]}, {at=[10,0]} ]\n"
                             "speed = [0, 0, 10, 10, 10, 10, 10, 0, 0]\n";
    const std::vector<double> at = positions(planned(text));
    return *std::min_element(at.begin(), at.end());
  };
  EXPECT_LT(lowest(""), -25.1);
  EXPECT_GE(lowest("overshoot = false\n"), -25);
}

}  // namespace key_frames_test
}  // namespace inbetween
