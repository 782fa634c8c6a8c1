#include "host_tools/wake_latency.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

namespace inbetween {
namespace {

TEST(WakeLatency, IsZeroWhereNothingWasCounted) {
  const WakeLatency summary = WakeLatencyCounter().summary();
  EXPECT_EQ(summary.p50_us, 0);
  EXPECT_EQ(summary.max_us, 0);
}

TEST(WakeLatency, OneTickIsEveryPercentile) {
  WakeLatencyCounter counter;
  counter.add(123'456'789);
  const WakeLatency summary = counter.summary();
  for (const double us : {summary.p50_us, summary.p99_us, summary.p99_9_us, summary.max_us}) {
    EXPECT_DOUBLE_EQ(us, 123'456.789);
  }
}

TEST(WakeLatency, CountsFromZeroToTheLongestTimeThereIs) {
  WakeLatencyCounter counter;
  counter.add(0);
  counter.add(0);
  counter.add(std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(counter.summary().p50_us, 0);
  EXPECT_DOUBLE_EQ(counter.summary().max_us, 9.223372036854775807e15);
}

/// Against sorting all of them.
TEST(WakeLatency, APercentileIsNeverTooSmallAndAtMostOnePercentTooLarge) {
  std::mt19937_64 random(1989);
  std::lognormal_distribution<double> latency(10, 3);  // median 22 us, some of seconds
  WakeLatencyCounter counter;
  std::vector<std::int64_t> all;
  for (int i = 0; i < 12'345; ++i) {
    all.push_back(static_cast<std::int64_t>(latency(random)));
    counter.add(all.back());
  }
  std::sort(all.begin(), all.end());
  const auto expect = [&](double us, double share) {
    const auto index = static_cast<std::size_t>(std::ceil(share * static_cast<double>(all.size()))) - 1;
    const double exact_us = static_cast<double>(all[index]) * 1e-3;
    EXPECT_GE(us, exact_us);
    EXPECT_LE(us, exact_us * 1.01);
  };
  const WakeLatency summary = counter.summary();
  expect(summary.p50_us, 0.5);
  expect(summary.p99_us, 0.99);
  expect(summary.p99_9_us, 0.999);
  EXPECT_DOUBLE_EQ(summary.max_us, static_cast<double>(all.back()) * 1e-3);
}

}  // namespace
}  // namespace inbetween
