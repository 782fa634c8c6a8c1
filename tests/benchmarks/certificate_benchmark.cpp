#include <benchmark/benchmark.h>

#include <stdexcept>
#include <vector>

#include "inbetween/limits/limits.hpp"
#include "inbetween/limits/motion_bounds.hpp"
#include "inbetween/limits/move.hpp"
#include "inbetween/limits/stop_bounds.hpp"
#include "tests/benchmarks/solved_subject.hpp"

/// What it costs to prove the peaks of a move, and that it can be stopped everywhere.

namespace inbetween {
namespace {

void prove(benchmark::State& state, const MoveSize& size) {
  const SolvedTrack<double> solution = solved_track(size);
  std::vector<AxisTurn<double>> turns(size.axes);
  const std::vector<MotionTriple<double>> slack(size.axes);
  std::vector<AxisPeaks<double>> peaks(size.axes);
  for (auto _ : state) {
    if (!bound_motion<double>(solution.track(), slack, {turns}, peaks))
      throw std::runtime_error("not bounded");
    benchmark::DoNotOptimize(peaks.data());
  }
}
BENCHMARK_CAPTURE(prove, example, example)->Name("certificate/example")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(prove, large, large)->Name("certificate/100x16")->Unit(benchmark::kMicrosecond);

/// In as many cells as a program takes for so many frames, on a rig whose limits are a quarter above the
/// peaks.
void bound_stops(benchmark::State& state, const MoveSize& size) {
  const SolvedTrack<double> solution = solved_track(size);
  const Move<double> move = Move<double>::make({&solution.track(), 1}, {}).value();
  std::vector<AxisTurn<double>> turns(size.axes);
  std::vector<MotionTriple<double>> slack(size.axes);
  std::vector<AxisPeaks<double>> peaks(size.axes);
  if (!bound_motion<double>(solution.track(), slack, {turns}, peaks)) throw std::runtime_error("not bounded");
  std::vector<AxisLimits<double>> limits;
  for (const AxisPeaks<double>& axis : peaks) {
    limits.push_back(AxisLimits<double>::make({.min = -1e4,
                                               .max = 1e4,
                                               .max_velocity = 1.25 * axis.velocity.value,
                                               .max_acceleration = 1.25 * axis.acceleration.value,
                                               .max_jerk = 1.25 * axis.jerk.value})
                         .value());
  }
  const auto cells = static_cast<std::size_t>(size.frames);
  std::vector<StopCell<double>> kept(cells + 1);
  std::vector<MotionTriple<double>> suprema(cells * size.axes);
  for (auto _ : state) {
    const auto bounds =
        StopBounds<double>::make({.move = move, .limits = limits}, {kept, suprema, slack, turns}, {});
    if (!bounds) throw std::runtime_error(bounds.error().what);
    benchmark::DoNotOptimize(kept.data());
  }
}
BENCHMARK_CAPTURE(bound_stops, example, example)->Name("stop_bounds/example")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(bound_stops, large, large)->Name("stop_bounds/100x16")->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace inbetween

BENCHMARK_MAIN();
