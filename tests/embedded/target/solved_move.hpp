#pragma once

#include <algorithm>
#include <array>

#include "inbetween/timing/frame_table.hpp"
#include "inbetween/timing/track.hpp"
#include "tests/embedded/target/moves.hpp"

/// A constant move, solved in memory of its own.

namespace inbetween::embedded {

template <Precise Real>
class SolvedMove {
 public:
  Result<Track<Real>> solve(const Move& move) {
    const std::span<const Real> keys = rounded(move.keys, keys_);
    const std::span<const Real> weights = rounded(move.weights, weights_);
    for (std::size_t i = 0; i < move.shapes.size(); ++i) {
      shapes_[i] = {static_cast<Real>(move.shapes[i].tension), static_cast<Real>(move.shapes[i].continuity),
                    static_cast<Real>(move.shapes[i].bias)};
    }
    const auto path = Path<Real>::make({.spline = move.spline,
                                        .closed = move.closed,
                                        .axis_count = move.axis_count,
                                        .keys = keys,
                                        .lap = rounded(move.lap, lap_),
                                        .weights = weights,
                                        .shapes = std::span(shapes_).first(move.shapes.size()),
                                        .overshoot = move.overshoot,
                                        .key_frames = is_curves(move) ? move.key_frames : none,
                                        .rests_at_start = move.rests,
                                        .rests_at_end = move.rests},
                                       {storage_.path.cubics, storage_.path.weights, knots_});
    if (!path) return path.error();
    const auto arc_length = ArcLength<Real>::make(*path, {}, storage_.arc_length.memory());
    if (!arc_length) return arc_length.error();
    if (!move.key_frames.empty()) {
      return Track<Real>::make_with_key_frames(*path, *arc_length, move.key_frames, move.kinetic, move.frames,
                                               move.fps, {.key_intervals = key_intervals_});
    }
    const Result<std::span<const Real>> speed = played_speed(move, *path, *arc_length);
    if (!speed) return speed.error();
    const auto profile = SpeedProfile<Real>::make(*speed, storage_.profile.memory(), move.ends);
    if (!profile) return profile.error();
    return Track<Real>::make(*path, *arc_length, *profile, move.frames, move.fps, storage_.memory());
  }
  [[nodiscard]] std::span<PathPoint<Real>> points() { return points_; }

 private:
  static constexpr std::span<const std::int32_t> none{};

  [[nodiscard]] static bool is_curves(const Move& move) { return move.kinetic == Kinetic::curves; }
  /// The drawn speed, or what its locked keys make of it.
  Result<std::span<const Real>> played_speed(const Move& move, const Path<Real>& path,
                                             const ArcLength<Real>& arc_length) {
    const std::span<const Real> drawn = rounded(move.speed, speed_);
    if (move.locks.empty()) return drawn;
    std::size_t keys = 0;
    for (std::int32_t i = 0; i <= path.segment_count(); ++i) {
      distances_[keys++] = arc_length.segment_begin(i).high;
    }
    const auto timing = adjust_to_locks<Real>({.control_values = drawn,
                                               .key_distances = std::span(distances_).first(keys),
                                               .locks = move.locks,
                                               .frames = move.frames,
                                               .ends = move.ends},
                                              key_timing_.memory());
    if (!timing) return timing.error();
    return timing->control_values;
  }
  static std::span<const Real> rounded(std::span<const double> numbers, std::span<Real> result) {
    std::ranges::transform(numbers, result.begin(), [](double x) { return static_cast<Real>(x); });
    return result.first(numbers.size());
  }

  /// Of a path over frames: beside a rest.
  static constexpr std::size_t max_segments = 4 * max_keys;

  TrackStorage<Real, max_segments, max_axes, max_values, max_pieces> storage_;
  std::array<FrameKnot, max_segments> knots_;
  std::array<KeyInterval<Real>, max_segments> key_intervals_;
  std::array<Real, max_keys * max_axes> keys_;
  std::array<Real, max_axes> weights_;
  std::array<Real, max_axes> lap_;
  std::array<KeyShape<Real>, max_keys> shapes_;
  std::array<Real, max_values> speed_;
  std::array<Real, max_keys + 1> distances_;
  KeyTimingStorage<Real, max_locks, max_values> key_timing_;
  std::array<PathPoint<Real>, max_move_frames + 1> points_;
};

}  // namespace inbetween::embedded
