// How late a loop wakes up for its ticks, counted while it runs.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace inbetween {

/// Microseconds between a tick's deadline and the moment when the loop woke up for it.
struct WakeLatency {
  double p50_us = 0, p99_us = 0, p99_9_us = 0, max_us = 0;
};

/// Counts latencies in buckets less than 1 % wide: 60 kB, however long the loop runs, and no allocation.
class WakeLatencyCounter {
 public:
  /// O(1). `latency_ns` >= 0.
  void add(std::int64_t latency_ns);

  /// A percentile is the upper end of its bucket: never less than the true one, at most 1 % more. The
  /// maximum is exact. All 0 when nothing was counted.
  [[nodiscard]] WakeLatency summary() const;

 private:
  static constexpr std::size_t buckets_per_octave = 128;

  [[nodiscard]] std::int64_t percentile_ns(double share) const;

  std::array<std::int64_t, buckets_per_octave * 57> counts_{};
  std::int64_t total_ = 0;
  std::int64_t max_ns_ = 0;
};

}  // namespace inbetween
