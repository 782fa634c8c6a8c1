#pragma once

#include <cstdint>
#include <optional>

#include "inbetween/can/rmd.hpp"
#include "sim/simulated_motor.hpp"
#include "sim/simulated_ramp.hpp"
#include "sim/simulated_servo.hpp"

namespace inbetween {

struct SimulatedRmdSettings {
  can::RmdMotor motor_number;
  double turns = 0;  ///< of its output shaft, at power-on
  /// Of its own ramp to a position, deg/s^2; 0: it goes there as fast as the limit in the position allows.
  std::uint32_t planning_acceleration = 0;
  /// That of a geared motor, in turns of its output shaft.
  SimulatedMotor::Settings motor{.max_acceleration = 600, .friction = 0.25, .coasting_friction = 24};
  bool keeps_record = false;
};

/// An RMD motor, frame in and frame out: it answers every command and says nothing by itself; the first
/// position gives it power. Its watchdog is off until somebody sets it, runs from the next frame on, and
/// takes the power away (the maker says only that the motor stops). An error does the same, until a shutdown
/// clears it.
class SimulatedRmd final : public SimulatedServo<can::Frame> {
 public:
  /// Powered on at `now_ns`.
  SimulatedRmd(const SimulatedRmdSettings& settings, std::int64_t now_ns);

  void receive(const can::Frame& frame) override;
  [[nodiscard]] const char* state_name() const override;
  [[nodiscard]] bool misses_something() const override { return false; }  // it tells nobody

 private:
  enum class State : std::uint8_t { off, in_position, stopped };
  void live(double seconds) override;
  void start_anew() override;
  void step(double seconds);
  void meet(const DriveTrouble& trouble) override;
  void enter(State state);
  void obey(const can::Frame& frame);
  void take_position(const can::RmdPosition& position);
  void answer_acceleration(const can::Frame& frame);
  void answer_status();

  SimulatedRmdSettings settings_;
  std::int64_t watchdog_ns_ = 0;  ///< 0: off
  std::int64_t fed_ns_ = 0;
  State state_ = State::off;
  std::uint16_t errors_ = 0;
  double target_ = 0;
  double max_turns_per_s_ = 0;  ///< 0: no limit
  SimulatedRamp demand_;
};

}  // namespace inbetween
