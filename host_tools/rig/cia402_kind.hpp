// CiA 402 drives as a rig file has them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "drivers/can/socket_can.hpp"
#include "host_tools/rig/bus_share.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "inbetween/can/cia402_bus.hpp"
#include "sim/cia402_drive.hpp"

namespace inbetween {

/// The host's node number; no axis may have it.
can::NodeId host_node();
/// Throws InputError at an axis whose drive has no node number of CANopen.
can::NodeId node_of(const RigAxis& axis);
/// The settings that a CiA 402 axis of a rig gets.
can::Cia402Settings settings_of(const RigAxis& axis, std::int32_t rate_hz);
/// Why a drive could not be set up: the object, what it has, and the words of the drive.
std::string words_of(const can::SetupRefusal& refusal);
/// What a drive that is set up does without, with what stands in for each, and what it has in another way.
std::vector<std::string> words_of_lacks(const can::Cia402Drive& host);
/// The frames of a tick beside those for each drive: SYNC, the heartbeat, and one of NMT or SDO.
inline constexpr std::int64_t frames_of_bus_per_tick = 3;
/// CiA 402 in the host tools (bus_kind.hpp).
struct Cia402Kind {
  using InRig = Cia402Drive;
  using Bus = can::Cia402Bus;
  /// Counts that a double has every one of.
  static constexpr double max_place = 9'007'199'254'740'992;

  static double scale_of(const RigAxis& axis) { return std::get<InRig>(axis.drive).counts_per_unit; }
  /// The drive counts `zero` where its motor is at 0: its limits of positions lie there.
  static void count_from(can::Cia402Drive& host, const RigAxis& axis, std::int64_t zero);
  static can::Cia402Drive host_of(const RigAxis& axis, std::int32_t rate_hz);
  static Bus bus_of(std::span<can::Cia402Drive> hosts, std::int32_t rate_hz, const RigAxis& first);
  static std::string detail_of(const can::Cia402Drive& host, can::DriveFinding finding);
  static std::vector<std::string> lacks_of(const can::Cia402Drive& host) { return words_of_lacks(host); }
  static std::string fitness_of(const can::Cia402Drive& host, std::int32_t rate_hz);
  static std::vector<can::CanFilter> heard_by_host(const RigAxis& axis);
  static std::vector<can::CanFilter> heard_by_drive(const RigAxis& axis);
  static BusShare share_of(const RigFile& rig, std::span<const std::size_t> axes);
  static std::unique_ptr<SimulatedCanDrive> simulate(const RigAxis& axis, const SimulatedPower& power);
};

/// A simulated drive for a CiA 402 axis that stands at `position`, with a motor that was chosen for its axis.
SimulatedCia402Settings simulated_settings_of(const RigAxis& axis, double position);

}  // namespace inbetween
