#include "sim/simulated_rig.hpp"

namespace inbetween {

SimulatedRig::SimulatedRig(std::span<const double> positions) : faults_(positions.size()) {
  for (const double position : positions) axes_.emplace_back(position);
}

void SimulatedRig::read(std::span<DriveState<double>> states) {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    states[i] = {.actual = axes_[i].actual(), .is_on = is_switched_on_, .has_fault = faults_[i]};
  }
}

void SimulatedRig::write(std::span<const double> setpoints) {
  ++writes_;
  if (!connected_ || !is_switched_on_) return;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    if (!faults_[i]) axes_[i].tick(setpoints[i]);
  }
}

void SimulatedRig::disable() {
  is_switched_on_ = false;
}

}  // namespace inbetween
