#include <benchmark/benchmark.h>

#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "host_tools/plan/bounded_move.hpp"
#include "host_tools/plan/fitted_trajectory.hpp"
#include "inbetween/limits/limits.hpp"
#include "inbetween/limits/played_motion.hpp"
#include "inbetween/play/playhead.hpp"
#include "tests/benchmarks/solved_subject.hpp"

/// A tick of a move that is played: where the playhead is, and the positions of all axes there.

namespace inbetween {
namespace {

constexpr std::int32_t rate_hz = 1000;

/// A move of a second and a key for every 24 frames, from rest to rest, on a rig whose limits are a quarter
/// above its peaks.
class Subject {
 public:
  Subject(std::size_t keys, std::size_t axes)
      : axes_(axes),
        solution_(solved_track({keys, axes, keys, static_cast<std::int32_t>(24 * keys)}, true)),
        move_(Move::make({&solution_.track(), 1}, {}).value()),
        fitted_(solution_.track()),
        trajectory_(*fitted_),
        motion_(PlayedMotion::make(move_, {&trajectory_, 1}).value()) {
    limits_ = limits_above(BoundedMove(move_, {&solution_.track(), 1}).peaks());
    const auto cells = static_cast<std::size_t>(move_.frames());
    cells_.resize(cells + 1);
    std::vector<MotionTriple> room(axes);
    write_room(limits_, 1, 1.0 / rate_hz, room);
    const BoundedMove bounded(move_, {&solution_.track(), 1},
                              {.limits = limits_, .motors = {}, .cells = cells, .room = std::move(room)});
    const auto bounds = StopBounds::make(
        {.motion = bounded.cells(), .limits = limits_, .tick_seconds = 1.0 / rate_hz}, cells_, {});
    if (!bounds) throw std::runtime_error(bounds.error().what);
    bounds_ = *bounds;
  }
  Subject(const Subject&) = delete;
  Subject& operator=(const Subject&) = delete;

  [[nodiscard]] const Move& move() const { return move_; }
  [[nodiscard]] const PlayedMotion& motion() const { return motion_; }
  [[nodiscard]] std::size_t axes() const { return axes_; }
  [[nodiscard]] const StopBounds& bounds() const { return *bounds_; }

 private:
  std::size_t axes_;
  SolvedTrack solution_;
  Move move_;
  FittedTrajectory fitted_;
  Trajectory trajectory_;
  PlayedMotion motion_;
  std::vector<AxisLimits> limits_;
  std::vector<StopCell> cells_;
  std::optional<StopBounds> bounds_;
};

Subject subject_of(benchmark::State& state) {
  const auto axes = static_cast<std::size_t>(state.range(0));
  return {axes == 3 ? std::size_t{8} : std::size_t{100}, axes};
}

/// Time runs evenly, to and fro.
void playhead_tick(benchmark::State& state) {
  const Subject subject = subject_of(state);
  Playhead playhead(subject.move(), subject.bounds(), rate_hz);
  playhead.set_repeat(Repeat::ping_pong);
  if (!playhead.play(Direction::forward)) {
    throw std::runtime_error("not played");
  }
  std::vector<double> positions(subject.axes());
  for (auto _ : state) {
    playhead.tick();
    subject.motion().positions(playhead.time(), positions);
    benchmark::DoNotOptimize(positions.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK(playhead_tick)->Arg(3)->Arg(16);

/// Between rest and the drawn speed, again and again, from one end to the other and back.
void playhead_ramp(benchmark::State& state) {
  const Subject subject = subject_of(state);
  Playhead playhead(subject.move(), subject.bounds(), rate_hz);
  std::vector<double> positions(subject.axes());
  Direction direction = Direction::forward;
  for (auto _ : state) {
    if (playhead.is_resting()) {
      if (!playhead.play(direction)) {
        direction = direction == Direction::forward ? Direction::backward : Direction::forward;
        if (!playhead.play(direction)) throw std::runtime_error("not played");
      }
    } else if (playhead.rate_change() == 0) {
      playhead.stop();
    }
    playhead.tick();
    subject.motion().positions(playhead.time(), positions);
    benchmark::DoNotOptimize(positions.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK(playhead_ramp)->Arg(3)->Arg(16);

}  // namespace
}  // namespace inbetween

BENCHMARK_MAIN();
