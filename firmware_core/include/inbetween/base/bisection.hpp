#pragma once

#include "inbetween/base/precision.hpp"

namespace inbetween {

template <Precise Real>
struct Bracket {
  Real low = 0, high = 0;
};

/// Halves a bracket: `is_below` is true at its low end and false at its high end, or the caller treats the
/// ends as if it were. It ends after `max_halvings` or when no number lies between the ends.
template <Precise Real, class Predicate>
constexpr Bracket<Real> bisected(Bracket<Real> bracket, int max_halvings, Predicate&& is_below) {
  for (int i = 0; i < max_halvings; ++i) {
    const Real middle = bracket.low + (bracket.high - bracket.low) / 2;
    if (!(bracket.low < middle && middle < bracket.high)) break;
    (is_below(middle) ? bracket.low : bracket.high) = middle;
  }
  return bracket;
}

}  // namespace inbetween
