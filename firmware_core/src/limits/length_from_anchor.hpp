#pragma once

#include <algorithm>
#include <cmath>

#include "path/piece_fit.hpp"
#include "path/segment_speed.hpp"

/// The length of a path from the place where it is slowest, to so many digits of that length and not of the
/// whole path: how the path turns there depends on powers of it.

namespace inbetween {

/// Whether a piece of the path stands still at its anchor, whatever P'' is: P' there is rounding.
template <Precise Real>
bool is_still_at_anchor(const AnchoredInterval<Real>& interval) {
  const std::array<Real, 5>& q = interval.speed_squared.q;
  return q[0] <= still_share<Real> * std::max(q[2], q[4]);
}

template <Precise Real>
class LengthFromAnchor {
 public:
  explicit LengthFromAnchor(const AnchoredInterval<Real>& interval)
      : q_(interval.speed_squared.q), is_still_(is_still_at_anchor(interval)), extent_(interval.extent) {}

  /// The integral of |P'| from 0 to tau, to 1e-7 of itself. It is integrated in parts that halve towards the
  /// anchor, each no longer than its distance from there, until q is nearly constant (or g = q / tau^2, where
  /// the path stands still): the zeros of q, where its root is not smooth, are then further away than a part
  /// is long.
  [[nodiscard]] Real at(Real tau) const {
    Real sum = 0;
    for (int i = 0; i < max_parts && !is_smooth(tau); ++i) {
      const Real middle = tau * Real(0.75);
      sum += part(middle, tau) + part(tau / 2, middle);
      tau /= 2;
    }
    return sum + part(0, tau);
  }

  /// The inverse: Newton's method in a bracket, which may begin anywhere.
  [[nodiscard]] Real inverse(Real length, Real guess) const {
    Real low = 0;
    Real high = extent_;
    Real tau = guess > low && guess < high ? guess : high;
    for (int i = 0; i < max_steps; ++i) {
      const Real beyond = at(tau) - length;
      (beyond > 0 ? high : low) = tau;
      Real next = tau - beyond / speed(tau);
      if (!(next > low && next < high)) next = low + (high - low) / 2;
      if (std::fabs(next - tau) <= 64 * std::numeric_limits<Real>::epsilon() * tau) return next;
      tau = next;
    }
    return tau;
  }

 private:
  /// Below the least of the near-cusps that are no standstill.
  static constexpr int max_parts = std::numeric_limits<Real>::digits;
  static constexpr int max_steps = 100;

  [[nodiscard]] bool is_smooth(Real tau) const {
    const std::size_t first = is_still_ ? 2 : 0;
    Real change = 0;
    for (std::size_t i = 4; i > first; --i) change = (change + std::fabs(q_[i])) * tau;
    return change <= q_[first] / 4;
  }
  [[nodiscard]] Real speed(Real tau) const {
    const Real g = q_[2] + tau * (q_[3] + tau * q_[4]);
    if (is_still_) return tau * std::sqrt(std::max(g, Real(0)));
    return std::sqrt(std::max(q_[0] + tau * (q_[1] + tau * g), Real(0)));
  }
  [[nodiscard]] Real part(Real from, Real to) const {
    return mean_of([this](Real tau) { return speed(tau); }, from, to - from) * (to - from);
  }

  std::array<Real, 5> q_;
  bool is_still_;
  Real extent_;
};

}  // namespace inbetween
