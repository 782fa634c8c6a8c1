#pragma once

#include <algorithm>
#include <cstdint>

namespace inbetween::gpio {

/// How far what is played may differ from its plan.
struct StepPaceLimits {
  std::int64_t tolerated_late_ns = 50'000;  ///< what is later counts as late
  std::int64_t rest_ns = 50'000'000;        ///< a motor that has made no step for so long stands
  std::int64_t min_spacing_ns = 5'000;      ///< on the wire, between instants planned at least that far apart
};

/// When each of a series of instants is to be played, if the one before was late. An instant is never left
/// out, and never follows faster than the motion allows:
///
/// - One that is late by more than is tolerated moves all that follow by its lateness. That shift grows with
///   every such instant and ends only where the series does (`end_series`): a motor that is behind would
///   otherwise be hurried.
/// - One that is late by less shifts nothing, or the little that every call is late by would add up. Such
/// time,
///   and what is left of a shift when its series has ended, is made good by shortening what follows: each
///   spacing by at most a 16th, or to a time of rest, after which no motor is in motion.
/// - Never is a spacing shorter than the least one, from the end of one call to the beginning of the next,
///   unless it was planned shorter.
///
/// Pure arithmetic on one clock: nothing is asked and nothing waits.
class StepPace {
 public:
  explicit StepPace(const StepPaceLimits& limits) : limits_(limits) {}

  /// The earliest time for an instant that was planned for `at_ns`, not before the one before it.
  [[nodiscard]] std::int64_t due_ns(std::int64_t at_ns) const {
    if (!has_before_) return at_ns + shift_ns_;
    const std::int64_t spacing = std::max<std::int64_t>(at_ns - at_before_ns_, 0);
    const std::int64_t max_hurried =
        begun_before_ns_ + std::min(spacing - spacing / made_good_by, limits_.rest_ns);
    const std::int64_t apart = ended_before_ns_ + std::min(spacing, limits_.min_spacing_ns);
    return std::max({at_ns + shift_ns_, max_hurried, apart});
  }

  /// The instant planned for `at_ns` was given to the kernel between these times. Says whether it was late:
  /// by more than is tolerated, beyond the shift of those before it.
  bool note_played(std::int64_t at_ns, std::int64_t begun_ns, std::int64_t ended_ns) {
    const std::int64_t late_ns = begun_ns - (at_ns + shift_ns_);
    const bool is_late = late_ns > limits_.tolerated_late_ns;
    if (is_late) shift_ns_ += late_ns;
    has_before_ = true;
    at_before_ns_ = at_ns;
    begun_before_ns_ = begun_ns;
    ended_before_ns_ = ended_ns;
    return is_late;
  }

  /// Nothing follows for now: the shift ends. The spacings hold even so.
  void end_series() { shift_ns_ = 0; }

  /// By how much what follows is later than planned.
  [[nodiscard]] std::int64_t shift_ns() const { return shift_ns_; }

 private:
  /// Speed and acceleration may be too high by that part for as long, which a motor with a margin does not
  /// notice: the tolerated 50 us are made good in 0.8 ms.
  static constexpr std::int64_t made_good_by = 16;

  StepPaceLimits limits_;
  std::int64_t shift_ns_ = 0;
  bool has_before_ = false;
  std::int64_t at_before_ns_ = 0;
  std::int64_t begun_before_ns_ = 0;
  std::int64_t ended_before_ns_ = 0;
};

}  // namespace inbetween::gpio
