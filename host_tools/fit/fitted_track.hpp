// One track of a move on its rig, alone, and what another speed curve would make of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host_tools/check/check.hpp"
#include "host_tools/fit/speed_constraints.hpp"
#include "host_tools/fit/speed_descent.hpp"
#include "host_tools/plan/drawn_curve.hpp"
#include "host_tools/plan/plan.hpp"

namespace inbetween {

class FittedTrack {
 public:
  /// The plan has a rig, and `report` is that of the plan.
  FittedTrack(const Plan& plan, const CheckReport& report, std::size_t index);

  /// The track as it is.
  [[nodiscard]] const Plan& played() const { return played_; }
  [[nodiscard]] const CheckReport& report() const { return report_; }
  [[nodiscard]] const MoveTrack& file() const { return played_.move().tracks.front(); }
  [[nodiscard]] const SolvedTrack& solved() const { return played_.tracks().front(); }
  [[nodiscard]] const Track& track() const { return solved().track(); }
  [[nodiscard]] std::int32_t frames() const { return played_.move().frames; }
  [[nodiscard]] CurveEnds ends() const { return ends_of(file()); }
  /// The axes of the track, in its order.
  [[nodiscard]] std::span<const RigAxis> axes() const { return axes_; }
  /// The index of an axis of the track among the axes of the rig.
  [[nodiscard]] std::size_t rig_axis(std::size_t axis) const { return rig_axes_[axis]; }

  /// Whether the acceleration steps at frames 0 and N.
  [[nodiscard]] EndSteps end_steps() const;

  /// The part of the curve that stays while the rest changes: its rests, and Phi at locked keys, at breaks
  /// and at the end. `baseline` is the played curve, refined or not.
  [[nodiscard]] CurveFrame frame_of(std::span<const double> baseline) const;

  /// The report of check_until_refused() on another curve; of two turns, where a periodic move fits in one
  /// and not in two. Nothing, with the reason in `trouble`, if the move would not play that curve unchanged.
  [[nodiscard]] std::optional<CheckReport> judge(std::span<const double> values, std::string& trouble) const;

 private:
  Plan played_;
  CheckReport report_;
  std::vector<RigAxis> axes_;
  std::vector<std::size_t> rig_axes_;
};

}  // namespace inbetween
