#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "inbetween/loop/ports.hpp"

namespace inbetween {

/// The drives of a rig without hardware: each arrives at a setpoint one tick after it was written. Switched
/// on by the tick after `enable`. What goes wrong on a rig can be made to go wrong here.
class SimulatedRig {
 public:
  /// At rest at `positions`, switched off.
  explicit SimulatedRig(std::span<const double> positions);

  void read(std::span<DriveState> states, std::int64_t now_ns);
  void write(std::span<const Setpoint> setpoints, std::int64_t now_ns);
  void enable() { is_switched_on_ = true; }
  void disable() { is_switched_on_ = false; }
  /// The axis is at `position` from now on as its drive counts, wherever it really is.
  void place(std::size_t axis, double position) { shifts_[axis] = position - actual_[axis]; }
  /// An ideal drive stands where it was told last.
  void quick_stop() {}

  /// Where the axis really is.
  [[nodiscard]] double true_position(std::size_t axis) const { return actual_[axis]; }
  /// How often setpoints have been written.
  [[nodiscard]] std::size_t writes() const { return writes_; }

  /// Setpoints do not arrive any more, and drives stay where they are.
  void disconnect() { connected_ = false; }
  void reconnect() { connected_ = true; }
  void set_fault(std::size_t axis, bool has_fault) { faults_[axis] = has_fault; }
  /// Somebody moves an axis while it is off.
  void move_by_hand(std::size_t axis, double position) { commanded_[axis] = actual_[axis] = position; }

 private:
  std::vector<double> commanded_, actual_;
  std::vector<double> shifts_;  ///< what a drive tells against where its axis is
  std::vector<bool> faults_;
  bool connected_ = true;
  bool is_switched_on_ = false;
  std::size_t writes_ = 0;
};

}  // namespace inbetween
