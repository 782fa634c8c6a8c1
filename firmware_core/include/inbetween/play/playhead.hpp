#pragma once

#include <cstdint>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/result.hpp"
#include "inbetween/limits/move.hpp"
#include "inbetween/limits/stop_bounds.hpp"
#include "inbetween/play/travel.hpp"
#include "inbetween/timing/frame_time.hpp"

/// Time as an axis: where on the time line the move is, and how fast time runs there.

namespace inbetween {

/// What the playhead does at an end of the time line.
enum class Repeat : std::uint8_t {
  none,       ///< rests there
  loop,       ///< goes on at the other end
  ping_pong,  ///< goes back
};

enum class PlayheadState : std::uint8_t {
  resting,     ///< rate 0
  playing,     ///< towards an end, at its rate or on the way to it
  slowing,     ///< to rest, wherever that will be
  travelling,  ///< from rest to rest, to a frame
  scrubbing,   ///< after a target that somebody moves
};

/// What a tick brought about.
enum class PlayheadEvent : std::uint8_t {
  none,
  finished,  ///< rests at the end of the time line that it was playing towards
  stopped,   ///< rests where it was told to slow down
  arrived,   ///< rests exactly on the frame that it travelled to
  repeated,  ///< passed an end and goes on
  opened,    ///< is where an exposure in motion begins, at its even rate
  closed,    ///< the exposure is over, and the rate falls
};

enum class Direction : std::int8_t { backward = -1, forward = 1 };

/// A frame that is exposed while the rig moves (go-motion): the shutter is open from one place of the time
/// line to another, which takes `seconds`. Both may lie beyond the ends of the time line, where nothing
/// moves.
template <Precise Real>
struct Exposure {
  FrameTime<Real> open, close;
  Real seconds = 0;
};

/// A place on the time line and the rate at which time runs, forward or backward. Nothing but the rate is
/// ever changed, so that the rig never leaves the path; and the rate changes within the bounds of
/// StopBounds, so that no axis leaves its stop limits, what was begun can be finished, and every stop is no
/// longer than StopBounds foretells. What is meant to rest again keeps lower bounds if there are any: a
/// travel to a frame and an exposure keep those of the motion limits, and a stop on the way those of the stop
/// limits.
///
/// Method: to a rate in the quickest way, a bend up (|r''| = R2), a straight stretch (|r'| = R1) and a bend
/// down (|r''| = Q) that meets the rate exactly. On every tick r'' is the one that keeps the state within the
/// bounds of the place. A turn is a stop and a start. To a frame the playhead travels from rest to rest with
/// the least bounds of the stretch, in closed form from its start, so that it rests on the frame exactly.
///
/// At an end of the time line nothing moves, the rate is of no consequence: a move that is played from there
/// runs at its rate from the first tick on, and needs exactly its frames.
template <Precise Real>
class Playhead {
 public:
  /// At rest on the first frame. Refers to all of them. Ticks come `rate_hz` times a second. `travels` are
  /// bounds, made for lower limits, that what goes from rest to rest keeps as well, and their rate.
  Playhead(const Move<Real>& move, const StopBounds<Real>& bounds, std::int32_t rate_hz,
           const StopBounds<Real>* travels = nullptr);

  /// Plays towards an end at the override rate. If it runs the other way it turns.
  /// Errors: out_of_range (it is at that end already, and does not repeat).
  Status play(Direction direction);
  /// The controlled stop: rest as soon as the bounds allow. Always possible; while resting nothing changes.
  void stop();
  /// Time stands still at once, where it is. Only for a rig that is not sent its positions any more: it does
  /// not follow, and has to be where the playhead is before it goes on.
  void halt();
  /// To a frame, and to rest there; where time runs it is stopped first.
  /// Errors: out_of_range (not on the time line).
  Status go_to(std::int32_t frame);
  /// To the next whole frame in a direction, counted from the frame that it is travelling to.
  /// Errors: out_of_range (beyond the end).
  Status step(Direction direction);
  /// Travels to where the run-up to an exposure starts, and to rest there (`arrived`).
  /// Errors: out_of_range (not resting; the exposure covers no time, or needs a rate above that of the
  /// bounds), not_converged (no run-up within the bounds was found).
  /// O(cells of the stop bounds that it passes).
  Status go_to_run_up(const Exposure<Real>& exposure);
  /// From there: a run-up, then from open to close at the even rate (close - open) / seconds, then a run-out
  /// to rest behind it (`arrived`). Opens on a tick (`opened`), and keeps the rate until the first tick at or
  /// after the end of the exposure (`closed`). Errors: those of go_to_run_up; out_of_range (not at its
  /// start).
  Status expose(const Exposure<Real>& exposure);
  /// Follows a target, which may be moved at any time, as fast as the override rate allows; rests there.
  /// Errors: out_of_range (not on the time line).
  Status scrub_to(const FrameTime<Real>& target);
  /// The rate of playing, as a share of the drawn speed; what is running changes to it.
  /// Errors: out_of_range (not in 0 < rate <= StopBounds::rate()).
  Status set_override(Real rate);
  /// Errors: no_solution, with axis, where a loop would step: the positions of an axis at both ends of the
  /// time line differ.
  Status set_repeat(Repeat repeat);
  /// At rest on a frame of the time line without having moved there: for a rig that has been moved otherwise.
  /// Errors: out_of_range (not on the time line; not resting).
  Status place_on(std::int32_t frame);

  /// One tick later. O(1), no allocation.
  PlayheadEvent tick();

  [[nodiscard]] const FrameTime<Real>& time() const { return time_; }
  /// Seconds of the time line a second, negative backward.
  [[nodiscard]] Real rate() const { return rate_; }
  /// Of the rate, per second.
  [[nodiscard]] Real rate_change() const { return change_; }
  [[nodiscard]] Real override_rate() const { return override_; }
  [[nodiscard]] Repeat repeat() const { return repeat_; }
  [[nodiscard]] PlayheadState state() const { return state_; }
  [[nodiscard]] bool is_resting() const { return state_ == PlayheadState::resting; }

 private:
  /// From rest to rest.
  struct Journey {
    FrameTime<Real> from, to;
    Real sign = 1;  ///< of the rate
    Travel<Real> course;
    std::int64_t opening_tick = -1;  ///< counted from the start; -1: no shutter opens
    std::int64_t closing_tick = -1;
    std::int64_t ticks = 0;  ///< since the start
  };

  [[nodiscard]] Real seconds_between(const FrameTime<Real>& from, const FrameTime<Real>& to) const;
  [[nodiscard]] bool is_on_time_line(const FrameTime<Real>& time) const;
  [[nodiscard]] FrameTime<Real> end_towards(Direction direction) const;
  void begin_travel(const FrameTime<Real>& to);
  [[nodiscard]] StopBound<Real> travel_bound(const FrameTime<Real>& from, const FrameTime<Real>& to) const;
  [[nodiscard]] Real top_travel_rate() const;
  [[nodiscard]] Result<Journey> journey_of(const Exposure<Real>& exposure) const;
  PlayheadEvent tick_travel();
  void set_travelled(const FrameTime<Real>& from, Real way_s, Real rate, Real change);
  [[nodiscard]] Real scrub_rate() const;
  PlayheadEvent tick_ramp(Real target);
  void follow_to(Real target);
  [[nodiscard]] bool lands_within_tick(Real target, Real jerk) const;
  void land(Real target);
  void move_on(Real jerk, Real seconds);
  void cruise();
  void anchor_here();
  PlayheadEvent settle();
  PlayheadEvent pass_end(Direction direction);
  void rest();
  void advance_by(Real seconds_of_time_line);

  const Move<Real>* move_;
  const StopBounds<Real>* bounds_;
  const StopBounds<Real>* travels_;  ///< null: the same
  std::int64_t unit_;                ///< a frame is so many ticks of numerator() each
  Real tick_s_;
  Real fps_;
  FrameTime<Real> time_;
  Real rate_ = 0;
  Real change_ = 0;
  Real override_;
  Direction direction_ = Direction::forward;
  Repeat repeat_ = Repeat::none;
  PlayheadState state_ = PlayheadState::resting;
  bool has_next_frame_ = false;
  std::int32_t next_frame_ = 0;  ///< to travel to once at rest
  FrameTime<Real> anchor_;       ///< where the rate became even ...
  std::int32_t cruise_frames_ = 0;
  std::int64_t cruise_phase_ = 0;  ///< ... and how far it has come since, in unit_ths of a frame
  Journey travel_;
  FrameTime<Real> scrub_target_;
};

extern template class Playhead<double>;
extern template class Playhead<float>;

}  // namespace inbetween
