#pragma once

#include <algorithm>
#include <cmath>

namespace inbetween {

/// The demand of a drive that goes to a position by itself, at most as fast as it may. Seconds, and any unit.
struct SimulatedRamp {
  struct Limits {
    double velocity = 0;      ///< 0: none
    double acceleration = 0;  ///< 0: none
  };
  double position = 0;
  double velocity = 0;

  void start(double at) {
    position = at;
    velocity = 0;
  }
  void go_to(double target, const Limits& limits, double seconds) {
    const double distance = target - position;
    double wanted = distance / seconds;
    if (limits.velocity > 0) wanted = std::clamp(wanted, -limits.velocity, limits.velocity);
    if (limits.acceleration > 0) {
      const double braking = std::sqrt(2 * limits.acceleration * std::fabs(distance));
      const double change = limits.acceleration * seconds;
      wanted = std::clamp(wanted, -braking, braking);
      wanted = std::clamp(wanted, velocity - change, velocity + change);
    }
    velocity = wanted;
    position += velocity * seconds;
  }
};

}  // namespace inbetween
