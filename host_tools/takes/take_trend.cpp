#include "host_tools/takes/take_trend.hpp"

#include <cmath>
#include <cstddef>

namespace inbetween {
namespace {

double error_of(const TakeSamples& samples, std::size_t sample, std::size_t axis) {
  const double error = samples.actual(sample)[axis] - samples.commanded(sample)[axis];
  // Rounding of an axis that stands; a picture would show it as large as what wears.
  constexpr double rounding_share = 1e-6;
  return std::fabs(error) < rounding_share * samples.axes()[axis].resolution ? 0 : error;
}

double seconds_between(const TakeSamples& samples, std::size_t from, std::size_t to) {
  return static_cast<double>(samples[to].tick - samples[from].tick) / samples.rate_hz();
}

double tolerance_of(const RigAxis& axis) {
  const std::optional<FollowLimits> limits = follow_limits_of(axis.drive);
  return limits ? limits->in_position : place_tolerance(axis);
}

std::optional<double> settle_seconds(const TakeSamples& samples, std::size_t axis, double tolerance) {
  std::size_t last = samples.size();  // that changes the setpoint
  while (last > 0 && samples.direction(last - 1, axis) == 0) --last;
  if (last == 0 || last == samples.size()) return std::nullopt;
  --last;
  std::size_t settled = samples.size();
  while (settled > last && std::fabs(error_of(samples, settled - 1, axis)) <= tolerance) --settled;
  if (settled == samples.size()) return std::nullopt;
  return seconds_between(samples, last, settled);
}

/// The mean error on the samples from `from` on, `step` by `step`, that go in its direction without a break.
double mean_beside(const TakeSamples& samples, std::size_t axis, std::size_t from, int step) {
  const int direction = samples.direction(from, axis);
  double sum = 0;
  std::int64_t count = 0;
  for (std::size_t i = from; i < samples.size() && samples.direction(i, axis) == direction;
       i += static_cast<std::size_t>(step)) {
    if (std::fabs(seconds_between(samples, from, i)) > reversal_window_s) break;
    sum += error_of(samples, i, axis);
    ++count;
  }
  return sum / static_cast<double>(count);
}

void find_reversals(const TakeSamples& samples, std::size_t axis, AxisTrend& trend) {
  std::optional<std::size_t> before;  // the last sample in motion
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const int direction = samples.direction(i, axis);
    if (direction == 0) continue;
    if (before && direction != samples.direction(*before, axis)) {
      ++trend.turns;
      const double error = mean_beside(samples, axis, i, 1) - mean_beside(samples, axis, *before, -1);
      if (!trend.reversal_error || std::fabs(error) > std::fabs(*trend.reversal_error)) {
        trend.reversal_error = error;
        trend.reversal_at = samples[*before].time;
      }
    }
    before = i;
  }
}

}  // namespace

TakeTrend trend_of(const TakeSamples& samples, const RigFile& rig) {
  TakeTrend trend{.number = samples.number()};
  for (std::size_t a = 0; a < samples.axes().size(); ++a) {
    const RigAxis& axis = rig.axes[a];
    AxisTrend& of = trend.axes.emplace_back();
    of.name = axis.name;
    of.unit = to_string(axis.unit);
    of.tolerance = tolerance_of(axis);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double error = std::fabs(error_of(samples, i, a));
      if (i > 0 && error <= of.following_error_peak) continue;
      of.following_error_peak = error;
      of.peak_at = samples[i].time;
    }
    of.settle_s = settle_seconds(samples, a, of.tolerance);
    find_reversals(samples, a, of);
  }
  return trend;
}

}  // namespace inbetween
