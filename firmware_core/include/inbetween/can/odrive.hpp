#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "inbetween/can/device_number.hpp"
#include "inbetween/can/frame.hpp"
#include "inbetween/can/servo_report.hpp"

/// CANSimple, the protocol of ODrive: 11-bit identifiers, little-endian, IEEE float32, positions in turns.
/// Sources: the firmware 0.5.x (communication/can/can_simple.cpp, MotorControl/axis.cpp), which is open, and
/// for 0.6.x the messages of ODrive's own ROS node. The two families give several numbers another meaning.
///
/// There is no SYNC and no object dictionary: a position acts when it arrives, and the drive reports by
/// itself in its own rhythm.

namespace inbetween::can {

enum class OdriveFamily : std::uint8_t {
  firmware_05,  ///< boards v3.x
  firmware_06,  ///< Pro, S1, Micro
};

struct OdriveNodeRange {
  static constexpr std::int64_t min = 0, max = 62;
  static constexpr const char* what = "a node of CANSimple is not a number from 0 to 62";
  static constexpr const char* remedy = "give the number that is set in the drive";
};
/// The number of an ODrive on its bus, 0 to 62; 63 is that of drives that have none yet.
using OdriveNode = DeviceNumber<OdriveNodeRange>;

/// The messages that are used here. They mean the same in both families but for the two that say so.
enum class OdriveMessage : std::uint8_t {
  version = 0x00,  ///< 0.6 only
  heartbeat = 0x01,
  emergency_stop = 0x02,
  error = 0x03,             ///< as read here 0.6 only
  parameter_order = 0x04,   ///< RxSdo, 0.6 only: reads or writes a setting
  parameter_answer = 0x05,  ///< TxSdo, 0.6 only
  address = 0x06,           ///< 0.6 only: in 0.5 it sets the node, also without a number
  axis_state = 0x07,
  estimates = 0x09,
  controller_mode = 0x0B,
  input_position = 0x0C,
  input_velocity = 0x0D,
  input_torque = 0x0E,
  clear_errors = 0x18,
  controller_error = 0x1D,  ///< as asked for here 0.5 only
};
/// What 0.5 is asked for the errors of its parts: other messages in 0.6.
enum class OdrivePart : std::uint8_t { motor = 0x03, encoder = 0x04, controller = 0x1D };
inline constexpr std::array odrive_parts{OdrivePart::motor, OdrivePart::encoder, OdrivePart::controller};
/// The bits of an identifier that are the message.
inline constexpr std::uint32_t odrive_message_bits = 0x1F;
constexpr FrameId odrive_id(OdriveNode node, OdriveMessage message) {
  return FrameId::standard(std::uint32_t{node.value()} << 5 | static_cast<std::uint32_t>(message));
}

inline constexpr std::uint8_t odrive_idle = 1;
inline constexpr std::uint8_t odrive_closed_loop = 8;

// --- from the host

struct OdrivePosition {
  float turns = 0;
  double turns_per_s = 0;  ///< feed-forward, in steps of 0.001
  double torque_nm = 0;    ///< feed-forward, in steps of 0.001
};
/// The largest feed-forward that the 16 bits of its field hold.
inline constexpr double odrive_max_feed_forward = 32.767;
/// Nothing where a feed-forward is beyond 16 bits, which would turn it round, or where the position is no
/// number.
std::optional<Frame> odrive_position_frame(OdriveNode node, const OdrivePosition& position);
std::optional<OdrivePosition> read_odrive_position(const Frame& frame, OdriveNode node);
Frame odrive_state_frame(OdriveNode node, std::uint8_t state);
/// Position control by what input_position says (3 and 1).
Frame odrive_position_mode_frame(OdriveNode node);
Frame odrive_clear_frame(OdriveNode node, OdriveFamily family);
/// Errors, no power, and the motor coasts.
Frame odrive_emergency_stop_frame(OdriveNode node);
/// A question for one of the messages of the drive.
Frame odrive_question(OdriveNode node, OdriveMessage message);

// --- from the drive

struct OdriveHeartbeat {
  std::uint32_t errors = 0;
  std::uint8_t state = 0;
  std::uint8_t result = 0;      ///< 0.6: of the last procedure; 1 while it lasts
  std::uint8_t sub_errors = 0;  ///< 0.5: 1 motor, 2 encoder, 4 controller
  bool is_trajectory_done = false;
  friend bool operator==(const OdriveHeartbeat&, const OdriveHeartbeat&) = default;
};
/// Nothing where the frame is no such message of `node` with eight bytes; so with the others.
std::optional<OdriveHeartbeat> read_odrive_heartbeat(const Frame& frame, OdriveNode node,
                                                     OdriveFamily family);
Frame odrive_heartbeat_frame(OdriveNode node, OdriveFamily family, const OdriveHeartbeat& told);

/// Nothing also where a number is none.
std::optional<ServoPlace> read_odrive_estimates(const Frame& frame, OdriveNode node);
Frame odrive_estimates_frame(OdriveNode node, float turns, float turns_per_s);

struct OdriveVersion {
  std::uint8_t protocol = 0;
  std::array<std::uint8_t, 3> hardware{};
  std::array<std::uint8_t, 3> firmware{};
  bool is_unreleased = false;
  friend bool operator==(const OdriveVersion&, const OdriveVersion&) = default;
};
std::optional<OdriveVersion> read_odrive_version(const Frame& frame, OdriveNode node);
Frame odrive_version_frame(OdriveNode node, const OdriveVersion& told);

struct OdriveError {
  std::uint32_t active = 0;
  std::uint32_t disarm_reason = 0;
  friend bool operator==(const OdriveError&, const OdriveError&) = default;
};
std::optional<OdriveError> read_odrive_error(const Frame& frame, OdriveNode node);
Frame odrive_error_frame(OdriveNode node, const OdriveError& told);

/// The errors of a part of 0.5; of its motor the low half.
std::optional<std::uint32_t> read_odrive_part(const Frame& frame, OdriveNode node, OdrivePart part);
Frame odrive_part_frame(OdriveNode node, OdrivePart part, std::uint32_t errors);
/// One bit of them in words.
const char* words_of_odrive_part(OdrivePart part, std::uint32_t bit);

/// The number that one device has alone, of 48 bits.
std::optional<std::uint64_t> read_odrive_serial(const Frame& frame, OdriveNode node);
Frame odrive_address_frame(OdriveNode node, std::uint64_t serial);

/// The error bit that says that nobody has spoken to the drive for longer than its watchdog allows.
constexpr std::uint32_t odrive_watchdog_error(OdriveFamily family) {
  return family == OdriveFamily::firmware_05 ? 0x800U : 0x100'0000U;
}
/// One bit of the errors in words: "its watchdog has expired".
const char* words_of_odrive_error(OdriveFamily family, std::uint32_t bit);

/// An ODrive for ServoDrive: how it is told, and what its frames say.
class Odrive {
 public:
  using Frame = can::Frame;
  /// It is switched on by an order only, and stays at a target.
  static constexpr ServoHabits habits{};
  static constexpr DriveFinding misfit = DriveFinding::wrong_firmware;
  static constexpr ServoWatch watch() { return ServoWatch::tried; }

  Odrive(OdriveNode node, OdriveFamily family) : node_(node), family_(family) {}

  /// Whether it tells what it is when it is asked. One of the other family does what this one does not.
  [[nodiscard]] bool tells_identity() const { return family_ == OdriveFamily::firmware_06; }
  [[nodiscard]] bool is_concerned(const Frame& frame) const {
    return !frame.id.is_extended() &&
           (frame.id.number() & ~odrive_message_bits) == std::uint32_t{node_.value()} << 5;
  }
  [[nodiscard]] ServoReport read(const Frame& frame);
  /// Nothing where the drive needs no such order. Asked again what it is, it is asked for more each time.
  [[nodiscard]] std::optional<Frame> order(ServoOrder order);
  /// Whether it has not been asked yet for all that there is to know of one with these errors.
  [[nodiscard]] bool has_more_to_ask(std::uint32_t errors) const;
  /// A position that acts at once. It feeds the watchdog.
  [[nodiscard]] std::optional<Frame> command(const ServoTarget& target) const;
  /// Every frame feeds the watchdog, and a position does nothing to a drive that is off.
  [[nodiscard]] std::optional<Frame> hold(ServoHold /*how*/, double turns) const {
    return command({.turns = turns});
  }
  [[nodiscard]] static std::optional<Frame> question() { return {}; }
  static bool fits(const ServoTarget& target) {
    return std::fabs(target.turns_per_s) <= odrive_max_feed_forward;
  }

  [[nodiscard]] OdriveNode node() const { return node_; }
  [[nodiscard]] OdriveFamily family() const { return family_; }
  /// What the parts of 0.5 have told of their errors, in the order of odrive_parts.
  [[nodiscard]] const std::array<std::uint32_t, odrive_parts.size()>& part_errors() const {
    return part_errors_;
  }
  /// Why 0.6 was switched off last.
  [[nodiscard]] std::uint32_t disarm_reason() const { return disarm_reason_; }

 private:
  [[nodiscard]] std::optional<Frame> next_question();

  OdriveNode node_;
  OdriveFamily family_;
  bool is_06_ = false;      ///< it has said so
  std::uint8_t asked_ = 0;  ///< questions since it was to say what it is
  std::optional<std::uint64_t> serial_;
  std::array<std::uint32_t, odrive_parts.size()> part_errors_{};
  std::uint32_t disarm_reason_ = 0;
};

}  // namespace inbetween::can
