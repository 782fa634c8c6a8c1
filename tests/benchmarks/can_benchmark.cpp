#include <benchmark/benchmark.h>

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "inbetween/can/cia402.hpp"
#include "inbetween/can/cia402_bus.hpp"
#include "tests/support/drive_frames.hpp"
#include "tests/support/simulated_can_rig.hpp"

/// A tick of the host's side of a CAN bus: what the drives have told is taken, what they are to do is
/// written.

namespace inbetween {
namespace {

void can_tick(benchmark::State& state) {
  const auto axes = static_cast<std::size_t>(state.range(0));
  SimulatedCanRig rig(axes);
  if (!rig.bring_to_following()) throw std::runtime_error("not switched on");
  std::vector<can::Frame> told;
  std::vector<std::int32_t> targets;
  for (const can::Cia402Drive& host : rig.hosts) {
    told.push_back(
        can::feedback_frame(host.node(), {.statusword = 0x1237, .actual = host.target(), .mode = 8}));
    told.push_back(can::heartbeat_frame(host.node(), can::NmtState::operational));
    targets.push_back(host.target());
  }
  std::vector<can::Frame> frames(can::Cia402Bus::frames_per_tick(axes));
  for ([[maybe_unused]] auto _ : state) {
    rig.now_ns += SimulatedCanRig::tick_ns;
    for (std::int32_t& target : targets) target ^= 1;
    benchmark::DoNotOptimize(rig.bus().tick(rig.now_ns, targets, frames).value());
    for (const can::Frame& frame : told) rig.bus().receive(frame, rig.now_ns);
    benchmark::ClobberMemory();
  }
  if (!rig.all_are(can::DrivePhase::following)) throw std::runtime_error("not following any more");
}
BENCHMARK(can_tick)->Arg(3)->Arg(8);

}  // namespace
}  // namespace inbetween

BENCHMARK_MAIN();
