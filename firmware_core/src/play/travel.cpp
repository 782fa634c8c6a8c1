#include "inbetween/play/travel.hpp"

#include <algorithm>
#include <cmath>

#include "base/cube_root.hpp"

namespace inbetween {

/// The rise takes rate / change + change / jerk seconds if r' reaches `change`, otherwise 2 sqrt(rate /
/// jerk).
template <Precise Real>
Real Travel<Real>::rise_to(Real rate, const StopBound<Real>& bounds) {
  const Real jerk_s = bounds.rate_change / bounds.release_jerk;
  if (rate <= bounds.rate_change * jerk_s) return 2 * std::sqrt(rate / bounds.release_jerk);
  return rate / bounds.rate_change + jerk_s;
}

template <Precise Real>
Travel<Real> Travel<Real>::even(Real rate, Real even_s, const StopBound<Real>& bounds) {
  Travel travel;
  travel.jerk_ = bounds.release_jerk;
  travel.rate_ = rate;
  travel.rise_s_ = rise_to(rate, bounds);
  travel.jerk_s_ = std::min(bounds.rate_change / bounds.release_jerk, travel.rise_s_ / 2);
  travel.even_s_ = even_s;
  return travel;
}

template <Precise Real>
Travel<Real> Travel<Real>::shortest(Real way_s, Real top_rate, const StopBound<Real>& bounds) {
  const Real change = bounds.rate_change;
  const Real jerk = bounds.release_jerk;
  const Real jerk_s = change / jerk;
  Real rate = top_rate;
  if (rate * rise_to(rate, bounds) > way_s) {
    const Real t = cube_root(way_s / (2 * jerk));
    rate = jerk * t * t;
    if (rate > change * jerk_s) {
      const Real root = std::sqrt(jerk_s * jerk_s + 4 * way_s / change);
      rate = change / 2 * (root - jerk_s);
    }
  }
  Travel travel = even(rate, 0, bounds);
  if (rate > 0) travel.even_s_ = std::max(way_s / rate - travel.rise_s_, Real{0});
  return travel;
}

/// Three phases: -J until r' = -peak, then r'' = 0, then +J.
template <Precise Real>
Real Travel<Real>::stop_way(Real rate, Real rate_change, const StopBound<Real>& bounds, Real tick_s) {
  const Real j = bounds.release_jerk;
  const Real fall = -rate_change;
  const Real peak = std::max(std::min(bounds.rate_change, std::sqrt(j * rate + fall * fall / 2)), fall);
  const Real steeper_s = (peak - fall) / j;
  const Real release_s = peak / j;
  const Real release_rate = peak * release_s / 2;
  const Real steep_rate = rate - steeper_s * (fall + peak) / 2;
  const Real even_s = std::max((steep_rate - release_rate) / peak, Real{0});
  const Real way_s = steeper_s * (rate - steeper_s * (fall / 2 + steeper_s * j / 6)) +
                     even_s * (steep_rate + release_rate) / 2 + release_s * release_rate / 3;
  return way_s + j * tick_s * tick_s * (steeper_s + even_s + release_s);
}

template <Precise Real>
TravelState<Real> Travel<Real>::at(Real seconds) const {
  const Real left = this->seconds() - seconds;
  if (seconds < rise_s_) return rise_at(seconds);
  if (left > rise_s_) return {rate_ * (seconds - rise_s_ / 2), false, rate_, 0};
  TravelState<Real> state = rise_at(left);
  state.to_end = true;
  state.rate_change = -state.rate_change;
  return state;
}

/// The state at so many seconds after rest, while the rate rises.
template <Precise Real>
TravelState<Real> Travel<Real>::rise_at(Real seconds) const {
  const Real j = jerk_;
  const Real b = jerk_s_;
  const Real t = seconds;
  if (t <= b) return {j * t * t * t / 6, false, j * t * t / 2, j * t};
  const Real left = rise_s_ - t;
  if (left <= b) {
    return {rate_ * (rise_s_ / 2 - left) + j * left * left * left / 6, false, rate_ - j * left * left / 2,
            j * left};
  }
  const Real y = t - b;
  return {b * b * b * j / 6 + y * (j * b * b / 2 + y * j * b / 2), false, j * b * (b / 2 + y), j * b};
}

template class Travel<double>;
template class Travel<float>;

}  // namespace inbetween
