#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/result.hpp"
#include "inbetween/limits/roll.hpp"
#include "inbetween/timing/frame_time.hpp"
#include "inbetween/timing/track.hpp"

/// A move, or a part of it, as it is played: its tracks side by side on one time line, with a pre-roll where
/// it starts moving and a post-roll where it ends moving.

namespace inbetween {

/// Whether a track is moving at its first or last frame: the drawn speed, or that of the parameter, is not 0
/// there. (A curve that rises from 0 at once, 0 = v_0 < v_1, is not moving yet: its acceleration steps, which
/// bound_move tells.)
template <Precise Real>
bool is_moving(const Track<Real>& track, RollEnd end);

/// The motion of every axis where a roll would join the whole move, track after track: of a track that is
/// moving there Track::motion; of one that rests its position, at rest. Returns whether any axis moves, so
/// that a roll is needed. `out` has an entry for every axis of all tracks. O(axes).
template <Precise Real>
bool joints_of(std::span<const Track<Real>> tracks, RollEnd end, std::span<AxisMotion<Real>> out);

/// The rolls of a move: of every axis of all tracks, track after track, or of none.
template <Precise Real>
struct MoveRolls {
  std::span<const RollAxis<Real>> before = {};
  std::span<const RollAxis<Real>> after = {};
};

/// The axes of all tracks, track after track, on the time line first_frame()..last_frame(): the frames part()
/// of the tracks, and the rolls that join them. A part of a move is a move of its own, with the frame numbers
/// of the whole: on its frames the positions are those of the whole, bit for bit. Refers to the caller's
/// memory.
template <Precise Real>
class Move {
 public:
  /// The whole move where no part is given. Errors: wrong_count (no track; rolls that are neither none nor
  /// one for each axis), out_of_range (tracks of different frames or frame rate; a part that is not
  /// 0 <= first < last <= N; rolls at the wrong end, at another frame than its first or last, of different
  /// frames or frame rate). O(axes).
  static Result<Move> make(std::span<const Track<Real>> tracks, const MoveRolls<Real>& rolls,
                           const std::optional<WholeFrames>& part = std::nullopt);

  [[nodiscard]] std::span<const Track<Real>> tracks() const { return tracks_; }
  [[nodiscard]] const MoveRolls<Real>& rolls() const { return rolls_; }
  [[nodiscard]] std::size_t axis_count() const { return axis_count_; }
  /// N of the tracks.
  [[nodiscard]] std::int32_t frames() const { return tracks_.front().frames(); }
  /// The frames of the tracks that are played: 0..N, or a part of them.
  [[nodiscard]] const WholeFrames& part() const { return part_; }
  [[nodiscard]] FrameRate frame_rate() const { return tracks_.front().frame_rate(); }
  /// part().first less the frames of the pre-roll.
  [[nodiscard]] std::int32_t first_frame() const { return first_frame_; }
  /// part().last and the frames of the post-roll.
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

  /// The rolls that hold at a time; none on the way from the first frame of part() to its last.
  [[nodiscard]] std::span<const RollAxis<Real>> rolls_at(const FrameTime<Real>& time) const {
    if (is_before(time)) return rolls_.before;
    return is_behind(time) ? rolls_.after : std::span<const RollAxis<Real>>();
  }
  /// Before its first frame and behind its last one, and on that of a part, the motion is a roll's or none.
  [[nodiscard]] bool rests_at(const FrameTime<Real>& time) const {
    return is_before(time) || is_behind(time);
  }
  /// Where no roll joins it, a part rests on its first and its last frame.
  [[nodiscard]] FrameTime<Real> within_part(const FrameTime<Real>& time) const {
    if (is_before(time)) return {part_.first, 0};
    return is_behind(time) ? FrameTime<Real>{part_.last, 0} : time;
  }

  /// The position of every axis. Before first_frame() and after last_frame() the axes rest where they are on
  /// it; on the frames part() the tracks decide, to the last bit. `out` has axis_count() entries. O(axes).
  void positions(const FrameTime<Real>& time, std::span<Real> out) const;
  /// Position, velocity, acceleration and jerk of every axis, the worst of what the tracks say of their
  /// derivatives. Resting outside the time line: derivatives 0. O(axes).
  Derivatives motion(const FrameTime<Real>& time, std::span<AxisMotion<Real>> out) const;

 private:
  Move(std::span<const Track<Real>> tracks, const MoveRolls<Real>& rolls, const WholeFrames& part)
      : tracks_(tracks), rolls_(rolls), part_(part), first_frame_(part.first), last_frame_(part.last) {
    if (!rolls.before.empty()) first_frame_ -= rolls.before.front().span().frames;
    if (!rolls.after.empty()) last_frame_ += rolls.after.front().span().frames;
  }
  [[nodiscard]] bool is_before(const FrameTime<Real>& time) const { return time.frame < part_.first; }
  /// On the last frame of a part the motion is that with which it arrives, and the roll has it.
  [[nodiscard]] bool is_behind(const FrameTime<Real>& time) const {
    return time.frame > part_.last ||
           (time.frame == part_.last && (time.fraction > 0 || part_.last < frames()));
  }

  std::span<const Track<Real>> tracks_;
  MoveRolls<Real> rolls_;
  WholeFrames part_;
  std::size_t axis_count_ = 0;
  std::int32_t first_frame_ = 0;
  std::int32_t last_frame_ = 0;
};

extern template class Move<double>;
extern template class Move<float>;

}  // namespace inbetween
