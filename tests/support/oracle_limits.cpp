#include "tests/support/oracle_limits.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "tests/support/oracle_quadrature.hpp"
#include "tests/support/oracle_table.hpp"

namespace inbetween::oracle {
namespace {

constexpr long double infinity = std::numeric_limits<long double>::infinity();
/// Below this share of its largest speed a segment stands still.
constexpr long double standstill = 1e-12L;
/// How near to a standstill in t nothing is sampled.
constexpr long double standstill_reach = 1e-9L;

// --- search of many functions of one variable at once
// ------------------------------------------------------------

/// One evaluation of all functions: the variable, the values, and the place that is reported.
struct Sample {
  long double x = 0;
  std::vector<long double> values;
  long double place = 0;
};

/// Where a function may have a maximum larger than any sample.
struct Bracket {
  std::size_t function = 0;
  long double from = 0, to = 0;
  long double potential = 0;
};

/// `evaluate` fills in the values and the place of a Sample whose x is set, or returns false where it cannot.
template <typename Evaluate>
class Search {
 public:
  Search(const Evaluate& evaluate, std::vector<Extreme>& best) : evaluate_(evaluate), best_(best) {
    for (Sample* sample : {&before_, &middle_, &after_}) sample->values.resize(best.size());
  }

  /// The given places, which ascend, and with Between::climbed all maxima between them.
  void run(const std::vector<long double>& places, Between between) {
    for (const long double x : places) feed(x);
    finish_row();
    if (between == Between::skipped) return;
    std::sort(brackets_.begin(), brackets_.end(),
              [](const Bracket& a, const Bracket& b) { return a.potential > b.potential; });
    for (const Bracket& bracket : brackets_)
      if (bracket.potential > best_[bracket.function].value) refine(bracket);
  }

 private:
  bool sample(long double x, Sample& at) {
    at.x = x;
    if (!evaluate_(at)) return false;
    for (std::size_t i = 0; i < best_.size(); ++i)
      if (at.values[i] > best_[i].value) best_[i] = {at.values[i], at.place};
    return true;
  }

  void feed(long double x) {
    if (!sample(x, after_)) {
      finish_row();
      return;
    }
    for (std::size_t i = 0; i < best_.size(); ++i) {
      const long double top = middle_.values[i];
      if (row_ == 1 && top >= after_.values[i]) remember(i, middle_, top, after_);
      if (row_ >= 2 && top >= before_.values[i] && top >= after_.values[i]) remember(i, before_, top, after_);
    }
    std::swap(before_, middle_);
    std::swap(middle_, after_);
    ++row_;
  }

  void finish_row() {
    if (row_ >= 2)
      for (std::size_t i = 0; i < best_.size(); ++i)
        if (middle_.values[i] >= before_.values[i]) remember(i, before_, middle_.values[i], middle_);
    row_ = 0;
  }

  /// A parabola through a maximum and its neighbours rises above it by at most an eighth of `rise`; four
  /// times as much as all of it is for what is no parabola.
  void remember(std::size_t i, const Sample& left, long double top, const Sample& right) {
    const long double rise = top - std::min(left.values[i], right.values[i]);
    const long double potential = top + 4 * rise;
    if (rise > 1e-12L * std::fabs(top) && potential > best_[i].value)
      brackets_.push_back({i, left.x, right.x, potential});
  }

  /// A bracket may hold several crests: it is divided once more before each of them is climbed.
  void refine(const Bracket& bracket) {
    constexpr int parts = 24;
    std::array<long double, parts + 1> value{};
    const auto x = [&](int k) {
      return bracket.from + (bracket.to - bracket.from) * static_cast<long double>(k) / parts;
    };
    for (int k = 0; k <= parts; ++k)
      value[static_cast<std::size_t>(k)] = sample(x(k), after_) ? after_.values[bracket.function] : -infinity;
    for (int k = 0; k <= parts; ++k) {
      const int left = std::max(k - 1, 0);
      const int right = std::min(k + 1, parts);
      const long double top = value[static_cast<std::size_t>(k)];
      const long double beside =
          std::min(value[static_cast<std::size_t>(left)], value[static_cast<std::size_t>(right)]);
      const bool crest = top >= value[static_cast<std::size_t>(left)] &&
                         top >= value[static_cast<std::size_t>(right)] && top > beside;
      if (crest && top + 4 * (top - beside) > best_[bracket.function].value)
        climb(bracket.function, x(left), x(right));
    }
  }

  /// Golden section search; thirty steps shrink the bracket to 5e-7 of itself, which for the value of a
  /// parabola is 3e-13 of its rise.
  void climb(std::size_t function, long double low, long double high) {
    const long double ratio = (std::sqrt(5.0L) - 1) / 2;
    const auto value_at = [&](long double x) {
      return sample(x, after_) ? after_.values[function] : -infinity;
    };
    long double left = high - ratio * (high - low);
    long double right = low + ratio * (high - low);
    long double value_left = value_at(left);
    long double value_right = value_at(right);
    for (int step = 0; step < 30; ++step) {
      if (value_left > value_right) {
        high = std::exchange(right, left);
        value_right = value_left;
        left = high - ratio * (high - low);
        value_left = value_at(left);
      } else {
        low = std::exchange(left, right);
        value_left = value_right;
        right = low + ratio * (high - low);
        value_right = value_at(right);
      }
    }
  }

  const Evaluate& evaluate_;
  std::vector<Extreme>& best_;
  Sample before_, middle_, after_;
  int row_ = 0;  ///< samples since the last that could not be evaluated
  std::vector<Bracket> brackets_;
};

std::vector<long double> evenly(long double from, long double to, int parts) {
  std::vector<long double> places;
  places.reserve(static_cast<std::size_t>(parts) + 1);
  for (int i = 0; i < parts; ++i)
    places.push_back(from + (to - from) * static_cast<long double>(i) / static_cast<long double>(parts));
  places.push_back(to);
  return places;
}

int parts_of(long double share, int samples) {
  return std::max(16, static_cast<int>(std::ceil(share * static_cast<long double>(samples))));
}

// --- what is searched of an axis
// ---------------------------------------------------------------------------------

constexpr std::size_t functions_per_axis = 5;
enum Searched : std::size_t { highest, lowest, velocity, acceleration, jerk };

void write_functions(const std::vector<AxisState>& axes, std::vector<long double>& values) {
  for (std::size_t axis = 0; axis < axes.size(); ++axis) {
    long double* of_axis = &values[functions_per_axis * axis];
    of_axis[highest] = axes[axis].position;
    of_axis[lowest] = -axes[axis].position;
    of_axis[velocity] = std::fabs(axes[axis].velocity);
    of_axis[acceleration] = std::fabs(axes[axis].acceleration);
    of_axis[jerk] = std::fabs(axes[axis].jerk);
  }
}

long double slope_of(const Cubic& c, long double t) {
  return c[1] + t * (2 * c[2] + t * 3 * c[3]);
}
long double bend_of(const Cubic& c, long double t) {
  return 2 * c[2] + 6 * t * c[3];
}

/// The state of an axis whose derivatives by arc length are given, where the path is run at speed v,
/// acceleration a and jerk j.
void run_along(const std::array<long double, 3>& by_length, long double v, long double a, long double j,
               AxisState& axis) {
  axis.velocity = by_length[0] * v;
  axis.acceleration = by_length[1] * v * v + by_length[0] * a;
  axis.jerk = by_length[2] * v * v * v + 3 * by_length[1] * v * a + by_length[0] * j;
}

}  // namespace

Extreme peak_of(const std::function<long double(long double)>& function, long double from, long double to,
                int samples) {
  if (samples < 1 || !(from <= to)) throw std::invalid_argument("oracle: nothing to search");
  std::vector<Extreme> best = {{-infinity, from}};
  const auto evaluate = [&](Sample& sample) {
    sample.values[0] = function(sample.x);
    sample.place = sample.x;
    if (std::isnan(sample.values[0]))
      throw std::domain_error("oracle: not a number at " + std::to_string(sample.x));
    return true;
  };
  Search(evaluate, best).run(evenly(from, to, samples), Between::climbed);
  return best[0];
}

// --- the motion
// --------------------------------------------------------------------------------------------------

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
    const long double component = weights_[axis] * slope_of(segment(i).axis[axis], t);
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
    sum += weights_[axis] * weights_[axis] * slope_of(c, t) * bend_of(c, t);
  }
  return sum;
}

/// One Gauss rule over a short way on which the speed changes by less than a tenth: its complex zeros are
/// then more than two widths away, and the rule is exact to 1e-15. A longer way may hide a bend between the
/// three places.
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
  const long double a = k_ * r * r * phi.slope(u);
  const long double j = k_ * r * r * r * phi.bend(u);
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
      bracket += w2 * slope_of(other, t) * turn;
      bracket_slope += w2 * (bend_of(other, t) * turn + slope_of(other, t) * turn_slope);
    }
    run_along({slope_of(c[axis], t) / sigma, bracket / (q * q),
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

// --- the search
// --------------------------------------------------------------------------------------------------

/// Goes along one stretch by t or by a. It integrates from where it stands, so that neighbouring places are
/// cheap.
class IdealMotion::Cursor {
 public:
  Cursor(const IdealMotion& motion, const Stretch& stretch)
      : motion_(motion),
        stretch_(stretch),
        phi_(motion.span_cubic(stretch.span)),
        area_to_begin_(phi_.integral(stretch.from_u)),
        t(stretch.from_t),
        u(stretch.from_u) {}

  void go_to_t(long double to) {
    move(to);
    const long double area = area_to_begin_ + (motion_.k_ > 0 ? distance_ / motion_.k_ : 0);
    u = phi_.inverse(area, stretch_.from_u, stretch_.to_u, u);
  }

  /// Newton's method inside a shrinking bracket.
  void go_to_u(long double to) {
    u = to;
    const long double wanted = motion_.k_ * (phi_.integral(to) - area_to_begin_);
    long double low = stretch_.from_t;
    long double high = stretch_.to_t;
    for (int step = 0; step < 200; ++step) {
      const long double beyond = distance_ - wanted;
      if (std::fabs(beyond) <= 1e-19L * motion_.path_.total_length()) return;
      (beyond > 0 ? high : low) = t;
      const long double newton = t - beyond / motion_.speed(stretch_.segment, t);
      // Beside a cusp it creeps along one end of the bracket.
      const long double next = step % 4 == 3 ? low + (high - low) / 2 : std::clamp(newton, low, high);
      if (next == t) return;
      move(next);
    }
  }

 private:
  void move(long double to) {
    distance_ += motion_.length(stretch_.segment, t, to);
    t = to;
  }

  const IdealMotion& motion_;
  const Stretch& stretch_;
  const SpanCubic& phi_;
  long double area_to_begin_;
  long double distance_ = 0;  ///< from the begin of the stretch to t

 public:
  long double t;
  long double u;
};

std::vector<IdealMotion::Stretch> IdealMotion::stretches() const {
  struct Bound {
    long double alpha;
    int key;  ///< -1: a knot of phi
  };
  std::vector<Bound> bounds;
  for (int knot = 0; knot <= profile_.spans(); ++knot) bounds.push_back({static_cast<long double>(knot), -1});
  for (int key = 1; key < path_.segments(); ++key)
    bounds.push_back({alpha_at(distance_[static_cast<std::size_t>(key)]), key});
  std::sort(bounds.begin(), bounds.end(), [](const Bound& a, const Bound& b) {
    return std::pair(a.alpha, a.key) < std::pair(b.alpha, b.key);
  });

  std::vector<Stretch> result;
  long double alpha = 0;
  Place place = {0, 0};
  for (const Bound& bound : bounds) {
    // Where rounding has it that a knot lies beyond the next key, or before the last, it is on it.
    Place to = {place.segment, 1};
    if (bound.key < 0) {
      const auto whole = static_cast<int>(bound.alpha);
      const long double distance = k_ * profile_.integral(static_cast<long double>(whole));
      const Place there = path_.place(std::min(distance, path_.total_length()));
      if (there.segment < place.segment) to.t = place.t;
      if (there.segment == place.segment) to.t = std::max(place.t, there.t);
    }
    const auto span = static_cast<int>(alpha);
    const auto knot = static_cast<long double>(span);
    if (bound.alpha > alpha)
      result.push_back({place.segment, span, alpha - knot, bound.alpha - knot, place.t, to.t});
    alpha = bound.alpha;
    place = bound.key < 0 ? to : Place{bound.key, 0};
  }
  return result;
}

/// Minima of the speed in t, ends included.
std::vector<long double> IdealMotion::slowest_places(const Stretch& stretch) const {
  const auto slope = [&](long double t) { return half_slope_of_squared_speed(stretch.segment, t); };
  std::vector<long double> places;
  if (slope(stretch.from_t) >= 0) places.push_back(stretch.from_t);
  if (slope(stretch.to_t) <= 0) places.push_back(stretch.to_t);
  const std::vector<long double> grid = evenly(stretch.from_t, stretch.to_t, 500);
  bool falls = false;
  for (std::size_t k = 0; k < grid.size(); ++k) {
    const bool fell = std::exchange(falls, slope(grid[k]) < 0);
    if (!fell || falls) continue;
    long double low = grid[k - 1];
    long double high = grid[k];
    for (;;) {
      const long double middle = low + (high - low) / 2;
      if (middle <= low || middle >= high) break;
      (slope(middle) < 0 ? low : high) = middle;
    }
    places.push_back(high);
  }
  return places;
}

/// Sweeps by t: one evenly spaced, and around every minimum of the speed one spaced as the hyperbolic sine,
/// where a step is a part of the width in which the path turns. They are not mixed: two places by chance side
/// by side would hide how much higher than both a crest beside them is.
std::vector<std::vector<long double>> IdealMotion::sweeps_by_t(const Stretch& stretch,
                                                               const std::vector<long double>& slowest,
                                                               int samples) const {
  std::vector<std::vector<long double>> sweeps = {
      evenly(stretch.from_t, stretch.to_t, parts_of(stretch.to_t - stretch.from_t, samples))};
  for (const long double middle : slowest) {
    long double bend = 0;
    for (std::size_t axis = 0; axis < weights_.size(); ++axis)
      bend = std::hypot(bend, weights_[axis] * bend_of(segment(stretch.segment).axis[axis], middle));
    const long double width =
        bend > 0 ? std::max(speed(stretch.segment, middle) / bend, standstill_reach) : 1;
    if (width > 0.3L) continue;
    const long double reach = std::asinh(1 / width);
    const auto parts = static_cast<int>(std::ceil(reach * (12 + static_cast<long double>(samples) / 64)));
    std::vector<long double>& sweep = sweeps.emplace_back();
    if (stands_still(stretch.segment, middle)) sweep = {middle - standstill_reach, middle + standstill_reach};
    for (const long double x : evenly(-reach, reach, 2 * parts))
      sweep.push_back(middle + width * std::sinh(x));
    std::erase_if(sweep, [&](long double t) { return t < stretch.from_t || t > stretch.to_t; });
    std::sort(sweep.begin(), sweep.end());
  }
  return sweeps;
}

void IdealMotion::search(const Stretch& stretch, int samples, Between between,
                         std::vector<Extreme>& best) const {
  const std::vector<long double> slowest = slowest_places(stretch);
  std::vector<long double> still;
  for (const long double t : slowest)
    if (stands_still(stretch.segment, t)) still.push_back(t);

  Cursor cursor(*this, stretch);
  std::vector<AxisState> axes;
  const auto evaluate_here = [&](Sample& sample) {
    const bool dwells = stretch.from_t == stretch.to_t;
    for (const long double t : still)
      if (!dwells && std::fabs(cursor.t - t) < standstill_reach * 0.999L) return false;
    if (!evaluate(stretch.segment, cursor.t, stretch.span, cursor.u, axes)) return false;
    write_functions(axes, sample.values);
    sample.place = frame_of(stretch.span, cursor.u);
    return true;
  };
  const auto by_t = [&](Sample& sample) {
    cursor.go_to_t(sample.x);
    return evaluate_here(sample);
  };
  const auto by_u = [&](Sample& sample) {
    cursor.go_to_u(sample.x);
    return evaluate_here(sample);
  };
  if (stretch.to_t > stretch.from_t)
    for (const std::vector<long double>& sweep : sweeps_by_t(stretch, slowest, samples))
      Search(by_t, best).run(sweep, between);
  Search(by_u, best)
      .run(evenly(stretch.from_u, stretch.to_u, parts_of(stretch.to_u - stretch.from_u, samples)), between);
  for (const long double t : still) search_standstill(stretch, t, best);
}

/// What cannot be sampled where the path stands still.
void IdealMotion::search_standstill(const Stretch& stretch, long double place,
                                    std::vector<Extreme>& best) const {
  const std::vector<Cubic>& cubics = segment(stretch.segment).axis;
  const auto diverge = [&](std::size_t function, long double u) {
    if (best[function].value < infinity) best[function] = {infinity, frame_of(stretch.span, u)};
  };
  Cursor cursor(*this, stretch);
  cursor.go_to_t(place);
  const long double u = cursor.u;
  const SpanCubic& phi = span_cubic(stretch.span);
  const long double typical = profile_.integral(static_cast<long double>(profile_.spans())) /
                              static_cast<long double>(profile_.spans());
  if (place > 0 && place < 1 && phi.value(u) > 1e-6L * typical) {
    for (std::size_t axis = 0; axis < cubics.size(); ++axis) {
      if (cubics[axis][1] == 0 && cubics[axis][2] == 0 && cubics[axis][3] == 0) continue;
      diverge(functions_per_axis * axis + acceleration, u);
      diverge(functions_per_axis * axis + jerk, u);
    }
    return;
  }
  for (const long double room : {stretch.from_t - place, stretch.to_t - place}) {
    if (std::fabs(room) < 1e-2L) continue;
    std::vector<std::vector<long double>> approach;
    for (long double share = 1e-3L; share > 0.5e-7L; share /= 10) {
      cursor.go_to_t(place + room * share);
      std::vector<AxisState> axes;
      if (!evaluate(stretch.segment, cursor.t, stretch.span, cursor.u, axes)) return;
      write_functions(axes, approach.emplace_back(best.size()));
    }
    for (std::size_t function = 0; function < best.size(); ++function) {
      if (function % functions_per_axis < acceleration) continue;
      bool grows = approach.front()[function] > 0;
      for (std::size_t k = 1; k < approach.size(); ++k)
        grows = grows && approach[k][function] > 1.5L * approach[k - 1][function];
      if (grows) diverge(function, u);
    }
  }
}

Extremes IdealMotion::extremes(int samples) const {
  if (samples < 1) throw std::invalid_argument("oracle: nothing to search");
  const auto axes = static_cast<std::size_t>(path_.axes());
  std::vector<Extreme> best(functions_per_axis * axes, {-infinity, 0});
  const std::vector<AxisState> start = at_key(0, Side::before);
  Sample at_start{.x = 0, .values = std::vector<long double>(best.size()), .place = 0};
  write_functions(start, at_start.values);
  for (std::size_t i = 0; i < best.size(); ++i) best[i].value = at_start.values[i];
  // Once without climbing, so that only what can be higher than all of it is climbed.
  if (k_ > 0)
    for (const Between between : {Between::skipped, Between::climbed})
      for (const Stretch& stretch : stretches())
        search(stretch, between == Between::skipped ? 16 : samples, between, best);

  Extremes result;
  for (std::size_t axis = 0; axis < axes; ++axis) {
    const Extreme* of_axis = &best[functions_per_axis * axis];
    result.axes.push_back({.lowest = {-of_axis[lowest].value, of_axis[lowest].place},
                           .highest = of_axis[highest],
                           .velocity = of_axis[velocity],
                           .acceleration = of_axis[acceleration],
                           .jerk = of_axis[jerk]});
  }
  for (int key = 0; key <= path_.segments(); ++key) {
    const std::vector<AxisState> before = at_key(key, Side::before);
    const std::vector<AxisState> after = at_key(key, Side::after);
    for (std::size_t axis = 0; axis < axes; ++axis)
      result.steps.push_back(
          {.key = key,
           .frame = key_frame(key),
           .axis = static_cast<int>(axis),
           .velocity = std::fabs(after[axis].velocity - before[axis].velocity),
           .acceleration = std::fabs(after[axis].acceleration - before[axis].acceleration)});
  }
  return result;
}

}  // namespace inbetween::oracle
