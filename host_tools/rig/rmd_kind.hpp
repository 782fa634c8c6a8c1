// MyActuator's RMD motors as a rig file has them.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drivers/can/socket_can.hpp"
#include "host_tools/rig/bus_share.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "inbetween/can/rmd.hpp"
#include "inbetween/can/servo_bus.hpp"
#include "sim/simulated_can_drive.hpp"

namespace inbetween {

/// The RMD protocol in the host tools (bus_kind.hpp).
struct RmdKind {
  using InRig = RmdDrive;
  using Bus = can::ServoBus<can::Rmd>;
  static constexpr double max_place = can::rmd_max_turns;

  static double scale_of(const RigAxis& axis) { return std::get<InRig>(axis.drive).turns_per_unit; }
  static Bus::Drive host_of(const RigAxis& axis, std::int32_t rate_hz);
  static Bus bus_of(std::span<Bus::Drive> hosts, std::int32_t rate_hz, const RigAxis& first);
  static std::string detail_of(const Bus::Drive& host, can::DriveFinding finding);
  static std::vector<std::string> lacks_of(const Bus::Drive& host);
  static std::string fitness_of(const Bus::Drive& host, std::int32_t rate_hz);
  static std::vector<can::CanFilter> heard_by_host(const RigAxis& axis);
  static std::vector<can::CanFilter> heard_by_drive(const RigAxis& axis);
  static BusShare share_of(const RigFile& rig, std::span<const std::size_t> axes);
  static std::unique_ptr<SimulatedCanDrive> simulate(const RigAxis& axis, const SimulatedPower& power);
};

}  // namespace inbetween
