#include "drivers/linux/telemetry_ring.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <thread>

namespace inbetween {
namespace telemetry_ring_test {

/// Wide enough that a record which is read while it is written shows.
struct Sample {
  std::uint64_t tick = 0;
  std::uint64_t twice = 0;
  std::uint64_t inverse = 0;
};

Sample sample_of(std::uint64_t tick) {
  return {.tick = tick, .twice = 2 * tick, .inverse = ~tick};
}

bool is_whole(const Sample& sample) {
  return sample.twice == 2 * sample.tick && sample.inverse == ~sample.tick;
}

TEST(TelemetryRing, GivesRecordsInTheirOrderAndThenNone) {
  TelemetryRing<int, 4> ring;
  EXPECT_EQ(ring.pop(), std::nullopt);
  EXPECT_TRUE(ring.push(7));
  EXPECT_TRUE(ring.push(8));
  EXPECT_EQ(ring.pop(), 7);
  EXPECT_EQ(ring.pop(), 8);
  EXPECT_EQ(ring.pop(), std::nullopt);
}

TEST(TelemetryRing, TakesItsWholeCapacityAndCountsWhatFindsItFull) {
  TelemetryRing<int, 4> ring;
  for (int record = 0; record < 4; ++record) EXPECT_TRUE(ring.push(record));
  EXPECT_EQ(ring.dropped(), 0U);
  EXPECT_FALSE(ring.push(4));
  EXPECT_FALSE(ring.push(5));
  EXPECT_EQ(ring.dropped(), 2U);
  EXPECT_EQ(ring.pop(), 0);
  EXPECT_TRUE(ring.push(6));  // there is room again, and what was dropped stays dropped
  for (const int expected : {1, 2, 3, 6}) EXPECT_EQ(ring.pop(), expected);
  EXPECT_EQ(ring.pop(), std::nullopt);
}

TEST(TelemetryRing, GoesRoundManyTimes) {
  TelemetryRing<int, 2> ring;
  for (int record = 0; record < 1000; ++record) {
    EXPECT_TRUE(ring.push(record));
    EXPECT_EQ(ring.pop(), record);
  }
  EXPECT_EQ(ring.dropped(), 0U);
}

TEST(TelemetryRing, BetweenTwoThreadsEveryRecordArrivesWholeAndInOrderOrIsCounted) {
  constexpr std::uint64_t ticks = 200'000;
  const auto ring = std::make_unique<TelemetryRing<Sample, 64>>();
  std::atomic<bool> has_ended{false};
  std::thread loop([&] {
    for (std::uint64_t tick = 1; tick <= ticks; ++tick) {
      ring->push(sample_of(tick));
      if (tick % 64 == 0) std::this_thread::yield();  // so that one processor sees both ends too
    }
    has_ended.store(true);
  });
  std::uint64_t received = 0;
  std::uint64_t torn = 0;
  std::uint64_t out_of_order = 0;
  std::uint64_t last = 0;
  for (bool is_last_look = false;;) {
    if (const std::optional<Sample> sample = ring->pop()) {
      ++received;
      if (!is_whole(*sample)) ++torn;
      if (sample->tick <= last) ++out_of_order;
      last = sample->tick;
    } else if (is_last_look) {
      break;
    } else {
      is_last_look = has_ended.load();
      std::this_thread::yield();
    }
  }
  loop.join();
  EXPECT_EQ(received + ring->dropped(), ticks);
  EXPECT_EQ(torn, 0U);
  EXPECT_EQ(out_of_order, 0U);
  EXPECT_GT(received, 0U);
}

}  // namespace telemetry_ring_test
}  // namespace inbetween
