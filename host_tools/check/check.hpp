// Holds a plan against the limits of its rig: every moment of the motion, not samples of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/plan/bounded_move.hpp"
#include "host_tools/plan/plan.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "inbetween/limits/stop_bounds.hpp"

namespace inbetween {

/// A move that would take an axis beyond a limit of the rig: nothing has moved. Exit status 3.
class LimitError : public InputError {
 public:
  using InputError::InputError;
};

/// The largest magnitude of a velocity, acceleration or jerk, proven: not below the true one, at most 0.001 %
/// above it (bound_move). Infinity where there is no bound.
struct CheckedPeak {
  double value = 0;
  double frame = 0;             ///< need not be a whole one
  std::optional<double> limit;  ///< only a jerk may have none

  [[nodiscard]] bool is_exceeded() const;
  /// value / limit; 0 without a limit.
  [[nodiscard]] double share() const { return limit ? value / *limit : 0; }
};

struct CheckedRange {
  Peak lowest, highest;
};

/// An axis of the rig, in its unit and seconds.
struct CheckedAxis {
  std::string name;
  std::string unit;
  std::optional<CheckedRange> range;  ///< nothing for an axis in no track: it stays, wherever it is
  double limit_min = 0;               ///< both inclusive
  double limit_max = 0;
  CheckedPeak velocity, acceleration, jerk;
};

/// The motor of an axis with a calibration, in its unit and seconds; the limits are what the take-up of its
/// backlash leaves. Proven as that of an axis is.
struct CheckedMotor {
  std::size_t axis = 0;  ///< in CheckReport::axes
  std::string unit;
  CheckedPeak velocity, acceleration, jerk;
};

/// A jump of the velocity or the acceleration of an axis. At frames 0 and N, against the rest outside; a
/// move that is moving there meets its roll and does not step.
struct CheckedStep {
  std::optional<std::int32_t> key;  ///< nothing between keys, where the path turns on the spot
  double frame = 0;
  std::size_t axis = 0;     ///< in CheckReport::axes
  double velocity = 0;      ///< 0 where it does not step
  double acceleration = 0;  ///< 0 where it does not step
};

/// One reason why the move does not fit.
struct CheckRefusal {
  Place place;
  std::string what;
  std::string remedy;    ///< what cures such a fault as a rule: it was not tried (find_cure)
  std::size_t axis = 0;  ///< in CheckReport::axes
  double frame = 0;      ///< where it is worst
  bool slower_helps = false;
  bool at_any_rate = false;  ///< holds however slowly the path is passed, and wherever the rig rests on it

  [[nodiscard]] std::string message() const { return what + "; " + remedy; }
};

/// The demands of controlled stops on an axis of the rig, whenever they begin, against its stop limits.
struct CheckedStopAxis {
  CheckedPeak velocity, acceleration, jerk;
};

/// Controlled stops at the drawn speed, forward and backward (StopBounds).
struct CheckedStops {
  LongestStop longest;                ///< in seconds
  std::vector<CheckedStopAxis> axes;  ///< every axis of the rig
};

class PlannedStops;

struct CheckReport {
  std::vector<CheckedAxis> axes;      ///< every axis of the rig, in its order
  std::optional<CheckedStops> stops;  ///< nothing where there is a place from which no stop keeps the limits
  std::shared_ptr<const PlannedStops> planned_stops;  ///< at the drawn speed, for whoever plays the plan
  /// How many times faster than drawn every limit of the motion still holds; below 1 where it does not fit, 0
  /// where no rate does, infinity where nothing moves.
  double highest_rate = 0;
  double highest_rate_between_steps = 0;  ///< the same if the rig rests wherever the motion steps
  std::vector<CheckedStep> steps;
  std::vector<CheckedMotor> motors;
  std::vector<CheckRefusal> refusals;  ///< axis by axis, what slowing does not cure before what it does
  double speed_error = 0;  ///< the loop follows this motion within this share of its speed; 0: exactly

  [[nodiscard]] bool fits() const { return refusals.empty(); }
};

/// Whether a step of the acceleration does not fit: the axis has a max_jerk, and it is not within
/// max_acceleration_step.
bool breaks_jerk_limit(const CheckedStep& step, const RigAxis& limits);

/// The plan has a rig. Peaks are those of the move with its rolls. Where a roll is needed and none keeps the
/// limits, the move is refused. It speaks of what plays: the trajectory, whose speed is within `speed_error`
/// of what is drawn.
///
/// Controlled stops are proven along with it (PlannedStops): a move that could not be stopped everywhere
/// inside the stop limits is refused.
///
/// A step of the velocity does not fit in any case. A step of the acceleration does not fit where the axis
/// has a max_jerk, unless it is within max_acceleration_step.
///
/// Throws SolverError where a track has more axes than the core can bound.
CheckReport check(const Plan& plan);
/// The same without stops.
CheckReport check_motion(const Plan& plan);
/// The same, for who only asks whether the move fits: stops are not proven where it is refused already.
CheckReport check_until_refused(const Plan& plan);
/// Both from what has been proven already at the drawn speed, of the second for stops.
CheckReport check_motion(const Plan& plan, const BoundedMove& bounded);
CheckReport check_until_refused(const Plan& plan, const BoundedMove& bounded);

/// Throws LimitError with the first refusal, if there is one.
void refuse_beyond_limits(const CheckReport& report);

}  // namespace inbetween
