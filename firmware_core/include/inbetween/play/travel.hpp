#pragma once

#include "inbetween/base/precision.hpp"
#include "inbetween/limits/stop_bounds.hpp"

/// A travel along the time line from rest to rest, planned as a whole.

namespace inbetween {

/// The state of a travel. `distance_s` counts seconds of the time line from its start or, once the rate
/// falls, from its end, so that it rests there exactly.
struct TravelState {
  double distance_s = 0;
  bool to_end = false;
  double rate = 0;         ///< seconds of the time line a second
  double rate_change = 0;  ///< of the rate, per second
};

/// The rate rises from 0, is constant for a while, and falls as it rose: r'' is +J, 0, -J, 0, -J, 0, +J. J is
/// release_jerk, and the largest r' is rate_change. If the rate reaches its top before r' is that large, the
/// rise has no phase with r'' = 0. Directions are the caller's: all numbers are magnitudes.
class Travel {
 public:
  Travel() = default;
  /// The quickest travel over `distance_s` >= 0 seconds of the time line at a rate of at most `top_rate` > 0.
  static Travel shortest(double distance_s, double top_rate, const StopBound& bounds);
  /// A travel that keeps `rate` > 0 for `even_s` >= 0 seconds.
  static Travel even(double rate, double even_s, const StopBound& bounds);
  /// The seconds from rest to a rate. Meanwhile the time line advances by half of seconds times `rate`.
  static double rise_to(double rate, const StopBound& bounds);

  /// The distance of the quickest stop from `rate` >= 0, which changes by `rate_change` a second, if it is
  /// made in ticks: each of the two times at which r'' changes may come a tick late, and leave the rate J
  /// tick^2 / 2 higher than it need be.
  static double stop_distance_s(double rate, double rate_change, const StopBound& bounds, double tick_s);

  /// The seconds from rest to rest.
  [[nodiscard]] double seconds() const { return 2 * rise_s_ + even_s_; }
  /// The state at so many seconds after the start, 0..seconds(). O(1).
  [[nodiscard]] TravelState at(double seconds) const;

 private:
  [[nodiscard]] TravelState rise_at(double seconds) const;

  double jerk_ = 0;  ///< |r''| of the jerk phases
  double rate_ = 0;  ///< reached in rise_s_ seconds, held for even_s_
  double rise_s_ = 0;
  double jerk_s_ = 0;  ///< length of each jerk phase
  double even_s_ = 0;
};

}  // namespace inbetween
