// From key positions to one cubic per segment and axis, the slow and obvious way. This is an oracle: it
// shares no line and no method with the product.
#pragma once

#include <array>
#include <vector>

namespace inbetween::oracle {

enum class Kind { smooth, catmull_rom, tcb, linear };

struct Keys {
  Kind kind = Kind::smooth;
  bool closed = false;
  std::vector<std::vector<long double>> at;                         ///< [key][axis]
  std::vector<std::array<long double, 3>> tension_continuity_bias;  ///< per key; empty: zeros; read for tcb
  std::vector<long double> weights;                                 ///< per axis, >= 0; empty: ones
};

/// c[0] + c[1] t + c[2] t^2 + c[3] t^3 on 0 <= t <= 1.
using Cubic = std::array<long double, 4>;
inline long double derivative(const Cubic& c, long double t) {
  return c[1] + t * (2 * c[2] + t * 3 * c[3]);
}
inline long double second_derivative(const Cubic& c, long double t) {
  return 2 * c[2] + 6 * t * c[3];
}

/// [segment][axis]. n keys make n - 1 segments, closed n; a sole key makes one constant segment.
///
/// - smooth: the interpolating spline with continuous second derivative over centripetal knots (the step is
/// the
///   square root of the weighted chord), second derivative zero at open ends, periodic when closed. All
///   continuity conditions are written down as one system and solved by Gaussian elimination with pivoting:
///   work about (3 n)^2, memory (3 n)^2 numbers. A segment between equal keys is constant and takes no part.
/// - tcb: Kochanek & Bartels, "Interpolating Splines with Local Tension, Continuity, and Bias Control"
/// (1984),
///   equations 8 and 9, on the uniform parameter. At an open end both chords are the only chord there is.
///   catmull_rom is the same with zeros.
/// - linear: straight lines.
///
/// Throws std::invalid_argument for no keys, lists of unequal length, negative weights, and for a segment of
/// zero weighted length in which an axis moves.
std::vector<std::vector<Cubic>> segment_cubics(const Keys& keys);

}  // namespace inbetween::oracle
