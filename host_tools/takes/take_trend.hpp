// What of a take shows wear and drift, when it is compared with that of other days.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/rig_model/rig_file.hpp"
#include "host_tools/takes/take_samples.hpp"

namespace inbetween {

struct AxisTrend {
  std::string name;
  std::string unit;
  /// The largest magnitude of commanded less actual, and where.
  double following_error_peak = 0;
  FrameTime peak_at = {};
  /// Within this the axis has settled, in its unit: `in_position` of its drive, or place_tolerance() where
  /// the drive has none.
  double tolerance = 0;
  /// From the last change of its setpoint until it is within the tolerance for good. Nothing where it was
  /// never moved, where the take ends in motion, or before it settled.
  std::optional<double> settle_s = {};
  /// The reversal error of its turns that is largest in magnitude, and the last moment before that turn;
  /// nothing where it does not turn.
  std::optional<double> reversal_error = {};
  FrameTime reversal_at = {};
  std::int64_t turns = 0;  ///< where it turns back, with or without a rest between
};

struct TakeTrend {
  std::int64_t number = 0;
  std::vector<AxisTrend> axes = {};  ///< of the rig, in its order
};

/// Of the ticks before and behind a turn so many seconds count, in which the axis goes that way.
inline constexpr double reversal_window_s = 0.1;

/// Reversal error: the mean of actual less commanded over the ticks behind a turn, less that over those
/// before it. It has the play and the bending of the gear, as the reversal value of ISO 230-2 has, which is
/// measured standing; this is measured moving, and has the lag of the drive too. Compare it between takes of
/// one move.
///
/// A window of 0.1 s is long enough for 25 ticks at 250 Hz, whose counts average out, and short enough that
/// lag, which grows with the speed, adds little: an axis that turns with 100 mm/s^2 is not faster than
/// 10 mm/s in it.
///
/// `rig` is that of the take.
TakeTrend trend_of(const TakeSamples& samples, const RigFile& rig);

}  // namespace inbetween
