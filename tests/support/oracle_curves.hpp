// Curves of one axis through keys on frames, the slow and obvious way. An oracle: it shares no line and no
// method with the product.
#pragma once

#include <array>
#include <vector>

namespace inbetween::oracle {

struct TimedKeys {
  std::vector<long double> at;
  std::vector<long double> frames;  ///< of each key, rising
  bool rests_at_start = true;
  bool rests_at_end = true;
  bool periodic = false;             ///< the last key is the first again, and the curve goes on through it
  bool rests_between_equals = true;  ///< false: only the ends that say so rest
};

/// c[0] + c[1] x + c[2] x^2 + c[3] x^3 with x in frames from `begin`.
struct TimedPiece {
  long double begin = 0, end = 0;
  std::array<long double, 4> c{};
};

/// The interpolating spline with continuous second derivative over frames, 0 there at open ends. At a rest
/// (the ends that say so, and keys beside another of the same value, unless these do not count) first and
/// second derivative are 0, and the spline has one more knot a quarter of the interval beside the rest. All
/// conditions are written down as one system and solved by elimination with pivoting.
std::vector<TimedPiece> smooth_curve(const TimedKeys& keys);

/// Derivative of order 0 to 3 at a frame; at a knot that of the piece behind it.
long double curve_at(const std::vector<TimedPiece>& curve, long double frame, int order);

}  // namespace inbetween::oracle
