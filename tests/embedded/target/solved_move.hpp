#pragma once

#include <array>

#include "inbetween/timing/frame_table.hpp"
#include "inbetween/timing/track.hpp"
#include "tests/embedded/target/moves.hpp"

/// A constant move, solved in memory of its own.

namespace inbetween::embedded {

class SolvedMove {
 public:
  Result<Track> solve(const Move& move) {
    const PathMemory memory{storage_.path.cubics, storage_.path.weights, knots_};
    const auto path = move.cubics.empty() ? path_through_keys(move, memory) : path_of_cubics(move, memory);
    if (!path) return path.error();
    const auto arc_length = ArcLength::make(*path, {}, storage_.arc_length.memory());
    if (!arc_length) return arc_length.error();
    if (!move.key_frames.empty()) {
      return Track::make_with_key_frames(*path, *arc_length, move.key_frames, move.kinetic, move.frames,
                                         move.fps, {.key_intervals = key_intervals_});
    }
    const Result<std::span<const double>> speed = played_speed(move, *path, *arc_length);
    if (!speed) return speed.error();
    const auto profile = SpeedProfile::make(*speed, storage_.profile.memory(), move.ends);
    if (!profile) return profile.error();
    return Track::make(*path, *arc_length, *profile, move.frames, move.fps, storage_.memory());
  }
  [[nodiscard]] std::span<PathPoint> points() { return points_; }

 private:
  static constexpr std::span<const std::int32_t> none{};
  static constexpr std::array<double, max_axes> plain_weights{1, 1, 1};

  static Result<Path> path_through_keys(const Move& move, const PathMemory& memory) {
    return Path::make({.spline = move.spline,
                       .closed = move.closed,
                       .axis_count = move.axis_count,
                       .keys = move.keys,
                       .lap = move.lap,
                       .weights = move.weights,
                       .shapes = move.shapes,
                       .overshoot = move.overshoot,
                       .key_frames = is_curves(move) ? move.key_frames : none,
                       .rests_at_start = move.rests,
                       .rests_at_end = move.rests,
                       .overlap_frames = move.overlap_frames,
                       .path_tolerances = move.path_tolerances},
                      memory);
  }
  static Result<Path> path_of_cubics(const Move& move, const PathMemory& memory) {
    return Path::make_of_cubics(
        {.spline = move.spline,
         .axis_count = move.axis_count,
         .key_count = static_cast<std::int32_t>(move.key_frames.size()),
         .cubics = move.cubics,
         .weights = std::span(plain_weights).first(static_cast<std::size_t>(move.axis_count)),
         .knots = move.knots,
         .over_frames = true},
        memory);
  }

  [[nodiscard]] static bool is_curves(const Move& move) { return move.kinetic == Kinetic::curves; }
  /// The drawn speed, or what its locked keys make of it.
  Result<std::span<const double>> played_speed(const Move& move, const Path& path,
                                               const ArcLength& arc_length) {
    if (move.locks.empty()) return move.speed;
    std::size_t keys = 0;
    for (std::int32_t i = 0; i <= path.segment_count(); ++i) {
      distances_[keys++] = arc_length.segment_begin(i).high;
    }
    const auto timing = adjust_to_locks({.control_values = move.speed,
                                         .key_distances = std::span(distances_).first(keys),
                                         .locks = move.locks,
                                         .frames = move.frames,
                                         .ends = move.ends},
                                        key_timing_.memory());
    if (!timing) return timing.error();
    return timing->control_values;
  }
  /// Of a path over frames: beside a rest, or where actions overlap.
  static constexpr std::size_t max_segments = 4 * max_keys;

  TrackStorage<max_segments, max_axes, max_values, max_pieces> storage_;
  std::array<FrameKnot, max_segments> knots_;
  std::array<KeyInterval, max_segments> key_intervals_;
  std::array<double, max_keys + 1> distances_;
  KeyTimingStorage<max_locks, max_values> key_timing_;
  std::array<PathPoint, max_move_frames + 1> points_;
};

}  // namespace inbetween::embedded
