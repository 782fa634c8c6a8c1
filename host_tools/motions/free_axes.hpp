// Axes of a rig that move without a drawn move: what they may do, and together what a motion loop plays.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "host_tools/rig_model/rig_file.hpp"
#include "inbetween/play/free_axis.hpp"
#include "inbetween/play/free_source.hpp"

namespace inbetween {

/// If a rig limits no jerk, a free axis takes so long to reach its acceleration: without a limit a stop would
/// be a step of the force.
inline constexpr double seconds_to_acceleration = 0.05;

/// `share` of an axis' velocity, acceleration and jerk, between its soft limits.
FreeAxisLimits free_limits_of(const RigAxis& of, double share);

/// An axis of a rig at rest at `position`. Throws InputError at the axis where it cannot be moved so.
FreeAxis free_axis_of(const RigAxis& axis, const FreeAxisLimits& limits, double position,
                      double tick_seconds);

/// A FreeSource, each axis by itself: they are on no common path. Allocates only when it is made.
class FreeAxes {
 public:
  explicit FreeAxes(std::vector<FreeAxis> axes) : axes_(std::move(axes)) {}

  void tick(std::int64_t /*now_ns*/, std::span<Setpoint> out) {
    for (std::size_t i = 0; i < axes_.size(); ++i) out[i] = axes_[i].tick();
  }
  void stop() { std::ranges::for_each(axes_, &FreeAxis::stop); }
  void halt() { std::ranges::for_each(axes_, &FreeAxis::halt); }
  [[nodiscard]] bool is_resting() const { return std::ranges::all_of(axes_, &FreeAxis::is_resting); }
  [[nodiscard]] std::span<FreeAxis> axes() { return axes_; }
  [[nodiscard]] std::span<const FreeAxis> axes() const { return axes_; }

 private:
  std::vector<FreeAxis> axes_;
};

}  // namespace inbetween
