#pragma once

#include <functional>
#include <vector>

/// The times at which a motion crosses the half steps, found the slow and sure way: by looking everywhere.
/// Shares no code and no method with the step generator.

namespace inbetween {

/// A place, its speed and acceleration, in whatever units.
struct OracleMotion {
  long double position = 0;
  long double velocity = 0;
  long double acceleration = 0;
};

struct OracleCrossing {
  long double at = 0;     ///< on the axis of the function
  long double speed = 0;  ///< steps per unit of that axis, about
  bool up = false;
};

/// Every change of floor(x(t) + 1/2) for t from `begin` to `end`, in order: x is looked at in cells + 1
/// places and at every extremum between them (golden section), and each crossing bisected.
std::vector<OracleCrossing> oracle_crossings(const std::function<long double(long double)>& x,
                                             long double begin, long double end, int cells);

/// The position at the share u of a tick, from the six basis functions of quintic Hermite interpolation.
/// Speed and acceleration per tick.
long double oracle_quintic(const OracleMotion& start, const OracleMotion& end, long double u);

}  // namespace inbetween
