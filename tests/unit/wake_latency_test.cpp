#include "host_tools/loop/wake_latency.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

namespace inbetween {
namespace wake_latency_test {

TEST(WakeLatency, IsZeroWhereNothingWasCounted) {
  const WakeLatency summary = WakeLatencyCounter().summary();
  EXPECT_EQ(summary.p50_us, 0);
  EXPECT_EQ(summary.max_us, 0);
}

TEST(WakeLatency, OneTickIsEveryPercentile) {
  WakeLatencyCounter counter;
  counter.add(123'456'789, 77);
  const WakeLatency summary = counter.summary();
  for (const double us : {summary.p50_us, summary.p99_us, summary.p99_9_us, summary.max_us}) {
    EXPECT_DOUBLE_EQ(us, 123'456.789);
  }
}

TEST(WakeLatency, CountsFromZeroToTheLongestTimeThereIs) {
  WakeLatencyCounter counter;
  counter.add(0, 0);
  counter.add(0, 1);
  counter.add(std::numeric_limits<std::int64_t>::max(), 2);
  EXPECT_EQ(counter.summary().p50_us, 0);
  EXPECT_DOUBLE_EQ(counter.summary().max_us, 9.223372036854775807e15);
  const std::vector<WakeLatency::Bucket> octaves = counter.summary().histogram;
  EXPECT_EQ(octaves.front().ticks, 2);
  EXPECT_EQ(octaves.back().ticks, 1) << "below " << octaves.back().below_us << " us";
}

/// Against sorting all of them.
TEST(WakeLatency, APercentileIsNeverTooSmallAndAtMostOnePercentTooLarge) {
  std::mt19937_64 random(1989);
  std::lognormal_distribution<double> latency(10, 3);  // median 22 us, some of seconds
  WakeLatencyCounter counter;
  std::vector<std::int64_t> all;
  for (int i = 0; i < 12'345; ++i) {
    all.push_back(static_cast<std::int64_t>(latency(random)));
    counter.add(all.back(), i);
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

TEST(WakeLatency, TellsWhenItWasTheWorst) {
  WakeLatencyCounter counter;
  counter.add(2'000, 1'000'000'000);
  counter.add(50'000, 3'500'000'000);
  counter.add(9'000, 4'000'000'000);
  EXPECT_DOUBLE_EQ(counter.summary().max_at_s, 2.5);
}

TEST(WakeLatency, ItsHistogramHasAnOctaveALineAndEveryTick) {
  WakeLatencyCounter counter;
  for (const std::int64_t ns : {600, 1'000, 1'024, 1'030, 2'047, 2'048, 9'000}) counter.add(ns, ns);
  const std::vector<WakeLatency::Bucket> octaves = counter.summary().histogram;
  ASSERT_EQ(octaves.size(), 5U);
  const std::array<double, 5> below_us{1.024, 2.048, 4.096, 8.192, 16.384};
  const std::array<std::int64_t, 5> ticks{2, 3, 1, 0, 1};
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_DOUBLE_EQ(octaves[i].below_us, below_us[i]);
    EXPECT_EQ(octaves[i].ticks, ticks[i]);
  }
  EXPECT_TRUE(WakeLatencyCounter().summary().histogram.empty());
}

}  // namespace wake_latency_test
}  // namespace inbetween
