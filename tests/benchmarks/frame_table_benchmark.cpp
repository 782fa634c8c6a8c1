#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "inbetween/path/arc_length.hpp"
#include "inbetween/path/path.hpp"
#include "inbetween/timing/frame_table.hpp"
#include "inbetween/timing/speed_profile.hpp"
#include "inbetween/timing/track.hpp"
#include "tests/benchmarks/subject.hpp"

/// The speed of a frame table by both solvers, building the path included, and of the tick.

namespace inbetween {
namespace {

void report_speed_error(benchmark::State& state, Subject& subject, const FrameTable& table) {
  const Track track = subject.make_track();
  state.counters["speed_error"] = measure_speed_deviation(track, table.points()).relative;
}

void closed_form(benchmark::State& state) {
  Subject subject = subject_of(static_cast<std::int32_t>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(subject.closed_form());
  report_speed_error(state, subject, subject.closed_form());
}
BENCHMARK(closed_form)->Arg(240)->Arg(100'000)->Unit(benchmark::kMicrosecond);

/// The same with the positions of all axes.
void closed_form_positions(benchmark::State& state) {
  Subject subject = subject_of(static_cast<std::int32_t>(state.range(0)));
  std::vector<double> positions((static_cast<std::size_t>(subject.frames()) + 1) * subject.axes());
  for (auto _ : state) {
    const Track track = subject.make_track();
    const FrameTable table = subject.closed_form_of(track);
    track.path().positions(table.points(), positions);
    benchmark::DoNotOptimize(positions.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK(closed_form_positions)->Arg(240)->Arg(100'000)->Unit(benchmark::kMicrosecond);

void runge_kutta(benchmark::State& state) {
  Subject subject = subject_of(static_cast<std::int32_t>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(subject.runge_kutta());
  const OdeTable made = subject.runge_kutta();
  state.counters["integrations"] = made.integrations;
  report_speed_error(state, subject, made.table);
}
BENCHMARK(runge_kutta)->Arg(240)->Arg(100'000)->Unit(benchmark::kMicrosecond);

/// Times of a move of 240 frames in an order that no processor learns: it would guess every branch of a
/// look-up among a thousand that come again and again. The upper bits of Knuth's linear congruential
/// generator (MMIX).
class RandomTimes {
 public:
  [[nodiscard]] FrameTime next() {
    state_ = state_ * 6364136223846793005U + 1442695040888963407U;
    return {static_cast<std::int32_t>((state_ >> 32U) * 240U >> 32U),
            static_cast<double>(state_ >> 12U & 0xFFFFFU) * 0x1p-20};
  }

 private:
  std::uint64_t state_ = 7;
};

/// The position of all axes at one time of the move after another, in random order.
void tick(benchmark::State& state) {
  Subject subject(8, 7, static_cast<std::size_t>(state.range(0)), 240);
  const Track track = subject.make_track();
  RandomTimes times;
  std::vector<double> positions(subject.axes());
  for (auto _ : state) {
    track.positions(times.next(), positions);
    benchmark::DoNotOptimize(positions.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK(tick)->Arg(3)->Arg(16);

/// Calls `locate` with the track and the room for the places of its frames.
template <class Locate>
void locate_all(benchmark::State& state, const Locate& locate) {
  Subject subject = subject_of(static_cast<std::int32_t>(state.range(0)));
  const Track track = subject.make_track();
  std::vector<PathPoint> points(static_cast<std::size_t>(subject.frames()) + 1);
  for (auto _ : state) {
    locate(track, points);
    benchmark::DoNotOptimize(points.data());
    benchmark::ClobberMemory();
  }
}

/// The places of all frames alone, in runs that share a span and a piece.
void frames_in_runs(benchmark::State& state) {
  locate_all(state, [](const Track& track, auto& points) { track.locate_frames(0, points); });
}
BENCHMARK(frames_in_runs)->Arg(240)->Arg(100'000);

/// The same, each looked up by itself.
void frames_one_by_one(benchmark::State& state) {
  locate_all(state, [](const Track& track, auto& points) {
    for (std::size_t i = 0; i < points.size(); ++i)
      points[i] = track.locate({static_cast<std::int32_t>(i), 0});
  });
}
BENCHMARK(frames_one_by_one)->Arg(240)->Arg(100'000);

/// Position, velocity, acceleration and jerk of all axes.
void motion(benchmark::State& state) {
  Subject subject(8, 7, static_cast<std::size_t>(state.range(0)), 240);
  const Track track = subject.make_track();
  RandomTimes times;
  std::vector<AxisMotion> axes(subject.axes());
  for (auto _ : state) {
    benchmark::DoNotOptimize(track.motion(times.next(), axes));
    benchmark::ClobberMemory();
  }
}
BENCHMARK(motion)->Arg(3)->Arg(16);

/// One axis in seven phases of constant jerk, as a generator of quickest trajectories gives it.
struct JerkProfile {
  std::array<double, 7> ends;
  std::array<double, 7> positions, velocities, accelerations, jerks;

  JerkProfile(std::mt19937& random, double duration) {
    std::uniform_real_distribution<double> share(0.5, 1.5);
    double end = 0;
    for (double& phase_end : ends) phase_end = end += share(random);
    for (double& phase_end : ends) phase_end *= duration / end;
    AxisMotion at;
    for (std::size_t phase = 0; phase < ends.size(); ++phase) {
      positions[phase] = at.position;
      velocities[phase] = at.velocity;
      accelerations[phase] = at.acceleration;
      jerks[phase] = share(random) - 1;
      at = in_phase(phase, ends[phase] - (phase > 0 ? ends[phase - 1] : 0));
    }
  }
  [[nodiscard]] AxisMotion in_phase(std::size_t phase, double t) const {
    const double p = positions[phase], v = velocities[phase], a = accelerations[phase], j = jerks[phase];
    return {p + t * (v + t * (a / 2 + t * j / 6)), v + t * (a + t * j / 2), a + t * j, j};
  }
  [[nodiscard]] AxisMotion at(double time) const {
    const auto phase = static_cast<std::size_t>(std::ranges::upper_bound(ends, time) - ends.begin());
    return in_phase(phase, phase > 0 ? time - ends[phase - 1] : time);
  }
};

/// Other programs play such profiles. This is what position, velocity and acceleration cost them at the same
/// times.
void jerk_profiles(benchmark::State& state) {
  std::mt19937 random(1989);
  const std::array profiles{JerkProfile(random, 240), JerkProfile(random, 240), JerkProfile(random, 240)};
  RandomTimes times;
  std::vector<AxisMotion> axes(profiles.size());
  for (auto _ : state) {
    const FrameTime time = times.next();
    for (std::size_t d = 0; d < axes.size(); ++d) axes[d] = profiles[d].at(time.frame + time.fraction);
    benchmark::DoNotOptimize(axes.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK(jerk_profiles);

}  // namespace
}  // namespace inbetween

BENCHMARK_MAIN();
