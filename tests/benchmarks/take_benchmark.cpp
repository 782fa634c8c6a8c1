#include <benchmark/benchmark.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "host_tools/motions/run.hpp"
#include "host_tools/takes/take_compare.hpp"
#include "host_tools/takes/take_passes.hpp"
#include "host_tools/takes/take_recorder.hpp"
#include "host_tools/takes/take_store.hpp"
#include "host_tools/takes/taken_motion.hpp"
#include "host_tools/takes/taken_rig.hpp"
#include "host_tools/takes/tick_codec.hpp"
#include "tests/support/places.hpp"
#include "tests/support/played_take.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/sixteen_axes.hpp"
#include "tests/support/temporary_file.hpp"

/// What takes cost: the loop of sixteen axes with and without one, and what is asked of a file of many.

namespace inbetween {
namespace {

// --- the loop

void take_tick_without(benchmark::State& state) {
  sixteen_axes::TickedLoop rig;
  LoopTrace trace(sixteen_axes::axes);
  for ([[maybe_unused]] auto _ : state) rig.tick(trace);
  if (!rig.is_running()) throw std::runtime_error("not running any more");
}
BENCHMARK(take_tick_without);

/// Until a reader finds so many ticks in the file.
void wait_for(const std::string& file, std::int64_t ticks) {
  TakeStore store(file, TakeStore::Access::read);
  while (store.list().front().ticks < ticks) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

/// The loop ticks here as fast as it can, and not every millisecond: each second of the rig is waited for,
/// so that every tick finds room in the ring.
void take_tick_with(benchmark::State& state) {
  const TemporaryFolder folder;
  const std::string file = folder.path() / "takes.db";
  sixteen_axes::TickedLoop rig;
  TakeRecorder recorder({.file = file}, rig.take());
  LoopTrace trace(sixteen_axes::axes, {&recorder});
  std::int64_t ticks = 0;
  for ([[maybe_unused]] auto _ : state) {
    rig.tick(trace);
    if (++ticks % sixteen_axes::rate_hz != 0) continue;
    state.PauseTiming();
    wait_for(file, ticks);
    state.ResumeTiming();
  }
  const KeptTake kept = recorder.finish("", false);
  if (kept.lost > 0) throw std::runtime_error("ticks were lost: " + kept.why);
  state.counters["bytes_a_tick"] = static_cast<double>(kept.bytes) / static_cast<double>(kept.ticks);
}
BENCHMARK(take_tick_with);

// --- many takes

constexpr std::int64_t many_takes = 1000;

Take played_reveal(const std::string& file) {
  const std::string reveal = in_checkout("examples/reveal.toml");
  const std::string camera_rig = in_checkout("examples/camera_rig.toml");
  const Plan plan(read_move_file(reveal), read_rig_file(camera_rig), {});
  TakeRequest request{.keeping = {.file = file}};
  for (const auto& [role, path] :
       {std::pair{TakeFile::Role::move, reveal}, {TakeFile::Role::rig, camera_rig}})
    request.files.push_back({.role = role, .path = path, .text = file_contents(path), .hash = {}});
  run(plan, {.simulated = true, .fast = true}, {.take = request});
  return TakeStore(file, TakeStore::Access::read).read(1);
}

/// Appends the ticks of a take, a second a chunk as a recorder does, each axis off by a count here and there.
void keep_again(TakeStore& store, const Take& take, std::mt19937& random) {
  const auto motion = TakenMotion::read(take.trajectory);
  TickEncoder encoder({.axes = take.axes,
                       .motion = &motion->motion(),
                       .frame_rate = take.frame_rate,
                       .rate_hz = take.rate_hz});
  const std::int64_t number = store.begin(take);
  std::vector<TakeEvent> events = take.events;
  const auto write = [&] {
    const std::int64_t first = encoder.first(), ticks = encoder.ticks();
    store.append(number, {.first = first, .ticks = ticks, .bytes = encoder.take_chunk()}, events, 0);
    events.clear();
  };
  for (TakeTick tick : take.ticks_of_take) {
    for (std::size_t a = 0; a < take.axes.size(); ++a)
      tick.actual[a] += take.axes[a].resolution * (static_cast<double>(random() % 3) - 1);
    encoder.add(tick);
    if (encoder.ticks() >= take.rate_hz) write();
  }
  write();
  store.finish(number, take.ending, take.is_whole, 0);
}

/// A thousand takes of the example.
class ManyTakes {
 public:
  ManyTakes() {
    const Take take = played_reveal(file_);
    TakeStore store(file_, TakeStore::Access::write);
    std::mt19937 random(1);
    for (std::int64_t i = 1; i < many_takes; ++i) keep_again(store, take, random);
  }
  [[nodiscard]] TakeStore store() const { return {file_, TakeStore::Access::read}; }

 private:
  TemporaryFolder folder_;
  std::string file_ = folder_.path() / "takes.db";
};

const ManyTakes& all() {
  static const ManyTakes takes;
  return takes;
}

void takes_list(benchmark::State& state) {
  const ManyTakes& takes = all();
  for ([[maybe_unused]] auto _ : state) {
    if (takes.store().list().size() != many_takes) throw std::runtime_error("takes are missing");
  }
}
BENCHMARK(takes_list);

RigMeasures measures_of(const Take& take) {
  const TakenRig rig = rig_of(take);
  return {rig.rig, rig.kinematics};
}

void takes_compare(benchmark::State& state) {
  const ManyTakes& takes = all();
  for ([[maybe_unused]] auto _ : state) {
    TakeStore store = takes.store();
    const Take first = store.read(1), last = store.read(many_takes);
    const TakeComparison comparison =
        compare_takes(TakeSamples(first), TakeSamples(last), measures_of(first));
    benchmark::DoNotOptimize(comparison.places);
  }
}
BENCHMARK(takes_compare);

void report_passes(benchmark::State& state, const std::vector<TakeSamples>& samples,
                   const RigMeasures& measures) {
  for ([[maybe_unused]] auto _ : state) {
    const PathReport report = path_report(samples, measures);
    if (report.left_out > report.places) throw std::runtime_error("the takes are hardly compared");
    state.counters["places"] = static_cast<double>(report.places);
  }
}

/// What `takes compare` of all of them adds to reading them, and to comparing each with the first.
void takes_passes(benchmark::State& state) {
  TakeStore store = all().store();
  std::vector<TakeSamples> samples;
  for (std::int64_t take = 1; take <= many_takes; ++take) samples.emplace_back(store.read(take));
  report_passes(state, samples, measures_of(store.read_head(1)));
}
BENCHMARK(takes_passes)->Unit(benchmark::kMillisecond);

/// The same of a hundred on a rig with joints and a lens, at places of their own.
void takes_passes_of_crane(benchmark::State& state) {
  const Plan plan = plan_of_crane();
  std::mt19937 random(1);
  std::uniform_real_distribution<double> share(0, 1);
  std::vector<TakeSamples> samples;
  for (std::int64_t number = 1; number <= 100; ++number) {
    PlayedTake take{.number = number, .phase = share(random)};
    take.error = [&](std::int64_t, std::size_t) { return 0.01 * share(random); };
    samples.emplace_back(played_take(plan, take));
  }
  report_passes(state, samples, measures_of(plan));
}
BENCHMARK(takes_passes_of_crane)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace inbetween

BENCHMARK_MAIN();
