#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "inbetween/can/device_number.hpp"
#include "inbetween/can/fd_frame.hpp"
#include "inbetween/can/servo_report.hpp"

/// The protocol of moteus controllers on CAN FD, as their host speaks it. Sources: mjbots/moteus
/// docs/protocol, docs/reference and fw/moteus_controller.cc, register map version 5.
///
/// A moteus tells nothing by itself: every frame asks for an answer. Every command is complete, and what it
/// does not say is as if it was never said; so it always says a position, because 0 is the default. A command
/// switches the drive on. Its watchdog runs from the last command; when it ends the drive brakes by itself,
/// as its setting servo.timeout_mode says, and takes no command before it has been told to stop (mode 11).

namespace inbetween::can {

struct MoteusNodeRange {
  static constexpr std::int64_t min = 1, max = 126;
  static constexpr const char* what = "a node of a moteus is not a number from 1 to 126";
  static constexpr const char* remedy = "give the number that is set in the drive, id.id";
};
/// The number of a moteus on its bus, 1 to 126; 127 is that of all.
using MoteusNode = DeviceNumber<MoteusNodeRange>;

/// An identifier is the sender's number, then the receiver's. This program is 0.
inline constexpr std::uint32_t moteus_number_bits = 0x7F;
inline constexpr unsigned moteus_sender_shift = 8;
inline constexpr std::uint32_t moteus_all_nodes = 0x7F;
inline constexpr std::uint32_t moteus_asks_for_answer = 0x8000;  ///< in the identifier of a host

enum class MoteusMode : std::uint8_t {
  stopped = 0,  ///< without power; writing it clears a fault
  fault = 1,
  enabling = 2,
  calibrating = 3,
  calibrated = 4,
  position = 10,
  timeout = 11,  ///< its watchdog has expired; it brakes
};

inline constexpr double moteus_here = std::numeric_limits<double>::quiet_NaN();

/// A command in mode 10. From its position the drive goes on by its velocity until the next.
struct MoteusCommand {
  double turns = moteus_here;  ///< of the output shaft; moteus_here: where it is
  double turns_per_s = 0;
  std::optional<double> max_torque_nm{};  ///< none: that of its settings
  std::optional<double> watchdog_s{};     ///< none: that of its settings
};
/// With the question how and where it is.
FdFrame moteus_command_frame(MoteusNode node, const MoteusCommand& command);
/// No power, no fault; no answer.
FdFrame moteus_stop_frame(MoteusNode node);
/// How and where it is: its mode, position, velocity, torque, voltage, temperature and fault.
FdFrame moteus_question(MoteusNode node);
/// What it is, and whether it knows its place.
FdFrame moteus_identity_question(MoteusNode node);

/// Errors as ServoStatus has them: a fault by its number, another mode than it should be in as this and the
/// mode.
inline constexpr std::uint32_t moteus_mode_error = 0x100;
inline constexpr std::uint32_t moteus_timeout_error =
    moteus_mode_error + static_cast<std::uint32_t>(MoteusMode::timeout);
/// In words: "it is too hot".
const char* words_of_moteus_error(std::uint32_t error);

inline constexpr std::uint32_t moteus_map_version = 5;

/// A moteus for ServoDrive.
class Moteus {
 public:
  using Frame = FdFrame;
  static constexpr ServoHabits habits{.goes_on_by_velocity = true, .starts_by_target = true};
  static constexpr DriveFinding misfit = DriveFinding::wrong_firmware;
  static constexpr ServoWatch watch() { return ServoWatch::tried; }
  struct Settings {
    MoteusNode node;
    /// Without a command for so long it stops by itself. It goes with every command.
    double watchdog_s = 0.05;
    /// The rig believes its position, which therefore must not count from wherever it was switched on.
    bool must_know_place = true;
  };
  explicit Moteus(const Settings& settings) : settings_(settings) {}

  [[nodiscard]] static bool tells_identity() { return true; }
  [[nodiscard]] bool is_concerned(const FdFrame& frame) const { return is_answer(frame) || is_for_it(frame); }
  [[nodiscard]] ServoReport read(const FdFrame& frame) const;
  [[nodiscard]] std::optional<FdFrame> order(ServoOrder order) const;
  [[nodiscard]] std::optional<FdFrame> command(const ServoTarget& target) const;
  [[nodiscard]] std::optional<FdFrame> hold(ServoHold how, double turns) const;
  [[nodiscard]] std::optional<FdFrame> question() const { return moteus_question(settings_.node); }
  static bool fits(const ServoTarget& target) {
    return std::isfinite(static_cast<float>(target.turns)) &&
           std::isfinite(static_cast<float>(target.turns_per_s));
  }

  [[nodiscard]] const Settings& settings() const { return settings_; }

 private:
  [[nodiscard]] bool is_answer(const FdFrame& frame) const {
    return frame.id.number() == std::uint32_t{settings_.node.value()} << moteus_sender_shift;
  }
  [[nodiscard]] bool is_for_it(const FdFrame& frame) const {
    const std::uint32_t receiver = frame.id.number() & moteus_number_bits;
    return frame.id.number() <= 0xFFFF &&
           (receiver == settings_.node.value() || receiver == moteus_all_nodes);
  }
  Settings settings_;
};

}  // namespace inbetween::can
