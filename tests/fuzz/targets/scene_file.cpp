// Any bytes are a scene that keeps every promise of host_tools/scene/scene_file.hpp, or are refused in one
// line. The first byte says as what they are read.
#include "host_tools/scene/scene_file.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "host_tools/scene/gltf_reader.hpp"
#include "host_tools/scene/scene_bounds.hpp"
#include "host_tools/scene/scene_poses.hpp"
#include "host_tools/scene/usda_reader.hpp"
#include "tests/fuzz/targets/refusal.hpp"

namespace inbetween {
namespace {

const std::string any_file = "any.scene";

void require_op(const SceneOp& op) {
  const std::size_t width = width_of(op);
  const std::size_t keys = op.times.empty() ? 1 : op.times.size();
  fuzz_require(width > 0 && op.values.size() == keys * width * (op.curve == SceneCurve::cubic ? 3 : 1),
               "a value has its numbers");
  fuzz_require(has_directions(op), "a rotation turns somewhere");
  for (std::size_t i = 1; i < op.times.size(); ++i)
    fuzz_require(op.times[i - 1] < op.times[i], "times ascend");
  for (const double value : op.values)
    fuzz_require(std::fabs(value) <= max_scene_number, "a number is in its range");
}

/// A short motion: what is staged is a pose.
void require_poses(const SceneFile& scene) {
  const SceneRows rows = rows_of_node(scene, chosen_node(scene, std::nullopt), {}, FrameRate{1, 1});
  fuzz_require(rows.poses.size() >= 2, "a motion has rows");
  for (const Pose& pose : rows.poses) {
    const double off = rotation_angle(pose.rotation, pose.rotation);
    fuzz_require(std::fabs(dot(pose.rotation.x, pose.rotation.x) - 1) < 1e-9 && off < 1e-6,
                 "a rotation is one");
    fuzz_require(
        std::isfinite(pose.position.x) && std::isfinite(pose.position.y) && std::isfinite(pose.position.z),
        "a place is one");
  }
}

void require_scene(const SceneFile& scene) {
  fuzz_require(scene.nodes.size() <= max_scene_nodes, "nodes fit");
  fuzz_require(scene.metres_per_unit > 0 && scene.codes_per_second > 0, "units are above 0");
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    const FileNode& node = scene.nodes[i];
    fuzz_require(node.parent >= -1 && node.parent < static_cast<std::int32_t>(i),
                 "a node is behind its parent");
    fuzz_require(node.depth <= max_scene_depth + 1, "nodes hang no deeper than they may");
    for (const SceneOp& op : node.ops) require_op(op);
  }
  constexpr double longest = 1000;  // a fuzzer asks for no long ones
  const double length = scene.last.value_or(0) - scene.first.value_or(0);
  if (std::fabs(length) <= longest) require_poses(scene);
}

}  // namespace
}  // namespace inbetween

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  if (size == 0) return 0;
  const bool is_usd = bytes[0] % 2 == 1;
  return inbetween::fuzz_text(
      bytes + 1, size - 1, inbetween::any_file.c_str(), [&](std::string_view text, const char* file) {
        // It reads no file beside the scene.
        const auto none = [](const std::filesystem::path&, std::size_t) -> std::string {
          throw inbetween::InputError({inbetween::any_file}, "there is no file beside it; write one file");
        };
        inbetween::require_scene(is_usd ? inbetween::read_usda(text, file)
                                        : inbetween::read_gltf(text, file, none));
      });
}
