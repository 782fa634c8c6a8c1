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
    const double wanted = omega * omega * seconds * (demand.position - position_) +
                          2 * omega * seconds * (demand.velocity - velocity_);
    const double most = settings_.max_acceleration * seconds;
    // A branch, because the processor foresees it.
    if (std::fabs(wanted) > most) [[unlikely]] {
      return integrate(std::copysign(most, wanted), settings_.friction, seconds);
    }
    integrate(wanted, settings_.friction, seconds);
  }
  /// Moves for `seconds` without current.
  void coast(double seconds) { integrate(0, settings_.coasting_friction, seconds); }
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
  /// The current adds `driven` to the velocity. Friction stops a motion and never begins one.
  void integrate(double driven, double friction, double seconds) {
    if (is_held_) {
      velocity_ = 0;
      return;
    }
    const double pushed = velocity_ - settings_.viscous_friction * seconds * velocity_ + driven;
    const double lost = friction * seconds;
    if (pushed > lost) {
      velocity_ = pushed - lost;
    } else if (pushed < -lost) {
      velocity_ = pushed + lost;
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
