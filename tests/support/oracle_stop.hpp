// The playhead as the rule of stop_bounds.hpp describes it, in small steps of time: what may be asked of the
// axes on any path through the permitted states. It plans nothing ahead.
#pragma once

#include <algorithm>
#include <functional>
#include <utility>

namespace inbetween::oracle {

/// Seconds of the time line from frame 0, and in the direction of travel: rate >= 0 and its change.
struct PlayheadState {
  double u = 0;
  double rate = 0;
  double change = 0;
};

/// What is permitted at a place: |change| up to rate_change, its own change up to rate_jerk.
struct PlayheadBound {
  double rate_change = 0;
  double rate_jerk = 0;
  double release_jerk = 0;
};

/// What it has to obey. The jerk bound of a place holds within `cell_seconds` of it and no further: no step
/// is longer.
struct PlayheadRule {
  std::function<PlayheadBound(double)> at;  ///< by u
  double cell_seconds = 0;                  ///< of the time line
  double highest_rate = 1;
  bool forward = true;
};

/// A step of the simulation, seen from the time line: rates are negative in reverse.
struct PlayheadStep {
  double u = 0;
  double rate = 0, change = 0, jerk = 0;
  double max_change = 0, max_jerk = 0;  ///< the bounds there
};

/// Brakes or speeds up as hard as the bounds permit.
class StoppingPlayhead {
 public:
  StoppingPlayhead(PlayheadRule rule, double step_seconds)
      : rule_(std::move(rule)),
        side_(rule_.forward ? 1 : -1),
        dt_(std::min(step_seconds, rule_.cell_seconds / rule_.highest_rate)) {}

  /// Whether the state is within the permitted ones.
  [[nodiscard]] bool permits(const PlayheadState& state) const;
  /// One step towards the highest rate, or towards rest, as long as the steps are or, where the bounds bend
  /// more sharply, shorter; returns its seconds. 0 where no permitted state can be reached with the jerk
  /// bound (to a millionth) in a step of any length: the claim of stop_bounds.hpp is wrong.
  double step(PlayheadState& state, bool speeding_up,
              const std::function<void(const PlayheadStep&)>& visit) const;

 private:
  [[nodiscard]] bool try_step(PlayheadState& state, bool speeding_up, double dt,
                              const std::function<void(const PlayheadStep&)>& visit) const;
  [[nodiscard]] PlayheadState after(const PlayheadState& state, double change, double dt) const;
  [[nodiscard]] double max_jerk(const PlayheadState& state, double dt) const;
  void show(const PlayheadState& from, const PlayheadState& to, double jerk, double max_jerk,
            const std::function<void(const PlayheadStep&)>& visit) const;

  PlayheadRule rule_;
  double side_;
  double dt_;
};

}  // namespace inbetween::oracle
