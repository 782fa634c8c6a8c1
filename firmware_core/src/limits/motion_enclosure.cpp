#include "motion_enclosure.hpp"

#include "motion_products.hpp"

namespace inbetween {

// --- the path near a point

template <Precise Real>
void MotionEnclosure<Real>::show(const PathPiece<Real>& piece) {
  if (shown_.segment == piece.segment && shown_.index == piece.index) return;
  shown_ = piece;
  is_still_ = track_.has_profile() && is_still_at_anchor(piece.interval);
  scale_ = piece.scale;
  inverse_scale_ = 1 / piece.scale;
  const std::span<const Cubic<Real>> cubics = track_.path().segment(piece.segment);
  if (!track_.has_profile()) {
    show_parameter(cubics);
    return;
  }
  for (std::size_t d = 0; d < cubics.size(); ++d) {
    const ScaledSlope<Real> slope = slope_of(cubics[d], piece);
    if (d >= axes_) {
      guides_[d - axes_] = slope;
      continue;
    }
    turns_[d] = {};
    turns_[d].first = slope.first;
    turns_[d].size = slope.size;
  }
  if constexpr (lanes_are_quick) {
    for (std::size_t begin = 0; !is_still_ && begin < axes_; begin += lanes) turn_in_lanes(begin / lanes);
    if (!is_still_) return;
  }
  for (std::size_t d = 0; d < axes_; ++d) {
    if (turns_by_pace(d)) {
      turn_where_still(d);
    } else {
      turn(d);
    }
  }
}

/// The numerators of each axis in its lane.
template <Precise Real>
void MotionEnclosure<Real>::fill_lanes() {
  if constexpr (lanes_are_quick) {
    for (std::size_t d = 0; d < axes_; ++d) {
      TurnLanes<Real>& to = lanes_[d / lanes];
      const std::size_t i = d % lanes;
      if (i == 0) to = {};
      const AxisTurn<Real>& from = turns_[d];
      for (std::size_t k = 0; k < to.first.size(); ++k) to.first[k].set(i, from.first[k]);
      for (std::size_t k = 0; k < to.second.size(); ++k) to.second[k].set(i, from.second[k]);
      for (std::size_t k = 0; k < to.third.size(); ++k) to.third[k].set(i, from.third[k]);
      to.steepest.set(i, steepest(d));
    }
  }
}

template <Precise Real>
void MotionEnclosure<Real>::turn_in_lanes(std::size_t group) {
  if constexpr (lanes_are_quick) {
    const std::span<AxisTurn<Real>> axes =
        turns_.subspan(group * lanes, std::min(lanes, axes_ - group * lanes));
    TurnLanes<Real>& lane = lanes_[group];
    lane = {};
    for (std::size_t i = 0; i < axes.size(); ++i) {
      for (std::size_t k = 0; k < lane.first.size(); ++k) lane.first[k].set(i, axes[i].first[k]);
      lane.size.set(i, axes[i].size);
      lane.steepest.set(i, steepest(group * lanes + i));
    }
    const auto slope_at = [this](std::size_t e) { return slope(e); };
    turn_lane(lane, track_.path().weights(), slope_at, shown_.interval.speed_squared.q, side());
    for (std::size_t i = 0; i < axes.size(); ++i) {
      axes[i].straight = !(lane.bend[i] > 0);
      if (axes[i].straight) {
        find_direction(group * lanes + i);
        continue;
      }
      for (std::size_t k = 0; k < lane.second.size(); ++k) axes[i].second[k] = lane.second[k][i];
      for (std::size_t k = 0; k < lane.third.size(); ++k) axes[i].third[k] = lane.third[k][i];
    }
  }
}

template <Precise Real>
ScaledSlope<Real> MotionEnclosure<Real>::slope_of(const Cubic<Real>& c, const PathPiece<Real>& piece) const {
  const Real scale = inverse_scale_;
  const Real side = piece.interval.forward ? 1 : -1;
  const Real anchor = piece.interval.anchor;
  ScaledSlope<Real> slope{.first = {scale * (c.c1 + anchor * (2 * c.c2 + 3 * c.c3 * anchor)),
                                    side * scale * (2 * c.c2 + 6 * c.c3 * anchor), 3 * scale * c.c3},
                          .size = scale * (std::fabs(c.c1) + 2 * std::fabs(c.c2) + 3 * std::fabs(c.c3))};
  // An axis without a weight may move on where the others stand still.
  if (is_still_ && std::fabs(slope.first[0]) <= still_speed_share<Real> * slope.size) slope.first[0] = 0;
  return slope;
}

template <Precise Real>
void MotionEnclosure<Real>::show_parameter(std::span<const Cubic<Real>> cubics) {
  for (std::size_t d = 0; d < axes_; ++d) {
    const Cubic<Real>& c = cubics[d];
    turns_[d] = {};
    turns_[d].first = {c.c1, 2 * c.c2, 3 * c.c3};
    turns_[d].second = {2 * c.c2, 6 * c.c3, 0, 0, 0};
    turns_[d].third = {6 * c.c3, 0, 0, 0, 0, 0, 0, 0};
  }
  fill_lanes();
}

/// The numerators of the second and third derivative by distance.
template <Precise Real>
void MotionEnclosure<Real>::turn(std::size_t d) {
  AxisTurn<Real>& axis = turns_[d];
  const auto [a, b, c] = axis.first;
  const std::span<const Real> weights = track_.path().weights();
  axis.straight = true;
  for (std::size_t e = 0; e < weights.size(); ++e) {
    const Real weight = weights[e] * weights[e];
    if (weight == 0) continue;
    const ScaledSlope<Real> other = slope(e);
    const auto [A, B, C] = other.first;
    // T' q^(3/2) = sum of w^2 P_e' (P_d'' P_e' - P_d' P_e''): exactly 0 for the axis itself.
    const std::array<Real, 3> cross{b * A - a * B, 2 * (c * A - a * C), c * B - b * C};
    // On a line nothing but the rounding of the coefficients is left of it.
    const Real rounding = 32 * std::numeric_limits<Real>::epsilon() * (axis.size * other.size);
    for (std::size_t j = 0; j < 3; ++j) {
      if (std::fabs(cross[j]) > rounding) axis.straight = false;
      for (std::size_t i = 0; i < 3; ++i) axis.second[i + j] += weight * (other.first[i] * cross[j]);
    }
  }
  if (axis.straight) return find_direction(d);
  const Quartic<Real>& q = shown_.interval.speed_squared;
  const std::array<Real, 4> slope = derivative(axis.second);
  const std::array<Real, 4> q_slope = derivative(q.q);
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 5; ++j) {
      axis.third[i + j] += slope[i] * q.q[j] - 2 * (q_slope[i] * axis.second[j]);
    }
  }
  for (Real& term : axis.second) term *= side();
}

/// The same with what vanishes taken out: P' / tau, the numerator of T' tau (denominator g^2, g = q / tau^2)
/// and that of T'' tau^3 (denominator g^(7/2)).
template <Precise Real>
void MotionEnclosure<Real>::turn_where_still(std::size_t d) {
  AxisTurn<Real>& axis = turns_[d];
  const auto [zero, b, c] = axis.first;
  const std::span<const Real> weights = track_.path().weights();
  axis.straight = true;
  std::array<Real, 2> turn{};
  for (std::size_t e = 0; e < weights.size(); ++e) {
    const Real weight = weights[e] * weights[e];
    if (weight == 0) continue;
    const ScaledSlope<Real> other = slope(e);
    const auto [none, B, C] = other.first;
    const Real cross = c * B - b * C;
    const Real rounding = 32 * std::numeric_limits<Real>::epsilon() * (axis.size * other.size);
    if (std::fabs(cross) > rounding) axis.straight = false;
    turn[0] += weight * (B * cross);
    turn[1] += weight * (C * cross);
  }
  if (axis.straight) return find_direction(d);
  const auto& q = shown_.interval.speed_squared.q;
  const std::array<Real, 3> g{q[2], q[3], q[4]};
  const std::array<Real, 2> g_slope = derivative(g);
  axis.second = {side() * turn[0], side() * turn[1], 0, 0, 0};
  for (std::size_t i = 0; i < 3; ++i) {
    axis.third[i + 1] += turn[1] * g[i];
    for (std::size_t j = 0; j < 2; ++j) {
      axis.third[i + j] -= turn[j] * g[i];
      if (i < 2) axis.third[i + j + 1] -= 2 * (turn[j] * g_slope[i]);
    }
  }
}

template <Precise Real>
void MotionEnclosure<Real>::find_direction(std::size_t d) {
  AxisTurn<Real>& axis = turns_[d];
  const auto [a, b, c] = axis.first;
  const Real far = shown_.interval.extent;
  axis.direction = (a + far * (b + far * c)) / std::sqrt(shown_.interval.speed_squared.value(far));
}

/// Once for all axes.
template <Precise Real>
void MotionEnclosure<Real>::divide_by_distance(MotionSurroundings<Real>& box) const {
  if (!track_.has_profile()) return;
  const auto powers = [](Real squared) {
    const Real square = squared * squared;
    const Real root = std::sqrt(squared);
    return Triple{1 / root, 1 / square, 1 / (square * (squared * root))};
  };
  const Interval<Real> range = box.speed_squared.range();
  const Triple here = powers(box.speed_squared.value);
  const Triple most = powers(range.low > 0 ? range.low : Real(0));
  const Triple least = powers(range.high);
  for (std::size_t i = 0; i < motion_quantities; ++i) box.by_distance[i] = {here[i], {least[i], most[i]}};
}

template <Precise Real>
void MotionEnclosure<Real>::find_jerk_change(const Stretch<Real>& stretch,
                                             MotionSurroundings<Real>& box) const {
  if (is_still_ || stretch.is_anchored) return;
  box.jerk_seconds = box.seconds;
  const Interval<Real> speed = not_negative(box.speed.part[0].range());
  const Interval<Real> change = box.speed.part[1].range();
  const Interval<Real> second = box.speed.part[2].range();
  const Interval<Real> square{speed.low * speed.low, speed.high * speed.high};
  const Real third = inverse_scale_ * stretch.time.second_change[1] / stretch.time.seconds;
  box.jerk_change = {Interval<Real>{square.low * square.low, square.high * square.high},
                     (square * change).times(Real(6)),
                     (change * change).times(Real(3)) + (speed * second).times(Real(4)),
                     {third, third}};
  if (!track_.has_profile()) return;
  const Quartic<Real>& q = shown_.interval.speed_squared;
  const Interval<Real> squared = box.speed_squared.range();
  const Interval<Real> slope = centred_slope(q.q, box.tau, box.tau_radius).slope.range();
  const Interval<Real> by{1 / squared.high,
                          squared.low > 0 ? 1 / squared.low : std::numeric_limits<Real>::infinity()};
  box.by_distance_slope = (slope * by).times(Real(3.5));
  const Interval<Real>& by_square = box.by_distance[1].range;
  box.by_fourth = {by_square.low * by_square.low, by_square.high * by_square.high};
  if (side() < 0) box.by_fourth = {-box.by_fourth.high, -box.by_fourth.low};
}

/// The speed in the units of the path's piece, and its derivatives.
template <Precise Real>
MotionFactor<Real> MotionEnclosure<Real>::time_factor(const TimePiece<Real>& time, Real x,
                                                      Real radius) const {
  Factor result{{centred(time.speed, x, radius), centred(time.change, x, radius),
                 centred(time.second_change, x, radius)}};
  for (Centred<Real>& part : result.part) {
    part = {part.value * inverse_scale_, part.spread * inverse_scale_};
  }
  return result;
}

// --- boxes

template <Precise Real>
Centred<Real> MotionEnclosure<Real>::path_speed_squared(Real tau, Real radius) const {
  const std::array<Real, 5>& q = shown_.interval.speed_squared.q;
  return is_still_ ? centred(std::array<Real, 3>{q[2], q[3], q[4]}, tau, radius) : centred(q, tau, radius);
}

template <Precise Real>
MotionSurroundings<Real> MotionEnclosure<Real>::at(const Stretch<Real>& stretch, Real x, Real tau) const {
  MotionSurroundings<Real> result{.tau = tau,
                                  .tau_radius = 0,
                                  .seconds = 0,
                                  .speed_squared = path_speed_squared(tau, Real(0)),
                                  .speed = time_factor(stretch.time, x, 0)};
  // At the standstill itself there is no such number, and nothing is found.
  result.pace = result.speed.part[0].value / tau;
  result.pace_range = {result.pace, result.pace};
  divide_by_distance(result);
  return result;
}

template <Precise Real>
MotionSurroundings<Real> MotionEnclosure<Real>::around(const Stretch<Real>& stretch,
                                                       const MotionBox<Real>& box) const {
  const Real tau_radius = std::max(std::fabs(box.tau_end - box.tau), std::fabs(box.tau - box.tau_begin)) +
                          tau_rounding(stretch, box.tau);
  const Real x_radius = std::max(box.end - box.x, box.x - box.begin);
  MotionSurroundings<Real> result{.tau = box.tau,
                                  .tau_radius = tau_radius,
                                  .seconds = x_radius * std::fabs(stretch.time.seconds),
                                  .speed_squared = path_speed_squared(box.tau, tau_radius),
                                  .speed = time_factor(stretch.time, box.x, x_radius)};
  divide_by_distance(result);
  find_jerk_change(stretch, result);
  if (is_still_) {
    result.pace = result.speed.part[0].value / box.tau;
    result.pace_range = pace_range(stretch, box, result);
  }
  return result;
}

/// The speed over tau, anywhere on a box.
template <Precise Real>
Interval<Real> MotionEnclosure<Real>::pace_range(const Stretch<Real>& stretch, const MotionBox<Real>& box,
                                                 const MotionSurroundings<Real>& surroundings) const {
  const bool from_rest = box.begin <= 0 && box.tau_begin <= 0 && stretch.time.speed[0] == 0;
  if (from_rest) return pace_from_rest(stretch.time, box.end, surroundings.speed_squared.range());
  const Interval<Real> speed = surroundings.speed.part[0].range();
  const Real near = std::min(box.tau_begin, box.tau_end) - tau_rounding(stretch, box.tau_begin);
  const Real far = std::max(box.tau_begin, box.tau_end) + tau_rounding(stretch, box.tau_end);
  return {std::max(speed.low, Real(0)) / far,
          near > 0 ? speed.high / near : std::numeric_limits<Real>::infinity()};
}

/// The same from the moment at which both are 0. With speed = x^k h the distance is between
/// x^(k + 1) h / (k + 1) for the least and the largest h, and tau^2 sqrt(g) / 2 likewise.
template <Precise Real>
Interval<Real> MotionEnclosure<Real>::pace_from_rest(const TimePiece<Real>& time, Real end,
                                                     const Interval<Real>& speed_squared) const {
  std::array<Real, 4> h = time.speed;
  Real k = 0;
  Real power = 1;  // x^(k - 1)
  while (h[0] == 0 && k < 3) {
    h = {h[1], h[2], h[3], 0};
    if (k > 0) power *= end;
    k += 1;
  }
  const Interval<Real> range = centred(h, end / 2, end / 2).range();
  if (!(range.low > 0)) return {0, std::numeric_limits<Real>::infinity()};
  const Real share = (k + 1) * inverse_scale_ / (2 * std::fabs(time.seconds));
  const auto pace = [&](Real most, Real least, Real squared) {
    return std::sqrt(share * power * (most * (most / least)) * std::sqrt(std::max(squared, Real(0))));
  };
  return {k > 1 ? Real(0) : pace(range.low, range.high, speed_squared.low),
          pace(range.high, range.low, speed_squared.high)};
}

template <Precise Real>
MotionTriple<Real> MotionEnclosure<Real>::here(std::size_t d, const MotionSurroundings<Real>& box) const {
  const AxisTurn<Real>& axis = turns_[d];
  Triple t{axis.direction, 0, 0};
  if (!axis.straight) {
    t = {value_at(first_of(d), box.tau), value_at(axis.second, box.tau), value_at(axis.third, box.tau)};
    if (track_.has_profile()) {
      for (std::size_t i = 0; i < t.size(); ++i) t[i] *= box.by_distance[i].value;
    }
  }
  Triple here = middle(t, turns_by_pace(d) ? box.pace : box.speed.part[0].value, box.speed);
  for (Real& value : here) value *= scale_;
  return here;
}

template <Precise Real>
MotionRange<Real> MotionEnclosure<Real>::range(std::size_t d, const MotionSurroundings<Real>& box) const {
  const AxisTurn<Real>& axis = turns_[d];
  MotionFactor<Real> t{{{{axis.direction, 0}, {}, {}}}};
  if (!axis.straight) t = path_factor(first_of(d), axis.second, axis.third, track_.has_profile(), box);
  if (turns_by_pace(d)) {
    return motion_range(t, steepest(d), box.pace, SpeedRanges<Real>(box.speed, box.pace_range), box, scale_);
  }
  return motion_range(t, steepest(d), box.speed.part[0].value, SpeedRanges<Real>(box.speed), box, scale_);
}

template <Precise Real>
void MotionEnclosure<Real>::here_in_lanes(std::size_t group, const MotionSurroundings<Real>& box,
                                          GroupTriple<Real>& out) const {
  if constexpr (lanes_are_quick) here_of(lanes_[group], track_.has_profile(), box, scale_, out);
}

template <Precise Real>
void MotionEnclosure<Real>::range_in_lanes(std::size_t group, const MotionSurroundings<Real>& box,
                                           const SpeedRanges<Real>& ranges,
                                           MotionRange<Group<Real>>& out) const {
  if constexpr (lanes_are_quick) range_of(lanes_[group], track_.has_profile(), box, ranges, scale_, out);
}

/// How far the place at a time may be off in tau: near an anchor as LengthFromAnchor says, elsewhere because
/// a distance is known to some roundings of the length.
template <Precise Real>
Real MotionEnclosure<Real>::tau_rounding(const Stretch<Real>& stretch, Real tau) const {
  constexpr Real length_rounding = std::numeric_limits<Real>::digits > 30 ? Real(2e-7) : Real(1e-5);
  if (!track_.has_profile()) return 0;
  if (stretch.is_anchored) return length_rounding * tau;
  const Real sigma = std::sqrt(std::max(shown_.interval.speed_squared.value(tau), Real(0)));
  const Real distance =
      4 * std::numeric_limits<Real>::epsilon() * track_.arc_length().total() * inverse_scale_;
  // On such a slow path the place follows the square root of the distance.
  return std::min(sigma > 0 ? distance / sigma : shown_.interval.extent, std::sqrt(distance));
}

/// |dP/dL| of an axis that counts is no more than this, even where the path stands still and turns.
template <Precise Real>
Real MotionEnclosure<Real>::steepest(std::size_t d) const {
  const Real weight = track_.path().weights()[d];
  return track_.has_profile() && weight > 0 ? 1 / weight : std::numeric_limits<Real>::infinity();
}

template <Precise Real>
bool MotionEnclosure<Real>::turns_back(const Stretch<Real>& stretch) const {
  const AnchoredInterval<Real>& interval = stretch.path.interval;
  if (!interval.stands_still || interval.anchor <= 0 || interval.anchor >= 1) return false;
  return stretch.tau_begin <= 0 && stretch.time.speed[0] > 0;
}

template class MotionEnclosure<double>;
template class MotionEnclosure<float>;

}  // namespace inbetween
