// When ticks are, in whole nanoseconds.
#pragma once

#include <cstdint>

namespace inbetween {

inline constexpr std::int64_t ns_per_s = 1'000'000'000;

/// From tick 0 to tick `tick`, rounded down: nothing adds up where a tick is no whole number of nanoseconds.
constexpr std::int64_t time_of_tick(std::int64_t tick, std::int32_t rate_hz) {
  return tick / rate_hz * ns_per_s + tick % rate_hz * ns_per_s / rate_hz;
}

}  // namespace inbetween
