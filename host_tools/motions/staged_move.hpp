// A plan with all that a motion loop needs to play it.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host_tools/check/planned_stops.hpp"
#include "host_tools/plan/plan.hpp"
#include "inbetween/loop/motion_loop.hpp"

namespace inbetween {

/// Stop bounds, a playhead on the first frame, and another for axes that stand still during exposures. Refers
/// to the plan.
class StagedMove {
 public:
  /// For rates up to `rate` times the drawn speed; `still` names axes of the plan. Throws LimitError where
  /// there is no stop from somewhere at that rate.
  explicit StagedMove(const Plan& plan, double rate = 1, std::span<const std::string> still = {});
  StagedMove(const StagedMove&) = delete;
  StagedMove& operator=(const StagedMove&) = delete;

  [[nodiscard]] const Plan& plan() const { return plan_; }
  [[nodiscard]] Playhead<double>& playhead() { return playhead_; }
  /// Null where no axis has it.
  [[nodiscard]] Playhead<double>* still() { return still_ ? &*still_ : nullptr; }
  [[nodiscard]] LoopSpec<double> loop_spec();
  /// Throws LimitError where a loop would step.
  void set_repeat(Repeat repeat);

 private:
  const Plan& plan_;
  PlannedStops stops_;
  Playhead<double> playhead_;
  std::optional<Playhead<double>> still_;
  std::vector<std::size_t> drive_of_;
  std::unique_ptr<bool[]> is_still_;  // std::vector<bool> has no bools to show
};

}  // namespace inbetween
