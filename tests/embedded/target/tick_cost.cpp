#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "examples/firmware/board.hpp"
#include "inbetween/play/playhead.hpp"
#include "inbetween/timing/track.hpp"
#include "inbetween/trajectory/count_trajectory.hpp"
#include "inbetween/trajectory/fit.hpp"
#include "tests/embedded/target/console.hpp"
#include "tests/embedded/target/moves.hpp"
#include "tests/embedded/target/played_move.hpp"
#include "tests/embedded/target/solved_move.hpp"
#ifdef INBETWEEN_TABLE
#include "examples/firmware/table_player.h"
#endif

/// Counts the instructions of a tick. QEMU, started with -icount shift=0, lets a nanosecond pass with every
/// instruction, so the board's clock, at 25 MHz, rises by one every 40 instructions. Every function is called
/// a thousand times and more, and what the loop and an empty function of the same signature take is
/// subtracted. The first line is the same for a loop whose length is known.

using namespace inbetween;

// By name, so that the disassembly can be searched for what they call (library_calls.sh).
extern "C" {
void tick_positions(const Track& track, const FrameTime& time, double* out);
void tick_motion(const Track& track, const FrameTime& time, AxisMotion* out);
void tick_playhead(Playhead& playhead);
void tick_trajectory(const Trajectory& trajectory, const FrameTime& time, double* out);
void tick_trajectory_counts(CountTrajectory& counts, const FloatFrameTime& time, std::int32_t* out);
void tick_solved(CountTrajectory& counts, const std::int32_t& tick, std::int32_t* out);
void tick_nothing(const void* track, const void* time, std::int32_t* out);
#ifdef INBETWEEN_TABLE
void tick_player(inbetween_player& player, std::int32_t* out);
#endif
void known_loop(std::uint32_t turns);
}

#define TICK [[gnu::noinline, gnu::noipa]] void
TICK tick_positions(const Track& track, const FrameTime& time, double* out) {
  track.positions(time, std::span(out, 3));
}
TICK tick_motion(const Track& track, const FrameTime& time, AxisMotion* out) {
  track.motion(time, std::span(out, 3));
}
TICK tick_playhead(Playhead& playhead) {
  playhead.tick();
}
TICK tick_trajectory(const Trajectory& trajectory, const FrameTime& time, double* out) {
  trajectory.positions(time, std::span(out, 3));
}
TICK tick_trajectory_counts(CountTrajectory& counts, const FloatFrameTime& time, std::int32_t* out) {
  counts.counts(time, std::span(out, 3));
}
/// A tick of examples/firmware/reveal.cpp, all of it but the sending.
TICK tick_solved(CountTrajectory& counts, const std::int32_t& tick, std::int32_t* out) {
  counts.counts(frame_time_of_tick<float>(tick, {24, 1}, 250), std::span(out, 3));
}
TICK tick_nothing(const void*, const void*, std::int32_t*) {
  asm volatile("");
}
#ifdef INBETWEEN_TABLE
TICK tick_player(inbetween_player& player, std::int32_t* out) {
  std::array<double, 3> positions;
  inbetween_tick(&player, positions.data());
  for (std::size_t m = 0; m < 3; ++m) out[m] = inbetween_count(&player.table->motors[m], positions.data());
}
#endif
#undef TICK

/// Two instructions a turn.
[[gnu::noinline]] void known_loop(std::uint32_t turns) {
  asm volatile("1: subs %0, %0, #1\n bne 1b" : "+r"(turns)::"cc");
}

namespace inbetween::embedded {
namespace {

constexpr std::uint32_t instructions_per_clock = 1'000'000'000 / board::clock_hz;

/// 8 keys, 7 control values, 3 axes: a short move as an animator makes it, and that of the benchmark tick/3
/// in kind.
constexpr std::array keys{41.0, 7.5,  60.0, 84.0, 33.0, 12.0, 15.0, 95.0, 51.0, 66.0, 72.0, 5.0,
                          28.0, 18.0, 88.0, 99.0, 44.0, 37.0, 3.0,  61.0, 79.0, 54.0, 25.0, 91.0};
constexpr std::array speed{12.0, 4.0, 17.0, 9.0, 1.0, 20.0, 6.0};
constexpr embedded::Move subject{.name = "subject",
                                 .spline = Spline::tcb,
                                 .axis_count = 3,
                                 .keys = keys,
                                 .speed = speed,
                                 .frames = 240,
                                 .rate_hz = 250};
constexpr std::array counts_per_unit{10'000.0, 10'000.0, 10'000.0};
constexpr std::int32_t tick_count = 2500;

template <class Work>
double instructions_of(Work work) {
  const std::uint32_t begin = board::clock_now();
  work();
  const std::uint32_t clocks = (board::clock_now() - begin) & board::clock_mask;
  return static_cast<double>(clocks) * instructions_per_clock;
}

/// In tenths, rounded.
void print_line(std::string_view name, double instructions) {
  const auto tenths = static_cast<long long>(instructions * 10 + 0.5);
  print(name);
  print(" ");
  print(tenths / 10);
  print(".");
  print(tenths % 10);
  print("\n");
}

/// The times of all ticks of the subject, worked out beforehand.
template <class Time>
std::span<const Time> all_times() {
  static std::array<Time, tick_count> times;
  for (std::int32_t tick = 0; tick < tick_count; ++tick) {
    times[static_cast<std::size_t>(tick)] =
        frame_time_of_tick<decltype(Time::fraction)>(tick, subject.fps, subject.rate_hz);
  }
  return times;
}

template <class Time = FrameTime, class TickFunction, class Object, class Out>
void measure(std::string_view name, TickFunction tick, Object& object, Out out) {
  const std::span<const Time> times = all_times<Time>();
  std::array<std::int32_t, 3> nowhere{};
  const double all = instructions_of([&] {
    for (const Time& time : times) tick(object, time, out);
  });
  const double overhead = instructions_of([&] {
    for (const Time& time : times) tick_nothing(&object, &time, nowhere.data());
  });
  print_line(name, (all - overhead) / tick_count);
}

/// The longest of all ticks: each is repeated until one step of the clock is one instruction of it.
template <class Time = FrameTime, class TickFunction, class Object, class Out>
void measure_longest(std::string_view name, TickFunction tick, Object& object, Out out) {
  std::array<std::int32_t, 3> nowhere{};
  double longest = 0;
  for (const Time& time : all_times<Time>()) {
    const double all = instructions_of([&] {
      for (std::uint32_t i = 0; i < instructions_per_clock; ++i) tick(object, time, out);
    });
    const double overhead = instructions_of([&] {
      for (std::uint32_t i = 0; i < instructions_per_clock; ++i) tick_nothing(&object, &time, nowhere.data());
    });
    longest = std::max(longest, (all - overhead) / instructions_per_clock);
  }
  print_line(name, longest);
}

/// Of so many ticks, all together.
template <class TickFunction>
double instructions_of_ticks(TickFunction tick, Playhead& playhead, int count) {
  std::array<std::int32_t, 3> nowhere{};
  const double all = instructions_of([&] {
    for (int i = 0; i < count; ++i) tick(playhead);
  });
  const double overhead = instructions_of([&] {
    for (int i = 0; i < count; ++i) tick_nothing(&playhead, nullptr, nowhere.data());
  });
  return all - overhead;
}

/// How many ticks a playhead takes to an even rate, or to rest.
int ticks_of_ramp(Playhead playhead) {
  int ticks = 0;
  do {
    playhead.tick();
    ++ticks;
  } while (playhead.rate_change() != 0 && ticks < tick_count);
  return ticks;
}

/// While time runs evenly; and on the way from rest to the drawn speed, and back to rest.
template <class TickFunction>
bool measure_playing(std::string_view even, std::string_view ramps, TickFunction tick,
                     const PlayedMove& played) {
  Playhead playhead(played.move(), played.bounds(), subject.rate_hz);
  bool is_well = playhead.play(Direction::forward).has_value();
  print_line(even, instructions_of_ticks(tick, playhead, tick_count) / tick_count);
  playhead.stop();
  for (int i = ticks_of_ramp(playhead); i > 0; --i) playhead.tick();
  double instructions = 0;
  int ticks = 0;
  for (std::int32_t frame = 10; frame < subject.frames; frame += 20) {
    is_well = is_well && playhead.place_on(frame);
    is_well = is_well && playhead.play(2 * frame < subject.frames ? Direction::forward : Direction::backward);
    for (int turn = 0; turn < 2; ++turn) {
      const int count = ticks_of_ramp(playhead);
      instructions += instructions_of_ticks(tick, playhead, count);
      ticks += count;
      is_well = is_well && playhead.rate_change() == 0 && playhead.is_resting() == (turn == 1);
      playhead.stop();
    }
  }
  print_line(ramps, instructions / ticks);
  return is_well;
}

template <class Real>
void measure_frame_time(std::string_view name) {
  Real sum = 0;
  const double all = instructions_of([&] {
    for (std::int32_t tick = 0; tick < tick_count; ++tick) {
      std::int32_t opaque = tick;
      asm volatile("" : "+r"(opaque));
      const BasicFrameTime<Real> time = frame_time_of_tick<Real>(opaque, subject.fps, subject.rate_hz);
      sum += time.fraction;
    }
  });
  asm volatile("" ::"r"(&sum) : "memory");
  print_line(name, all / tick_count);
}

/// Playing the subject. False where it does not go as it should.
bool measure_play(const Track& track, PlayedMove& played) {
  Status made = played.make(track, subject.rate_hz);
  print_line("bound_move", instructions_of([&] { made = made ? played.prove() : made; }));
  print_line("StopBounds::make", instructions_of([&] { made = made ? played.make_bounds() : made; }));
  const bool is_well =
      made.has_value() && measure_playing("Playhead::tick", "Playhead::tick(ramps)", tick_playhead, played);
  if (!is_well) print("FAILED: the subject is not played as it should be\n");
  return is_well;
}

std::array<SampledJoint, 100> joints;
TrajectoryStorage<3, 300, 30> fitted;
std::array<CountTrajectoryPiece, 400> count_pieces;
std::array<CountPolynomial, 3 * count_pieces.size()> count_polynomials;

/// The trajectory of the subject, and its tick. False where there is none.
bool measure_trajectory(const Track& track) {
  const auto sampler = TrackSampler::make(track, joints);
  if (!sampler) return false;
  auto trajectory = fit_trajectory(*sampler, {}, fitted.memory());
  print_line("fit_trajectory",
             instructions_of([&] { trajectory = fit_trajectory(*sampler, {}, fitted.memory()); }));
  if (!trajectory) return false;
  const CountTrajectoryMemory memory{count_pieces, count_polynomials};
  auto counts = CountTrajectory::make(*trajectory, counts_per_unit, memory);
  print_line("CountTrajectory::make",
             instructions_of([&] { counts = CountTrajectory::make(*trajectory, counts_per_unit, memory); }));
  if (!counts) return false;
  std::array<double, 3> positions{};
  std::array<std::int32_t, 3> out{};
  measure("Trajectory::positions", tick_trajectory, *trajectory, positions.data());
  measure<FloatFrameTime>("CountTrajectory::counts", tick_trajectory_counts, *counts, out.data());
  measure_longest<FloatFrameTime>("CountTrajectory::counts(longest)", tick_trajectory_counts, *counts,
                                  out.data());
  const double all = instructions_of([&] {
    for (std::int32_t tick = 0; tick < tick_count; ++tick) tick_solved(*counts, tick, out.data());
  });
  const double overhead = instructions_of([&] {
    for (std::int32_t tick = 0; tick < tick_count; ++tick) tick_nothing(&counts, &tick, out.data());
  });
  print_line("reveal_firmware(tick)", (all - overhead) / tick_count);
  return true;
}

#ifdef INBETWEEN_TABLE
/// A tick of examples/firmware/play_table.cpp, all of it but the sending: of a table of three axes, to its
/// end.
bool measure_player() {
  const inbetween_trajectory& table = INBETWEEN_TABLE;
  if (table.motor_count != 3 || table.position_count != 3) return false;
  inbetween_player player;
  inbetween_start(&player, &table, table.rate_hz);
  std::array<std::int32_t, 3> out{};
  const std::int64_t ticks = last_tick(table.last_frame - table.first_frame,
                                       {table.fps_numerator, table.fps_denominator}, table.rate_hz);
  const double all = instructions_of([&] {
    for (std::int64_t tick = 0; tick < ticks; ++tick) tick_player(player, out.data());
  });
  const double overhead = instructions_of([&] {
    for (std::int64_t tick = 0; tick < ticks; ++tick) tick_nothing(&player, nullptr, out.data());
  });
  print_line("play_table(tick)", (all - overhead) / static_cast<double>(ticks));
  return true;
}
#endif

SolvedMove solved_move;
PlayedMove played_move;

}  // namespace

bool run() {
  board::start_clock();
  constexpr std::uint32_t turns = 500'000;
  print_line("known_loop", instructions_of([] { known_loop(turns); }) / turns);

  Result<Track> track = solved_move.solve(subject);
  print_line("solve", instructions_of([&] { track = solved_move.solve(subject); }));
  if (!track) {
    print("FAILED: the subject has no track\n");
    return false;
  }
  std::array<double, 3> positions{};
  std::array<AxisMotion, 3> motion{};
  measure("Track::positions", tick_positions, *track, positions.data());
  measure("Track::motion", tick_motion, *track, motion.data());
  measure_frame_time<double>("frame_time_of_tick");
  measure_frame_time<float>("frame_time_of_tick(float)");
  if (!measure_trajectory(*track)) {
    print("FAILED: the subject has no trajectory\n");
    return false;
  }
#ifdef INBETWEEN_TABLE
  if (!measure_player()) {
    print("FAILED: the table has not three axes\n");
    return false;
  }
#endif
  return measure_play(*track, played_move);
}

}  // namespace inbetween::embedded
