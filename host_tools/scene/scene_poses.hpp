// Where a node of a scene is on every frame, on the stage of the rig.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/exchange/baked_table.hpp"
#include "host_tools/scene/scene_file.hpp"
#include "inbetween/joints/pose.hpp"

namespace inbetween {

/// How a scene stands on the stage: it is scaled about its origin, turned about up, and its origin put down.
struct ScenePlacement {
  double scale = 1;
  double turn_deg = 0;  ///< counterclockwise, seen from above
  Vector3 place = {};   ///< m
};

/// Looks at one node of a scene, on the stage: z up, in metres, as the tip of a rig that it shall move.
/// Refers to the scene.
class StagedNode {
 public:
  StagedNode(const SceneFile& scene, std::size_t node, const ScenePlacement& placement);

  /// A camera looks along its -z axis with y up, the tip along x with z up. Another node has its own axes,
  /// where its world has z up; where it has y up the tip's y is its -z, and the tip's z its y. A scale of the
  /// scene leaves the rotation as it is. Throws InputError where a scale is 0 or mirrors, or a place is
  /// beyond 1e6 m.
  [[nodiscard]] Pose at(double code) const;

 private:
  const SceneFile& scene_;
  std::size_t node_;
  ScenePlacement placement_;
};

/// Row k is at time code first + k step.
struct SceneRows {
  FrameRate fps;  ///< rows a second
  double first = 0;
  double step = 1;
  std::int64_t first_frame = 0;  ///< the number of the first row
  std::vector<Pose> poses = {};
  [[nodiscard]] double code(double row) const { return first + row * step; }
};

/// From the first time code of the file, or at which the node moves, to the first row at or after the last.
/// `fps` is asked where the file does not say the rate exactly: throws InputError, with the option. Also
/// where there would be fewer than two rows or more than a table may have.
SceneRows rows_of_node(const SceneFile& scene, std::size_t node, const ScenePlacement& placement,
                       const std::optional<FrameRate>& fps);

/// The columns tx ty tz in metres, and pan, tilt and roll in degrees: of a tip that is turned by pan about z
/// (counterclockwise from above), then up by tilt, then by roll about the direction in which it looks, the
/// top to the right. Angles go on beyond a turn. Rows are moments.
BakedTable table_of_poses(const SceneFile& scene, const SceneRows& rows);

}  // namespace inbetween
