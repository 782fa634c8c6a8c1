#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iostream>
#include <span>
#include <vector>

#include "inbetween/steps/step_merge.hpp"
#include "sim/simulated_stepper.hpp"
#include "tests/support/property.hpp"
#include "tests/support/random_steps.hpp"
#include "tests/support/step_run.hpp"

namespace inbetween {
namespace step_merge_property_test {

/// One of the axes of a chip, and whether what the chip does is what its generator asked for.
class Axis {
 public:
  Axis(const StepSpec& spec, std::int32_t step_line)
      : lines({.step = step_line, .dir = step_line - 1, .timing = spec.timing}),
        run_(spec),
        stepper_(SimulatedStepper::make(settings(spec), 0).value()) {}

  /// Its edges of the next tick.
  std::span<const StepEdge> tick(std::int64_t start_ns) {
    const Setpoint next = random_next(at_, run_.generator.spec());
    start_ns_ = start_ns;
    next_ = 0;
    edges_ = {};
    if (run_.tick(next)) {
      at_ = next;
      edges_ = run_.last_tick;
    }
    return edges_;
  }
  void take(const EdgeInstant& instant, std::int64_t grain_ns) {
    RC_ASSERT(stepper_.take(instant).has_value());
    const std::uint64_t step = std::uint64_t{1} << lines.step;
    const std::uint64_t dir = std::uint64_t{1} << lines.dir;
    if ((instant.mask & (step | dir)) == 0) return;
    RC_ASSERT(next_ < edges_.size());
    const StepEdge& edge = edges_[next_++];
    const std::uint64_t bit = edge.line == StepLine::step ? step : dir;
    RC_ASSERT((instant.mask & (step | dir)) == bit);
    RC_ASSERT(((instant.levels & bit) != 0) == edge.level);
    RC_ASSERT(instant.at_ns >= start_ns_ + edge.at_ns);
    RC_ASSERT(instant.at_ns <= start_ns_ + edge.at_ns + grain_ns);
  }
  void check() const {
    RC_ASSERT(next_ == edges_.size());
    RC_ASSERT(stepper_.violations() == StepViolations{});
    RC_ASSERT(stepper_.count() == run_.generator.count());
  }

  StepLines lines;

 private:
  [[nodiscard]] SimulatedStepper::Settings settings(const StepSpec& spec) const {
    SimulatedStepper::Settings settings;
    settings.lines = lines;
    settings.steps_per_unit = spec.steps_per_unit;
    return settings;
  }

  StepRun run_;
  SimulatedStepper stepper_;
  Setpoint at_;
  std::span<const StepEdge> edges_;
  std::int64_t start_ns_ = 0;
  std::size_t next_ = 0;
};

TEST(StepMergeProperties, EdgesKeepTheMinimaOfEveryAxisAndAreAtMostAGrainLate) {
  std::size_t edge_count = 0;
  std::size_t instant_count = 0;
  check_property(200, [&] {
    constexpr std::int64_t tick_ns = 1'000'000;
    const std::int64_t grain_ns = *rc::gen::element<std::int64_t>(0, 1000, 10'000, 50'000);
    std::vector<Axis> axes;
    std::vector<StepLines> lines;
    for (std::int32_t line = 63; line > 55; line -= 2) {
      StepSpec spec = random_spec();
      spec.tick_ns = tick_ns;
      spec.max_step_rate = std::min(spec.max_step_rate, 40e3);
      axes.emplace_back(spec, line);
      lines.push_back(axes.back().lines);
    }
    const StepMerge merge = StepMerge::make(lines, grain_ns).value();
    std::vector<EdgeInstant> memory(4000);
    std::int64_t last_ns = -1;
    for (int tick = 0; tick < 25; ++tick) {
      const std::int64_t start_ns = tick * tick_ns;
      std::vector<std::span<const StepEdge>> edges;
      for (Axis& axis : axes) {
        edges.push_back(axis.tick(start_ns));
        edge_count += edges.back().size();
      }
      const std::size_t size = merge.merge(start_ns, edges, memory).value();
      instant_count += size;
      for (const EdgeInstant& instant : std::span(memory).first(size)) {
        RC_ASSERT(instant.at_ns > last_ns);
        RC_ASSERT(instant.at_ns < start_ns + tick_ns);
        RC_ASSERT(instant.mask != 0U);
        RC_ASSERT((instant.levels & ~instant.mask) == 0U);
        last_ns = instant.at_ns;
        for (Axis& axis : axes) axis.take(instant, grain_ns);
      }
      for (const Axis& axis : axes) axis.check();
    }
  });
  std::cout << edge_count << " edges in " << instant_count << " instants\n";
  if (counts_mean_something()) {
    EXPECT_LT(instant_count * 100, edge_count * 99);
  }
}

}  // namespace step_merge_property_test
}  // namespace inbetween
