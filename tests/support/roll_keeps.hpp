// Whether a roll of so many frames keeps every limit, by the peaks of its axes.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "inbetween/limits/roll.hpp"

namespace inbetween {

inline bool roll_keeps(const RollRequest& request, std::int32_t frames) {
  for (std::size_t i = 0; i < request.joints.size(); ++i) {
    const AxisMotion& joint = request.joints[i];
    const AxisLimits& limits = request.limits[i];
    const AxisPeaks peaks =
        RollAxis::make({request.end, request.joint_frame, frames, request.fps}, joint).value().peaks();
    const bool keeps =
        peaks.velocity.value <= limits.max_velocity() &&
        std::max(peaks.acceleration.value, std::fabs(joint.acceleration)) <= limits.max_acceleration() &&
        (!limits.max_jerk() || peaks.jerk.value <= *limits.max_jerk()) &&
        peaks.lowest.value >= limits.min() && peaks.highest.value <= limits.max();
    if (!keeps) return false;
  }
  return true;
}

}  // namespace inbetween
