#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/result.hpp"

/// The path P(s) through the key positions: where the rig goes, with no notion of time.

namespace inbetween {

enum class Spline : std::uint8_t {
  smooth,       ///< interpolating cubic spline, centripetal knots, C2 in the knot parameter, natural ends
  catmull_rom,  ///< C1; the tangent at a key is half the chord between its neighbours
  tcb,          ///< Kochanek and Bartels 1984: tension, continuity and bias per key
  linear,       ///< straight segments; the direction steps at keys
};

/// Kochanek and Bartels' parameters of one key, each in [-1, 1]. All zero is Catmull-Rom.
template <Precise Real>
struct KeyShape {
  Real tension = 0;
  Real continuity = 0;
  Real bias = 0;
};

/// What a path is made from. Nothing is kept: the spans may go when `Path::make` returns.
template <Precise Real>
struct PathSpec {
  Spline spline = Spline::smooth;
  /// A closed path of n keys has n segments; the last leads back to key 0.
  bool closed = false;
  std::int32_t axis_count = 0;
  /// Key-major: keys[key * axis_count + axis], in axis units.
  std::span<const Real> keys;
  /// One per axis, >= 0: how much one unit of the axis counts as distance. Empty: 1 for every axis.
  std::span<const Real> weights = {};
  /// One per key, read for `tcb` only. Empty: all zero.
  std::span<const KeyShape<Real>> shapes = {};
};

/// c0 + c1 t + c2 t^2 + c3 t^3, in axis units.
template <Precise Real>
struct Cubic {
  Real c0 = 0, c1 = 0, c2 = 0, c3 = 0;

  [[nodiscard]] constexpr Real value(Real t) const { return c0 + t * (c1 + t * (c2 + t * c3)); }
  [[nodiscard]] constexpr Real derivative(Real t) const { return c1 + t * (2 * c2 + t * (3 * c3)); }
  [[nodiscard]] constexpr Real second(Real t) const { return 2 * c2 + t * (6 * c3); }
  [[nodiscard]] constexpr Real third() const { return 6 * c3; }
};

/// The memory of a path, owned by the caller, who keeps it alive and unmoved as long as the path.
template <Precise Real>
struct PathMemory {
  std::span<Cubic<Real>> cubics;  ///< (segments + 1) * axes
  std::span<Real> weights;        ///< axes
};

/// A path that exists is valid: finite coefficients, positive weighted length wherever an axis moves.
/// A small value that refers to the caller's memory; copying it copies no coefficients.
template <Precise Real>
class Path {
 public:
  /// Solves for the coefficients.
  ///
  /// smooth: knots u_i+1 = u_i + sqrt(weighted chord) (Lee 1989, centripetal), tridiagonal system for
  /// the second derivatives (de Boor, A Practical Guide to Splines, ch. IV; periodic by Sherman and
  /// Morrison), each segment re-parameterised to t in [0, 1]. Neighbouring equal keys share a knot:
  /// the segment between them has no length and is passed in no time.
  /// tcb, catmull_rom: Kochanek and Bartels 1984, eqs. 8 and 9; at an open end both chords are the
  /// only chord there is.
  ///
  /// Errors: not_finite, out_of_range (coordinate beyond Precision<Real>::largest, negative weight,
  /// shape outside [-1, 1], a smooth path that overshoots a thousand times as far), wrong_count, capacity,
  /// unmeasured (with key and axis). Cost: linear in keys * axes. One key is a path that stays there.
  static Result<Path> make(const PathSpec<Real>& spec, const PathMemory<Real>& memory);

  [[nodiscard]] std::int32_t axis_count() const { return axis_count_; }
  [[nodiscard]] std::int32_t key_count() const { return key_count_; }
  /// n for n + 1 open keys, n for n closed keys, 0 for one open key.
  [[nodiscard]] std::int32_t segment_count() const { return segment_count_; }
  [[nodiscard]] bool closed() const { return closed_; }
  [[nodiscard]] Spline spline() const { return spline_; }
  [[nodiscard]] std::span<const Real> weights() const { return weights_; }

  /// The cubics of all axes on a segment. Segment `segment_count()` is the continuation of the last
  /// one beyond its end, expanded there: at t = 0 it gives the last key to the last bit, and the
  /// derivatives with which the path arrives.
  [[nodiscard]] std::span<const Cubic<Real>> segment(std::int32_t index) const {
    const auto axes = static_cast<std::size_t>(axis_count_);
    return cubics_.subspan(static_cast<std::size_t>(index) * axes, axes);
  }
  /// Position of one axis, in axis units.
  [[nodiscard]] Real position(const PathPoint<Real>& point, std::int32_t axis) const {
    return segment(point.segment)[static_cast<std::size_t>(axis)].value(point.t);
  }
  /// |diag(weights) dP/dt| at a point, scaled by a power of two where a plain sum of squares would
  /// overflow or vanish.
  [[nodiscard]] Real parametric_speed(const PathPoint<Real>& point) const;

 private:
  Path() = default;

  std::span<const Cubic<Real>> cubics_;
  std::span<const Real> weights_;
  std::int32_t axis_count_ = 0;
  std::int32_t key_count_ = 0;
  std::int32_t segment_count_ = 0;
  Spline spline_ = Spline::smooth;
  bool closed_ = false;
};

/// Memory for paths of up to `Keys` keys (closed or open) and `Axes` axes.
template <Precise Real, std::size_t Keys, std::size_t Axes>
struct PathStorage {
  std::array<Cubic<Real>, (Keys + 1) * Axes> cubics;
  std::array<Real, Axes> weights;

  [[nodiscard]] PathMemory<Real> memory() { return {cubics, weights}; }
};

extern template class Path<double>;
extern template class Path<float>;

}  // namespace inbetween
