// The motion loop as this program runs it.
#pragma once

#include <atomic>
#include <vector>

#include "host_tools/rig_drives.hpp"
#include "inbetween/motion_loop.hpp"

namespace inbetween {

/// The lines of a rig: a simulated e-stop, which a signal or a test may press from another thread.
class RigLines {
 public:
  void press(bool is_pressed) { is_pressed_.store(is_pressed, std::memory_order_relaxed); }
  [[nodiscard]] bool emergency_stop() const { return is_pressed_.load(std::memory_order_relaxed); }

 private:
  std::atomic<bool> is_pressed_{false};
};

using RunLoop = MotionLoop<double, RigDrives, RigLines>;

}  // namespace inbetween
