// The moves that certificates and trajectories are measured with.
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include "host_tools/plan/solved_track.hpp"

namespace inbetween {

struct MoveSize {
  std::size_t keys, axes, control_values;
  std::int32_t frames;
};
inline constexpr MoveSize example{8, 3, 7, 240};
inline constexpr MoveSize large{100, 16, 64, 2400};

/// A move of that size through random keys, at random speed.
inline SolvedTrack solved_track(const MoveSize& size) {
  std::mt19937 random(1989);
  std::uniform_real_distribution<double> coordinate(0.0, 100.0);
  std::uniform_real_distribution<double> height(1.0, 20.0);
  std::vector<double> at(size.keys * size.axes);
  for (double& value : at) value = coordinate(random);
  std::vector<double> speed(size.control_values);
  for (double& value : speed) value = height(random);
  const TrackSpec spec{.path = {.axis_count = static_cast<std::int32_t>(size.axes), .keys = at},
                       .control_values = speed,
                       .frames = size.frames,
                       .fps = {24, 1},
                       .arc_length = {}};
  return {spec, Solver::closed_form};
}

}  // namespace inbetween
