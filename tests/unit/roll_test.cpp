#include "inbetween/limits/roll.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include "tests/support/roll_keeps.hpp"

namespace inbetween {
namespace roll_test {

constexpr FrameRate film{24, 1};
constexpr double infinity = std::numeric_limits<double>::infinity();

RollAxis pre_roll(const AxisMotion& joint, std::int32_t frames, FrameRate fps = film) {
  return *RollAxis::make({RollEnd::before, 0, frames, fps}, joint);
}

RollAxis post_roll(const AxisMotion& joint, std::int32_t frames, std::int32_t last_frame = 240) {
  return *RollAxis::make({RollEnd::after, last_frame, frames, film}, joint);
}

AxisLimits limits_of(const AxisLimitsSpec& spec) {
  return *AxisLimits::make(spec);
}

AxisLimits wide(double max_velocity, double max_acceleration) {
  return limits_of(
      {.min = -1e6, .max = 1e6, .max_velocity = max_velocity, .max_acceleration = max_acceleration});
}

/// The axes of a machine on the frame where roll and move meet.
struct Machine {
  std::vector<AxisMotion> joints;
  std::vector<AxisLimits> limits;

  RollRequest before() const { return {RollEnd::before, 0, film, joints, limits}; }
  RollRequest after(std::int32_t last_frame) const {
    return {RollEnd::after, last_frame, film, joints, limits};
  }
};

bool says(const char* text, const std::string& word) {
  return std::string(text).find(word) != std::string::npos;
}

// --- one axis

TEST(Roll, AnAxisThatRestsStaysWhereItIs) {
  const auto roll = post_roll({.position = 0.1}, 7);
  for (const std::int32_t frame : {240, 243, 247, 300}) {
    const AxisMotion at = roll.motion({frame, 0});
    EXPECT_EQ(at.position, 0.1);
    EXPECT_EQ(at.velocity, 0);
    EXPECT_EQ(at.acceleration, 0);
    EXPECT_EQ(at.jerk, 0);
  }
  const AxisPeaks peaks = roll.peaks();
  EXPECT_EQ(peaks.lowest.value, 0.1);
  EXPECT_EQ(peaks.highest.value, 0.1);
  EXPECT_EQ(peaks.velocity.value, 0);
  EXPECT_EQ(peaks.acceleration.value, 0);
  EXPECT_EQ(peaks.jerk.value, 0);
}

TEST(Roll, JoinsTheMoveToTheLastBitAndRestsExactly) {
  const AxisMotion joint{1234.1, -0.7, 3.3, 0};
  for (const std::int32_t frames : {1, 3, 7, 49, 1001}) {
    for (const auto& roll : {pre_roll(joint, frames), post_roll(joint, frames)}) {
      const RollSpan span = roll.span();
      const AxisMotion met = roll.motion({span.joint_frame, 0});
      EXPECT_EQ(met.position, joint.position);
      EXPECT_EQ(met.velocity, joint.velocity);
      EXPECT_EQ(met.acceleration, joint.acceleration);
      const std::int32_t away = span.end == RollEnd::before ? -frames : frames;
      const AxisMotion at_rest = roll.motion({span.joint_frame + away, 0});
      EXPECT_EQ(at_rest.velocity, 0);
      EXPECT_EQ(at_rest.acceleration, 0);
      EXPECT_EQ(at_rest.position, roll.rest_position());
    }
  }
}

TEST(Roll, HoldsStillBeyondTheFarEnd) {
  const auto before = pre_roll({.position = 1, .velocity = 2, .acceleration = 3}, 10);
  const auto after = post_roll({.position = 1, .velocity = 2, .acceleration = 3}, 10);
  for (const AxisMotion& at : {before.motion({-11, 0.5}), before.motion({-12, 0})}) {
    EXPECT_EQ(at.position, before.rest_position());
    EXPECT_EQ(at.velocity, 0);
    EXPECT_EQ(at.jerk, 0);
  }
  for (const AxisMotion& at : {after.motion({250, 0.5}), after.motion({252, 0})}) {
    EXPECT_EQ(at.position, after.rest_position());
    EXPECT_EQ(at.velocity, 0);
    EXPECT_EQ(at.jerk, 0);
  }
}

TEST(Roll, FromRestToASteadySpeedIsTheQuarticThatPaperAndPencilGive) {
  // 12 unit/s in one second: p = 100 + 12 t - 12 t^3 - 6 t^4.
  const auto roll = pre_roll({.position = 100, .velocity = 12}, 24);
  EXPECT_EQ(roll.seconds(), 1);
  const std::array<double, 5> c = roll.coefficients();
  EXPECT_EQ(c[0], 100);
  EXPECT_EQ(c[1], 12);
  EXPECT_EQ(c[2], 0);
  EXPECT_DOUBLE_EQ(c[3], -12);
  EXPECT_DOUBLE_EQ(c[4], -6);
  EXPECT_DOUBLE_EQ(roll.rest_position(), 94);
  const AxisMotion half = roll.motion({-12, 0});
  EXPECT_DOUBLE_EQ(half.position, 100 - 6 + 1.5 - 0.375);
  EXPECT_DOUBLE_EQ(half.velocity, 6);
  EXPECT_DOUBLE_EQ(half.acceleration, 18);
  EXPECT_NEAR(half.jerk, 0, 1e-13);
  const AxisPeaks peaks = roll.peaks();
  EXPECT_NEAR(peaks.lowest.value, 94, 1e-10);
  EXPECT_EQ(peaks.highest.value, 100);
  EXPECT_EQ(peaks.velocity.value, 12);
  EXPECT_NEAR(peaks.acceleration.value, 18, 1e-12);
  EXPECT_DOUBLE_EQ(peaks.acceleration.frame, -12);
  EXPECT_NEAR(peaks.jerk.value, 72, 1e-11);
}

TEST(Roll, ThePostRollIsTheMirrorImageOfAPreRoll) {
  const auto before = pre_roll({3.5, 1.7, 0.9, 0}, 31);
  const auto after = post_roll({3.5, -1.7, 0.9, 0}, 31);
  for (std::int32_t i = 0; i <= 31; ++i) {
    const AxisMotion a = before.motion({-i, 0});
    const AxisMotion b = after.motion({240 + i, 0});
    EXPECT_EQ(a.position, b.position);
    EXPECT_EQ(a.velocity, -b.velocity);
    EXPECT_EQ(a.acceleration, b.acceleration);
    EXPECT_EQ(a.jerk, -b.jerk);
  }
  EXPECT_EQ(before.peaks().lowest.value, after.peaks().lowest.value);
  EXPECT_EQ(before.peaks().jerk.value, after.peaks().jerk.value);
}

/// So many seconds from the joint.
double position_after(const RollAxis& roll, double seconds) {
  double sum = 0;
  const std::array<double, 5> c = roll.coefficients();
  for (std::size_t power = c.size(); power-- > 0;) sum = sum * seconds + c[power];
  return sum;
}

TEST(Roll, FramesAndSecondsMeanTheSamePlace) {
  const FrameRate ntsc{24000, 1001};
  const AxisMotion joint{.position = 10, .velocity = 4, .acceleration = -3};
  const auto before = pre_roll(joint, 12, ntsc);
  EXPECT_NEAR(before.seconds(), 12 * 1001.0 / 24000, 1e-15);
  const auto after = *RollAxis::make({RollEnd::after, 100, 12, ntsc}, joint);
  for (const double frames : {0.25, 3.0, 6.5, 11.75}) {
    const double seconds = frames * 1001 / 24000;
    const double down = std::floor(-frames);
    const auto earlier = before.motion({static_cast<std::int32_t>(down), -frames - down});
    EXPECT_NEAR(earlier.position, position_after(before, -seconds), 1e-13);
    const auto whole = static_cast<std::int32_t>(frames);
    const auto later = after.motion({100 + whole, frames - whole});
    EXPECT_NEAR(later.position, position_after(after, seconds), 1e-13);
  }
}

TEST(Roll, AMoveThatStartsBrakingIsReachedFromAHigherSpeed) {
  // v = 1, a = -6, T = 1: the speed is u^2 (9 - 8 u), largest at u = 3/4.
  const auto peaks = pre_roll({.position = 0, .velocity = 1, .acceleration = -6}, 24).peaks();
  EXPECT_NEAR(peaks.velocity.value, 1.6875, 1e-12);
  EXPECT_NEAR(peaks.velocity.frame, -6, 1e-12);
}

TEST(Roll, AMoveThatStartsSlowlyButPushedHardIsReachedByBackingUp) {
  // v = 1, a = 8, T = 1: the speed is u^2 (6 u - 5), so the axis turns at u = 5/6 and rests 1/6 above the
  // joint.
  const auto peaks = pre_roll({.position = 0, .velocity = 1, .acceleration = 8}, 24).peaks();
  EXPECT_NEAR(peaks.highest.value, 1.0 / 6, 1e-12);
  EXPECT_EQ(peaks.highest.frame, -24);
  const double turn = 5.0 / 6;
  EXPECT_NEAR(peaks.lowest.value, (1.5 * std::pow(turn, 4) - 5.0 / 3 * std::pow(turn, 3)) - (1.5 - 5.0 / 3),
              1e-12);
  EXPECT_NEAR(peaks.lowest.frame, -4, 1e-12);
  EXPECT_EQ(peaks.acceleration.value, 8);
}

TEST(Roll, PeaksCarryTheFrameNumbersOfTheMove) {
  const auto before = pre_roll({.position = 5, .velocity = 10}, 48).peaks();
  EXPECT_EQ(before.lowest.frame, -48);
  EXPECT_EQ(before.highest.frame, 0);
  const auto after = post_roll({.position = 5, .velocity = 10}, 48, 240).peaks();
  EXPECT_EQ(after.highest.frame, 288);
  EXPECT_EQ(after.lowest.frame, 240);
  EXPECT_DOUBLE_EQ(after.acceleration.frame, 264);
}

TEST(Roll, WhatDoesNotMakeARollIsRefused) {
  const AxisMotion joint{.position = 0, .velocity = 1};
  const auto refusal = [&](const RollSpan& span, const AxisMotion& at) {
    const auto roll = RollAxis::make(span, at);
    EXPECT_FALSE(roll.has_value());
    return roll.has_value() ? ErrorCode{} : roll.error().code;
  };
  const RollSpan span{RollEnd::before, 0, 24, film};
  EXPECT_EQ(refusal({RollEnd::before, 0, 0, film}, joint), ErrorCode::out_of_range);
  EXPECT_EQ(refusal({RollEnd::before, 0, max_roll_frames + 1, film}, joint), ErrorCode::out_of_range);
  EXPECT_EQ(refusal({RollEnd::before, 0, 24, {24, 0}}, joint), ErrorCode::out_of_range);
  EXPECT_EQ(refusal({RollEnd::before, 0, 24, {-24, 1}}, joint), ErrorCode::out_of_range);
  EXPECT_EQ(refusal(span, {.position = infinity}), ErrorCode::not_finite);
  EXPECT_EQ(refusal(span, {.position = 0, .velocity = std::nan("")}), ErrorCode::not_finite);
  EXPECT_EQ(refusal(span, {.position = 0, .velocity = 0, .acceleration = -infinity}), ErrorCode::not_finite);
  EXPECT_EQ(refusal(span, {.position = 0, .velocity = 1e307}), ErrorCode::out_of_range);
  const RollSpan brief{RollEnd::before, 0, 1, {std::numeric_limits<std::int32_t>::max(), 1}};
  EXPECT_EQ(refusal(brief, {.position = 0, .velocity = 1e300}), ErrorCode::out_of_range);
}

// --- how many frames

TEST(RollFrames, NothingRollsWhereEveryAxisRests) {
  const Machine machine{{{.position = 5}, {.position = -5}}, {wide(1, 1), wide(1, 1)}};
  EXPECT_EQ(*roll_frames(machine.before()), 0);
  EXPECT_EQ(*roll_frames(machine.after(10)), 0);
}

TEST(RollFrames, IsTheLeastThatTheAccelerationAllows) {
  // 1.5 * 400 / 810 s are 17.8 frames.
  const Machine machine{{{.position = 0, .velocity = 400}}, {wide(500, 810)}};
  EXPECT_EQ(*roll_frames(machine.before()), 18);
  EXPECT_EQ(*roll_frames(machine.after(240)), 18);
  const AxisPeaks shorter = pre_roll(machine.joints.front(), 17).peaks();
  EXPECT_NEAR(shorter.acceleration.value, 600 * 24.0 / 17, 1e-9);
  EXPECT_NEAR(shorter.acceleration.frame, -8.5, 1e-12);
  EXPECT_FALSE(roll_keeps(machine.before(), 17));
  EXPECT_TRUE(roll_keeps(machine.before(), 18));
}

TEST(RollFrames, IsTheLeastThatTheJerkAllows) {
  // sqrt(6 * 400 / 2500) s are 23.5 frames.
  const Machine machine{
      {{.position = 0, .velocity = 400}},
      {limits_of(
          {.min = -1e6, .max = 1e6, .max_velocity = 500, .max_acceleration = 5000, .max_jerk = 2500})}};
  EXPECT_EQ(*roll_frames(machine.before()), 24);
  EXPECT_FALSE(roll_keeps(machine.before(), 23));
  EXPECT_TRUE(roll_keeps(machine.before(), 24));
}

TEST(RollFrames, OneNumberServesAllAxesOfAllTracks) {
  const Machine machine{{{.position = 0, .velocity = 400}, {.position = 3}, {.position = 0, .velocity = 90}},
                        {wide(500, 810), wide(1, 1), wide(100, 100)}};
  EXPECT_EQ(*roll_frames(machine.before()), 33);  // 1.5 * 90 / 100 s are 32.4
}

TEST(RollFrames, ASpeedThatIsTheLimitIsNoBreach) {
  const Machine machine{{{.position = 0, .velocity = 0.1}}, {wide(0.1, 1)}};
  EXPECT_TRUE(roll_frames(machine.before()).has_value());
}

TEST(RollFrames, TooLittleRoomBeforeTheFirstKeyIsRefusedWithAxisAndPlace) {
  const AxisLimits slider = limits_of({.min = 0, .max = 1500, .max_velocity = 500, .max_acceleration = 810});
  const Machine machine{{{.position = 3}, {.position = 100, .velocity = 400}}, {slider, slider}};
  const auto frames = roll_frames(machine.before());
  ASSERT_FALSE(frames.has_value());
  EXPECT_EQ(frames.error().code, ErrorCode::no_solution);
  EXPECT_EQ(frames.error().axis, 1);
  EXPECT_EQ(frames.error().frame, 0);
  EXPECT_TRUE(says(frames.error().what, "pre-roll leaves the range"));
  EXPECT_TRUE(says(frames.error().remedy, "first key"));
  // 18 frames are the least that the acceleration allows; they need 400 * 18 / 24 / 2 = 150.
  const auto obstacle = *roll_obstacle(machine.before());
  ASSERT_TRUE(obstacle.has_value());
  EXPECT_EQ(obstacle->axis, 1);
  EXPECT_EQ(obstacle->quantity, RollQuantity::position);
  EXPECT_FALSE(obstacle->at_joint);
  EXPECT_EQ(obstacle->frames, 18);
  EXPECT_EQ(obstacle->frame, -18);
  EXPECT_NEAR(obstacle->value, -50, 1e-9);
  EXPECT_EQ(obstacle->limit, 0);
}

TEST(RollFrames, TooLittleRoomBehindTheLastKeyIsRefusedThere) {
  const Machine machine{{{.position = 1400, .velocity = 400}},
                        {limits_of({.min = 0, .max = 1500, .max_velocity = 500, .max_acceleration = 810})}};
  const auto frames = roll_frames(machine.after(240));
  ASSERT_FALSE(frames.has_value());
  EXPECT_EQ(frames.error().frame, 240);
  EXPECT_TRUE(says(frames.error().what, "post-roll leaves the range"));
  EXPECT_TRUE(says(frames.error().remedy, "last key"));
  EXPECT_EQ((*roll_obstacle(machine.after(240)))->frame, 258);
}

TEST(RollFrames, ALongerRollFitsWhereShorterOnesBackIntoTheEnd) {
  // Axis 0: v = a = 1 with 0.6 of room behind it. The roll needs up to 0.75 of it, for 3 s, and less again
  // when it is so long that the axis starts from the other side. Axis 1 needs 2 s.
  const Machine machine{
      {{.position = 0.6, .velocity = 1, .acceleration = 1}, {.position = 0, .velocity = 4}},
      {limits_of({.min = 0, .max = 10, .max_velocity = 2, .max_acceleration = 2}), wide(5, 3.01)}};
  const auto frames = roll_frames(machine.before());
  ASSERT_TRUE(frames.has_value());
  EXPECT_GT(*frames, 7.6 * 24);
  EXPECT_LT(*frames, 7.8 * 24);
  EXPECT_TRUE(roll_keeps(machine.before(), *frames));
  for (std::int32_t fewer = 1; fewer < *frames; ++fewer) {
    EXPECT_FALSE(roll_keeps(machine.before(), fewer)) << fewer;
  }
  EXPECT_FALSE((*roll_obstacle(machine.before())).has_value());
}

TEST(RollFrames, NoRollBacksUpByLessThanConstantAccelerationDoes) {
  // v^2 / (2 a) is 0.5: with 0.49 of room no roll of whatever length will do.
  const Machine machine{
      {{.position = 0.49, .velocity = 1, .acceleration = 1}, {.position = 0, .velocity = 4}},
      {limits_of({.min = 0, .max = 1000, .max_velocity = 200, .max_acceleration = 2}), wide(5, 3.01)}};
  const auto obstacle = *roll_obstacle(machine.before());
  ASSERT_TRUE(obstacle.has_value());
  EXPECT_EQ(obstacle->axis, 0);
  EXPECT_EQ(obstacle->quantity, RollQuantity::position);
  EXPECT_EQ(obstacle->frames, 32);  // Newton's least for axis 1 is 31.9
}

TEST(RollFrames, WhatIsInTheWayIsToldForTheShortestRollThatIsGentleEnough) {
  // As above, with 0.501 of room: a little more than v^2 / (2 a), which would take a roll of 20 minutes.
  // Axis 1 needs 47.8 frames.
  const Machine machine{
      {{.position = 0.501, .velocity = 1, .acceleration = 1}, {.position = 0, .velocity = 4}},
      {limits_of({.min = 0, .max = 1e6, .max_velocity = 200, .max_acceleration = 2}), wide(5, 3.01)}};
  const auto obstacle = *roll_obstacle(machine.before());
  ASSERT_TRUE(obstacle.has_value());
  EXPECT_EQ(obstacle->axis, 0);
  EXPECT_EQ(obstacle->quantity, RollQuantity::position);
  EXPECT_EQ(obstacle->frames, 48);
}

TEST(RollFrames, OfTwoAxesThatLeaveTheirRangesTheFirstIsTold) {
  // Both back up as above; the second has even less room.
  const AxisLimits limits = limits_of({.min = 0, .max = 1e6, .max_velocity = 200, .max_acceleration = 2});
  const Machine machine{{{.position = 0.5011, .velocity = 1, .acceleration = 1},
                         {.position = 0.501, .velocity = 1, .acceleration = 1},
                         {.position = 0, .velocity = 4}},
                        {limits, limits, wide(5, 3.01)}};
  const auto obstacle = *roll_obstacle(machine.before());
  ASSERT_TRUE(obstacle.has_value());
  EXPECT_EQ(obstacle->axis, 0);
  EXPECT_EQ(obstacle->quantity, RollQuantity::position);
  EXPECT_EQ(obstacle->frames, 48);
}

TEST(RollFrames, AnAxisThatNoRollHelpsIsToldBeforeOneThatALongerRollHelps) {
  // Axis 0 backs up by 0.67 for 2 s, and by less than its room in a longer roll. Axis 1 needs 1.99 s, and a
  // way of 4 for them.
  const Machine machine{{{.position = 0.6, .velocity = 1, .acceleration = 1}, {.position = 3, .velocity = 4}},
                        {limits_of({.min = 0, .max = 10, .max_velocity = 2, .max_acceleration = 2}),
                         limits_of({.min = 0, .max = 10, .max_velocity = 5, .max_acceleration = 3.01})}};
  const auto obstacle = *roll_obstacle(machine.before());
  ASSERT_TRUE(obstacle.has_value());
  EXPECT_EQ(obstacle->axis, 1);
  EXPECT_EQ(obstacle->quantity, RollQuantity::position);
  EXPECT_EQ(obstacle->frames, 48);
}

TEST(RollFrames, AnOvershootOfTheSpeedLimitIsRefused) {
  const Machine machine{{{.position = 0, .velocity = 1, .acceleration = -6}}, {wide(1.01, 7)}};
  const auto frames = roll_frames(machine.before());
  ASSERT_FALSE(frames.has_value());
  EXPECT_TRUE(says(frames.error().what, "pre-roll exceeds max_velocity"));
  // After the move the same brakes it.
  EXPECT_TRUE(roll_frames(machine.after(240)).has_value());
}

TEST(RollFrames, ARollOfMinutesIsRefused) {
  const Machine machine{{{.position = 0, .velocity = 1}}, {wide(2, 1e-4)}};
  const auto frames = roll_frames(machine.before());
  ASSERT_FALSE(frames.has_value());
  EXPECT_TRUE(says(frames.error().what, "pre-roll exceeds max_acceleration"));
  EXPECT_EQ((*roll_obstacle(machine.before()))->frames, max_roll_frames);
  const double longest = max_roll_frames / 24.0;
  const Machine just{{{.position = 0, .velocity = 1}}, {wide(2, 1.5 / longest * 1.00001)}};
  EXPECT_EQ(*roll_frames(just.before()), max_roll_frames);
}

TEST(RollFrames, AMoveThatItselfBreaksALimitAtTheJointIsRefusedForThat) {
  const AxisLimits limits = limits_of({.min = 0, .max = 10, .max_velocity = 2, .max_acceleration = 3});
  struct Case {
    AxisMotion joint;
    RollQuantity quantity;
    std::string before, after;
  };
  const std::vector<Case> cases = {
      {{5, 2.5, 0, 0}, RollQuantity::velocity, "starts faster than max_velocity", "ends faster than"},
      {{5, 0, -3.5, 0},
       RollQuantity::acceleration,
       "starts with more than max_acceleration",
       "ends with more"},
      {{-1, 1, 0, 0}, RollQuantity::position, "starts outside the range", "ends outside the range"},
      {{11, 1, 0, 0}, RollQuantity::position, "starts outside the range", "ends outside the range"},
  };
  for (const Case& one : cases) {
    const Machine machine{{one.joint}, {limits}};
    EXPECT_TRUE(says(roll_frames(machine.before()).error().what, one.before));
    EXPECT_TRUE(says(roll_frames(machine.after(9)).error().what, one.after));
    const auto obstacle = *roll_obstacle(machine.after(9));
    ASSERT_TRUE(obstacle.has_value());
    EXPECT_TRUE(obstacle->at_joint);
    EXPECT_EQ(obstacle->quantity, one.quantity);
    EXPECT_EQ(obstacle->frame, 9);
  }
}

TEST(RollFrames, ARestingAxisOutsideItsRangeIsSeen) {
  const AxisLimits limits = limits_of({.min = 0, .max = 10, .max_velocity = 2, .max_acceleration = 3});
  const Machine machine{{{.position = 5, .velocity = 1}, {.position = 11}}, {limits, limits}};
  EXPECT_EQ(roll_frames(machine.before()).error().axis, 1);
}

TEST(RollFrames, EveryMovingAxisNeedsItsLimits) {
  const Machine machine{{{.position = 0, .velocity = 1}}, {}};
  EXPECT_EQ(roll_frames(machine.before()).error().code, ErrorCode::wrong_count);
  EXPECT_EQ(roll_obstacle(machine.before()).error().code, ErrorCode::wrong_count);
}

TEST(RollFrames, AFrameRateIsNeeded) {
  const Machine machine{{{.position = 0, .velocity = 1}}, {wide(1, 1)}};
  for (const FrameRate fps : {FrameRate{0, 1}, FrameRate{24, 0}, FrameRate{-24, 1}}) {
    const RollRequest request{RollEnd::before, 0, fps, machine.joints, machine.limits};
    EXPECT_EQ(roll_frames(request).error().code, ErrorCode::out_of_range);
  }
}

TEST(RollFrames, AnAxisWithoutAFiniteMotionIsNamed) {
  const Machine machine{{{.position = 0}, {.position = 0, .velocity = infinity}}, {wide(1, 1), wide(1, 1)}};
  const auto frames = roll_frames(machine.before());
  ASSERT_FALSE(frames.has_value());
  EXPECT_EQ(frames.error().code, ErrorCode::not_finite);
  EXPECT_EQ(frames.error().axis, 1);
}

}  // namespace roll_test
}  // namespace inbetween
