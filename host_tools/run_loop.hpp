// The motion loop as this program runs it.
#pragma once

#include "drivers/linux/emergency_signal.hpp"
#include "host_tools/rig_drives.hpp"
#include "inbetween/motion_loop.hpp"

namespace inbetween {

/// The lines of a rig. Until there are some on GPIO, its emergency stop is a signal.
class RigLines {
 public:
  void read(std::int64_t /*now_ns*/) {}
  [[nodiscard]] bool limit_hit() const { return false; }
  [[nodiscard]] bool emergency_stop() const { return EmergencySignal::is_pressed(); }

 private:
  EmergencySignal signal_;
};

using RunLoop = MotionLoop<double, RigDrives, RigLines>;

}  // namespace inbetween
