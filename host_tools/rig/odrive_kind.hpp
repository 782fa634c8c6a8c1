// ODrives as a rig file has them.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "drivers/can/socket_can.hpp"
#include "host_tools/files/rig_file.hpp"
#include "host_tools/rig/bus_share.hpp"
#include "inbetween/can/odrive.hpp"
#include "inbetween/can/servo_bus.hpp"
#include "sim/simulated_can_drive.hpp"

namespace inbetween {

/// The settings of a drive that counts turns, from the limits of its axis.
can::ServoSettings servo_settings_of(const RigAxis& axis, double turns_per_unit, double max_following_error,
                                     std::int32_t rate_hz);
/// Of a drive that counts turns of its output shaft, in steps or with noise of `turns`: what counts as
/// holding a place and as rest.
void set_noise(can::ServoSettings& settings, double turns);
/// The bits of an error in words, " (error 14h: ..., ...)"; nothing for 0.
std::string words_of_error_bits(std::uint32_t errors, const char* (*words_of_bit)(std::uint32_t));
/// The note for a drive with no_watchdog = "accepted".
inline constexpr std::string_view words_without_watchdog =
    "nothing stops the motor if this program dies (no_watchdog = \"accepted\"): it goes to its last "
    "position, not "
    "faster than the limit that came with it, and holds it";

/// CANSimple in the host tools (bus_kind.hpp).
struct OdriveKind {
  using InRig = OdriveDrive;
  using Bus = can::ServoBus<can::Odrive>;
  static constexpr double max_place = max_turns;

  static double scale_of(const RigAxis& axis) { return std::get<InRig>(axis.drive).turns_per_unit; }
  static Bus::Drive host_of(const RigAxis& axis, std::int32_t rate_hz);
  static Bus bus_of(std::span<Bus::Drive> hosts, std::int32_t rate_hz, const RigAxis& first);
  static std::string detail_of(const Bus::Drive& host, can::DriveFinding finding);
  static std::vector<std::string> lacks_of(const Bus::Drive& /*host*/) { return {}; }
  static std::string fitness_of(const Bus::Drive& host, std::int32_t rate_hz);
  static std::vector<can::CanFilter> heard_by_host(const RigAxis& axis);
  static std::vector<can::CanFilter> heard_by_drive(const RigAxis& axis);
  static BusShare share_of(const RigFile& rig, std::span<const std::size_t> axes);
  static std::unique_ptr<SimulatedCanDrive> simulate(const RigAxis& axis, const SimulatedPower& power);
};

}  // namespace inbetween
