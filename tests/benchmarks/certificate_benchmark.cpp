#include <benchmark/benchmark.h>

#include <random>
#include <stdexcept>
#include <vector>

#include "host_tools/solved_track.hpp"
#include "inbetween/motion_bounds.hpp"

/// What it costs to prove the peaks of a move.

namespace inbetween {
namespace {

void prove(benchmark::State& state, std::size_t keys, std::size_t axes, std::size_t values,
           std::int32_t frames) {
  std::mt19937 random(1989);
  std::uniform_real_distribution<double> coordinate(0.0, 100.0);
  std::uniform_real_distribution<double> height(1.0, 20.0);
  std::vector<double> at(keys * axes);
  for (double& value : at) value = coordinate(random);
  std::vector<double> speed(values);
  for (double& value : speed) value = height(random);
  const TrackSpec<double> spec{.path = {.axis_count = static_cast<std::int32_t>(axes), .keys = at},
                               .control_values = speed,
                               .frames = frames,
                               .fps = {24, 1},
                               .arc_length = {}};
  const SolvedTrack<double> solution(spec, Solver::closed_form);
  std::vector<AxisTurn<double>> turns(axes);
  const std::vector<PeakSlack<double>> slack(axes);
  std::vector<AxisPeaks<double>> peaks(axes);
  for (auto _ : state) {
    if (!bound_motion<double>(solution.track(), slack, {turns}, peaks))
      throw std::runtime_error("not bounded");
    benchmark::DoNotOptimize(peaks.data());
  }
}

void certificate_example(benchmark::State& state) {
  prove(state, 8, 3, 7, 240);
}
BENCHMARK(certificate_example)->Name("certificate/example")->Unit(benchmark::kMicrosecond);

void certificate_large(benchmark::State& state) {
  prove(state, 100, 16, 64, 2400);
}
BENCHMARK(certificate_large)->Name("certificate/100x16")->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace inbetween

BENCHMARK_MAIN();
