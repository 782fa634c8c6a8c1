// A scene as USD in its text form (.usda).
//
// Source: openusd.org, UsdGeomXformable (ops translate and orient, of which a viewer interpolates the first
// on straight lines and the second by slerp), UsdGeomCamera (focal length and apertures in tenths of a unit
// of the scene, focus in units; it looks along -z with y up), and the stage's upAxis, metersPerUnit,
// timeCodesPerSecond. A time code is a frame.
#pragma once

#include <string>

#include "host_tools/exchange/baked_table.hpp"
#include "host_tools/scene/animated_scene.hpp"

namespace inbetween {

struct UsdaChoices {
  UpAxis up = UpAxis::z;
  double metres_per_unit = 1;
};

/// Numbers read back exactly. Names that USD does not have are spelled with _, and stand as they are in
/// inbetween:name. Throws InputError where links hang deeper than max_scene_depth on each other, and where
/// the file would have more than max_usda_bytes. O(rows * nodes).
std::string write_usda(const AnimatedScene& scene, const UsdaChoices& choices = {});

}  // namespace inbetween
