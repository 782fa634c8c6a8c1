// The step generator and the merging of its edges take no memory: neither in motion, nor at a turn, nor when
// a setpoint is refused.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "inbetween/steps/step_generator.hpp"
#include "inbetween/steps/step_merge.hpp"
#include "tests/realtime/armed_allocator.hpp"

namespace inbetween {
namespace step_no_allocation_test {

TEST(NoAllocationOfTheStepGenerator, FromTheFirstStepToARefusal) {
  constexpr std::size_t axes = 3;
  constexpr StepTiming timing{.pulse_ns = 2500, .pause_ns = 2500, .dir_setup_ns = 5000, .dir_hold_ns = 5000};
  constexpr StepSpec spec{
      .steps_per_unit = 100, .timing = timing, .max_step_rate = 50'000, .tick_ns = 1'000'000};
  std::vector<StepEdge> memory(axes * StepGenerator::make(spec).value().max_edges());
  std::vector<EdgeInstant> instants(memory.size());
  const std::array<StepLines, axes> lines{{{0, 1, timing}, {2, 3, timing}, {4, 5, timing}}};

  const ArmedAllocator armed;
  std::array<StepGenerator, axes> generators{StepGenerator::make(spec).value(),
                                             StepGenerator::make(spec).value(),
                                             StepGenerator::make(spec).value()};
  const StepMerge merge = StepMerge::make(lines, 2000).value();
  std::array<std::span<const StepEdge>, axes> edges;
  const std::size_t room = memory.size() / axes;
  std::size_t instant_count = 0;
  for (int tick = 0; tick < 2000; ++tick) {
    for (std::size_t i = 0; i < axes; ++i) {
      const double phase = 0.01 * tick * static_cast<double>(i + 1);
      const Setpoint end{.position = std::sin(phase), .velocity = 0, .acceleration = 0};
      const std::span<StepEdge> out = std::span(memory).subspan(i * room, room);
      edges[i] = out.first(generators[i].advance(end, out).value());
    }
    instant_count += merge.merge(tick * spec.tick_ns, edges, instants).value();
  }
  const bool is_refused = !generators[0].advance({.position = 1000}, memory);
  const std::size_t hits = armed.hits();
  EXPECT_EQ(hits, 0U);
  EXPECT_TRUE(is_refused);
  EXPECT_GT(instant_count, 2000U);
}

}  // namespace step_no_allocation_test
}  // namespace inbetween
