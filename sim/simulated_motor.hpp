#pragma once

#include <cmath>
#include <numbers>

namespace inbetween {

/// A motor with its load behind a position controller: second order, with a current that has a limit and with
/// friction. Positions in counts, seconds.
class SimulatedMotor {
 public:
  struct Settings {
    double bandwidth_hz = 30;        ///< of the position controller, critically damped
    double max_acceleration = 5e6;   ///< counts/s^2 at the limit of the current
    double friction = 2e3;           ///< counts/s^2, against the motion
    double viscous_friction = 1;     ///< 1/s
    double coasting_friction = 2e5;  ///< counts/s^2 without current: the load brakes
  };
  /// The motion that the controller wants.
  struct Demand {
    double position = 0;
    double velocity = 0;
  };

  SimulatedMotor(const Settings& settings, double position) : settings_(settings), position_(position) {}

  /// Moves for `seconds` and follows the demand.
  void follow(const Demand& demand, double seconds) {
    const double omega = 2 * std::numbers::pi * settings_.bandwidth_hz;
    // Velocities and not accelerations, because a step waits for the one before: so it has less to wait for.
    const double spring = omega * omega * seconds * (demand.position - position_);
    const double damper = 2 * omega * seconds * (demand.velocity - velocity_);
    const double most = settings_.max_acceleration * seconds;
    const double kept = kept_velocity(seconds);
    const double lost = settings_.friction * seconds;
    // A branch, because the processor foresees it.
    if (std::fabs(spring + damper) > most) [[unlikely]] {
      return integrate(kept, std::copysign(most, spring + damper), lost, seconds);
    }
    integrate(kept + damper, spring, lost, seconds);
  }
  /// Moves for `seconds` and is brought to a velocity, wherever it is.
  void follow_speed(double velocity, double seconds) {
    follow({.position = position_, .velocity = velocity}, seconds);
  }
  /// Moves for `seconds` without current.
  void coast(double seconds) {
    integrate(kept_velocity(seconds), 0, settings_.coasting_friction * seconds, seconds);
  }
  /// Somebody moves it by hand.
  void put(double position) {
    position_ = position;
    velocity_ = 0;
  }
  /// Something holds it, whatever the current.
  void hold(bool is_held) { is_held_ = is_held; }

  [[nodiscard]] double position() const { return position_; }
  [[nodiscard]] double velocity() const { return velocity_; }

 private:
  [[nodiscard]] double kept_velocity(double seconds) const {
    return (1 - settings_.viscous_friction * seconds) * velocity_;
  }
  /// The new velocity is the sum of both, of which `late` is known last, less what friction takes. That stops
  /// a motion and never begins one.
  void integrate(double early, double late, double lost, double seconds) {
    if (is_held_) {
      velocity_ = 0;
      return;
    }
    if (early + late > lost) {
      velocity_ = early - lost + late;
    } else if (early + late < -lost) {
      velocity_ = early + lost + late;
    } else {
      velocity_ = 0;
    }
    position_ += velocity_ * seconds;
  }

  Settings settings_;
  double position_;
  double velocity_ = 0;
  bool is_held_ = false;
};

}  // namespace inbetween
