// Why no speed curve meets the locked keys of a track.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>

#include "host_tools/plan/solved_track.hpp"

namespace inbetween {

/// The core's refusal of locked keys, with the numbers that prove it.
class UnmetLock : public SolverError {
 public:
  UnmetLock(const Error& error, std::string remedy) : SolverError(error), remedy_(std::move(remedy)) {}
  /// It is told in place of the remedy of the error.
  [[nodiscard]] const std::string& remedy() const { return remedy_; }

 private:
  std::string remedy_;
};

/// The input of adjust_to_locks() that was refused, with the locks that it completed.
struct UnmetLocks {
  std::span<const KeyLock> locks;  ///< the ends of the move are the first and the last
  std::span<const Waypoint> waypoints;
  std::span<const double> control_values;
  CurveEnds ends = CurveEnds::natural;
  std::int32_t frames = 0;
};

/// A control value is 100 at most, and so is the mean of a curve, however many values it has. Where the path
/// between two neighbouring locks needs a larger mean, that proves that no curve meets them: the refusal
/// blames the lock at the end of the stretch that needs the largest. Nothing where no stretch does. Phi
/// between two breaks counts as drawn. O(control values + locks).
std::optional<UnmetLock> proven_unmet(const UnmetLocks& unmet);

}  // namespace inbetween
