#pragma once

#include "inbetween/base/precision.hpp"

/// What an axis is to do at a tick.

namespace inbetween {

/// Where an axis shall be, and how it moves there: in axis units, per second, per second squared. Between
/// two ticks it moves as the polynomial of lowest degree that joins both.
template <Precise Real>
struct Setpoint {
  Real position = 0;
  Real velocity = 0;
  Real acceleration = 0;
};

}  // namespace inbetween
