// The faults of a script, brought into simulated drives at their times.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/rig/fault_script.hpp"
#include "sim/simulated_can_drive.hpp"

namespace inbetween {

class FaultSchedule {
 public:
  /// The drives got power at `power_ns`, on the clock that they have.
  FaultSchedule(const FaultScript& script, std::int64_t power_ns)
      : pending_(script.faults), power_ns_(power_ns) {}

  /// The drive of an axis of the rig, by its number; it stays the caller's.
  void attach(std::size_t axis, SimulatedDrive& drive) { drives_.push_back({axis, &drive}); }

  /// Before the drives are advanced to `now_ns`: what is due begins then. O(faults that have not begun +
  /// drives).
  void advance(std::int64_t now_ns);

  struct Begun {
    std::size_t axis = 0;
    std::int64_t at_ns = 0;
    std::string what;
  };
  [[nodiscard]] const std::vector<Begun>& begun() const { return begun_; }

 private:
  struct DriveOfAxis {
    std::size_t axis;
    SimulatedDrive* drive;
  };
  void begin(const ScriptedFault& fault, std::int64_t now_ns);

  std::vector<ScriptedFault> pending_;
  std::vector<Begun> begun_;
  std::vector<DriveOfAxis> drives_;
  std::int64_t power_ns_;
  std::optional<std::int64_t> motion_ns_;
};

}  // namespace inbetween
