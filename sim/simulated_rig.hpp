#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "inbetween/loop/ports.hpp"
#include "sim/simulated_axis.hpp"

namespace inbetween {

/// The drives of a rig without hardware: each arrives at a setpoint one tick after it was written. Switched
/// on by the tick after `enable`. What goes wrong on a rig can be made to go wrong here.
class SimulatedRig {
 public:
  /// At rest at `positions`, switched off.
  explicit SimulatedRig(std::span<const double> positions);

  void read(std::span<DriveState<double>> states, std::int64_t now_ns);
  void write(std::span<const Setpoint<double>> setpoints, std::int64_t now_ns);
  void enable() { is_switched_on_ = true; }
  void disable() { is_switched_on_ = false; }
  /// The axis is at `position` from now on as its drive counts, wherever it really is.
  void place(std::size_t axis, double position) { shifts_[axis] = position - axes_[axis].actual(); }
  /// An ideal drive stands where it was told last.
  void quick_stop() {}

  /// The axes where they really are.
  [[nodiscard]] const std::vector<SimulatedAxis>& axes() const { return axes_; }
  /// How often setpoints have been written.
  [[nodiscard]] std::size_t writes() const { return writes_; }

  /// Setpoints do not arrive any more, and drives stay where they are.
  void disconnect() { connected_ = false; }
  void reconnect() { connected_ = true; }
  void set_fault(std::size_t axis, bool has_fault) { faults_[axis] = has_fault; }
  /// Somebody moves an axis while it is off.
  void move_by_hand(std::size_t axis, double position) { axes_[axis] = SimulatedAxis(position); }

 private:
  std::vector<SimulatedAxis> axes_;
  std::vector<double> shifts_;  ///< what a drive tells against where its axis is
  std::vector<bool> faults_;
  bool connected_ = true;
  bool is_switched_on_ = false;
  std::size_t writes_ = 0;
};

/// Lines that are released.
struct SimulatedLines {
  bool is_pressed = false;
  bool is_at_limit = false;
  int begins = 0;
  void read(std::int64_t /*now_ns*/) {}
  void begin() { ++begins; }
  [[nodiscard]] bool limit_hit() const { return is_at_limit; }
  [[nodiscard]] bool emergency_stop() const { return is_pressed; }
};

}  // namespace inbetween
