// A scene as glTF 2.0: one file of JSON with its numbers in it (.gltf), or a binary one (.glb).
//
// glTF has metres, y up, and times in seconds from 0; its numbers are float32. The rate, the first frame, the
// focal length, the sensor and the focus have no place in it and stand in `extras.inbetween`, where other
// programs pass over them. Source: Khronos, glTF 2.0 specification, 3.11 (animations) and 3.10 (cameras).
#pragma once

#include <string>

#include "host_tools/scene/animated_scene.hpp"

namespace inbetween {

/// How far what a reader gets on the rows is from the scene, because numbers have 24 bits. The node of the
/// camera takes up what rounding its parents leaves, so that it adds up along no chain of joints.
struct GltfRounding {
  double camera_m = 0;
  double camera_rad = 0;
  double joint_m = 0;  ///< the same of any other node, which adds up along its branch
  double joint_rad = 0;
  double time_s = 0;  ///< of a time
};

struct GltfText {
  std::string bytes;
  GltfRounding rounding;
};

enum class GltfForm { text, binary };

/// Positions are interpolated on straight lines and rotations by slerp (LINEAR). Without a lens the camera
/// has the angle of view of 50 mm before 36 x 24 mm, since glTF has no camera without one. O(rows * nodes *
/// depth). Throws InputError where a file would have more than max_gltf_bytes.
GltfText write_gltf(const AnimatedScene& scene, GltfForm form);

}  // namespace inbetween
