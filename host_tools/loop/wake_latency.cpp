#include "host_tools/loop/wake_latency.hpp"

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

void write_json(const WakeLatency& latency, JsonWriter& json) {
  json.object("wake_latency_us", [&] {
    json.member("p50", latency.p50_us);
    json.member("p99", latency.p99_us);
    json.member("p99_9", latency.p99_9_us);
    json.member("max", latency.max_us);
    json.member("max_at_s", latency.max_at_s);
    json.objects("histogram", latency.histogram, [&](const WakeLatency::Bucket& bucket) {
      json.member("below_us", bucket.below_us);
      json.member("ticks", bucket.ticks);
    });
  });
}

void WakeLatencyCounter::add(std::int64_t latency_ns, std::int64_t now_ns) {
  const auto latency = static_cast<std::uint64_t>(latency_ns);
  const int dropped = dropped_bits(latency);
  ++counts_[buckets_per_octave * static_cast<std::size_t>(dropped) + (latency >> dropped)];
  if (total_++ == 0) first_at_ns_ = now_ns;
  if (latency_ns < max_ns_) return;
  max_ns_ = latency_ns;
  max_at_ns_ = now_ns;
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

std::vector<WakeLatency::Bucket> WakeLatencyCounter::histogram() const {
  // Up to 255 ns a bucket is one nanosecond wide; from there on 128 are an octave.
  constexpr std::size_t first_octave = 2 * buckets_per_octave;
  std::vector<WakeLatency::Bucket> octaves;
  std::size_t begin = 0;
  double below_us = static_cast<double>(first_octave) * 1e-3;
  for (std::size_t end = first_octave; end <= counts_.size(); end += buckets_per_octave, below_us *= 2) {
    WakeLatency::Bucket octave{.below_us = below_us};
    for (; begin < end; ++begin) octave.ticks += counts_[begin];
    if (octave.ticks > 0 || !octaves.empty()) octaves.push_back(octave);
  }
  while (!octaves.empty() && octaves.back().ticks == 0) octaves.pop_back();
  return octaves;
}

WakeLatency WakeLatencyCounter::summary() const {
  const auto us = [](std::int64_t ns) { return static_cast<double>(ns) * 1e-3; };
  return {us(percentile_ns(0.5)),
          us(percentile_ns(0.99)),
          us(percentile_ns(0.999)),
          us(max_ns_),
          static_cast<double>(max_at_ns_ - first_at_ns_) * 1e-9,
          histogram()};
}

}  // namespace inbetween
