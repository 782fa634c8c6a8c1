#pragma once

#include <cstdint>
#include <span>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/result.hpp"
#include "inbetween/limits/move.hpp"
#include "inbetween/limits/stop_bounds.hpp"
#include "inbetween/play/travel.hpp"
#include "inbetween/timing/frame_time.hpp"

/// Time as an axis: the place of the move on the time line, and the rate at which time runs there.

namespace inbetween {

/// The action of the playhead at an end of the time line.
enum class Repeat : std::uint8_t {
  none,       ///< rests at the end
  loop,       ///< goes on at the other end
  ping_pong,  ///< goes back
};

enum class PlayheadState : std::uint8_t {
  resting,     ///< rate 0
  playing,     ///< towards an end, at its rate or on the way to it
  slowing,     ///< to rest, wherever that will be
  travelling,  ///< from rest to rest, to a frame
  following,   ///< from rest to rest, where another playhead was tick by tick
};

/// The event of a tick.
enum class PlayheadEvent : std::uint8_t {
  none,
  finished,  ///< rests at the end of the time line that it was playing towards
  stopped,   ///< rests where it was told to slow down
  arrived,   ///< rests exactly on the frame that it travelled to
  repeated,  ///< passed an end and goes on
  opened,    ///< an exposure in motion begins, at its constant rate
  closed,    ///< the exposure is over, and the rate falls
};

enum class Direction : std::int8_t { backward = -1, forward = 1 };

/// A frame that is exposed while the rig moves (go-motion): the shutter is open from one place of the time
/// line to another, which takes `seconds`. Both may lie beyond the ends of the time line, where nothing
/// moves.
struct Exposure {
  FrameTime open, close;
  double seconds = 0;
};

/// The place of a playhead, and the rate at which time runs there.
struct PlayheadPlace {
  FrameTime time;
  double rate = 0;         ///< Playhead::rate
  double rate_change = 0;  ///< Playhead::rate_change

  friend constexpr bool operator==(const PlayheadPlace&, const PlayheadPlace&) = default;
};

/// The stretch of the time line that an exposure in motion passes, from rest to rest.
struct ExposureTravel {
  FrameTime from, to;
};

/// A place on the time line and the rate at which time runs, forward or backward. Commands change nothing but
/// the rate, so that the rig never leaves the path. The rate changes within the bounds of StopBounds, so that
/// no axis leaves its stop limits, every change can be completed, and no stop is longer than StopBounds
/// states. What is no stop keeps the bounds of the motion limits, if there are any: a travel to a frame, an
/// exposure, and every change of the rate to that of a play or an override. A turn begins with a stop. A rate
/// change that a stop began, and which is more than those bounds permit, is released first.
///
/// The bounds of the motion limits are a ladder for rates that rise from rung to rung. The higher the rate,
/// the less the motion leaves of its limits, and at the highest often nothing: the rate then rises to the
/// rung below, and waits there for a place that leaves more.
///
/// Method: the rate goes to its target in the quickest way, in three phases: |r''| = R2 until |r'| = R1, then
/// r'' = 0, then |r''| = Q until r' = 0 exactly at the target. On every tick r'' keeps the state within the
/// bounds of the place. A turn is a stop and a start. To a frame the playhead travels from rest to rest with
/// the smallest bounds between, in closed form from its start, so that it rests on the frame exactly.
///
/// At an end of the time line nothing moves at any rate. Therefore a move that is played from there runs at
/// its full rate from the first tick on, and takes exactly its frames.
class Playhead {
 public:
  /// Makes a playhead at rest on the first frame. It refers to all of them. Ticks come `rate_hz`
  /// times a second. `rungs` are bounds `within` the others, made for the motion limits; the lowest rate is
  /// first, and the rate of the last is that of `bounds`. A travel and an exposure keep the first, and its
  /// rate; no place of it makes them wait.
  Playhead(const Move& move, const StopBounds& bounds, std::int32_t rate_hz,
           std::span<const StopBounds> rungs = {});

  /// Plays towards an end at the override rate. A playhead that runs the other way turns. Errors:
  /// wrong_state (it is at that end already, and does not repeat).
  Status play(Direction direction);
  /// Makes a controlled stop: the playhead rests as soon as the bounds allow. This is always possible; a
  /// playhead at rest stays at rest. A travel that would end as soon goes on to its end (`arrived`), so that
  /// no stop passes the place at which a travel was to rest.
  void stop();
  /// Lets time stand still at once. Use it only for a rig whose positions are no longer sent: such a rig does
  /// not follow, and must be where the playhead is before it goes on.
  void halt();
  /// Travels to a place and rests there exactly. A running playhead stops first. Errors: out_of_range (not on
  /// the time line).
  Status go_to(const FrameTime& place);
  Status go_to(std::int32_t frame) { return go_to(FrameTime{frame, 0}); }
  /// Travels to the next whole frame in a direction, counted from the frame that it is travelling to. Errors:
  /// out_of_range (beyond the end), wrong_state (it plays or slows down).
  Status step(Direction direction);
  /// The travel of an exposure with its run-up and run-out. Errors and cost: those of go_to_run_up, which
  /// needs a playhead that rests.
  [[nodiscard]] Result<ExposureTravel> travel_of(const Exposure& exposure) const;
  /// Travels to the start of the run-up to an exposure, and rests there (`arrived`).
  /// Errors: wrong_state (not resting), out_of_range (the exposure covers no time, or needs a rate above that
  /// of the bounds), not_converged (no run-up within the bounds was found). O(cells of the stop bounds that
  /// it passes).
  Status go_to_run_up(const Exposure& exposure);
  /// Exposes from there: a run-up, then the constant rate (close - open) / seconds from open to close, then a
  /// run-out to rest behind it (`arrived`). The shutter opens on a tick (`opened`), and the rate stays until
  /// the first tick at or after the end of the exposure (`closed`). Errors: those of go_to_run_up;
  /// wrong_state (not at its start).
  Status expose(const Exposure& exposure);
  /// Plays again what another playhead did, to the last bit: the places where it was after each tick, up to
  /// that where it rests (`finished` at the end of the time line, `stopped` elsewhere). On the way it is
  /// stopped, turned and sent elsewhere as one that plays. Refers to the places until it is somewhere else.
  /// Domain: what can_follow() from here. Errors: wrong_state (not resting), wrong_count (no place). O(1).
  Status follow(std::span<const PlayheadPlace> places);
  /// Whether that keeps the bounds, from where the playhead rests. Errors: those of follow; out_of_range,
  /// with frame, and `needed` the number of the place, from 0: it is not on the time line, its rate or the
  /// change of that is not within the bounds, a tick does not lead to it from the one before, the last does
  /// not rest. O(places).
  [[nodiscard]] Status can_follow(std::span<const PlayheadPlace> places) const;
  /// Sets the rate of playing, as a share of the drawn speed. A running playhead changes to it. Errors:
  /// out_of_range (not in 0 < rate <= StopBounds::rate()).
  Status set_override(double rate);
  /// Domain: a loop only of what can_loop().
  void set_repeat(Repeat repeat) { repeat_ = repeat; }
  /// Puts a playhead at rest on a frame without a travel, for a rig that was moved otherwise. Errors:
  /// out_of_range (not on the time line), wrong_state (not resting).
  Status place_on(std::int32_t frame);
  /// Takes the playhead, with whatever it does and will do, so many whole frames along the time line. For a
  /// move that does the same there, turn after turn: nothing is rounded, and no number grows. Domain: here
  /// and to where it travels there is a time line so much further too.
  void shift_by(std::int32_t frames);

  /// One tick later. O(1), no allocation.
  PlayheadEvent tick();

  [[nodiscard]] const FrameTime& time() const { return time_; }
  /// Seconds of the time line a second, negative backward.
  [[nodiscard]] double rate() const { return rate_; }
  /// The change of the rate, per second.
  [[nodiscard]] double rate_change() const { return change_; }
  [[nodiscard]] double override_rate() const { return override_; }
  /// The highest override.
  [[nodiscard]] double top_rate() const { return bounds_->rate(); }
  [[nodiscard]] Repeat repeat() const { return repeat_; }
  [[nodiscard]] PlayheadState state() const { return state_; }
  [[nodiscard]] bool is_resting() const { return state_ == PlayheadState::resting; }
  /// It slows down to play the other way.
  [[nodiscard]] bool is_turning() const {
    return state_ == PlayheadState::playing && rate_ * static_cast<double>(direction_) < 0;
  }

 private:
  /// A travel from rest to rest.
  struct Journey {
    FrameTime from, to;
    double sign = 1;  ///< of the rate
    Travel course;
    std::int64_t opening_tick = -1;  ///< counted from the start; -1: no shutter opens
    std::int64_t closing_tick = -1;
    std::int64_t ticks = 0;  ///< since the start
  };

  [[nodiscard]] double seconds_between(const FrameTime& from, const FrameTime& to) const;
  [[nodiscard]] bool is_on_time_line(const FrameTime& time) const;
  [[nodiscard]] FrameTime end_towards(Direction direction) const;
  void begin_travel(const FrameTime& to);
  [[nodiscard]] StopBound travel_bound(const FrameTime& from, const FrameTime& to) const;
  [[nodiscard]] double top_travel_rate() const;
  [[nodiscard]] Result<Journey> journey_of(const Exposure& exposure) const;
  PlayheadEvent tick_travel();
  [[nodiscard]] bool leads_to(const PlayheadPlace& last, const PlayheadPlace& next) const;
  [[nodiscard]] bool is_end(const FrameTime& time) const;
  PlayheadEvent tick_following();
  [[nodiscard]] bool travel_ends_like_a_stop() const;
  PlayheadEvent tick_ramp(double target);
  void change_to(double target);
  [[nodiscard]] const StopBounds* rung_from(double target) const;
  void release();
  void follow_to(double target, const StopBounds& within);
  [[nodiscard]] bool is_steady(double target) const;
  void settle_on(double target);
  [[nodiscard]] bool lands_within_tick(double target, double jerk) const;
  void land(double target);
  void move_on(double jerk, double seconds);
  void cruise();
  void anchor_here();
  PlayheadEvent settle();
  PlayheadEvent pass_end(Direction direction);
  void rest();
  void advance_by(double seconds_of_time_line);

  const Move* move_;
  const StopBounds* bounds_;
  std::span<const StopBounds> rungs_;
  const StopBounds* rung_ = nullptr;  ///< on which the rate changes
  std::int64_t unit_;                 ///< a frame is so many ticks of numerator() each
  double tick_s_;
  double fps_;
  FrameTime time_;
  double rate_ = 0;
  double change_ = 0;
  double override_;
  Direction direction_ = Direction::forward;
  Repeat repeat_ = Repeat::none;
  PlayheadState state_ = PlayheadState::resting;
  bool has_next_ = false;
  FrameTime next_;    ///< to travel to once at rest
  FrameTime anchor_;  ///< the place where the rate became constant ...
  std::int32_t cruise_frames_ = 0;
  std::int64_t cruise_phase_ = 0;  ///< ... and how far it has come since, in unit_ths of a frame
  Journey travel_;
  std::span<const PlayheadPlace> followed_;  ///< that are left
};

inline PlayheadPlace place_of(const Playhead& playhead) {
  return {playhead.time(), playhead.rate(), playhead.rate_change()};
}

}  // namespace inbetween
