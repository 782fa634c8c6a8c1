// The buses and GPIO chips of this machine under a rig.
#pragma once

#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drivers/can/socket_can.hpp"
#include "drivers/linux/instance_lock.hpp"
#include "host_tools/rig/rig_hardware.hpp"
#include "host_tools/rig_model/rig_motors.hpp"

namespace inbetween {

/// Opens a bus of the rig. Throws InputError at the place of the bus where it is not there.
template <class Frame>
void open_bus_of(const RigFile& rig, const std::string& bus, std::span<const can::CanFilter> filters,
                 can::CanSocket<Frame>& socket) {
  if (const auto refusal = socket.open(bus, filters)) refuse_at(place_of_bus(rig, bus), *refusal);
}

/// Looks at every line that the rig has, before any of them is taken: each is there, meant once and free.
/// Nothing is changed. Returns an error at the place of each that is not.
std::vector<InputError> unavailable_lines(const RigFile& rig);
/// Throws the first of them.
void refuse_unavailable_lines(const RigFile& rig);

/// Nobody else can open a bus through it meanwhile. Lines are taken at their safe levels.
class MachineHardware final : public RigHardware {
 public:
  /// The threads that play edges ask for the rights of real-time threads if `in_real_time`, and are refused
  /// without them. Refers to the rig.
  explicit MachineHardware(const RigFile& rig, bool in_real_time = true)
      : rig_(rig), motors_(motors_of(rig).rig), in_real_time_(in_real_time) {}

  std::unique_ptr<ChipOutputs> open_steps(const std::string& chip, std::span<const std::size_t> axes,
                                          std::span<const StepLines> wires) override;
  std::unique_ptr<ChipOutputs> open_pulses(const std::string& chip,
                                           std::span<const PulseLine> lines) override;
  std::string chip_of(const LineAddress& line) override;
  std::vector<OpenedInputs> open_inputs(std::span<const InputLine* const> lines) override;
  std::unique_ptr<AxisDrives> open_others(std::span<const std::size_t> axes) override;

 private:
  std::unique_ptr<BusLink<can::Frame>> open_classic_bus(const std::string& bus,
                                                        std::span<const std::size_t> axes) override;
  std::unique_ptr<BusLink<can::FdFrame>> open_fd_bus(const std::string& bus,
                                                     std::span<const std::size_t> axes) override;
  void lock_bus(const std::string& bus);

  const RigFile& rig_;
  RigFile motors_;  ///< what buses and chips know
  bool in_real_time_;
  std::map<std::string, InstanceLock> buses_;  ///< those that have been opened
};

}  // namespace inbetween
