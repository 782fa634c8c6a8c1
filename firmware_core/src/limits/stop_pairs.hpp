#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "inbetween/limits/motion_cells.hpp"
#include "inbetween/limits/stop_bounds.hpp"

/// The pair of rate change and rate jerk from which a stop in one cell of the time line lasts shortest.

namespace inbetween {

/// The closeness of the rate change of a pair; its stop time is a thousandth of that off.
template <Precise Real>
inline constexpr Real pair_closeness = Real(1e-3);
/// In 1/s and 1/s^2: a stop that takes weeks is none.
template <Precise Real>
inline constexpr Real min_bound = Real(1e-6);

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
  PairSearch(const StopRequest<Real>& request, const MotionCells<Real>& motion, std::size_t cell)
      : request_(request), motion_(motion), axes_(request.limits.size()), cell_(cell) {}

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
  [[nodiscard]] StopPair<Real> quickest() const {
    Real high = max_change();
    if (falls_at(high)) return {high, max_jerk(high).value};
    Real low = 0;
    while (high - low > pair_closeness<Real> * high) {
      const Real middle = low + (high - low) / 2;
      (falls_at(middle) ? low : high) = middle;
    }
    return {low, max_jerk(low).value};
  }

 private:
  /// R2 at an R1, and at R1 = 0 by the same axis.
  struct MaxJerk {
    Real value = 0;
    Real at_rest = 0;
  };

  [[nodiscard]] const MotionTriple<Real>& suprema(std::size_t d) const {
    return motion_.suprema[cell_ * axes_ + d];
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
    MaxJerk jerk{request_.max_rate_jerk(), request_.max_rate_jerk()};
    for (std::size_t d = 0; d < axes_; ++d) {
      const std::optional<Real> limit = request_.limits[d].stop_jerk();
      if (!limit) continue;
      const auto [p1, p2, p3] = suprema(d);
      const Real at_rest = *limit - p3 * r * r * r;
      const Real left = at_rest - 3 * p2 * r * change;
      if (p1 * jerk.value > left) jerk = {left > 0 ? left / p1 : Real(0), at_rest / p1};
    }
    return jerk;
  }
  [[nodiscard]] bool falls_at(Real change) const {
    const MaxJerk jerk = max_jerk(change);
    return jerk.value * jerk.value * request_.rate >= jerk.at_rest * change * change;
  }

  const StopRequest<Real>& request_;
  const MotionCells<Real>& motion_;
  std::size_t axes_;
  std::size_t cell_;
};

}  // namespace inbetween
