#include "host_tools/plan/plan_motion.hpp"

#include "host_tools/plan/solved_track.hpp"

namespace inbetween {

std::span<const Trajectory> PlanMotion::trajectories(std::span<const Track<double>> tracks) {
  std::call_once(is_fitted_, [&] {
    for (const Track<double>& track : tracks) {
      fitted_.push_back(std::make_unique<FittedTrajectory>(track));
      trajectories_.push_back(**fitted_.back());
    }
  });
  return trajectories_;
}

const PlayedMotion& PlanMotion::of(const Move<double>& move, std::span<const Track<double>> tracks) {
  std::call_once(is_made_, [&] { motion_ = value_or_throw(PlayedMotion::make(move, trajectories(tracks))); });
  return *motion_;
}

}  // namespace inbetween
