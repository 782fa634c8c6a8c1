// The memory of a motion loop, on the heap.
#pragma once

#include <cstddef>
#include <vector>

#include "inbetween/loop/motion_loop.hpp"

namespace inbetween {

/// For a rig of so many drives, and moves of up to so many axes.
class LoopStorage {
 public:
  LoopStorage(std::size_t drives, std::size_t axes)
      : states_(drives), setpoints_(drives), next_(axes), motions_(axes) {}
  LoopStorage(const LoopStorage&) = delete;
  LoopStorage& operator=(const LoopStorage&) = delete;

  [[nodiscard]] LoopMemory memory() { return {states_, setpoints_, next_, motions_}; }
  /// The setpoints that the drives were told last.
  [[nodiscard]] std::vector<double> targets() const {
    std::vector<double> targets;
    for (const Setpoint& setpoint : setpoints_) targets.push_back(setpoint.position);
    return targets;
  }

 private:
  std::vector<DriveState> states_;
  std::vector<Setpoint> setpoints_, next_;
  std::vector<AxisMotion> motions_;
};

}  // namespace inbetween
