#include "host_tools/wake_latency.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace inbetween {
namespace {

/// Latencies below twice the buckets of an octave have a bucket each; above, the bits below the 8 leading
/// ones are dropped.
constexpr int leading_bits = 8;

int dropped_bits(std::uint64_t latency_ns) {
  return std::max(static_cast<int>(std::bit_width(latency_ns)) - leading_bits, 0);
}

}  // namespace

void WakeLatencyCounter::add(std::int64_t latency_ns) {
  const auto latency = static_cast<std::uint64_t>(latency_ns);
  const int dropped = dropped_bits(latency);
  ++counts_[buckets_per_octave * static_cast<std::size_t>(dropped) + (latency >> dropped)];
  ++total_;
  max_ns_ = std::max(max_ns_, latency_ns);
}

std::int64_t WakeLatencyCounter::percentile_ns(double share) const {
  const auto wanted = static_cast<std::int64_t>(std::ceil(share * static_cast<double>(total_)));
  std::int64_t passed = 0;
  for (std::size_t bucket = 0; bucket < counts_.size(); ++bucket) {
    passed += counts_[bucket];
    if (passed < wanted) continue;
    const std::size_t dropped = bucket / buckets_per_octave > 1 ? bucket / buckets_per_octave - 1 : 0;
    const std::size_t leading = bucket - dropped * buckets_per_octave;
    const auto end = static_cast<std::int64_t>(((leading + 1) << dropped) - 1);
    return std::min(end, max_ns_);
  }
  return max_ns_;
}

WakeLatency WakeLatencyCounter::summary() const {
  const auto us = [](std::int64_t ns) { return static_cast<double>(ns) * 1e-3; };
  return {us(percentile_ns(0.5)), us(percentile_ns(0.99)), us(percentile_ns(0.999)), us(max_ns_)};
}

}  // namespace inbetween
