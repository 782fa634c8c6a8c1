// The stepper drives of a rig file on its GPIO chips, or simulated.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/gpio/step_player.hpp"
#include "host_tools/files/rig_file.hpp"
#include "host_tools/rig/counters.hpp"
#include "host_tools/rig/played_chip.hpp"
#include "inbetween/steps/step_port.hpp"
#include "sim/simulated_step_chip.hpp"

namespace inbetween {

/// A chip of the machine with its thread, or one in this process (StepSink).
class HostStepSink {
 public:
  explicit HostStepSink(SimulatedStepChip& chip) : simulated_(&chip) {}
  explicit HostStepSink(gpio::StepPlayer& player) : player_(&player) {}

  bool push(const EdgeInstant& instant) {
    return player_ != nullptr ? player_->push(instant) : simulated_->push(instant);
  }
  void discard() { player_ != nullptr ? player_->discard() : simulated_->discard(); }
  [[nodiscard]] std::uint64_t waiting() const {
    return player_ != nullptr ? player_->waiting() : simulated_->waiting();
  }
  [[nodiscard]] bool is_too_late() const {
    return player_ != nullptr ? player_->is_too_late() : simulated_->is_too_late();
  }
  [[nodiscard]] bool has_ended() const {
    return player_ != nullptr ? player_->has_ended() : simulated_->has_ended();
  }

 private:
  // One of them.
  SimulatedStepChip* simulated_ = nullptr;
  gpio::StepPlayer* player_ = nullptr;
};

/// Throws InputError at the place of an axis whose drive cannot take the steps that its limits permit.
void refuse_step_rates(const RigFile& rig);

/// A DrivePort for the step-dir axes of a rig, in the order of indices().
class StepDrives {
 public:
  /// Null where the rig has no such axis. Standing at `positions`, in the order of the rig's axes.
  static std::unique_ptr<StepDrives> simulated(const RigFile& rig, const std::vector<double>& positions);
  /// Takes the lines of all chips, at their safe levels, and starts the threads that play the steps, with the
  /// rights of real-time threads if `in_real_time`. Throws InputError at the place of what is not there or
  /// not allowed; then nothing has changed.
  static std::unique_ptr<StepDrives> on_chips(const RigFile& rig, bool in_real_time);
  StepDrives(const StepDrives&) = delete;
  StepDrives& operator=(const StepDrives&) = delete;

  /// Which axes of the rig.
  [[nodiscard]] std::span<const std::size_t> indices() const { return indices_; }

  void read(std::span<DriveState<double>> states, std::int64_t now_ns);
  void write(std::span<const Setpoint<double>> setpoints, std::int64_t now_ns) {
    port_->write(setpoints, now_ns);
  }
  void enable() { port_->enable(); }
  void disable() { port_->disable(); }
  void quick_stop() { port_->quick_stop(); }

  /// Axis `lane` of indices() is at `position`. Only while it rests. Throws InputError at an axis
  /// whose steps cannot be counted so far.
  void place(std::size_t lane, double position);
  /// Steps were counted that the motor did not get: nobody knows where the axis is.
  [[nodiscard]] bool has_lost_steps(std::size_t lane) const {
    return port_->lane_states()[lane].has_lost_steps;
  }
  /// When the motion of the last setpoints is played.
  [[nodiscard]] const TickChain& chain() const { return port_->chain(); }
  /// Of a simulated axis: where its shaft is.
  [[nodiscard]] double shaft(std::size_t lane) const;
  /// What is wrong and what to do, the first found; "" for nothing. Not for the loop's thread.
  [[nodiscard]] std::string trouble() const;
  /// Of the chips; none in simulation.
  [[nodiscard]] std::vector<Counted> counts() const;

 private:
  struct Chip {
    std::string label;
    std::vector<std::size_t> lanes;  ///< of this object, one behind the other
    std::vector<StepLines> wires;
    std::vector<EdgeInstant> instants;
    std::uint64_t enable_mask = 0, enable_levels = 0;
    std::optional<HostStepSink> sink;
    PlayedChip played;  ///< on hardware
    // in simulation
    SimulatedStepChip simulated;
  };

  explicit StepDrives(const RigFile& rig);
  void make_port();
  void open(Chip& chip, bool in_real_time);

  const RigFile& rig_;
  std::vector<std::size_t> indices_;
  std::deque<Chip> chips_;
  std::vector<StepLane<double>> lanes_;
  std::vector<std::vector<StepEdge>> edges_;
  std::vector<StepChip<HostStepSink>> port_chips_;
  std::vector<StepLaneState> lane_states_;
  std::vector<std::span<const StepEdge>> lists_;
  std::optional<StepPort<double, HostStepSink>> port_;
};

}  // namespace inbetween
