#include "inbetween/limits/motion_steps.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/scaled_norm.hpp"
#include "path/segment_speed.hpp"
#include "time_pieces.hpp"
#include "timing/met_place.hpp"

namespace inbetween {
namespace {

/// Speed and acceleration along the path.
template <Precise Real>
struct Pace {
  Real speed = 0;
  Real acceleration = 0;
};

/// The way into a point of the path or out of it, and the pace there.
template <Precise Real>
struct Side {
  std::int32_t segment = 0;
  Real t = 0;
  bool arriving = false;
  Pace<Real> pace;
};

template <Precise Real>
Pace<Real> pace_at(const Track<Real>& track, const CurvePlace<Real>& place, Real constant) {
  const SpeedSpan<Real>& span = track.profile().span(place.span);
  const Real rate = track.curve_rate();
  return {constant * rate * span.value(place.t), constant * rate * rate * span.derivative(place.t)};
}

/// Velocity and acceleration of every axis on one side.
template <Precise Real>
class SidedMotion {
 public:
  SidedMotion(const Track<Real>& track, const Side<Real>& side)
      : path_(track.path()),
        side_(side),
        cubics_(path_.segment(side.segment)),
        sigma_(path_.parametric_speed({side.segment, side.t})),
        second_(norm([&](const Cubic<Real>& cubic) { return cubic.second(side.t); })),
        third_(norm([](const Cubic<Real>& cubic) { return cubic.third(); })) {
    const Real t = side.t;
    // Inside a segment the sides are different only where the path stands still.
    stands_still_ = (t > 0 && t < 1) || sigma_ <= still_speed_share<Real> * (second_ + third_);
    if (stands_still_) return;
    Real change = 0;  // d sigma / dt
    for (std::size_t d = 0; d < cubics_.size(); ++d) {
      const Real weight = path_.weights()[d];
      change += weight * cubics_[d].derivative(t) / sigma_ * (weight * cubics_[d].second(t));
    }
    rate_ = side.pace.speed / sigma_;
    rate_change_ = (side.pace.acceleration - change * rate_ * rate_) / sigma_;
  }

  /// |P''| / |P'|^2, of which the part across the path is its curvature.
  [[nodiscard]] Real bend() const { return stands_still_ ? Real(0) : second_ / sigma_ / sigma_; }

  [[nodiscard]] AxisStep<Real> axis(std::size_t d) const {
    const Cubic<Real>& cubic = cubics_[d];
    const Real t = side_.t;
    if (stands_still_) {
      const Real direction = direction_of(cubic);
      return {direction * side_.pace.speed, direction * side_.pace.acceleration};
    }
    const Real first = cubic.derivative(t);
    return {first * rate_, cubic.second(t) * rate_ * rate_ + first * rate_change_};
  }

 private:
  template <class Derivative>
  [[nodiscard]] Real norm(const Derivative& derivative) const {
    return scaled_norm<Real>(cubics_.size(),
                             [&](std::size_t d) { return path_.weights()[d] * derivative(cubics_[d]); });
  }
  /// The limit of P' / |P'| on this side.
  [[nodiscard]] Real direction_of(const Cubic<Real>& cubic) const {
    if (second_ > still_speed_share<Real> * third_) {
      return (side_.arriving ? -cubic.second(side_.t) : cubic.second(side_.t)) / second_;
    }
    return third_ > 0 ? cubic.third() / third_ : Real(0);
  }

  const Path<Real>& path_;
  Side<Real> side_;
  std::span<const Cubic<Real>> cubics_;
  Real sigma_ = 0, second_ = 0, third_ = 0;
  Real rate_ = 0, rate_change_ = 0;  ///< ds/dt and its change
  bool stands_still_ = false;
};

/// Adds the velocity and acceleration of one side, with a sign.
template <Precise Real>
void add_side(const Track<Real>& track, const Side<Real>& side, Real sign, std::span<AxisStep<Real>> out) {
  if (side.pace.speed == 0 && side.pace.acceleration == 0) return;
  const SidedMotion<Real> motion(track, side);
  for (std::size_t d = 0; d < out.size(); ++d) {
    const AxisStep<Real> axis = motion.axis(d);
    out[d].velocity += sign * axis.velocity;
    out[d].acceleration += sign * axis.acceleration;
  }
}

/// A move timed by frames: the pace is that of the parameter.
template <Precise Real>
void add_interval(const Track<Real>& track, std::int32_t segment, Real t, Real sign,
                  std::span<AxisStep<Real>> out) {
  const KeyInterval<Real>& interval = track.key_intervals()[static_cast<std::size_t>(segment)];
  const ParameterRates<Real> rates = interval.rates(t, track.frame_rate());
  const std::span<const Cubic<Real>> cubics = track.path().segment(segment);
  for (std::size_t d = 0; d < out.size(); ++d) {
    const Real slope = cubics[d].derivative(t);
    out[d].velocity += sign * (slope * rates.first);
    out[d].acceleration += sign * (cubics[d].second(t) * rates.first * rates.first + slope * rates.second);
  }
}

template <Precise Real>
Real add_key_of_frames(const Track<Real>& track, std::int32_t key, std::span<AxisStep<Real>> out) {
  const std::int32_t segments = track.path().segment_count();
  if (key > 0) add_interval(track, key - 1, Real(1), Real(-1), out);
  if (key >= segments) return static_cast<Real>(track.frames());
  add_interval(track, key, Real(0), Real(1), out);
  return track.key_intervals()[static_cast<std::size_t>(key)].begin();
}

template <Precise Real>
Real add_key_of_curve(const Track<Real>& track, std::int32_t key, std::span<AxisStep<Real>> out) {
  const std::int32_t segments = track.path().segment_count();
  const std::int32_t f = track.profile().span_count();
  std::int32_t next = key;
  while (next < segments && !has_length(track, next)) ++next;
  MetPlace<Real> met;
  if (key == 0) {
    met = {{0, 0}, 0, track.portions().empty() ? track.constant() : track.portions().front().constant};
  } else if (next >= segments) {
    met = {{f - 1, 1}, track.portions().empty() ? track.constant() : track.portions().back().constant, 0};
  } else {
    met = find_distance(track, track.arc_length().segment_begin(key));
  }
  const Real frame = frame_of(track, met.place);
  if (key > 0 && !has_length(track, key - 1)) return frame;  // the key before it is here too
  if (key > 0) {
    add_side(track, {key - 1, Real(1), true, pace_at(track, met.place, met.arriving)}, Real(-1), out);
  }
  if (next < segments) {
    add_side(track, {next, Real(0), false, pace_at(track, met.place, met.leaving)}, Real(1), out);
  }
  return frame;
}

/// The interval on that side of a frame, and where in it.
template <Precise Real>
std::pair<std::int32_t, Real> interval_beside(const Track<Real>& track, std::int32_t frame, bool arriving) {
  const std::span<const KeyInterval<Real>> intervals = track.key_intervals();
  std::size_t i = intervals.size() - 1;
  while (i > 0 && intervals[i].u({frame, 0}) < 0) --i;
  const Real u = intervals[i].u({frame, 0});
  if (u == 0 && arriving && i > 0) return {static_cast<std::int32_t>(i) - 1, Real(1)};
  return {static_cast<std::int32_t>(i), u};
}

/// The sum, and 0 where it is no more than rounding.
template <Precise Real>
Real sum_without_rounding(Real a, Real b, Real c) {
  const Real sum = a + b + c;
  const Real size = std::fabs(a) + std::fabs(b) + std::fabs(c);
  return std::fabs(sum) <= 16 * std::numeric_limits<Real>::epsilon() * size ? Real(0) : sum;
}

template <Precise Real>
void add_motion_of_frames(const Track<Real>& track, std::int32_t frame, bool arriving,
                          std::span<AxisMotion<Real>> out) {
  const auto [segment, u] = interval_beside(track, frame, arriving);
  const KeyInterval<Real>& interval = track.key_intervals()[static_cast<std::size_t>(segment)];
  const ParameterRates<Real> rates = interval.rates(u, track.frame_rate());
  const Real t = u * (interval.c1 + u * (interval.c2 + u * interval.c3));
  const std::span<const Cubic<Real>> cubics = track.path().segment(segment);
  for (std::size_t d = 0; d < out.size(); ++d) {
    const Cubic<Real>& cubic = cubics[d];
    const Real slope = sum_without_rounding(cubic.c1, 2 * cubic.c2 * t, 3 * cubic.c3 * t * t);
    const Real bend = sum_without_rounding(2 * cubic.c2, 6 * cubic.c3 * t, Real(0));
    out[d].velocity = slope * rates.first;
    out[d].acceleration = bend * rates.first * rates.first + slope * rates.second;
  }
}

/// The segment on that side of a key that is met on a frame; -1 where none is met there.
template <Precise Real>
std::int32_t segment_beside(const Track<Real>& track, std::int32_t frame, bool arriving) {
  const TwoSum<Real> distance = track.distance({frame, 0});
  const Real margin = lock_share<Real> * track.arc_length().total();
  const std::int32_t last = track.path().segment_count();
  const std::int32_t here = track.locate({frame, 0}).segment;
  for (std::int32_t key = here; key <= std::min(here + 1, last); ++key) {
    if (!(std::fabs(distance.minus(track.arc_length().segment_begin(key))) <= margin)) continue;
    std::int32_t segment = arriving ? key - 1 : key;
    while (segment >= 0 && segment < last && !has_length(track, segment)) segment += arriving ? -1 : 1;
    return segment < last ? segment : -1;
  }
  return -1;
}

template <Precise Real>
void add_motion_of_curve(const Track<Real>& track, std::int32_t frame, bool arriving,
                         std::span<AxisMotion<Real>> out) {
  const CurvePlace<Real> place = track.place({frame, 0});
  const bool rests = track.profile().span(place.span).value(place.t) == 0;
  const std::int32_t segment = segment_beside(track, frame, arriving);
  if (!rests && segment < 0) return;
  for (AxisMotion<Real>& axis : out) axis = {.position = axis.position};
  if (rests) return;
  Real constant = track.constant();
  for (const Portion<Real>& portion : track.portions()) {
    if (portion.begin_frame < frame || (portion.begin_frame == frame && !arriving))
      constant = portion.constant;
  }
  const Side<Real> side{segment, Real(arriving ? 1 : 0), arriving, pace_at(track, place, constant)};
  const SidedMotion<Real> motion(track, side);
  for (std::size_t d = 0; d < out.size(); ++d) {
    out[d].velocity = motion.axis(d).velocity;
    out[d].acceleration = motion.axis(d).acceleration;
  }
}

template <Precise Real>
void make_magnitudes(std::span<AxisStep<Real>> axes) {
  for (AxisStep<Real>& axis : axes) {
    axis.velocity = std::fabs(axis.velocity);
    axis.acceleration = std::fabs(axis.acceleration);
  }
}

}  // namespace

template <Precise Real>
Real steps_at_key(const Track<Real>& track, std::int32_t key, std::span<AxisStep<Real>> out) {
  const std::span<AxisStep<Real>> axes = out.first(static_cast<std::size_t>(track.path().axis_count()));
  for (AxisStep<Real>& axis : axes) axis = {};
  if (track.path().segment_count() == 0) return 0;
  const Real frame =
      track.has_profile() ? add_key_of_curve(track, key, axes) : add_key_of_frames(track, key, axes);
  make_magnitudes(axes);
  return frame;
}

template <Precise Real>
PaceBounds<Real> pace_bounds(const Track<Real>& track) {
  constexpr Real infinity = std::numeric_limits<Real>::infinity();
  if (!track.has_profile() || !track.portions().empty()) return {infinity, infinity};
  Real highest = 0;
  Real steepest = 0;
  for (std::int32_t i = 0; i < track.profile().span_count(); ++i) {
    const auto [b0, b1, b2, b3] = track.profile().span(i);
    highest = std::max({highest, b0, b1, b2, b3});
    steepest = std::max({steepest, std::fabs(b1 - b0), std::fabs(b2 - b1), std::fabs(b3 - b2)});
  }
  const Real rate = track.curve_rate();
  return {track.constant() * rate * highest, track.constant() * rate * rate * (3 * steepest)};
}

template <Precise Real>
void bound_steps_at_key(const Track<Real>& track, std::int32_t key, const PaceBounds<Real>& pace,
                        std::span<AxisStep<Real>> out) {
  const std::span<AxisStep<Real>> axes = out.first(static_cast<std::size_t>(track.path().axis_count()));
  constexpr Real infinity = std::numeric_limits<Real>::infinity();
  for (AxisStep<Real>& axis : axes) axis = {infinity, infinity};
  const bool is_inside = key > 0 && key < track.path().segment_count();
  if (!is_inside || !(pace.speed < infinity) || !has_length(track, key - 1) || !has_length(track, key))
    return;
  // With the speed w the velocity is T w and the acceleration T' w^2 + T w', T = dP/dL: at the unit speed
  // that stays they are T and T'.
  const SidedMotion<Real> before(track, Side<Real>{key - 1, Real(1), true, {1, 0}});
  const SidedMotion<Real> after(track, Side<Real>{key, Real(0), false, {1, 0}});
  constexpr Real rounding = 64 * std::numeric_limits<Real>::epsilon();
  const auto step = [](Real from, Real to) {
    return std::fabs(to - from) + rounding * (std::fabs(to) + std::fabs(from));
  };
  const Real bend = before.bend() + after.bend();
  for (std::size_t d = 0; d < axes.size(); ++d) {
    const AxisStep<Real> one = before.axis(d);
    const AxisStep<Real> other = after.axis(d);
    const Real turn = step(one.velocity, other.velocity);
    axes[d].velocity = turn * pace.speed;
    // What is along the path cancels, and leaves its rounding.
    const Real along = rounding * bend * (std::fabs(one.velocity) + std::fabs(other.velocity));
    axes[d].acceleration = (step(one.acceleration, other.acceleration) + along) * pace.speed * pace.speed +
                           turn * pace.acceleration;
  }
}

template <Precise Real>
void motion_beside(const Track<Real>& track, std::int32_t frame, bool arriving,
                   std::span<AxisMotion<Real>> out) {
  const std::span<AxisMotion<Real>> axes = out.first(static_cast<std::size_t>(track.path().axis_count()));
  track.motion({frame, 0}, axes);
  for (AxisMotion<Real>& axis : axes) axis.jerk = 0;
  if (track.path().segment_count() == 0) return;
  if (track.has_profile()) {
    add_motion_of_curve(track, frame, arriving, axes);
  } else {
    add_motion_of_frames(track, frame, arriving, axes);
  }
}

template <Precise Real>
Standstills<Real> standstills_within(const Track<Real>& track, std::int32_t segment) {
  Standstills<Real> found;
  if (!track.has_profile()) return found;
  const SegmentSpeed<Real> speed(track.path().segment(segment), track.path().weights());
  if (speed.is_still()) return found;
  const AnchoredIntervals<Real> split = split_where_slow(speed);
  for (std::size_t i = 0; i < split.count; ++i) {
    const AnchoredInterval<Real>& interval = split.intervals[i];
    const bool inside = interval.anchor > 0 && interval.anchor < 1;
    if (!inside || !interval.stands_still || !interval.forward) continue;
    if (found.count < found.t.size()) found.t[found.count++] = interval.anchor;
  }
  return found;
}

template <Precise Real>
Real steps_at_standstill(const Track<Real>& track, const PathPoint<Real>& point,
                         std::span<AxisStep<Real>> out) {
  const std::span<AxisStep<Real>> axes = out.first(static_cast<std::size_t>(track.path().axis_count()));
  for (AxisStep<Real>& axis : axes) axis = {};
  const MetPlace<Real> met = find_distance(track, track.arc_length().distance(track.path(), point));
  add_side(track, {point.segment, point.t, true, pace_at(track, met.place, met.arriving)}, Real(-1), axes);
  add_side(track, {point.segment, point.t, false, pace_at(track, met.place, met.leaving)}, Real(1), axes);
  make_magnitudes(axes);
  return frame_of(track, met.place);
}

template double steps_at_key(const Track<double>&, std::int32_t, std::span<AxisStep<double>>);
template float steps_at_key(const Track<float>&, std::int32_t, std::span<AxisStep<float>>);
template PaceBounds<double> pace_bounds(const Track<double>&);
template PaceBounds<float> pace_bounds(const Track<float>&);
template void bound_steps_at_key(const Track<double>&, std::int32_t, const PaceBounds<double>&,
                                 std::span<AxisStep<double>>);
template void bound_steps_at_key(const Track<float>&, std::int32_t, const PaceBounds<float>&,
                                 std::span<AxisStep<float>>);
template void motion_beside(const Track<double>&, std::int32_t, bool, std::span<AxisMotion<double>>);
template void motion_beside(const Track<float>&, std::int32_t, bool, std::span<AxisMotion<float>>);
template Standstills<double> standstills_within(const Track<double>&, std::int32_t);
template Standstills<float> standstills_within(const Track<float>&, std::int32_t);
template double steps_at_standstill(const Track<double>&, const PathPoint<double>&,
                                    std::span<AxisStep<double>>);
template float steps_at_standstill(const Track<float>&, const PathPoint<float>&, std::span<AxisStep<float>>);

}  // namespace inbetween
