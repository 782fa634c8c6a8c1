#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "host_tools/check/planned_stops.hpp"
#include "host_tools/rig_model/rig_motors.hpp"
#include "inbetween/limits/calibration.hpp"
#include "tests/support/fitting_move.hpp"
#include "tests/support/oracle_gear.hpp"
#include "tests/support/property.hpp"

/// The curve of a calibration, and what is proven of a motor behind it, against a spline of its own.

namespace inbetween {
namespace calibration_property_test {

using Marks = std::vector<CalibrationMark>;

double any_number(double low, double high) {
  constexpr int steps = 1'000'000;
  return low + (high - low) * (*rc::gen::resize(rc::kNominalSize, rc::gen::inRange(0, steps + 1))) / steps;
}

/// From `low` to `high` of the axis; the motor goes either way, by as much.
Marks any_marks(double low, double high) {
  const int count = *rc::gen::inRange(2, 12);
  const double direction = *rc::gen::arbitrary<bool>() ? 1 : -1;
  Marks marks{{0, any_number(-50, 50)}};
  for (int i = 1; i < count; ++i) {
    // Neighbouring chords up to 8 times as steep as each other: some curves turn back.
    const double step = any_number(0.5, 2);
    marks.push_back({marks.back().axis + step,
                     marks.back().motor + direction * step * std::pow(2, any_number(-1.5, 1.5))});
  }
  const double scale = (high - low) / marks.back().axis;
  for (CalibrationMark& mark : marks) {
    mark.axis = low + scale * mark.axis;
    mark.motor *= high - low;
  }
  marks.back().axis = std::max(marks.back().axis, high);
  return marks;
}

oracle::MarkCurve oracle_of(const Marks& marks) {
  std::vector<long double> x, y;
  for (const CalibrationMark& mark : marks) {
    x.push_back(mark.axis);
    y.push_back(mark.motor);
  }
  return {x, y};
}

TEST(CalibrationProperty, TheCurveIsTheNaturalSplineAndComesBackToTheAxis) {
  check_property(3000, [] {
    const double low = any_number(-100, 100);
    const double high = low + any_number(0.01, 1000);
    const Marks marks = any_marks(low, high);
    std::vector<CalibrationPiece> pieces(marks.size() + 1);
    const auto made = Calibration::make(marks, pieces);
    const oracle::MarkCurve curve = oracle_of(marks);
    const double size = std::fabs(marks.back().motor) + std::fabs(marks.front().motor);
    const double range = high - low;
    const double sign = marks.back().motor > marks.front().motor ? 1 : -1;
    if (!made) {
      RC_ASSERT(made.error().code == ErrorCode::no_solution);
      const auto from = static_cast<std::size_t>(made.error().key);
      const double chord =
          (marks[from + 1].motor - marks[from].motor) / (marks[from + 1].axis - marks[from].axis);
      long double least = chord * sign;
      for (int i = 0; i <= 2000; ++i) {
        const double share = i / 2000.0;
        least = std::min(
            least, sign * curve.at(marks[from].axis + share * (marks[from + 1].axis - marks[from].axis))[1]);
      }
      RC_ASSERT(least <= 1.01e-3L * sign * chord + 1e-3L * std::fabs(chord));
      return;
    }
    long double steepest = 0, bend = 0, third = 0;
    const double from = any_number(low - 0.1 * range, high);
    const double to = any_number(from, high + 0.1 * range);
    for (int i = 0; i <= 200; ++i) {
      const double x = from + i / 200.0 * (to - from);
      const auto [value, first, second, jump] = curve.at(x);
      RC_ASSERT(std::fabs(made->motor_at(x) - static_cast<double>(value)) <= 1e-10 * size);
      RC_ASSERT(std::fabs(made->slope_at(x).first - static_cast<double>(first)) <= 1e-9 * size / range);
      RC_ASSERT(static_cast<double>(first) * sign > 0);
      RC_ASSERT(std::fabs(made->axis_at(made->motor_at(x)) - x) <= 1e-9 * range);
      steepest = std::max(steepest, std::fabs(first));
      bend = std::max(bend, std::fabs(second));
      third = std::max(third, std::fabs(jump));
    }
    const CalibrationSlope bounds = made->bounds(from, to);
    RC_ASSERT(bounds.first >= steepest * (1 - 1e-9L));
    RC_ASSERT(bounds.second >= bend * (1 - 1e-9L) - 1e-9L * size / range / range);
    RC_ASSERT(bounds.third >= third * (1 - 1e-9L) - 1e-9L * size / range / range / range);
    RC_ASSERT(bounds.first <= steepest * 1.05L);
  });
}

/// The move of a fitting plan on the same rig, in which an axis has a calibration; nothing where its curve
/// turns back.
std::optional<Plan> calibrated(const Plan& plan, std::size_t axis, double share) {
  RigFile rig = *plan.rig();
  RigAxis& its = rig.axes[axis];
  AxisCalibration calibration{.unit = AxisUnit::deg, .marks = any_marks(its.min, its.max), .curve = {}};
  calibration.curve = std::make_shared<const CalibrationCurve>(calibration.marks);
  if (!calibration.curve->curve()) return std::nullopt;
  its.calibration = calibration;
  const CalibrationSlope slope = calibration.motor().bounds(its.min, its.max);
  const double jerk = its.max_jerk.value_or(10 * its.max_acceleration);
  const auto most = motor_motion(slope, {its.max_velocity, its.max_acceleration, jerk});
  its.motor_limits = MotorLimits{.max_velocity = share * most[0],
                                 .max_acceleration = share * most[1],
                                 .max_jerk = {},
                                 .stop_acceleration = 1.5 * share * most[1],
                                 .stop_jerk = {}};
  if (its.max_jerk) {
    its.motor_limits->max_jerk = share * most[2];
    its.motor_limits->stop_jerk = 1.5 * share * most[2];
  }
  return Plan(plan.move(), rig, {.frames = {plan.part().first, plan.part().last}});
}

/// The motor and its derivatives on the time line: as it plays, and as its calibration makes them of the axis
/// (chain rule).
using Quantities = std::array<double, 4>;

const PlayedMotor& motor_of(const Plan& plan) {
  return plan.motion().motors().front();
}
Quantities played_at(const Plan& plan, const FrameTime& time) {
  const AxisMotion motion = plan.motion().motion_of(motor_of(plan), time);
  return {motion.position, motion.velocity, motion.acceleration, motion.jerk};
}
Quantities asked_at(const Plan& plan, std::size_t d, const oracle::MarkCurve& curve, const FrameTime& time) {
  std::vector<AxisMotion> motion(plan.played().axis_count());
  plan.motion().motion(time, motion);
  const auto [p, v, a, j] = std::array<long double, 4>{motion[d].position, motion[d].velocity,
                                                       motion[d].acceleration, motion[d].jerk};
  const auto [value, t1, t2, t3] = curve.at(p);
  return {static_cast<double>(value), static_cast<double>(t1 * v), static_cast<double>(t2 * v * v + t1 * a),
          static_cast<double>(t3 * v * v * v + 3 * t2 * v * a + t1 * j)};
}

/// The trajectories of a motor, with what is played of each.
struct PlayedStretch {
  const Trajectory* trajectory;
  FrameTime from, to;
};
std::vector<PlayedStretch> stretches_of(const Plan& plan) {
  const PlayedMotor& motor = motor_of(plan);
  const WholeFrames& part = plan.part();
  std::vector<PlayedStretch> stretches{{motor.whole, {part.first, 0}, {part.last, 0}}};
  for (const Trajectory* roll : {motor.pre_roll, motor.post_roll})
    if (roll != nullptr) stretches.push_back({roll, roll->begin(), roll->end()});
  return stretches;
}

/// The largest magnitude of derivative 1 to 3 by a dense search of every piece, both ends included.
std::array<double, 3> dense_peaks(const Plan& plan) {
  constexpr int samples = 64;
  std::array<double, 3> most{};
  for (const PlayedStretch& stretch : stretches_of(plan)) {
    const Trajectory& trajectory = *stretch.trajectory;
    for (std::size_t i = 0; i < trajectory.pieces().size(); ++i) {
      const FrameTime from = std::max(trajectory.pieces()[i].begin, stretch.from);
      const FrameTime to = std::min(trajectory.end_of(i), stretch.to);
      if (!(from < to)) continue;
      const double frames = frames_between(from, to);
      for (int k = 0; k < samples; ++k) {
        const AxisMotion at = trajectory.motion_of(0, moved_by(from, frames * k / samples));
        most[0] = std::max(most[0], std::fabs(at.velocity));
        most[1] = std::max(most[1], std::fabs(at.acceleration));
        most[2] = std::max(most[2], std::fabs(at.jerk));
      }
      for (std::size_t n = 0; n < 3 && to == trajectory.end_of(i); ++n) {
        most[n] =
            std::max(most[n], std::fabs(at_end_of_piece(trajectory, trajectory.pieces()[i], 0, n + 1, true)));
      }
    }
  }
  return most;
}

double slope_of(const Marks& marks) {
  return (marks.back().motor - marks.front().motor) / (marks.back().axis - marks.front().axis);
}

/// What the motor of an axis travels in the whole move and its rolls, if its curve were straight.
double range_of(const Plan& plan, std::size_t d, const Marks& marks) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  const auto take = [&](double position) {
    low = std::min(low, position);
    high = std::max(high, position);
  };
  std::size_t axis = d, track = 0;
  const std::span<const Trajectory> trajectories = plan.motion().trajectories();
  for (; axis >= trajectories[track].axis_count(); ++track) axis -= trajectories[track].axis_count();
  for (int frame = 0; frame <= plan.played().frames(); ++frame)
    take(trajectories[track].motion_of(axis, {frame, 0}).position);
  for (const auto rolls : {plan.played().rolls().before, plan.played().rolls().after})
    if (!rolls.empty()) take(rolls[d].rest_position());
  return (high - low) *
         std::fabs((marks.back().motor - marks.front().motor) / (marks.back().axis - marks.front().axis));
}

TEST(CalibrationProperty, AMotorPlaysWhatItsCalibrationMakesOfTheAxis) {
  check_property(400, [] {
    const std::optional<FittingMove> fitting = fitting_move(200, true);
    if (!fitting) return;
    const std::size_t d = static_cast<std::size_t>(
        *rc::gen::inRange<int>(0, static_cast<int>(fitting->plan.played().axis_count())));
    const auto plan = calibrated(fitting->plan, fitting->plan.axis_of(d), 1);
    if (!plan) return;
    const oracle::MarkCurve curve = oracle_of(plan->rig()->axes[plan->axis_of(d)].calibration->marks);
    const std::array<double, 3> peaks = dense_peaks(*plan);
    const int first = plan->played().first_frame();
    const int last = plan->played().last_frame();
    std::array<double, 4> off{};
    for (int i = 0; i < 1000; ++i) {
      const double frame = first + any_number(0, 1) * (last - first);
      const auto whole = static_cast<std::int32_t>(std::floor(frame));
      const FrameTime time{whole, frame - whole};
      const Quantities played = played_at(*plan, time), asked = asked_at(*plan, d, curve, time);
      for (std::size_t n = 0; n < 4; ++n) off[n] = std::max(off[n], std::fabs(played[n] - asked[n]));
    }
    const Marks& marks = plan->rig()->axes[plan->axis_of(d)].calibration->marks;
    // The rounding of a position far from 0, of the axis or of the motor.
    double rounding = 0;
    const double slope = std::fabs(slope_of(marks));
    for (const CalibrationMark& mark : {marks.front(), marks.back()})
      rounding += 1e-12 * (std::fabs(mark.motor) + slope * std::fabs(mark.axis));
    RC_ASSERT(off[0] <= 2 * std::ldexp(range_of(*plan, d, marks), -30) + rounding);
    RC_ASSERT(off[1] <= 2e-6 * peaks[0] + 1e3 * rounding);
    RC_ASSERT(off[2] <= 1e-3 * peaks[1] + 1e6 * rounding);
    for (const int end : {first, last}) {
      RC_ASSERT(std::fabs(played_at(*plan, {end, 0})[0] - asked_at(*plan, d, curve, {end, 0})[0]) <=
                rounding);
    }
  });
}

TEST(CalibrationProperty, NoMotorIsQuickerThanProvenInACellOfTheTimeLine) {
  check_property(400, [] {
    const std::optional<FittingMove> fitting = fitting_move(200);
    if (!fitting) return;
    const std::size_t d = static_cast<std::size_t>(
        *rc::gen::inRange<int>(0, static_cast<int>(fitting->plan.played().axis_count())));
    const auto plan = calibrated(fitting->plan, fitting->plan.axis_of(d), 1);
    if (!plan) return;
    const std::size_t cells = static_cast<std::size_t>(*rc::gen::inRange(5, 50));
    const std::vector<CalibratedMotor> motors = plan->calibrated_motors();
    const BoundedMove bounded(plan->played(), plan->track_views(),
                              {.limits = {}, .motors = motors, .cells = cells, .room = {}});
    const int first = plan->played().first_frame();
    const int last = plan->played().last_frame();
    for (int i = 0; i < 2000; ++i) {
      const double at = static_cast<double>(cells) * (i + 0.5) / 2000;
      const double frame = first + (last - first) * (at / static_cast<double>(cells));
      const auto whole = static_cast<std::int32_t>(std::floor(frame));
      const Quantities q = played_at(*plan, {whole, frame - whole});
      const MotionTriple& suprema =
          bounded.cells().of_cell(static_cast<std::size_t>(at))[bounded.cells().axes];
      for (std::size_t n = 0; n < 3; ++n) RC_ASSERT(std::fabs(q[n + 1]) <= suprema[n] * (1 + 1e-12) + 1e-7);
    }
  });
}

TEST(CalibrationProperty, WhatIsProvenOfAMotorIsWhatADenseSearchFinds) {
  double loosest = 1;
  int moves = 0;
  check_property(400, [&] {
    const std::optional<FittingMove> fitting = fitting_move(200, true);
    if (!fitting) return;
    const std::size_t d = static_cast<std::size_t>(
        *rc::gen::inRange<int>(0, static_cast<int>(fitting->plan.played().axis_count())));
    const std::size_t axis = fitting->plan.axis_of(d);
    const auto plan = calibrated(fitting->plan, axis, any_number(0.1, 1.5));
    if (!plan) return;
    const CheckReport report = check(*plan);
    RC_ASSERT(report.motors.size() == 1U);
    const CheckedMotor& motor = report.motors.front();
    ++moves;
    const std::array<double, 3> found = dense_peaks(*plan);
    const std::array<const CheckedPeak*, 3> proven{&motor.velocity, &motor.acceleration, &motor.jerk};
    for (std::size_t n = 0; n < 3; ++n) {
      RC_ASSERT(proven[n]->value >= found[n] * (1 - 1e-9));
      if (!(found[n] > 0) || !std::isfinite(proven[n]->value)) continue;
      RC_ASSERT(proven[n]->value <= found[n] * 1.005);
      loosest = std::max(loosest, proven[n]->value / found[n]);
    }
    const MotorLimits& limits = *plan->rig()->axes[axis].motor_limits;
    if (report.fits()) {
      RC_ASSERT(found[0] <= limits.max_velocity);
      RC_ASSERT(found[1] <= limits.max_acceleration);
      if (limits.max_jerk) RC_ASSERT(found[2] <= *limits.max_jerk);
    }
    if (!report.stops) return;
    const int first = plan->played().first_frame();
    const int last = plan->played().last_frame();
    for (int i = 0; i < 1000; ++i) {
      const double frame = first + any_number(0, 1) * (last - first);
      const auto whole = static_cast<std::int32_t>(std::floor(frame));
      const FrameTime time{whole, frame - whole};
      const Quantities q = played_at(*plan, time);
      const StopBound bound = report.planned_stops->bounds()->at(time);
      constexpr double rounding = 1 + 1e-6;
      RC_ASSERT(std::fabs(q[2]) + std::fabs(q[1]) * bound.rate_change <= limits.stop_acceleration * rounding);
      if (!limits.stop_jerk) continue;
      RC_ASSERT(std::fabs(q[3]) + 3 * std::fabs(q[2]) * bound.rate_change +
                    std::fabs(q[1]) * bound.rate_jerk <=
                *limits.stop_jerk * rounding);
    }
  });
  std::cout << moves << " moves, the loosest bound is " << loosest << " times what was found\n";
  if (counts_mean_something()) {
    EXPECT_GT(moves, 50);
  }
}

}  // namespace calibration_property_test
}  // namespace inbetween
