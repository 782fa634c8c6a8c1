#include "inbetween/play/travel.hpp"

#include <algorithm>
#include <cmath>

#include "base/cube_root.hpp"

namespace inbetween {

/// The rise takes rate / change + change / jerk seconds if r' reaches `change`, otherwise 2 sqrt(rate /
/// jerk).
double Travel::rise_to(double rate, const StopBound& bounds) {
  const double jerk_s = bounds.rate_change / bounds.release_jerk;
  if (rate <= bounds.rate_change * jerk_s) return 2 * std::sqrt(rate / bounds.release_jerk);
  return rate / bounds.rate_change + jerk_s;
}

Travel Travel::even(double rate, double even_s, const StopBound& bounds) {
  Travel travel;
  travel.jerk_ = bounds.release_jerk;
  travel.rate_ = rate;
  travel.rise_s_ = rise_to(rate, bounds);
  travel.jerk_s_ = std::min(bounds.rate_change / bounds.release_jerk, travel.rise_s_ / 2);
  travel.even_s_ = even_s;
  return travel;
}

Travel Travel::shortest(double distance_s, double top_rate, const StopBound& bounds) {
  const double change = bounds.rate_change;
  const double jerk = bounds.release_jerk;
  const double jerk_s = change / jerk;
  double rate = top_rate;
  if (rate * rise_to(rate, bounds) > distance_s) {
    const double t = cube_root(distance_s / (2 * jerk));
    rate = jerk * t * t;
    if (rate > change * jerk_s) {
      const double root = std::sqrt(jerk_s * jerk_s + 4 * distance_s / change);
      rate = change / 2 * (root - jerk_s);
    }
  }
  Travel travel = even(rate, 0, bounds);
  if (rate > 0) travel.even_s_ = std::max(distance_s / rate - travel.rise_s_, 0.0);
  return travel;
}

/// Three phases: -J until r' = -peak, then r'' = 0, then +J.
double Travel::stop_distance_s(double rate, double rate_change, const StopBound& bounds, double tick_s) {
  const double j = bounds.release_jerk;
  const double fall = -rate_change;
  const double peak = std::max(std::min(bounds.rate_change, std::sqrt(j * rate + fall * fall / 2)), fall);
  const double steeper_s = (peak - fall) / j;
  const double release_s = peak / j;
  const double release_rate = peak * release_s / 2;
  const double steep_rate = rate - steeper_s * (fall + peak) / 2;
  const double even_s = std::max((steep_rate - release_rate) / peak, 0.0);
  const double distance_s = steeper_s * (rate - steeper_s * (fall / 2 + steeper_s * j / 6)) +
                            even_s * (steep_rate + release_rate) / 2 + release_s * release_rate / 3;
  return distance_s + j * tick_s * tick_s * (steeper_s + even_s + release_s);
}

TravelState Travel::at(double seconds) const {
  const double left = this->seconds() - seconds;
  if (seconds < rise_s_) return rise_at(seconds);
  if (left > rise_s_) return {rate_ * (seconds - rise_s_ / 2), false, rate_, 0};
  TravelState state = rise_at(left);
  state.to_end = true;
  state.rate_change = -state.rate_change;
  return state;
}

/// The state at so many seconds after rest, while the rate rises.
TravelState Travel::rise_at(double seconds) const {
  const double j = jerk_;
  const double b = jerk_s_;
  const double t = seconds;
  if (t <= b) return {j * t * t * t / 6, false, j * t * t / 2, j * t};
  const double left = rise_s_ - t;
  if (left <= b) {
    return {rate_ * (rise_s_ / 2 - left) + j * left * left * left / 6, false, rate_ - j * left * left / 2,
            j * left};
  }
  const double y = t - b;
  return {b * b * b * j / 6 + y * (j * b * b / 2 + y * j * b / 2), false, j * b * (b / 2 + y), j * b};
}

}  // namespace inbetween
