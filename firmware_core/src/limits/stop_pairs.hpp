#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

#include "inbetween/limits/motion_cells.hpp"
#include "inbetween/limits/stop_bounds.hpp"

/// The pair of rate change and rate jerk from which a stop in one cell of the time line lasts shortest.

namespace inbetween {

/// How far the stop time of a pair may be from the least there is.
template <Precise Real>
inline constexpr Real pair_closeness = Real(1e-5);
/// In 1/s and 1/s^2: a stop that takes weeks is none.
template <Precise Real>
inline constexpr Real min_bound = Real(1e-6);

/// In single precision it is rounded up.
template <Precise Real>
std::array<Real, motion_quantities> in_precision(const MotionTriple& triple) {
  const auto rounded = [](double value) {
    const auto near = static_cast<Real>(value);
    return static_cast<double>(near) < value ? near * (1 + std::numeric_limits<Real>::epsilon()) : near;
  };
  return {rounded(triple[0]), rounded(triple[1]), rounded(triple[2])};
}

/// R1 and R2 of a cell.
template <Precise Real>
struct StopPair {
  Real rate_change = 0;
  Real rate_jerk = 0;
};

/// The limits that the axes leave to rate change and rate jerk in one cell.
template <Precise Real>
class PairSearch {
 public:
  PairSearch(const StopRequest<Real>& request, std::size_t cell)
      : request_(request),
        axes_(request.limits.size()),
        cell_(cell),
        max_rate_jerk_(request.max_rate_jerk()),
        min_share_(std::sqrt(std::numeric_limits<Real>::epsilon()) / max_rate_jerk_) {}

  /// Why there is no pair, with the axis.
  [[nodiscard]] std::optional<StopObstacle<Real>> obstacle() const {
    for (std::size_t d = 0; d < axes_; ++d) {
      const auto [p1, p2, p3] = suprema(d);
      const Real r = request_.rate;
      const Real acceleration = p2 * r * r;
      const Real limit = request_.limits[d].stop_acceleration();
      const auto axis = static_cast<std::int32_t>(d);
      if (!(limit - acceleration > p1 * min_bound<Real>)) {
        return StopObstacle<Real>{axis, StopQuantity::acceleration, acceleration, limit};
      }
      const std::optional<Real> jerk_limit = request_.limits[d].stop_jerk();
      const Real jerk = p3 * r * r * r;
      if (jerk_limit && !(*jerk_limit - jerk > p1 * min_bound<Real>)) {
        return StopObstacle<Real>{axis, StopQuantity::jerk, jerk, *jerk_limit};
      }
    }
    return std::nullopt;
  }

  /// There is no obstacle. rate / R1 + R1 / R2 is the greatest of its values for each axis, and each of
  /// those, with R2 = b - s R1, is convex and falls as long as R2^2 rate > b R1^2. At its least R1^2 <= R2
  /// rate, so that it is the time of a stop there.
  ///
  /// The least of the two axes that bound R2 at both ends of an interval is sought, and then the interval
  /// ends there (cutting planes; Kelley 1960): until no third axis bounds R2 there. That takes two or three
  /// looks at all axes, where halving takes twelve.
  [[nodiscard]] StopPair<Real> quickest() const {
    Real high = max_change();
    MaxJerk above = max_jerk(high);
    if (falls_at(high, above)) return {high, above.value(high)};
    Real low = 0;
    MaxJerk below = max_jerk(low);
    while (true) {
      const Real crossing = (below.at_rest - above.at_rest) / (below.slope - above.slope);
      // The same axis at both ends has no crossing: NaN, which is passed over.
      const Real best =
          quickest_of(above) > crossing ? quickest_of(above) : std::min(quickest_of(below), crossing);
      const Real change = std::min(high, best);
      const MaxJerk here = max_jerk(change);
      const Real jerk = here.value(change);
      const Real hoped = std::min(below.value(change), above.value(change));
      const bool is_inside = change > low && change < high;
      if (!is_inside || jerk >= hoped * (1 - pair_closeness<Real>)) return {change, jerk};
      if (falls_at(change, here)) {
        low = change;
        below = here;
      } else {
        high = change;
        above = here;
      }
    }
  }

 private:
  /// R2 by the axis that bounds it at some R1, as a function of R1; below 0 where that leaves no R2.
  struct MaxJerk {
    Real at_rest = 0;
    Real slope = 0;

    [[nodiscard]] Real value(Real change) const { return at_rest - slope * change; }
  };

  [[nodiscard]] std::array<Real, motion_quantities> suprema(std::size_t d) const {
    return in_precision<Real>(request_.motion.of_cell(cell_)[d]);
  }
  [[nodiscard]] Real max_change() const {
    Real change = request_.max_rate_change();
    for (std::size_t d = 0; d < axes_; ++d) {
      const auto [p1, p2, p3] = suprema(d);
      const Real left = request_.limits[d].stop_acceleration() - p2 * request_.rate * request_.rate;
      if (p1 * change > left) change = left / p1;
    }
    return change;
  }
  [[nodiscard]] MaxJerk max_jerk(Real change) const {
    const Real r = request_.rate;
    MaxJerk jerk{max_rate_jerk_, 0};
    Real value = jerk.at_rest;
    for (std::size_t d = 0; d < axes_; ++d) {
      const std::optional<Real> limit = request_.limits[d].stop_jerk();
      if (!limit) continue;
      const auto [p1, p2, p3] = suprema(d);
      const Real at_rest = *limit - p3 * r * r * r;
      const Real slope = 3 * p2 * r;
      if (!(p1 * value > at_rest - slope * change)) continue;
      const Real share = std::max(p1, min_share_ * *limit);
      jerk = {at_rest / share, slope / share};
      value = jerk.value(change);
    }
    return jerk;
  }
  [[nodiscard]] bool falls_at(Real change, const MaxJerk& jerk) const {
    const Real value = jerk.value(change);
    return value > 0 && value * value * request_.rate >= jerk.at_rest * change * change;
  }
  /// The rate change with which a stop that only this axis bounds takes the least time.
  [[nodiscard]] Real quickest_of(const MaxJerk& jerk) const {
    return std::sqrt(jerk.at_rest * request_.rate) /
           (1 + jerk.slope * std::sqrt(request_.rate / jerk.at_rest));
  }

  const StopRequest<Real>& request_;
  std::size_t axes_;
  std::size_t cell_;
  Real max_rate_jerk_;
  Real min_share_;  ///< the R2 of an axis that hardly moves would fall too steeply for the digits of a Real
};

}  // namespace inbetween
