#include "tests/support/oracle_path.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <string>

#include "tests/support/oracle_quadrature.hpp"

namespace inbetween::oracle {
namespace {

using WeightedSlope = std::vector<std::array<long double, 3>>;

/// A sum of squares, never the expanded quartic: that one loses half its digits beside a cusp.
long double speed_of(const WeightedSlope& slope, long double t) {
  long double sum = 0;
  for (const auto& c : slope) {
    const long double component = c[0] + t * (c[1] + t * c[2]);
    sum += component * component;
  }
  return std::sqrt(sum);
}

/// Coefficients of the derivative of the squared speed, a cubic in t.
std::vector<long double> slope_of_squared_speed(const WeightedSlope& slope) {
  std::vector<long double> squared(5, 0.0L);
  for (const auto& c : slope)
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < 3; ++k) squared[i + k] += c[i] * c[k];
  std::vector<long double> result;
  for (std::size_t i = 1; i < squared.size(); ++i) result.push_back(static_cast<long double>(i) * squared[i]);
  return result;
}

long double value_of(const std::vector<long double>& polynomial, long double t) {
  long double sum = 0;
  for (std::size_t i = polynomial.size(); i-- > 0;) sum = sum * t + polynomial[i];
  return sum;
}

/// Sign changes of a polynomial in (0, 1): those of its derivative cut the interval into monotone stretches,
/// and each stretch is bisected down to neighbouring numbers.
std::vector<long double> roots_in_unit_interval(const std::vector<long double>& polynomial) {
  if (polynomial.size() < 2) return {};
  std::vector<long double> derived;
  for (std::size_t i = 1; i < polynomial.size(); ++i)
    derived.push_back(static_cast<long double>(i) * polynomial[i]);
  std::vector<long double> stops = roots_in_unit_interval(derived);
  stops.push_back(1);
  std::vector<long double> roots;
  long double from = 0;
  for (const long double stop : stops) {
    long double low = from;
    long double high = stop;
    from = stop;
    const bool rises = value_of(polynomial, low) < 0;
    if (rises == (value_of(polynomial, high) < 0)) continue;
    for (;;) {
      const long double middle = low + (high - low) / 2;
      if (middle <= low || middle >= high) break;
      ((value_of(polynomial, middle) < 0) == rises ? low : high) = middle;
    }
    if (high > 0 && high < 1) roots.push_back(high);
  }
  return roots;
}

long double largest_speed(const WeightedSlope& slope) {
  long double largest = std::max(speed_of(slope, 0), speed_of(slope, 1));
  for (const long double t : roots_in_unit_interval(slope_of_squared_speed(slope)))
    largest = std::max(largest, speed_of(slope, t));
  return largest;
}

/// 0, 1, and between them the places where the speed has a minimum below a fifth of its maximum. At a cusp
/// the speed has a kink there, near one it almost has, and beside the bound it is smooth again.
std::vector<long double> bounds_of(const WeightedSlope& slope, long double largest) {
  const long double slow = largest / 5;
  std::vector<long double> bounds = {0};
  for (const long double t : roots_in_unit_interval(slope_of_squared_speed(slope)))
    if (speed_of(slope, t) < slow && t > bounds.back()) bounds.push_back(t);
  bounds.push_back(1);
  return bounds;
}

}  // namespace

Path::Path(const Keys& keys)
    : weights_(keys.weights.empty() && !keys.at.empty()
                   ? std::vector<long double>(keys.at.front().size(), 1.0L)
                   : keys.weights) {
  for (const std::vector<Cubic>& axes : segment_cubics(keys)) {
    Segment& segment = segments_.emplace_back();
    segment.axis = axes;
    for (std::size_t axis = 0; axis < axes.size(); ++axis) {
      const long double w = weights_[axis];
      const Cubic& c = axes[axis];
      segment.weighted_slope.push_back({w * c[1], 2 * w * c[2], 3 * w * c[3]});
    }
    segment.largest_speed = largest_speed(segment.weighted_slope);
    segment.bounds = bounds_of(segment.weighted_slope, segment.largest_speed);
    segment.length_to_bound = {0};
    for (std::size_t i = 0; i + 1 < segment.bounds.size(); ++i)
      segment.length_to_bound.push_back(segment.length_to_bound.back() +
                                        length(segment, segment.bounds[i], segment.bounds[i + 1]));
    segment_length_.push_back(segment.length_to_bound.back());
    total_length_ += segment_length_.back();
  }
}

const Path::Segment& Path::at(int segment, long double t) const {
  if (segment < 0 || segment >= segments())
    throw std::out_of_range("oracle: the path has no segment " + std::to_string(segment));
  if (!(t >= 0 && t <= 1)) throw std::out_of_range("oracle: t = " + std::to_string(t) + " is outside [0, 1]");
  return segments_[static_cast<std::size_t>(segment)];
}

const Cubic& Path::cubic(int segment, long double t, int axis) const {
  if (axis < 0 || axis >= axes())
    throw std::out_of_range("oracle: the path has no axis " + std::to_string(axis));
  return at(segment, t).axis[static_cast<std::size_t>(axis)];
}

long double Path::position(int segment, long double t, int axis) const {
  return cubic(segment, t, axis)[0] + offset(segment, t, axis);
}

long double Path::offset(int segment, long double t, int axis) const {
  const Cubic& c = cubic(segment, t, axis);
  return t * (c[1] + t * (c[2] + t * c[3]));
}

long double Path::derivative(int order, int segment, long double t, int axis) const {
  const Cubic& c = cubic(segment, t, axis);
  switch (order) {
    case 1:
      return c[1] + t * (2 * c[2] + t * 3 * c[3]);
    case 2:
      return 2 * c[2] + 6 * t * c[3];
    case 3:
      return 6 * c[3];
    default:
      throw std::out_of_range("oracle: no derivative of order " + std::to_string(order));
  }
}

long double Path::speed(int segment, long double t) const {
  return speed_of(at(segment, t).weighted_slope, t);
}

long double Path::length(int segment, long double t0, long double t1) const {
  at(segment, t1);
  return length(at(segment, t0), t0, t1);
}

long double Path::length(const Segment& segment, long double t0, long double t1) const {
  if (t1 < t0) return -length(segment, t1, t0);
  const auto speed_at = [&segment](long double t) { return speed_of(segment.weighted_slope, t); };
  // A sum of a dozen rounded speeds is not reproduced any closer than this.
  const long double error_density = 4e-19L * segment.largest_speed;
  long double sum = 0;
  long double from = t0;
  for (const long double bound : segment.bounds) {
    if (bound <= from || bound >= t1) continue;
    sum += integral(speed_at, from, bound, error_density);
    from = bound;
  }
  return sum + integral(speed_at, from, t1, error_density);
}

long double Path::travelled(Place from, Place to) const {
  if (to.segment < from.segment) return -travelled(to, from);
  if (to.segment == from.segment) return length(from.segment, from.t, to.t);
  long double sum = length(from.segment, from.t, 1) + length(to.segment, 0, to.t);
  for (int i = from.segment + 1; i < to.segment; ++i) sum += segment_length_[static_cast<std::size_t>(i)];
  return sum;
}

Place Path::place(long double distance) const {
  if (!(distance >= 0 && distance <= total_length_))
    throw std::out_of_range("oracle: distance " + std::to_string(distance) + " is not on the path");
  if (distance == 0) return {0, 0};
  if (distance == total_length_) return {segments() - 1, 1};
  std::size_t segment = 0;
  while (distance > segment_length_[segment] && segment + 1 < segments_.size())
    distance -= segment_length_[segment++];
  return {static_cast<int>(segment), t_within(segments_[segment], distance)};
}

long double Path::t_within(const Segment& segment, long double distance) const {
  if (distance >= segment.length_to_bound.back()) return 1;
  std::size_t piece = 0;
  while (distance > segment.length_to_bound[piece + 1]) ++piece;
  long double low = segment.bounds[piece];
  long double high = segment.bounds[piece + 1];
  // The length still to go from low; integrating from the moving end keeps each integral short.
  long double to_go = distance - segment.length_to_bound[piece];
  const long double piece_length = segment.length_to_bound[piece + 1] - segment.length_to_bound[piece];
  long double t = low + (high - low) * to_go / piece_length;
  for (int step = 0; step < 200; ++step) {
    if (!(t > low && t < high)) t = low + (high - low) / 2;
    if (t <= low || t >= high) return t;
    const long double beyond = length(segment, low, t) - to_go;
    const long double speed_here = speed_of(segment.weighted_slope, t);
    if (beyond > 0) {
      high = t;
    } else {
      low = t;
      to_go = -beyond;
    }
    const long double correction = beyond / speed_here;
    if (std::fabs(correction) <= std::numeric_limits<long double>::epsilon() * t) return t;
    // Beside a cusp Newton's method may creep along one end of the bracket: every fourth step halves it.
    t = step % 4 == 3 ? low + (high - low) / 2 : t - correction;
  }
  return t;
}

long double Path::slowest() const {
  long double least = 1;
  for (const Segment& segment : segments_) {
    const long double largest = segment.largest_speed;
    if (largest == 0) continue;
    std::vector<long double> candidates =
        roots_in_unit_interval(slope_of_squared_speed(segment.weighted_slope));
    candidates.insert(candidates.end(), {0.0L, 1.0L});
    for (const long double t : candidates)
      least = std::min(least, speed_of(segment.weighted_slope, t) / largest);
  }
  return least;
}

int Path::piece(int segment, long double t) const {
  const std::vector<long double>& bounds = at(segment, t).bounds;
  return static_cast<int>(std::upper_bound(bounds.begin() + 1, bounds.end() - 1, t) - bounds.begin()) - 1;
}

}  // namespace inbetween::oracle
