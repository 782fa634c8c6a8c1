// A speed curve that is changed as little as can be until the move keeps the limits of its rig.
#include "host_tools/fit/speed_fit.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "host_tools/fit/fewer_values.hpp"
#include "host_tools/fit/fewest_fit.hpp"
#include "host_tools/fit/fit_output.hpp"
#include "host_tools/move_model/speed_rewrite.hpp"
#include "tests/support/refused_text.hpp"
#include "tests/support/rig_text.hpp"

namespace inbetween {
namespace speed_fit_test {

using testing::AllOf;
using testing::Each;
using testing::ElementsAreArray;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

struct Limits {
  double velocity = 150;
  double acceleration = 400;
  std::string more = "";
};

/// Two axes that are limited alike.
std::string rig_with(const Limits& limits) {
  std::vector<AxisText> axes{{.name = "x"}, {.name = "y"}};
  for (AxisText& axis : axes) {
    axis.max_velocity = limits.velocity;
    axis.max_acceleration = limits.acceleration;
    axis.more = limits.more;
  }
  return rig_text(axes);
}

const std::string bends =
    "keys = [ { at = [10, 0] }, { at = [60, 40] }, { at = [110, -20] }, { at = [160, 10] } ]\n";
const std::string peaked = "speed = [0, 0, 6, 16, 6, 6, 0, 0]\n";

std::string move_of(const std::string& track, int frames = 96) {
  return fmt::format("name = \"m\"\nfps = 24\nframes = {}\n[[track]]\naxes = [\"x\", \"y\"]\n{}", frames,
                     track);
}

Plan plan_of(const std::string& move, const Limits& limits) {
  return {parse_move(move, "move.toml"), parse_rig(rig_with(limits), "rig.toml"), {}};
}

SpeedFit fit_of(const Plan& plan, FitStart start = FitStart::either) {
  return fit_speed(plan, check(plan), {.start = start});
}

/// The file with the new curves in it, read again.
Plan written(const std::string& move, const SpeedFit& fit, const Limits& limits) {
  std::string text = move;
  for (const TrackFit& track : fit.tracks) text = with_speed(text, "move.toml", track.track, track.speed);
  return plan_of(text, limits);
}

double area_per_span(const Plan& plan) {
  const SpeedProfile& profile = plan.tracks()[0].track().profile();
  return profile.total_integral() / profile.span_count();
}

TEST(SpeedFit, AMoveThatFitsIsLeftAsItIs) {
  const SpeedFit fit = fit_of(plan_of(move_of(bends + peaked, 400), {}));
  EXPECT_TRUE(fit.found);
  EXPECT_THAT(fit.tracks, IsEmpty());
  EXPECT_EQ(fit.reason, "");
  EXPECT_GT(fit.fewest.frames, 0);
}

TEST(SpeedFit, APeakIsFlattenedAndTheRestRaisedUntilTheVelocityFits) {
  const std::string move = move_of(bends + peaked);
  const Limits limits{.velocity = 110, .acceleration = 4000};
  const Plan plan = plan_of(move, limits);
  ASSERT_FALSE(check(plan).fits());
  const SpeedFit fit = fit_of(plan);
  ASSERT_TRUE(fit.found) << fit.reason;
  ASSERT_THAT(fit.tracks, SizeIs(1));
  const TrackFit& track = fit.tracks[0];
  EXPECT_EQ(track.refinements, 0);
  EXPECT_THAT(track.speed, SizeIs(8));
  const Plan after = written(move, fit, limits);
  EXPECT_TRUE(check(after).fits());
  EXPECT_NEAR(area_per_span(after) / area_per_span(plan), 1, 1e-9);
  EXPECT_GT(check(after).axes[0].velocity.value, 0.994 * 110) << "no flatter than it has to be";
  EXPECT_LT(track.largest_change, 0) << "where it was too fast";
  EXPECT_NEAR(track.largest_change_at, 3, 0.3);
  EXPECT_NEAR(track.largest_change_frame, track.largest_change_at * 96 / 7, 1e-9);
  EXPECT_LT(track.change, std::abs(track.largest_change));
  EXPECT_NEAR(track.change_share, track.change / area_per_span(plan), 1e-9);
  for (const std::size_t rest : {0U, 1U, 6U, 7U}) EXPECT_EQ(track.speed[rest], 0);
}

/// A curve that somebody has drawn with a pen: as many values as the pen gave.
std::string drawn_by_pen(int values) {
  std::string speed = "speed = [0, 0";
  for (int i = 2; i < values - 2; ++i)
    speed += fmt::format(", {:.3f}", 6 + 5 * std::sin(0.12 * i) + 0.4 * std::sin(2.1 * i));
  return speed + ", 0, 0]\n";
}

TEST(SpeedFit, ACurveOfManyValuesSaysInHowFewItStaysEditableAndHowMuchFurtherThatIs) {
  const std::string move = move_of(bends + drawn_by_pen(60));
  const Limits limits{.velocity = 80, .acceleration = 4000};
  const Plan plan = plan_of(move, limits);
  SpeedFit fit = fit_of(plan);
  ASSERT_TRUE(fit.found) << fit.reason;
  ASSERT_THAT(fit.tracks, SizeIs(1));
  EXPECT_GE(fit.tracks[0].speed.size(), 60U);
  add_fewer_values(plan, fit, {});
  ASSERT_TRUE(fit.tracks[0].fewer.has_value());
  const FewerValues& fewer = *fit.tracks[0].fewer;
  EXPECT_LE(fewer.speed.size(), 48U);
  EXPECT_GE(fewer.further_share, 0);
  EXPECT_LT(fewer.further_share, 0.3);
  EXPECT_TRUE(check(plan_of(with_speed(move, "move.toml", 0, fewer.speed), limits)).fits());

  char* said = nullptr;
  std::size_t size = 0;
  std::FILE* const out = open_memstream(&said, &size);
  print_fit(plan, fit, 96, "fitted.toml", out);
  std::fclose(out);
  EXPECT_THAT(said,
              HasSubstr(fmt::format("\n  editable in {} values: {:.2g} % further from yours: speed = [0, 0",
                                    fewer.speed.size(), 100 * fewer.further_share)));
  std::free(said);
}

TEST(SpeedFit, ACurveOfFewValuesIsEditableAsItIs) {
  const Plan plan = plan_of(move_of(bends + peaked), {.velocity = 110, .acceleration = 4000});
  SpeedFit fit = fit_of(plan);
  ASSERT_TRUE(fit.found) << fit.reason;
  add_fewer_values(plan, fit, {});
  EXPECT_FALSE(fit.tracks[0].fewer.has_value());
}

TEST(SpeedFit, AccelerationAndJerkFitToo) {
  const std::string move = move_of(bends + peaked);
  for (const Limits& limits : {Limits{.velocity = 500, .acceleration = 190},
                               Limits{.velocity = 500, .acceleration = 500, .more = "max_jerk = 1000"}}) {
    const SpeedFit fit = fit_of(plan_of(move, limits));
    ASSERT_TRUE(fit.found) << fit.reason;
    EXPECT_TRUE(check(written(move, fit, limits)).fits());
  }
}

TEST(SpeedFit, AStepOfTheAccelerationIsALimitToo) {
  const std::string move = move_of("spline = \"catmull-rom\"\n" + bends + peaked, 200);
  Limits limits{
      .velocity = 500, .acceleration = 500, .more = "max_jerk = 9000\nmax_acceleration_step = 9000"};
  double largest = 0;
  for (const CheckedStep& step : check(plan_of(move, limits)).steps)
    largest = std::max(largest, step.acceleration);
  limits.more = fmt::format("max_jerk = 9000\nmax_acceleration_step = {}", 0.8 * largest);
  ASSERT_FALSE(check(plan_of(move, limits)).fits());
  const SpeedFit fit = fit_of(plan_of(move, limits));
  ASSERT_TRUE(fit.found) << fit.reason;
  EXPECT_TRUE(check(written(move, fit, limits)).fits());
}

TEST(SpeedFit, WhereAFewValuesAreTooStiffTheCurveIsRefined) {
  const std::string move = move_of(bends + "speed = [0, 0, 10, 0, 0]\n");
  const Limits limits{.velocity = 150, .acceleration = 300};
  const Plan plan = plan_of(move, limits);
  ASSERT_FALSE(check(plan).fits());
  const SpeedFit fit = fit_of(plan);
  ASSERT_TRUE(fit.found) << fit.reason;
  EXPECT_GT(fit.tracks.at(0).refinements, 0) << "one free value can not change at equal Phi(f)";
  EXPECT_EQ(fit.tracks[0].speed.size(), (std::size_t{4} << fit.tracks[0].refinements) + 1);
  EXPECT_TRUE(check(written(move, fit, limits)).fits());
}

const std::string halting = "speed = [0, 0, 6, 16, 6, 6, 6, 6, 0, 0]\n";

TEST(SpeedFit, LockedKeysAndHoldsAreMetAsBefore) {
  const std::string locked = with(with(bends, "[60, 40] }", "[60, 40], frame = 70 }"), "[110, -20] }",
                                  "[110, -20], frame = 120, hold = 24 }");
  const std::string move = move_of(locked + halting, 240);
  const double peak = check(plan_of(move, {.velocity = 1e4, .acceleration = 1e4})).axes[1].velocity.value;
  for (const double share : {0.97, 0.9, 0.8}) {
    const Limits limits{.velocity = share * peak, .acceleration = 400};
    const Plan plan = plan_of(move, limits);
    ASSERT_FALSE(check(plan).fits());
    const SpeedFit fit = fit_of(plan);
    ASSERT_TRUE(fit.found) << share << ": " << fit.reason;
    const Plan after = written(move, fit, limits);
    EXPECT_TRUE(check(after).fits());
    std::vector<double> at(2);
    after.tracks()[0].track().positions({70, 0}, at);
    EXPECT_NEAR(at[0], 60, 1e-6);
    for (const std::int32_t frame : {120, 130, 144}) {
      after.tracks()[0].track().positions({frame, 0}, at);
      EXPECT_NEAR(at[0], 110, 1e-6) << frame;
    }
    EXPECT_LT(after.tracks()[0].key_timing()->largest_change, 1e-6) << "reading it again changes nothing";
    EXPECT_EQ(after.tracks()[0].key_timing()->refinements, 0);
  }
}

TEST(SpeedFit, EasedKeysWithoutAFrameAreMetWhenTheLimitsWantItAndThoseWithOneStay) {
  const std::string there =
      "corners = \"ease\"\nkeys = [ { at = [0, 0] }, { at = [90, 0] }, { at = [90, 20] }";
  const Limits limits{.velocity = 150, .acceleration = 400, .more = "max_jerk = 4000"};
  const std::string speed = "speed = [0, 0, 6, 6, 6, 0, 0]\n";
  for (const char* last : {", { at = [0, 0] } ]\n", ", { at = [0, 0], frame = 72 }, { at = [30, 0] } ]\n"}) {
    const std::string move = move_of("spline = \"linear\"\n" + there + last + speed);
    const Plan plan = plan_of(move, limits);
    ASSERT_THAT(check(plan).refusals, testing::Not(IsEmpty()));
    const SpeedFit fit = fit_of(plan);
    ASSERT_TRUE(fit.found) << fit.reason;
    const Plan after = written(move, fit, limits);
    EXPECT_TRUE(check(after).fits());
    const KeyTiming& timing = *after.tracks()[0].key_timing();
    EXPECT_LT(timing.largest_change, 1e-6) << "reading it again changes nothing";
    std::vector<double> at(2);
    for (const KeyLock& lock : timing.locks) {
      if (lock.key == 3 && lock.ease) {
        EXPECT_EQ(timing.frame_of(lock, 96), 72);
      }
      if (lock.key != 1) continue;
      const double frame = timing.frame_of(lock, 96);
      const auto whole = static_cast<std::int32_t>(frame);
      after.tracks()[0].track().positions({whole, frame - whole}, at);
      EXPECT_THAT(at, testing::ElementsAre(testing::DoubleNear(90, 1e-6), testing::DoubleNear(0, 1e-6)));
    }
  }
}

TEST(SpeedFit, AHoldWithoutAFrameIsRefusedWithTheFrameToWrite) {
  const std::string held = with(bends, "[110, -20] }", "[110, -20], hold = 24 }");
  const Plan plan = plan_of(move_of(held + halting, 240), {.velocity = 30});
  const SpeedFit fit = fit_of(plan);
  EXPECT_FALSE(fit.found);
  const std::int32_t frame = plan.tracks()[0].key_timing()->locks[1].frame;
  EXPECT_THAT(fit.reason, HasSubstr(fmt::format("frame = {}", frame)));
}

TEST(SpeedFit, WhatSlowingDoesNotCureIsSaid) {
  const std::string line = "spline = \"linear\"\n" + bends + peaked;
  EXPECT_THAT(fit_of(plan_of(move_of(line), {})).reason, HasSubstr("which no drive can follow"));
  const std::string far = with(bends, "[160, 10]", "[260, 10]");
  const SpeedFit beyond = fit_of(plan_of(move_of(far + peaked), {}));
  EXPECT_FALSE(beyond.found);
  EXPECT_THAT(beyond.reason, HasSubstr("move its keys inward"));
}

TEST(SpeedFit, ATrackTimedByFramesHasNoCurveToChange) {
  const std::string timed =
      "timing = \"frames\"\nkeys = [ { at = [10, 0], frame = 0 }, { at = [160, 10], frame = 96 } ]\n";
  const SpeedFit fit = fit_of(plan_of(move_of(timed), {.velocity = 10}));
  EXPECT_FALSE(fit.found);
  EXPECT_THAT(fit.reason, HasSubstr("timing = \"frames\""));
}

TEST(SpeedFit, FewerFramesThanAnyCurveNeedsAreRefusedAtOnce) {
  const SpeedFit fit = fit_of(plan_of(move_of(bends + peaked, 24), {}));
  EXPECT_FALSE(fit.found);
  EXPECT_THAT(fit.tracks, IsEmpty());
  EXPECT_GT(fit.fewest.frames, 24);
  EXPECT_THAT(fit.reason, HasSubstr(fmt::format("at least {} frames", fit.fewest.frames)));
}

TEST(SpeedFit, ACurveThatNoFileHoldsIsRefusedBeforeTheSearch) {
  std::string speed = "speed = [0, 0";
  for (int i = 0; i < 1000; ++i) speed += ", 10";
  const std::string eased = with(bends, "[60, 40] }", "[60, 40], ease = true }");
  const std::string move = move_of(eased + speed + ", 0, 0]\n", 2400);
  const Plan plan = plan_of(move, {.velocity = 0.97 * check(plan_of(move, {})).axes[0].velocity.value});
  ASSERT_FALSE(check(plan).fits());
  ASSERT_GT(plan.tracks()[0].control_values().size(), max_control_values);
  bool has_begun = false;
  try {
    fit_speed(plan, check(plan), {.progress = [&](double) { has_begun = true; }});
    ADD_FAILURE() << "was not refused";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("move.toml:7:9: "), HasSubstr("4013 control values"),
                                    HasSubstr("at most 2048; draw it with fewer")));
  }
  EXPECT_FALSE(has_begun);
}

TEST(SpeedFit, WhereNoneIsFoundTheNearestTellsWhatIsInTheWay) {
  const Plan plan = plan_of(move_of(bends + peaked, 72), {.velocity = 150, .acceleration = 182});
  const SpeedFit fit = fit_of(plan);
  ASSERT_FALSE(fit.found);
  ASSERT_LE(fit.fewest.frames, 72) << "the bound alone does not refuse it";
  EXPECT_THAT(fit.reason,
              AllOf(HasSubstr("no speed curve was found"), HasSubstr("and max_acceleration is 182")));
}

TEST(SpeedFit, IsNotSearchedForWhereTwoLockedKeysProveThatThereIsNone) {
  const std::string locked = "keys = [{ at = [-50, 0] }, { at = [50, 0], frame = 48 }, { at = [150, 0] }]\n";
  const Plan plan = plan_of(move_of(locked + "speed = [10, 10]\n", 192), {.velocity = 40});
  bool has_begun = false;
  const SpeedFit fit = fit_speed(plan, check(plan), {.progress = [&](double) { has_begun = true; }});
  EXPECT_FALSE(has_begun);
  ASSERT_FALSE(fit.found);
  ASSERT_LE(fit.fewest.frames, 192) << "the whole path has frames enough";
  EXPECT_THAT(fit.reason, AllOf(HasSubstr("between key 0 on frame 0 and key 1 on frame 48 the path takes at "
                                          "least 60.0 frames, whatever the speed curve"),
                                HasSubstr("because of max_velocity of axis \"x\"")));
}

TEST(SpeedFit, IsTakenForQuickByItsValuesAndByItsKeysAndAxes) {
  EXPECT_TRUE(is_quick_to_fit(plan_of(move_of(bends + peaked), {})));
  std::string many_keys = "keys = [";
  for (int i = 0; i < 150; ++i) many_keys += fmt::format(" {{ at = [{}, {}] }},", i, i % 3);
  EXPECT_FALSE(is_quick_to_fit(plan_of(move_of(many_keys + "]\n" + peaked), {})));
  std::string many_values = "speed = [0, 0";
  for (int i = 0; i < 40; ++i) many_values += ", 5";
  EXPECT_FALSE(is_quick_to_fit(plan_of(move_of(bends + many_values + ", 0, 0]\n"), {})));
  std::string both_many = "speed = [0, 0";
  for (int i = 0; i < 20; ++i) both_many += ", 5";
  std::string keys = "keys = [";
  for (int i = 0; i < 90; ++i) keys += fmt::format(" {{ at = [{}, {}] }},", i, i % 3);
  EXPECT_FALSE(is_quick_to_fit(plan_of(move_of(keys + "]\n" + both_many + ", 0, 0]\n"), {})));
}

TEST(SpeedFit, OfHundredsOfValuesIsFound) {
  std::string speed = "speed = [0, 0";
  for (int i = 0; i < 400; ++i) speed += fmt::format(", {}", 6 + i * 7 % 5 + (i / 50 % 2) * 6);
  const std::string move = move_of(bends + speed + ", 0, 0]\n", 3000);
  const CheckReport loose = check(plan_of(move, {.velocity = 1e4, .acceleration = 1e5}));
  const Limits tight{.velocity = 0.8 * loose.axes[0].velocity.value,
                     .acceleration = 0.7 * loose.axes[0].acceleration.value};
  const Plan plan = plan_of(move, tight);
  ASSERT_FALSE(check(plan).fits());
  const SpeedFit fit = fit_of(plan);
  ASSERT_TRUE(fit.found) << fit.reason;
  EXPECT_EQ(fit.tracks.front().refinements, 0);
  EXPECT_TRUE(check(written(move, fit, tight)).fits());
}

TEST(SpeedFit, EndsWhenItIsToldToWithWhatItHas) {
  const std::string move = move_of(bends + peaked);
  const Limits limits{.velocity = 110, .acceleration = 4000};
  const Plan plan = plan_of(move, limits);
  int found_early = 0;
  double least = 1e300;
  for (int steps = 0; steps < 400; ++steps) {
    int asked = 0;
    const SpeedFit fit = fit_speed(plan, check(plan), {.is_over = [&] { return asked++ >= steps; }});
    if (!fit.found) {
      EXPECT_THAT(fit.reason, HasSubstr("the search was ended"));
      EXPECT_THAT(fit.tracks, IsEmpty());
    } else {
      EXPECT_TRUE(check(written(move, fit, limits)).fits()) << steps;
      least = std::min(least, fit.tracks[0].change);
      if (!fit.was_ended) break;
      ++found_early;
    }
  }
  EXPECT_GT(found_early, 0) << "it has a curve before it is sure that there is none nearer";
  EXPECT_EQ(least, fit_of(plan).tracks[0].change) << "and then it has the nearest";
}

TEST(SpeedFit, OnlyTheTrackThatBreaksALimitChanges) {
  const std::string two =
      "name = \"m\"\nfps = 24\nframes = 96\n[[track]]\naxes = [\"x\"]\nkeys = [ { at = [0] }, { at = [90] } "
      "]\n" +
      peaked + "[[track]]\naxes = [\"y\"]\nkeys = [ { at = [0] }, { at = [150] } ]\n" + peaked;
  const Limits limits{.velocity = 80};
  const SpeedFit fit = fit_of(plan_of(two, limits));
  ASSERT_TRUE(fit.found) << fit.reason;
  ASSERT_THAT(fit.tracks, SizeIs(1));
  EXPECT_EQ(fit.tracks[0].track, 1U);
  const Plan after = written(two, fit, limits);
  EXPECT_TRUE(check(after).fits());
  EXPECT_THAT(after.move().tracks[0].speed, ElementsAreArray({0, 0, 6, 16, 6, 6, 0, 0}));
}

TEST(SpeedFit, ProgressNeverFallsAndEndsBelowOne) {
  const Plan plan = plan_of(move_of(bends + peaked), {.velocity = 110});
  std::vector<double> shares;
  static_cast<void>(
      fit_speed(plan, check(plan), {.progress = [&](double share) { shares.push_back(share); }}));
  EXPECT_GE(shares.size(), 10U) << "it goes on with every step";
  EXPECT_TRUE(std::ranges::is_sorted(shares));
  EXPECT_THAT(shares, Each(testing::Lt(1)));
}

/// Largest over smallest acceleration across the path, v^2 times curvature, where an ellipse is travelled at
/// full speed.
double unevenness(const Plan& plan) {
  const Track& track = plan.tracks()[0].track();
  double largest = 0;
  double smallest = 1e300;
  std::vector<AxisMotion> at(2);
  for (std::int32_t frame = track.frames() / 4; frame <= track.frames() * 3 / 4; ++frame) {
    track.motion({frame, 0}, at);
    const double speed = std::hypot(at[0].velocity, at[1].velocity);
    const double across =
        std::abs(at[0].velocity * at[1].acceleration - at[1].velocity * at[0].acceleration) / speed;
    largest = std::max(largest, across);
    smallest = std::min(smallest, across);
  }
  return largest / smallest;
}

TEST(SpeedFit, TheCurvatureStartMakesTheAccelerationAcrossAnEllipseEven) {
  std::string keys = "closed = true\nkeys = [";
  for (int i = 0; i < 16; ++i) {
    const double angle = 2 * 3.14159265358979 * i / 16;
    keys += fmt::format(" {{ at = [{}, {}] }},", 100 + 90 * std::cos(angle), 30 * std::sin(angle));
  }
  const std::string move = move_of(keys +
                                       " ]\nspeed = [0, 0, 10, 10, 10, 10, 10, 10, 10, 10, 10, 10, 10, 10, "
                                       "10, 10, 10, 10, 10, 10, 10, 10, 10, "
                                       "0, 0]\n",
                                   240);
  const Limits limits{.velocity = 500, .acceleration = 68};
  const Plan plan = plan_of(move, limits);
  ASSERT_FALSE(check(plan).fits());
  const SpeedFit drawn = fit_of(plan);
  const SpeedFit curved = fit_of(plan, FitStart::curvature);
  ASSERT_TRUE(drawn.found) << drawn.reason;
  ASSERT_TRUE(curved.found) << curved.reason;
  EXPECT_LT(unevenness(written(move, curved, limits)), 0.5 * unevenness(written(move, drawn, limits)));
  EXPECT_GT(curved.tracks[0].change, drawn.tracks[0].change) << "the price of it";
}

TEST(SpeedFit, TheDetourIsTakenWhereItLeadsNearer) {
  std::vector<AxisText> axes{{.name = "x"}, {.name = "y"}, {.name = "z"}};
  for (AxisText& axis : axes) {
    axis.min = -1000;
    axis.max_acceleration = 20000;
  }
  axes[0].max_velocity = 303.429;
  axes[1].max_velocity = 180.939;
  axes[2].max_velocity = 176.063;
  const std::string move =
      "name = \"m\"\nfps = 24\nframes = 225\n[[track]]\naxes = [\"x\", \"y\", \"z\"]\nspline = \"tcb\"\nkeys "
      "= [\n"
      "{ at = [-147, 142, 120], tension = -0.39, bias = 0.16 },\n"
      "{ at = [-32, -174, -134], tension = -0.06, bias = 0.24 },\n"
      "{ at = [40, 180, 130], tension = -0.25, bias = 0.04 },\n"
      "{ at = [-59, -14, -30], tension = 0.36, bias = -0.11 },\n"
      "{ at = [-5, 134, 127], tension = -0.07, bias = 0.24 } ]\n"
      "speed = [0, 0, 15, 16, 0, 0]\n";
  const Plan plan(parse_move(move, "move.toml"), parse_rig(rig_text(axes), "rig.toml"), {});
  const auto change_from = [&](FitStart start) {
    const SpeedFit fit = fit_of(plan, start);
    return fit.tracks.empty() ? 0 : fit.tracks.front().change;
  };
  const double drawn = change_from(FitStart::drawn);
  const double curved = change_from(FitStart::curvature);
  EXPECT_GT(curved, 0);
  EXPECT_LT(curved, drawn);
  EXPECT_DOUBLE_EQ(change_from(FitStart::either), curved);
}

TEST(SpeedFit, OfFewValuesUsesTheLimitsUpToWhatIsProven) {
  const std::vector<AxisText> axes{
      {.name = "x", .min = -1000, .max_velocity = 130.5, .max_acceleration = 49800},
      {.name = "y", .min = -1000, .max_velocity = 91.27, .max_acceleration = 25830},
      {.name = "z", .min = -1000, .max_velocity = 72.55, .max_acceleration = 17920}};
  const std::string move =
      "name = \"m\"\nfps = 24\nframes = 94\n[[track]]\naxes = [\"x\", \"y\", \"z\"]\n"
      "keys = [ { at = [59, 78, 55] }, { at = [79, 64, 25] }, { at = [10, 9, 58] },\n"
      "{ at = [97, 6, 27] }, { at = [30, 51, 26] }, { at = [89, 31, 13] } ]\n"
      "speed = [0, 0, 5, 11, 6, 18, 3, 14, 16, 9, 18, 16, 7, 14, 2, 7, 14, 19, 4, 17, 12, 0, 0]\n";
  const SpeedFit fit = fit_of(Plan(parse_move(move, "move.toml"), parse_rig(rig_text(axes), "rig.toml"), {}));
  ASSERT_TRUE(fit.found) << fit.reason;
  // 0.1906 if no curve is tried with hardly any margin.
  EXPECT_LT(fit.tracks[0].change_share, 0.19);
}

TEST(SpeedFit, ManyKeysOnALineAreFittedAsItsTwoEnds) {
  const auto line_of = [](int keys) {
    std::string track = "keys = [";
    for (int k = 0; k < keys; ++k) {
      const double x = 160.0 * k / (keys - 1);
      track += fmt::format(" {{ at = [{}, {}] }},", x, x / 2);
    }
    return move_of(track + " ]\n" + peaked);
  };
  const Limits limits{.velocity = 80, .acceleration = 120};
  const SpeedFit of_two = fit_of(plan_of(line_of(2), limits), FitStart::drawn);
  const SpeedFit of_many = fit_of(plan_of(line_of(700), limits), FitStart::drawn);
  ASSERT_TRUE(of_two.found) << of_two.reason;
  ASSERT_TRUE(of_many.found) << of_many.reason;
  EXPECT_NEAR(of_many.tracks[0].change, of_two.tracks[0].change, 0.03 * of_two.tracks[0].change);
}

}  // namespace speed_fit_test
}  // namespace inbetween
