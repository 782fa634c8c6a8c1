// The limits of a loop without the rights of a real-time program (SessionOptions::allow_jitter).
#pragma once

namespace inbetween {

/// The share of its velocity that an axis may have then: faster, a late tick could make it jump.
inline constexpr double jitter_share = 0.1;

}  // namespace inbetween
