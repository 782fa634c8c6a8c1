#pragma once

#include "inbetween/base/precision.hpp"
#include "inbetween/limits/stop_bounds.hpp"

/// From rest to rest along the time line, foreseen as a whole.

namespace inbetween {

/// Where a travel is: `way_s` seconds of the time line from its start or, once the rate falls, from its end,
/// so that it rests there exactly.
template <Precise Real>
struct TravelState {
  Real way_s = 0;
  bool to_end = false;
  Real rate = 0;         ///< seconds of the time line a second
  Real rate_change = 0;  ///< of the rate, per second
};

/// The rate rises from 0 by a bend, a straight stretch and a bend, is even for a while, and falls as it rose:
/// r'' is +J, 0, -J, 0, -J, 0, +J. A bend is as steep as release_jerk allows, the straight stretch as
/// rate_change does; where the rate reaches its top before the first bend ends there is no straight stretch.
/// Directions are the caller's: all numbers are magnitudes.
template <Precise Real>
class Travel {
 public:
  Travel() = default;
  /// The quickest over `way_s` >= 0 seconds of the time line at no more than `top_rate` > 0.
  static Travel shortest(Real way_s, Real top_rate, const StopBound<Real>& bounds);
  /// One that keeps `rate` > 0 for `even_s` >= 0 seconds.
  static Travel even(Real rate, Real even_s, const StopBound<Real>& bounds);
  /// Seconds from rest to a rate; half as many times `rate` of the time line pass meanwhile.
  static Real rise_to(Real rate, const StopBound<Real>& bounds);

  /// From rest to rest.
  [[nodiscard]] Real seconds() const { return 2 * rise_s_ + even_s_; }
  /// So many seconds after its start, 0..seconds(). O(1).
  [[nodiscard]] TravelState<Real> at(Real seconds) const;

 private:
  [[nodiscard]] TravelState<Real> rise_at(Real seconds) const;

  Real jerk_ = 0;  ///< of the bends
  Real rate_ = 0;  ///< reached in rise_s_ seconds, held for even_s_
  Real rise_s_ = 0;
  Real bend_s_ = 0;  ///< of each bend
  Real even_s_ = 0;
};

extern template class Travel<double>;
extern template class Travel<float>;

}  // namespace inbetween
