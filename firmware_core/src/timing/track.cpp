#include "inbetween/timing/track.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/scaled_norm.hpp"
#include "inbetween/base/processor_clones.hpp"
#include "path/segment_speed.hpp"

namespace inbetween {
namespace {

/// Frames whose lengths stand on the stack at a time: enough to fill the vector registers often, less than 1
/// KB in double precision.
constexpr std::size_t frames_per_block = 120;

/// The lengths to frames of one span; `phase` is that of the first, in parts of a span.
INBETWEEN_PROCESSOR_CLONES void find_lengths(const SpanDistance& span, std::int32_t phase, std::int32_t step,
                                             double part, std::span<double> lengths) {
  const SpanDistance own = span;
  for (double& length : lengths) {
    length = own.length(static_cast<double>(phase) * part);
    phase += step;
  }
}

/// The inner products of W P', W P'' and W P''', W = diag(weights), at one place of the path.
struct SlopeProducts {
  double p11 = 0, p12 = 0, p13 = 0, p22 = 0, p33 = 0;

  void add(double first, double second, double third) {
    p11 += first * first;
    p12 += first * second;
    p13 += first * third;
    p22 += second * second;
    p33 += third * third;
  }
  /// Neither these nor a third power of p11 overflow or vanish.
  [[nodiscard]] bool is_in_range() const {
    constexpr double most = 1e100;
    return p11 > 1 / most && p11 < most && p22 < most && p33 < most;
  }
};

/// sigma = |W P'| and its derivatives in t.
struct ParametricSpeed {
  double inverse = 0;            ///< 1 / sigma
  double first = 0, second = 0;  ///< sigma' / sigma, sigma'' / sigma

  /// The root and the division do not wait for each other.
  explicit ParametricSpeed(const SlopeProducts& products) {
    const double inverse_square = 1 / products.p11;
    inverse = std::sqrt(products.p11) * inverse_square;
    first = products.p12 * inverse_square;
    second = (products.p22 + products.p13) * inverse_square - first * first;
  }
};

/// The same of a place where the products over- or underflow; sigma, above 0, is known there. Everything is
/// in units of a power of two near it.
struct ScaledSpeed {
  double scale;
  ParametricSpeed speed;

  ScaledSpeed(std::span<const Cubic> cubics, std::span<const double> weights, double t, double sigma)
      : scale(scale_of(sigma)), speed(products_of(cubics, weights, t, scale)) {}

 private:
  static SlopeProducts products_of(std::span<const Cubic> cubics, std::span<const double> weights, double t,
                                   double scale) {
    SlopeProducts products;
    for (std::size_t d = 0; d < cubics.size(); ++d) {
      const double weight = scale * weights[d];
      products.add(weight * cubics[d].derivative(t), weight * cubics[d].second(t),
                   weight * cubics[d].third());
    }
    return products;
  }
  static double scale_of(double sigma) {
    int exponent = 0;
    static_cast<void>(std::frexp(sigma, &exponent));
    return std::ldexp(1.0, -exponent);
  }
};

/// From sigma s' = v by differentiating twice in time.
ParameterRates parameter_rates(const AlongPath& along, const ParametricSpeed& speed, double scale = 1) {
  ParameterRates s;
  s.first = scale * along.speed * speed.inverse;
  const double square = s.first * s.first;
  s.second = scale * along.acceleration * speed.inverse - speed.first * square;
  s.third = scale * along.jerk * speed.inverse - speed.second * (square * s.first) -
            3 * (speed.first * s.first) * s.second;
  return s;
}

/// Position and derivatives by t. Doubling rounds nothing.
AxisMotion slopes_of(const Cubic& cubic, double t) {
  const double third = 3 * cubic.c3;
  const double second = 2 * cubic.c2;
  return {cubic.value(t), cubic.c1 + t * (second + t * third), second + t * (2 * third), 2 * third};
}

/// The slopes of all axes, and what they and those of the guides behind them add up to.
inline SlopeProducts write_slopes(std::span<const Cubic> cubics, std::span<const double> weights, double t,
                                  std::span<AxisMotion> axes) {
  SlopeProducts products;
  const auto add = [&](const AxisMotion& slopes, double weight) {
    products.add(weight * slopes.velocity, weight * slopes.acceleration, weight * slopes.jerk);
  };
  for (std::size_t d = 0; d < axes.size(); ++d) {
    axes[d] = slopes_of(cubics[d], t);
    add(axes[d], weights[d]);
  }
  for (std::size_t d = axes.size(); d < cubics.size(); ++d) add(slopes_of(cubics[d], t), weights[d]);
  return products;
}

/// A derivative beyond the range of double is given as 0, and then none is known.
std::uint8_t without_overflow(std::span<AxisMotion> motion, std::uint8_t order) {
  for (AxisMotion& axis : motion) {
    for (double* derivative : {&axis.velocity, &axis.acceleration, &axis.jerk}) {
      if (std::isfinite(*derivative)) continue;
      *derivative = 0;
      order = 0;
    }
  }
  return order;
}

/// Derivatives of t below this overflow in no axis: the coefficients of a path are at most 1000 times
/// Precision::largest, its derivatives by t eight times as large, and the third power of this is the
/// greatest factor.
constexpr double safe_rate = 1e60;

/// The chain rule for p(t(time)), axis by axis: derivatives by t become derivatives in time.
inline std::uint8_t pass_in_time(const ParameterRates& s, std::span<AxisMotion> axes) {
  const double square = s.first * s.first;
  const double cube = square * s.first;
  const double cross = 3 * s.first * s.second;
  for (AxisMotion& axis : axes) {
    const auto [position, p1, p2, p3] = axis;
    axis = {position, p1 * s.first, p2 * square + p1 * s.second, p3 * cube + p2 * cross + p1 * s.third};
  }
  const double most = safe_rate;
  if (std::fabs(s.first) < most && std::fabs(s.second) < most && std::fabs(s.third) < most) [[likely]]
    return 3;
  return without_overflow(axes, 3);
}

/// How far the distance at which a path is found to stand still may be from the true one, in roundings of
/// the length. Measured on 3000 paths with a cusp between two keys: at most 1.4 in double and 1.1 in single
/// precision; FuzzFinds.ACuspBetweenKeysIsReportedWhereverItLies holds it.
constexpr int distance_roundings = 2;

/// Whether P' = 0 is further away than `rounding` for sure, as it is nearly everywhere: the comparison of
/// Standstill::distance() for both manners in which a path comes to rest, without a root.
bool is_far_from_standstill(const SlopeProducts& p, double rounding) {
  const double square = rounding * rounding;
  return p.is_in_range() && p.p11 * p.p11 > 4 * square * p.p22 &&
         p.p11 * p.p11 * p.p11 > 21 * square * (square * p.p33);
}

/// A point from which P' = 0 is not far, if it is anywhere.
struct Standstill {
  double sigma = 0, second = 0, third = 0;  ///< |W P'|, |W P''|, |W P'''|

  /// P' vanishes to first order: the direction turns to its opposite. Otherwise it goes on.
  [[nodiscard]] bool turns() const { return second > still_speed_share * third; }
  /// How far in t: from sigma = second t, or from sigma = third t^2 / 2.
  [[nodiscard]] double time() const {
    if (sigma == 0) return 0;
    return turns() ? sigma / second : std::sqrt(2 * (sigma / third));
  }
  /// How far along the path: the integral of sigma.
  [[nodiscard]] double distance() const { return sigma * (time() / (turns() ? 2.0 : 3.0)); }
  /// P' is no more than rounding.
  [[nodiscard]] bool is_here() const { return sigma <= still_speed_share * (second + third); }

  /// Whether this axis' derivative is 0 at the standstill as far as can be told from here.
  [[nodiscard]] bool holds(const Cubic& cubic, double t) const {
    const double second_of_axis = std::fabs(cubic.second(t));
    const double third_of_axis = std::fabs(cubic.third());
    const double margin = 4;  // where P'' and P''' both count, time() is up to half too short
    const double rounding = still_speed_share * (second_of_axis + third_of_axis);
    return std::fabs(cubic.derivative(t)) <=
           margin * time() * (second_of_axis + time() * third_of_axis) + rounding;
  }
};

/// Where several keys lie in one place the path is still between them: the motion leaves from the last of
/// them, and at the end of the path it has arrived at the first. Everywhere else the point itself.
PathPoint moving_side(const Path& path, const PathPoint& point) {
  const auto is_still = [&](std::int32_t segment) {
    const std::span<const Cubic> cubics = path.segment(segment);
    return std::ranges::all_of(
        cubics, [](const Cubic& cubic) { return cubic.c1 == 0 && cubic.c2 == 0 && cubic.c3 == 0; });
  };
  if (!is_still(point.segment)) return point;
  for (std::int32_t i = point.segment + 1; i < path.segment_count(); ++i) {
    if (!is_still(i)) return {i, 0};
  }
  for (std::int32_t i = point.segment; i-- > 0;) {
    if (!is_still(i)) return {i, 1};
  }
  return point;
}

inline void keep_positions(const Path& path, std::int32_t segment, std::span<AxisMotion> axes) {
  if (path.overshoots()) [[likely]]
    return;
  for (std::size_t d = 0; d < axes.size(); ++d) axes[d].position = path.kept(axes[d].position, segment, d);
}

std::uint8_t write_standstill(const Path& path, const AlongPath& along, const Standstill& standstill,
                              std::span<AxisMotion> out) {
  const std::span<const Cubic> cubics = path.segment(along.point.segment);
  const double t = along.point.t;
  const bool stays = along.speed == 0 && along.acceleration == 0 && along.jerk == 0;
  // The direction is the limit of P' / |P'|, +-P'' on either side, and where P'' = 0 too, P'''.
  const double side = along.point.segment == path.segment_count() ? -1.0 : 1.0;
  std::uint8_t order = stays ? 3 : 1;
  for (std::size_t d = 0; d < out.size(); ++d) {
    const bool measured = path.weights()[d] > 0 && !standstill.is_here();
    out[d] = {.position = cubics[d].value(t)};
    if (stays) continue;
    if (!measured && !standstill.holds(cubics[d], t)) {
      order = 0;
      continue;
    }
    double direction = 0;
    if (!standstill.is_here()) {
      direction = cubics[d].derivative(t) / standstill.sigma;
    } else if (standstill.turns()) {
      direction = side * cubics[d].second(t) / standstill.second;
    } else if (standstill.third > 0) {
      direction = cubics[d].third() / standstill.third;
    }
    out[d].velocity = direction * along.speed;
    out[d].acceleration = direction * along.acceleration;
  }
  return without_overflow(out, order);
}

}  // namespace

bool Track::locate_frames(std::int32_t first, std::span<PathPoint> points) const {
  if (!is_plain_) {
    for (std::size_t i = 0; i < points.size(); ++i)
      points[i] = locate({first + static_cast<std::int32_t>(i), 0});
    return false;
  }
  std::array<double, frames_per_block> lengths;
  const std::int32_t f = profile_.span_count();
  const bool has_last = !points.empty() && first + static_cast<std::int32_t>(points.size()) > frames_;
  if (has_last) points.back() = {path_.segment_count(), 0};  // no point is behind it
  const std::size_t total = points.size() - (has_last ? 1 : 0);
  bool in_order = true;
  for (std::size_t done = 0; done < total;) {
    const std::int32_t scaled = (first + static_cast<std::int32_t>(done)) * f;
    const std::int32_t index = scaled / frames_;
    const std::int32_t phase = scaled - index * frames_;
    const std::int32_t in_span = (frames_ - phase - 1) / f + 1;
    const std::span<double> run =
        std::span(lengths).first(std::min({lengths.size(), total - done, static_cast<std::size_t>(in_span)}));
    const SpanDistance& span = span_distances_[static_cast<std::size_t>(index)];
    find_lengths(span, phase, f, inverse_frames_, run);
    const bool run_in_order = arc_length_.locate(span.begin, run, points.subspan(done, run.size()));
    in_order = in_order && run_in_order && (done == 0 || points[done - 1].at_or_before(points[done]));
    done += run.size();
  }
  return in_order;
}

// Each calls what is rare from its own frame, not through locate(): a tick on a microcontroller has less
// stack for it.
inline AlongPath Track::along_profile(const FrameTime& time) const {
  AlongPath result;
  const bool is_end = time.frame >= frames_;
  if (is_end) result.point = {path_.segment_count(), 0};
  if (is_outside(time)) return result;
  const CurvePlace where = place(time);
  if (!is_end) result.point = is_plain_ ? locate_at(where) : special_locate(time);
  const SpeedSpan& span = profile_.span(where.span);
  const double rate = curve_rate();
  const double scale = (portions_.empty() ? constant_ : portion_at(time.frame).constant) * rate;
  result.speed = scale * span.value(where.t);
  result.acceleration = scale * rate * span.derivative(where.t);
  result.jerk = scale * rate * rate * span.second(where.t);
  return result;
}

AlongPath Track::along_key_frames(const FrameTime& time) const {
  AlongPath result;
  result.point = locate(time);
  if (is_outside(time)) return result;
  // These follow from sigma s' = v by differentiating.
  const ParameterRates s = key_frame_rates(time);
  const double sigma = path_.parametric_speed(result.point);
  result.speed = sigma * s.first;
  if (sigma > 0) {
    const ScaledSpeed scaled(path_.segment(result.point.segment), path_.weights(), result.point.t, sigma);
    const auto [inverse, first, second] = scaled.speed;
    result.acceleration = sigma * (first * s.first * s.first + s.second);
    result.jerk = sigma * (second * s.first * s.first * s.first + 3 * first * s.first * s.second + s.third);
  }
  return result;
}

AlongPath Track::along(const FrameTime& time) const {
  AlongPath result = has_profile() ? along_profile(time) : along_key_frames(time);
  for (double* derivative : {&result.speed, &result.acceleration, &result.jerk}) {
    if (!std::isfinite(*derivative)) *derivative = 0;
  }
  return result;
}

/// A part of both, so that a tick has no frame for it.
inline std::uint8_t Track::write_motion(const AlongPath& where, std::span<AxisMotion> axes) const {
  const std::span<const Cubic> cubics = path_.segment(where.point.segment);
  const SlopeProducts products = write_slopes(cubics, path_.weights(), where.point.t, axes);
  keep_positions(path_, where.point.segment, axes);
  if (is_far_from_standstill(products, distance_rounding())) [[likely]]
    return pass_in_time(parameter_rates(where, ParametricSpeed(products)), axes);
  return write_slow(where, axes);
}

std::uint8_t Track::motion(const FrameTime& time, std::span<AxisMotion> out) const {
  const std::span<AxisMotion> axes = out.first(static_cast<std::size_t>(path_.axis_count()));
  if (!has_profile()) {
    const PathPoint point = locate(time);
    const ParameterRates s = is_outside(time) ? ParameterRates{} : key_frame_rates(time);
    write_slopes(path_.segment(point.segment), path_.weights(), point.t, axes);
    keep_positions(path_, point.segment, axes);
    return pass_in_time(s, axes);
  }
  return write_motion(along_profile(time), axes);
}

std::uint8_t Track::motion_at(const AlongPath& where, std::span<AxisMotion> out) const {
  return write_motion(where, out.first(static_cast<std::size_t>(path_.axis_count())));
}

/// Nearer than this the distance is not known: on which side of a standstill the motion is cannot be told.
double Track::distance_rounding() const {
  return distance_roundings * std::numeric_limits<double>::epsilon() * arc_length_.total();
}

/// Position and derivatives where the path may stand still, or where a plain sum of squares overflows.
std::uint8_t Track::write_slow(AlongPath where, std::span<AxisMotion> axes) const {
  const PathPoint here = where.point;
  where.point = moving_side(path_, here);
  const std::span<const Cubic> cubics = path_.segment(where.point.segment);
  const std::span<const double> weights = path_.weights();
  const double t = where.point.t;
  const Standstill standstill{
      path_.parametric_speed(where.point),
      scaled_norm(cubics.size(), [&](std::size_t d) { return weights[d] * cubics[d].second(t); }),
      scaled_norm(cubics.size(), [&](std::size_t d) { return weights[d] * cubics[d].third(); })};
  std::uint8_t order = 3;
  if (standstill.distance() <= distance_rounding()) {
    order = write_standstill(path_, where, standstill, axes);
  } else {
    const ScaledSpeed scaled(cubics, weights, t, standstill.sigma);
    write_slopes(cubics, weights, t, axes);
    order = pass_in_time(parameter_rates(where, scaled.speed, scaled.scale), axes);
  }
  for (std::size_t d = 0; d < axes.size(); ++d) {
    axes[d].position = path_.position(here, static_cast<std::int32_t>(d));  // from either side
  }
  return order;
}

}  // namespace inbetween
