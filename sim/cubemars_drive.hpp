#pragma once

#include <cstdint>
#include <optional>

#include "inbetween/can/cubemars.hpp"
#include "sim/simulated_motor.hpp"
#include "sim/simulated_ramp.hpp"
#include "sim/simulated_servo.hpp"

namespace inbetween {

struct SimulatedCubemarsSettings {
  can::CubemarsMotor motor_number;
  can::CubemarsScale scale;
  double turns = 0;                             ///< of its output shaft, at power-on
  std::int64_t feedback_period_ns = 5'000'000;  ///< free-running
  /// That of a geared motor, in turns of its output shaft.
  SimulatedMotor::Settings motor{.max_acceleration = 600, .friction = 0.25, .coasting_friction = 24};
  bool keeps_record = false;
};

/// An AK motor in servo mode, frame in and frame out: feedback in its own rhythm, in tenths of a degree that
/// go round; positions with limits, of which the first gives it power, and current. It has no watchdog. An
/// error takes its power away for as long as it lasts.
class SimulatedCubemars final : public SimulatedServo<can::Frame> {
 public:
  /// Powered on at `now_ns`.
  SimulatedCubemars(const SimulatedCubemarsSettings& settings, std::int64_t now_ns);

  void receive(const can::Frame& frame) override;
  [[nodiscard]] const char* state_name() const override;
  [[nodiscard]] bool misses_something() const override { return false; }

 private:
  void live(double seconds) override;
  void start_anew() override;
  void step(double seconds);
  void report();
  void meet(const DriveTrouble& trouble) override;
  void set_power(bool is_on);
  void take_position(const can::CubemarsPosition& position);
  void take_speed(std::int32_t erpm);
  [[nodiscard]] can::Frame feedback() const;
  [[nodiscard]] double turns_of(std::int32_t counts) const;

  SimulatedCubemarsSettings settings_;
  std::int64_t feedback_ns_;
  bool is_on_ = false;
  std::uint8_t error_ = 0;
  can::CubemarsPosition told_;
  std::optional<double> told_turns_per_s_;  ///< instead of a position
  SimulatedRamp demand_;
};

}  // namespace inbetween
