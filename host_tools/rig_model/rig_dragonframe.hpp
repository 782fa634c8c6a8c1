// What a rig is to Dragonframe.
#pragma once

#include <vector>

#include "host_tools/text/diagnostics.hpp"

namespace inbetween {

/// Motor 1 is the first axis of the rig, and so on.
struct RigDragonframe {
  std::vector<double> steps_per_unit;  ///< of each axis; below 0: the host counts the other way
  Place place;
};

}  // namespace inbetween
