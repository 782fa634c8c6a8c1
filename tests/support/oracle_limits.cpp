#include "tests/support/oracle_limits.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "tests/support/oracle_quadrature.hpp"
#include "tests/support/oracle_search.hpp"
#include "tests/support/oracle_table.hpp"

namespace inbetween::oracle {
namespace {

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

std::vector<IdealMotion::Stretch> IdealMotion::stretches(int first, int last) const {
  struct Bound {
    long double alpha;
    int key;  ///< -1: a knot of phi
  };
  std::vector<Bound> bounds;
  for (int knot = 0; knot <= profile_.spans(); ++knot) bounds.push_back({static_cast<long double>(knot), -1});
  // The first and the last frame are cut out like knots.
  const long double spans_per_frame = static_cast<long double>(profile_.spans()) / frames_;
  const long double begin = first * spans_per_frame;
  const long double end = last == frames_ ? profile_.spans() : last * spans_per_frame;
  if (first > 0) bounds.push_back({begin, -1});
  if (last < frames_) bounds.push_back({end, -1});
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
      const long double distance = k_ * profile_.integral(bound.alpha);
      const Place there = path_.place(std::min(distance, path_.total_length()));
      if (there.segment < place.segment) to.t = place.t;
      if (there.segment == place.segment) to.t = std::max(place.t, there.t);
    }
    const auto span = static_cast<int>(alpha);
    const auto knot = static_cast<long double>(span);
    if (bound.alpha > alpha && alpha >= begin && bound.alpha <= end)
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
    long double turn = 0;
    for (std::size_t axis = 0; axis < weights_.size(); ++axis)
      turn =
          std::hypot(turn, weights_[axis] * second_derivative(segment(stretch.segment).axis[axis], middle));
    const long double width =
        turn > 0 ? std::max(speed(stretch.segment, middle) / turn, standstill_reach) : 1;
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

Extremes IdealMotion::extremes_between(int first, int last, int samples) const {
  if (samples < 1) throw std::invalid_argument("oracle: nothing to search");
  const auto axes = static_cast<std::size_t>(path_.axes());
  std::vector<Extreme> best(functions_per_axis * axes, {-infinity, 0});
  const std::vector<AxisState> start = first == 0 ? at_key(0, Side::before) : at(first);
  Sample at_start{.x = 0, .values = std::vector<long double>(best.size()), .place = 0};
  write_functions(start, at_start.values);
  for (std::size_t i = 0; i < best.size(); ++i) best[i].value = at_start.values[i];
  // Once without climbing, so that only what can be higher than all of it is climbed.
  if (k_ > 0)
    for (const Between between : {Between::skipped, Between::climbed})
      for (const Stretch& stretch : stretches(first, last))
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
