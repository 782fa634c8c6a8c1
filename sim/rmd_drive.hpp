#pragma once

#include <cstdint>
#include <optional>

#include "inbetween/can/rmd.hpp"
#include "sim/drive_trouble.hpp"
#include "sim/simulated_can_drive.hpp"
#include "sim/simulated_motor.hpp"
#include "sim/simulated_ramp.hpp"

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
class SimulatedRmd final : public SimulatedCanDrive {
 public:
  /// Powered on at `now_ns`.
  SimulatedRmd(const SimulatedRmdSettings& settings, std::int64_t now_ns);

  void advance(std::int64_t now_ns) override;
  void receive(const can::Frame& frame) override;
  void add_trouble(const DriveTrouble& trouble) override { troubles_.add(trouble); }
  [[nodiscard]] bool has_been_moved() const override { return has_been_moved_; }
  [[nodiscard]] double position() const override { return motor_.position(); }
  [[nodiscard]] double velocity() const override { return motor_.velocity(); }
  [[nodiscard]] const char* state_name() const override;
  [[nodiscard]] bool misses_something() const override { return false; }  // it tells nobody
  DriveRecord take_record() override;

 private:
  using Kind = DriveTrouble::Kind;
  enum class State : std::uint8_t { off, in_position, stopped };
  void send(const can::Frame& frame);
  void start_anew();
  void step(double seconds);
  void meet(const DriveTrouble& trouble);
  void enter(State state);
  void obey(const can::Frame& frame);
  void take_position(const can::RmdPosition& position);
  void answer_acceleration(const can::Frame& frame);
  void answer_status();
  [[nodiscard]] bool has_trouble(Kind kind) const { return troubles_.has(kind, now_ns_); }

  SimulatedRmdSettings settings_;
  SimulatedMotor motor_;
  std::int64_t now_ns_;
  std::int64_t boot_ns_;
  std::int64_t watchdog_ns_ = 0;  ///< 0: off
  std::int64_t fed_ns_ = 0;
  State state_ = State::off;
  std::uint16_t errors_ = 0;
  double zero_ = 0;  ///< where its encoder counts from
  double target_ = 0;
  double max_turns_per_s_ = 0;  ///< 0: no limit
  SimulatedRamp demand_;
  std::optional<std::int32_t> first_target_;
  bool has_been_moved_ = false;
  DriveRecord record_;
  DriveTroubles troubles_;
};

}  // namespace inbetween
