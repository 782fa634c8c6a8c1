// The links of an articulated rig on the rows of a plan: where they are in the world, and how they move.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "host_tools/plan/plan.hpp"
#include "host_tools/plan/plan_rows.hpp"

namespace inbetween {

/// Refers to the plan, whose rig has kinematics.
class LinkRows {
 public:
  LinkRows(const Plan& plan, PlanRows rows);

  [[nodiscard]] const TimeLine& line() const { return line_; }
  /// The motion of every link of the tree, in metres and seconds. Links that hang on an axis in no track are
  /// not to be used: it counts as 0. Throws InputError where a joint is too far from its zero to be computed.
  const std::vector<LinkMotion>& at(std::int64_t row);

 private:
  const Plan& plan_;
  TimeLine line_;
  std::vector<std::optional<AxisColumn>> columns_;  // of the rig's axes
  std::vector<CoordinateMotion> coordinates_;
  std::vector<LinkMotion> links_;
  std::optional<std::int64_t> row_;  // that links_ are of
};

/// The poses of all links at a moment of the frames 0..N. Otherwise as LinkRows::at.
std::vector<Pose> link_poses(const Plan& plan, const FrameTime& when);

}  // namespace inbetween
