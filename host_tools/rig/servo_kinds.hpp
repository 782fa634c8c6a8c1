// The drives that count turns as a rig file has them: the Kinds of their protocols (bus_kind.hpp), each
// written in NAME_kind.cpp, and what they have in common.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "drivers/can/socket_can.hpp"
#include "host_tools/rig/bus_share.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "inbetween/can/cubemars.hpp"
#include "inbetween/can/moteus.hpp"
#include "inbetween/can/odrive.hpp"
#include "inbetween/can/rmd.hpp"
#include "inbetween/can/servo_bus.hpp"
#include "sim/simulated_can_drive.hpp"

namespace inbetween {

/// The part of a Kind that needs no word of its protocol.
template <class Protocol, class RigDrive>
struct ServoKind {
  using InRig = RigDrive;
  using Bus = can::ServoBus<Protocol>;
  using Host = typename Bus::Drive;

  static double scale_of(const RigAxis& axis) { return std::get<InRig>(axis.drive).turns_per_unit; }
  static Bus bus_of(std::span<Host> hosts, std::int32_t /*rate_hz*/, const RigAxis& first) {
    return value_or_refuse(Bus::make(hosts), first.place, named(first));
  }
  static std::vector<std::string> lacks_of(const Host& /*host*/) { return {}; }
};

/// CANSimple.
struct OdriveKind : ServoKind<can::Odrive, OdriveDrive> {
  static constexpr double max_place = max_turns;
  static Host host_of(const RigAxis& axis, std::int32_t rate_hz);
  static std::string detail_of(const Host& host, can::DriveFinding finding);
  static std::string fitness_of(const Host& host, std::int32_t rate_hz);
  static std::vector<can::CanFilter> heard_by_host(const RigAxis& axis);
  static std::vector<can::CanFilter> heard_by_drive(const RigAxis& axis);
  static BusShare share_of(const RigFile& rig, std::span<const std::size_t> axes);
  static std::unique_ptr<SimulatedCanDrive> simulate(const RigAxis& axis, const SimulatedPower& power);
};

/// moteus on CAN FD.
struct MoteusKind : ServoKind<can::Moteus, MoteusDrive> {
  static constexpr double max_place = max_turns;
  static Host host_of(const RigAxis& axis, std::int32_t rate_hz);
  static std::string detail_of(const Host& host, can::DriveFinding finding);
  static std::string fitness_of(const Host& host, std::int32_t rate_hz);
  static std::vector<can::CanFilter> heard_by_host(const RigAxis& axis);
  static std::vector<can::CanFilter> heard_by_drive(const RigAxis& axis);
  static BusShare share_of(const RigFile& rig, std::span<const std::size_t> axes);
  static std::unique_ptr<SimulatedFdDrive> simulate(const RigAxis& axis, const SimulatedPower& power);
};

/// MyActuator's RMD motors.
struct RmdKind : ServoKind<can::Rmd, RmdDrive> {
  static constexpr double max_place = can::rmd_max_turns;
  static Host host_of(const RigAxis& axis, std::int32_t rate_hz);
  static std::string detail_of(const Host& host, can::DriveFinding finding);
  static std::vector<std::string> lacks_of(const Host& host);
  static std::string fitness_of(const Host& host, std::int32_t rate_hz);
  static std::vector<can::CanFilter> heard_by_host(const RigAxis& axis);
  static std::vector<can::CanFilter> heard_by_drive(const RigAxis& axis);
  static BusShare share_of(const RigFile& rig, std::span<const std::size_t> axes);
  static std::unique_ptr<SimulatedCanDrive> simulate(const RigAxis& axis, const SimulatedPower& power);
};

/// CubeMars motors.
struct CubemarsKind : ServoKind<can::Cubemars, CubemarsDrive> {
  static constexpr double max_place = max_cubemars_turns;
  static Host host_of(const RigAxis& axis, std::int32_t rate_hz);
  static std::string detail_of(const Host& host, can::DriveFinding finding);
  static std::vector<std::string> lacks_of(const Host& host);
  static std::string fitness_of(const Host& host, std::int32_t rate_hz);
  static std::vector<can::CanFilter> heard_by_host(const RigAxis& axis);
  static std::vector<can::CanFilter> heard_by_drive(const RigAxis& axis);
  static BusShare share_of(const RigFile& rig, std::span<const std::size_t> axes);
  static std::unique_ptr<SimulatedCanDrive> simulate(const RigAxis& axis, const SimulatedPower& power);
};

/// The settings of a drive that counts turns, from the limits of its axis.
can::ServoSettings servo_settings_of(const RigAxis& axis, std::int32_t rate_hz);
/// Of a drive that counts turns of its output shaft, in steps or with noise of `turns`: what counts as
/// holding a place.
void set_noise(can::ServoSettings& settings, double turns);
/// The bits of an error in words, " (error 14h: ..., ...)"; nothing for 0.
std::string words_of_error_bits(std::uint32_t errors, const char* (*words_of_bit)(std::uint32_t));
/// The note for a drive with no_watchdog = "accepted".
inline constexpr std::string_view words_without_watchdog =
    "nothing stops the motor if this program dies (no_watchdog = \"accepted\"): it goes to its last "
    "position, not "
    "faster than the limit that came with it, and holds it";

}  // namespace inbetween
