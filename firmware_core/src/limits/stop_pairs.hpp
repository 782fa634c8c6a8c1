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
inline constexpr double pair_closeness = 1e-5;
/// In 1/s and 1/s^2: a stop that takes weeks is none.
inline constexpr double min_bound = 1e-6;

/// R1 and R2 of a cell.
struct StopPair {
  double rate_change = 0;
  double rate_jerk = 0;
};

/// The limits that the axes leave to rate change and rate jerk in one cell.
class PairSearch {
 public:
  PairSearch(const StopRequest& request, std::size_t cell)
      : request_(request),
        axes_(request.limits.size()),
        cell_(cell),
        max_rate_jerk_(request.max_rate_jerk()),
        min_share_(std::sqrt(std::numeric_limits<double>::epsilon()) / max_rate_jerk_) {}

  /// Why there is no pair, with the axis.
  [[nodiscard]] std::optional<StopObstacle> obstacle() const {
    for (std::size_t d = 0; d < axes_; ++d) {
      const auto& [p1, p2, p3] = suprema(d);
      const double r = request_.rate;
      const double acceleration = p2 * r * r;
      const double limit = request_.limits[d].stop_acceleration();
      const auto axis = static_cast<std::int32_t>(d);
      if (!(limit - acceleration > p1 * min_bound)) {
        return StopObstacle{axis, StopQuantity::acceleration, acceleration, limit};
      }
      const std::optional<double> jerk_limit = request_.limits[d].stop_jerk();
      const double jerk = p3 * r * r * r;
      if (jerk_limit && !(*jerk_limit - jerk > p1 * min_bound)) {
        return StopObstacle{axis, StopQuantity::jerk, jerk, *jerk_limit};
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
  [[nodiscard]] StopPair quickest() const {
    double high = max_change();
    MaxJerk above = max_jerk(high);
    if (falls_at(high, above)) return {high, above.value(high)};
    double low = 0;
    MaxJerk below = max_jerk(low);
    while (true) {
      const double crossing = (below.at_rest - above.at_rest) / (below.slope - above.slope);
      // The same axis at both ends has no crossing: NaN, which is passed over.
      const double best =
          quickest_of(above) > crossing ? quickest_of(above) : std::min(quickest_of(below), crossing);
      const double change = std::min(high, best);
      const MaxJerk here = max_jerk(change);
      const double jerk = here.value(change);
      const double hoped = std::min(below.value(change), above.value(change));
      const bool is_inside = change > low && change < high;
      if (!is_inside || jerk >= hoped * (1 - pair_closeness)) return {change, jerk};
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
    double at_rest = 0;
    double slope = 0;

    [[nodiscard]] double value(double change) const { return at_rest - slope * change; }
  };

  [[nodiscard]] const MotionTriple& suprema(std::size_t d) const { return request_.motion.of_cell(cell_)[d]; }
  [[nodiscard]] double max_change() const {
    double change = request_.max_rate_change();
    for (std::size_t d = 0; d < axes_; ++d) {
      const auto& [p1, p2, p3] = suprema(d);
      const double left = request_.limits[d].stop_acceleration() - p2 * request_.rate * request_.rate;
      if (p1 * change > left) change = left / p1;
    }
    return change;
  }
  [[nodiscard]] MaxJerk max_jerk(double change) const {
    const double r = request_.rate;
    MaxJerk jerk{max_rate_jerk_, 0};
    double value = jerk.at_rest;
    for (std::size_t d = 0; d < axes_; ++d) {
      const std::optional<double> limit = request_.limits[d].stop_jerk();
      if (!limit) continue;
      const auto& [p1, p2, p3] = suprema(d);
      const double at_rest = *limit - p3 * r * r * r;
      const double slope = 3 * p2 * r;
      if (!(p1 * value > at_rest - slope * change)) continue;
      const double share = std::max(p1, min_share_ * *limit);
      jerk = {at_rest / share, slope / share};
      value = jerk.value(change);
    }
    return jerk;
  }
  [[nodiscard]] bool falls_at(double change, const MaxJerk& jerk) const {
    const double value = jerk.value(change);
    return value > 0 && value * value * request_.rate >= jerk.at_rest * change * change;
  }
  /// The rate change with which a stop that only this axis bounds takes the least time.
  [[nodiscard]] double quickest_of(const MaxJerk& jerk) const {
    return std::sqrt(jerk.at_rest * request_.rate) /
           (1 + jerk.slope * std::sqrt(request_.rate / jerk.at_rest));
  }

  const StopRequest& request_;
  std::size_t axes_;
  std::size_t cell_;
  double max_rate_jerk_;
  double
      min_share_;  ///< the R2 of an axis that hardly moves would fall too steeply for the digits of a double
};

}  // namespace inbetween
