// A rig in this process: simulated drives, motors, switches and lines in place of the machine's.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host_tools/rig/fault_schedule.hpp"
#include "host_tools/rig/fault_script.hpp"
#include "host_tools/rig/rig_hardware.hpp"
#include "host_tools/rig/step_log.hpp"
#include "host_tools/rig_model/rig_motors.hpp"
#include "sim/can_bus.hpp"
#include "sim/simulated_can_drive.hpp"
#include "sim/simulated_inputs.hpp"
#include "sim/simulated_step_chip.hpp"

namespace inbetween {

/// Axes on CAN buses have drives that speak their frames, step-dir axes motors that turn by the edges on
/// their lines, the others ideal drives. Home switches are at `home.at`, limit switches beyond what a homing
/// needs; the other inputs are released. Pulses are played in time.
class SimulatedHardware final : public RigHardware {
 public:
  /// The axes stand at `positions`, in the order of the rig. The faults begin after power-on, which is at 0.
  /// Refers to the rig.
  SimulatedHardware(const RigFile& rig, std::vector<double> positions, const FaultScript& faults = {})
      : rig_(rig),
        motors_(motors_of(rig)),
        axis_positions_(std::move(positions)),
        faults_(faults, 0),
        where_(motors_.of.size()) {
    for (const auto& motor : motors_.of) {
      positions_.push_back(motor_position(rig.axes[motor.axis], motor, axis_positions_[motor.axis]));
    }
  }

  /// From now on every edge on a STEP line goes there, before any is opened. Throws InputError where the rig
  /// has no such line, and what StepLog throws.
  void log_steps(const std::string& file, bool waits);
  std::optional<LoopLogEnd> end_step_log() override;

  void advance(std::int64_t now_ns) override;
  std::unique_ptr<ChipOutputs> open_steps(const std::string& chip, std::span<const std::size_t> axes,
                                          std::span<const StepLines> wires) override;
  [[nodiscard]] double counted_from(std::size_t axis) const override { return positions_[axis]; }
  std::unique_ptr<ChipOutputs> open_pulses(const std::string& chip,
                                           std::span<const PulseLine> lines) override;
  std::string chip_of(const LineAddress& line) override { return line.chip; }
  /// All of them on one chip, numbered as they are here; no chip where there are none.
  std::vector<OpenedInputs> open_inputs(std::span<const InputLine* const> lines) override;
  std::unique_ptr<AxisDrives> open_others(std::span<const std::size_t> axes) override;

  /// The true position of an axis, whatever its drive was told. Its drive has been opened.
  [[nodiscard]] double true_position(std::size_t axis) const {
    return axis_position(rig_.axes[axis], motors_.of[axis], where_[axis]());
  }
  /// The same of a motor, in its unit (motors_of).
  [[nodiscard]] double true_motor_position(std::size_t motor) const { return where_[motor](); }
  /// The input lines that have been opened.
  [[nodiscard]] SimulatedInputs& inputs() { return inputs_.value(); }

 private:
  void log_edges_of(SimulatedStepChip& chip, std::vector<std::size_t> motors, std::vector<StepLines> lines);
  std::unique_ptr<BusLink<can::Frame>> open_classic_bus(const std::string& bus,
                                                        std::span<const std::size_t> axes) override;
  std::unique_ptr<BusLink<can::FdFrame>> open_fd_bus(const std::string& bus,
                                                     std::span<const std::size_t> axes) override;
  template <class Frame>
  std::unique_ptr<BusLink<Frame>> simulate_bus(SimulatedBus<Frame>& wire, std::span<const std::size_t> axes);

  const RigFile& rig_;
  RigMotors motors_;
  std::vector<double> axis_positions_;
  std::vector<double> positions_;  ///< of the motors
  std::deque<SimulatedCanBus> buses_;
  std::deque<SimulatedFdBus> fd_buses_;
  std::vector<std::unique_ptr<SimulatedDrive>> drives_;
  std::deque<SimulatedStepChip> chips_;
  std::optional<StepLog> step_log_;
  FaultSchedule faults_;
  std::optional<SimulatedInputs> inputs_;
  std::vector<std::function<double()>> where_;  ///< empty for a motor whose drive has not been opened
};

}  // namespace inbetween
