#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "inbetween/limits/limits.hpp"
#include "inbetween/limits/move_bounds.hpp"

/// The verdict on a move: it names the limits that the move does not keep, and says how fast it could be
/// played. It follows from what bound_move has proven.

namespace inbetween {

/// It names what is not kept. An axis is judged in this order; then come the rolls and the stops.
enum class BreachKind : std::uint8_t {
  below_range,
  above_range,
  velocity,
  acceleration,
  jerk,
  velocity_step,
  acceleration_step,
  roll,
  stop,
};

struct Breach {
  BreachKind kind = BreachKind::below_range;
  std::int32_t axis = -1;     ///< through all tracks, and behind them the motors
  std::int32_t quantity = 0;  ///< of a roll RollQuantity, of a stop StopQuantity
  double value = 0;
  double limit = 0;
  double frame = 0;
};

/// A peak without a bound exceeds every limit; nothing exceeds one that is not there.
constexpr bool is_exceeded(double peak, const std::optional<double>& limit) {
  return limit && !(peak <= *limit);
}

/// Whether the lowest and the highest position lie outside the range, by more than rounding.
struct RangeVerdict {
  bool below = false;
  bool above = false;
};
RangeVerdict judge_range(double lowest, double highest, const AxisLimits& limits);

/// Whether a step of the acceleration is too large: an axis with a max_jerk allows none but those up to its
/// max_acceleration_step. A step of the velocity is never allowed.
bool breaks_jerk_limit(double acceleration_step, const AxisLimits& limits);

/// This holds what is proven of a move, and the limits of its axes and, behind them, of its motors.
struct JudgedMove {
  std::span<const AxisPeaks> peaks;
  std::span<const MoveStep> steps;
  std::span<const AxisLimits> limits;  ///< as many as peaks
  std::size_t axes = 0;                ///< the others are motors: their range is that of their axis
};

/// The first limit that is not kept, axis by axis; nothing where the motion fits. O(peaks * steps).
std::optional<Breach> first_breach(const JudgedMove& move);

/// How many times faster than drawn a move could be played with every limit of motion kept, rolls included.
struct HighestRate {
  /// The least of V / v, sqrt(A / a), cbrt(J / j) over axes and motors, and of sqrt(max_acceleration_step /
  /// step) where there is a max_jerk. 0 where something has no bound or a step is not allowed at any rate, as
  /// no step of the velocity is; infinity where nothing moves. Not above the exact value.
  double whole = 0;
  double between_steps = 0;  ///< the same if the rig rests wherever the motion steps
};
/// O(peaks + steps).
HighestRate highest_rate(const JudgedMove& move);

}  // namespace inbetween
