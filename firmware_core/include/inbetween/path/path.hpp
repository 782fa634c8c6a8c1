#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/processor_clones.hpp"
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
struct KeyShape {
  double tension = 0;
  double continuity = 0;
  double bias = 0;
};

/// A path is made from this. Nothing is kept: the spans may go when `Path::make` returns.
struct PathSpec {
  Spline spline = Spline::smooth;
  /// A closed path of n keys has n segments; the last leads back to key 0.
  bool closed = false;
  std::int32_t axis_count = 0;
  /// Key-major: keys[key * axis_count + axis], in axis units.
  std::span<const double> keys;
  /// Of a closed path, one per axis: it returns so far beyond key 0, by whole turns of a rotary axis. Empty:
  /// to key 0 itself.
  std::span<const double> lap = {};
  /// One per axis, >= 0: how much one unit of the axis counts as distance. Empty: 1 for every axis.
  std::span<const double> weights = {};
  /// One per key, read for `tcb` only. Empty: all zero.
  std::span<const KeyShape> shapes = {};
  /// false: no axis leaves the values of its two keys between them, to the last bit, for smooth and
  /// catmull_rom. Slopes are lowered to 3 times the lesser of the two chords' and to 0 where the axis turns
  /// back or stays (Fritsch and Carlson 1980), so that the path is C1 where that happens.
  bool overshoot = true;
  /// The frame of every key, and of a closed path that of the return to key 0: the knots of the path are
  /// frames, and every axis is a curve over time. Empty: the path has no notion of time.
  std::span<const std::int32_t> key_frames = {};
  /// Only with `key_frames`: velocity and acceleration are 0 at that end.
  bool rests_at_start = true;
  bool rests_at_end = true;
  /// One per key of a linear path over frames, in frames, >= 0: the actions before and after the key overlap
  /// for so long, half of it on either side of its frame (Tuori, Tools and techniques for computer-aided
  /// animation, 1977). The position is the straight line convolved with a triangle so wide: cubics, C2. The
  /// last key is met, and key 0: an action that begins or ends at rest is shorter by half the overlap there,
  /// and at an end without a rest nothing overlaps. The seam of a periodic path overlaps as any other key.
  std::span<const std::int32_t> overlap_frames = {};
  /// One per key of a linear path with no notion of time, >= 0, in weighted distance: the path passes the
  /// key no further away than this, by a C2 blend of two cubics over at most half of either leg (the path
  /// tolerance of machine tools, G64 P). A corner that turns straight back stays. Of a closed path key 0 is
  /// the seam, and the ends of an open one are met.
  std::span<const double> path_tolerances = {};

  /// The position of a key. The number of keys is the return to key 0, and so on round a closed path.
  [[nodiscard]] double key(std::size_t index, std::size_t axis) const {
    const auto axes = static_cast<std::size_t>(axis_count);
    const std::size_t count = keys.size() / axes;
    if (index < count) return keys[index * axes + axis];
    const double first = keys[(index - count) * axes + axis];
    return lap.empty() ? first : first + lap[axis];
  }
};

/// The begin of a segment that is a part of the path between two keys: of `parts` equal parts of the path
/// from `key` to the next key, of the time on a path over frames and otherwise of s, it has `length` from
/// `part` on.
struct FrameKnot {
  std::int32_t key = 0;
  std::int32_t part = 0;
  std::int32_t parts = 1;
  std::int32_t length = 1;

  /// s at t of the segment.
  [[nodiscard]] double parameter(double t) const {
    return static_cast<double>(key) +
           (static_cast<double>(part) + t * static_cast<double>(length)) / static_cast<double>(parts);
  }
};

/// c0 + c1 t + c2 t^2 + c3 t^3, in axis units.
struct Cubic {
  double c0 = 0, c1 = 0, c2 = 0, c3 = 0;

  /// Not by Horner's rule: two halves that do not wait for each other.
  [[nodiscard]] constexpr double value(double t) const {
    const double square = t * t;
    return (c0 + square * c2) + t * (c1 + square * c3);
  }
  [[nodiscard]] constexpr double derivative(double t) const { return c1 + t * (2 * c2 + t * (3 * c3)); }
  [[nodiscard]] constexpr double second(double t) const { return 2 * c2 + t * (6 * c3); }
  [[nodiscard]] constexpr double third() const { return 6 * c3; }
};

/// A cubic in two registers: c0 and c1, c2 and c3.
struct CubicHalves {
  using Half [[gnu::vector_size(2 * sizeof(double))]] = double;
  Half low, high;

  /// Half by half: GCC 12 copies all of it through memory (tick/16 takes 1.3 times as long).
  explicit CubicHalves(const Cubic& cubic) {
    __builtin_memcpy(&low, &cubic, sizeof(low));
    __builtin_memcpy(&high, &cubic.c2, sizeof(high));
  }
};

/// The values at t of the first cubics, as many as `out` has entries, bit for bit those of Cubic::value().
/// Two at once where that is quick: c0 and c1 stand side by side and meet the same square, and only their
/// sums change places. What the compiler makes of the plain loop puts the coefficients of two cubics together
/// first (tick/3 takes 1.1 times as long, tick/16 1.2).
inline void write_values(std::span<const Cubic> cubics, double t, std::span<double> out) {
  std::size_t d = 0;
  if constexpr (lanes_are_quick) {
    using Half = typename CubicHalves::Half;
    const double square = t * t;
    for (; d + 1 < out.size(); d += 2) {
      const CubicHalves a(cubics[d]);
      const CubicHalves b(cubics[d + 1]);
      const Half a_sums = a.low + square * a.high;
      const Half b_sums = b.low + square * b.high;
      const Half values = Half{a_sums[0], b_sums[0]} + t * Half{a_sums[1], b_sums[1]};
      __builtin_memcpy(out.subspan(d).data(), &values, sizeof(values));
    }
  }
  for (; d < out.size(); ++d) out[d] = cubics[d].value(t);
}

/// A guide is a row of a path that is no axis and only measures. So many are x, y and z of a point in space.
inline constexpr std::size_t max_guides = 3;

/// A path whose coefficients are known, such as that of joints that follow a curve in space. Nothing is kept.
struct CubicPathSpec {
  Spline spline = Spline::smooth;  ///< of the keys that it was made from
  bool closed = false;
  std::int32_t axis_count = 0;
  std::int32_t key_count = 0;
  /// Segment after segment, in each the axes and then the guides.
  std::span<const Cubic> cubics;
  /// One for each axis and each guide. With weights of 0 for the axes, the guides alone are the distance.
  std::span<const double> weights;
  /// One for each segment, in the order of the path: all the parts of the path from key 0 to key 1, and so
  /// on.
  std::span<const FrameKnot> knots;
  /// Every row is a curve over time, and the knots are parts of the time from key to key.
  bool over_frames = false;
};

/// The memory of a path, owned by the caller, who keeps it alive and unmoved as long as the path.
struct PathMemory {
  std::span<Cubic> cubics;    ///< (segments + 1) * (axes + guides)
  std::span<double> weights;  ///< axes + guides
  /// Segments, of a path of cubics, over frames or with rounded corners: up to 5 between keys.
  std::span<FrameKnot> knots = {};
};

/// A path that exists is valid: finite coefficients, positive weighted length wherever an axis moves.
/// A small value that refers to the caller's memory; copying it copies no coefficients.
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
  /// With `key_frames` the knots are the frames. smooth: C2 in time; a closed path without a rest at an end
  /// is periodic, other ends without a rest have acceleration 0. tcb, catmull_rom: the tangents are adjusted
  /// to unequal numbers of frames (Kochanek and Bartels 1984), so that the velocity goes on. An axis rests,
  /// with velocity and acceleration 0, at the ends that say so and where it has one value at two neighbouring
  /// keys, by one more knot a quarter into the interval beside the rest.
  ///
  /// Errors: not_finite, out_of_range (coordinate beyond Precision::largest, negative weight,
  /// shape outside [-1, 1], a smooth path that overshoots a thousand times as far, frames that do not rise),
  /// wrong_count, capacity, unmeasured (with key and axis). Cost: linear in keys * axes. One key is a path
  /// that stays there.
  static Result<Path> make(const PathSpec& spec, const PathMemory& memory);

  /// Takes coefficients as they are. Errors: wrong_count, not_finite, out_of_range (a weight, a coefficient,
  /// a knot that is not the next one), capacity, unmeasured, as for make(), and no_solution where a segment
  /// does not begin where the one before it ends. O(segments * axes).
  static Result<Path> make_of_cubics(const CubicPathSpec& spec, const PathMemory& memory);

  [[nodiscard]] std::int32_t axis_count() const { return axis_count_; }
  [[nodiscard]] std::int32_t key_count() const { return key_count_; }
  /// n for n + 1 open keys, n for n closed keys, 0 for one open key; more where a path over frames rests, and
  /// where corners are rounded.
  [[nodiscard]] std::int32_t segment_count() const { return segment_count_; }
  [[nodiscard]] bool closed() const { return closed_; }
  [[nodiscard]] Spline spline() const { return spline_; }
  /// One for each axis and, behind them, one for each guide.
  [[nodiscard]] std::span<const double> weights() const { return weights_; }
  /// The knots are frames, and every axis is a curve over time.
  [[nodiscard]] bool over_frames() const { return over_frames_; }
  /// One for every segment of a path over frames, with rounded corners or of cubics; otherwise empty, and
  /// segment i begins at key i.
  [[nodiscard]] std::span<const FrameKnot> knots() const { return knots_; }
  /// The key at which segment `index` begins, 0..segment_count(); nothing where it begins between keys. A
  /// path with rounded corners passes the key there, and need not meet it. The end of a closed path is key 0.
  [[nodiscard]] std::optional<std::int32_t> key_at(std::int32_t index) const {
    if (index == segment_count_) return closed_ ? 0 : key_count_ - 1;
    if (knots_.empty()) return index;
    const FrameKnot& knot = knots_[static_cast<std::size_t>(index)];
    if (knot.part > 0) return std::nullopt;
    return knot.key;
  }
  /// s: i at key i, and in proportion to t, or to time where the path is over frames, between keys.
  [[nodiscard]] double parameter(const PathPoint& point) const {
    const auto index = static_cast<std::size_t>(point.segment);
    if (knots_.empty()) return static_cast<double>(point.segment) + point.t;
    if (index >= knots_.size()) return static_cast<double>(knots_.back().key + 1);
    return knots_[index].parameter(point.t);
  }

  /// The cubics of all axes on a segment, and behind them those of the guides. Segment `segment_count()` is
  /// the continuation of the last one beyond its end, expanded there: at t = 0 it gives the last key to the
  /// last bit, and the derivatives with which the path arrives.
  [[nodiscard]] std::span<const Cubic> segment(std::int32_t index) const {
    return cubics_.subspan(static_cast<std::size_t>(index) * weights_.size(), weights_.size());
  }
  /// Position of one axis, in axis units.
  [[nodiscard]] double position(const PathPoint& point, std::int32_t axis) const {
    const auto d = static_cast<std::size_t>(axis);
    return kept(segment(point.segment)[d].value(point.t), point.segment, d);
  }
  /// What has been worked out as a position of an axis on a segment, without what rounding adds beyond the
  /// ends of that segment where the path does not overshoot.
  [[nodiscard]] double kept(double position, std::int32_t segment_index, std::size_t axis) const {
    if (overshoots_ || segment_index >= segment_count_) return position;
    const double begin = segment(segment_index)[axis].c0;
    const double end = segment(segment_index + 1)[axis].c0;
    return begin < end ? std::clamp(position, begin, end) : std::clamp(position, end, begin);
  }
  /// false: a position may need kept(). What positions(), position() and a Track give is kept already.
  [[nodiscard]] bool overshoots() const { return overshoots_; }
  /// The positions of all axes at many points, axis after axis: out[axis * points.size() + i]. Quickest where
  /// many points of one segment follow each other, as in a table of frames.
  void positions(std::span<const PathPoint> points, std::span<double> out) const;
  /// |diag(weights) dP/dt| at a point, scaled by a power of two where a plain sum of squares would
  /// overflow or vanish.
  [[nodiscard]] double parametric_speed(const PathPoint& point) const;

 private:
  Path() = default;

  std::span<const Cubic> cubics_;
  std::span<const double> weights_;
  std::span<const FrameKnot> knots_;
  std::int32_t axis_count_ = 0;
  std::int32_t key_count_ = 0;
  std::int32_t segment_count_ = 0;
  Spline spline_ = Spline::smooth;
  bool closed_ = false;
  bool over_frames_ = false;
  bool overshoots_ = true;
};

/// Memory for paths of up to `Keys` keys (closed or open) and `Axes` axes.
template <std::size_t Keys, std::size_t Axes>
struct PathStorage {
  std::array<Cubic, (Keys + 1) * Axes> cubics;
  std::array<double, Axes> weights;

  [[nodiscard]] PathMemory memory() { return {cubics, weights}; }
};

}  // namespace inbetween
