#pragma once

#include <limits>

#include "inbetween/base/precision.hpp"

namespace inbetween {

/// Twice what a lock promises, as a share of the length: a place that the move comes to rest at within this
/// is met at rest.
template <Precise Real>
inline constexpr Real lock_share = std::numeric_limits<Real>::digits > 30 ? Real(2e-12) : Real(2e-5);

}  // namespace inbetween
