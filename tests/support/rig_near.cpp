#include "tests/support/rig_near.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "host_tools/check/check.hpp"

namespace inbetween {

std::optional<MoveFile> for_a_rig(const RandomMove& random) {
  for (const std::vector<long double>& at : random.keys.at) {
    if (std::ranges::any_of(at, [](long double value) { return std::fabs(value) > 1e9L; })) {
      return std::nullopt;
    }
  }
  const bool all_zero = std::ranges::all_of(random.keys.weights, [](auto weight) { return weight == 0; });
  if (all_zero && !random.keys.weights.empty()) return std::nullopt;
  return parse_move(as_toml(random), "move.toml");
}

std::optional<RigFile> rig_near(const MoveFile& move, const RigNear& request) {
  RigFile rig{.path = "rig.toml", .name = "rig", .rate_hz = request.rate_hz, .buses = {}, .axes = {}};
  std::vector<std::string> names;
  for (const MoveTrack& track : move.tracks) names.insert(names.end(), track.axes.begin(), track.axes.end());
  for (const std::string& name : names) {
    RigAxis axis;
    axis.name = name;
    axis.min = -1e30;
    axis.max = 1e30;
    axis.max_velocity = axis.max_acceleration = 1e30;
    rig.axes.push_back(axis);
  }
  const CheckReport loose = check(Plan(move, rig, {}));
  for (std::size_t d = 0; d < names.size(); ++d) {
    const CheckedAxis& found = loose.axes[d];
    RigAxis& axis = rig.axes[d];
    const Peak& lowest = found.range->lowest;
    const Peak& highest = found.range->highest;
    const double size = highest.value - lowest.value;
    const double largest = std::max(std::fabs(highest.value), std::fabs(lowest.value));
    if (!(size > 1e-6 * largest) || !std::isfinite(found.jerk.value) || largest > 1e9 || size < 1e-9) {
      return std::nullopt;
    }
    axis.min = lowest.value - size;
    axis.max = highest.value + size;
    axis.max_velocity = request.share() * found.velocity.value;
    axis.max_acceleration = request.share() * std::max(found.acceleration.value, 1e-3 * axis.max_velocity);
    if (!request.limits_jerk) continue;
    axis.max_jerk = request.share() * std::max(found.jerk.value, 1e-3 * axis.max_acceleration);
  }
  if (!request.allows_steps) return rig;
  // What is a step and what is rounding depends on the limits.
  for (const CheckedStep& step : check(Plan(move, rig, {})).steps) {
    if (!(step.acceleration > 0 && std::isfinite(step.acceleration))) continue;
    std::optional<double>& most = rig.axes[step.axis].max_acceleration_step;
    most = std::max(most.value_or(0), 1.001 * step.acceleration);
  }
  return rig;
}

}  // namespace inbetween
