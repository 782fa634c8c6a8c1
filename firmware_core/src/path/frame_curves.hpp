#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "inbetween/path/path.hpp"
#include "path/tcb_tangent.hpp"

/// The cubics of a path whose knots are frames: a parameter curve over time for every axis.

namespace inbetween {

/// Segments of equal duration between two keys beside a rest: the knot that a rest adds lies a quarter in.
/// From rest to rest this is the motion of the least largest jerk, 32 chord / duration^3.
inline constexpr std::size_t rest_parts = 4;

/// Unknown are the slopes m_k of each axis at the keys, per frame. At a rest m = 0. Elsewhere a smooth path
/// has one row for each key: the acceleration with which the axis arrives is that with which it leaves.
/// Between keys h frames and D units apart these are
///   plain:            M_right = (4 m_1 + 2 m_0) / h - 6 D / h^2
///   rest at the left: M_right = (14/3 m_1) / h - 8 D / h^2   (with the knot at h / 4)
/// and M_left the same with the time reversed. Every row is dominated by its diagonal.
class FrameCurves {
 public:
  FrameCurves(const PathSpec& spec, const PathMemory& memory)
      : spec_(spec),
        memory_(memory),
        axes_(static_cast<std::size_t>(spec.axis_count)),
        intervals_(spec.key_frames.size() - 1) {}

  /// Segments of the path.
  [[nodiscard]] std::size_t segments() const {
    std::size_t count = 0;
    for (std::size_t k = 0; k < intervals_; ++k) count += parts(k);
    return count;
  }

  /// Writes all cubics, and the knot at which each segment begins.
  void write() {
    std::size_t first = 0;
    for (std::size_t k = 0; k < intervals_; first += parts(k), ++k) {
      for (std::size_t j = 0; j < parts(k); ++j) {
        memory_.knots[first + j] = {.key = static_cast<std::int32_t>(k),
                                    .part = static_cast<std::int32_t>(j),
                                    .parts = static_cast<std::int32_t>(parts(k))};
      }
    }
    const std::size_t last = segments();
    for (std::size_t d = 0; d < axes_; ++d) {
      if (spec_.spline == Spline::smooth) solve_slopes(d);
      write_axis(d, last);
    }
  }

 private:
  struct Row {
    double before = 0, here = 1, after = 0, right = 0;
  };
  /// The slopes at both ends of an interval.
  struct Slopes {
    double leaving = 0, arriving = 0;
  };

  [[nodiscard]] bool is_periodic() const {
    return spec_.closed && !spec_.rests_at_start && !spec_.rests_at_end;
  }
  [[nodiscard]] double frames(std::size_t k) const {
    return static_cast<double>(spec_.key_frames[k + 1] - spec_.key_frames[k]);
  }
  [[nodiscard]] double key(std::size_t k, std::size_t d) const { return spec_.key(k, d); }
  [[nodiscard]] double chord(std::size_t k, std::size_t d) const { return key(k + 1, d) - key(k, d); }
  /// The interval before key k; `intervals_` where there is none.
  [[nodiscard]] std::size_t before(std::size_t k) const {
    if (k > 0) return k - 1;
    return is_periodic() ? intervals_ - 1 : intervals_;
  }
  /// The interval behind key k; `intervals_` where there is none.
  [[nodiscard]] std::size_t behind(std::size_t k) const { return k == intervals_ && is_periodic() ? 0 : k; }
  [[nodiscard]] bool rests(std::size_t k, std::size_t d) const {
    if (k == 0 && spec_.rests_at_start) return true;
    if (k == intervals_ && spec_.rests_at_end) return true;
    const auto is_still = [&](std::size_t i) { return i < intervals_ && chord(i, d) == 0; };
    return spec_.spline != Spline::linear && (is_still(before(k)) || is_still(behind(k)));
  }
  [[nodiscard]] std::size_t parts(std::size_t k) const {
    if (spec_.spline == Spline::linear) return 1;
    for (std::size_t d = 0; d < axes_; ++d) {
      if (chord(k, d) != 0 && (rests(k, d) || rests(k + 1, d))) return rest_parts;
    }
    return 1;
  }

  // The slots of one axis: the cubic of key k holds m_k in c1, and while the system is solved the upper
  // diagonal in c2, and in c3 the answer of row k to the last unknown of a closed path.
  [[nodiscard]] Cubic& slot(std::size_t k, std::size_t d) { return memory_.cubics[k * axes_ + d]; }

  /// Adds the side of an interval at key k to the row of that key; `other` is the key at its other end.
  void add_side(std::size_t interval, std::size_t other, std::size_t d, double& beside, Row& row) const {
    const bool from_rest = rests(other, d);
    const double h = frames(interval);
    row.here += (from_rest ? 14.0 / 3 : 4.0) / h;
    row.right += (from_rest ? 8.0 : 6.0) * (chord(interval, d) / h) / h;
    if (!from_rest) beside += 2 / h;
  }
  [[nodiscard]] Row row(std::size_t k, std::size_t d) const {
    Row result;
    if (rests(k, d)) return result;
    result.here = 0;
    // At an open end the acceleration is 0: the row has one side.
    const std::size_t left = before(k);
    const std::size_t right = behind(k);
    if (left < intervals_) add_side(left, left, d, result.before, result);
    if (right < intervals_) add_side(right, right + 1, d, result.after, result);
    return result;
  }

  void solve_slopes(std::size_t d) {
    const std::size_t count = is_periodic() ? intervals_ : intervals_ + 1;
    const std::size_t end = is_periodic() ? count - 1 : count;  // the last unknown of a ring comes after them
    for (std::size_t k = 0; k < end; ++k) {
      const Row line = row(k, d);
      const double carried = k > 0 ? line.before : 0.0;
      const Cubic above = k > 0 ? slot(k - 1, d) : Cubic{};
      const double pivot = line.here - carried * above.c2;
      const double ring = (k == 0 ? -line.before : 0.0) - (k + 1 == end ? line.after : 0.0);
      slot(k, d) = {0, (line.right - carried * above.c1) / pivot, line.after / pivot,
                    (ring - carried * above.c3) / pivot};
    }
    for (std::size_t k = end; k-- > 1;) {
      Cubic& line = slot(k - 1, d);
      line.c1 -= line.c2 * slot(k, d).c1;
      line.c3 -= line.c2 * slot(k, d).c3;
    }
    if (!is_periodic()) return;
    const Row line = row(end, d);
    const double last = (line.right - line.before * slot(end - 1, d).c1 - line.after * slot(0, d).c1) /
                        (line.here + line.before * slot(end - 1, d).c3 + line.after * slot(0, d).c3);
    for (std::size_t k = 0; k < end; ++k) slot(k, d).c1 += slot(k, d).c3 * last;
    slot(end, d).c1 = last;
    slot(count, d).c1 = slot(0, d).c1;
  }

  /// Kochanek and Bartels 1984: tangents are adjusted to the frames on either side of the key, so that the
  /// velocity goes on where the continuity is 0.
  [[nodiscard]] double adjusted_tangent(std::size_t k, std::size_t d, KeySide side) const {
    if (rests(k, d)) return 0;
    const std::size_t left = spec_.closed && k == 0 ? intervals_ - 1 : (k > 0 ? k - 1 : 0);
    const std::size_t right = spec_.closed && k == intervals_ ? 0 : std::min(k, intervals_ - 1);
    return 2 * tcb_tangent(spec_, k, d, side) / (frames(left) + frames(right));
  }

  /// Between 0 and 3 times the lesser of the two chords' slopes: the curve from a rest is monotone then too.
  [[nodiscard]] double limited(double slope, std::size_t k, std::size_t d) const {
    const std::size_t left = k > 0 ? k - 1 : (spec_.closed ? intervals_ - 1 : 0);
    const std::size_t right = k < intervals_ ? k : (spec_.closed ? 0 : intervals_ - 1);
    const double one = chord(left, d) / frames(left);
    const double other = chord(right, d) / frames(right);
    if (!(one * other > 0) || slope * one <= 0) return 0;
    const double most = 3 * std::min(std::fabs(one), std::fabs(other));
    return std::clamp(slope, -most, most);
  }

  /// From the last interval to the first, because the slope of a key stands at or before its cubics.
  void write_axis(std::size_t d, std::size_t segments) {
    std::size_t first = segments;
    double slope_after = slot(intervals_, d).c1;
    for (std::size_t k = intervals_; k-- > 0;) {
      Slopes slopes{slot(k, d).c1, slope_after};
      slope_after = slopes.leaving;
      if (spec_.spline == Spline::tcb || spec_.spline == Spline::catmull_rom) {
        slopes = {adjusted_tangent(k, d, KeySide::leaving), adjusted_tangent(k + 1, d, KeySide::arriving)};
      }
      if (!spec_.overshoot) slopes = {limited(slopes.leaving, k, d), limited(slopes.arriving, k + 1, d)};
      const std::size_t count = parts(k);
      first -= count;
      write_interval(k, d, {slopes.leaving * frames(k), slopes.arriving * frames(k)}, first, count);
    }
  }

  void write_interval(std::size_t k, std::size_t d, const Slopes& slopes, std::size_t first,
                      std::size_t count) {
    const double begin = key(k, d);
    const double delta = chord(k, d);
    if (spec_.spline == Spline::linear) {
      slot(first, d) = {begin, delta, 0, 0};
      return;
    }
    if (count == 1) {
      slot(first, d) = hermite(delta, slopes);
      slot(first, d).c0 = begin;
      return;
    }
    const bool from_rest = rests(k, d);
    const bool to_rest = rests(k + 1, d);
    for (std::size_t j = 0; j < count; ++j) {
      Cubic part;
      if (from_rest && to_rest) {
        const bool late = j >= count / 2;
        part = rest_to_rest(delta, late ? count - 1 - j : j);
        if (late) part = reversed(part, delta);
      } else if (from_rest) {
        part = from_rest_part(delta, slopes.arriving, j);
      } else if (to_rest) {
        part = reversed(from_rest_part(delta, slopes.leaving, count - 1 - j), delta);
      } else {
        part = restarted(hermite(delta, slopes), static_cast<double>(j) / 4);
      }
      // The key itself, and not what the chord less its parts is rounded to.
      part.c0 = j == 0 ? begin : begin + part.c0;
      // Rounding of the chord may carry it beyond the next key.
      const double end = key(k + 1, d);
      if (!spec_.overshoot) part.c0 = std::clamp(part.c0, std::min(begin, end), std::max(begin, end));
      slot(first + j, d) = part;
    }
  }

  static Cubic hermite(double delta, const Slopes& slopes) {
    return {0, slopes.leaving, 3 * delta - 2 * slopes.leaving - slopes.arriving,
            slopes.leaving + slopes.arriving - 2 * delta};
  }
  /// The quarter of a cubic that begins at t.
  static Cubic restarted(const Cubic& c, double t) {
    return {c.value(t), c.derivative(t) / 4, c.second(t) / 32, c.c3 / 64};
  }
  /// The same curve in the opposite direction of time: delta - c(1 - t).
  static Cubic reversed(const Cubic& c, double delta) {
    return {delta - (c.c0 + (c.c1 + (c.c2 + c.c3))), c.c1 + (2 * c.c2 + 3 * c.c3), -(c.c2 + 3 * c.c3), c.c3};
  }
  /// Quarter j of the curve from rest to a slope. The acceleration is linear from 0 to A over the first
  /// quarter and from there to M at the end.
  static Cubic from_rest_part(double delta, double slope, std::size_t j) {
    const double peak = 6 * delta - 1.5 * slope;
    const double end = 14.0 / 3 * slope - 8 * delta;
    if (j == 0) return {0, 0, 0, peak / 96};
    return restarted({peak / 96, peak / 8, peak / 2, 2 * (end - peak) / 9}, static_cast<double>(j - 1) / 4);
  }
  /// Quarter 0 or 1 of the curve from rest to rest.
  static Cubic rest_to_rest(double delta, std::size_t j) {
    if (j == 0) return {0, 0, 0, delta / 12};
    return {delta / 12, delta / 4, delta / 4, -delta / 12};
  }

  const PathSpec& spec_;
  const PathMemory& memory_;
  std::size_t axes_;
  std::size_t intervals_;
};

}  // namespace inbetween
