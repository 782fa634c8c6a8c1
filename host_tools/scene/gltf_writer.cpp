#include "host_tools/scene/gltf_writer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "host_tools/exchange/baked_table.hpp"
#include "host_tools/joints/vector_length.hpp"
#include "host_tools/scene/base64.hpp"
#include "host_tools/scene/scene_bounds.hpp"

namespace inbetween {
namespace {

using Json = nlohmann::ordered_json;

/// The scene has z up, and glTF y.
constexpr Rotation3 scene_in_gltf{{1, 0, 0}, {0, 0, -1}, {0, 1, 0}};
constexpr int float_type = 5126;

double rounded(double number) {
  return static_cast<double>(static_cast<float>(number));
}
Vector3 rounded(const Vector3& v) {
  return {rounded(v.x), rounded(v.y), rounded(v.z)};
}
Quaternion rounded(const Quaternion& q) {
  return {rounded(q.x), rounded(q.y), rounded(q.z), rounded(q.w)};
}

/// As a reader has it.
Pose rounded(const Pose& pose) {
  return {rotation_of(rounded(quaternion_of(pose.rotation))), rounded(pose.position)};
}
Pose rounded_local(const SceneNode& node, std::size_t row) {
  Pose pose = rounded(node.rest);
  if (!node.positions.empty()) pose.position = rounded(node.positions[row]);
  if (!node.turns.empty()) pose.rotation = rotation_of(rounded(node.turns[row]));
  return pose;
}

Pose inverse_of(const Pose& pose) {
  const Rotation3 back = inverse(pose.rotation);
  return {back, back * (pose.position * -1)};
}

void raise_by(const Pose& read, const Pose& exact, double& m, double& rad) {
  m = std::max(m, length(read.position - exact.position));
  rad = std::max(rad, rotation_angle(read.rotation, exact.rotation));
}

/// Moves the node of the camera so that rounding its parents does not move it, and tells what remains.
GltfRounding take_up_rounding(AnimatedScene& scene) {
  GltfRounding rounding;
  const auto last = static_cast<std::size_t>(scene.camera.node);
  std::vector<Pose> exact(scene.nodes.size()), read(scene.nodes.size());
  SceneNode& camera = scene.nodes[last];
  SceneNode moved = camera;
  moved.positions.clear();
  moved.turns.clear();
  for (std::size_t row = 0; row < scene.rows; ++row) {
    for (std::size_t i = 0; i < last; ++i) {
      const SceneNode& node = scene.nodes[i];
      const auto parent = static_cast<std::size_t>(std::max(node.parent, 0));
      exact[i] = node.parent < 0 ? local_pose(node, row) : exact[parent] * local_pose(node, row);
      read[i] = node.parent < 0 ? rounded_local(node, row) : read[parent] * rounded_local(node, row);
      raise_by(read[i], exact[i], rounding.joint_m, rounding.joint_rad);
    }
    const auto parent = static_cast<std::size_t>(camera.parent);
    const Pose wanted = exact[parent] * local_pose(camera, row);
    const Pose local = inverse_of(read[parent]) * wanted;
    const Quaternion turn = quaternion_of(local.rotation);
    moved.turns.push_back(moved.turns.empty() ? turn : nearer_sign(turn, moved.turns.back()));
    moved.positions.push_back(local.position);
    raise_by(read[parent] * rounded_local(moved, row), wanted, rounding.camera_m, rounding.camera_rad);
  }
  camera = std::move(moved);
  return rounding;
}

/// Fills the buffer, and the lists of JSON that say what lies where in it.
class Buffer {
 public:
  explicit Buffer(Json& document) : views_(document["bufferViews"]), accessors_(document["accessors"]) {
    views_ = Json::array();
    accessors_ = Json::array();
  }
  /// Returns the index of its accessor.
  std::size_t add(const std::vector<float>& numbers, const char* type, std::size_t count) {
    const std::size_t bytes = numbers.size() * sizeof(float);
    views_.push_back({{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", bytes}});
    accessors_.push_back(
        {{"bufferView", views_.size() - 1}, {"componentType", float_type}, {"count", count}, {"type", type}});
    // glTF is little-endian, and so is every processor that this program is built for.
    const std::size_t begin = bytes_.size();
    bytes_.resize(begin + bytes);
    std::memcpy(bytes_.data() + begin, numbers.data(), bytes);
    return accessors_.size() - 1;
  }
  Json& accessor(std::size_t index) { return accessors_[index]; }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  Json& views_;
  Json& accessors_;
  std::string bytes_;
};

std::size_t add_times(Buffer& buffer, const AnimatedScene& scene, GltfRounding& rounding) {
  std::vector<float> times;
  for (std::size_t row = 0; row < scene.rows; ++row) {
    const double time = static_cast<double>(row) * scene.fps.denominator / scene.fps.numerator;
    times.push_back(static_cast<float>(time));
    rounding.time_s = std::max(rounding.time_s, std::fabs(static_cast<double>(times.back()) - time));
  }
  const std::size_t index = buffer.add(times, "SCALAR", times.size());
  buffer.accessor(index)["min"] = {times.front()};
  buffer.accessor(index)["max"] = {times.back()};
  return index;
}

Json three(const Vector3& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}
Json four(const Quaternion& q) {
  return {static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z), static_cast<float>(q.w)};
}

Json node_json(const SceneNode& node) {
  Json json = {{"name", node.name}};
  json["translation"] = three(node.positions.empty() ? node.rest.position : node.positions.front());
  json["rotation"] = four(node.turns.empty() ? quaternion_of(node.rest.rotation) : node.turns.front());
  return json;
}

/// Node 0 turns z up into y up, and node i + 1 is node i of the scene.
Json nodes_json(const AnimatedScene& scene) {
  Json nodes = Json::array();
  nodes.push_back({{"name", "z up"}, {"rotation", four(quaternion_of(scene_in_gltf))}});
  std::vector<std::vector<std::size_t>> children(scene.nodes.size() + 1);
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    nodes.push_back(node_json(scene.nodes[i]));
    children[static_cast<std::size_t>(scene.nodes[i].parent) + 1].push_back(i + 1);
  }
  for (std::size_t i = 0; i < children.size(); ++i) {
    if (!children[i].empty()) nodes[i]["children"] = children[i];
  }
  nodes[static_cast<std::size_t>(scene.camera.node) + 1]["camera"] = 0;
  return nodes;
}

Json camera_json(const AnimatedScene& scene) {
  const SceneLens lens = scene.camera.lens.value_or(usual_lens);
  constexpr double nearest_m = 0.01;  // no lens of a rig is nearer to what it films
  Json camera = {{"type", "perspective"},
                 {"perspective",
                  {{"yfov", 2 * std::atan(lens.sensor_mm[1] / (2 * lens.focal_length_mm))},
                   {"aspectRatio", lens.sensor_mm[0] / lens.sensor_mm[1]},
                   {"znear", nearest_m}}}};
  if (scene.camera.lens) {
    camera["extras"]["inbetween"] = {
        {"focal_length_mm", lens.focal_length_mm}, {"sensor_mm", lens.sensor_mm}, {"focus_m", lens.focus_m}};
  }
  return camera;
}

/// A channel of a node for each list of samples that it has.
Json animation_json(const AnimatedScene& scene, Buffer& buffer, GltfRounding& rounding) {
  Json samplers = Json::array(), channels = Json::array();
  const std::size_t times = add_times(buffer, scene, rounding);
  const auto add = [&](std::size_t node, const char* path, const std::vector<float>& numbers,
                       const char* type) {
    const std::size_t output = buffer.add(numbers, type, scene.rows);
    samplers.push_back({{"input", times}, {"output", output}, {"interpolation", "LINEAR"}});
    channels.push_back({{"sampler", samplers.size() - 1}, {"target", {{"node", node + 1}, {"path", path}}}});
  };
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    const SceneNode& node = scene.nodes[i];
    std::vector<float> numbers;
    for (const Vector3& v : node.positions)
      for (const double number : {v.x, v.y, v.z}) numbers.push_back(static_cast<float>(number));
    if (!numbers.empty()) add(i, "translation", numbers, "VEC3");
    numbers.clear();
    for (const Quaternion& q : node.turns)
      for (const double number : {q.x, q.y, q.z, q.w}) numbers.push_back(static_cast<float>(number));
    if (!numbers.empty()) add(i, "rotation", numbers, "VEC4");
  }
  return {{"name", scene.name}, {"samplers", std::move(samplers)}, {"channels", std::move(channels)}};
}

void put_u32(std::string& bytes, std::size_t number) {
  for (int shift = 0; shift < 32; shift += 8)
    bytes += static_cast<char>((number >> static_cast<unsigned>(shift)) & 0xffU);
}

/// A header, and two chunks of whole words: JSON filled up with blanks, and the numbers.
std::string binary_file(std::string json, const std::string& numbers) {
  constexpr std::size_t word = 4, header = 12, chunk_header = 8;
  json.resize((json.size() + word - 1) / word * word, ' ');
  std::string bytes = "glTF";
  put_u32(bytes, 2);
  put_u32(bytes, header + 2 * chunk_header + json.size() + numbers.size());
  put_u32(bytes, json.size());
  bytes += "JSON" + json;
  put_u32(bytes, numbers.size());
  bytes += std::string("BIN\0", word) + numbers;
  return bytes;
}

}  // namespace

GltfText write_gltf(const AnimatedScene& scene, GltfForm form) {
  AnimatedScene moved = scene;
  GltfText result;
  result.rounding = take_up_rounding(moved);
  Json document = {{"asset",
                    {{"version", "2.0"},
                     {"generator", "inbetween"},
                     {"extras",
                      {{"inbetween",
                        {{"frames_per_second", to_string(scene.fps)},
                         {"first_frame", scene.first_frame},
                         {"between_frames_m", scene.between.place_m},
                         {"between_frames_rad", scene.between.turn_rad}}}}}}},
                   {"scene", 0},
                   {"scenes", {{{"name", scene.name}, {"nodes", {0}}}}},
                   {"nodes", nodes_json(moved)},
                   {"cameras", {camera_json(scene)}}};
  Buffer buffer(document);
  Json animation = animation_json(moved, buffer, result.rounding);
  document["animations"] = Json::array({std::move(animation)});
  Json whole = {{"byteLength", buffer.bytes().size()}};
  if (form == GltfForm::text)
    whole["uri"] = "data:application/octet-stream;base64," + base64_of(buffer.bytes());
  document["buffers"] = Json::array({std::move(whole)});
  // A name may be no UTF-8; what is none becomes the sign for it.
  const std::string json =
      document.dump(form == GltfForm::text ? 1 : -1, ' ', false, Json::error_handler_t::replace);
  result.bytes = form == GltfForm::text ? json + "\n" : binary_file(json, buffer.bytes());
  if (result.bytes.size() > max_gltf_bytes) {
    throw InputError({scene.name},
                     fmt::format("the file would have more than {} MiB; write a part of the move, "
                                 "or fewer rows a second",
                                 max_gltf_bytes >> 20U));
  }
  return result;
}

}  // namespace inbetween
