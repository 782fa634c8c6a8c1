#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <span>

#include "base/interval.hpp"
#include "inbetween/base/processor_clones.hpp"
#include "motion_enclosure.hpp"

/// The arithmetic of MotionEnclosure on one axis or on Lanes of them: a Number is either. Everything is
/// inlined into the two functions at the end, which are compiled for each kind of processor.

namespace inbetween {

/// 0 times infinity is anything.
template <Precise Real, class Number>
Number or_infinity(const Number& bound) {
  return least(Number(std::numeric_limits<Real>::infinity()), bound);
}

/// a * b.
template <class Number, Precise Real>
Centred<Number> product(const Centred<Number>& a, const Reciprocal<Real>& b) {
  const Number middle = a.value * b.value;
  if (!(b.range.high <= std::numeric_limits<Real>::max())) {
    return {middle, Number(std::numeric_limits<Real>::infinity())};
  }
  const Interval<Number> range = a.range().times(Interval<Number>::of(b.range));
  return {middle, greatest(range.high - middle, middle - range.low)};
}

template <class Number, Precise Real, std::size_t Size>
Number value_at(const std::array<Number, Size>& c, Real x) {
  Number value = c[Size - 1];
  for (std::size_t i = Size - 1; i-- > 0;) value = c[i] + x * value;
  return value;
}

/// The products of the factors in the middle of a box.
template <class Number, Precise Real>
std::array<Number, motion_quantities> middle(const std::array<Number, motion_quantities>& t, Real pace,
                                             const MotionFactor<Real>& w) {
  return {t[0] * w.part[0].value, t[1] * pace * w.part[0].value + t[0] * w.part[1].value,
          t[2] * pace * pace * pace + Real(3) * t[1] * pace * w.part[1].value + t[0] * w.part[2].value};
}

/// What the products can be on a box, where the speed is not 0 all the time. |dP/dL| is at most `steepest`.
template <class Number, Precise Real>
std::array<Number, motion_quantities> bounds_of(const MotionFactor<Number>& t, const Number& steepest,
                                                const SpeedRanges<Real>& ranges,
                                                const MotionSurroundings<Real>& box,
                                                const std::array<Number, motion_quantities>& here) {
  using Range = Interval<Number>;
  Range first = t.part[0].range();
  first.low = greatest(Real(-1) * steepest, first.low);
  first.high = least(steepest, first.high);
  const Range second = t.part[1].range();
  const Range third = t.part[2].range();
  std::array<Number, motion_quantities> bound;
  const Range jerk = third.times(Range::of(ranges.cube)) +
                     (second * Range::of(ranges.pace_change)).times(Real(3)) +
                     first * Range::of(ranges.second);
  const auto& by = box.jerk_change;
  const Range change_of_jerk = t.third_slope.times(Range::of(by[0])) + third * Range::of(by[1]) +
                               second * Range::of(by[2]) + first * Range::of(by[3]);
  bound[2] = least(or_infinity<Real>(jerk.magnitude()),
                   or_infinity<Real>(absolute(here[2]) + ranges.cube.high * t.rounding +
                                     box.jerk_seconds * change_of_jerk.magnitude()));
  // By the mean value theorem from the middle, or directly.
  const Range acceleration = second.times(Range::of(ranges.pace_speed)) + first * Range::of(ranges.change);
  bound[1] = least(or_infinity<Real>(acceleration.magnitude()),
                   or_infinity<Real>(absolute(here[1]) + box.seconds * bound[2]));
  bound[0] = least(or_infinity<Real>(first.times(Range::of(not_negative(ranges.speed))).magnitude()),
                   or_infinity<Real>(absolute(here[0]) + box.seconds * bound[1]));
  return bound;
}

/// The motion and its bounds, from the derivatives by distance.
template <class Number, Precise Real>
MotionRange<Number> motion_range(const MotionFactor<Number>& t, const Number& steepest, Real pace,
                                 const SpeedRanges<Real>& ranges, const MotionSurroundings<Real>& box,
                                 Real scale) {
  MotionRange<Number> range;
  range.here = middle<Number>({t.part[0].value, t.part[1].value, t.part[2].value}, pace, box.speed);
  if (ranges.is_rest()) {
    range.bound = {};  // wherever it is
  } else {
    range.bound = bounds_of(t, steepest, ranges, box, range.here);
  }
  for (Number& value : range.here) value = scale * value;
  for (Number& value : range.bound) value = scale * value;
  return range;
}

/// dP/dL and its derivatives by distance about tau (by t, if timed by frames); where the path stands still at
/// tau = 0, times 1, tau and tau^3.
template <class Number, Precise Real>
MotionFactor<Number> path_factor(const std::array<Number, 3>& first, const std::array<Number, 5>& second,
                                 const std::array<Number, 8>& third, bool has_profile,
                                 const MotionSurroundings<Real>& box) {
  const CentredSlope<Number> numerator = centred_slope(third, box.tau, box.tau_radius);
  MotionFactor<Number> t{
      {centred(first, box.tau, box.tau_radius), centred(second, box.tau, box.tau_radius), numerator.value}};
  t.rounding = numerator.rounding;
  if (!has_profile) return t;
  t.rounding = t.rounding * box.by_distance[2].value;
  using Range = Interval<Number>;
  const Range part = t.part[2].range() * Range::of(box.by_distance_slope);
  t.third_slope =
      (numerator.slope.range() + Range{Real(-1) * part.high, Real(-1) * part.low}) * Range::of(box.by_fourth);
  for (std::size_t i = 0; i < t.part.size(); ++i) t.part[i] = product(t.part[i], box.by_distance[i]);
  return t;
}

/// What MotionEnclosure::turn does for one axis.
template <Precise Real, class SlopeAt>
[[gnu::flatten]] INBETWEEN_PROCESSOR_CLONES void turn_lane(TurnLanes<Real>& lane,
                                                           std::span<const Real> weights,
                                                           const SlopeAt& slope_at,
                                                           const std::array<Real, 5>& q, Real side) {
  using Number = WideLanes<Real>;
  const auto [a, b, c] = lane.first;
  std::array<Number, 5>& second = lane.second;
  for (std::size_t e = 0; e < weights.size(); ++e) {
    const Real weight = weights[e] * weights[e];
    if (weight == 0) continue;
    const ScaledSlope<Real> other = slope_at(e);
    const auto [A, B, C] = other.first;
    const std::array<Number, 3> cross{b * A - a * B, 2 * (c * A - a * C), c * B - b * C};
    const Number rounding = 32 * std::numeric_limits<Real>::epsilon() * (lane.size * other.size);
    for (std::size_t j = 0; j < 3; ++j) {
      lane.bend = greatest(lane.bend, absolute(cross[j]) - rounding);
      for (std::size_t i = 0; i < 3; ++i)
        second[i + j] = second[i + j] + weight * (other.first[i] * cross[j]);
    }
  }
  const std::array<Real, 4> q_slope = derivative(q);
  for (std::size_t i = 0; i < 4; ++i) {
    const Number slope = static_cast<Real>(i + 1) * second[i + 1];
    for (std::size_t j = 0; j < 5; ++j) {
      lane.third[i + j] = lane.third[i + j] + (slope * q[j] - 2 * (q_slope[i] * second[j]));
    }
  }
  for (Number& term : second) term = side * term;
}

/// Does for a group of axes what MotionEnclosure::here does for one.
template <Precise Real>
[[gnu::flatten]] INBETWEEN_PROCESSOR_CLONES void here_of(
    const TurnLanes<Real>& turn, bool has_profile, const MotionSurroundings<Real>& box, Real scale,
    std::array<WideLanes<Real>, motion_quantities>& out) {
  using Number = WideLanes<Real>;
  std::array<Number, motion_quantities> t{value_at(turn.first, box.tau), value_at(turn.second, box.tau),
                                          value_at(turn.third, box.tau)};
  for (std::size_t i = 0; has_profile && i < t.size(); ++i) t[i] = t[i] * box.by_distance[i].value;
  out = middle(t, box.speed.part[0].value, box.speed);
  for (Number& value : out) value = scale * value;
}

template <Precise Real>
[[gnu::flatten]] INBETWEEN_PROCESSOR_CLONES void range_of(const TurnLanes<Real>& turn, bool has_profile,
                                                          const MotionSurroundings<Real>& box,
                                                          const SpeedRanges<Real>& ranges, Real scale,
                                                          MotionRange<WideLanes<Real>>& out) {
  out = motion_range(path_factor(turn.first, turn.second, turn.third, has_profile, box), turn.steepest,
                     box.speed.part[0].value, ranges, box, scale);
}

}  // namespace inbetween
