#pragma once

#include <cstdint>
#include <optional>

#include "inbetween/base/result.hpp"
#include "inbetween/can/device_number.hpp"
#include "inbetween/can/drive_finding.hpp"
#include "inbetween/can/frame.hpp"
#include "inbetween/can/servo_report.hpp"

/// The protocol of MyActuator's RMD motors: 11-bit identifiers, always eight bytes, little-endian, angles of
/// the output shaft in hundredths of a degree. Source: the maker's "Motor Motion Protocol V4.2" (2024-05).
///
/// A motor says nothing by itself: it answers every command once, with the same first byte. It has no command
/// that switches it on: the first position does.

namespace inbetween::can {

struct RmdMotorRange {
  static constexpr std::int64_t min = 1, max = 32;
  static constexpr const char* what = "a motor of the RMD protocol is not a number from 1 to 32";
  static constexpr const char* remedy = "give the number that is set in the motor";
};
/// The number of a motor on its bus, 1 to 32.
using RmdMotor = DeviceNumber<RmdMotorRange>;

/// The commands that are used here: byte 0 of a command and of its answer.
enum class RmdCommand : std::uint8_t {
  read_acceleration = 0x42,
  shut_down = 0x80,   ///< no power
  stop = 0x81,        ///< velocity 0 under control
  read_angle = 0x92,  ///< over all turns
  read_status = 0x9A,
  position = 0xA4,
  host_timeout = 0xB3,
};

constexpr FrameId rmd_command_id(RmdMotor motor) {
  return FrameId::standard(0x140U + motor.value());
}
constexpr FrameId rmd_answer_id(RmdMotor motor) {
  return FrameId::standard(0x240U + motor.value());
}
inline constexpr FrameId rmd_all_motors_id = 0x280;
/// Stiffness, damping and torque at once (the motion mode), which is not used here.
constexpr FrameId rmd_motion_id(RmdMotor motor) {
  return FrameId::standard(0x400U + motor.value());
}

/// Of an angle on the wire.
inline constexpr double rmd_steps_per_turn = 36'000;
/// The steps of 32 bits.
inline constexpr double rmd_max_turns = 59'652;

// --- from the host

/// A command without a number.
Frame rmd_command_frame(RmdMotor motor, RmdCommand command);
Frame rmd_acceleration_question(RmdMotor motor);  ///< of positions
Frame rmd_host_timeout_frame(RmdMotor motor, std::uint32_t ms);

struct RmdPosition {
  std::int32_t steps = 0;
  std::uint16_t max_deg_per_s = 0;  ///< 0 is no limit
  friend bool operator==(const RmdPosition&, const RmdPosition&) = default;
};
Frame rmd_position_frame(RmdMotor motor, const RmdPosition& told);
/// Nothing where the frame is no such command for `motor`.
std::optional<RmdPosition> read_rmd_position(const Frame& frame, RmdMotor motor);

// --- from the motor

Frame rmd_angle_frame(RmdMotor motor, std::int32_t steps);
/// Nothing where the frame is no such answer of `motor`; so with the others.
std::optional<std::int32_t> read_rmd_angle(const Frame& frame, RmdMotor motor);

struct RmdStatus {
  std::int8_t celsius = 0;
  bool is_brake_open = false;
  double volts = 0;  ///< in steps of 0.1
  std::uint16_t errors = 0;
  friend bool operator==(const RmdStatus&, const RmdStatus&) = default;
};
Frame rmd_status_frame(RmdMotor motor, const RmdStatus& told);
std::optional<RmdStatus> read_rmd_status(const Frame& frame, RmdMotor motor);

/// The answer to a position, among others. Its angle has steps of a whole degree, and is not used here.
struct RmdMotion {
  std::int8_t celsius = 0;
  double amperes = 0;  ///< in steps of 0.01
  std::int16_t deg_per_s = 0;
  std::int16_t degrees = 0;
};
Frame rmd_motion_frame(RmdMotor motor, const RmdMotion& told);

/// One bit of the errors in words: "its supply voltage is too low".
const char* words_of_rmd_error(std::uint32_t bit);

/// How a motor is told.
struct RmdSettings {
  RmdMotor motor;
  std::uint16_t max_deg_per_s = 0;   ///< the limit that goes with every position
  std::uint16_t hold_deg_per_s = 0;  ///< that of a position where it stands already
  std::uint32_t host_timeout_ms = 100;
  bool has_no_watchdog = false;  ///< and the rig accepts that
};

/// A motor for ServoDrive. It remembers what it has been told last: a motor does not tell whether it has
/// power, but it answers every command, so that a position that is answered has switched it on, and a
/// shutdown off.
class Rmd {
 public:
  using Frame = can::Frame;
  static constexpr ServoHabits habits{.starts_by_target = true,
                                      .restarts_unsaid = true,
                                      .needs_place_to_start = true,
                                      .is_asked_apart = true};
  static constexpr DriveFinding misfit = DriveFinding::plans_by_itself;

  /// Errors: out_of_range (a velocity limit of 0, which is none, a limit of hold above the other, a timeout
  /// of 0).
  static Result<Rmd> make(const RmdSettings& settings);

  [[nodiscard]] ServoWatch watch() const {
    return settings_.has_no_watchdog ? ServoWatch::accepted : ServoWatch::confirmed;
  }
  [[nodiscard]] static constexpr bool tells_identity() { return true; }
  [[nodiscard]] bool is_concerned(const Frame& frame) const;
  [[nodiscard]] ServoReport read(const Frame& frame);
  [[nodiscard]] std::optional<Frame> order(ServoOrder order) const;
  /// What it is asked next: its angle most of the time, its status every fourth time.
  [[nodiscard]] std::optional<Frame> question();
  [[nodiscard]] std::optional<Frame> command(const ServoTarget& target) const;
  [[nodiscard]] std::optional<Frame> hold(ServoHold how, double turns) const;
  static bool fits(const ServoTarget& target);

  [[nodiscard]] RmdMotor motor() const { return settings_.motor; }
  [[nodiscard]] std::uint32_t host_timeout_ms() const { return settings_.host_timeout_ms; }

 private:
  [[nodiscard]] std::optional<Frame> position(double turns, std::uint16_t max_deg_per_s) const;
  explicit Rmd(const RmdSettings& settings) : settings_(settings) {}

  RmdSettings settings_;
  bool may_have_power_ = true;  ///< until it has answered a shutdown
  std::uint32_t errors_ = 0;    ///< that it has told last
  std::uint32_t questions_ = 0;
};

}  // namespace inbetween::can
