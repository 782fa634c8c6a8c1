#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "host_tools/plan/network.hpp"
#include "host_tools/plan/solved_track.hpp"

/// What it costs to solve a network of moving points: 64 axes, 100 keys, and 16 drawn curves of so many
/// points.

namespace inbetween {
namespace {

constexpr std::size_t axes = 64;
constexpr std::size_t curves = 16;
constexpr std::int32_t keys = 100;
constexpr std::int32_t frames = 990;

double wave(std::size_t axis, std::int32_t frame) {
  return 20 * std::sin(0.02 * frame + 0.3 * static_cast<double>(axis));
}

/// The numbers of a network, which is made of them again and again. Every curve has a point on each key
/// frame.
struct Subject {
  explicit Subject(std::int32_t frames_between_points) {
    for (std::size_t axis = 0; axis < axes; ++axis) places.push_back(static_cast<double>(axis));
    for (std::int32_t k = 0; k < keys; ++k) {
      key_frames.push_back(k * frames / (keys - 1));
      for (std::size_t axis = 0; axis < axes; ++axis) at_keys.push_back(wave(axis, key_frames.back()));
    }
    drawn.resize(curves);
    for (std::int32_t frame = 0; frame <= frames; frame += frames_between_points) {
      point_frames.push_back(frame);
      for (std::size_t i = 0; i < curves; ++i) drawn[i].push_back(wave(axis_of(i), frame));
    }
    for (std::size_t i = 0; i < curves; ++i) spec_curves.push_back({axis_of(i), point_frames, drawn[i]});
  }
  static std::size_t axis_of(std::size_t curve) { return curve * (axes - 1) / (curves - 1); }

  [[nodiscard]] NetworkSpec spec() const {
    return {.keys = at_keys, .key_frames = key_frames, .places = places, .curves = spec_curves};
  }

  std::vector<double> places, at_keys;
  std::vector<std::int32_t> key_frames, point_frames;
  std::vector<std::vector<double>> drawn;
  std::vector<NetworkCurve> spec_curves;
};

CubicsOverFrames solved(const Subject& subject) {
  const Network network(subject.spec());
  benchmark::DoNotOptimize(network.gap());
  return network.path();
}

void solve_network(benchmark::State& state) {
  const Subject subject(static_cast<std::int32_t>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(solved(subject).cubics.data());
}
BENCHMARK(solve_network)
    ->Name("network/frames_between_points")
    ->Arg(10)
    ->Arg(1)
    ->Unit(benchmark::kMillisecond);

/// With its distances and its table of frames, as a plan has it.
void solve_track(benchmark::State& state) {
  const Subject subject(static_cast<std::int32_t>(state.range(0)));
  const std::vector<double> weights(axes, 1);
  for (auto _ : state) {
    const CubicsOverFrames path = solved(subject);
    const SolvedTrack track({.path = {},
                             .cubics = CubicPathSpec{.axis_count = static_cast<std::int32_t>(axes),
                                                     .key_count = keys,
                                                     .cubics = path.cubics,
                                                     .weights = weights,
                                                     .knots = path.knots,
                                                     .over_frames = true},
                             .control_values = {},
                             .frames = frames,
                             .fps = {24, 1},
                             .arc_length = {},
                             .key_frames = subject.key_frames,
                             .kinetic = Kinetic::curves},
                            Solver::closed_form);
    benchmark::DoNotOptimize(track.table().provenance().speed_error);
  }
}
BENCHMARK(solve_track)
    ->Name("network_track/frames_between_points")
    ->Arg(10)
    ->Arg(1)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace inbetween

BENCHMARK_MAIN();
