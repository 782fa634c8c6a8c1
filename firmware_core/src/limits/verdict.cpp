#include "inbetween/limits/verdict.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/cube_root.hpp"

namespace inbetween {
namespace {

std::optional<Breach> breach_of(const JudgedMove& move, std::size_t moved) {
  const AxisPeaks& peak = move.peaks[moved];
  const AxisLimits& limits = move.limits[moved];
  const auto breach = [&](BreachKind kind, double value, double limit, double frame) {
    return Breach{kind, static_cast<std::int32_t>(moved), 0, value, limit, frame};
  };
  if (moved < move.axes) {
    const RangeVerdict range = judge_range(peak.lowest.value, peak.highest.value, limits);
    if (range.below)
      return breach(BreachKind::below_range, peak.lowest.value, limits.min(), peak.lowest.frame);
    if (range.above)
      return breach(BreachKind::above_range, peak.highest.value, limits.max(), peak.highest.frame);
  }
  constexpr std::array kinds{BreachKind::velocity, BreachKind::acceleration, BreachKind::jerk};
  const std::array<const Peak*, 3> found{&peak.velocity, &peak.acceleration, &peak.jerk};
  const std::array<std::optional<double>, 3> most{limits.max_velocity(), limits.max_acceleration(),
                                                  limits.max_jerk()};
  for (std::size_t q = 0; q < found.size(); ++q) {
    if (is_exceeded(found[q]->value, most[q]))
      return breach(kinds[q], found[q]->value, *most[q], found[q]->frame);
  }
  for (const MoveStep& step : move.steps) {
    if (step.axis != moved) continue;
    if (step.velocity > 0) return breach(BreachKind::velocity_step, step.velocity, 0, step.frame);
    if (breaks_jerk_limit(step.acceleration, limits)) {
      return breach(BreachKind::acceleration_step, step.acceleration, limits.max_acceleration_step(),
                    step.frame);
    }
  }
  return std::nullopt;
}

/// How many times faster the peaks of an axis may become.
double rate_of(const AxisPeaks& peaks, const AxisLimits& limits) {
  double rate = std::numeric_limits<double>::infinity();
  if (peaks.velocity.value > 0) rate = std::min(rate, limits.max_velocity() / peaks.velocity.value);
  if (peaks.acceleration.value > 0)
    rate = std::min(rate, std::sqrt(limits.max_acceleration() / peaks.acceleration.value));
  if (limits.max_jerk() && peaks.jerk.value > 0)
    rate = std::min(rate, cube_root(*limits.max_jerk() / peaks.jerk.value));
  return rate;
}

}  // namespace

RangeVerdict judge_range(double lowest, double highest, const AxisLimits& limits) {
  const double rounding = position_rounding(limits.min(), limits.max());
  return {.below = limits.min() - lowest > rounding, .above = highest - limits.max() > rounding};
}

bool breaks_jerk_limit(double acceleration_step, const AxisLimits& limits) {
  return limits.max_jerk() && acceleration_step > limits.max_acceleration_step();
}

std::optional<Breach> first_breach(const JudgedMove& move) {
  for (std::size_t moved = 0; moved < move.peaks.size(); ++moved) {
    if (const std::optional<Breach> found = breach_of(move, moved)) return found;
  }
  return std::nullopt;
}

HighestRate highest_rate(const JudgedMove& move) {
  // Every term is rounded a few times.
  constexpr double downward = 1 - 8 * std::numeric_limits<double>::epsilon();
  double rate = std::numeric_limits<double>::infinity();
  for (std::size_t d = 0; d < move.peaks.size(); ++d)
    rate = std::min(rate, rate_of(move.peaks[d], move.limits[d]));
  HighestRate found{.between_steps = rate * downward};
  for (const MoveStep& step : move.steps) {
    const AxisLimits& limits = move.limits[step.axis];
    if (step.velocity > 0) rate = 0;
    if (limits.max_jerk() && step.acceleration > 0)
      rate = std::min(rate, std::sqrt(limits.max_acceleration_step() / step.acceleration));
  }
  found.whole = rate * downward;
  return found;
}

}  // namespace inbetween
