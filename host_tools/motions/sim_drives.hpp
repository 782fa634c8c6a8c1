// The drives of a rig as a process of their own: they speak their frames on the rig's buses.
#pragma once

#include <cstdio>
#include <functional>
#include <map>
#include <string>

#include "host_tools/rig/fault_script.hpp"
#include "host_tools/rig_model/rig_file.hpp"

namespace inbetween {

struct SimDrivesOptions {
  /// The positions of axes, by name; the others stand at 0, or as near to it as their limits allow.
  std::map<std::string, double> standing = {};
  /// Whether somebody wants it to end.
  std::function<bool()> interrupted = {};
  /// Called once the buses are open and the drives have power.
  std::function<void()> ready = {};
  /// Their faults, for the same rig.
  FaultScript faults = {};
  /// Receives a line per target that a drive applied: axis, nanoseconds of the monotonic clock, units of the
  /// drive; one per state of its protocol that it entered, with its velocity at that moment; one per
  /// emergency that it sent; one per fault that has begun; and one per axis with what it does at the end. May
  /// be null.
  std::FILE* record = nullptr;
};

/// Until it is interrupted. Axes on STEP and DIR lines are left out: nothing at those answers. Throws
/// InputError at the place of a bus that is not there, or of an axis whose drive is on no CAN bus or
/// unknown; and where no axis is left. Looks at its buses a thousand times a second.
void run_sim_drives(const RigFile& of, const SimDrivesOptions& options);

}  // namespace inbetween
