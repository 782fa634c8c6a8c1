#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <random>
#include <vector>

#include "host_tools/plan/fitted_trajectory.hpp"
#include "inbetween/trajectory/bounds.hpp"
#include "tests/benchmarks/solved_subject.hpp"
#include "tests/support/count_trajectory.hpp"

/// What a trajectory costs: to fit, to bound, and to look at.

namespace inbetween {
namespace {

/// At random, so that nothing is found again.
std::vector<FrameTime> random_times(std::int32_t frames) {
  std::mt19937 random(1989);
  std::uniform_int_distribution<std::int32_t> frame(0, frames - 1);
  std::uniform_real_distribution<double> fraction(0.0, 1.0);
  std::vector<FrameTime> times(4096);
  for (FrameTime& time : times) time = {frame(random), fraction(random)};
  return times;
}

void fit(benchmark::State& state, const MoveSize& size) {
  const SolvedTrack solved = solved_track(size);
  const SampledTrack sampled(solved.track());
  TrajectoryFitter fitter;
  std::size_t pieces = fitter.fit(*sampled).pieces().size();
  for (auto _ : state) pieces = fitter.fit(*sampled).pieces().size();
  state.counters["pieces"] = static_cast<double>(pieces);
}
BENCHMARK_CAPTURE(fit, example, example)->Name("trajectory_fit/example")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(fit, large, large)->Name("trajectory_fit/100x16")->Unit(benchmark::kMicrosecond);

void bound(benchmark::State& state, const MoveSize& size) {
  const SolvedTrack solved = solved_track(size);
  const FittedTrajectory fitted(solved.track());
  std::vector<AxisPeaks> peaks(size.axes);
  for (auto _ : state) {
    bound_trajectory(*fitted, peaks);
    benchmark::DoNotOptimize(peaks.data());
  }
}
BENCHMARK_CAPTURE(bound, example, example)->Name("trajectory_bounds/example")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(bound, large, large)->Name("trajectory_bounds/100x16")->Unit(benchmark::kMicrosecond);

void bound_each_cell(benchmark::State& state, const MoveSize& size) {
  const SolvedTrack solved = solved_track(size);
  const FittedTrajectory fitted(solved.track());
  const CellLine line{0, solved.track().frames(), 256};
  std::vector<AxisPeaks> peaks(size.axes);
  bound_trajectory(*fitted, peaks);
  std::vector<std::array<double, 3>> room;
  for (const AxisPeaks& axis : peaks)
    room.push_back({0.005 * axis.velocity.value, 0.005 * axis.acceleration.value, 0.005 * axis.jerk.value});
  std::vector<std::array<double, 3>> suprema(line.cells * size.axes);
  for (auto _ : state) {
    std::fill(suprema.begin(), suprema.end(), std::array<double, 3>{});
    bound_cells(*fitted, fitted->begin(), fitted->end(), line, room, suprema, size.axes);
    benchmark::DoNotOptimize(suprema.data());
  }
}
BENCHMARK_CAPTURE(bound_each_cell, example, example)
    ->Name("trajectory_cells/example")
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(bound_each_cell, large, large)
    ->Name("trajectory_cells/100x16")
    ->Unit(benchmark::kMicrosecond);

/// Calls `look` with one time after the other.
template <class Time, class Look>
void look_at_times(benchmark::State& state, const std::vector<Time>& times, const Look& look) {
  std::size_t i = 0;
  for (auto _ : state) look(times[i++ % times.size()]);
}

void positions(benchmark::State& state, const MoveSize& size) {
  const SolvedTrack solved = solved_track(size);
  const FittedTrajectory fitted(solved.track());
  std::vector<double> out(size.axes);
  look_at_times(state, random_times(size.frames), [&](const FrameTime& time) {
    fitted->positions(time, out);
    benchmark::DoNotOptimize(out.data());
  });
}
BENCHMARK_CAPTURE(positions, example, example)->Name("trajectory_positions/3");
BENCHMARK_CAPTURE(positions, large, large)->Name("trajectory_positions/16");

void motion(benchmark::State& state, const MoveSize& size) {
  const SolvedTrack solved = solved_track(size);
  const FittedTrajectory fitted(solved.track());
  std::vector<AxisMotion> out(size.axes);
  look_at_times(state, random_times(size.frames), [&](const FrameTime& time) {
    fitted->motion(time, out);
    benchmark::DoNotOptimize(out.data());
  });
}
BENCHMARK_CAPTURE(motion, example, example)->Name("trajectory_motion/3");
BENCHMARK_CAPTURE(motion, large, large)->Name("trajectory_motion/16");

void counts(benchmark::State& state, const MoveSize& size) {
  const SolvedTrack solved = solved_track(size);
  const FittedTrajectory fitted(solved.track());
  CountsOfTrajectory counted(*fitted, std::vector<double>(size.axes, 10'000));
  std::vector<FloatFrameTime> times;
  for (const FrameTime& time : random_times(size.frames))
    times.push_back({time.frame, static_cast<float>(time.fraction)});
  std::vector<std::int32_t> out(size.axes);
  look_at_times(state, times, [&](const FloatFrameTime& time) {
    counted->counts(time, out);
    benchmark::DoNotOptimize(out.data());
  });
}
BENCHMARK_CAPTURE(counts, example, example)->Name("trajectory_counts/3");
BENCHMARK_CAPTURE(counts, large, large)->Name("trajectory_counts/16");

}  // namespace
}  // namespace inbetween

BENCHMARK_MAIN();
