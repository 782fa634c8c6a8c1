#include "inbetween/path/path.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/scaled_norm.hpp"
#include "inbetween/base/processor_clones.hpp"
#include "path/frame_curves.hpp"
#include "path/path_checks.hpp"
#include "path/rounded_corners.hpp"
#include "path/tcb_tangent.hpp"

namespace inbetween {
namespace {

/// So many places of a path stand on the stack at a time: 2 KB in double precision, and less on a
/// microcontroller.
constexpr std::size_t places_at_once = lanes_are_quick ? 256 : 16;

/// The places of the first points on one segment, no more than `t` has room for. Returns how many they are.
INBETWEEN_PROCESSOR_CLONES std::size_t take_places(std::span<const PathPoint> points, std::span<double> t) {
  const std::int32_t segment = points.front().segment;
  std::size_t count = std::min(points.size(), t.size());
  // Without a branch for each point: nearly always all of them are on the segment.
  std::int32_t differ = 0;
  for (std::size_t i = 0; i < count; ++i) {
    t[i] = points[i].t;
    differ |= points[i].segment ^ segment;
  }
  if (differ == 0) return count;
  count = 1;
  while (points[count].segment == segment) ++count;
  return count;
}

INBETWEEN_PROCESSOR_CLONES void evaluate(const Cubic& cubic, std::span<const double> t,
                                         std::span<double> out) {
  const Cubic own = cubic;
  for (std::size_t i = 0; i < t.size(); ++i) out[i] = own.value(t[i]);
}

/// The keys of a spec and where the coefficients go, while the path is being made.
class Construction {
 public:
  Construction(const PathSpec& spec, const PathMemory& memory)
      : spec_(spec),
        memory_(memory),
        cubics_(memory.cubics),
        axes_(static_cast<std::size_t>(spec.axis_count)),
        keys_(spec.keys.size() / axes_),
        segments_(spec.closed && keys_ > 1 ? keys_ : keys_ - 1) {
    std::ranges::copy(spec.weights, memory.weights.begin());
    if (spec.weights.empty()) std::ranges::fill(memory.weights.first(axes_), 1.0);
    weights_ = memory.weights.first(axes_);
  }

  void build() {
    if (RoundedCorners::are_asked(spec_)) {
      RoundedCorners corners(spec_, memory_);
      segments_ = corners.segments();
      corners.write();
      return append_continuation();
    }
    if (!spec_.key_frames.empty()) {
      FrameCurves curves(spec_, memory_);
      segments_ = curves.segments();
      curves.write();
      return append_continuation();
    }
    switch (spec_.spline) {
      case Spline::linear:
        for (std::size_t i = 0; i < segments_; ++i) straight(i);
        break;
      case Spline::smooth:
        build_smooth();
        break;
      case Spline::catmull_rom:
      case Spline::tcb:
        build_tcb();
        break;
    }
    if (!spec_.overshoot && segments_ > 0) limit_slopes();
    append_continuation();
  }

  /// The first segment on which the path swings beyond the numbers: a smooth path does where an axis of
  /// little weight goes far between keys that are near to each other as weighted.
  [[nodiscard]] Status check_range() const {
    // An ordinary path overshoots a few times; the square of this is still finite for every axis.
    const double max_magnitude = 1000 * Precision::largest;
    for (std::size_t i = 0; i < segments_ * axes_; ++i) {
      const Cubic& c = cubics_[i];
      const auto inside = [&](double x) { return std::fabs(x) <= max_magnitude; };  // false for a NaN
      if (inside(c.c1) && inside(c.c2) && inside(c.c3)) continue;
      return Error{.code = ErrorCode::out_of_range,
                   .what = "the path swings beyond the range of numbers after this key",
                   .remedy = "make the weights less unequal, or use a spline that is not smooth",
                   .key = key_of(i / axes_),
                   .axis = static_cast<std::int32_t>(i % axes_)};
    }
    return Done{};
  }

  /// The first segment in which an axis moves although the weighted length does not grow.
  [[nodiscard]] Status check_measured() const {
    for (std::size_t i = 0; i < segments_; ++i) {
      std::int32_t moving_axis = -1;
      bool measured = false;
      for (std::size_t d = 0; d < axes_; ++d) {
        const Cubic& c = cubics_[i * axes_ + d];
        if (c.c1 == 0 && c.c2 == 0 && c.c3 == 0) continue;
        if (weights_[d] > 0) measured = true;
        if (moving_axis < 0) moving_axis = static_cast<std::int32_t>(d);
      }
      if (moving_axis >= 0 && !measured) {
        return Error{
            .code = ErrorCode::unmeasured,
            .what = "an axis moves after this key, but with its weight of 0 the path has no length there",
            .remedy = "give the axis a weight above 0, or a track of its own",
            .key = key_of(i),
            .axis = moving_axis};
      }
    }
    return Done{};
  }

  [[nodiscard]] std::size_t segments() const { return segments_; }
  [[nodiscard]] std::size_t keys() const { return keys_; }
  [[nodiscard]] std::span<const double> weights() const { return weights_; }

 private:
  [[nodiscard]] double key(std::size_t i, std::size_t d) const { return spec_.key(i, d); }
  [[nodiscard]] double chord(std::size_t i, std::size_t d) const { return key(i + 1, d) - key(i, d); }
  /// The key from which a segment leads, once it is built.
  [[nodiscard]] std::int32_t key_of(std::size_t segment) const {
    return has_knots(spec_) ? memory_.knots[segment].key : static_cast<std::int32_t>(segment);
  }
  [[nodiscard]] Cubic& cubic(std::size_t i, std::size_t d) { return cubics_[i * axes_ + d]; }

  void straight(std::size_t i) {
    for (std::size_t d = 0; d < axes_; ++d) cubic(i, d) = {key(i, d), chord(i, d), 0, 0};
  }

  void build_tcb() {
    for (std::size_t i = 0; i < segments_; ++i) {
      for (std::size_t d = 0; d < axes_; ++d) {
        const double delta = chord(i, d);
        const double leaving = tcb_tangent(spec_, i, d, KeySide::leaving);
        const double arriving = tcb_tangent(spec_, i + 1, d, KeySide::arriving);
        cubic(i, d) = {key(i, d), leaving, 3 * delta - 2 * leaving - arriving,
                       leaving + arriving - 2 * delta};
      }
    }
  }

  // The smooth spline. Neighbouring equal keys share a knot, so the unknowns are the second
  // derivatives M_k at the distinct knots k = 0..m, m steps h_k apart. Until the coefficients are
  // written, the slots of cubic(k, 0) hold c0 = h_k, c1 = 1 / pivot_k, c3 = z_k (the answer of row k
  // to the last unknown of a closed path), and cubic(k, d).c2 holds the right-hand side, then M_k.

  void build_smooth() {
    std::size_t steps = 0;
    exponent_ = chord_exponent();
    for (std::size_t i = 0; i < segments_; ++i) {
      if (same_knot(i)) continue;
      cubic(steps, 0).c0 = std::sqrt(scaled_chord(i));
      for (std::size_t d = 0; d < axes_; ++d) cubic(steps, d).c2 = chord(i, d) / cubic(steps, 0).c0;
      ++steps;
    }
    if (steps < 2) {
      for (std::size_t i = 0; i < segments_; ++i) straight(i);
      return;
    }
    for (std::size_t d = 0; d < axes_; ++d) slopes_to_right_hand_side(d, steps);
    if (spec_.closed) {
      solve_periodic(steps);
    } else {
      factor(1, steps);
      for (std::size_t d = 0; d < axes_; ++d) {
        solve(1, steps, [&](std::size_t k) -> double& { return cubic(k, d).c2; });
        cubic(0, d).c2 = 0;
        cubic(steps, d).c2 = 0;
      }
    }
    for (std::size_t d = axes_; d-- > 0;) write_smooth(d, steps);  // axis 0 last: its slots hold h
  }

  /// The power of two that makes the longest chord about 1: only ratios of knots matter, and the roots of
  /// scaled chords round as those of unscaled ones.
  [[nodiscard]] int chord_exponent() const {
    double longest = 0;
    for (std::size_t i = 0; i < segments_; ++i) longest = std::max(longest, weighted_chord(i));
    int exponent = 0;
    static_cast<void>(std::frexp(longest, &exponent));
    return exponent;
  }

  [[nodiscard]] double weighted_chord(std::size_t i) const {
    return scaled_norm(axes_, [&](std::size_t d) { return weights_[d] * chord(i, d); });
  }

  [[nodiscard]] double scaled_chord(std::size_t i) const { return std::ldexp(weighted_chord(i), -exponent_); }
  /// Equal keys, or nearer to each other than the longest chord lets them be told apart.
  [[nodiscard]] bool same_knot(std::size_t i) const {
    return scaled_chord(i) < std::numeric_limits<double>::min();
  }

  void slopes_to_right_hand_side(std::size_t d, std::size_t steps) {
    const double first = cubic(0, d).c2;
    const double last = cubic(steps - 1, d).c2;
    for (std::size_t k = steps - 1; k > 0; --k) {
      cubic(k, d).c2 = 6 * (cubic(k, d).c2 - cubic(k - 1, d).c2);
    }
    cubic(0, d).c2 = 6 * (first - last);  // the row of knot 0, which only a closed path has
  }

  [[nodiscard]] double step(std::size_t k) { return cubic(k, 0).c0; }

  /// Rows first..end-1 of h_k-1 M_k-1 + 2 (h_k-1 + h_k) M_k + h_k M_k+1 = r_k, with the unknowns
  /// outside taken to the right-hand side. In a closed path the step before 0 is the last.
  void factor(std::size_t first, std::size_t end) {
    double inverse_before = 0;
    for (std::size_t k = first; k < end; ++k) {
      const double before = k > 0 ? step(k - 1) : step(end);
      const double eliminated = k > first ? before * before * inverse_before : 0.0;
      inverse_before = 1 / (2 * (before + step(k)) - eliminated);
      cubic(k, 0).c1 = inverse_before;
    }
  }
  template <class Unknown>
  void solve(std::size_t first, std::size_t end, Unknown unknown) {
    for (std::size_t k = first; k < end; ++k) {
      const double carried = k > first ? step(k - 1) * unknown(k - 1) : 0.0;
      unknown(k) = (unknown(k) - carried) * cubic(k, 0).c1;
    }
    for (std::size_t k = end - 1; k-- > first;) {
      unknown(k) -= step(k) * cubic(k, 0).c1 * unknown(k + 1);
    }
  }

  /// Rows 0..m-2 are solved with M_m-1 as a parameter; the last row then gives it.
  void solve_periodic(std::size_t m) {
    const std::size_t last = m - 1;
    factor(0, last);
    const auto z = [&](std::size_t k) -> double& { return cubic(k, 0).c3; };
    for (std::size_t k = 0; k < last; ++k) z(k) = 0;
    z(0) -= step(last);
    z(last - 1) -= step(last - 1);
    solve(0, last, z);
    const double diagonal =
        2 * (step(last - 1) + step(last)) + step(last - 1) * z(last - 1) + step(last) * z(0);
    for (std::size_t d = 0; d < axes_; ++d) {
      const auto moment = [&](std::size_t k) -> double& { return cubic(k, d).c2; };
      solve(0, last, moment);
      const double known = step(last - 1) * moment(last - 1) + step(last) * moment(0);
      moment(last) = (moment(last) - known) / diagonal;
      for (std::size_t k = 0; k < last; ++k) moment(k) += z(k) * moment(last);
    }
  }

  /// From the last segment to the first, because knot k stands at or before its segment's own slot.
  void write_smooth(std::size_t d, std::size_t steps) {
    std::size_t k = steps;
    double moment_after = spec_.closed ? cubic(0, d).c2 : cubic(steps, d).c2;
    for (std::size_t i = segments_; i-- > 0;) {
      const double delta = chord(i, d);
      if (same_knot(i)) {
        cubic(i, d) = {key(i, d), delta, 0, 0};
        continue;
      }
      --k;
      const double moment = cubic(k, d).c2;
      const double square = step(k) * step(k);
      cubic(i, d) = {key(i, d), delta - square * (2 * moment + moment_after) / 6, square * moment / 2,
                     square * (moment_after - moment) / 6};
      moment_after = moment;
    }
  }

  /// Fritsch and Carlson 1980: slopes of one sign, none above 3 times either chord's, make a cubic monotone.
  /// A segment without length keeps its straight line, and no slope goes through it.
  void limit_slopes() {
    for (std::size_t d = 0; d < axes_; ++d) {
      double leaving = limited_slope(0, d);
      const double first = leaving;
      for (std::size_t i = 0; i < segments_; ++i) {
        const bool is_ring = spec_.closed && i + 1 == segments_;
        const double next = is_ring ? first : limited_slope(i + 1, d);
        Cubic& c = cubic(i, d);
        if (duration(i) > 0) {
          const double out = leaving * duration(i);
          const double in = next * duration(i);
          const double delta = chord(i, d);
          if (out != c.c1 || in != c.derivative(1))
            c = {c.c0, out, 3 * delta - 2 * out - in, out + in - 2 * delta};
        }
        leaving = next;
      }
    }
  }
  /// How long a segment takes on the parameter on which the path is C1; 0 where it has no length.
  [[nodiscard]] double duration(std::size_t i) const {
    if (spec_.spline != Spline::smooth) return 1;
    return same_knot(i) ? 0.0 : std::sqrt(scaled_chord(i));
  }
  /// The slope at key i, before the cubic of the segment that begins there is changed.
  [[nodiscard]] double limited_slope(std::size_t i, std::size_t d) {
    const auto slope_of_chord = [&](std::size_t k) {
      return duration(k) > 0 ? chord(k, d) / duration(k) : 0.0;
    };
    const bool has_before = i > 0 || spec_.closed;
    const bool has_behind = i < segments_;
    const std::size_t before = i > 0 ? i - 1 : segments_ - 1;
    const double one = slope_of_chord(has_before ? before : i);
    const double other = slope_of_chord(has_behind ? i : before);
    if (!(one * other > 0)) return 0;
    const double time = duration(has_behind ? i : before);
    const double slope = (has_behind ? cubic(i, d).c1 : cubic(before, d).derivative(1)) / time;
    const double most = 3 * std::min(std::fabs(one), std::fabs(other));
    if (slope * one <= 0) return 0;
    return slope > most ? most : (slope < -most ? -most : slope);
  }

  void append_continuation() {
    for (std::size_t d = 0; d < axes_; ++d) {
      Cubic& end = cubic(segments_, d);
      if (segments_ == 0) {
        end = {key(0, d), 0, 0, 0};
        continue;
      }
      const Cubic& c = cubic(segments_ - 1, d);
      end = {key(spec_.closed ? keys_ : keys_ - 1, d), c.derivative(1), c.c2 + 3 * c.c3, c.c3};
      // A seam that is rounded is no key: it returns to where it began.
      if (spec_.closed && cubic(0, d).c0 != key(0, d)) end.c0 += cubic(0, d).c0 - key(0, d);
    }
  }

  const PathSpec& spec_;
  PathMemory memory_;
  std::span<Cubic> cubics_;
  std::span<const double> weights_;
  std::size_t axes_;
  std::size_t keys_;
  std::size_t segments_;
  int exponent_ = 0;
};

}  // namespace

Result<Path> Path::make(const PathSpec& spec, const PathMemory& memory) {
  if (const Status counts = check_counts(spec); !counts) return counts.error();
  if (const Status numbers = check_numbers(spec); !numbers) return numbers.error();
  if (const Status frames = check_key_frames(spec); !frames) return frames.error();
  if (const Status corners = check_corners(spec, memory); !corners) return corners.error();
  if (const Status enough = check_memory(spec, memory); !enough) return enough.error();

  Construction construction(spec, memory);
  construction.build();
  if (const Status in_range = construction.check_range(); !in_range) return in_range.error();
  if (const Status measured = construction.check_measured(); !measured) return measured.error();

  Path path;
  path.axis_count_ = spec.axis_count;
  path.key_count_ = static_cast<std::int32_t>(construction.keys());
  path.segment_count_ = static_cast<std::int32_t>(construction.segments());
  path.cubics_ =
      memory.cubics.first((construction.segments() + 1) * static_cast<std::size_t>(spec.axis_count));
  path.weights_ = construction.weights();
  if (has_knots(spec)) path.knots_ = memory.knots.first(construction.segments());
  path.over_frames_ = !spec.key_frames.empty();
  path.overshoots_ = spec.overshoot;
  path.spline_ = spec.spline;
  path.closed_ = spec.closed;
  return path;
}

void Path::positions(std::span<const PathPoint> points, std::span<double> out) const {
  std::array<double, places_at_once> memory;
  for (std::size_t begin = 0; begin < points.size();) {
    const std::size_t count = take_places(points.subspan(begin), memory);
    const std::span<const double> places = std::span(memory).first(count);
    const std::span<const Cubic> cubics = segment(points[begin].segment);
    for (std::size_t d = 0; d < static_cast<std::size_t>(axis_count_); ++d) {
      const std::span<double> written = out.subspan(d * points.size() + begin, count);
      evaluate(cubics[d], places, written);
      if (overshoots_) continue;
      for (double& position : written) position = kept(position, points[begin].segment, d);
    }
    begin += count;
  }
}

double Path::parametric_speed(const PathPoint& point) const {
  const std::span<const Cubic> cubics = segment(point.segment);
  return scaled_norm(cubics.size(),
                     [&](std::size_t d) { return weights_[d] * cubics[d].derivative(point.t); });
}

}  // namespace inbetween
