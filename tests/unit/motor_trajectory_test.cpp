// What the motor behind a calibration plays.
#include "inbetween/limits/motor_trajectory.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "host_tools/plan/fitted_trajectory.hpp"
#include "host_tools/plan/solved_track.hpp"

namespace inbetween {
namespace motor_trajectory_test {

/// One axis through some keys, in two seconds.
SolvedTrack track_of(const std::vector<double>& keys, const std::vector<double>& speed) {
  TrackSpec spec;
  spec.path = {.spline = Spline::smooth, .closed = false, .axis_count = 1, .keys = keys};
  spec.control_values = speed;
  spec.frames = 48;
  spec.fps = {24, 1};
  return SolvedTrack(spec, Solver::closed_form);
}

struct Lens {
  std::array<CalibrationMark, 4> marks{{{0.5, 0}, {1, 100}, {2, 160}, {5, 210}}};
  std::array<CalibrationPiece, 5> pieces;
  Calibration curve = *Calibration::make(marks, pieces);
};

struct Pull : Lens {
  SolvedTrack track;
  FittedTrajectory axis{track.track()};
  FittedMotor motor;

  explicit Pull(const std::vector<double>& keys, const std::vector<double>& speed = {0, 0, 10, 10, 0, 0})
      : track(track_of(keys, speed)), motor(source()) {}
  [[nodiscard]] MotorSource source() const { return {&*axis, 0, &curve, axis.travel(0)}; }
};

std::vector<double> times_of_breaks(const Trajectory& trajectory) {
  std::vector<double> times;
  for (const TrajectoryBreak& one : trajectory.breaks()) times.push_back(one.time.frame + one.time.fraction);
  return times;
}

TEST(MotorTrajectory, ItsJerkStepsWhereTheAxisPassesAMark) {
  const Pull pull({0.6, 4});
  const Trajectory& motor = *pull.motor;
  const std::vector<double> breaks = times_of_breaks(motor);
  for (const double mark : {1.0, 2.0}) {
    const auto at = std::ranges::find_if(breaks, [&](double frame) {
      const auto whole = static_cast<std::int32_t>(frame);
      return std::fabs(pull.axis->motion_of(0, {whole, frame - whole}).position - mark) < 1e-12;
    });
    ASSERT_NE(at, breaks.end()) << mark;
    const TrajectoryBreak& found = motor.breaks()[static_cast<std::size_t>(at - breaks.begin())];
    const auto side = [&](std::size_t k, bool arriving) {
      return at_end_of_piece(motor, motor.pieces()[found.piece - (arriving ? 1 : 0)], 0, k, arriving);
    };
    for (const std::size_t k : {0U, 1U}) EXPECT_EQ(side(k, true), side(k, false)) << "to the last bit";
    EXPECT_NEAR(side(2, true), side(2, false), 1e-9 * std::fabs(side(2, true)));
    EXPECT_GT(std::fabs(side(3, true) - side(3, false)), 1) << mark;
  }
}

TEST(MotorTrajectory, MarksBelowZeroArePassedToo) {
  const std::array<CalibrationMark, 4> marks{{{-5, 0}, {-2, 50}, {-1, 110}, {-0.5, 210}}};
  std::array<CalibrationPiece, 5> pieces;
  const auto curve = Calibration::make(marks, pieces);
  ASSERT_TRUE(curve);
  const SolvedTrack track = track_of({-4, -0.6}, {0, 0, 10, 10, 0, 0});
  const FittedTrajectory axis(track.track());
  const FittedMotor motor(MotorSource{&*axis, 0, &*curve, axis.travel(0)});
  for (const double mark : {-2.0, -1.0}) {
    EXPECT_TRUE(std::ranges::any_of((*motor).breaks(), [&](const TrajectoryBreak& one) {
      return std::fabs(axis->motion_of(0, one.time).position - mark) < 1e-12;
    })) << mark;
  }
}

TEST(MotorTrajectory, AnAxisThatTurnsBetweenTwoMarksPassesOneTwiceAndAFallingCurveIsAsGood) {
  const Pull pull({0.6, 1.2, 0.6});
  int passed = 0;
  for (const double frame : times_of_breaks(*pull.motor)) {
    const auto whole = static_cast<std::int32_t>(frame);
    passed += std::fabs(pull.axis->motion_of(0, {whole, frame - whole}).position - 1) < 1e-12 ? 1 : 0;
  }
  EXPECT_EQ(passed, 2);
  std::array<CalibrationMark, 4> marks = pull.marks;
  for (CalibrationMark& mark : marks) mark.motor *= -1;
  std::array<CalibrationPiece, 5> pieces;
  const auto falling = Calibration::make(marks, pieces);
  ASSERT_TRUE(falling);
  const FittedMotor mirrored(MotorSource{&*pull.axis, 0, &*falling, pull.axis.travel(0)});
  ASSERT_EQ((*mirrored).pieces().size(), (*pull.motor).pieces().size());
  for (int frame = 0; frame <= 48; ++frame) {
    EXPECT_EQ((*mirrored).motion_of(0, {frame, 0}).position,
              -(*pull.motor).motion_of(0, {frame, 0}).position);
  }
}

TEST(MotorTrajectory, AtRestItIsWhereTheCalibrationSaysToTheLastBit) {
  const Pull pull({0.6, 1.7, 4}, {0, 0, 10, 0, 0, 0, 0, 10, 0, 0});
  for (const int frame : {0, 48}) {
    const double place = pull.axis->motion_of(0, {frame, 0}).position;
    EXPECT_EQ((*pull.motor).motion_of(0, {frame, 0}).position, pull.curve.motor_at(place));
  }
  const Pull still({1.5, 1.5});
  EXPECT_EQ((*still.motor).pieces().size(), 1U) << "nothing moves";
  EXPECT_EQ((*still.motor).motion_of(0, {20, 0.5}).position, still.curve.motor_at(1.5));
}

TEST(MotorTrajectory, WhereTheSpeedOfTheAxisStepsThatOfTheMotorDoes) {
  // In seconds of 2.4 and of 1.
  const std::vector<double> keys{0.6, 3, 4};
  const std::vector<std::int32_t> frames{0, 24, 48};
  TrackSpec spec;
  spec.path = {.spline = Spline::linear, .axis_count = 1, .keys = keys};
  spec.key_frames = frames;
  spec.kinetic = Kinetic::linear;
  spec.frames = 48;
  spec.fps = {24, 1};
  const SolvedTrack track(spec, Solver::closed_form);
  const FittedTrajectory axis(track.track());
  const Lens lens;
  const FittedMotor motor(MotorSource{&*axis, 0, &lens.curve, axis.travel(0)});
  const auto step = std::ranges::find((*motor).breaks(), FrameTime{24, 0}, &TrajectoryBreak::time);
  ASSERT_NE(step, (*motor).breaks().end());
  EXPECT_EQ(step->key, 1);
  const std::span<const TrajectoryPiece> pieces = (*motor).pieces();
  const double slope = lens.curve.slope_at(3).first;
  EXPECT_NEAR(at_end_of_piece(*motor, pieces[step->piece - 1], 0, 1, true), slope * 2.4, 1e-9);
  EXPECT_NEAR(at_end_of_piece(*motor, pieces[step->piece], 0, 1, false), slope, 1e-9);
}

TEST(MotorTrajectory, OnARollItJoinsTheMove) {
  const Pull pull({0.6, 4}, {10, 10, 10, 0, 0});
  const AxisMotion joint = pull.axis->motion_of(0, {0, 0});
  ASSERT_GT(joint.velocity, 0.1);
  const auto roll = RollAxis::make({RollEnd::before, 0, 12, {24, 1}}, {.position = joint.position,
                                                                       .velocity = joint.velocity,
                                                                       .acceleration = joint.acceleration,
                                                                       .jerk = 0});
  ASSERT_TRUE(roll);
  const FittedMotor rolled(*roll, pull.curve);
  const AxisMotion end = (*rolled).motion_of(0, {0, 0}), begin = (*pull.motor).motion_of(0, {0, 0});
  EXPECT_EQ(end.position, begin.position);
  EXPECT_NEAR(end.velocity, begin.velocity, 1e-12 * std::fabs(begin.velocity));
  EXPECT_NEAR(end.acceleration, begin.acceleration, 1e-12 * std::fabs(begin.acceleration));
  const AxisMotion rest = (*rolled).motion_of(0, {-12, 0});
  EXPECT_EQ(rest.position, pull.curve.motor_at(roll->rest_position()));
  EXPECT_EQ(rest.velocity, 0);
}

TEST(MotorTrajectory, TooLittleMemoryAndAnAxisThatIsNoneAreErrors) {
  const Pull pull({0.6, 4});
  const auto code = [&](MotorSource source, std::size_t joint_count, std::size_t pieces) {
    std::vector<MotorJoint> joints(joint_count);
    TrajectoryRoom room;
    room.reserve(64, 1, pieces);
    const Result<Trajectory> fitted = fit_motor(source, joints, room.memory());
    return fitted ? ErrorCode::not_converged : fitted.error().code;
  };
  EXPECT_EQ(code(pull.source(), 4096, 4096), ErrorCode::not_converged) << "none";
  EXPECT_EQ(code(pull.source(), 3, 4096), ErrorCode::capacity);
  EXPECT_EQ(code(pull.source(), 0, 4096), ErrorCode::capacity);
  EXPECT_EQ(code(pull.source(), 4096, 2), ErrorCode::capacity);
  MotorSource other = pull.source();
  other.axis = 1;
  EXPECT_EQ(code(other, 4096, 4096), ErrorCode::out_of_range);
}

}  // namespace motor_trajectory_test
}  // namespace inbetween
