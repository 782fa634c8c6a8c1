#include "segment_speed.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

namespace inbetween {
namespace {

/// Ascending anchors in [0, 1].
struct Anchors {
  std::array<double, 4> t{};
  std::size_t count = 0;
  void add(double anchor) {
    if (count < t.size()) t[count++] = anchor;  // a quartic has no more than these
  }
};

/// The place of the minimum of q on [a, b], to the last bit, if that is below `slow`; q' rises from negative
/// to positive.
std::optional<double> slow_minimum(const Quartic& q, double a, double b, double slow) {
  for (int i = 0; i < std::numeric_limits<double>::digits + 8; ++i) {
    // A convex function is above its tangents.
    if (q.value(a) + q.derivative(a) * (b - a) >= slow || q.value(b) - q.derivative(b) * (b - a) >= slow) {
      return std::nullopt;
    }
    const double middle = a + (b - a) / 2;
    if (middle <= a || middle >= b) break;
    (q.derivative(middle) < 0 ? a : b) = middle;
  }
  if (q.value(b) < slow) return b;
  return std::nullopt;
}

/// Adds the minima of q inside (0, 1): q' passes from negative to positive between two
/// neighbouring zeros of q'' (a quadratic).
void add_inner_minima(const Quartic& q, double slow, Anchors& anchors) {
  std::array<double, 4> cuts{0, 1, 1, 1};
  std::size_t cut_count = 1;
  const double a = 12 * q.q[4];
  const double b = 6 * q.q[3];
  const double c = 2 * q.q[2];
  const double discriminant = b * b - 4 * a * c;
  if (discriminant > 0) {
    const double r = -(b + std::copysign(std::sqrt(discriminant), b)) / 2;
    std::array<double, 2> zeros{a != 0 ? r / a : -1.0, r != 0 ? c / r : -1.0};
    if (zeros[1] < zeros[0]) std::swap(zeros[0], zeros[1]);
    for (const double zero : zeros) {
      if (zero > 0 && zero < 1) cuts[cut_count++] = zero;
    }
  }
  cuts[cut_count++] = 1;
  // A minimum this near to an end is the end: the slope there is rounding.
  const double rounding = 64 * std::numeric_limits<double>::epsilon();
  for (std::size_t i = 0; i + 1 < cut_count; ++i) {
    if (!(q.derivative(cuts[i]) < 0) || q.derivative(cuts[i + 1]) < 0) continue;
    const std::optional<double> t = slow_minimum(q, cuts[i], cuts[i + 1], slow);
    if (t && *t > rounding && *t < 1 - rounding) anchors.add(*t);
  }
}

Anchors find_anchors(const Quartic& q) {
  Anchors anchors;
  const std::array<double, 5> bounds = q.ordinates();
  const double largest = *std::ranges::max_element(bounds);
  const double slow = slow_share * largest;
  if (*std::ranges::min_element(bounds) >= slow) return anchors;
  if (bounds[0] < slow) anchors.add(0);
  add_inner_minima(q, slow, anchors);
  if (bounds[4] < slow) anchors.add(1);
  return anchors;
}

AnchoredInterval anchored(const SegmentSpeed& speed, double anchor, double end, double largest) {
  AnchoredInterval interval;
  interval.anchor = anchor;
  interval.forward = end > anchor;
  interval.extent = std::fabs(end - anchor);
  interval.speed_squared = speed.about(anchor, interval.forward);
  const std::array<double, 5>& q = interval.speed_squared.q;
  // If P' vanishes to second order (q[2] = 0 too) sqrt(d) fits no better than d.
  interval.stands_still = q[0] <= still_share * largest && q[2] > slow_share * slow_share * largest;
  return interval;
}

}  // namespace

AnchoredIntervals split_where_slow(const SegmentSpeed& speed) {
  const Quartic q = speed.about(0, true);
  const Anchors anchors = find_anchors(q);
  AnchoredIntervals result;
  const auto add = [&](const AnchoredInterval& interval) { result.intervals[result.count++] = interval; };
  if (anchors.count == 0) {
    add({.anchor = 0, .extent = 1, .forward = true, .stands_still = false, .speed_squared = q});
    return result;
  }
  const std::array<double, 5> bounds = q.ordinates();
  const double largest = *std::ranges::max_element(bounds);
  double begin = 0;
  for (std::size_t i = 0; i < anchors.count; ++i) {
    const double anchor = anchors.t[i];
    const double end = i + 1 < anchors.count ? (anchor + anchors.t[i + 1]) / 2 : 1.0;
    if (anchor > begin) add(anchored(speed, anchor, begin, largest));
    if (end > anchor) add(anchored(speed, anchor, end, largest));
    begin = end;
  }
  return result;
}

}  // namespace inbetween
