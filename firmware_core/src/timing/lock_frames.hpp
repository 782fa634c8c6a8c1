#pragma once

#include <cstddef>
#include <span>

#include "inbetween/timing/key_timing.hpp"

/// The frames of the locked keys, before any curve is changed.

namespace inbetween {

/// Writes every request with its frame, between the two ends of the move, and returns how many there are.
/// A hold without a frame begins where the drawn curve arrives, played between the locks with a frame on
/// either side in the frames that are no holds.
/// Errors: those of adjust_to_locks that need no curve. `out` has room for two locks more than the requests,
/// `arrivals`, which serve in between, for as many. Cost: linear in control values and requests.
Result<std::size_t> complete_locks(const KeyTimingSpec& spec, std::span<KeyLock> out,
                                   std::span<double> arrivals);

}  // namespace inbetween
