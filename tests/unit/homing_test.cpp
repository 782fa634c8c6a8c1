// Axes that look for their switches, with what switches do.
#include "inbetween/homing/homing.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "tests/support/simulated_homing.hpp"

namespace inbetween {
namespace homing_test {

constexpr int rate_hz = 1000;

/// Its switch is 30 mm below where it stands, it takes itself to be at 500, and the switch is at -2.
LostAxis slide(std::uint8_t line = 0) {
  return {.limits = {.velocity = 100, .acceleration = 400, .jerk = 4000, .min = -5, .max = 1000},
          .spec = {.towards_max = false,
                   .at = -2,
                   .fast = 40,
                   .slow = 1,
                   .search = 60,
                   .leave = 20,
                   .back_off = 3,
                   .home = {.line = line}},
          .there = {.line = line, .is_above = false, .closes = 70, .hysteresis = 0.5},
          .true_position = 100,
          .position = 500};
}
std::vector<LostAxis> three_slides() {
  std::vector<LostAxis> slides{slide(0), slide(1), slide(2)};
  slides[0].true_position = 90;
  slides[1].true_position = 110;
  return slides;
}

/// A millionth of a millimetre: 1 ns at 1 mm/s, and rounding.
constexpr double exact = 2e-6;

TEST(Homing, FindsItsSwitchAndKnowsWhereItIs) {
  SimulatedHoming homing({slide()}, rate_hz, 1);
  ASSERT_TRUE(homing.start());
  EXPECT_EQ(homing.run(), HomingState::done);
  EXPECT_EQ(homing.axis(0).phase(), HomingPhase::referenced);
  EXPECT_EQ(homing.axis(0).failure(), HomingFailure::none);
  EXPECT_NEAR(homing.error(0), 0, exact);
  EXPECT_NEAR(homing.axis(0).shift(), -2 - (500 - 30), exact);
  EXPECT_LE(homing.fastest(), 1);
  EXPECT_LE(homing.sharpest(), 1 + 1e-12);
}

TEST(Homing, BothDirectionsAndBothLevels) {
  for (const bool towards_max : {false, true}) {
    for (const bool active_level : {false, true}) {
      LostAxis lost = slide();
      lost.spec.towards_max = towards_max;
      lost.there.is_above = towards_max;
      lost.there.closes = towards_max ? 133 : 70;
      lost.there.active_level = active_level;
      lost.spec.home.active_level = active_level;
      SimulatedHoming homing({lost}, rate_hz, 1);
      ASSERT_TRUE(homing.start());
      EXPECT_EQ(homing.run(), HomingState::done);
      EXPECT_NEAR(homing.error(0), 0, exact);
    }
  }
}

/// Behind it the axis goes further than it may look for it: while it stops, and on the slow approach.
TEST(Homing, ASwitchAtTheVeryEndOfTheDistanceToLookForItIsFound) {
  LostAxis lost = slide();
  lost.spec.search = 30.02;
  lost.spec.leave = 0.01;
  SimulatedHoming homing({lost}, rate_hz, 1);
  ASSERT_TRUE(homing.start());
  EXPECT_EQ(homing.run(), HomingState::done);
  EXPECT_NEAR(homing.error(0), 0, exact);
}

TEST(Homing, AnAxisOnItsSwitchLeavesItFirst) {
  LostAxis lost = slide();
  lost.true_position = 62;
  SimulatedHoming homing({lost}, rate_hz, 1);
  ASSERT_TRUE(homing.start());
  ASSERT_TRUE(homing.run_to(0, HomingPhase::leaving));
  for (int i = 0; i < 20; ++i) homing.tick();
  EXPECT_GT(homing.setpoint(0).velocity, 0) << "away from the switch";
  EXPECT_EQ(homing.run(), HomingState::done);
  EXPECT_NEAR(homing.error(0), 0, exact);
}

TEST(Homing, TheSlowApproachIsSlow) {
  SimulatedHoming homing({slide()}, rate_hz, 1);
  ASSERT_TRUE(homing.start());
  ASSERT_TRUE(homing.run_to(0, HomingPhase::approaching));
  while (homing.axis(0).phase() != HomingPhase::referenced) {
    homing.tick();
    ASSERT_LE(std::fabs(homing.setpoint(0).velocity), 1);
  }
}

/// Most ticks are longer than it takes to be sure of an edge, or most are shorter.
TEST(Homing, AtAnyRate) {
  for (const int rate : {20, 50, 100, 250, 1000, 4000}) {
    SimulatedHoming homing({slide()}, rate, 1);
    ASSERT_TRUE(homing.start());
    EXPECT_EQ(homing.run(), HomingState::done);
    EXPECT_NEAR(homing.error(0), 0, exact) << rate;
  }
}

TEST(Homing, SpikesOnTheWayAreCountedAndPassedOver) {
  LostAxis lost = slide();
  lost.there.noise_hz = 8;
  SimulatedHoming homing({lost}, rate_hz, 3);
  ASSERT_TRUE(homing.start());
  EXPECT_EQ(homing.run(), HomingState::done);
  EXPECT_GT(homing.axis(0).home_switch().noise_count(), 3U);
  EXPECT_NEAR(homing.error(0), 0, 0.002) << "a spike less than 2 ms before the edge is taken for it";
}

/// At 40 mm/s 2 to 3 ms are 0.1 mm, more than there is to back off: the edge is looked for beyond.
TEST(Homing, ASpikeRightBeforeTheFastEdgeDoesNotHideTheSwitch) {
  LostAxis lost = slide();
  lost.there.hysteresis = 0;
  lost.spec.back_off = 0.05;
  lost.spec.home.quiet_ns = 3'000'000;
  SimulatedHoming homing({lost}, rate_hz, 1);
  ASSERT_TRUE(homing.start());
  while (homing.setpoint(0).position > 470.1) homing.tick();
  ASSERT_EQ(homing.axis(0).phase(), HomingPhase::searching);
  const std::int64_t now_ns = homing.now_ns();
  homing.spikes = {{.at_ns = now_ns - 20'000, .level = true}, {.at_ns = now_ns - 10'000, .level = false}};
  EXPECT_EQ(homing.run(), HomingState::done);
  EXPECT_EQ(homing.axis(0).home_switch().noise_count(), 0U) << "it was taken for the edge";
  EXPECT_NEAR(homing.error(0), 0, exact);
}

TEST(Homing, AxesHomeTogetherAndEndEachByItself) {
  SimulatedHoming homing(three_slides(), rate_hz, 1);
  ASSERT_TRUE(homing.start());
  ASSERT_TRUE(homing.run_to(0, HomingPhase::referenced));
  EXPECT_EQ(homing.homing().state(), HomingState::moving);
  EXPECT_EQ(homing.run(), HomingState::done);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(homing.error(i), 0, exact);
}

/// After a failure all axes have come to rest by their ramps, do not move again, and say why.
void expect_all_stop(SimulatedHoming& homing, std::int32_t axis, HomingFailure failure) {
  EXPECT_EQ(homing.run(), HomingState::failed);
  EXPECT_EQ(homing.homing().failed_axis(), axis);
  for (std::size_t i = 0; i < 3; ++i) {
    const bool is_it = static_cast<std::int32_t>(i) == axis || axis < 0;
    EXPECT_STREQ(words_of(homing.axis(i).failure()), words_of(is_it ? failure : HomingFailure::other_axis));
    EXPECT_EQ(homing.axis(i).phase(), HomingPhase::failed);
    EXPECT_EQ(homing.axis(i).shift(), 0);
  }
  EXPECT_LE(homing.sharpest(), 1 + 1e-12);
  for (int tick = 0; tick < 1000; ++tick) {
    homing.tick();
    for (std::size_t i = 0; i < 3; ++i) ASSERT_EQ(homing.setpoint(i).velocity, 0);
  }
}

/// docs/faults.md 33, and the bug report: a failed Z homing while X and Y went on.
TEST(HomingFault33, AStuckSwitchStopsAllHomingAxes) {
  std::vector<LostAxis> slides = three_slides();
  slides[2].true_position = 75;
  slides[2].there.fault = SimulatedSwitch::Fault::stuck;
  SimulatedHoming homing(slides, rate_hz, 1);
  ASSERT_TRUE(homing.start());
  ASSERT_TRUE(homing.run_to(2, HomingPhase::backing));
  EXPECT_NE(homing.setpoint(0).velocity, 0);
  EXPECT_NE(homing.setpoint(1).velocity, 0);
  expect_all_stop(homing, 2, HomingFailure::stuck);
}

TEST(HomingFault33, ASwitchThatIsStuckAtTheStartStopsAllHomingAxes) {
  std::vector<LostAxis> slides = three_slides();
  slides[2].true_position = 69;
  slides[2].there.fault = SimulatedSwitch::Fault::stuck;
  SimulatedHoming homing(slides, rate_hz, 1);
  ASSERT_TRUE(homing.start());
  expect_all_stop(homing, 2, HomingFailure::stuck);
  EXPECT_NEAR(homing.setpoint(2).position, 500 + slides[2].spec.leave, 1e-9) << "and no further";
}

TEST(HomingFault33, AnOpenSwitchStopsAllHomingAxes) {
  std::vector<LostAxis> slides = three_slides();
  for (LostAxis& each : slides) each.there.closes = 0;
  slides[2].there.fault = SimulatedSwitch::Fault::open;
  slides[2].spec.search = 25;
  SimulatedHoming homing(slides, rate_hz, 1);
  ASSERT_TRUE(homing.start());
  expect_all_stop(homing, 2, HomingFailure::never_reached);
  EXPECT_NEAR(homing.setpoint(2).position, 500 - slides[2].spec.search, 1e-9) << "and no further";
}

TEST(HomingFault33, ASwitchThatOpensForGoodBeforeTheSlowApproachStopsAllHomingAxes) {
  std::vector<LostAxis> slides = three_slides();
  slides[2].true_position = 75;
  SimulatedHoming homing(slides, rate_hz, 1);
  ASSERT_TRUE(homing.start());
  ASSERT_TRUE(homing.run_to(2, HomingPhase::approaching));
  homing.home_switch(2).set_fault(SimulatedSwitch::Fault::open);
  EXPECT_EQ(homing.run(), HomingState::failed);
  EXPECT_EQ(homing.axis(2).failure(), HomingFailure::never_reached);
}

TEST(HomingFault33, AChatteringSwitchStopsAllHomingAxes) {
  std::vector<LostAxis> slides = three_slides();
  slides[2].true_position = 75;
  slides[2].there.fault = SimulatedSwitch::Fault::chatter;
  SimulatedHoming homing(slides, rate_hz, 1);
  ASSERT_TRUE(homing.start());
  expect_all_stop(homing, 2, HomingFailure::chattering);
}

/// docs/faults.md 31: the events of every axis come from one queue, so that each of them may have lost one.
/// The first axis whose switch is asked is told.
TEST(HomingFault31, LostEdgesFailTheHomingAndNoAxisIsReferenced) {
  std::vector<LostAxis> slides = three_slides();
  for (LostAxis& each : slides) {
    each.there.bounce_s = 0.002;
    each.there.max_bounces = 5;
  }
  SimulatedHoming homing(slides, rate_hz, 1);
  ASSERT_TRUE(homing.start());
  ASSERT_TRUE(homing.run_to(0, HomingPhase::approaching));
  homing.loses_events = true;
  EXPECT_EQ(homing.run(), HomingState::failed);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(homing.axis(i).phase(), HomingPhase::failed);
    EXPECT_EQ(homing.axis(i).failure(), HomingFailure::events_lost);
    EXPECT_EQ(homing.axis(i).shift(), 0);
  }
}

/// Without a time the place of the edge is not known, even if no gap tells that its event was lost.
TEST(HomingFault31, AnEdgeThatOnlyTheLevelTellsIsNoReference) {
  SimulatedHoming homing({slide()}, rate_hz, 1);
  ASSERT_TRUE(homing.start());
  ASSERT_TRUE(homing.run_to(0, HomingPhase::approaching));
  homing.loses_events = true;
  EXPECT_EQ(homing.run(), HomingState::failed);
  EXPECT_EQ(homing.axis(0).failure(), HomingFailure::events_lost);
  EXPECT_NE(std::string(words_of(HomingFailure::events_lost)).find("lost"), std::string::npos);
}

TEST(Homing, ALimitSwitchADriveAndTheOperatorStopAllAxesInAnyPhase) {
  const std::array failures{HomingFailure::limit_hit, HomingFailure::drive_fault, HomingFailure::stopped};
  for (const HomingPhase phase :
       {HomingPhase::sensing, HomingPhase::searching, HomingPhase::overrunning, HomingPhase::turning,
        HomingPhase::backing, HomingPhase::approaching, HomingPhase::settling, HomingPhase::latching}) {
    for (const HomingFailure failure : failures) {
      std::vector<LostAxis> slides = three_slides();
      slides[1].true_position = 75;
      slides[1].there.bounce_s = 0.004;
      slides[1].there.max_bounces = 5;
      slides[1].spec.home.quiet_ns = 3'000'000;
      SimulatedHoming homing(slides, rate_hz, 1);
      ASSERT_TRUE(homing.start());
      ASSERT_TRUE(homing.run_to(1, phase)) << static_cast<int>(phase);
      homing.inputs[1].limit_hit = failure == HomingFailure::limit_hit;
      homing.inputs[1].drive_fault = failure == HomingFailure::drive_fault;
      if (failure == HomingFailure::stopped) homing.homing().stop();
      expect_all_stop(homing, failure == HomingFailure::stopped ? -1 : 1, failure);
    }
  }
}

TEST(Homing, HaltedAllAxesRestAtOnceAndAreNotReferenced) {
  SimulatedHoming homing(three_slides(), rate_hz, 1);
  ASSERT_TRUE(homing.start());
  ASSERT_TRUE(homing.run_to(0, HomingPhase::backing));
  homing.homing().halt();
  EXPECT_EQ(homing.homing().state(), HomingState::failed);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_TRUE(homing.free_axis(i).is_resting());
    EXPECT_EQ(homing.axis(i).failure(), HomingFailure::stopped);
  }
}

/// What has been measured before another axis failed is still true.
TEST(Homing, AnAxisThatIsReferencedStaysSo) {
  std::vector<LostAxis> slides = three_slides();
  slides[2].there.closes = 0;
  slides[2].spec.search = 500;
  slides[2].spec.fast = 5;
  SimulatedHoming homing(slides, rate_hz, 1);
  ASSERT_TRUE(homing.start());
  ASSERT_TRUE(homing.run_to(1, HomingPhase::referenced));
  homing.homing().stop();
  EXPECT_EQ(homing.run(), HomingState::failed);
  EXPECT_EQ(homing.axis(1).phase(), HomingPhase::referenced);
  EXPECT_NEAR(homing.error(1), 0, exact);
  EXPECT_EQ(homing.axis(2).failure(), HomingFailure::stopped);
}

TEST(Homing, AfterAFailureItCanBeginAgain) {
  SimulatedHoming homing({slide()}, rate_hz, 1);
  ASSERT_TRUE(homing.start());
  ASSERT_TRUE(homing.run_to(0, HomingPhase::searching));
  homing.homing().stop();
  EXPECT_EQ(homing.run(), HomingState::failed);
  ASSERT_TRUE(homing.start());
  EXPECT_EQ(homing.run(), HomingState::done);
  EXPECT_NEAR(homing.error(0), 0, exact);
}

TEST(Homing, RefusesToBeginAndSaysWhyAndOfWhichAxis) {
  SimulatedHoming homing(three_slides(), rate_hz, 1);
  const auto refused = [&](const char* what, std::int32_t axis) {
    const Status status = homing.start();
    ASSERT_FALSE(status);
    EXPECT_STREQ(status.error().what, what);
    EXPECT_EQ(status.error().axis, axis);
    EXPECT_GT(std::strlen(status.error().remedy), 0U);
    EXPECT_EQ(homing.axis(0).phase(), HomingPhase::waiting);
    EXPECT_EQ(homing.homing().state(), HomingState::waiting);
  };
  homing.inputs[1].limit_hit = true;
  refused("an axis stands on a limit switch", 1);
  homing.inputs[1] = {.drive_fault = true};
  refused("the drive of an axis has a fault", 1);
  homing.inputs[1] = {};
  ASSERT_TRUE(homing.free_axis(2).drive(10));
  refused("an axis moves already", 2);
  homing.free_axis(2).halt();
  ASSERT_TRUE(homing.free_axis(2).place(1e119));
  refused("the distances of the homing are too far to be computed", 2);
  ASSERT_TRUE(homing.free_axis(2).place(0));
  homing.inputs.pop_back();
  refused("the homing has not an input for every axis", -1);
  homing.inputs.emplace_back();
  ASSERT_TRUE(homing.start());
  EXPECT_FALSE(homing.start()) << "it is under way";
}

TEST(Homing, IllegalSpecsAreRefused) {
  using Spec = HomingSpec;
  FreeAxis axis = *FreeAxis::make(slide().limits, 0, 0.001);
  const auto is_legal = [&](const Spec& spec) { return AxisHoming::make(spec, axis).has_value(); };
  const Spec good = slide().spec;
  EXPECT_TRUE(is_legal(good));
  for (double Spec::*field : {&Spec::fast, &Spec::slow, &Spec::search, &Spec::leave, &Spec::back_off}) {
    for (const double value :
         {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
      Spec bad = good;
      bad.*field = value;
      EXPECT_FALSE(is_legal(bad));
    }
  }
  Spec bad = good;
  bad.at = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(is_legal(bad));
  bad = good;
  bad.fast = 100.5;
  EXPECT_FALSE(is_legal(bad)) << "faster than the axis";
  bad = good;
  bad.slow = 41;
  EXPECT_FALSE(is_legal(bad)) << "slower fast than slow";
  Spec even = good;
  even.slow = even.fast;
  EXPECT_TRUE(is_legal(even));
  bad = good;
  bad.home.quiet_ns = 0;
  EXPECT_FALSE(is_legal(bad));
}

}  // namespace homing_test
}  // namespace inbetween
