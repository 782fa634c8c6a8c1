#include "sim/simulated_rig.hpp"

namespace inbetween {

SimulatedRig::SimulatedRig(std::span<const double> positions)
    : commanded_(positions.begin(), positions.end()),
      actual_(commanded_),
      shifts_(positions.size()),
      faults_(positions.size()) {}

void SimulatedRig::read(std::span<DriveState> states, std::int64_t /*now_ns*/) {
  for (std::size_t i = 0; i < actual_.size(); ++i) {
    DriveCondition condition = faults_[i] ? DriveCondition::cannot_follow : DriveCondition::fine;
    if (!connected_) condition = DriveCondition::unreachable;
    states[i] = {.actual = actual_[i] + shifts_[i], .is_on = is_switched_on_, .condition = condition};
  }
}

void SimulatedRig::write(std::span<const Setpoint> setpoints, std::int64_t /*now_ns*/) {
  if (setpoints.empty()) return;
  ++writes_;
  if (!connected_ || !is_switched_on_) return;
  for (std::size_t i = 0; i < actual_.size(); ++i) {
    if (faults_[i]) continue;
    actual_[i] = commanded_[i];
    commanded_[i] = setpoints[i].position - shifts_[i];
  }
}

}  // namespace inbetween
