#pragma once

#include "inbetween/base/precision.hpp"

/// The command to an axis at a tick.

namespace inbetween {

/// The commanded position of an axis with its velocity and acceleration, in axis units and seconds. Between
/// two ticks the axis moves on the polynomial of lowest degree that joins both setpoints.
struct Setpoint {
  double position = 0;
  double velocity = 0;
  double acceleration = 0;

  friend constexpr bool operator==(const Setpoint&, const Setpoint&) = default;
};

}  // namespace inbetween
