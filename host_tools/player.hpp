// Ticks on a clock, keys from a terminal, and what is shown meanwhile.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "drivers/linux/monotonic_clock.hpp"
#include "host_tools/run.hpp"
#include "host_tools/transport_keys.hpp"
#include "host_tools/wake_latency.hpp"

namespace inbetween {

/// Ticks on a clock, with keys from a terminal. Each tick is waited for. One that comes a whole period late
/// or more delays those after it: time stands still for the rig meanwhile, and there is no burst.
template <class Clock>
class Player {
 public:
  Player(const RunOptions& options, std::int32_t rate_hz, RunReport& report)
      : options_(options), rate_hz_(rate_hz), report_(report) {}

  /// Until it is done or somebody has left, and as long as the drives take to arrive. Progress is told where
  /// the last tick is known. Returns how many ticks that were.
  template <class Performance>
  std::int64_t play(Performance& performance, std::optional<std::int64_t> last) {
    std::int64_t start_ns = clock_.now_ns();
    std::int64_t ticks = 0;
    const auto is_over = [&] { return performance.is_done() || performance.keys().has_left(); };
    // In one more tick than it takes to rest the drives arrive.
    for (std::int64_t tick = 0, ticks_at_rest = 0; ticks_at_rest < 2; ++tick) {
      wait_for(tick, start_ns);
      press_keys(performance);
      if (tick > 0) performance.tick(clock_.now_ns());
      if (is_over()) {
        ++ticks_at_rest;
      } else {
        ticks = tick + 2;
      }
      show(performance, tick, last);
    }
    return ticks;
  }
  [[nodiscard]] WakeLatency latencies() const { return latencies_.summary(); }

 private:
  static constexpr std::int64_t ns_per_s = 1'000'000'000;

  void wait_for(std::int64_t tick, std::int64_t& start_ns) {
    const std::int64_t deadline_ns =
        start_ns + tick / rate_hz_ * ns_per_s + tick % rate_hz_ * ns_per_s / rate_hz_;
    clock_.sleep_until_ns(deadline_ns);
    const std::int64_t latency_ns = clock_.now_ns() - deadline_ns;
    latencies_.add(latency_ns);
    if (latency_ns < ns_per_s / rate_hz_) return;
    ++report_.late_ticks;
    start_ns += latency_ns;
  }
  template <class Performance>
  void press_keys(Performance& performance) {
    if (options_.keys) keys_.feed(options_.keys());
    while (const std::optional<TransportKey> key = keys_.next()) performance.press(*key);
    if (options_.interrupted && options_.interrupted()) performance.press(TransportKey::quit);
  }
  template <class Performance>
  void show(const Performance& performance, std::int64_t tick, std::optional<std::int64_t> last) {
    const bool looks_at_clock = tick % 64 == 0 || !options_.fast;
    if (!looks_at_clock || wall_.now_ns() < next_show_ns_) return;
    if (options_.progress && last) options_.progress(std::min(tick, *last), *last);
    if (options_.status) options_.status(performance.snapshot());
    next_show_ns_ = wall_.now_ns() + ns_per_s / 10;
  }

  const RunOptions& options_;
  std::int32_t rate_hz_;
  RunReport& report_;
  Clock clock_;
  MonotonicClock wall_;
  TransportKeys keys_;
  WakeLatencyCounter latencies_;
  std::int64_t next_show_ns_ = 0;
};

}  // namespace inbetween
