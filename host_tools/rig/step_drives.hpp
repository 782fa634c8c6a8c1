// The stepper drives of a rig file on its GPIO chips.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "host_tools/rig/counters.hpp"
#include "host_tools/rig/rig_hardware.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "inbetween/steps/step_port.hpp"

namespace inbetween {

/// Throws InputError at the place of an axis whose drive cannot take the steps that its limits permit.
void refuse_step_rates(const RigFile& rig);

/// A DrivePort for the step-dir axes of a rig, in the order of indices().
class StepDrives final : public PortDrives<StepPort<ChipOutputs>> {
 public:
  /// Takes the lines of all chips and switches nothing on. The rig has such axes. Throws InputError at the
  /// place of what is not there or not allowed; then nothing has changed.
  StepDrives(const RigFile& rig, RigHardware& hardware);
  StepDrives(const StepDrives&) = delete;
  StepDrives& operator=(const StepDrives&) = delete;

  /// Which axes of the rig.
  [[nodiscard]] std::span<const std::size_t> indices() const { return indices_; }

  /// Only while the axis rests.
  void place(std::size_t lane, double position) override;
  /// Steps were counted that the motor did not get: nobody knows where the axis is.
  [[nodiscard]] bool has_lost_position(std::size_t lane) const override {
    return port_->lane_states()[lane].has_lost_steps;
  }
  /// When the motion of the last setpoints is played.
  [[nodiscard]] const TickChain& chain() const { return port_->chain(); }
  /// Says the first thing that is wrong and what to do; "" if nothing is. Not for the loop's thread.
  [[nodiscard]] std::string trouble() const override;
  /// Adds what the chips that count have counted, and the steps of each axis that its driver's times delayed.
  void count(Counters& counts) const override;

 private:
  struct Chip {
    std::string label;
    std::vector<std::size_t> lanes;  ///< of this object, one behind the other
    std::vector<StepLines> wires;
    std::vector<EdgeInstant> instants;
    std::uint64_t enable_mask = 0, enable_levels = 0;
    std::unique_ptr<ChipOutputs> outputs;
  };

  void add_lanes(Chip& chip);
  void make_port();

  const RigFile& rig_;
  std::vector<std::size_t> indices_;
  std::deque<Chip> chips_;
  std::vector<StepLane> lanes_;
  std::vector<std::vector<StepEdge>> edges_;
  std::vector<StepChip<ChipOutputs>> port_chips_;
  std::vector<StepLaneState> lane_states_;
  std::vector<std::span<const StepEdge>> lists_;
};

}  // namespace inbetween
