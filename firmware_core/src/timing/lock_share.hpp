#pragma once

#include <limits>

#include "inbetween/base/precision.hpp"

namespace inbetween {

/// Twice what a lock promises, as a share of the length: a place that the move comes to rest at within this
/// is met at rest.
inline constexpr double lock_share = 2e-12;

/// Within a span of the drawn curve the computed distance falls nowhere by more than this share of the
/// distance over the span. That distance is at least a quarter of the largest Bernstein coefficient of the
/// curve, so the coefficients of the distance in powers of t add up to 32 times that distance at most; they
/// are evaluated with 8 roundings each, and t is known to 3.
inline constexpr double distance_rounding = 1024 * std::numeric_limits<double>::epsilon();

}  // namespace inbetween
