#include "inbetween/timing/track.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include "host_tools/plan/solved_track.hpp"

namespace inbetween {
namespace track_test {

struct Drawing {
  Spline spline = Spline::smooth;
  bool closed = false;
  std::int32_t axis_count = 1;
  std::vector<double> keys;
  std::vector<KeyShape> shapes = {};
  std::vector<double> speed;
  std::int32_t frames = 0;
  FrameRate fps = {24, 1};
};

SolvedTrack solved(const Drawing& drawing) {
  return SolvedTrack({.path = {.spline = drawing.spline,
                               .closed = drawing.closed,
                               .axis_count = drawing.axis_count,
                               .keys = drawing.keys,
                               .shapes = drawing.shapes},
                      .control_values = drawing.speed,
                      .frames = drawing.frames,
                      .fps = drawing.fps,
                      .arc_length = {}},
                     Solver::closed_form);
}

/// The error with which the core refuses a drawing.
Error refusal(const Drawing& drawing) {
  try {
    static_cast<void>(solved(drawing));
  } catch (const SolverError& error) {
    return error.error();
  }
  ADD_FAILURE() << "the drawing is not refused";
  return {};
}

AxisMotion motion(const SolvedTrack& solution, const FrameTime& time, std::size_t axis = 0,
                  std::uint8_t expected = 3) {
  std::vector<AxisMotion> axes(static_cast<std::size_t>(solution.track().path().axis_count()));
  EXPECT_EQ(solution.track().motion(time, axes), expected);
  return axes[axis];
}

double position(const SolvedTrack& solution, const FrameTime& time, std::size_t axis = 0) {
  std::vector<double> axes(static_cast<std::size_t>(solution.track().path().axis_count()));
  solution.track().positions(time, axes);
  return axes[axis];
}

void expect_motion(const AxisMotion& motion, const AxisMotion& expected, double tolerance) {
  EXPECT_NEAR(motion.position, expected.position, tolerance);
  EXPECT_NEAR(motion.velocity, expected.velocity, tolerance);
  EXPECT_NEAR(motion.acceleration, expected.acceleration, tolerance);
  EXPECT_NEAR(motion.jerk, expected.jerk, tolerance);
}

// --- closed forms

TEST(Track, OneControlValueIsConstantSpeed) {
  const auto line = solved({.keys = {10, 30}, .speed = {7}, .frames = 48});
  const double rounding = 500 * std::numeric_limits<double>::epsilon();
  for (const FrameTime& time : {FrameTime{0, 0}, {11, 0.25}, {47, 0.75}, {48, 0}}) {
    const double frame = static_cast<double>(time.frame) + time.fraction;
    expect_motion(motion(line, time), {10 + 20 * frame / 48, 10, 0, 0}, rounding);
  }
  EXPECT_NEAR(line.track().constant(), 20.0 / 7, rounding);
}

TEST(Track, TwoControlValuesAreConstantAcceleration) {
  // Two seconds, 20 units: v = 10 t, x = 5 t^2.
  const auto line = solved({.keys = {0, 20}, .speed = {0, 3}, .frames = 50, .fps = {25, 1}});
  const double rounding = 500 * std::numeric_limits<double>::epsilon();
  for (const FrameTime& time : {FrameTime{0, 0}, {10, 0.5}, {25, 0}, {50, 0}}) {
    const double t = (static_cast<double>(time.frame) + time.fraction) / 25;
    expect_motion(motion(line, time), {5 * t * t, 10 * t, 10, 0}, rounding);
  }
}

TEST(Track, TimeIsCountedInTheFramesOfTheRate) {
  const auto line = solved({.keys = {0, 20}, .speed = {1}, .frames = 24, .fps = {24000, 1001}});
  EXPECT_NEAR(motion(line, {7, 0}).velocity, 20 / 1.001, 500 * std::numeric_limits<double>::epsilon());
}

TEST(Track, ABellOfSpeedHasTheDerivativesOfItsFormula) {
  // phi = 6 a - 2 a^3 for a <= 1, Phi(2) = 5; at one a a second the line is 10 long, so K = 2.
  const auto line = solved({.keys = {0, 10}, .speed = {0, 6, 0}, .frames = 100, .fps = {50, 1}});
  for (const double a : {0.0, 0.2, 0.5, 0.98}) {
    const double frame = 50 * a;
    const auto whole = static_cast<std::int32_t>(frame);
    const auto at = motion(line, {whole, frame - whole});
    expect_motion(
        at, {2 * (3 * a * a - a * a * a * a / 2), 2 * (6 * a - 2 * a * a * a), 2 * (6 - 6 * a * a), -24 * a},
        1e-12);
  }
}

TEST(Track, AlongAParabolaAtConstantSpeedEveryDerivativeIsTheFormula) {
  // The middle segment is (u, u^2); with g = 1 + 4 u^2 and speed v: u' = v g^(-1/2),
  // u'' = -4 u v^2 g^-2, u''' = v^3 (64 u^2 - 4 g) g^(-7/2).
  const auto path = solved({.spline = Spline::catmull_rom,
                            .axis_count = 2,
                            .keys = {-3, 9, -1, 1, 1, 1, 3, 9},
                            .speed = {5},
                            .frames = 60});
  const double v = path.track().arc_length().total() / 2.5;
  for (const FrameTime& time : {FrameTime{26, 0.3}, {30, 0}, {32, 0.7}}) {
    const auto x = motion(path, time, 0);
    const double u = x.position;
    ASSERT_LT(std::fabs(u), 1) << "not in the middle segment";
    const double g = 1 + 4 * u * u;
    const double u1 = v / std::sqrt(g);
    const double u2 = -4 * u * v * v / (g * g);
    const double u3 = v * v * v * (64 * u * u - 4 * g) * std::pow(g, -3.5);
    expect_motion(x, {u, u1, u2, u3}, 1e-11 * v * v * v);
    expect_motion(motion(path, time, 1),
                  {u * u, 2 * u * u1, 2 * (u1 * u1 + u * u2), 2 * (3 * u1 * u2 + u * u3)}, 1e-11 * v * v * v);
  }
}

TEST(Track, AlongThePathSpeedAndItsDerivativesAreThoseOfTheCurve) {
  const auto line = solved({.keys = {0, 20}, .speed = {0, 3}, .frames = 50, .fps = {25, 1}});
  const AlongPath along = line.track().along({25, 0});
  const double rounding = 500 * std::numeric_limits<double>::epsilon();
  EXPECT_NEAR(along.point.t, 0.25, rounding);
  EXPECT_NEAR(along.speed, 10, rounding);
  EXPECT_NEAR(along.acceleration, 10, rounding);
  EXPECT_NEAR(along.jerk, 0, rounding);
  EXPECT_NEAR(line.track().distance({25, 0}).high, 5, rounding);
}

TEST(Track, AClosedPathEndsWhereItBegan) {
  const auto loop = solved({.closed = true,
                            .axis_count = 2,
                            .keys = {0.1, 0.2, 1.3, 0, 1, 1.7},
                            .speed = {3, 8, 2},
                            .frames = 31});
  for (const std::size_t axis : {0U, 1U}) {
    EXPECT_EQ(position(loop, {0, 0}, axis), position(loop, {31, 0}, axis));
    EXPECT_NE(position(loop, {0, 0}, axis), position(loop, {16, 0}, axis));
  }
}

// --- rest, dwell and the time outside

TEST(Track, TwoZerosAtBothEndsStartAndEndAtRest) {
  const auto track =
      solved({.axis_count = 2, .keys = {0, 0, 5, 9, 20, 3}, .speed = {0, 0, 10, 0, 0}, .frames = 40});
  for (const std::int32_t frame : {0, 40}) {
    for (const std::size_t axis : {0U, 1U}) {
      const AxisMotion at = motion(track, {frame, 0}, axis);
      EXPECT_EQ(at.velocity, 0);
      EXPECT_EQ(at.acceleration, 0);
      EXPECT_EQ(at.position, frame == 0 ? 0.0 : axis == 0 ? 20.0 : 3.0);
    }
  }
}

TEST(Track, OutsideTheMoveItsEndsAreHeldToTheLastBit) {
  const auto track =
      solved({.axis_count = 2, .keys = {0.1, 0.7, 5, 9, 20.3, 3.9}, .speed = {4, 10, 6}, .frames = 40});
  const FrameTime before[] = {{-1, 0.5}, {-1, 0}, {-1'000'000, 0}};
  const FrameTime after[] = {{40, 0.001}, {41, 0}, {2'000'000'000, 0.5}};
  for (const auto& time : before) {
    expect_motion(motion(track, time, 0), {0.1, 0, 0, 0}, 0);
    expect_motion(motion(track, time, 1), {0.7, 0, 0, 0}, 0);
    EXPECT_EQ(position(track, time, 1), 0.7);
    EXPECT_EQ(track.track().locate(time), (PathPoint{0, 0}));
  }
  for (const auto& time : after) {
    expect_motion(motion(track, time, 0), {20.3, 0, 0, 0}, 0);
    expect_motion(motion(track, time, 1), {3.9, 0, 0, 0}, 0);
    EXPECT_EQ(position(track, time, 1), 3.9);
    EXPECT_EQ(track.track().locate(time), (PathPoint{2, 0}));
  }
}

TEST(Track, AMoveThatEndsMovingStillMovesOnItsLastFrame) {
  const auto line = solved({.keys = {0, 24}, .speed = {6}, .frames = 24});
  EXPECT_NEAR(motion(line, {24, 0}).velocity, 24, 1e-4);
  EXPECT_EQ(motion(line, {24, 0.01}).velocity, 0);
}

TEST(Track, WhereTheCurveIsZeroTheRigStandsStill) {
  // Zero on 2 <= a <= 3, frames 20 to 30.
  const auto track = solved(
      {.axis_count = 2, .keys = {0, 0, 5, 9, 20, 3, 18, -4}, .speed = {8, 0, 0, 0, 0, 8}, .frames = 50});
  const PathPoint still = track.track().locate({20, 0});
  for (std::int32_t frame = 20; frame < 30; ++frame) {
    for (const double fraction : {0.0, 0.3, 0.9}) {
      EXPECT_EQ(track.track().locate({frame, fraction}), still);
      EXPECT_EQ(motion(track, {frame, fraction}).velocity, 0);
      EXPECT_EQ(motion(track, {frame, fraction}).acceleration, 0);
    }
  }
  EXPECT_EQ(track.track().locate({30, 0}), still);
  EXPECT_NE(track.track().locate({18, 0}), still);
  EXPECT_NE(track.track().locate({32, 0}), still);
}

TEST(Track, MoreControlValuesThanFramesArePassedWithinAFrame) {
  const auto line = solved({.keys = {0, 10}, .speed = {5, 5, 5, 5, 5, 5, 5, 5}, .frames = 2});
  for (const double fraction : {0.0, 0.1, 0.5, 0.99}) {
    EXPECT_NEAR(position(line, {0, fraction}), 5 * fraction, 1e-5);
    EXPECT_NEAR(position(line, {1, fraction}), 5 + 5 * fraction, 1e-5);
  }
  EXPECT_EQ(position(line, {2, 0}), 10);
}

TEST(Track, TheFractionKeepsItsDigitsLateInALongMove) {
  constexpr std::int32_t frames = 1'000'000;
  const auto line = solved({.keys = {0, 1}, .speed = std::vector<double>(1001, 50), .frames = frames});
  double before = -1;
  for (int i = 0; i < 1000; ++i) {  // steps of 1e-9 of the length: far below a bit of s = 0.999
    const double fraction = i / 1000.0;
    const double distance =
        line.track().distance({999'000, fraction}).minus(line.track().distance({999'000, 0}));
    EXPECT_NEAR(distance, fraction * 1e-6, 1e-19);
    EXPECT_GE(distance, before);
    before = distance;
  }
}

// --- where the path stands still

TEST(Track, WhereTheTangentVanishesPositionAndVelocityStandAndTheRestIsSaid) {
  // P = 3 t^2 - 2 t^3: the tangent vanishes at both keys, the speed does not.
  const auto line = solved({.spline = Spline::tcb,
                            .keys = {0, 24},
                            .shapes = {{.tension = 1}, {.tension = 1}},
                            .speed = {0, 4},
                            .frames = 24});
  expect_motion(motion(line, {0, 0}, 0, 1), {0, 0, 48, 0}, 1e-3);
  expect_motion(motion(line, {24, 0}, 0, 1), {24, 48, 48, 0}, 1e-3);
}

TEST(Track, WhereTheTangentVanishesToSecondOrderTheVelocityStillStands) {
  // Tension 1 leaves key 0 with P' = 0, and tension -1 with bias -1 arrives at key 1 with three times
  // the chord: P = t^3.
  const auto line = solved({.spline = Spline::tcb,
                            .keys = {0, -24},
                            .shapes = {{.tension = 1}, {.tension = -1, .continuity = 0.5, .bias = -1}},
                            .speed = {4},
                            .frames = 24});
  EXPECT_NEAR(motion(line, {0, 0}, 0, 1).velocity, -24, 1e-3);
  EXPECT_NEAR(motion(line, {24, 0}).velocity, -24, 1e-3);
}

TEST(Track, AtRestEvenAVanishingTangentLeavesNothingUnsaid) {
  const auto line = solved({.spline = Spline::tcb,
                            .keys = {0, 24},
                            .shapes = {{.tension = 1}, {.tension = 1}},
                            .speed = {0, 0, 0, 4, 0, 0, 0},
                            .frames = 24});
  expect_motion(motion(line, {0, 0}), {0, 0, 0, 0}, 0);
  expect_motion(motion(line, {24, 0}), {24, 0, 0, 0}, 0);
}

TEST(Track, OneKeyIsHeldForTheWholeMove) {
  for (const std::vector<double>& speed : {std::vector<double>{5, 9}, {0, 0}}) {
    const auto still = solved({.axis_count = 2, .keys = {3.3, -4.4}, .speed = speed, .frames = 10});
    EXPECT_EQ(still.track().constant(), 0);
    EXPECT_EQ(still.table().frames(), 10);
    for (std::int32_t frame = 0; frame <= 10; ++frame) {
      EXPECT_EQ(position(still, {frame, 0.5}, 0), 3.3);
      expect_motion(motion(still, {frame, 0}, 1), {-4.4, 0, 0, 0}, 0);
    }
  }
}

// --- what is refused

TEST(Track, ACurveOfZerosOnARealPathIsAnError) {
  EXPECT_EQ(refusal({.keys = {0, 1}, .speed = {0, 0, 0}, .frames = 10}).code, ErrorCode::no_distance);
  EXPECT_EQ(refusal({.keys = {0, 1}, .speed = {0}, .frames = 10}).code, ErrorCode::no_distance);
}

TEST(Track, FramesAreCountedFromOneToAMillion) {
  for (const std::int32_t frames : {0, -1, 1'000'001, std::numeric_limits<std::int32_t>::min()}) {
    SolvedTrack good = solved({.keys = {0, 1}, .speed = {1}, .frames = 10});
    std::vector<SpanDistance> memory(2);
    const auto refused = Track::make(good.track().path(), good.track().arc_length(), good.track().profile(),
                                     frames, {24, 1}, {memory});
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::out_of_range);
    EXPECT_THAT(refused.error().what, testing::HasSubstr("frames"));
  }
  EXPECT_DOUBLE_EQ(position(solved({.keys = {0, 1}, .speed = {1}, .frames = 1}), {0, 0.5}), 0.5);
  EXPECT_EQ(solved({.keys = {0, 1}, .speed = {1}, .frames = 1'000'000}).table().frames(), 1'000'000);
}

TEST(Track, TheFrameRateIsPositive) {
  for (const FrameRate fps : {FrameRate{0, 1}, {-24, 1}, {24, 0}, {24, -1}, {-24, -1}}) {
    const Error error = refusal({.keys = {0, 1}, .speed = {1}, .frames = 10, .fps = fps});
    EXPECT_EQ(error.code, ErrorCode::out_of_range);
    EXPECT_THAT(error.what, testing::HasSubstr("frame rate"));
  }
}

TEST(Track, FramesTimesControlValuesStayWithinThirtyOneBits) {
  // 2^31 - 1 = 2147483647.
  const auto drawing = [](std::size_t values) {
    return Drawing{.keys = {0, 1}, .speed = std::vector<double>(values, 1.0), .frames = 1'000'000};
  };
  const auto largest = solved(drawing(2148));  // f = 2147
  EXPECT_NEAR(position(largest, {999'999, 0.5}), 0.9999995, 1e-12);
  const Error error = refusal(drawing(2149));
  EXPECT_EQ(error.code, ErrorCode::out_of_range);
  EXPECT_THAT(error.what, testing::HasSubstr("31 bits"));
}

TEST(Track, StatesTheCapacityNeededWhichSuffices) {
  const auto good = solved({.keys = {0, 1}, .speed = {1, 2, 3, 4}, .frames = 10});
  const Track& track = good.track();
  const auto make = [&](std::size_t capacity) {
    std::vector<SpanDistance> memory(capacity);
    return Track::make(track.path(), track.arc_length(), track.profile(), 10, {24, 1}, {memory});
  };
  const auto refused = make(1);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::capacity);
  EXPECT_EQ(refused.error().needed, 4);
  EXPECT_TRUE(make(4));
  EXPECT_FALSE(make(3));
}

TEST(Track, AllItsMemoryMayStandInOneObject) {
  TrackStorage<4, 2, 3> storage;
  const std::vector<double> keys{0, 0, 5, 9, 20, 3, 18, -4};
  const std::vector<double> speed{1, 5, 2};
  for (const bool closed : {false, true}) {
    const auto path = Path::make({.closed = closed, .axis_count = 2, .keys = keys}, storage.path.memory());
    ASSERT_TRUE(path);
    const auto arc_length = ArcLength::make(*path, {.delta = 1e-4}, storage.arc_length.memory());
    ASSERT_TRUE(arc_length);
    const auto profile = SpeedProfile::make(speed, storage.profile.memory());
    ASSERT_TRUE(profile);
    EXPECT_TRUE(Track::make(*path, *arc_length, *profile, 24, {24, 1}, storage.memory()));
  }
}

TEST(Track, KeysInOnePlaceAtTheEndsAreLeftAndReachedAtTheDrawnSpeed) {
  TrackSpec spec;
  const std::vector<double> keys{10, 10, 10, 40, 70, 70};
  const std::vector<double> speed{5};
  spec.path = {.spline = Spline::smooth, .axis_count = 1, .keys = keys};
  spec.control_values = speed;
  spec.frames = 24;
  spec.fps = {24, 1};
  const SolvedTrack solved(spec, Solver::closed_form);
  std::vector<AxisMotion> motion(1);
  for (const std::int32_t frame : {0, 24}) {
    EXPECT_EQ(solved.track().motion({frame, 0}, motion), 3);
    EXPECT_NEAR(motion[0].velocity, 60, 1e-9) << "frame " << frame;
    EXPECT_EQ(motion[0].position, frame == 0 ? 10 : 70);
  }
}

/// Where the squares of derivatives would vanish or overflow they are taken in other units.
TEST(Track, TheMotionHasTheSameBitsInAllUnitsThatArePowersOfTwo) {
  const std::vector<double> keys{0, 0, 40, 10, 40, 60, 90, 20};
  const auto in_units = [&](double unit) {
    std::vector<double> scaled = keys;
    for (double& key : scaled) key *= unit;
    return solved({.axis_count = 2, .keys = scaled, .speed = {0, 0, 9, 4, 9, 0, 0}, .frames = 100});
  };
  const SolvedTrack plain = in_units(1);
  for (const int exponent : {-350, -200, 200, 350}) {
    const double unit = std::ldexp(1.0, exponent);
    const SolvedTrack scaled = in_units(unit);
    for (std::int32_t frame = 0; frame <= 100; ++frame) {
      for (const std::size_t axis : {std::size_t{0}, std::size_t{1}}) {
        const AxisMotion expected = motion(plain, {frame, 0.25}, axis);
        const AxisMotion got = motion(scaled, {frame, 0.25}, axis);
        EXPECT_EQ(got.position, unit * expected.position) << exponent << ", frame " << frame;
        EXPECT_EQ(got.velocity, unit * expected.velocity) << exponent << ", frame " << frame;
        EXPECT_EQ(got.acceleration, unit * expected.acceleration) << exponent << ", frame " << frame;
        EXPECT_EQ(got.jerk, unit * expected.jerk) << exponent << ", frame " << frame;
      }
    }
  }
}

}  // namespace track_test
}  // namespace inbetween
