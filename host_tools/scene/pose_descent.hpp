// The axes on their way to a pose of the tip.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host_tools/joints/kinematics.hpp"

namespace inbetween {

/// Newton's method with damping (Levenberg and Marquardt) on place and rotation vector. TipSolver says a
/// rotation by aim and roll, of which there is none straight up or down, where cameras over a table look;
/// here no rotation is special. Refers to the kinematics.
class PoseDescent {
 public:
  /// `axes` are all coordinates that move the link.
  PoseDescent(const Kinematics& kinematics, std::int32_t link, std::vector<std::size_t> axes);

  /// With everything else at 0. Valid until the next call.
  const Pose& pose(const std::vector<double>& positions);

  /// Changes the positions while they come nearer, 100 times at most. O(axes) each time.
  void descend(const Pose& wanted, std::vector<double>& positions);

 private:
  std::vector<double> stepped(std::vector<double> positions, const std::array<double, 6>& miss,
                              double damping);

  const Kinematics& kinematics_;
  std::int32_t link_;
  std::vector<std::size_t> axes_;
  std::vector<double> coordinates_;
  std::vector<Pose> poses_;
  std::vector<JacobianColumn> columns_;
};

}  // namespace inbetween
