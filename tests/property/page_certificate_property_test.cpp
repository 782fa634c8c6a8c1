#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "editor/solver/certificate.hpp"
#include "host_tools/check/check.hpp"
#include "host_tools/check/planned_stops.hpp"
#include "tests/support/fitting_move.hpp"
#include "tests/support/property.hpp"

/// What the page says of a move is what `check` says, to the last bit.

namespace inbetween {
namespace page_certificate_property_test {

double any_number(double low, double high) {
  constexpr int steps = 1'000'000;
  return low + (high - low) * (*rc::gen::resize(rc::kNominalSize, rc::gen::inRange(0, steps + 1))) / steps;
}

/// A curve through four marks; it may turn back, and then there is none.
std::optional<AxisCalibration> any_calibration(const RigAxis& axis) {
  AxisCalibration calibration{.unit = AxisUnit::deg, .marks = {}, .curve = {}};
  double motor = any_number(-50, 50);
  for (const double share : {0.0, 0.3, 0.6, 1.0}) {
    calibration.marks.push_back({axis.min + share * (axis.max - axis.min), motor});
    motor += any_number(0.5, 2) * (axis.max - axis.min);
  }
  calibration.curve = std::make_shared<const CalibrationCurve>(calibration.marks);
  if (!calibration.curve->curve()) return std::nullopt;
  return calibration;
}

/// The rig of a move that fits, with limits of which some may be too low, and motors behind calibrations.
RigFile any_rig_like(RigFile rig) {
  for (RigAxis& axis : rig.axes) {
    const double share = *rc::gen::arbitrary<bool>() ? any_number(0.7, 1.3) : 1;
    axis.max_velocity *= share;
    axis.max_acceleration *= share;
    if (axis.max_jerk) *axis.max_jerk *= share;
    axis.stop_acceleration = 1.5 * axis.max_acceleration;
    if (axis.max_jerk) axis.stop_jerk = 1.5 * *axis.max_jerk;
    if (!*rc::gen::arbitrary<bool>()) continue;
    axis.calibration = any_calibration(axis);
    if (!axis.calibration) continue;
    const double steep = any_number(1, 4);
    axis.motor_limits = MotorLimits{.max_velocity = steep * axis.max_velocity,
                                    .max_acceleration = steep * axis.max_acceleration,
                                    .max_jerk = {},
                                    .stop_acceleration = 1.5 * steep * axis.max_acceleration,
                                    .stop_jerk = {}};
    if (!axis.max_jerk) continue;
    axis.motor_limits->max_jerk = steep * *axis.max_jerk;
    axis.motor_limits->stop_jerk = 1.5 * steep * *axis.max_jerk;
  }
  return rig;
}

void compare(const Peak& page, const CheckedPeak& program) {
  RC_ASSERT(page.value == program.value);
  if (program.value > 0) RC_ASSERT(page.frame == program.frame);
}

void compare(const editor::Certificate& page, const CheckReport& program, const Plan& plan) {
  const std::size_t axes = plan.played().axis_count();
  RC_ASSERT(page.peaks().size() == axes + program.motors.size());
  for (std::size_t d = 0; d < axes; ++d) {
    const CheckedAxis& axis = program.axes[plan.axis_of(d)];
    RC_ASSERT(page.peaks()[d].lowest.value == axis.range->lowest.value);
    RC_ASSERT(page.peaks()[d].highest.value == axis.range->highest.value);
    compare(page.peaks()[d].velocity, axis.velocity);
    compare(page.peaks()[d].acceleration, axis.acceleration);
    compare(page.peaks()[d].jerk, axis.jerk);
  }
  for (std::size_t m = 0; m < program.motors.size(); ++m) {
    compare(page.peaks()[axes + m].velocity, program.motors[m].velocity);
    compare(page.peaks()[axes + m].acceleration, program.motors[m].acceleration);
    compare(page.peaks()[axes + m].jerk, program.motors[m].jerk);
  }
  RC_ASSERT(page.steps().size() == program.steps.size());
  for (std::size_t i = 0; i < program.steps.size(); ++i) {
    const MoveStep& step = page.steps()[i];
    RC_ASSERT(step.frame == program.steps[i].frame && step.key == program.steps[i].key.value_or(-1));
    RC_ASSERT(plan.axis_of(step.axis) == program.steps[i].axis);
    RC_ASSERT(step.velocity == program.steps[i].velocity);
    RC_ASSERT(step.acceleration == program.steps[i].acceleration);
  }
  RC_ASSERT(page.first_breach().has_value() == !program.fits());
  RC_ASSERT(page.highest_rate() == program.highest_rate);
  RC_ASSERT(page.roll_obstacle().has_value() == !plan.roll_obstacles().empty());
  RC_ASSERT(page.stops().has_value() == program.stops.has_value());
  if (program.stops) {
    const LongestStop longest = page.stops()->longest_in_time();
    RC_ASSERT(longest.length.seconds == program.stops->longest.length.seconds);
    RC_ASSERT(longest.length.frames == program.stops->longest.length.frames);
    RC_ASSERT(longest.from_frame == program.stops->longest.from_frame);
  }
}

TEST(PageCertificateProperty, SaysOfAMoveWhatCheckSaysToTheLastBit) {
  const auto page = std::make_unique<editor::Certificate>();
  int fit = 0, refused = 0, motors = 0, stop = 0;
  check_property(1000, [&] {
    const std::optional<FittingMove> fitting = fitting_move(200);
    if (!fitting) return;
    const Plan plan(fitting->plan.move(), any_rig_like(*fitting->plan.rig()), {});
    const CheckReport report = check(plan);
    std::vector<AxisLimits> limits = plan.limits();
    for (const AxisLimits& motor : motor_limits(plan)) limits.push_back(motor);
    const std::vector<CalibratedMotor> calibrated = plan.calibrated_motors();
    const Status made = page->make(plan.track_views(), limits, calibrated, plan.rig()->rate_hz);
    RC_ASSERT(made.has_value());
    compare(*page, report, plan);
    ++(report.fits() ? fit : refused);
    motors += static_cast<int>(report.motors.size());
    stop += report.stops ? 1 : 0;
  });
  std::cout << fit << " moves that fit, " << refused << " that do not, " << motors << " motors, " << stop
            << " that can be stopped everywhere\n";
  if (counts_mean_something()) {
    EXPECT_GT(fit, 20);
    EXPECT_GT(refused, 20);
    EXPECT_GT(motors, 20);
  }
}

}  // namespace page_certificate_property_test
}  // namespace inbetween
