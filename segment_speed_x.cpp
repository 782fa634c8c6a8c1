#include "segment_speed.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

namespace inbetween {
namespace {

/// Ascending anchors in [0, 1].
template <Precise Real>
struct Anchors {
  std::array<Real, 4> t{};
  std::size_t count = 0;
  void add(Real anchor) {
    if (count < t.size()) t[count++] = anchor;  // a quartic has no more than these
  }
};

/// The place of the minimum of q on [a, b], to the last bit, if that is below `slow`; q' rises from negative
/// to positive.
template <Precise Real>
std::optional<Real> slow_minimum(const Quartic<Real>& q, Real a, Real b, Real slow) {
  for (int i = 0; i < std::numeric_limits<Real>::digits + 8; ++i) {
    // A convex function is above its tangents.
    if (q.value(a) + q.derivative(a) * (b - a) >= slow || q.value(b) - q.derivative(b) * (b - a) >= slow) {
      return std::nullopt;
    }
    const Real middle = a + (b - a) / 2;
    if (middle <= a || middle >= b) break;
    (q.derivative(middle) < 0 ? a : b) = middle;
  }
  if (q.value(b) < slow) return b;
  return std::nullopt;
}

/// Adds the minima of q inside (0, 1): q' passes from negative to positive between two
/// neighbouring zeros of q'' (a quadratic).
template <Precise Real>
void add_inner_minima(const Quartic<Real>& q, Real slow, Anchors<Real>& anchors) {
  std::array<Real, 4> cuts{0, 1, 1, 1};
  std::size_t cut_count = 1;
  const Real a = 12 * q.q[4];
  const Real b = 6 * q.q[3];
  const Real c = 2 * q.q[2];
  const Real discriminant = b * b - 4 * a * c;
  if (discriminant > 0) {
    const Real r = -(b + std::copysign(std::sqrt(discriminant), b)) / 2;
    std::array<Real, 2> zeros{a != 0 ? r / a : Real(-1), r != 0 ? c / r : Real(-1)};
    if (zeros[1] < zeros[0]) std::swap(zeros[0], zeros[1]);
    for (const Real zero : zeros) {
      if (zero > 0 && zero < 1) cuts[cut_count++] = zero;
    }
  }
  cuts[cut_count++] = 1;
  // A minimum this near to an end is the end: the slope there is rounding.
  const Real rounding = 64 * std::numeric_limits<Real>::epsilon();
  for (std::size_t i = 0; i + 1 < cut_count; ++i) {
    if (!(q.derivative(cuts[i]) < 0) || q.derivative(cuts[i + 1]) < 0) continue;
    const std::optional<Real> t = slow_minimum(q, cuts[i], cuts[i + 1], slow);
    if (t && *t > rounding && *t < 1 - rounding) anchors.add(*t);
  }
}

template <Precise Real>
Anchors<Real> find_anchors(const Quartic<Real>& q) {
  Anchors<Real> anchors;
  const std::array<Real, 5> bounds = q.ordinates();
  const Real largest = *std::ranges::max_element(bounds);
  const Real slow = slow_share<Real> * largest;
  if (*std::ranges::min_element(bounds) >= slow) return anchors;
  if (bounds[0] < slow) anchors.add(0);
  add_inner_minima(q, slow, anchors);
  if (bounds[4] < slow) anchors.add(1);
  return anchors;
}

template <Precise Real>
AnchoredInterval<Real> anchored(const SegmentSpeed<Real>& speed, Real anchor, Real end, Real largest) {
  AnchoredInterval<Real> interval;
  interval.anchor = anchor;
  interval.forward = end > anchor;
  interval.extent = std::fabs(end - anchor);
  interval.speed_squared = speed.about(anchor, interval.forward);
  const std::array<Real, 5>& q = interval.speed_squared.q;
  // If P' vanishes to second order (q[2] = 0 too) sqrt(d) fits no better than d.
  interval.stands_still =
      q[0] <= still_share<Real> * largest && q[2] > slow_share<Real> * slow_share<Real> * largest;
  return interval;
}

}  // namespace

template <Precise Real>
AnchoredIntervals<Real> split_where_slow(const SegmentSpeed<Real>& speed) {
  const Quartic<Real> q = speed.about(0, true);
  const Anchors<Real> anchors = find_anchors(q);
  AnchoredIntervals<Real> result;
  const auto add = [&](const AnchoredInterval<Real>& interval) {
    result.intervals[result.count++] = interval;
  };
  if (anchors.count == 0) {
    add({.anchor = 0, .extent = 1, .forward = true, .stands_still = false, .speed_squared = q});
    return result;
  }
  const std::array<Real, 5> bounds = q.ordinates();
  const Real largest = *std::ranges::max_element(bounds);
  Real begin = 0;
  for (std::size_t i = 0; i < anchors.count; ++i) {
    const Real anchor = anchors.t[i];
    const Real end = i + 1 < anchors.count ? (anchor + anchors.t[i + 1]) / 2 : Real(1);
    if (anchor > begin) add(anchored(speed, anchor, begin, largest));
    if (end > anchor) add(anchored(speed, anchor, end, largest));
    begin = end;
  }
  return result;
}

template AnchoredIntervals<double> split_where_slow(const SegmentSpeed<double>&);

}  // namespace inbetween
