// The motion whose limits oracle_limits.cpp searches.
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "tests/support/oracle_limits.hpp"
#include "tests/support/oracle_quadrature.hpp"
#include "tests/support/oracle_search.hpp"
#include "tests/support/oracle_table.hpp"

namespace inbetween::oracle {
namespace {

/// Below this share of its largest speed a segment stands still.
constexpr long double standstill = 1e-12L;

/// The state of an axis whose derivatives by arc length are given, where the path is run at speed v,
/// acceleration a and jerk j.
void run_along(const std::array<long double, 3>& by_length, long double v, long double a, long double j,
               AxisState& axis) {
  axis.velocity = by_length[0] * v;
  axis.acceleration = by_length[1] * v * v + by_length[0] * a;
  axis.jerk = by_length[2] * v * v * v + 3 * by_length[1] * v * a + by_length[0] * j;
}

}  // namespace

long double IdealMotion::SpanCubic::inverse(long double wanted, long double low, long double high,
                                            long double guess) const {
  if (wanted <= integral(low)) return low;
  if (wanted >= integral(high)) return high;
  long double u = guess;
  for (int step = 0; step < 200; ++step) {
    if (!(u > low && u < high)) u = low + (high - low) / 2;
    if (u <= low || u >= high) return u;
    const long double beyond = integral(u) - wanted;
    (beyond > 0 ? high : low) = u;
    const long double correction = beyond / value(u);
    if (beyond == 0 || std::fabs(correction) <= std::numeric_limits<long double>::epsilon() * u) return u;
    // Towards a zero of phi Newton's method creeps along one end of the bracket.
    u = step % 4 == 3 ? low + (high - low) / 2 : u - correction;
  }
  return u;
}

IdealMotion::IdealMotion(const Keys& keys, Profile profile, int frames, long double frames_per_second)
    : path_(keys),
      profile_(std::move(profile)),
      weights_(keys.weights.empty() ? std::vector<long double>(keys.at.front().size(), 1.0L) : keys.weights),
      frames_(frames),
      spans_per_second_(static_cast<long double>(profile_.spans()) / static_cast<long double>(frames) *
                        frames_per_second) {
  row_at(path_, profile_, frames, 0);  // refuses what has no answer
  const long double area = profile_.integral(static_cast<long double>(profile_.spans()));
  k_ = path_.total_length() > 0 ? path_.total_length() / area : 0;
  distance_.push_back(0);
  for (const std::vector<Cubic>& axes : segment_cubics(keys)) {
    const int i = static_cast<int>(segments_.size());
    segments_.push_back({axes, 0});
    for (const long double t : evenly(0, 1, 1000))
      segments_.back().largest_speed = std::max(segments_.back().largest_speed, speed(i, t));
    distance_.push_back(distance_.back() + path_.length(i, 0, 1));
  }
  distance_.back() = path_.total_length();
  for (int span = 0; span < profile_.spans(); ++span) {
    const auto a = static_cast<long double>(span);
    const long double bend = profile_.derivative(2, a);
    spans_.push_back(
        {profile_.value(a), profile_.derivative(1, a), bend / 2, (profile_.derivative(2, a + 1) - bend) / 6});
  }
}

long double IdealMotion::frame_of(int span, long double u) const {
  return (static_cast<long double>(span) + u) * static_cast<long double>(frames_) /
         static_cast<long double>(profile_.spans());
}

long double IdealMotion::speed(int i, long double t) const {
  long double sum = 0;
  for (std::size_t axis = 0; axis < weights_.size(); ++axis) {
    const long double component = weights_[axis] * derivative(segment(i).axis[axis], t);
    sum += component * component;
  }
  return std::sqrt(sum);
}

bool IdealMotion::stands_still(int i, long double t) const {
  return speed(i, t) <= standstill * segment(i).largest_speed;
}

long double IdealMotion::half_slope_of_squared_speed(int i, long double t) const {
  long double sum = 0;
  for (std::size_t axis = 0; axis < weights_.size(); ++axis) {
    const Cubic& c = segment(i).axis[axis];
    sum += weights_[axis] * weights_[axis] * derivative(c, t) * second_derivative(c, t);
  }
  return sum;
}

/// One Gauss rule over a short distance on which the speed changes by less than a tenth: its complex zeros
/// are then more than two widths away, and the rule is exact to 1e-15. A longer way may hide a bend between
/// the three places.
long double IdealMotion::length(int i, long double from, long double to) const {
  if (std::fabs(to - from) > 0.02L) return path_.length(i, from, to);
  const std::array speeds = {speed(i, from), speed(i, from + (to - from) / 2), speed(i, to)};
  const auto [least, most] = std::minmax_element(speeds.begin(), speeds.end());
  if (*most > 1.1L * *least) return path_.length(i, from, to);
  return gauss_legendre([&](long double t) { return speed(i, t); }, from, to);
}

bool IdealMotion::evaluate(int i, long double t, int span, long double u,
                           std::vector<AxisState>& axes) const {
  const SpanCubic& phi = span_cubic(span);
  const long double r = spans_per_second_;
  const long double v = k_ * r * phi.value(u);
  const long double a = k_ * r * r * phi.derivative(u);
  const long double j = k_ * r * r * r * phi.second_derivative(u);
  const std::vector<Cubic>& c = segment(i).axis;
  axes.resize(c.size());
  for (std::size_t axis = 0; axis < c.size(); ++axis)
    axes[axis] = {.position = c[axis][0] + t * (c[axis][1] + t * (c[axis][2] + t * c[axis][3]))};
  if (v == 0 && a == 0 && j == 0) return true;
  if (stands_still(i, t)) return false;
  const long double sigma = speed(i, t);

  // With q = sigma^2 and the tangent P'/sigma: (P'/sigma)' = (P'' q - P' q'/2) / sigma^3. The bracket is the
  // sum over the axes k of w_k^2 P'_k (P''_i P'_k - P'_i P''_k), whose terms are written as polynomials: the
  // straight line, where they vanish, and the near-cusp, where they nearly do, keep their digits.
  const long double q = sigma * sigma;
  for (std::size_t axis = 0; axis < c.size(); ++axis) {
    long double bracket = 0;
    long double bracket_slope = 0;
    for (std::size_t k = 0; k < c.size(); ++k) {
      if (k == axis) continue;
      const Cubic& own = c[axis];
      const Cubic& other = c[k];
      const long double m12 = 2 * (own[2] * other[1] - own[1] * other[2]);
      const long double m13 = 6 * (own[3] * other[1] - own[1] * other[3]);
      const long double m23 = 6 * (own[3] * other[2] - own[2] * other[3]);
      const long double turn = m12 + t * (m13 + t * m23);
      const long double turn_slope = m13 + 2 * t * m23;
      const long double w2 = weights_[k] * weights_[k];
      bracket += w2 * derivative(other, t) * turn;
      bracket_slope += w2 * (second_derivative(other, t) * turn + derivative(other, t) * turn_slope);
    }
    run_along({derivative(c[axis], t) / sigma, bracket / (q * q),
               (bracket_slope * q - 4 * bracket * half_slope_of_squared_speed(i, t)) / (q * q * q * sigma)},
              v, a, j, axes[axis]);
  }
  return true;
}

std::vector<AxisState> IdealMotion::required(int i, long double t, int span, long double u) const {
  std::vector<AxisState> axes;
  if (!evaluate(i, t, span, u, axes))
    throw std::domain_error("oracle: the path stands still in segment " + std::to_string(i) +
                            ", t = " + std::to_string(t));
  return axes;
}

/// The first a at which the move has come so far, within the rounding of the distance: a key in a dwell is
/// met where the dwell begins.
long double IdealMotion::alpha_at(long double distance) const {
  if (!(k_ > 0) || distance <= 0) return 0;
  const long double rounding = 1e-17L * path_.total_length() / k_;
  long double to_go = distance / k_;
  for (int span = 0; span < profile_.spans(); ++span) {
    const long double area = span_cubic(span).integral(1);
    if (to_go <= area + rounding) {
      const long double a = static_cast<long double>(span) + span_cubic(span).inverse(to_go, 0, 1, 0.5L);
      // A key on a knot, which rounding has moved.
      return std::fabs(a - std::round(a)) < 1e-15L * static_cast<long double>(span + 1) ? std::round(a) : a;
    }
    to_go -= area;
  }
  return static_cast<long double>(profile_.spans());
}

long double IdealMotion::key_frame(int key) const {
  const long double distance = distance_.at(static_cast<std::size_t>(key));
  return key == path_.segments() ? static_cast<long double>(frames_) : frame_of(0, alpha_at(distance));
}

/// At the beginning of segment `key`, or the end of the one before, or in the next that has a length.
std::vector<AxisState> IdealMotion::beside_key(int key, Side side, int span, long double u) const {
  const bool before = side == Side::before;
  int i = before ? key - 1 : key;
  while (i >= 0 && i < path_.segments() && segment(i).largest_speed == 0) i += before ? -1 : 1;
  if (i >= 0 && i < path_.segments()) {
    long double t = before ? 1 : 0;
    if (stands_still(i, t)) t = before ? 1 - standstill_reach : standstill_reach;
    return required(i, t, span, u);
  }
  std::vector<AxisState> rest;
  for (int axis = 0; axis < path_.axes(); ++axis)
    rest.push_back({.position = key < path_.segments() ? path_.position(key, 0, axis)
                                                       : path_.position(key - 1, 1, axis)});
  return rest;
}

std::vector<AxisState> IdealMotion::at_key(int key, Side side) const {
  const long double alpha = key == path_.segments() ? static_cast<long double>(profile_.spans())
                                                    : alpha_at(distance_.at(static_cast<std::size_t>(key)));
  const int span = std::min(static_cast<int>(alpha), profile_.spans() - 1);
  return beside_key(key, side, span, alpha - static_cast<long double>(span));
}

std::vector<AxisState> IdealMotion::at(long double frame, Side side) const {
  const Row row = row_at(path_, profile_, frames_, frame);
  const bool ends = frame == static_cast<long double>(frames_);
  int span = std::min(static_cast<int>(row.alpha), profile_.spans() - 1);
  if (side == Side::before && span > 0 && !ends && row.alpha == static_cast<long double>(span)) --span;
  const long double u = row.alpha - static_cast<long double>(span);
  for (int key = 0; key <= path_.segments(); ++key) {
    const long double distance = distance_[static_cast<std::size_t>(key)];
    if (std::fabs(row.distance - distance) > 1e-15L * path_.total_length()) continue;
    const bool inner = distance > 0 && distance < path_.total_length();
    const Side inside = distance > 0 ? Side::before : Side::after;
    return beside_key(key, inner ? side : inside, span, u);
  }
  return required(row.place.segment, row.place.t, span, u);
}

}  // namespace inbetween::oracle
