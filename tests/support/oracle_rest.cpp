#include "tests/support/oracle_rest.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "tests/support/oracle_quadrature.hpp"

namespace inbetween::oracle {
namespace {

/// Below this share of its largest speed the path stands still, below that of the largest control value the
/// curve does.
constexpr long double rest_standstill = 1e-12L;
constexpr long double curve_standstill = 1e-13L;
/// Two borders nearer than this share of the length are one.
constexpr long double coincidence = 1e-16L;

long double norm(const std::vector<long double>& weights, const auto& component) {
  long double sum = 0;
  for (std::size_t d = 0; d < weights.size(); ++d) {
    const long double part = weights[d] * component(d);
    sum += part * part;
  }
  return std::sqrt(sum);
}

/// Gauss's rule of three points: on a hundredth of the distance to the next singularity exact to 1e-12.
long double short_integral(const auto& integrand, long double from, long double to) {
  const long double middle = from + (to - from) / 2;
  const long double half = (to - from) / 2;
  const long double node = std::sqrt(0.6L) * half;
  return half * (8 * integrand(middle) + 5 * (integrand(middle - node) + integrand(middle + node))) / 9;
}

std::vector<long double> with_phantoms(const std::vector<double>& values) {
  const std::size_t count = values.size();
  if (count < 2) throw std::invalid_argument("oracle: a curve at rest has more than one control value");
  std::vector<long double> all(count + 2);
  std::copy(values.begin(), values.end(), all.begin() + 1);
  all.front() = 2 * all[1] - all[2];
  all.back() = 2 * all[count] - all[count - 1];
  return all;
}

}  // namespace

RestingMotion::RestingMotion(const Keys& keys, const std::vector<double>& control_values, int frames,
                             long double frames_per_second, std::vector<MetKey> met)
    : path_(keys),
      profile_(control_values),
      cubics_(segment_cubics(keys)),
      values_(with_phantoms(control_values)),
      weights_(keys.weights.empty() ? std::vector<long double>(keys.at.front().size(), 1.0L) : keys.weights),
      frames_(frames),
      spans_per_second_(static_cast<long double>(profile_.spans()) / static_cast<long double>(frames) *
                        frames_per_second),
      met_(std::move(met)),
      best_(keys.at.front().size()) {
  distance_.push_back(0);
  for (int i = 0; i < path_.segments(); ++i) distance_.push_back(distance_.back() + path_.length(i, 0, 1));
}

long double RestingMotion::distance_at(const MetKey& place) const {
  const long double before = distance_[static_cast<std::size_t>(place.key)];
  return place.t > 0 ? before + path_.length(place.key, 0, place.t) : before;
}

std::vector<MetKey> RestingMotion::standstills() const {
  std::vector<MetKey> places;
  for (int i = 0; i < path_.segments(); ++i) {
    for (const long double t : borders_within(i)) {
      if (t == 0 || t == 1) continue;
      const std::vector<Slope> slopes = slopes_at({.segment = i, .t = t});
      if (norm(weights_, [&](std::size_t d) { return slopes[d].a; }) == 0) places.push_back({i, 0, t});
    }
  }
  return places;
}

std::vector<RestPeaks> RestingMotion::peaks() {
  const auto last = static_cast<long double>(profile_.spans());
  MetKey from;
  for (const MetKey& to : met_) {
    add_section(from, to);
    from = to;
  }
  add_section(from, {path_.segments(), last, 0});
  return best_;
}

/// Minima of |diag(w) P'| inside a segment, and its ends.
std::vector<long double> RestingMotion::borders_within(int segment) const {
  const std::vector<Cubic>& c = cubics_[static_cast<std::size_t>(segment)];
  const auto slope = [&](long double t) {
    long double sum = 0;
    for (std::size_t d = 0; d < c.size(); ++d) {
      const long double first = c[d][1] + t * (2 * c[d][2] + t * 3 * c[d][3]);
      sum += weights_[d] * weights_[d] * first * (2 * c[d][2] + 6 * t * c[d][3]);
    }
    return sum;
  };
  std::vector<long double> borders = {0};
  constexpr int parts = 1000;
  for (int i = 0; i < parts; ++i) {
    long double low = static_cast<long double>(i) / parts;
    long double high = static_cast<long double>(i + 1) / parts;
    if (!(slope(low) < 0 && slope(high) >= 0)) continue;
    for (int k = 0; k < 200; ++k) {
      const long double middle = low + (high - low) / 2;
      if (middle <= low || middle >= high) break;
      (slope(middle) < 0 ? low : high) = middle;
    }
    if (high > 1e-15L && high < 1 - 1e-15L) borders.push_back(high);
  }
  borders.push_back(1);
  return borders;
}

long double RestingMotion::alpha_after(long double alpha, long double area, long double last) const {
  long double low = alpha;
  long double high = last;
  for (int i = 0; i < 200; ++i) {
    const long double middle = low + (high - low) / 2;
    if (middle <= low || middle >= high) break;
    (profile_.integral(alpha, middle) < area ? low : high) = middle;
  }
  return high;
}

/// Cuts the section at knots, keys and slow places, in the order of time, and searches each stretch.
void RestingMotion::add_section(const MetKey& from, const MetKey& to) {
  const long double area = profile_.integral(from.alpha, to.alpha);
  const long double begin = distance_at(from);
  const long double length = distance_at(to) - begin;
  if (!(length > 0)) return;
  if (!(area > 0)) throw std::invalid_argument("oracle: the curve stands still between two keys");
  const long double constant = length / area;
  const long double near = coincidence * distance_.back();

  std::vector<std::pair<long double, long double>> knots;  // distance, alpha
  for (auto knot = static_cast<int>(from.alpha) + 1; static_cast<long double>(knot) < to.alpha; ++knot) {
    const auto alpha = static_cast<long double>(knot);
    knots.emplace_back(constant * profile_.integral(from.alpha, alpha), alpha);
  }
  knots.emplace_back(length, to.alpha);
  std::size_t knot = 0;
  long double alpha = from.alpha;
  const int last_segment = to.t > 0 ? to.key : to.key - 1;
  for (int i = from.key; i <= last_segment; ++i) {
    if (!(path_.length(i, 0, 1) > 0)) continue;
    std::vector<long double> borders = borders_within(i);
    if (i == to.key) std::erase_if(borders, [&](long double t) { return t > to.t; });
    long double t = i == from.key ? from.t : 0;
    for (std::size_t k = 1; k < borders.size(); ++k) {
      if (borders[k] <= t) continue;
      const long double behind = distance_[static_cast<std::size_t>(i)] - begin;
      const long double border = behind + path_.length(i, 0, borders[k]);
      while (t < borders[k]) {
        // Dwells, and knots that are where the path is already.
        while (knot + 1 < knots.size() && knots[knot].first <= behind + path_.length(i, 0, t) + near) {
          alpha = knots[knot++].second;
        }
        const bool ends = i == last_segment && k + 1 == borders.size();
        const bool is_inner = knot + 1 < knots.size();
        const bool knot_is_first = is_inner && knots[knot].first < border - near;
        long double t_to = borders[k];
        long double alpha_to = 0;
        if (knot_is_first) {
          alpha_to = knots[knot].second;
          long double low = t;
          long double high = borders[k];
          for (int step = 0; step < 70; ++step) {
            const long double middle = low + (high - low) / 2;
            (behind + path_.length(i, 0, middle) < knots[knot].first ? low : high) = middle;
          }
          t_to = high;
        } else if (ends) {
          alpha_to = to.alpha;
        } else if (is_inner && knots[knot].first <= border + near) {
          alpha_to = knots[knot].second;
        } else {
          alpha_to = alpha_after(alpha, path_.length(i, t, t_to) / constant, to.alpha);
        }
        const int span = std::min(static_cast<int>(alpha), profile_.spans() - 1);
        const long double half = (t_to - t) / 2;
        if (half > 0) {
          search({i, t, alpha, span, constant, true}, half);
          search({i, t_to, alpha_to, span, constant, false}, half);
        }
        t = t_to;
        alpha = alpha_to;
      }
    }
  }
}

std::vector<RestingMotion::Slope> RestingMotion::slopes_at(const End& end) const {
  std::vector<Slope> slopes;
  long double largest = 0;
  const long double side = end.forward ? 1 : -1;
  for (const Cubic& c : cubics_[static_cast<std::size_t>(end.segment)]) {
    const long double t = end.t;
    slopes.push_back({c[1] + t * (2 * c[2] + t * 3 * c[3]), side * (2 * c[2] + 6 * t * c[3]), 3 * c[3]});
    const long double weight = weights_[slopes.size() - 1];
    largest = std::max(largest, weight * (std::fabs(c[1]) + 2 * std::fabs(c[2]) + 3 * std::fabs(c[3])));
  }
  if (norm(weights_, [&](std::size_t d) { return slopes[d].a; }) <= rest_standstill * largest) {
    for (Slope& slope : slopes) slope.a = 0;
  }
  return slopes;
}

/// phi in powers of y about alpha, in the span; at a knot from the control values, so that a rest is one.
RestingMotion::Phi RestingMotion::phi_at(const End& end) const {
  const auto knot_powers = [&](int knot, bool forward) {
    const auto v = static_cast<std::size_t>(knot);
    const std::array<long double, 3> beside = {values_[v], values_[v + 1], values_[v + 2]};
    const long double bend = beside[0] - 2 * beside[1] + beside[2];
    const int other = forward ? knot + 1 : knot - 1;
    const auto o = static_cast<std::size_t>(other);
    const long double bend_there = values_[o] - 2 * values_[o + 1] + values_[o + 2];
    const long double side = forward ? 1 : -1;
    Phi powers = {(beside[0] + 4 * beside[1] + beside[2]) / 6, side * (beside[2] - beside[0]) / 2, bend / 2,
                  (bend_there - bend) / 6};
    const long double largest = *std::max_element(values_.begin(), values_.end());
    for (long double& power : powers) {
      if (std::fabs(power) < curve_standstill * largest) power = 0;
    }
    return powers;
  };
  const long double from_begin = end.alpha - static_cast<long double>(end.span);
  const bool near_begin = from_begin < 0.5L;
  Phi powers = knot_powers(near_begin ? end.span : end.span + 1, near_begin);
  const long double shift = near_begin ? from_begin : 1 - from_begin;
  if (shift > 0) {
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 3; j-- > i;) powers[j] += shift * powers[j + 1];
  }
  if (end.forward != near_begin) {
    powers[1] = -powers[1];
    powers[3] = -powers[3];
  }
  return powers;
}

void RestingMotion::search(const End& end, long double reach) {
  const std::vector<Slope> slopes = slopes_at(end);
  const Phi phi = phi_at(end);
  const auto speed = [&](long double x) {
    return norm(weights_, [&](std::size_t d) { return slopes[d].a + x * (slopes[d].b + x * slopes[d].c); });
  };
  const auto area = [&](long double y) {
    return y * (phi[0] + y * (phi[1] / 2 + y * (phi[2] / 3 + y * phi[3] / 4)));
  };
  const bool passes = speed(0) == 0 && phi[0] > 0;
  passes_standstill_ = passes_standstill_ || passes;
  // The powers of phi hold to the end of the span. Rounding may want a little more area than there is.
  const auto span = static_cast<long double>(end.span);
  const long double room = end.forward ? span + 1 - end.alpha : end.alpha - span;
  constexpr long double step = 1.015L;
  long double x = 0;
  long double length = 0;
  long double y = 0;
  for (long double next = reach * (passes ? 1e-2L : 1e-12L); x < reach; next *= step) {
    next = std::min(next, reach);
    length += x > 0 ? short_integral(speed, x, next) : gauss_legendre(speed, x, next);
    x = next;
    // The moment at which the path is there: Newton's method from above, where the area is convex or not.
    const long double wanted = length / end.constant;
    long double low = y;
    long double high = room;
    long double guess = y > 0 ? std::min(y * 1.02L, room) : std::min(1e-3L, room);
    for (int i = 0; i < 300; ++i) {
      const long double beyond = area(guess) - wanted;
      (beyond > 0 ? high : low) = guess;
      const long double rate = phi[0] + guess * (phi[1] + guess * (phi[2] + guess * phi[3]));
      long double better = guess - beyond / rate;
      if (!(better > low && better < high)) better = low > 0 ? std::sqrt(low * high) : high / 1024;
      const bool is_there = std::fabs(better - guess) <= 1e-18L * guess;
      guess = better;
      if (is_there) break;
    }
    y = guess;
    take(end, slopes, phi, x, y);
  }
}

/// P(s(time)) by the chain rule, s' = w / sigma differentiated.
void RestingMotion::take(const End& end, const std::vector<Slope>& slopes, const Phi& phi, long double x,
                         long double y) {
  const long double r = spans_per_second_;
  const long double k = end.constant;
  const long double w = k * r * (phi[0] + y * (phi[1] + y * (phi[2] + y * phi[3])));
  const long double w1 = k * r * r * (phi[1] + y * (2 * phi[2] + y * 3 * phi[3]));
  const long double w2 = k * r * r * r * (2 * phi[2] + 6 * y * phi[3]);
  const auto first = [&](std::size_t d) { return slopes[d].a + x * (slopes[d].b + x * slopes[d].c); };
  const auto second = [&](std::size_t d) { return slopes[d].b + 2 * x * slopes[d].c; };
  const auto third = [&](std::size_t d) { return 2 * slopes[d].c; };
  const long double sigma = norm(weights_, first);
  long double along = 0;
  long double bend = 0;
  long double bend_terms = 0;  // their magnitudes: they may cancel
  for (std::size_t d = 0; d < slopes.size(); ++d) {
    const long double weight = weights_[d] * weights_[d];
    along += weight * first(d) * second(d);
    bend += weight * (second(d) * second(d) + first(d) * third(d));
    bend_terms += weight * (second(d) * second(d) + std::fabs(first(d) * third(d)));
  }
  const long double sigma1 = along / sigma;
  const long double sigma2 = (bend - sigma1 * sigma1) / sigma;
  const long double s1 = w / sigma;
  const long double s2 = (w1 - sigma1 * s1 * s1) / sigma;
  const long double s3 = (w2 - sigma2 * s1 * s1 * s1 - 3 * sigma1 * s1 * s2) / sigma;
  const long double alpha = end.alpha + (end.forward ? y : -y);
  const long double frame =
      alpha * static_cast<long double>(frames_) / static_cast<long double>(profile_.spans());
  // What the sums above and below lose, of which each term is known to some roundings. The terms of phi may
  // cancel too, and leave a rest with a speed of either sign.
  constexpr long double rounding = 16 * std::numeric_limits<long double>::epsilon();
  const auto sum_of = [y](long double a, long double b, long double c, long double d) {
    return std::fabs(a) + y * (std::fabs(b) + y * (std::fabs(c) + y * std::fabs(d)));
  };
  const long double size1 = std::fabs(s1);
  const long double size2 = std::fabs(s2);
  const long double lost1 = rounding * k * r * sum_of(phi[0], phi[1], phi[2], phi[3]) / sigma;
  const long double lost_w1 = rounding * k * r * r * sum_of(phi[1], 2 * phi[2], 3 * phi[3], 0);
  const long double lost_w2 = rounding * k * r * r * r * sum_of(2 * phi[2], 6 * phi[3], 0, 0);
  const long double lost_sigma2 = rounding * (bend_terms + sigma1 * sigma1) / sigma;
  const long double lost2 = (lost_w1 + std::fabs(sigma1) * size1 * (rounding * size1 + 2 * lost1)) / sigma;
  const long double lost3 =
      (lost_w2 + std::fabs(sigma2) * size1 * size1 * (rounding * size1 + 3 * lost1) +
       lost_sigma2 * size1 * size1 * size1 +
       3 * std::fabs(sigma1) * (rounding * size1 * size2 + lost1 * size2 + size1 * lost2)) /
      sigma;
  const auto raise = [frame](Found& found, long double value, long double lost) {
    found.most = std::max(found.most, std::fabs(value) + lost);
    if (std::fabs(value) - lost > found.value) {
      found.value = std::fabs(value) - lost;
      found.frame = frame;
    }
  };
  for (std::size_t d = 0; d < slopes.size(); ++d) {
    const long double p1 = first(d);
    const long double p2 = second(d);
    const long double p3 = third(d);
    const long double size_p2 = std::fabs(p2);
    raise(best_[d].velocity, p1 * s1, 0);
    raise(best_[d].acceleration, p2 * s1 * s1 + p1 * s2,
          size_p2 * size1 * (rounding * size1 + 2 * lost1) + std::fabs(p1) * lost2);
    raise(best_[d].jerk, p3 * s1 * s1 * s1 + 3 * p2 * s1 * s2 + p1 * s3,
          std::fabs(p3) * size1 * size1 * (rounding * size1 + 3 * lost1) +
              3 * size_p2 * (rounding * size1 * size2 + lost1 * size2 + size1 * lost2) +
              std::fabs(p1) * lost3);
  }
}

}  // namespace inbetween::oracle
