#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "host_tools/rig_model/rig_motors.hpp"
#include "host_tools/rig_model/rig_readers.hpp"
#include "inbetween/limits/limits.hpp"

namespace inbetween {
namespace {

constexpr std::array<std::string_view, 7> calibration_fields = {
    "unit", "marks", "max_velocity", "max_acceleration", "max_jerk", "stop_acceleration", "stop_jerk"};
constexpr std::array<std::string_view, 3> backlash_fields = {"play", "take_up_s", "approach"};
constexpr std::array<std::string_view, 2> ganged_fields = {"drive", "offset"};
/// More motors on one axis than a machine has.
constexpr std::size_t max_ganged = 7;

std::optional<double> read_stop_limit(const TomlTable& table, std::string_view field,
                                      const std::optional<double>& motion) {
  const auto value = table.optional(field);
  if (!value) return motion ? std::optional(default_stop_ratio * *motion) : std::nullopt;
  const double limit = value->positive_number();
  if (!motion || limit < *motion) {
    value->refuse(motion
                      ? fmt::format("is {}, below that of the motion, {}; write that or more", limit, *motion)
                      : std::string("has no max_jerk beside it; give one, or leave it out"));
  }
  return limit;
}

/// Declared for the motor of a calibration.
MotorLimits read_motor_limits(const TomlTable& table) {
  MotorLimits limits;
  limits.max_velocity =
      table.required("max_velocity", "max_velocity = 300.0 (of the motor), say").positive_number();
  limits.max_acceleration =
      table.required("max_acceleration", "max_acceleration = 2000.0 (of the motor), say").positive_number();
  if (const auto jerk = table.optional("max_jerk")) limits.max_jerk = jerk->positive_number();
  limits.stop_acceleration = *read_stop_limit(table, "stop_acceleration", limits.max_acceleration);
  limits.stop_jerk = read_stop_limit(table, "stop_jerk", limits.max_jerk);
  return limits;
}

std::vector<CalibrationMark> read_marks(const TomlValue& marks) {
  std::vector<CalibrationMark> read;
  for (const TomlValue& mark : marks.list(Calibration::max_marks)) {
    const std::vector<TomlValue> pair = mark.list(2);
    if (pair.size() != 2) mark.refuse("is not a pair; write [position of the axis, position of the motor]");
    read.push_back({pair[0].number(), pair[1].number()});
  }
  return read;
}

AxisCalibration read_calibration(const TomlValue& value, const RigAxis& axis) {
  const TomlTable table(value.table(), "a calibration", calibration_fields);
  AxisCalibration calibration;
  calibration.unit = static_cast<AxisUnit>(
      table.required("unit", R"(unit = "deg", what the motor counts)").choice(axis_unit_names));
  const TomlValue marks = table.required("marks", "marks = [[0.5, 0.0], [1.0, 90.0]], say");
  calibration.marks = read_marks(marks);
  calibration.curve = std::make_shared<const CalibrationCurve>(calibration.marks);
  const Result<Calibration>& curve = calibration.curve->curve();
  if (!curve) {
    const std::int32_t mark = curve.error().key;
    (mark < 0 ? marks : marks.list(Calibration::max_marks)[static_cast<std::size_t>(mark)])
        .refuse(fmt::format("cannot be: {}; {}", curve.error().what, curve.error().remedy));
  }
  if (axis.min < calibration.marks.front().axis || axis.max > calibration.marks.back().axis) {
    marks.refuse(
        fmt::format("reach from {} to {} {}, and the axis from {} to {}; measure marks as far as the "
                    "axis goes, or lower its range",
                    calibration.marks.front().axis, calibration.marks.back().axis, to_string(axis.unit),
                    axis.min, axis.max));
  }
  return calibration;
}

/// A step of the acceleration of the axis is one of its motor.
void refuse_unbounded_steps(const TomlTable& axis_table, const TomlValue& calibration, const RigAxis& axis) {
  if (!axis.motor_limits->max_jerk) return;
  if (!axis.max_jerk) {
    calibration.refuse(
        "has a max_jerk, and the axis has none; give the axis one, so that its acceleration "
        "does not step");
  }
  axis_table.refuse_any({"max_acceleration_step"},
                        "does not go with a max_jerk of the calibration; leave one of them out");
}

AxisBacklash read_backlash(const TomlValue& value) {
  const TomlTable table(value.table(), "a backlash", backlash_fields);
  AxisBacklash backlash;
  backlash.play = table.required("play", "play = 0.05, how far the motor turns in it").positive_number();
  const TomlValue seconds = table.required("take_up_s", "take_up_s = 0.2, how long the motor takes for it");
  constexpr double longest_s = 10;
  backlash.take_up_s = seconds.number(0, longest_s);
  if (!(backlash.take_up_s > 0)) seconds.refuse("is 0; write a number above 0");
  backlash.approach_is_up =
      table
          .required("approach",
                    R"(approach = "positive" or "negative", the direction in which places are exact)")
          .choice({"positive", "negative"}) == 0;
  return backlash;
}

/// The limits as somebody wrote them.
MotorLimits written_limits(const RigAxis& axis) {
  MotorLimits limits{.max_velocity = axis.max_velocity,
                     .max_acceleration = axis.max_acceleration,
                     .max_jerk = axis.max_jerk,
                     .stop_acceleration = stop_acceleration_of(axis),
                     .stop_jerk = axis.stop_jerk};
  if (!limits.stop_jerk && axis.max_jerk) limits.stop_jerk = default_stop_ratio * *axis.max_jerk;
  return limits;
}

void refuse_hasty_take_up(const TomlValue& backlash, const RigAxis& axis) {
  const MotorLimits& limits = *axis.motor_limits;
  const auto [velocity, acceleration, jerk] = take_up_peaks(axis.backlash->play, axis.backlash->take_up_s);
  const auto refuse = [&](double peak, double limit, std::string_view name, std::string_view per) {
    if (peak < limit) return;
    const AxisUnit unit = axis.calibration ? axis.calibration->unit : axis.unit;
    backlash.refuse(
        fmt::format("would be taken up with {:.6g} {}{}, which leaves nothing of {} = {:g}; give "
                    "it a longer take_up_s",
                    peak, to_string(unit), per, name, limit));
  };
  refuse(velocity, limits.max_velocity, "max_velocity", "/s");
  refuse(acceleration, limits.max_acceleration, "max_acceleration", "/s^2");
  if (limits.max_jerk) refuse(jerk, *limits.max_jerk, "max_jerk", "/s^3");
}

}  // namespace

void read_gear(const TomlTable& table, RigAxis& axis) {
  if (const auto offset = table.optional("offset")) axis.offset = offset->number();
  if (const auto value = table.optional("calibration")) {
    axis.calibration = read_calibration(*value, axis);
    axis.motor_limits = read_motor_limits(TomlTable(value->table(), "a calibration", calibration_fields));
    refuse_unbounded_steps(table, *value, axis);
  }
  if (const auto value = table.optional("backlash")) {
    axis.backlash = read_backlash(*value);
    if (!axis.motor_limits) axis.motor_limits = written_limits(axis);
    refuse_hasty_take_up(*value, axis);
  }
}

void read_ganged(const TomlTable& table, RigAxis& axis, const RigContext& rig) {
  const auto skew = table.optional("max_skew");
  const auto list = table.optional("ganged");
  if (!list) {
    if (skew) skew->refuse("is for an axis with several motors; add ganged = [...], or leave it out");
    return;
  }
  for (const TomlValue& value : list->tables(max_ganged)) {
    const TomlTable motor(value.table(), "a ganged motor", ganged_fields);
    GangedMotor ganged;
    ganged.place = value.place();
    take(rig.taken, value, fmt::format("axis {}", in_quotes(ganged_name(axis, axis.ganged.size()))),
         "give each axis its own name");
    if (const auto offset = motor.optional("offset")) ganged.offset = offset->number();
    const TomlValue drive = motor.required("drive", R"(drive = { type = ... }, as that of the axis)");
    ganged.drive = read_drive(drive, motor_of(axis, {.axis = 0, .offset = ganged.offset}), rig);
    if (ganged.drive.index() != axis.drive.index()) {
      drive.refuse("is of another type than the drive of the axis; motors on one axis are of one type");
    }
    axis.ganged.push_back(std::move(ganged));
  }
  axis.max_skew = table
                      .required("max_skew",
                                "max_skew = 0.5, how far the motors of an axis may be apart "
                                "before the rig stops")
                      .positive_number();
}

void leave_room_for_backlash(RigAxis& axis) {
  if (!axis.backlash || axis.calibration) return;
  const AxisLimits left = limits_beside_take_up(axis);
  axis.max_velocity = left.max_velocity();
  axis.max_acceleration = left.max_acceleration();
  axis.max_jerk = left.max_jerk();
  axis.stop_acceleration = left.stop_acceleration();
  axis.stop_jerk = left.stop_jerk();
}

}  // namespace inbetween
