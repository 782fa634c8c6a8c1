#pragma once

#include <cstdint>
#include <optional>

#include "inbetween/base/result.hpp"
#include "inbetween/can/device_number.hpp"
#include "inbetween/can/drive_finding.hpp"
#include "inbetween/can/frame.hpp"
#include "inbetween/can/scale_watch.hpp"
#include "inbetween/can/servo_report.hpp"

/// The servo mode of CubeMars' AK motors: 29-bit identifiers of a packet number and the motor's, big-endian
/// payloads, degrees of the output shaft. Sources: the manual of the AK80-64, V1.0.8, and open drivers of the
/// firmware V1 to V3, which differ in two scales.
///
/// A motor tells where it is in its own rhythm, and takes commands without an answer. The first position
/// gives it power, and nothing of it is known to stop it when its host dies: it holds the last position.

namespace inbetween::can {

struct CubemarsMotorRange {
  static constexpr std::int64_t min = 1, max = 255;
  static constexpr const char* what = "a motor of CubeMars is not a number from 1 to 255";
  static constexpr const char* remedy = "give the number that is set in the motor";
};
/// The number of a motor on its bus, 1 to 255.
using CubemarsMotor = DeviceNumber<CubemarsMotorRange>;

/// The packets that are used here.
enum class CubemarsPacket : std::uint8_t {
  current = 1,   ///< 0 A takes the power away
  speed = 3,     ///< 0 brakes and holds, whatever the scale of positions is
  position = 6,  ///< with limits of velocity and acceleration
  feedback = 0x29,
};
/// Commands have packet numbers below this.
inline constexpr std::uint32_t cubemars_commands = 0x10;
constexpr FrameId cubemars_id(CubemarsMotor motor, CubemarsPacket packet) {
  return FrameId::extended(std::uint32_t{static_cast<std::uint8_t>(packet)} << 8 | motor.value());
}

/// What the firmware takes its numbers for, and what is on the shaft.
struct CubemarsScale {
  double counts_per_deg = 10'000;      ///< early manuals: 1'000'000
  double erpm_per_count = 10;          ///< of velocity and of acceleration; early manuals: 1
  double electric_turns_per_turn = 0;  ///< of the output shaft: pole pairs times gear ratio
  /// Counts of a velocity (turns/s) or an acceleration (turns/s^2) of the output shaft.
  [[nodiscard]] double counts_of(double turns) const {
    return turns * 60 * electric_turns_per_turn / erpm_per_count;
  }
};

// --- from the host

/// In the counts of the motor's firmware.
struct CubemarsPosition {
  std::int32_t position = 0;
  std::int16_t max_velocity = 0;
  std::int16_t max_acceleration = 0;
  friend bool operator==(const CubemarsPosition&, const CubemarsPosition&) = default;
};
Frame cubemars_position_frame(CubemarsMotor motor, const CubemarsPosition& told);
/// Nothing where the frame is no such packet for `motor`; so with the others.
std::optional<CubemarsPosition> read_cubemars_position(const Frame& frame, CubemarsMotor motor);
Frame cubemars_current_frame(CubemarsMotor motor, std::int32_t milliamperes);
std::optional<std::int32_t> read_cubemars_current(const Frame& frame, CubemarsMotor motor);

/// Electrical turns a minute.
Frame cubemars_speed_frame(CubemarsMotor motor, std::int32_t erpm);
std::optional<std::int32_t> read_cubemars_speed(const Frame& frame, CubemarsMotor motor);

// --- from the motor

struct CubemarsFeedback {
  std::int16_t decidegrees = 0;  ///< of the output shaft; goes round after 6553.6 degrees
  std::int16_t dekaerpm = 0;
  std::int16_t centiamperes = 0;
  std::int8_t celsius = 0;
  std::uint8_t error = 0;  ///< 0: none
  friend bool operator==(const CubemarsFeedback&, const CubemarsFeedback&) = default;
};
Frame cubemars_feedback_frame(CubemarsMotor motor, const CubemarsFeedback& told);
std::optional<CubemarsFeedback> read_cubemars_feedback(const Frame& frame, CubemarsMotor motor);

/// "its encoder has failed".
const char* words_of_cubemars_error(std::uint32_t error);

struct CubemarsSettings {
  CubemarsMotor motor;
  CubemarsScale scale;
  std::int16_t max_velocity = 0;   ///< that goes with every position, in counts
  std::int16_t hold_velocity = 0;  ///< that of a position where it stands already
  std::int16_t max_acceleration = 0;
};

/// A motor for ServoDrive. Feedback goes round: how often is counted from when the motor was asked for first,
/// where it must be within 3200 degrees of its 0. It remembers whether a position or 0 A was sent last, and
/// counts as off once it tells that no current flows.
class Cubemars {
 public:
  using Frame = can::Frame;
  static constexpr ServoHabits habits{.starts_by_target = true,
                                      .restarts_unsaid = true,
                                      .needs_place_to_start = true,
                                      .has_two_scales = true};
  /// Feedback comes in tenths of a degree, cut off: so that two places are told up to a step wrong.
  [[nodiscard]] ScaleWatch::Settings scale_watch() const {
    return {.noise_turns = 1.2 / 3'600,
            .proof_turns = 10.0 / 360,
            .ramp_turns_per_s2 = settings_.max_acceleration / settings_.scale.counts_of(1)};
  }
  static constexpr DriveFinding misfit = DriveFinding::wrong_firmware;
  static constexpr ServoWatch watch() { return ServoWatch::accepted; }

  /// Errors: out_of_range (a limit or scale that is not positive, a velocity of hold above the other).
  static Result<Cubemars> make(const CubemarsSettings& settings);

  [[nodiscard]] static constexpr bool tells_identity() { return false; }
  [[nodiscard]] bool is_concerned(const Frame& frame) const;
  [[nodiscard]] ServoReport read(const Frame& frame);
  [[nodiscard]] std::optional<Frame> order(ServoOrder order);
  [[nodiscard]] static std::optional<Frame> question() { return {}; }
  [[nodiscard]] std::optional<Frame> command(const ServoTarget& target);
  [[nodiscard]] std::optional<Frame> hold(ServoHold how, double turns);
  static bool fits(const ServoTarget& target);

  [[nodiscard]] CubemarsMotor motor() const { return settings_.motor; }

 private:
  explicit Cubemars(const CubemarsSettings& settings) : settings_(settings) {}
  std::optional<Frame> position(double turns, std::int16_t max_velocity);

  CubemarsSettings settings_;
  bool may_have_power_ = true;  ///< until it has been sent 0 A
  std::optional<std::int16_t> last_decidegrees_;
  std::int64_t decidegrees_ = 0;  ///< over all turns
};

}  // namespace inbetween::can
