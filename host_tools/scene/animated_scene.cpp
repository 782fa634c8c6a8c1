#include "host_tools/scene/animated_scene.hpp"

namespace inbetween {

Pose local_pose(const SceneNode& node, std::size_t row) {
  Pose pose = node.rest;
  if (!node.positions.empty()) pose.position = node.positions[row];
  if (!node.turns.empty()) pose.rotation = rotation_of(node.turns[row]);
  return pose;
}

Pose world_pose(const AnimatedScene& scene, std::int32_t node, std::size_t row) {
  Pose pose;
  for (std::int32_t at = node; at >= 0; at = scene.nodes[static_cast<std::size_t>(at)].parent)
    pose = local_pose(scene.nodes[static_cast<std::size_t>(at)], row) * pose;
  return pose;
}

}  // namespace inbetween
