// USD in its text form (.usda).
//
// Read are prims and their xformOps, with the samples over time, the stage's up axis, unit and rate. Values
// of other properties are passed over as they stand. A file is read as it is: what it takes from other files
// (references, payloads, sublayers) and variants are not, with a warning.
#pragma once

#include <string>
#include <string_view>

#include "host_tools/scene/scene_file.hpp"

namespace inbetween {

/// Throws InputError at line and column where something is wrong, at the file where it is USD in binary or
/// beyond the bounds of scene_bounds.hpp. O(bytes).
SceneFile read_usda(std::string_view text, const std::string& file);

}  // namespace inbetween
