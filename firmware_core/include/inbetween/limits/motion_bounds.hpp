#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "inbetween/base/result.hpp"
#include "inbetween/timing/track.hpp"
#include "inbetween/trajectory/axis_peaks.hpp"

/// How far, how fast and how hard a move goes on every axis, proven for every moment and not only for sampled
/// ones.

namespace inbetween {

inline constexpr std::size_t max_bounded_axes = 64;

/// Velocity, acceleration and jerk of one axis.
inline constexpr std::size_t motion_quantities = 3;
template <Precise Real>
using MotionTriple = std::array<Real, motion_quantities>;

/// The derivatives of one axis on one stretch of the path: polynomials in the distance tau from the stretch's
/// anchor, scaled by a power of two. Where the path stands still at the anchor, `second` and `third` are
/// those of d2P / dL2 tau and d3P / dL3 tau^3, and q is divided by tau^2.
template <Precise Real>
struct AxisTurn {
  std::array<Real, 3> first{};   ///< dP / dt
  std::array<Real, 5> second{};  ///< the numerator of d2P / dL2 (denominator q^2), or d2P / dt2
  std::array<Real, 8> third{};   ///< the numerator of d3P / dL3 (denominator q^(7/2)), or d3P / dt3
  Real size = 0;                 ///< the size of the numbers that `first` was computed from
  bool straight = false;         ///< dP / dL is constant
  Real direction = 0;            ///< ... and this
};

/// The memory of bound_motion, owned by the caller.
template <Precise Real>
struct MotionBoundsMemory {
  std::span<AxisTurn<Real>> turns;  ///< axes
};

/// Bounds of every axis of one track on the frames `part`, of the whole move where none are given: true <=
/// peak <= 1.01 true + slack (lowest and highest: within 1e-6 of the range). The slack of each axis, in axis
/// units and seconds, is a small share of its limits, so that nothing is refined that is far from them; 0 is
/// allowed.
///
/// Method: velocity, acceleration and jerk are T w, T' w^2 + T w', T'' w^3 + 3 T' w w' + T w'' with T = dP/dL
/// and its derivatives by distance as rational functions on one segment, w the speed along the path as a
/// polynomial in time on one span of the speed curve. Over a short stretch of time each factor is enclosed by
/// its Taylor polynomial about the middle (centred form), the products by interval arithmetic and by the mean
/// value theorem; stretches are halved until what is proven is within 0.5 % of the largest value found
/// (branch and bound; Moore, Kearfott and Cloud 2009, ch. 6). It is the motion as asked, not the fitted
/// inverse of arc length, which is within delta of it.
///
/// T' and T'' have no bound where the path stands still: at a tension of 1, at keys that go back the same
/// way, at a cusp. If the move rests there, what counts are their products with powers of w, which vanishes
/// too: they are bounded by enclosing w / tau, tau the distance in the path's parameter. If it is passed at a
/// speed, acceleration and jerk are infinite on every axis that turns there. A key that the speed curve comes
/// to rest at, within what a lock promises (1e-12 of the length in double, 1e-5 in single precision), is met
/// at rest, and so is a place beside it, no further away, where the path turns on the spot.
///
/// A bound that cannot be closed to 1 % because rounding hides the truth (a peak that lasts less than 1e-10
/// of the move in double, beside a near-cusp) is given as it is: too high, never too low.
///
/// Domain: 0 <= part.first < part.last <= N. Errors: capacity (axes). No allocation. Cost: about 0.2 ms for
/// three axes on a desktop machine, growing with the number of peaks, not with the number of frames.
template <Precise Real>
Status bound_motion(const Track<Real>& track, std::span<const MotionTriple<Real>> slack,
                    const MotionBoundsMemory<Real>& memory, std::span<AxisPeaks<Real>> out,
                    const std::optional<WholeFrames>& part = std::nullopt);

}  // namespace inbetween
