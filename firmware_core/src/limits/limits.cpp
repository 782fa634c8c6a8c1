#include "inbetween/limits/limits.hpp"

#include <cmath>

namespace inbetween {
namespace {

Error refused(double value, const char* not_finite, const char* out_of_range) {
  if (!std::isfinite(value)) {
    return Error{.code = ErrorCode::not_finite, .what = not_finite, .remedy = "use a number"};
  }
  return Error{
      .code = ErrorCode::out_of_range, .what = out_of_range, .remedy = "use a number above 0, within 1e15"};
}

bool is_magnitude(double value) {
  return value > 0 && value <= Precision::largest;
}

bool is_absent_or_magnitude(const std::optional<double>& value) {
  return !value || is_magnitude(*value);
}

Status check_range(double min, double max) {
  if (!std::isfinite(min) || !std::isfinite(max)) {
    return Error{.code = ErrorCode::not_finite,
                 .what = "an end of the range of an axis is not a finite number",
                 .remedy = "give min and max, the positions that the axis can reach"};
  }
  if (std::fabs(min) > Precision::largest || std::fabs(max) > Precision::largest) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "an end of the range of an axis is too far away",
                 .remedy = "use positions within 1e15"};
  }
  if (!(min < max)) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "the range of an axis is empty",
                 .remedy = "write min < max"};
  }
  return Done{};
}

Status check_magnitudes(const AxisLimitsSpec& spec) {
  if (!is_magnitude(spec.max_velocity)) {
    return refused(spec.max_velocity, "max_velocity is not a finite number", "max_velocity is not a limit");
  }
  if (!is_magnitude(spec.max_acceleration)) {
    return refused(spec.max_acceleration, "max_acceleration is not a finite number",
                   "max_acceleration is not a limit");
  }
  if (!is_absent_or_magnitude(spec.max_jerk)) {
    return refused(*spec.max_jerk, "max_jerk is not a finite number", "max_jerk is not a limit");
  }
  if (!is_absent_or_magnitude(spec.max_acceleration_step)) {
    return refused(*spec.max_acceleration_step, "max_acceleration_step is not a finite number",
                   "max_acceleration_step is not a limit");
  }
  return Done{};
}

/// Both were completed, where the spec left them to the default.
Status check_stop(const AxisLimitsSpec& limits) {
  if (!is_magnitude(*limits.stop_acceleration)) {
    return refused(*limits.stop_acceleration, "stop_acceleration is not a finite number",
                   "stop_acceleration is not a limit");
  }
  if (!is_absent_or_magnitude(limits.stop_jerk)) {
    return refused(*limits.stop_jerk, "stop_jerk is not a finite number", "stop_jerk is not a limit");
  }
  if (*limits.stop_acceleration < limits.max_acceleration) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "stop_acceleration is below max_acceleration, but a stop begins in the motion",
                 .remedy = "raise stop_acceleration or lower max_acceleration"};
  }
  if (limits.max_jerk && *limits.stop_jerk < *limits.max_jerk) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "stop_jerk is below max_jerk, but a stop begins in the motion",
                 .remedy = "raise stop_jerk or lower max_jerk"};
  }
  return Done{};
}

}  // namespace

Result<AxisLimits> AxisLimits::make(const AxisLimitsSpec& spec) {
  const Status range = check_range(spec.min, spec.max);
  if (!range) return range.error();
  const Status magnitudes = check_magnitudes(spec);
  if (!magnitudes) return magnitudes.error();
  constexpr double ratio = static_cast<double>(default_stop_ratio);
  AxisLimitsSpec limits = spec;
  if (!limits.stop_acceleration) limits.stop_acceleration = ratio * spec.max_acceleration;
  if (!limits.stop_jerk && spec.max_jerk) limits.stop_jerk = ratio * *spec.max_jerk;
  const Status stop = check_stop(limits);
  if (!stop) return stop.error();
  return AxisLimits(limits);
}

}  // namespace inbetween
