// A plan with all that a motion loop needs to play it.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host_tools/check/planned_stops.hpp"
#include "host_tools/plan/plan.hpp"
#include "inbetween/loop/motion_loop.hpp"

namespace inbetween {

/// What a move needs beside that to be shot frame by frame.
struct ShootStage {
  double exposure_rate = 0;             ///< exposures pass at up to so many times the drawn speed
  std::vector<std::string> still = {};  ///< axes of the plan that stand still meanwhile
  std::int32_t first_frame = 0;         ///< where the rig begins
  std::vector<FrameTime> rests = {};    ///< where every travel rests, ascending
};

/// Stop bounds, a playhead on the first frame, and another for axes that stand still during exposures. Refers
/// to the plan.
///
/// Stops may use the stop limits of the rig, everything else its motion limits alone. The motions to single
/// frames and through exposures are slower than drawn, unless the exposures need more: at travel_share of the
/// highest rate the motion itself takes half of an axis' acceleration at most, and leaves the rest to speed
/// up with. A move that is played on after a stop rises by middle_share to the highest rate.
class StagedMove {
 public:
  static constexpr double travel_share = 0.7;
  static constexpr double middle_share = 0.85;

  /// For the rates of `stops`, which were made for the plan and have no obstacle. The playhead rests on the
  /// first frame of the time line, or of the shoot.
  StagedMove(const Plan& plan, std::shared_ptr<const PlannedStops> stops);
  /// Throws LimitError where the rig cannot speed up at the rate of the exposures.
  StagedMove(const Plan& plan, std::shared_ptr<const PlannedStops> stops, ShootStage shoot);
  explicit StagedMove(const Plan& plan) : StagedMove(plan, stops_of(plan, 1)) {}
  StagedMove(const StagedMove&) = delete;
  StagedMove& operator=(const StagedMove&) = delete;

  /// Throws LimitError where there is no stop from somewhere at `rate` times the drawn speed.
  static std::shared_ptr<const PlannedStops> stops_of(const Plan& plan, double rate);

  [[nodiscard]] const Plan& plan() const { return plan_; }
  [[nodiscard]] Playhead& playhead() { return playhead_; }
  [[nodiscard]] const Playhead& playhead() const { return playhead_; }
  /// Null where no axis has it.
  [[nodiscard]] Playhead* still() { return still_ ? &*still_ : nullptr; }
  /// Where every travel of a shoot rests.
  [[nodiscard]] std::span<const FrameTime> rests() const { return shoot_.rests; }
  /// At most how fast it goes to a frame that somebody asks for, as a share of the drawn speed.
  void go_slowly(double rate) { slow_rate_ = rate; }
  [[nodiscard]] double slow_rate() const { return slow_rate_; }
  [[nodiscard]] LoopSpec loop_spec();
  /// Throws LimitError where a loop would step.
  void set_repeat(Repeat repeat);

 private:
  const Plan& plan_;
  std::shared_ptr<const PlannedStops> stops_;
  ShootStage shoot_;
  std::vector<PlannedStops> rungs_;
  std::vector<StopBounds> rung_bounds_;
  Playhead playhead_;
  std::optional<Playhead> still_;
  std::vector<std::size_t> drive_of_;
  std::vector<double> counts_;
  std::vector<AxisLimits> loop_limits_;
  double slow_rate_ = 1;
  std::unique_ptr<bool[]> is_still_;  // std::vector<bool> has no bools to show
};

}  // namespace inbetween
