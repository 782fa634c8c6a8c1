#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "inbetween/can/moteus.hpp"
#include "inbetween/can/moteus_register.hpp"
#include "sim/simulated_motor.hpp"
#include "sim/simulated_servo.hpp"

namespace inbetween {

struct SimulatedMoteusSettings {
  can::MoteusNode node;
  double turns = 0;                          ///< of the output shaft, at power-on
  std::int64_t watchdog_ns = 100'000'000;    ///< where a command says none (servo.default_timeout_s)
  std::int64_t enable_delay_ns = 5'000'000;  ///< from the command until it holds
  double min_turns = -std::numeric_limits<double>::infinity();  ///< servopos.position_min
  double max_turns = std::numeric_limits<double>::infinity();
  int home_state = 2;  ///< 0: it counts from power-on, 1: by its rotor, 2: by its output shaft
  std::uint32_t map_version = 5;
  /// That of a motor with 8192 counts a turn.
  SimulatedMotor::Settings motor{.max_acceleration = 600, .friction = 0.25, .coasting_friction = 24};
  bool keeps_record = false;
};

/// A moteus with its motor, frame in and frame out: sub-frames of all types, an answer to whoever asks for
/// one, commands that are complete or nothing, a control position that goes on by its velocity, the watchdog
/// of the last command, faults. When its watchdog has expired it brakes the motor to rest (servo.timeout_mode
/// 12).
class SimulatedMoteus final : public SimulatedServo<can::FdFrame> {
 public:
  /// Powered on at `now_ns`.
  SimulatedMoteus(const SimulatedMoteusSettings& settings, std::int64_t now_ns);

  void receive(const can::FdFrame& frame) override;
  [[nodiscard]] const char* state_name() const override;
  [[nodiscard]] bool misses_something() const override { return mode_ == can::MoteusMode::timeout; }

  [[nodiscard]] can::MoteusMode mode() const { return mode_; }

 private:
  /// What a frame has written. Each has the values of a command that does not say them.
  struct Command {
    std::optional<double> mode;
    double position = 0;
    double velocity = 0;
    double max_torque = std::numeric_limits<double>::quiet_NaN();
    double watchdog_s = 0;
  };
  static void write(const can::MoteusItem& item, Command& command);
  [[nodiscard]] std::optional<double> register_value(const can::MoteusItem& item) const;
  [[nodiscard]] std::optional<can::FdFrame> answer_to(const can::FdFrame& question) const;
  void send(can::FdFrame frame);
  void obey(const Command& command);
  void take_target(const Command& command);
  void begin_position();
  void live(double seconds) override;
  void start_anew() override;
  void step(double seconds);
  void meet(const DriveTrouble& trouble) override;
  void enter(can::MoteusMode mode);
  void fail(int fault);
  void flood();
  [[nodiscard]] bool has_torque() const { return !(command_.max_torque == 0); }

  SimulatedMoteusSettings settings_;
  std::int64_t fed_ns_ = 0;  ///< by the last command
  can::MoteusMode mode_ = can::MoteusMode::stopped;
  int fault_ = 0;
  std::int64_t enabling_ns_ = 0;  ///< since when it is on its way
  Command command_;
  double control_ = 0;  ///< the position that it holds, in its turns
  bool watches_ = true;
};

}  // namespace inbetween
