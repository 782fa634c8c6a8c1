#pragma once

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
    double acceleration = 0;
  };

  SimulatedMotor(const Settings& settings, double position) : settings_(settings), position_(position) {}

  /// Moves for `seconds` and follows the demand.
  void follow(const Demand& demand, double seconds);
  /// Moves for `seconds` without current.
  void coast(double seconds);
  /// Somebody moves it by hand.
  void put(double position);
  /// Something holds it, whatever the current.
  void hold(bool is_held) { is_held_ = is_held; }

  [[nodiscard]] double position() const { return position_; }
  [[nodiscard]] double velocity() const { return velocity_; }

 private:
  void integrate(double drive, double friction, double seconds);
  Settings settings_;
  double position_;
  double velocity_ = 0;
  bool is_held_ = false;
};

}  // namespace inbetween
