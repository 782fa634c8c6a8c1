#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "host_tools/check/planned_stops.hpp"
#include "host_tools/files/rig_motors.hpp"
#include "inbetween/limits/calibration.hpp"
#include "tests/support/bounded_cells.hpp"
#include "tests/support/fitting_move.hpp"
#include "tests/support/oracle_gear.hpp"
#include "tests/support/property.hpp"

/// The curve of a calibration, and what is proven of a motor behind it, against a spline of its own.

namespace inbetween {
namespace calibration_property_test {

using Marks = std::vector<CalibrationMark<double>>;

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
  for (CalibrationMark<double>& mark : marks) {
    mark.axis = low + scale * mark.axis;
    mark.motor *= high - low;
  }
  marks.back().axis = std::max(marks.back().axis, high);
  return marks;
}

oracle::MarkCurve oracle_of(const Marks& marks) {
  std::vector<long double> x, y;
  for (const CalibrationMark<double>& mark : marks) {
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
    std::vector<CalibrationPiece<double>> pieces(marks.size() + 1);
    const auto made = Calibration<double>::make(marks, pieces);
    const oracle::MarkCurve curve = oracle_of(marks);
    const double size = std::fabs(marks.back().motor) + std::fabs(marks.front().motor);
    const double way = high - low;
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
    const double from = any_number(low - 0.1 * way, high);
    const double to = any_number(from, high + 0.1 * way);
    for (int i = 0; i <= 200; ++i) {
      const double x = from + i / 200.0 * (to - from);
      const auto [value, first, second, jump] = curve.at(x);
      RC_ASSERT(std::fabs(made->motor_at(x) - static_cast<double>(value)) <= 1e-10 * size);
      RC_ASSERT(std::fabs(made->slope_at(x).first - static_cast<double>(first)) <= 1e-9 * size / way);
      RC_ASSERT(static_cast<double>(first) * sign > 0);
      RC_ASSERT(std::fabs(made->axis_at(made->motor_at(x)) - x) <= 1e-9 * way);
      steepest = std::max(steepest, std::fabs(first));
      bend = std::max(bend, std::fabs(second));
      third = std::max(third, std::fabs(jump));
    }
    const CalibrationSlope<double> bounds = made->bounds(from, to);
    RC_ASSERT(bounds.first >= steepest * (1 - 1e-9L));
    RC_ASSERT(bounds.second >= bend * (1 - 1e-9L) - 1e-9L * size / way / way);
    RC_ASSERT(bounds.third >= third * (1 - 1e-9L) - 1e-9L * size / way / way / way);
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
  const CalibrationSlope<double> slope = calibration.motor().bounds(its.min, its.max);
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

/// The motor and its derivatives on the time line, by the chain rule.
std::array<double, 3> motor_at(const Plan& plan, std::size_t d, const oracle::MarkCurve& curve,
                               const FrameTime<double>& time) {
  std::vector<AxisMotion<double>> motion(plan.played().axis_count());
  plan.motion().motion(time, motion);
  const auto [p, v, a, j] = std::array<long double, 4>{motion[d].position, motion[d].velocity,
                                                       motion[d].acceleration, motion[d].jerk};
  const auto [value, t1, t2, t3] = curve.at(p);
  return {static_cast<double>(t1 * v), static_cast<double>(t2 * v * v + t1 * a),
          static_cast<double>(t3 * v * v * v + 3 * t2 * v * a + t1 * j)};
}

/// Suprema of the motor, cell by cell of the time line.
std::vector<MotionTriple> cells_of_motor(const Plan& plan, std::size_t cells) {
  const PlannedMotors planned = planned_motors(plan);
  const BoundedMove bounded(plan.played(), plan.track_views(),
                            {.limits = {}, .motors = planned.motors, .cells = cells, .room = {}});
  const MotionCells& found = bounded.cells();
  std::vector<MotionTriple> of_motor;
  for (std::size_t cell = 0; cell < cells; ++cell) of_motor.push_back(found.of_cell(cell)[found.axes]);
  return of_motor;
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
    const std::vector<MotionTriple> suprema = cells_of_motor(*plan, cells);
    const oracle::MarkCurve curve = oracle_of(plan->rig()->axes[plan->axis_of(d)].calibration->marks);
    const int first = plan->played().first_frame();
    const int last = plan->played().last_frame();
    for (int i = 0; i < 2000; ++i) {
      const double at = static_cast<double>(cells) * (i + 0.5) / 2000;
      const double frame = first + (last - first) * (at / static_cast<double>(cells));
      const auto whole = static_cast<std::int32_t>(std::floor(frame));
      const std::array<double, 3> q = motor_at(*plan, d, curve, {whole, frame - whole});
      for (std::size_t n = 0; n < 3; ++n) {
        RC_ASSERT(std::fabs(q[n]) <= suprema[static_cast<std::size_t>(at)][n] * (1 + 1e-6) + 1e-9);
      }
    }
  });
}

TEST(CalibrationProperty, NoMotorIsQuickerThanProvenInAMoveAndInAStop) {
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
    const oracle::MarkCurve curve = oracle_of(plan->rig()->axes[axis].calibration->marks);
    const MotorLimits& limits = *plan->rig()->axes[axis].motor_limits;
    const int first = plan->played().first_frame();
    const int last = plan->played().last_frame();
    std::array<double, 3> found{};
    double fastest = 0;
    std::vector<AxisMotion<double>> motion(plan->played().axis_count());
    ++moves;
    for (int i = 0; i < 1000; ++i) {
      const double frame = first + any_number(0, 1) * (last - first);
      const auto whole = static_cast<std::int32_t>(std::floor(frame));
      const FrameTime<double> time{whole, frame - whole};
      const std::array<double, 3> q = motor_at(*plan, d, curve, time);
      for (std::size_t n = 0; n < 3; ++n) found[n] = std::max(found[n], std::fabs(q[n]));
      plan->motion().motion(time, motion);
      fastest = std::max(fastest, std::fabs(motion[d].velocity));
      constexpr double rounding = 1 + 1e-6;
      RC_ASSERT(std::fabs(q[0]) <= motor.velocity.value * rounding);
      RC_ASSERT(std::fabs(q[1]) <= motor.acceleration.value * rounding);
      RC_ASSERT(std::fabs(q[2]) <= motor.jerk.value * rounding);
      if (!report.stops) continue;
      const StopBound<double> bound = report.planned_stops->bounds()->at(time);
      RC_ASSERT(std::fabs(q[1]) + std::fabs(q[0]) * bound.rate_change <= limits.stop_acceleration * rounding);
      if (!limits.stop_jerk) continue;
      RC_ASSERT(std::fabs(q[2]) + 3 * std::fabs(q[1]) * bound.rate_change +
                    std::fabs(q[0]) * bound.rate_jerk <=
                *limits.stop_jerk * rounding);
    }
    // A peak that no sample hits is missing on both sides.
    if (found[0] > 0) {
      const double of_axis = report.axes[axis].velocity.value / fastest;
      loosest = std::max(loosest, motor.velocity.value / found[0] / of_axis);
    }
    if (!report.fits()) return;
    RC_ASSERT(found[0] <= limits.max_velocity);
    RC_ASSERT(found[1] <= limits.max_acceleration);
    if (limits.max_jerk) RC_ASSERT(found[2] <= *limits.max_jerk);
  });
  std::cout << moves << " moves, the loosest bound of a velocity is " << loosest << " times what was found\n";
  if (counts_mean_something()) {
    EXPECT_GT(moves, 50);
  }
}

}  // namespace calibration_property_test
}  // namespace inbetween
