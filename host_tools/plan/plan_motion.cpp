#include "host_tools/plan/plan_motion.hpp"

#include "host_tools/plan/solved_track.hpp"

namespace inbetween {

std::span<const Trajectory> PlanMotion::trajectories(std::span<const Track> tracks) {
  std::call_once(is_fitted_, [&] {
    for (const Track& track : tracks) {
      fitted_.push_back(std::make_unique<FittedTrajectory>(track));
      trajectories_.push_back(**fitted_.back());
    }
  });
  return trajectories_;
}

void PlanMotion::fit_motor_of(const CalibratedMotor& motor, const Move& move) {
  const auto keep = [&](std::unique_ptr<FittedMotor> fitted) {
    fitted_motors_.push_back(std::move(fitted));
    return &**fitted_motors_.back();
  };
  std::size_t track = 0;
  std::size_t axis = motor.axis;
  for (; axis >= trajectories_[track].axis_count(); ++track) axis -= trajectories_[track].axis_count();
  const MotorSource source{&trajectories_[track], axis, motor.calibration, fitted_[track]->travel(axis)};
  PlayedMotor played{.axis = motor.axis, .whole = keep(std::make_unique<FittedMotor>(source))};
  const auto on = [&](std::span<const RollAxis> rolls) -> const Trajectory* {
    if (rolls.empty()) return nullptr;
    return keep(std::make_unique<FittedMotor>(rolls[motor.axis], *motor.calibration));
  };
  played.pre_roll = on(move.rolls().before);
  played.post_roll = on(move.rolls().after);
  motors_.push_back(played);
}

const PlayedMotion& PlanMotion::of(const Move& move, std::span<const Track> tracks,
                                   std::span<const CalibratedMotor> motors) {
  std::call_once(is_made_, [&] {
    trajectories(tracks);
    for (const CalibratedMotor& motor : motors) fit_motor_of(motor, move);
    motion_ = value_or_throw(PlayedMotion::make(move, trajectories_, motors_));
  });
  return *motion_;
}

}  // namespace inbetween
