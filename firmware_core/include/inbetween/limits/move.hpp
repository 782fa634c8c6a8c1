#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/result.hpp"
#include "inbetween/limits/roll.hpp"
#include "inbetween/timing/frame_time.hpp"
#include "inbetween/timing/track.hpp"

/// A move as it is played: its tracks side by side on one time line, with a pre-roll where it starts moving
/// and a post-roll where it ends moving.

namespace inbetween {

/// Whether a track is moving at its first or last frame: the drawn speed, or that of the parameter, is not 0
/// there. (A curve that rises from 0 at once, 0 = v_0 < v_1, is not moving yet: its acceleration steps, which
/// steps_at_key tells.)
template <Precise Real>
bool is_moving(const Track<Real>& track, RollEnd end);

/// The motion of every axis where a roll would join the move, track after track: of a track that is moving
/// there that of Track::motion, one-sided; of one that rests its position, at rest. Returns whether any axis
/// moves, so that a roll is needed. `out` has an entry for every axis of all tracks. O(axes).
template <Precise Real>
bool joints_of(std::span<const Track<Real>> tracks, RollEnd end, std::span<AxisMotion<Real>> out);

/// The rolls of a move: of every axis of all tracks, track after track, or of none.
template <Precise Real>
struct MoveRolls {
  std::span<const RollAxis<Real>> before = {};
  std::span<const RollAxis<Real>> after = {};
};

/// The axes of all tracks, track after track, on the time line first_frame()..last_frame(). Refers to the
/// caller's memory.
template <Precise Real>
class Move {
 public:
  /// Errors: wrong_count (no track; rolls that are neither none nor one for each axis), out_of_range (tracks
  /// of different frames or frame rate; rolls at the wrong end, at another frame than 0 or N, of different
  /// frames or frame rate). O(axes).
  static Result<Move> make(std::span<const Track<Real>> tracks, const MoveRolls<Real>& rolls);

  [[nodiscard]] std::span<const Track<Real>> tracks() const { return tracks_; }
  [[nodiscard]] const MoveRolls<Real>& rolls() const { return rolls_; }
  [[nodiscard]] std::size_t axis_count() const { return axis_count_; }
  /// N, without the rolls.
  [[nodiscard]] std::int32_t frames() const { return tracks_.front().frames(); }
  [[nodiscard]] FrameRate frame_rate() const { return tracks_.front().frame_rate(); }
  /// 0, or minus the frames of the pre-roll.
  [[nodiscard]] std::int32_t first_frame() const { return first_frame_; }
  /// N, or N plus the frames of the post-roll.
  [[nodiscard]] std::int32_t last_frame() const { return last_frame_; }

  /// The time of tick k, counted from first_frame(), at `rate_hz` ticks a second. Exact
  /// (frame_time_of_tick).
  [[nodiscard]] FrameTime<Real> time_of_tick(std::int64_t tick, std::int32_t rate_hz) const {
    FrameTime<Real> time = frame_time_of_tick<Real>(tick, frame_rate(), rate_hz);
    time.frame += first_frame_;
    return time;
  }
  /// The first tick at or after last_frame().
  [[nodiscard]] std::int64_t last_tick_at(std::int32_t rate_hz) const {
    return last_tick(last_frame_ - first_frame_, frame_rate(), rate_hz);
  }

  /// The position of every axis. Before first_frame() and after last_frame() the axes rest where they are on
  /// it; at frames 0 and N the track decides, to the last bit. `out` has axis_count() entries. O(axes).
  void positions(const FrameTime<Real>& time, std::span<Real> out) const;
  /// Position, velocity, acceleration and jerk of every axis, the worst of what the tracks say of their
  /// derivatives. Resting outside the time line: derivatives 0. O(axes).
  Derivatives motion(const FrameTime<Real>& time, std::span<AxisMotion<Real>> out) const;

 private:
  Move(std::span<const Track<Real>> tracks, const MoveRolls<Real>& rolls) : tracks_(tracks), rolls_(rolls) {}
  /// The rolls that hold at a time; none within 0..N.
  [[nodiscard]] std::span<const RollAxis<Real>> rolls_at(const FrameTime<Real>& time) const {
    if (time.frame < 0) return rolls_.before;
    const bool is_behind = time.frame > frames() || (time.frame == frames() && time.fraction > 0);
    return is_behind ? rolls_.after : std::span<const RollAxis<Real>>();
  }

  std::span<const Track<Real>> tracks_;
  MoveRolls<Real> rolls_;
  std::size_t axis_count_ = 0;
  std::int32_t first_frame_ = 0;
  std::int32_t last_frame_ = 0;
};

extern template class Move<double>;
extern template class Move<float>;

}  // namespace inbetween
