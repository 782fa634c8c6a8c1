#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "inbetween/base/fixed_vector.hpp"
#include "inbetween/base/precision.hpp"
#include "inbetween/base/result.hpp"
#include "inbetween/play/playhead.hpp"
#include "inbetween/steps/edge_instant.hpp"
#include "inbetween/timing/frame_time.hpp"

/// Times the pulses on lines: a pulse begins when the playhead passes its place on the time line.

namespace inbetween {

/// A pulse on a line, 0..63 in its request, that begins when the playhead passes `at`.
struct TimedPulse {
  FrameTime at;
  std::int64_t width_ns = 0;  ///< above 0, on the clock, whatever the playhead does meanwhile
  std::int32_t line = 0;
};

/// The motion of the playhead in a tick, with its times.
struct CueTick {
  PlayheadPlace from, to;
  Repeat repeated = Repeat::none;  ///< its action at an end of the time line, if it passed one
  std::int64_t start_ns = 0;
  std::int64_t end_ns = 0;
};

/// A pulse that begins.
struct BegunPulse {
  std::size_t pulse = 0;  ///< index in the pulses of CueTimer::make
  std::int64_t at_ns = 0;
  bool is_merged = false;  ///< its line was still on
};

/// Memory for the results of a tick, owned by the caller.
struct CueRoom {
  std::span<BegunPulse> begun;
  std::span<EdgeInstant> instants;  ///< instants_for(begun.size())
};
constexpr std::size_t instants_for(std::size_t begun) {
  return 2 * begun + 64;
}

/// The number of entries of a CueRoom that are filled.
struct CueCount {
  std::size_t begun = 0;
  std::size_t instants = 0;
};

/// Counts since construction.
struct CueCounters {
  std::uint64_t merged = 0;     ///< pulses that began while their line was on
  std::uint64_t lost = 0;       ///< pulses for which a tick had no room
  std::uint64_t late_ends = 0;  ///< pulses that were to end between two ticks, and ended with the later one
};

/// Decides when lines go on and off while a playhead moves.
///
/// A pulse begins when the playhead comes to its place, or leaves it, in forward direction. It begins once,
/// even if the playhead rests there. In backward direction no pulse begins, but the playhead arms every pulse
/// that it passes again, that at the turn included. A loop, a turn at an end, or a playhead that is put down
/// elsewhere arms the pulses ahead too. A pulse that is passed exactly at the end of a tick begins with the
/// next tick.
///
/// A line is on until the last of its pulses is over. Pulses may overlap or touch if time runs faster than
/// drawn. They are then one pulse on the line, and are counted.
///
/// Method: between two ticks the playhead moves on the quintic that has its place, rate and rate change at
/// both ticks, as axes do between two setpoints; bisection finds the time. This is exact if r'' is constant
/// within the tick; if r'' steps, it is off by less than |r''| tick^3 / 100 seconds of the time line. A
/// playhead that comes to an end of the time line keeps its rate change until there.
///
/// Refers to the pulses. No allocation.
class CueTimer {
 public:
  static constexpr std::size_t max_lines = 64;

  /// `pulses` are in the order of their places, on a time line from first to last frame.
  /// Errors: out_of_range with key, the number of the pulse (out of order; its place, line or width).
  /// O(pulses).
  static Result<CueTimer> make(std::span<const TimedPulse> pulses, std::int32_t first_frame,
                               std::int32_t last_frame, FrameRate fps);

  /// Writes the pulses that begin in the tick and the instants at which lines change, all in [start, end), in
  /// the order of time. In `levels` on is 1. Errors, after which nothing has changed: out_of_range (the tick
  /// takes no time, or begins before the last one ended), capacity (the instants of the room). O(log pulses +
  /// 40 a pulse that begins + lines a pulse that ends).
  Result<CueCount> advance(const CueTick& tick, CueRoom room);
  /// Ends everything when no tick follows: a pulse that was passed exactly at the end of the last tick
  /// begins, and all pulses that have begun end, however much later. Errors: capacity.
  Result<CueCount> end_all(CueRoom room);

  [[nodiscard]] const CueCounters& counters() const { return counters_; }

 private:
  /// Pulses first..last-1.
  struct Range {
    std::size_t first = 0, last = 0;
  };
  /// The motion of the playhead within a tick, in frames, as a function of time.
  struct TickMotion;
  struct Leg;
  struct Output;

  CueTimer(std::span<const TimedPulse> pulses, std::int32_t first_frame, std::int32_t last_frame, double fps)
      : pulses_(pulses), first_{first_frame, 0}, last_{last_frame, 0}, fps_(fps) {}

  [[nodiscard]] std::size_t first_at(const FrameTime& time) const;
  [[nodiscard]] std::size_t first_behind(const FrameTime& time) const;
  void go_through(const CueTick& tick, Output& out);
  void go(const Leg& leg, const TickMotion& motion, Output& out);
  void begin_due(Output& out);
  void begin(std::size_t pulse, std::int64_t at_ns, Output& out);
  void end_before(std::int64_t at_ns, Output& out);
  [[nodiscard]] static Status check_room(const CueRoom& room);

  std::span<const TimedPulse> pulses_;
  FrameTime first_, last_;
  double fps_;
  bool has_place_ = false;
  FrameTime here_;
  std::size_t next_ = 0;       ///< the first pulse that the playhead comes to on its way forward
  FixedVector<Range, 2> due_;  ///< pulses passed exactly at the end of the last tick, on both sides of an end
  std::int64_t ended_ns_ = 0;  ///< the last tick
  std::uint64_t lines_on_ = 0;  ///< bit i: line i
  std::array<std::int64_t, max_lines> off_at_ns_{};
  CueCounters counters_;
};

}  // namespace inbetween
