// How late a loop wakes up for its ticks, counted while it runs.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host_tools/text/json_writer.hpp"

namespace inbetween {

/// Microseconds between a tick's deadline and the moment when the loop woke up for it.
struct WakeLatency {
  double p50_us = 0, p99_us = 0, p99_9_us = 0, max_us = 0;
  double max_at_s = 0;  ///< when it was the worst, counted from the first tick
  struct Bucket {
    double below_us = 0;  ///< and not below half of that, but for the first
    std::int64_t ticks = 0;
  };
  std::vector<Bucket> histogram;  ///< from the first octave that has any to the last
};

/// The member "wake_latency_us".
void write_json(const WakeLatency& latency, JsonWriter& json);

/// Counts latencies in buckets less than 1 % wide: 60 kB, however long the loop runs, and no allocation.
class WakeLatencyCounter {
 public:
  /// O(1). `latency_ns` >= 0, of a tick at `now_ns` of any clock that goes forward.
  void add(std::int64_t latency_ns, std::int64_t now_ns);

  /// A percentile is the upper end of its bucket: never less than the true one, at most 1 % more. The
  /// maximum is exact. All 0 when nothing was counted. Allocates the histogram.
  [[nodiscard]] WakeLatency summary() const;

 private:
  static constexpr std::size_t buckets_per_octave = 128;

  [[nodiscard]] std::vector<WakeLatency::Bucket> histogram() const;
  [[nodiscard]] std::int64_t percentile_ns(double share) const;

  std::array<std::int64_t, buckets_per_octave * 57> counts_{};
  std::int64_t total_ = 0;
  std::int64_t max_ns_ = 0;
  std::int64_t first_at_ns_ = 0;
  std::int64_t max_at_ns_ = 0;
};

}  // namespace inbetween
