#include <benchmark/benchmark.h>

#include <stdexcept>
#include <utility>
#include <vector>

#include "host_tools/plan/bounded_move.hpp"
#include "inbetween/limits/limits.hpp"
#include "inbetween/limits/stop_bounds.hpp"
#include "tests/benchmarks/solved_subject.hpp"

/// What it costs to prove the peaks of a move, and with them that it can be stopped everywhere: the fit is in
/// both.

namespace inbetween {
namespace {

void prove(benchmark::State& state, const MoveSize& size) {
  const SolvedTrack solution = solved_track(size);
  const Move move = Move::make({&solution.track(), 1}, {}).value();
  for (auto _ : state) {
    const BoundedMove bounded(move, {&solution.track(), 1});
    benchmark::DoNotOptimize(bounded.peaks().data());
  }
}
BENCHMARK_CAPTURE(prove, example, example)->Name("certificate/example")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(prove, large, large)->Name("certificate/100x16")->Unit(benchmark::kMicrosecond);

/// In as many cells as a program takes for so many frames, on a rig whose limits are a quarter above the
/// peaks.
void bound_stops(benchmark::State& state, const MoveSize& size) {
  const SolvedTrack solution = solved_track(size);
  const Move move = Move::make({&solution.track(), 1}, {}).value();
  const std::vector<AxisLimits> limits = limits_above(BoundedMove(move, {&solution.track(), 1}).peaks());
  const auto cells = static_cast<std::size_t>(size.frames);
  std::vector<StopCell> kept(cells + 1);
  for (auto _ : state) {
    std::vector<MotionTriple> room(size.axes);
    write_room(limits, 1, 1.0 / 250, room);
    const BoundedMove bounded(move, {&solution.track(), 1},
                              {.limits = limits, .motors = {}, .cells = cells, .room = std::move(room)});
    const auto bounds = StopBounds::make({.motion = bounded.cells(), .limits = limits}, kept, {});
    if (!bounds) throw std::runtime_error(bounds.error().what);
    benchmark::DoNotOptimize(kept.data());
  }
}
BENCHMARK_CAPTURE(bound_stops, example, example)
    ->Name("certificate_and_stops/example")
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(bound_stops, large, large)
    ->Name("certificate_and_stops/100x16")
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace inbetween

BENCHMARK_MAIN();
