#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/result.hpp"
#include "inbetween/limits/limits.hpp"
#include "inbetween/limits/motion_cells.hpp"
#include "inbetween/limits/move.hpp"
#include "inbetween/timing/frame_time.hpp"

/// How hard the playhead may brake and speed up at every place of the time line, so that every axis stays
/// inside its stop limits and every stop can be brought to its end.
///
/// The playhead is at u on the time line, in seconds of the move, with rate r = du/dt, rate change a = dr/dt
/// (1/s) and rate jerk j = da/dt (1/s^2). p1, p2, p3 being the derivatives of an axis' position in u, the
/// axis moves with
///     velocity p1 r,   acceleration p2 r^2 + p1 a,   jerk p3 r^3 + 3 p2 r a + p1 j.

namespace inbetween {

/// Nothing stops quicker, whatever its axes could bear, than in so many ticks, and no jerk phase of the rate
/// is shorter than so many: in less a playhead that advances tick by tick could not follow the bounds. At 250
/// Hz a stop takes 96 ms at least.
inline constexpr int min_stop_ticks = 16;
inline constexpr int min_jerk_ticks = 8;

/// One cell of the time line. `rate_change` and `release_jerk` are those of its beginning, linear from there
/// to the next.
struct StopCell {
  double rate_change = 0;
  double rate_jerk = 0;
  double release_jerk = 0;
};

/// The bounds at one place. |a| <= rate_change, |j| <= rate_jerk.
struct StopBound {
  double rate_change = 0;   ///< R1, 1/s
  double rate_jerk = 0;     ///< R2, 1/s^2
  double release_jerk = 0;  ///< Q <= R2, 1/s^2: what a release may be planned with

  /// Of each bound the smaller one.
  [[nodiscard]] StopBound lower(const StopBound& other) const {
    return {std::min(rate_change, other.rate_change), std::min(rate_jerk, other.rate_jerk),
            std::min(release_jerk, other.release_jerk)};
  }
};

/// From the highest rate, and from the worst rate change there, to rest.
struct StopLength {
  double seconds = 0;
  double frames = 0;  ///< on the time line
};
struct LongestStop {
  StopLength length;
  double from_frame = 0;  ///< near which it begins
  bool forward = true;
};

enum class StopQuantity : std::uint8_t { acceleration, jerk };

/// A place from which no stop keeps the limits: what the axis does at the highest rate alone takes all of
/// them.
struct StopObstacle {
  std::int32_t axis = -1;  ///< counted through the tracks; behind them the motors
  StopQuantity quantity = StopQuantity::acceleration;
  double value = 0;  ///< a bound of |p2| rate^2 or |p3| rate^3; infinity where there is none
  double limit = 0;
  double frame = 0;  ///< near which it is; it need not be a whole one, and is negative on a pre-roll
};

class StopBounds;

/// The caps of |a| and |j|, where the axes could bear more.
struct StopCaps {
  double max_rate_change;
  double max_rate_jerk;

  StopCaps(double rate, double tick_seconds)
      : max_rate_change(rate / (min_stop_ticks * tick_seconds)),
        max_rate_jerk(max_rate_change / (min_jerk_ticks * tick_seconds)) {}
};

/// Stop bounds are made for this.
struct StopRequest {
  const MotionCells& motion;  ///< what the move does
  /// One for every axis, track after track, and then one for every motor, in units of the motor.
  std::span<const AxisLimits> limits;
  double rate = 1;                  ///< the highest |r|
  double tick_seconds = 1.0 / 250;  ///< of the playhead that will follow the bounds
  /// Bounds of stops, made for the same move and as many cells, for at least this rate: what is made stays
  /// within them. It is for changes of the rate that are no stop: `limits` are those of the motion.
  const StopBounds* within = nullptr;
  /// Such changes may wait. Where the motion leaves next to nothing of the limits the rate stays what it is:
  /// R1 = R2 = 0 there, and no place is an obstacle.
  bool may_wait = false;

  [[nodiscard]] StopCaps caps() const { return {rate, tick_seconds}; }
  [[nodiscard]] double max_rate_change() const { return caps().max_rate_change; }
  [[nodiscard]] double max_rate_jerk() const { return caps().max_rate_jerk; }
};

/// How many cells the time line of a move is proven in for rates up to `rate` times the drawn speed: one for
/// a frame, 64 to max_stop_cells, and none shorter than two ticks.
inline constexpr std::int64_t max_stop_cells = 4096;
std::size_t stop_cells(const Move& move, std::int32_t rate_hz, double rate);

/// How far above the truth the suprema of a cell may be and cost a stop no more than a thousandth: a share of
/// what the limits leave. `out` has an entry for every limit.
void write_room(std::span<const AxisLimits> limits, double rate, double tick_seconds,
                std::span<MotionTriple> out);

/// Bounds R1, R2 and Q as functions of u such that for |r| <= rate, |a| <= R1(u), |j| <= R2(u) every axis
/// keeps its stop_acceleration and, where it has one, its stop_jerk, at u itself and anywhere within a cell
/// of it: a tick may pass from one cell into the next, so a cell should be no shorter than rate times a tick.
/// And such that the states
///     |a| <= R1(u);   a^2 <= 2 |r| Q(u) while braking;   a^2 <= 2 (rate - |r|) Q(u) while speeding up (V)
/// are viable: from each of them, forward and reverse, there is a continuation inside V, and one that stops.
///
/// Method. MotionCells has bounds of |p1|, |p2|, |p3| on each cell. Of the pairs with
///     p2 rate^2 + p1 R1 <= stop_acceleration,   p3 rate^3 + 3 p2 rate R1 + p1 R2 <= stop_jerk
/// over the cell and its neighbours that is taken from which a stop from `rate` lasts shortest,
/// rate / R1 + R1 / R2, convex in R1. R2 is constant on a cell. R1 and Q are continuous, linear on a cell:
/// the largest functions below the R1 of the pairs of a cell and of its neighbours, beside whose R2 it may
/// stand, and below R2, that fall and rise along u no faster than
///     |dR1/du| <= R2 / rate,                 |dQ/du| <= 2 Q (R2 - Q) / (rate min(R1, sqrt(2 rate Q)))   (S)
/// found by a sweep forward and one backward.
///
/// V is viable: on each of its borders |j| = R2(u) towards a = 0 stays inside.
/// - |a| = R1(u): R1 falls by at most R2 |r| / rate <= R2 in a second.
/// - Braking, q = a^2 / (2 |r|) = Q(u): dq/dt = (|a| / |r|) (q - |j|), which along u is
///   -(|a| / r^2) (R2 - Q) = -2 Q (R2 - Q) / (|r| |a|), and |r| <= rate, |a| <= min(R1, sqrt(2 rate Q)).
/// - Speeding up, q = a^2 / (2 (rate - |r|)): likewise -2 Q (R2 - Q) / (|r| |a|).
/// And since R1 and Q have positive minima, braking as hard as V allows comes to rest. A jerk bound that
/// looks only as far as one release (min R2 over its reach) is not enough: where it falls, a playhead that is
/// still braking at less than its release would already be outside.
///
/// Beyond either end of the time line the bounds are those at the end.
class StopBounds {
 public:
  /// `cells` has one entry more than the motion has cells; the bounds keep it. Every cell of the motion takes
  /// in its neighbours (widen). If `peaks` is not empty it has an entry for every axis and receives the most
  /// that any playing and stopping within V asks of it: velocity p1 rate, acceleration p2 rate^2 + p1 R1,
  /// jerk p3 rate^3 + 3 p2 rate R1 + p1 R2 (also of an axis without a stop_jerk), with the frame near which;
  /// lowest and highest are left as they are.
  ///
  /// Errors: no_solution, with axis and, unless negative, the whole frame, where not even a slow stop is
  /// legal: `obstacle`, if it is given, then says more, of the cells in order of time the first, of it the
  /// first axis; wrong_count (limits, peaks, cells, suprema), out_of_range (rate). No allocation.
  /// O(cells * axes).
  static Result<StopBounds> make(const StopRequest& request, std::span<StopCell> cells,
                                 std::span<AxisPeaks> peaks, std::optional<StopObstacle>* obstacle = nullptr);

  [[nodiscard]] double rate() const { return rate_; }
  /// Whether others with so many entries for cells, for rates up to `rate`, can be `within` these.
  [[nodiscard]] bool is_as_fine_as(std::size_t cell_entries, double rate) const {
    return cells_.size() == cell_entries && rate <= rate_;
  }
  /// Whether a rate and its change, both along the direction of travel, are within V at a place, or off by
  /// rounding. O(1).
  [[nodiscard]] bool permits(const FrameTime& time, double rate, double change) const;
  /// O(1).
  [[nodiscard]] StopBound at(const FrameTime& time) const;
  /// The smallest value of each bound between two places, `from` not after `to`. O(cells between them).
  [[nodiscard]] StopBound min_between(const FrameTime& from, const FrameTime& to) const;
  [[nodiscard]] double rate_change(const FrameTime& time) const { return at(time).rate_change; }
  [[nodiscard]] double rate_jerk(const FrameTime& time) const { return at(time).rate_jerk; }
  [[nodiscard]] double release_jerk(const FrameTime& time) const { return at(time).release_jerk; }

  /// A bound of how long and how far any stop from this place goes that brakes as hard as V allows, whatever
  /// rate and rate change it begins with. Counted to its end even where it would pass the end of the time
  /// line. O(cells that the stop passes).
  ///
  /// With the minima r1, q of R1 and Q over all that the stop passes, from a at most R1 here: rate changes
  /// above 0 last at most t = min(a / q, sqrt(2 rate / q)), and then the rate is at most `rate`; from there
  /// at every rate the real stop brakes at least as hard as one under the constants r1 and q, so that both
  /// seconds and distance, the integrals of 1 / |a| and r / |a| over r, are less.
  [[nodiscard]] StopLength stop_from(const FrameTime& time, bool forward) const;
  /// make finds the longest stop among all places. Bounds that may wait have none.
  [[nodiscard]] const LongestStop& longest_in_time() const { return longest_in_time_; }

 private:
  StopBounds(const StopRequest& request, std::span<StopCell> cells);
  struct Place {
    std::size_t cell = 0;
    double share = 0;  ///< of the cell, 0..1
  };
  [[nodiscard]] Place place(const FrameTime& time) const;
  [[nodiscard]] std::size_t cell_count() const { return cells_.size() - 1; }
  void stay_within(const StopBounds& stops);
  void make_continuous();
  void limit_rate_change(std::size_t from, std::size_t to, std::size_t cell);
  void limit_release_jerk(std::size_t from, std::size_t to, std::size_t cell);
  [[nodiscard]] double rising_in(std::size_t cell) const {
    return std::max(cells_[cell].rate_change, cells_[cell + 1].rate_change);
  }
  [[nodiscard]] double frames_in(double seconds) const { return seconds / cell_seconds_ * cell_frames_; }
  [[nodiscard]] StopLength stop_from_cell(std::size_t cell, bool forward) const;
  void find_longest();

  std::span<StopCell> cells_;
  double rate_ = 1;
  double cell_seconds_ = 0;
  double cell_frames_ = 0;
  std::int32_t first_frame_ = 0;
  std::int32_t frames_ = 1;  ///< of the time line
  LongestStop longest_in_time_;
};

}  // namespace inbetween
