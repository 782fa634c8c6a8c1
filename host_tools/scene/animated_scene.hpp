// A rig that moves, as other programs see one: nodes that hang on each other, and where each is on every row.
//
// Lengths are metres, z is up, and the world is the root link of the rig. A camera looks along the -z axis of
// its node, with y up in the picture, as those of glTF and USD do.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/scene/quaternion.hpp"
#include "inbetween/joints/pose.hpp"
#include "inbetween/timing/frame_time.hpp"

namespace inbetween {

struct SceneNode {
  std::string name;
  std::int32_t parent = -1;             ///< an earlier node; -1 is the world
  Pose rest = {};                       ///< in its parent; what has no samples stays so
  std::vector<Vector3> positions = {};  ///< on each row, or none
  std::vector<Quaternion> turns =
      {};  ///< on each row, or none; of length 1, neighbours the shorter way round
};

/// A pinhole.
struct SceneLens {
  double focal_length_mm = 0;
  std::array<double, 2> sensor_mm = {};  ///< width and height
  double focus_m = 0;
};

/// What stands in where a rig has none and a lens is needed: 50 mm before 36 x 24 mm.
inline constexpr SceneLens usual_lens{.focal_length_mm = 50, .sensor_mm = {36, 24}, .focus_m = 0};

struct SceneCamera {
  std::int32_t node = 0;  ///< the last one
  std::optional<SceneLens> lens = {};
};

/// How far the camera may be between two rows from where the rig takes it, where a program interpolates
/// positions on straight lines and rotations by slerp: proven bounds.
struct BetweenRows {
  double place_m = 0;
  double turn_rad = 0;
};

struct AnimatedScene {
  std::string name;
  FrameRate fps;                 ///< rows a second
  std::int64_t first_frame = 0;  ///< the number of the first row
  std::size_t rows = 0;
  std::vector<SceneNode> nodes = {};
  SceneCamera camera = {};
  BetweenRows between = {};
};

/// In its parent.
Pose local_pose(const SceneNode& node, std::size_t row);
/// In the world. O(depth).
Pose world_pose(const AnimatedScene& scene, std::int32_t node, std::size_t row);

}  // namespace inbetween
