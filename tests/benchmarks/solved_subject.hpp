// The moves that certificates and trajectories are measured with.
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include "host_tools/plan/solved_track.hpp"
#include "inbetween/limits/limits.hpp"
#include "inbetween/trajectory/axis_peaks.hpp"

namespace inbetween {

struct MoveSize {
  std::size_t keys, axes, control_values;
  std::int32_t frames;
};
inline constexpr MoveSize example{8, 3, 7, 240};
inline constexpr MoveSize large{100, 16, 64, 2400};

/// A move of that size through random keys, at random speed; from rest to rest, if so said.
inline SolvedTrack solved_track(const MoveSize& size, bool rests = false) {
  std::mt19937 random(1989);
  std::uniform_real_distribution<double> coordinate(0.0, 100.0);
  std::uniform_real_distribution<double> height(1.0, 20.0);
  std::vector<double> at(size.keys * size.axes);
  for (double& value : at) value = coordinate(random);
  std::vector<double> speed(size.control_values);
  for (double& value : speed) value = height(random);
  if (rests) speed[0] = speed[1] = speed[speed.size() - 2] = speed.back() = 0;
  const TrackSpec spec{.path = {.axis_count = static_cast<std::int32_t>(size.axes), .keys = at},
                       .control_values = speed,
                       .frames = size.frames,
                       .fps = {24, 1},
                       .arc_length = {}};
  return {spec, Solver::closed_form};
}

/// Of a rig whose limits are a quarter above the peaks of a move.
inline std::vector<AxisLimits> limits_above(const std::vector<AxisPeaks>& peaks) {
  std::vector<AxisLimits> limits;
  for (const AxisPeaks& axis : peaks) {
    limits.push_back(AxisLimits::make({.min = -1e4,
                                       .max = 1e4,
                                       .max_velocity = 1.25 * axis.velocity.value,
                                       .max_acceleration = 1.25 * axis.acceleration.value,
                                       .max_jerk = 1.25 * axis.jerk.value})
                         .value());
  }
  return limits;
}

}  // namespace inbetween
