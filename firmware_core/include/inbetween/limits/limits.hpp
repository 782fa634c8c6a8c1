#pragma once

#include <algorithm>
#include <optional>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/result.hpp"

/// The limits of an axis of the machine.

namespace inbetween {

/// Stops may use this much more than motion where the rig does not say (design of the rig file).
inline constexpr double default_stop_ratio = 1.5;

/// The limits of one axis as somebody wrote them, in axis units and seconds: magnitudes, except for min and
/// max.
struct AxisLimitsSpec {
  double min = 0;                                              ///< lowest position
  double max = 0;                                              ///< highest position
  double max_velocity = 0;                                     ///< unit/s
  double max_acceleration = 0;                                 ///< unit/s^2
  std::optional<double> max_jerk = std::nullopt;               ///< unit/s^3; absent: no limit
  std::optional<double> max_acceleration_step = std::nullopt;  ///< unit/s^2; absent: none beside a max_jerk
  std::optional<double> stop_acceleration = std::nullopt;      ///< unit/s^2; absent: 1.5 max_acceleration
  std::optional<double> stop_jerk = std::nullopt;  ///< unit/s^3; absent: 1.5 max_jerk, if there is one
};

/// The limits of one axis, valid: every number finite and at most Precision::largest, min < max, all
/// others above 0, and none of the limits of a stop below that of the motion, because a stop begins in the
/// motion.
class AxisLimits {
 public:
  /// Errors, none of which names an axis (the caller knows which it was): not_finite, out_of_range.
  static Result<AxisLimits> make(const AxisLimitsSpec& spec);

  [[nodiscard]] double min() const { return limits_.min; }
  [[nodiscard]] double max() const { return limits_.max; }
  [[nodiscard]] double max_velocity() const { return limits_.max_velocity; }
  [[nodiscard]] double max_acceleration() const { return limits_.max_acceleration; }
  /// Absent: no limit.
  [[nodiscard]] std::optional<double> max_jerk() const { return limits_.max_jerk; }
  /// How far the acceleration may jump although there is a max_jerk. 0 where the rig allows no step.
  [[nodiscard]] double max_acceleration_step() const { return limits_.max_acceleration_step.value_or(0.0); }
  [[nodiscard]] double stop_acceleration() const { return *limits_.stop_acceleration; }
  /// Absent: no limit. Given without a max_jerk it holds for stops alone.
  [[nodiscard]] std::optional<double> stop_jerk() const { return limits_.stop_jerk; }

 private:
  explicit AxisLimits(const AxisLimitsSpec& limits) : limits_(limits) {}

  AxisLimitsSpec limits_;  ///< stop_acceleration is there; stop_jerk, if max_jerk is
};

/// A position that is beyond its range by no more than this is on its end: the rest is rounding.
constexpr double position_rounding(double min, double max) {
  return 1e-12 * std::max({min, -min, max, -max});
}

}  // namespace inbetween
