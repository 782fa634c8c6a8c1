#include "sim/simulated_motor.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace inbetween {

void SimulatedMotor::follow(const Demand& demand, double seconds) {
  const double omega = 2 * std::numbers::pi * settings_.bandwidth_hz;
  const double wanted = demand.acceleration + omega * omega * (demand.position - position_) +
                        2 * omega * (demand.velocity - velocity_);
  integrate(std::clamp(wanted, -settings_.max_acceleration, settings_.max_acceleration), settings_.friction,
            seconds);
}

void SimulatedMotor::coast(double seconds) {
  integrate(0, settings_.coasting_friction, seconds);
}

void SimulatedMotor::put(double position) {
  position_ = position;
  velocity_ = 0;
}

/// Friction stops a motion and never begins one.
void SimulatedMotor::integrate(double drive, double friction, double seconds) {
  if (is_held_) {
    velocity_ = 0;
    return;
  }
  const double pushed = velocity_ + (drive - settings_.viscous_friction * velocity_) * seconds;
  const double lost = friction * seconds;
  velocity_ = std::fabs(pushed) <= lost ? 0 : pushed - std::copysign(lost, pushed);
  position_ += velocity_ * seconds;
}

}  // namespace inbetween
