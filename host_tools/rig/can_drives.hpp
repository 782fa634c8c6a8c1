// The CiA 402 drives of a rig file on its buses.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host_tools/files/rig_file.hpp"
#include "host_tools/rig/counters.hpp"
#include "host_tools/rig/rig_hardware.hpp"
#include "inbetween/can/cia402_port.hpp"

namespace inbetween {

/// The host's node number; no axis may have it.
can::NodeId host_node();
/// Throws InputError at an axis whose drive has no node number of CANopen.
can::NodeId node_of(const RigAxis& axis);
/// The settings that a CiA 402 axis of a rig gets.
can::Cia402Settings settings_of(const RigAxis& axis, std::int32_t rate_hz);
/// Why a drive could not be set up: the object, what it has, and the words of the drive.
std::string words_of(const can::SetupRefusal& refusal);
/// What a drive that is set up does without, with what stands in for each.
std::vector<std::string> words_of_lacks(const can::SetupRunner& setup);
/// The frames of a tick beside those for each drive: SYNC, the heartbeat, and one of NMT or SDO.
inline constexpr std::int64_t frames_of_bus_per_tick = 3;
/// Throws InputError at the place of a bus whose load would be above bus_load_limit_percent, or that has more
/// frames in a tick than are sent at once.
void refuse_overloaded_buses(const RigFile& rig);

class CanDrives final : public PortDrives<can::Cia402Port<double, BusLink>> {
 public:
  /// `axes` of the rig are its CiA 402 axes, at least one. Throws InputError at the place of an axis that
  /// cannot be set up, and what RigHardware::open_bus throws.
  CanDrives(const RigFile& rig, std::span<const std::size_t> axes, RigHardware& hardware);
  CanDrives(const CanDrives&) = delete;
  CanDrives& operator=(const CanDrives&) = delete;

  void place(std::size_t drive, double position) override;
  [[nodiscard]] bool has_lost_position(std::size_t drive) const override;

  /// Each says the first thing that is wrong, with a bus or with a drive, and what to do; "" if nothing is.
  [[nodiscard]] std::string bus_trouble() const;
  [[nodiscard]] std::string drive_trouble() const;
  /// RigDrives::left_on.
  /// What drives that are set up do without, a line each, with what stands in for it.
  [[nodiscard]] std::vector<std::string> notes() const;
  [[nodiscard]] std::string left_on() const;
  /// Adds what the buses and the drives on them have counted.
  void count(Counters& counts) const override;

 private:
  struct BusOfRig {
    std::string name;
    std::vector<std::size_t> axes;
    std::vector<can::Cia402Drive> hosts;
    std::optional<can::Cia402Bus> bus;
    std::unique_ptr<BusLink> link;
    std::vector<std::int32_t> targets;
    std::vector<can::PortDrive> known;
    std::vector<can::Frame> frames;
  };

  const RigFile& rig_;
  std::vector<std::size_t> axes_;
  std::deque<BusOfRig> buses_;
  std::vector<can::Cia402Lane<BusLink>> lanes_;
  std::vector<can::Cia402Axis<double>> ports_;
};

}  // namespace inbetween
