#include "motion_enclosure.hpp"

#include "limits/lock_share.hpp"

namespace inbetween {
namespace {

/// 0 times infinity is anything.
template <Precise Real>
Real or_infinity(Real bound) {
  return bound >= 0 ? bound : std::numeric_limits<Real>::infinity();
}

}  // namespace

// --- the path near a point

template <Precise Real>
void MotionEnclosure<Real>::show(const PathPiece<Real>& piece) {
  if (shown_.segment == piece.segment && shown_.index == piece.index) return;
  shown_ = piece;
  scale_ = std::ldexp(Real(1), piece.exponent);
  inverse_scale_ = std::ldexp(Real(1), -piece.exponent);
  const std::span<const Cubic<Real>> cubics = track_.path().segment(piece.segment);
  if (!track_.has_profile()) {
    show_parameter(cubics);
    return;
  }
  const Real scale = inverse_scale_;
  const Real side = piece.interval.forward ? 1 : -1;
  const Real anchor = piece.interval.anchor;
  for (std::size_t d = 0; d < axes_; ++d) {
    const Cubic<Real>& c = cubics[d];
    turns_[d] = {};
    turns_[d].first = {scale * (c.c1 + anchor * (2 * c.c2 + 3 * c.c3 * anchor)),
                       side * scale * (2 * c.c2 + 6 * c.c3 * anchor), 3 * scale * c.c3};
    turns_[d].size = scale * (std::fabs(c.c1) + 2 * std::fabs(c.c2) + 3 * std::fabs(c.c3));
  }
  for (std::size_t d = 0; d < axes_; ++d) turn(d);
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
}

/// The numerators of the second and third derivative by distance.
template <Precise Real>
void MotionEnclosure<Real>::turn(std::size_t d) {
  AxisTurn<Real>& axis = turns_[d];
  const auto [a, b, c] = axis.first;
  const std::span<const Real> weights = track_.path().weights();
  axis.straight = true;
  for (std::size_t e = 0; e < axes_; ++e) {
    const auto [A, B, C] = turns_[e].first;
    const Real weight = weights[e] * weights[e];
    // T' q^(3/2) = sum of w^2 P_e' (P_d'' P_e' - P_d' P_e''): exactly 0 for the axis itself.
    const std::array<Real, 3> cross{b * A - a * B, 2 * (c * A - a * C), c * B - b * C};
    // On a line nothing but the rounding of the coefficients is left of it.
    const Real rounding = 32 * std::numeric_limits<Real>::epsilon() * (axis.size * turns_[e].size);
    for (std::size_t j = 0; j < 3; ++j) {
      if (weight > 0 && std::fabs(cross[j]) > rounding) axis.straight = false;
      for (std::size_t i = 0; i < 3; ++i) axis.second[i + j] += weight * (turns_[e].first[i] * cross[j]);
    }
  }
  const Quartic<Real>& q = shown_.interval.speed_squared;
  if (axis.straight) {
    const Real far = shown_.interval.extent;
    axis.direction = (a + far * (b + far * c)) / std::sqrt(q.value(far));
    return;
  }
  const std::array<Real, 4> slope = derivative(axis.second);
  const std::array<Real, 4> q_slope = derivative(q.q);
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 5; ++j) {
      axis.third[i + j] += slope[i] * q.q[j] - 2 * (q_slope[i] * axis.second[j]);
    }
  }
}

/// dP/dL and its derivatives by distance about tau (by t, if timed by frames).
template <Precise Real>
MotionFactor<Real> MotionEnclosure<Real>::path_factor(std::size_t d,
                                                      const MotionSurroundings<Real>& box) const {
  const AxisTurn<Real>& axis = turns_[d];
  const Centred<Real>& q = box.speed_squared;
  if (!track_.has_profile()) {
    return {centred(axis.first, box.tau, box.tau_radius), centred(axis.second, box.tau, box.tau_radius),
            centred(axis.third, box.tau, box.tau_radius)};
  }
  if (axis.straight) return {{{{axis.direction, 0}, {}, {}}}};
  const Real side = shown_.interval.forward ? 1 : -1;
  const Interval<Real> range = q.range();
  const Real root = std::sqrt(q.value);
  const Real low = range.low > 0 ? std::sqrt(range.low) : Real(0);
  const Real high = std::sqrt(range.high);
  const Real square = q.value * q.value;
  return {
      quotient(centred(axis.first, box.tau, box.tau_radius), Real(1), root, low, high),
      quotient(centred(axis.second, box.tau, box.tau_radius), side, square,
               range.low > 0 ? range.low * range.low : Real(0), range.high * range.high),
      quotient(centred(axis.third, box.tau, box.tau_radius), Real(1), square * (q.value * root),
               low * low * low * (low * low * low) * low, high * high * high * (high * high * high) * high)};
}

/// scale * a / b, with b from `low` to `high` and `value` in the middle.
template <Precise Real>
Centred<Real> MotionEnclosure<Real>::quotient(const Centred<Real>& a, Real scale, Real value, Real low,
                                              Real high) {
  const Real middle = scale * a.value / value;
  if (!(low > 0)) return {middle, std::numeric_limits<Real>::infinity()};
  const Interval<Real> range = (scale * a.range()) * Interval<Real>{1 / high, 1 / low};
  return {middle, std::max(range.high - middle, middle - range.low)};
}

/// The speed in the units of the path's piece, and its derivatives.
template <Precise Real>
MotionFactor<Real> MotionEnclosure<Real>::time_factor(const TimePiece<Real>& time, Real x,
                                                      Real radius) const {
  Factor result{centred(time.speed, x, radius), centred(time.change, x, radius),
                centred(time.bend, x, radius)};
  for (Centred<Real>& part : result.part) {
    part = {part.value * inverse_scale_, part.spread * inverse_scale_};
  }
  return result;
}

// --- boxes

template <Precise Real>
MotionSurroundings<Real> MotionEnclosure<Real>::at(const TimePiece<Real>& time, Real x, Real tau) const {
  return {.tau = tau,
          .tau_radius = 0,
          .seconds = 0,
          .speed_squared = centred(shown_.interval.speed_squared.q, tau, Real(0)),
          .speed = time_factor(time, x, 0)};
}

template <Precise Real>
MotionSurroundings<Real> MotionEnclosure<Real>::around(const TimePiece<Real>& time,
                                                       const MotionBox<Real>& box) const {
  const Real tau_radius =
      std::max(std::fabs(box.tau_end - box.tau), std::fabs(box.tau - box.tau_begin)) + tau_rounding(box.tau);
  const Real x_radius = std::max(box.end - box.x, box.x - box.begin);
  return {.tau = box.tau,
          .tau_radius = tau_radius,
          .seconds = x_radius * time.seconds,
          .speed_squared = centred(shown_.interval.speed_squared.q, box.tau, tau_radius),
          .speed = time_factor(time, box.x, x_radius)};
}

template <Precise Real>
MotionTriple<Real> MotionEnclosure<Real>::here(std::size_t d, const MotionSurroundings<Real>& box) const {
  return scaled_up(product(middle(path_factor(d, box)), middle(box.speed)));
}

template <Precise Real>
MotionRange<Real> MotionEnclosure<Real>::range(std::size_t d, const MotionSurroundings<Real>& box) const {
  const Factor t = path_factor(d, box);
  const Triple here = product(middle(t), middle(box.speed));
  return {scaled_up(here), scaled_up(bounds_of(t, steepest(d), box, here))};
}

/// How far the place at a time may be off in tau, because a distance is known to some roundings of the
/// length.
template <Precise Real>
Real MotionEnclosure<Real>::tau_rounding(Real tau) const {
  if (!track_.has_profile()) return 0;
  const Real sigma = std::sqrt(std::max(shown_.interval.speed_squared.value(tau), Real(0)));
  const Real distance =
      4 * std::numeric_limits<Real>::epsilon() * track_.arc_length().total() * inverse_scale_;
  // Where the path is that slow the place follows the square root of the distance.
  return std::min(sigma > 0 ? distance / sigma : shown_.interval.extent, std::sqrt(distance));
}

/// |dP/dL| of an axis that counts is no more than this, even where the path stands still and turns.
template <Precise Real>
Real MotionEnclosure<Real>::steepest(std::size_t d) const {
  const Real weight = track_.path().weights()[d];
  return track_.has_profile() && weight > 0 ? 1 / weight : std::numeric_limits<Real>::infinity();
}

template <Precise Real>
MotionTriple<Real> MotionEnclosure<Real>::bounds_of(const Factor& t, Real steepest,
                                                    const MotionSurroundings<Real>& box,
                                                    const Triple& here) const {
  const Factor& w = box.speed;
  Interval<Real> speed = w.part[0].range();
  if (speed.low == 0 && speed.high == 0) return {};  // a rest, wherever it is
  speed.low = std::max(speed.low, Real(0));
  const Interval<Real> square{speed.low * speed.low, speed.high * speed.high};
  const Interval<Real> cube{square.low * speed.low, square.high * speed.high};
  const Interval<Real> change = w.part[1].range();
  Interval<Real> first = t.part[0].range();
  if (!(first.low >= -steepest)) first.low = -steepest;
  if (!(first.high <= steepest)) first.high = steepest;
  const Interval<Real> second = t.part[1].range();
  Triple bound;
  bound[2] = or_infinity(
      (t.part[2].range() * cube + Real(3) * (second * (speed * change)) + first * w.part[2].range())
          .magnitude());
  // By the mean value theorem from the middle, or directly.
  bound[1] = std::min(or_infinity((second * square + first * change).magnitude()),
                      or_infinity(std::fabs(here[1]) + box.seconds * bound[2]));
  bound[0] = std::min(or_infinity((first * speed).magnitude()),
                      or_infinity(std::fabs(here[0]) + box.seconds * bound[1]));
  return bound;
}

template <Precise Real>
bool MotionEnclosure<Real>::turns_back(const Stretch<Real>& stretch, bool at_end) const {
  const AnchoredInterval<Real>& interval = stretch.path.interval;
  if (!interval.stands_still || interval.anchor <= 0 || interval.anchor >= 1) return false;
  if ((at_end ? stretch.tau_end : stretch.tau_begin) > 0) return false;
  const Real x = at_end ? stretch.end : stretch.begin;
  if (!(centred(stretch.time.speed, x, Real(0)).value > 0)) return false;
  // The speed of a touch rises with the third power of time: beside it the place may be off by what a lock
  // promises while the speed is far above rounding.
  const auto touches = [&](Real knot) {
    const auto way = [&](Real at) {
      const std::array<Real, 4>& c = stretch.time.speed;
      return at * (c[0] + at * (c[1] / 2 + at * (c[2] / 3 + at * c[3] / 4)));
    };
    Real size = 0;
    for (const Real c : stretch.time.speed) size += std::fabs(c);
    const bool is_still =
        centred(stretch.time.speed, knot, Real(0)).value <= 8 * std::numeric_limits<Real>::epsilon() * size;
    const Real beside = std::fabs(way(x) - way(knot)) * stretch.time.seconds;
    return is_still && beside <= lock_share<Real> * track_.arc_length().total();
  };
  return !touches(Real(0)) && !touches(Real(1));
}

template class MotionEnclosure<double>;
template class MotionEnclosure<float>;

}  // namespace inbetween
