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

/// The time line on which a move, or a part of it, is played, with a pre-roll where it starts moving and a
/// post-roll where it ends moving.

namespace inbetween {

/// Whether a track is moving at its first or last frame: the drawn speed, or that of the parameter, is not 0
/// there. (A curve that rises from 0 at once, 0 = v_0 < v_1, is not moving yet: its acceleration steps, which
/// bound_move tells.)
bool is_moving(const Track& track, RollEnd end);

/// The motion of every axis where a roll would join the whole move, track after track: of a track that is
/// moving there Track::motion; of one that rests its position, at rest. Returns whether any axis moves, so
/// that a roll is needed. `out` has an entry for every axis of all tracks. O(axes).
bool joints_of(std::span<const Track> tracks, RollEnd end, std::span<AxisMotion> out);

/// The rolls of a move: of every axis of all tracks, track after track, or of none.
struct MoveRolls {
  std::span<const RollAxis> before = {};
  std::span<const RollAxis> after = {};
};

/// How long a whole move lasts, and how many axes it has.
struct MoveLength {
  std::int32_t frames = 0;  ///< N: its frames are 0..N
  FrameRate fps;
  std::size_t axes = 0;  ///< of all its tracks
};

/// Tells it of tracks that play side by side. Errors: wrong_count (no track), out_of_range (tracks of
/// different frames or frame rate). O(tracks).
Result<MoveLength> length_of(std::span<const Track> tracks);

/// The time line first_frame()..last_frame() of the axes of all tracks, track after track: the frames part()
/// of the whole move, and the rolls that join them. A part of a move is a move of its own, with the frame
/// numbers of the whole. What the axes do on it is PlayedMotion. Refers to the caller's memory.
class Move {
 public:
  /// The whole move of tracks side by side where no part is given. Errors: those of length_of; wrong_count
  /// (rolls that are neither none nor one for each axis), out_of_range (a part that is not
  /// 0 <= first < last <= N; rolls at the wrong end, at another frame than its first or last, of different
  /// frames or frame rate). O(axes).
  static Result<Move> make(std::span<const Track> tracks, const MoveRolls& rolls,
                           const std::optional<WholeFrames>& part = std::nullopt);
  /// The same where the tracks are not there any more, and their trajectories are.
  static Result<Move> make(const MoveLength& whole, const MoveRolls& rolls,
                           const std::optional<WholeFrames>& part = std::nullopt);

  [[nodiscard]] const MoveRolls& rolls() const { return rolls_; }
  [[nodiscard]] std::size_t axis_count() const { return whole_.axes; }
  /// N of the whole.
  [[nodiscard]] std::int32_t frames() const { return whole_.frames; }
  /// The frames of the whole that are played: 0..N, or a part of them.
  [[nodiscard]] const WholeFrames& part() const { return part_; }
  [[nodiscard]] FrameRate frame_rate() const { return whole_.fps; }
  /// part().first less the frames of the pre-roll.
  [[nodiscard]] std::int32_t first_frame() const { return first_frame_; }
  /// part().last and the frames of the post-roll.
  [[nodiscard]] std::int32_t last_frame() const { return last_frame_; }

  /// The time of tick k, counted from first_frame(), at `rate_hz` ticks a second. Exact
  /// (frame_time_of_tick).
  [[nodiscard]] FrameTime time_of_tick(std::int64_t tick, std::int32_t rate_hz) const {
    FrameTime time = frame_time_of_tick(tick, frame_rate(), rate_hz);
    time.frame += first_frame_;
    return time;
  }
  /// The first tick at or after last_frame().
  [[nodiscard]] std::int64_t last_tick_at(std::int32_t rate_hz) const {
    return last_tick(last_frame_ - first_frame_, frame_rate(), rate_hz);
  }

  /// The rolls that hold at a time; none on the way from the first frame of part() to its last.
  [[nodiscard]] std::span<const RollAxis> rolls_at(const FrameTime& time) const {
    if (is_before(time)) return rolls_.before;
    return is_behind(time) ? rolls_.after : std::span<const RollAxis>();
  }
  /// Before its first frame and behind its last one, and on that of a part, the motion is a roll's or none.
  [[nodiscard]] bool rests_at(const FrameTime& time) const { return is_before(time) || is_behind(time); }
  /// Where no roll joins it, a part rests on its first and its last frame.
  [[nodiscard]] FrameTime within_part(const FrameTime& time) const {
    if (is_before(time)) return {part_.first, 0};
    return is_behind(time) ? FrameTime{part_.last, 0} : time;
  }

 private:
  Move(const MoveLength& whole, const MoveRolls& rolls, const WholeFrames& part)
      : whole_(whole), rolls_(rolls), part_(part), first_frame_(part.first), last_frame_(part.last) {
    if (!rolls.before.empty()) first_frame_ -= rolls.before.front().span().frames;
    if (!rolls.after.empty()) last_frame_ += rolls.after.front().span().frames;
  }
  [[nodiscard]] bool is_before(const FrameTime& time) const { return time.frame < part_.first; }
  /// On the last frame of a part the motion is that with which it arrives, and the roll has it.
  [[nodiscard]] bool is_behind(const FrameTime& time) const {
    return time.frame > part_.last ||
           (time.frame == part_.last && (time.fraction > 0 || part_.last < frames()));
  }

  MoveLength whole_;
  MoveRolls rolls_;
  WholeFrames part_;
  std::int32_t first_frame_ = 0;
  std::int32_t last_frame_ = 0;
};

}  // namespace inbetween
