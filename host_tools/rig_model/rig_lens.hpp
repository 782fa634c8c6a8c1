// The lens of the rig's camera, which makes pixels of what the rig does.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "host_tools/text/diagnostics.hpp"

namespace inbetween {

/// A lens without distortion before a sensor, at a tip of the rig. The tip looks along its x axis; its y axis
/// points to the left of the picture, its z axis up.
struct RigLens {
  double focal_length_mm = 0;                      ///< above 0
  std::array<double, 2> sensor_mm = {};            ///< width and height of what the picture shows, above 0
  std::array<std::int32_t, 2> resolution_px = {};  ///< of the picture, width and height, above 0
  double distance_m = 0;                           ///< from the tip to what is looked at, above 0
  std::string tip;                                 ///< one of RigKinematics::tips
  Place place;
};

}  // namespace inbetween
