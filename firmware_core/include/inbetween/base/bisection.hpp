#pragma once

#include "inbetween/base/precision.hpp"

namespace inbetween {

struct Bracket {
  double low = 0, high = 0;
};

/// Halves a bracket: `is_below` is true at its low end and false at its high end, or the caller treats the
/// ends as if it were. It ends after `max_halvings` or when no number lies between the ends.
template <class Predicate>
constexpr Bracket bisected(Bracket bracket, int max_halvings, Predicate&& is_below) {
  for (int i = 0; i < max_halvings; ++i) {
    const double middle = bracket.low + (bracket.high - bracket.low) / 2;
    if (!(bracket.low < middle && middle < bracket.high)) break;
    (is_below(middle) ? bracket.low : bracket.high) = middle;
  }
  return bracket;
}

/// What bisected() returns, to the last bit, for the place where a smooth `value` that rises passes 0, with
/// fewer values: Newton's method finds what surrounds it, and outside of that the outcome of a halving is
/// certain. It is, because the computed value falls by no more than `rounding` from any place to a later one.
/// `is_below` tells on which side of 0 a value is. `slope` is about that of the value: where it is 0 or
/// misleads, more values are computed.
template <class Value, class Slope, class IsBelow>
constexpr Bracket bisected_near_zero(Bracket bracket, int max_halvings, double rounding, Value&& value,
                                     Slope&& slope, IsBelow&& is_below) {
  constexpr int max_newton_steps = 6;
  Bracket around = bracket;
  double x = bracket.low;
  for (int i = 0; i < max_newton_steps; ++i) {
    const double y = value(x);
    (y > 0 ? around.high : around.low) = x;
    if (y <= rounding && -y <= rounding) break;
    const double next = x - y / slope(x);
    x = next > around.low && next < around.high ? next : around.low + (around.high - around.low) / 2;
  }
  Bracket certain = bracket;  // up to `low` a value is below, from `high` on it is not
  const double narrow = 2 * rounding / slope(x);
  for (double reach = narrow; reach > 0 && x - reach > bracket.low; reach *= 8) {
    if (!(value(x - reach) < -rounding)) continue;
    certain.low = x - reach;
    break;
  }
  for (double reach = narrow; reach > 0 && x + reach < bracket.high; reach *= 8) {
    if (!(value(x + reach) > rounding)) continue;
    certain.high = x + reach;
    break;
  }
  return bisected(bracket, max_halvings, [&](double middle) {
    return middle <= certain.low || (middle < certain.high && is_below(value(middle)));
  });
}

}  // namespace inbetween
