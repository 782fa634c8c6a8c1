#include "sim/simulated_rig.hpp"

namespace inbetween {

SimulatedRig::SimulatedRig(std::span<const double> positions)
    : shifts_(positions.size()), faults_(positions.size()) {
  for (const double position : positions) axes_.emplace_back(position);
}

void SimulatedRig::read(std::span<DriveState<double>> states, std::int64_t /*now_ns*/) {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    DriveCondition condition = faults_[i] ? DriveCondition::cannot_follow : DriveCondition::fine;
    if (!connected_) condition = DriveCondition::unreachable;
    states[i] = {.actual = axes_[i].actual() + shifts_[i], .is_on = is_switched_on_, .condition = condition};
  }
}

void SimulatedRig::write(std::span<const Setpoint<double>> setpoints, std::int64_t /*now_ns*/) {
  if (setpoints.empty()) return;
  ++writes_;
  if (!connected_ || !is_switched_on_) return;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    if (!faults_[i]) axes_[i].tick(setpoints[i].position - shifts_[i]);
  }
}

}  // namespace inbetween
