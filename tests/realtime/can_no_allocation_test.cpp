// The host's side of a CAN bus takes no memory: neither while drives are set up, nor in motion, nor when
// everything goes wrong.
#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "inbetween/can/cia402_bus.hpp"
#include "tests/realtime/armed_allocator.hpp"
#include "tests/support/simulated_can_rig.hpp"

namespace inbetween {
namespace can_no_allocation_test {

using can::DrivePhase;
using Kind = DriveTrouble::Kind;

constexpr std::size_t axes = 3;

/// A rig whose host, and nobody else, is watched.
class WatchedRig {
 public:
  void tick(const std::vector<std::int32_t>& targets) {
    rig.now_ns += SimulatedCanRig::tick_ns;
    std::array<can::Frame, can::Cia402Bus::frames_per_tick(axes)> frames;
    std::size_t count = 0;
    {
      const ArmedAllocator armed;
      count = rig.bus().tick(rig.now_ns, targets, frames).value();
      hits += armed.hits();
    }
    for (std::size_t i = 0; i < count; ++i) rig.wire.send(frames.at(i));
    const std::vector<can::Frame> heard = rig.wire.run(rig.now_ns);
    const ArmedAllocator armed;
    for (const can::Frame& frame : heard) rig.bus().receive(frame, rig.now_ns);
    hits += armed.hits();
  }
  bool tick_until(DrivePhase phase) {
    for (int i = 0; i < 2500 && !rig.all_are(phase); ++i) tick({});
    return rig.all_are(phase);
  }

  SimulatedCanRig rig{axes};
  std::size_t hits = 0;
};

TEST(NoAllocationOnTheCanBus, FromTheFirstFrameToTheLastFault) {
  WatchedRig watched;
  watched.rig.connect();
  ASSERT_TRUE(watched.tick_until(DrivePhase::idle));
  ASSERT_TRUE(watched.rig.enable());
  ASSERT_TRUE(watched.tick_until(DrivePhase::following));
  std::vector<std::int32_t> targets{1000, 2000, 3000};
  for (int i = 0; i < 5000; ++i) {
    for (std::int32_t& target : targets) target += 10;
    watched.tick(targets);
  }
  std::int64_t at_ns = watched.rig.now_ns;
  for (const DriveTrouble& trouble :
       {DriveTrouble{.kind = Kind::lose_feedback, .for_ns = 20'000'000},
        DriveTrouble{.kind = Kind::wrong_mode}, DriveTrouble{.kind = Kind::emergency, .value = 0x2310},
        DriveTrouble{.kind = Kind::reboot}}) {
    DriveTrouble now = trouble;
    now.at_ns = at_ns += 100'000'000;
    watched.rig.drive(1).add_trouble(now);
  }
  watched.rig.wire.inject({.id = 0x201, .length = 6});
  for (int i = 0; i < 500; ++i) watched.tick(targets);
  EXPECT_EQ(watched.rig.host_of(1).phase(), DrivePhase::gone);
  EXPECT_EQ(watched.hits, 0U);
}

}  // namespace can_no_allocation_test
}  // namespace inbetween
