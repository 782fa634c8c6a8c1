// The trajectories of a plan, fitted when somebody asks for them.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "host_tools/plan/fitted_trajectory.hpp"
#include "inbetween/limits/played_motion.hpp"

namespace inbetween {

/// Of one plan: every call gives the same tracks, and the same move.
class PlanMotion {
 public:
  /// Of whole tracks. Throws SolverError.
  std::span<const Trajectory> trajectories(std::span<const Track> tracks);
  /// With motors that follow axes of the move. Throws SolverError.
  const PlayedMotion& of(const Move& move, std::span<const Track> tracks,
                         std::span<const CalibratedMotor> motors);

 private:
  void fit_motor_of(const CalibratedMotor& motor, const Move& move);

  std::once_flag is_fitted_, is_made_;
  std::vector<std::unique_ptr<FittedTrajectory>> fitted_;
  std::vector<Trajectory> trajectories_;
  std::vector<std::unique_ptr<FittedMotor>> fitted_motors_;
  std::vector<PlayedMotor> motors_;
  std::optional<PlayedMotion> motion_;
};

}  // namespace inbetween
