// What a refused move is told to change: each advice was tried, and is tried here again as its words say.
#include "host_tools/fit/cure.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "host_tools/plan/near_keys.hpp"
#include "tests/support/refused_text.hpp"
#include "tests/support/rig_text.hpp"

namespace inbetween {
namespace cure_test {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

/// A camera on a slide.
std::string slide_and_pan() {
  return rig_text(
      {axis_text("slide", "mm", {-100, 1800}, {.velocity = 500, .acceleration = 800, .jerk = 8000}),
       axis_text("pan", "deg", {-180, 180}, {.velocity = 90, .acceleration = 180, .jerk = 1800})});
}

/// The head of a puppet.
std::string neck() {
  return rig_text(
      {{.name = "yaw", .unit = "deg", .min = -70, .max = 70, .max_velocity = 180, .max_acceleration = 900},
       {.name = "nod", .unit = "deg", .min = -30, .max = 35, .max_velocity = 150, .max_acceleration = 800}});
}

std::string move_of(const std::string& axes, int frames, const std::string& track) {
  return fmt::format("name = \"m\"\nfps = 24\nframes = {}\n[[track]]\naxes = [{}]\n{}", frames, axes, track);
}

Plan plan_of(const std::string& move, const std::string& rig) {
  return {parse_move(move, "move.toml"), parse_rig(rig, "rig.toml"), {}};
}

std::optional<Cure> cure_of(const std::string& move, const std::string& rig) {
  const Plan plan = plan_of(move, rig);
  const CheckReport report = check(plan);
  return find_cure(plan, report, smallest_frames(plan, report, {}));
}

bool fits(const std::string& move, const std::string& rig) {
  return check(plan_of(move, rig)).fits();
}

std::string near(double apart) {
  return move_of(R"("slide", "pan")", 240,
                 fmt::format("keys = [{{at=[0,0]}},{{at=[500,30]}},{{at=[{},30]}},{{at=[1000,0]}}]\n"
                             "speed = [0,0,10,10,10,0,0]\n",
                             500 + apart));
}

// Case 31.
TEST(Cure, KeysThatAreNearlyInOnePlaceAreNamedWithTheirDistance) {
  for (const double apart : {0.01, 0.1, 1.0, 5.0}) {
    const std::optional<Cure> cure = cure_of(near(apart), slide_and_pan());
    ASSERT_TRUE(cure) << apart;
    EXPECT_EQ(cure->words, fmt::format("keys 1 and 2, which are {:.6g} mm apart, at one place", apart));
    EXPECT_EQ(cure->place.line, 6U);
  }
  EXPECT_TRUE(fits(near(0), slide_and_pan())) << "as the words say";
  EXPECT_EQ(cure_of(near(0), slide_and_pan()), std::nullopt) << "nothing to cure";
}

TEST(Cure, APlanWarnsOfKeysThatAreNearlyInOnePlace) {
  const std::vector<Warning> warnings = plan_of(near(0.1), slide_and_pan()).warnings();
  ASSERT_THAT(warnings, SizeIs(2));
  EXPECT_THAT(warnings[1].message,
              HasSubstr("keys 1 and 2 are 0.1 mm apart, 5007 times nearer than their neighbours"));
  EXPECT_THAT(plan_of(near(0), slide_and_pan()).warnings(), SizeIs(1)) << "a place that is passed twice";
  EXPECT_THAT(plan_of(near(20), slide_and_pan()).warnings(), SizeIs(1));
}

TEST(Cure, KeysOverFramesAndStraightPathsMayBeAsNearAsTheyLike) {
  const std::string keys =
      "keys = [{at=[0],frame=0},{at=[500],frame=9},{at=[500.1],frame=20},{at=[0],frame=48}]\n";
  EXPECT_THAT(near_keys(parse_move(move_of("\"slide\"", 48, "timing = \"frames\"\n" + keys), "m").tracks[0]),
              IsEmpty());
  EXPECT_THAT(
      near_keys(
          parse_move(move_of("\"slide\"", 48, "speed = [5]\nspline = \"linear\"\n" + keys), "m").tracks[0]),
      IsEmpty());
  EXPECT_THAT(near_keys(parse_move(move_of("\"slide\"", 48, "speed = [5]\n" + keys), "m").tracks[0]),
              SizeIs(1));
}

std::string nod_near_a_cusp(const std::string& of_key = "") {
  return move_of(
      R"("yaw", "nod")", 72,
      fmt::format("keys = [ {{ at = [0, 0] }}, {{ at = [5, 12]{} }}, {{ at = [25, -4] }}, {{ at = [20, "
                  "0] }} ]\nspeed = [0, 0, 10, 6, 8, 10, 0, 0]\n",
                  of_key));
}

// Case 54: the program said "give the move more frames", of which 407 would do.
TEST(Cure, ANodNearACuspIsEasedAtTheKeyWhereItTurns) {
  const std::string move = nod_near_a_cusp(", ease = true");
  ASSERT_FALSE(fits(move, neck()));
  const std::optional<Cure> cure = cure_of(move, neck());
  ASSERT_TRUE(cure);
  EXPECT_EQ(cure->words, "ease = true at key 2");
  EXPECT_TRUE(fits(with(move, "at = [25, -4]", "at = [25, -4], ease = true"), neck())) << "as the words say";
}

// Case 54: the program said corners = "ease", and then 999 frames.
TEST(Cure, ANodWithAHoldIsCuredByStayingBetweenItsKeys) {
  const std::string move =
      move_of("\"nod\"", 72,
              "keys = [ { at = [0] }, { at = [20], hold = 6 }, { at = [-10] }, { at = [0] } ]\n"
              "speed = [0, 0, 10, 10, 0, 0]\n");
  ASSERT_FALSE(fits(move, neck()));
  const std::optional<Cure> cure = cure_of(move, neck());
  ASSERT_TRUE(cure);
  EXPECT_EQ(cure->words, "overshoot = false, and ease = true at key 2");
  EXPECT_EQ(cure->frames, 85);
  std::string cured = with(move, "keys =", "overshoot = false\nkeys =");
  cured = with(cured, "at = [-10]", "at = [-10], ease = true");
  EXPECT_FALSE(fits(cured, neck()));
  cured = with(with(cured, "frames = 72", "frames = 85"), "hold = 6", "hold = 7");
  EXPECT_TRUE(fits(cured, neck())) << "as the words say";
}

/// The lids of a puppet, whose servos have a max_jerk.
std::string lids() {
  return rig_text(
      {axis_text("lid", "deg", {0, 45}, {.velocity = 500, .acceleration = 8000, .jerk = 200000})});
}

std::string blink(const std::string& more = "") {
  return move_of("\"lid\"", 18,
                 more +
                     "timing = \"frames\"\n"
                     "keys = [{at=[0],frame=0},{at=[45],frame=8},{at=[0],frame=18}]\n");
}

// The program said overshoot = false, and then spline = "smooth", which it has.
TEST(Cure, AnAxisThatTurnsBackOverFramesRestsAtAKeyThatIsWrittenTwice) {
  for (const char* more : {"", "overshoot = false\n"}) {
    const std::string move = blink(more);
    const CheckReport report = check(plan_of(move, lids()));
    ASSERT_FALSE(report.fits());
    EXPECT_THAT(report.refusals[0].message(),
                HasSubstr("; write key 1 twice, on frames 8 and 9, for a rest there"));
    const std::optional<Cure> cure = cure_of(move, lids());
    ASSERT_TRUE(cure);
    EXPECT_EQ(cure->words, "key 1 twice, on frames 8 and 9, for a rest there");
    EXPECT_EQ(cure->frames, 18);
    EXPECT_TRUE(fits(with(move, "{at=[45],frame=8}", "{at=[45],frame=8},{at=[45],frame=9}"), lids()))
        << "as the words say";
  }
}

TEST(Cure, OvershootIsAllowedWhereItTouchesNoLimit) {
  const std::string move = move_of(
      "\"lid\"", 96,
      "timing = \"frames\"\novershoot = false\nkeys = [{at=[2],frame=0},{at=[14],frame=24},{at=[4],frame=48},"
      "{at=[20],frame=72},{at=[2],frame=96}]\n");
  const CheckReport report = check(plan_of(move, lids()));
  ASSERT_FALSE(report.fits());
  EXPECT_THAT(report.refusals[0].message(), HasSubstr("at key 3, frame 72.00, and at keys 1 and 2, and"));
  EXPECT_THAT(report.refusals[0].message(), HasSubstr("write key 1 twice, on frames 24 and 25, key 2 twice"));
  const std::optional<Cure> cure = cure_of(move, lids());
  ASSERT_TRUE(cure);
  EXPECT_EQ(cure->words, "overshoot = true in place of false");
  EXPECT_TRUE(fits(with(move, "overshoot = false", "overshoot = true"), lids())) << "as the words say";
}

TEST(Cure, OfSixKeysThatTurnBackThoseThatNeedItRest) {
  const std::string move = move_of("\"lid\"", 90,
                                   "timing = \"frames\"\nkeys = [{at=[0],frame=0},{at=[14],frame=12},{at=[0],"
                                   "frame=24},{at=[45],frame=40},{at=[20],frame=60},{at=[0],frame=90}]\n");
  const std::optional<Cure> cure = cure_of(move, lids());
  ASSERT_TRUE(cure);
  EXPECT_EQ(cure->words,
            "key 2 twice, on frames 24 and 25 and key 3 twice, on frames 40 and 41, for a rest there");
}

/// A head whose motors are so many times as slow.
std::string slow_head(double times) {
  return rig_text({axis_text("pan", "deg", {-70, 70}, {.velocity = 120 / times, .acceleration = 600 / times},
                             fmt::format("max_jerk = {}\n", 6000 / times)),
                   axis_text("roll", "deg", {-20, 20}, {.velocity = 80 / times, .acceleration = 400 / times},
                             fmt::format("max_jerk = {}\n", 4000 / times))});
}

// The program said overshoot = false and ease = true at key 2, in 940576 frames.
TEST(Cure, InTwentyTimesAsManyFramesItIsNoAdvice) {
  const std::string move =
      move_of(R"("pan", "roll")", 96,
              "keys = [{at=[0,0]},{at=[-70,0]},{at=[-70,0],frame=15},{at=[0,5.8],hold=6},{at=[20.4,-20],"
              "ease=true},{at=[20.4,-20]},{at=[70,0]}]\nspeed = [0,0,5,10,3,0,0]\n");
  const std::optional<Cure> cure = cure_of(move, slow_head(1));
  ASSERT_TRUE(cure);
  EXPECT_THAT(cure->words, HasSubstr("hold = 1 at key 2"));
  EXPECT_LE(cure->frames, 20 * 96);
  EXPECT_EQ(cure_of(move, slow_head(20)), std::nullopt);
}

TEST(Cure, CornersAreEasedBesideAHoldInTheSamePlace) {
  const std::string keys =
      "overshoot = false\ncorners = \"ease\"\nkeys = "
      "[{at=[10]},{at=[40],hold=4},{at=[40]},{at=[12]},{at=[30]},{at=[30]}]\n"
      "speed = [0,0,10,0,0]\n";
  EXPECT_NO_THROW(plan_of(move_of("\"lid\"", 48, keys), lids()));
  const std::string behind =
      with(with(keys, "{at=[40],hold=4},{at=[40]}", "{at=[40]},{at=[40],hold=4}"), "[10]", "[11]");
  EXPECT_NO_THROW(plan_of(move_of("\"lid\"", 48, behind), lids()));
}

TEST(Cure, TwoKeysInOnePlaceThatBothRestAreToldSo) {
  const auto refusal_of = [](const std::string& keys) -> std::string {
    try {
      plan_of(move_of("\"lid\"", 48, "keys = [" + keys + "]\nspeed = [0,0,10,0,0]\n"), lids());
    } catch (const InputError& error) {
      return error.message();
    }
    return "";
  };
  for (const char* rest : {"ease=true", "hold=5"}) {
    const std::string key = fmt::format("{{at=[20],{}}}", rest);
    EXPECT_THAT(refusal_of("{at=[0]}," + key + "," + key + ",{at=[0]}"),
                HasSubstr("in the same place, and both rest or ease on one frame; remove one of the two"));
    EXPECT_EQ(refusal_of("{at=[0]}," + key + ",{at=[0]}"), "") << "as the words say";
  }
  EXPECT_THAT(refusal_of("{at=[10]},{at=[10],hold=4},{at=[25]}"),
              HasSubstr("remove this key, and give the first its hold"));
  EXPECT_EQ(refusal_of("{at=[10],hold=4},{at=[25]}"), "") << "as the words say";
  EXPECT_THAT(refusal_of("{at=[0]},{at=[20],hold=5},{at=[20]}"), HasSubstr("remove the keys behind it"));
  EXPECT_EQ(refusal_of("{at=[0]},{at=[20],hold=5}"), "") << "as the words say";
}

/// A jaw and a neck at twelve keys, where a step at one is told of, and those at the others are counted.
std::string dialogue(const std::string& ease) {
  std::string keys;
  for (const char* at : {"0, 0", "14, 3", "4, 6", "18, 8", "6, 5", "12, 0", "2, -6", "16, -10", "5, -8",
                         "11, -3", "3, 2", "0, 0"}) {
    const bool is_end = at == std::string("0, 0");
    keys += fmt::format("{{at=[{}]{}}},\n", at, is_end ? "" : ease);
  }
  return "overshoot = false\nkeys = [\n" + keys + "]\nspeed = [0, 0, 8, 10, 10, 8, 10, 10, 8, 10, 6, 0, 0]\n";
}

TEST(Cure, AllKeysAtWhichAnAxisStepsAreEasedAtOnce) {
  const std::string rig =
      rig_text({axis_text("jaw", "deg", {0, 22}, {.velocity = 220, .acceleration = 2400, .jerk = 48000}),
                axis_text("neck", "deg", {-60, 60}, {.velocity = 180, .acceleration = 900, .jerk = 9000})});
  const std::string axes = R"("jaw", "neck")";
  const std::optional<Cure> cure = cure_of(move_of(axes, 88, dialogue("")), rig);
  ASSERT_TRUE(cure);
  EXPECT_EQ(cure->words, "ease = true at keys 1, 2, 3, 4, 5, 6, 7, 8, 9 and 10");
  EXPECT_TRUE(fits(move_of(axes, cure->frames, dialogue(", ease=true")), rig)) << "as the words say";
  EXPECT_FALSE(fits(move_of(axes, cure->frames - 1, dialogue(", ease=true")), rig));
}

TEST(Cure, AKeyWithAFrameOnNoKnotIsHeldAndNotEased) {
  const auto nod = [](const std::string& overshoot, const std::string& locked, const std::string& free) {
    return move_of(R"("yaw")", 72,
                   fmt::format("{}keys = [{{at=[0]}},{{at=[-18],frame=22{}}},{{at=[4]{}}},{{at=[0]}}]\n"
                               "speed = [0, 0, 10, 10, 8, 0, 0]\n",
                               overshoot, locked, free));
  };
  const std::optional<Cure> cure = cure_of(nod("", "", ""), neck());
  ASSERT_TRUE(cure);
  EXPECT_EQ(cure->words, "overshoot = false, and hold = 1 at key 1, and ease = true at key 2");
  EXPECT_EQ(cure->frames, 72);
  EXPECT_TRUE(fits(nod("overshoot = false\n", ",hold=1", ",ease=true"), neck())) << "as the words say";
  EXPECT_THROW(plan_of(nod("", ",ease=true", ""), neck()), InputError) << "its frame is on no knot";
}

TEST(Cure, AMoveOfSeveralTracksIsToldWhichOneToChange) {
  const std::string move = nod_near_a_cusp(", ease = true") +
                           "[[track]]\naxes = [\"lid\"]\ntiming = \"frames\"\n"
                           "keys = [{at = [0], frame = 0}, {at = [0], frame = 72}]\n";
  std::string rig = neck();
  rig += rig_text({{.name = "lid"}}).substr(rig_text({}).size());
  const std::optional<Cure> cure = cure_of(move, rig);
  ASSERT_TRUE(cure);
  EXPECT_EQ(cure->words, "ease = true at key 2 in the track of \"yaw\"");
}

TEST(Cure, WhatNothingCuresGetsNoAdvice) {
  const std::string far =
      move_of("\"nod\"", 72, "keys = [ { at = [0] }, { at = [90] } ]\nspeed = [0, 0, 5, 0, 0]\n");
  EXPECT_EQ(cure_of(far, neck()), std::nullopt) << "a key outside the axis";
}

}  // namespace cure_test
}  // namespace inbetween
