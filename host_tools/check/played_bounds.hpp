#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "host_tools/plan/plan.hpp"
#include "inbetween/trajectory/axis_peaks.hpp"

/// What the trajectories of a plan reach and where they step: the certificate that is to take the place of
/// the one of its tracks.

namespace inbetween {

/// How much an axis steps, with its sign; at the ends of what is played, against the rest outside.
struct PlayedStep {
  std::optional<std::int32_t> key;  ///< nothing between keys
  double frame = 0;
  std::size_t axis = 0;  ///< of Plan::played()
  double velocity = 0;
  double acceleration = 0;
};

struct PlayedBounds {
  std::vector<AxisPeaks<double>> axes;  ///< of Plan::played(), with the rolls
  std::vector<PlayedStep> steps;        ///< that are not 0
  double loosened = 1;                  ///< Trajectory::loosened
};

/// Of the frames that are played, and of its rolls. Memory: some hundred joints at a time, whatever the
/// length.
PlayedBounds bound_played(const Plan& plan);

}  // namespace inbetween
