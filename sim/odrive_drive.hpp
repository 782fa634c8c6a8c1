#pragma once

#include <cstdint>
#include <optional>

#include "inbetween/can/odrive.hpp"
#include "sim/simulated_motor.hpp"
#include "sim/simulated_servo.hpp"

namespace inbetween {

struct SimulatedOdriveSettings {
  can::OdriveNode node;
  can::OdriveFamily family = can::OdriveFamily::firmware_06;
  std::uint64_t serial = 0x2468'ACE0'1357;         ///< 0.6
  double turns = 0;                                ///< at power-on
  std::int64_t watchdog_ns = 100'000'000;          ///< 0: it has none
  std::int64_t enable_delay_ns = 100'000'000;      ///< from the order until it holds
  std::int64_t heartbeat_period_ns = 100'000'000;  ///< free-running
  std::int64_t estimates_period_ns = 10'000'000;   ///< free-running
  double velocity_limit = 1e9;                     ///< turns/s; faster is an error
  /// That of a motor with 8192 counts a turn.
  SimulatedMotor::Settings motor{.max_acceleration = 600, .friction = 0.25, .coasting_friction = 24};
  bool keeps_record = false;
};

/// An ODrive with its motor, frame in and frame out, of either family: heartbeat and estimates in its own
/// rhythm, answers to remote frames, idle and closed loop, position control by passthrough, errors and a
/// watchdog that every frame to it feeds. When it is switched on it takes for its position the one that it
/// has; it does not forget an old feed-forward by that. Without power its motor coasts.
class SimulatedOdrive final : public SimulatedServo<can::Frame> {
 public:
  /// Powered on at `now_ns`.
  SimulatedOdrive(const SimulatedOdriveSettings& settings, std::int64_t now_ns);

  void receive(const can::Frame& frame) override;
  [[nodiscard]] const char* state_name() const override;
  [[nodiscard]] bool misses_something() const override { return false; }  // it misses whoever is silent

  [[nodiscard]] bool is_on() const { return state_ == can::odrive_closed_loop; }
  [[nodiscard]] std::uint32_t errors() const { return errors_; }

 private:
  void live(double seconds) override;
  void start_anew() override;
  void step(double seconds);
  void report();
  void meet(const DriveTrouble& trouble) override;
  void enter(std::uint8_t state);
  void fail(std::uint32_t errors);
  void obey_state(std::uint32_t state);
  void take_position(const can::OdrivePosition& position);
  void answer(const can::Frame& question);
  [[nodiscard]] std::uint32_t part_errors(std::size_t part) const;
  [[nodiscard]] can::Frame heartbeat() const;
  [[nodiscard]] can::Frame estimates() const;

  SimulatedOdriveSettings settings_;
  std::int64_t heartbeat_ns_;
  std::int64_t estimates_ns_;
  std::int64_t fed_ns_;
  std::uint8_t state_ = can::odrive_idle;
  std::optional<std::int64_t> on_ns_;  ///< when it will be switched on
  std::uint32_t errors_ = 0;
  can::OdrivePosition input_;
};

}  // namespace inbetween
