#include <benchmark/benchmark.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <stdexcept>
#include <vector>

#include "inbetween/steps/step_generator.hpp"
#include "inbetween/steps/step_merge.hpp"

/// A tick of STEP/DIR axes: the edges of each, and the instants of their chip. Two figures matter: the time
/// of a tick, and the time of a step (its two edges), which is the inverse of what is printed as steps/s.

namespace inbetween {
namespace {

constexpr std::int64_t tick_ns = 1'000'000;
constexpr StepTiming timing{.pulse_ns = 2500, .pause_ns = 2500, .dir_setup_ns = 5000, .dir_hold_ns = 5000};

/// Axes that swing, each a little later than the one before, at up to `rate` steps/s.
class SwingingAxes {
 public:
  SwingingAxes(std::size_t axes, double rate) : rate_(rate) {
    std::vector<StepLines> lines;
    for (std::size_t i = 0; i < axes; ++i) {
      const StepSpec spec{
          .steps_per_unit = 1, .timing = timing, .max_step_rate = 100'000, .tick_ns = tick_ns};
      generators_.push_back(StepGenerator::make(spec).value());
      memory_.emplace_back(generators_.back().max_edges());
      const auto first = static_cast<std::int32_t>(2 * i);
      lines.push_back({.step = first, .dir = first + 1, .timing = timing});
    }
    edges_.resize(axes);
    instants_.resize(axes * memory_[0].size());
    merge_.push_back(StepMerge::make(lines).value());
    for (std::size_t tick = 0; tick < ticks_per_swing; ++tick) {
      for (std::size_t i = 0; i < axes; ++i) setpoints_.push_back(at(tick, i));
    }
    for (std::size_t i = 0; i < axes; ++i) {
      if (!generators_[i].place(at(ticks_per_swing - 1, i).position)) throw std::runtime_error("not placed");
    }
  }

  /// Returns how many edges.
  std::size_t tick() {
    std::size_t edge_count = 0;
    for (std::size_t i = 0; i < generators_.size(); ++i) {
      const Setpoint& end = setpoints_[tick_ * generators_.size() + i];
      const std::size_t size = generators_[i].advance(end, memory_[i]).value();
      edges_[i] = std::span<const StepEdge>(memory_[i]).first(size);
      edge_count += size;
    }
    tick_ = (tick_ + 1) % ticks_per_swing;
    return edge_count;
  }
  std::size_t merge() { return merge_[0].merge(0, edges_, instants_).value(); }

 private:
  static constexpr std::size_t ticks_per_swing = 1000;

  [[nodiscard]] Setpoint at(std::size_t tick, std::size_t axis) const {
    const double omega = 2 * std::numbers::pi;  // a swing a second
    const double phase =
        omega * static_cast<double>(tick) / ticks_per_swing - 0.3 * static_cast<double>(axis);
    return {static_cast<double>(rate_ / omega * std::sin(phase)),
            static_cast<double>(rate_ * std::cos(phase)),
            static_cast<double>(-rate_ * omega * std::sin(phase))};
  }

  double rate_;
  std::size_t tick_ = 0;
  std::vector<StepGenerator> generators_;
  std::vector<std::vector<StepEdge>> memory_;
  std::vector<std::span<const StepEdge>> edges_;
  std::vector<EdgeInstant> instants_;
  std::vector<StepMerge> merge_;
  std::vector<Setpoint> setpoints_;
};

template <bool Merges>
void step_tick(benchmark::State& state) {
  SwingingAxes axes(static_cast<std::size_t>(state.range(0)), static_cast<double>(state.range(1)));
  std::size_t edges = 0;
  for ([[maybe_unused]] auto _ : state) {
    edges += axes.tick();
    if constexpr (Merges) benchmark::DoNotOptimize(axes.merge());
    benchmark::ClobberMemory();
  }
  state.counters["steps"] = benchmark::Counter(static_cast<double>(edges) / 2, benchmark::Counter::kIsRate);
}
void generate(benchmark::State& state) {
  step_tick<false>(state);
}
void generate_and_merge(benchmark::State& state) {
  step_tick<true>(state);
}
BENCHMARK(generate)->ArgNames({"axes", "rate"})->ArgsProduct({{1, 8}, {0, 5000, 50'000}});
BENCHMARK(generate_and_merge)->ArgNames({"axes", "rate"})->ArgsProduct({{1, 8}, {0, 5000, 50'000}});

}  // namespace
}  // namespace inbetween

BENCHMARK_MAIN();
