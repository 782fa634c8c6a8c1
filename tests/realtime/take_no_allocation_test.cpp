// The loop's thread takes no memory for a take, whether the ring has room for a tick or not.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <string>

#include "host_tools/takes/take_recorder.hpp"
#include "host_tools/takes/take_store.hpp"
#include "tests/realtime/armed_allocator.hpp"
#include "tests/support/sixteen_axes.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace take_no_allocation_test {

TEST(TakeNoAllocation, TicksKeysAndPulsesOfSixteenAxesTakeNoMemory) {
  constexpr std::int64_t ticks = 30'000;
  const TemporaryFolder folder;
  const std::string file = folder.path() / "takes.db";
  sixteen_axes::TickedLoop rig;
  TakeRecorder recorder({.file = file, .pulse_words = [](std::size_t) { return "flash"; }}, rig.take());
  LoopTrace trace(sixteen_axes::axes, {nullptr, &recorder});
  std::size_t hits = 0;
  {
    const ArmedAllocator armed;
    // More quickly than any rig: the ring fills up, too.
    for (std::int64_t tick = 0; tick < ticks; ++tick) {
      rig.tick(trace);
      if (tick % 100 == 0) recorder.press(TransportKey::faster);
      if (tick % 100 == 50) recorder.pulse(0);
    }
    hits = armed.hits();
  }
  EXPECT_EQ(hits, 0U);
  EXPECT_TRUE(rig.is_running());
  const KeptTake kept = recorder.finish("", false);
  EXPECT_EQ(kept.ticks + kept.lost, ticks);
  EXPECT_GT(kept.ticks, 0);
  TakeStore store(file, TakeStore::Access::read);
  EXPECT_FALSE(store.read_head(1).events.empty());
}

}  // namespace take_no_allocation_test
}  // namespace inbetween
