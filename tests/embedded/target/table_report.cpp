#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "inbetween/base/hash.hpp"
#include "inbetween/play/playhead.hpp"
#include "inbetween/timing/frame_table.hpp"
#include "inbetween/timing/key_timing.hpp"
#include "inbetween/timing/track.hpp"
#include "inbetween/trajectory/bounds.hpp"
#include "inbetween/trajectory/count_trajectory.hpp"
#include "inbetween/trajectory/fit.hpp"
#include "tests/embedded/target/console.hpp"
#include "tests/embedded/target/joint_report.hpp"
#include "tests/embedded/target/moves.hpp"
#include "tests/embedded/target/play_report.hpp"
#include "tests/embedded/target/report_line.hpp"
#include "tests/embedded/target/solved_move.hpp"

/// Solves the constant moves, checks that each table keeps its invariants, and prints a
/// hash of every table and of what every tick evaluates; and plays two of them. The test compares the lines
/// with those of other targets.

namespace inbetween::embedded {
namespace {

void hash_ticks(const Track& track, const Move& move) {
  std::array<double, max_axes> positions{};
  std::array<AxisMotion, max_axes> motion{};
  Fnv1a position_hash;
  Fnv1a motion_hash;
  const auto axes = static_cast<std::size_t>(move.axis_count);
  for (std::int64_t tick = 0; tick <= last_tick(move.frames, move.fps, move.rate_hz); ++tick) {
    const FrameTime time = frame_time_of_tick(tick, move.fps, move.rate_hz);
    track.positions(time, std::span(positions).first(axes));
    track.motion(time, std::span(motion).first(axes));
    for (std::size_t d = 0; d < axes; ++d) {
      position_hash.add(positions[d]);
      motion_hash.add(motion[d].velocity);
      motion_hash.add(motion[d].acceleration);
      motion_hash.add(motion[d].jerk);
    }
  }
  print_hash("positions", position_hash.value());
  print_hash("motion", motion_hash.value());
}

void hash_peaks(const Trajectory& trajectory) {
  std::array<AxisPeaks, max_axes> storage;
  const auto peaks = std::span(storage).first(trajectory.axis_count());
  bound_trajectory(trajectory, peaks);
  Fnv1a hash;
  for (const AxisPeaks& axis : peaks) {
    for (const Peak& peak : {axis.lowest, axis.highest, axis.velocity, axis.acceleration, axis.jerk}) {
      hash.add(peak.value);
      hash.add(peak.frame);
    }
  }
  print_hash("bounds", hash.value());
}

/// What every tick evaluates of a trajectory, and of its counts.
void hash_trajectory_ticks(const Trajectory& trajectory, CountTrajectory& counts, const Move& move) {
  const std::size_t axes = trajectory.axis_count();
  std::array<AxisMotion, max_axes> motion{};
  std::array<std::int32_t, max_axes> whole{};
  Fnv1a motion_hash;
  Fnv1a count_hash;
  for (std::int64_t tick = 0; tick <= last_tick(move.frames, move.fps, move.rate_hz); ++tick) {
    trajectory.motion(frame_time_of_tick(tick, move.fps, move.rate_hz), std::span(motion).first(axes));
    counts.counts(frame_time_of_tick<float>(tick, move.fps, move.rate_hz), std::span(whole).first(axes));
    for (std::size_t d = 0; d < axes; ++d) {
      for (const double one :
           {motion[d].position, motion[d].velocity, motion[d].acceleration, motion[d].jerk})
        motion_hash.add(one);
      count_hash.add(whole[d]);
    }
  }
  print_hash("motion", motion_hash.value());
  print_hash("counts", count_hash.value());
}

void report_trajectory(const Move& move) {
  static SolvedMove solved;
  static std::array<SampledJoint, 1000> joints;
  static TrajectoryStorage<max_axes, 400, 60> fitted;
  static std::array<CountTrajectoryPiece, 600> pieces;
  static std::array<CountPolynomial, max_axes * pieces.size()> polynomials;
  const Result<Track> track = solved.solve(move);
  if (!track) return fail("trajectory", move, track.error());
  const auto sampler = TrackSampler::make(*track, joints);
  if (!sampler) return fail("trajectory", move, sampler.error());
  const auto trajectory = fit_trajectory(*sampler, {}, fitted.memory());
  if (!trajectory) return fail("trajectory", move, trajectory.error());
  const std::array scale{move.counts_per_unit, -move.counts_per_unit, move.counts_per_unit / 7};
  auto counts = CountTrajectory::make(*trajectory, std::span(scale).first(trajectory->axis_count()),
                                      {pieces, polynomials});
  if (!counts) return fail("trajectory", move, counts.error());
  print("trajectory ");
  print(move.name);
  print(" ");
  print(static_cast<long long>(trajectory->pieces().size()));
  Fnv1a rows;
  for (const TrajectoryPiece& piece : trajectory->pieces()) {
    rows.add(piece.begin.frame);
    rows.add(piece.begin.fraction);
    const std::size_t size = static_cast<std::size_t>(piece.degree / 2 + 1) * trajectory->axis_count();
    for (const std::uint32_t row : {piece.begin_row, piece.end_row}) {
      for (const double value : trajectory->values().subspan(row, size)) rows.add(value);
    }
  }
  print_hash("rows", rows.value());
  hash_peaks(*trajectory);
  hash_trajectory_ticks(*trajectory, *counts, move);
  print("\n");
}

void report(const Move& move) {
  static SolvedMove solved;
  const Result<Track> track = solved.solve(move);
  if (!track) {
    fail("double", move, track.error());
    return;
  }
  const auto table = closed_form_table(*track, solved.points());
  if (!table) {
    fail("double", move, table.error());
    return;
  }
  if (const Status sound = check_invariants(*track, *table); !sound) fail("double", move, sound.error());
  print("double");
  print(" ");
  print(move.name);
  print_hash("table", hash_of(table->points()));
  hash_ticks(*track, move);
  print("\n");
}

/// What the elements of the core's memory take. `inbetween budget` computes with those of the machine that it
/// runs on, so they must be the same everywhere.
void report_sizes() {
  print("sizes double");
  for (const std::size_t size :
       {sizeof(Cubic), sizeof(ArcPiece), sizeof(TwoSum), sizeof(SpeedSpan), sizeof(PathPoint),
        sizeof(TrajectoryPiece), sizeof(CountTrajectoryPiece), sizeof(CountPolynomial), sizeof(Portion),
        sizeof(KeyInterval), sizeof(KeyLock), sizeof(FrameTime), sizeof(AxisMotion), sizeof(RollAxis),
        sizeof(StopCell), sizeof(MotionTriple), sizeof(Playhead) - 6 * sizeof(void*)}) {
    print(" ");
    print(static_cast<long long>(size));
  }
  print("\n");
}

}  // namespace

bool run() {
  report_sizes();
  for (const Move& move : moves) {
    report(move);
    report_trajectory(move);
  }
  report_play(moves[0]);
  report_play(moves[2]);
  report_joints();
  return passed;
}

}  // namespace inbetween::embedded
