// Inverse kinematics: the positions of axes that put a link of the rig where it is asked to be.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "host_tools/joints/crane_solutions.hpp"
#include "host_tools/joints/kinematics.hpp"
#include "host_tools/joints/tip_target.hpp"
#include "inbetween/joints/arm_angles.hpp"

namespace inbetween {

/// How near to a target the axes can bring the link.
struct TipSolution {
  std::vector<double> positions;  // one for each TipAxis
  double miss_m = 0;              // of the position
  double miss_rad = 0;            // of aim and roll
  [[nodiscard]] bool is_exact() const { return miss_m <= max_miss && miss_rad <= max_miss; }
  /// What iterations in double leave, of rigs of some metres.
  static constexpr double max_miss = 1e-11;
};

/// Newton's method with damping (Levenberg and Marquardt; Nakamura and Hanafusa 1986, Wampler 1986) on the
/// Jacobian of the tree. Axes that the target leaves free stay as near as they can to where they were sought.
/// An arm of two parallel axes is solved in closed form (arm_angles), with the elbow on the side that is
/// asked, and so are camera cranes and remote heads (CraneSolutions).
class TipSolver {
 public:
  /// All axes that move the link are among `axes`. `kinematics` outlives the solver.
  TipSolver(const Kinematics& kinematics, std::int32_t link, std::vector<TipAxis> axes);

  /// The link hangs on two parallel joints and on nothing else that moves.
  [[nodiscard]] bool is_two_joint_arm() const { return arm_.has_value(); }
  void set_elbow(ElbowSide side) { elbow_ = side; }

  /// From no more than `near` and the ranges of the axes: the solution that is nearest to `near`, inside the
  /// ranges if there is one; of all that there are where the rig has a closed form, otherwise of those that
  /// are found from there and from 24 places spread over the ranges.
  [[nodiscard]] TipSolution solve_from_ranges(const TipTarget& target) const;
  /// From positions beside the solution. What is not exact is as near as the method comes.
  [[nodiscard]] TipSolution solve(const TipTarget& target, const std::vector<double>& seed) const;

  /// How fast the axes move when the target does, at an exact solution.
  [[nodiscard]] std::vector<double> rates(const TipTarget& target, const TipTargetRate& rate,
                                          const std::vector<double>& positions) const;

  struct Freedom {
    std::size_t rank = 0;       // so many directions of the target can be followed
    double smallest = 0;        // of their singular values, as a share of the largest
    std::size_t weak_axis = 0;  // index of the first TipAxis that moves most without moving the link
    /// The sign of the Jacobian's determinant where it is square, otherwise 0: it changes only where the rig
    /// passes through a singular place.
    int sign = 0;
  };
  /// `rank` directions at most are counted.
  [[nodiscard]] Freedom freedom(const TipTarget& target, const std::vector<double>& positions,
                                std::size_t rank) const;
  /// The rank at most places: fewer at a singular one.
  [[nodiscard]] std::size_t usual_rank(const TipTarget& target) const;

  [[nodiscard]] const std::vector<TipAxis>& axes() const { return axes_; }
  [[nodiscard]] Pose pose(const std::vector<double>& positions) const;
  /// The longest distance from the root to the link, from joint to joint (m).
  [[nodiscard]] double reach() const { return reach_; }

 private:
  /// What is missing to the target, in m by reach and in rad, and how the scaled axes change it.
  struct Rows {
    std::vector<double> miss;
    std::vector<std::vector<double>> slopes;
    double miss_m = 0;
    double miss_rad = 0;
    [[nodiscard]] double size() const;
  };
  struct Arm {
    TwoJointArm links;
    Pose shoulder;  // its z axis is that of the joint, its x axis the upper arm with both axes at 0
    double forearm_angle = 0;      // in it, with both axes at 0
    std::array<double, 2> slopes;  // rad per unit of each axis, about z
  };

  [[nodiscard]] std::vector<Pose> poses(const std::vector<double>& positions) const;
  [[nodiscard]] Rows rows(const TipTarget& target, const std::vector<double>& positions) const;
  /// The step of the scaled axes that changes the rows by `wanted`, weaker where their squared singular
  /// values are below the damping.
  static std::vector<double> step(const Rows& rows, const std::vector<double>& wanted, double damping);
  /// What is left of a motion of the scaled axes without the part that moves the link.
  static std::vector<double> idle_part(const Rows& rows, std::vector<double> motion);
  /// The motion of the rows that the target's motion asks for.
  [[nodiscard]] std::vector<double> wanted(const TipTarget& target, const TipTargetRate& rate,
                                           const std::vector<double>& positions) const;
  void descend(const TipTarget& target, std::vector<double>& positions) const;
  void stay_near(const TipTarget& target, std::vector<double>& positions) const;
  [[nodiscard]] std::optional<Arm> find_arm() const;
  [[nodiscard]] TipSolution solve_arm(const Vector3& position, const std::vector<double>& seed) const;
  /// The solution of the closed form that is nearest to `seed`, inside the ranges if `in_ranges_first` and
  /// there is one.
  [[nodiscard]] std::optional<TipSolution> solve_crane(const TipTarget& target,
                                                       const std::vector<double>& seed,
                                                       bool in_ranges_first) const;
  /// Of the scaled axes.
  [[nodiscard]] double distance(const std::vector<double>& a, const std::vector<double>& b) const;
  [[nodiscard]] bool in_range(std::size_t i, double position) const;
  [[nodiscard]] bool in_ranges(const std::vector<double>& positions) const;

  const Kinematics* kinematics_;
  std::int32_t link_;
  std::vector<TipAxis> axes_;
  double reach_ = 0;
  std::vector<double> scales_;  // rad, or m by reach, per unit of each axis
  std::vector<bool> slides_;
  std::optional<Arm> arm_;
  ElbowSide elbow_ = ElbowSide::left;
  std::optional<CraneSolutions> crane_;
};

}  // namespace inbetween
