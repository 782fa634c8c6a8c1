#include "inbetween/timing/speed_profile.hpp"

#include <cmath>

namespace inbetween {
namespace {

/// Finite and within 0..100, or the error that names the control value.
Status check_control_value(double value, std::int32_t index) {
  if (!std::isfinite(value)) {
    return Error{.code = ErrorCode::not_finite,
                 .what = "a control value of the speed curve is not a finite number",
                 .remedy = "use numbers from 0 to 100",
                 .control_value = index};
  }
  if (value < 0 || value > largest_control_value) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = value < 0 ? "a control value of the speed curve is negative"
                                   : "a control value of the speed curve is above 100",
                 .remedy = "use numbers from 0 to 100; the curve is drawn in proportion",
                 .control_value = index};
  }
  return Done{};
}

}  // namespace

Result<SpeedProfile> SpeedProfile::make(std::span<const double> control_values,
                                        const SpeedProfileMemory& memory, CurveEnds ends) {
  if (control_values.empty()) {
    return Error{.code = ErrorCode::wrong_count,
                 .what = "the speed curve has no control values",
                 .remedy = "give at least one, for example speed = [10]"};
  }
  for (std::size_t i = 0; i < control_values.size(); ++i) {
    const Status valid = check_control_value(control_values[i], static_cast<std::int32_t>(i));
    if (!valid) return valid.error();
  }
  if (ends == CurveEnds::periodic && control_values.back() != control_values.front()) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "the last control value of a periodic speed curve is not its first",
                 .remedy = "write the same speed at both ends",
                 .control_value = static_cast<std::int32_t>(control_values.size()) - 1};
  }
  const std::size_t f = control_values.size() > 1 ? control_values.size() - 1 : 1;
  if (memory.spans.size() < f || memory.integrals.size() < f + 1) {
    return Error{.code = ErrorCode::capacity,
                 .what = "the speed curve has more control values than its memory",
                 .remedy = "give it a larger capacity",
                 .needed = static_cast<std::int64_t>(f) + 1};
  }
  const std::array<double, 2> constant{control_values.front(), control_values.front()};
  if (control_values.size() == 1) control_values = constant;
  TwoSum integral;
  memory.integrals[0] = integral;
  for (std::size_t i = 0; i < f; ++i) {
    SpeedSpan& span = memory.spans[i];
    span = speed_span(control_values, i, ends);
    integral.add(span.integral());
    integral.renormalize();
    memory.integrals[i + 1] = integral;
  }

  SpeedProfile profile;
  profile.spans_ = memory.spans.first(f);
  profile.integrals_ = memory.integrals.first(f + 1);
  return profile;
}

}  // namespace inbetween
