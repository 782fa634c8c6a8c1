#include <benchmark/benchmark.h>

#include <random>
#include <stdexcept>
#include <vector>

#include "host_tools/plan/solved_track.hpp"
#include "inbetween/limits/limits.hpp"
#include "inbetween/limits/motion_bounds.hpp"
#include "inbetween/limits/move.hpp"
#include "inbetween/limits/stop_bounds.hpp"

/// What it costs to prove the peaks of a move, and that it can be stopped everywhere.

namespace inbetween {
namespace {

struct MoveSize {
  std::size_t keys, axes, control_values;
  std::int32_t frames;
};
constexpr MoveSize example{8, 3, 7, 240};
constexpr MoveSize large{100, 16, 64, 2400};

/// A move of that size through random keys, at random speed.
SolvedTrack<double> solved_track(const MoveSize& size) {
  std::mt19937 random(1989);
  std::uniform_real_distribution<double> coordinate(0.0, 100.0);
  std::uniform_real_distribution<double> height(1.0, 20.0);
  std::vector<double> at(size.keys * size.axes);
  for (double& value : at) value = coordinate(random);
  std::vector<double> speed(size.control_values);
  for (double& value : speed) value = height(random);
  const TrackSpec<double> spec{.path = {.axis_count = static_cast<std::int32_t>(size.axes), .keys = at},
                               .control_values = speed,
                               .frames = size.frames,
                               .fps = {24, 1},
                               .arc_length = {}};
  return {spec, Solver::closed_form};
}

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
