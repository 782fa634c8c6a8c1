#include "host_tools/scene/scene_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "host_tools/text/spelling.hpp"

namespace inbetween {
namespace {

constexpr std::size_t matrix_numbers = 16;

/// Of a cubic curve a value stands between the tangent that arrives and the one that leaves.
std::size_t stride_of(const SceneOp& op) {
  return width_of(op) * (op.curve == SceneCurve::cubic ? 3 : 1);
}

std::span<const double> value_of(const SceneOp& op, std::size_t key) {
  const std::size_t width = width_of(op);
  const std::size_t before = op.curve == SceneCurve::cubic ? width : 0;
  return std::span(op.values).subspan(key * stride_of(op) + before, width);
}

/// Hermite's form, with tangents per time code (glTF 2.0, appendix C.5).
double hermite(const SceneOp& op, std::size_t key, std::size_t i, double share) {
  const std::size_t width = width_of(op);
  const double* const a = op.values.data() + key * stride_of(op);
  const double* const b = a + stride_of(op);
  const double span = op.times[key + 1] - op.times[key];
  const double t = share, t2 = t * t, t3 = t2 * t;
  return (2 * t3 - 3 * t2 + 1) * a[width + i] + span * (t3 - 2 * t2 + t) * a[2 * width + i] +
         (3 * t2 - 2 * t3) * b[width + i] + span * (t3 - t2) * b[i];
}

std::vector<double> value_at(const SceneOp& op, double code) {
  const auto whole = [&](std::size_t key) {
    const auto value = value_of(op, key);
    return std::vector<double>(value.begin(), value.end());
  };
  if (op.times.empty() || code <= op.times.front()) return whole(0);
  if (code >= op.times.back()) return whole(op.times.size() - 1);
  const auto after = std::ranges::upper_bound(op.times, code);
  const auto key = static_cast<std::size_t>(after - op.times.begin()) - 1;
  const double share = (code - op.times[key]) / (op.times[key + 1] - op.times[key]);
  std::vector<double> value = whole(key);
  if (op.curve == SceneCurve::step || share == 0) return value;
  const std::span<const double> next = value_of(op, key + 1);
  if (op.kind == SceneOpKind::quaternion && op.curve == SceneCurve::linear) {
    const Quaternion q =
        slerp({value[0], value[1], value[2], value[3]}, {next[0], next[1], next[2], next[3]}, share);
    return {q.x, q.y, q.z, q.w};
  }
  for (std::size_t i = 0; i < value.size(); ++i) {
    value[i] =
        op.curve == SceneCurve::cubic ? hermite(op, key, i, share) : (1 - share) * value[i] + share * next[i];
  }
  return value;
}

Affine turned(const Rotation3& rotation) {
  return {rotation.x, rotation.y, rotation.z, {}};
}

Affine of_angles(const std::string& axes, const std::vector<double>& degrees) {
  Affine all;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const Vector3 axis = axes[i] == 'x'   ? Vector3{1, 0, 0}
                         : axes[i] == 'y' ? Vector3{0, 1, 0}
                                          : Vector3{0, 0, 1};
    const double angle = degrees[i] * std::numbers::pi / 180;
    all = turned(turned_about(axis, {std::sin(angle), std::cos(angle)})) * all;
  }
  return all;
}

Affine of_op(const SceneOp& op, double code) {
  const std::vector<double> v = value_at(op, code);
  switch (op.kind) {
    case SceneOpKind::translate:
      return {.origin = {v[0], v[1], v[2]}};
    case SceneOpKind::scale:
      return {{v[0], 0, 0}, {0, v[1], 0}, {0, 0, v[2]}, {}};
    case SceneOpKind::quaternion:
      return turned(rotation_of({v[0], v[1], v[2], v[3]}));
    case SceneOpKind::angles:
      return of_angles(op.axes, v);
    case SceneOpKind::matrix:
      break;
  }
  return {{v[0], v[1], v[2]}, {v[4], v[5], v[6]}, {v[8], v[9], v[10]}, {v[12], v[13], v[14]}};
}

/// By cofactors.
std::optional<Affine> inverse_of(const Affine& map) {
  const Vector3 a = cross(map.y, map.z), b = cross(map.z, map.x), c = cross(map.x, map.y);
  const double volume = dot(map.x, a);
  if (volume == 0 || !std::isfinite(1 / volume)) return std::nullopt;
  const double f = 1 / volume;
  Affine back{{a.x * f, b.x * f, c.x * f}, {a.y * f, b.y * f, c.y * f}, {a.z * f, b.z * f, c.z * f}, {}};
  back.origin = back * (map.origin * -1);
  return back;
}

bool moves(const FileNode& node) {
  return std::ranges::any_of(node.ops, [](const SceneOp& op) { return op.times.size() > 1; });
}

std::string listed(const SceneFile& scene, const std::vector<std::size_t>& nodes) {
  constexpr std::size_t max_named = 12;
  std::vector<std::string> names;
  for (const std::size_t node : nodes) {
    if (names.size() == max_named) {
      names.push_back(fmt::format("{} more", nodes.size() - max_named));
      break;
    }
    names.push_back(in_quotes(path_of(scene, node)));
  }
  return comma_separated(names);
}

std::vector<std::size_t> nodes_that(const SceneFile& scene, const auto& is_one) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < scene.nodes.size(); ++i)
    if (is_one(scene.nodes[i])) found.push_back(i);
  return found;
}

std::size_t named_node(const SceneFile& scene, const std::string& name) {
  auto found = nodes_that(scene, [&](const FileNode& node) { return node.name == name; });
  if (found.empty() && name.starts_with('/')) {
    for (std::size_t i = 0; i < scene.nodes.size(); ++i)
      if (name.ends_with(scene.nodes[i].name) && path_of(scene, i) == name) found.push_back(i);
  }
  if (found.size() == 1) return found.front();
  if (found.size() > 1) {
    throw InputError({scene.file}, fmt::format("several nodes are called {}; say which, by its path: {}",
                                               in_quotes(name), listed(scene, found)));
  }
  std::vector<std::string_view> names;
  for (const FileNode& node : scene.nodes) names.push_back(node.name);
  const auto meant = probably_meant(name, names);
  throw InputError({scene.file}, fmt::format("there is no node {}; {}", in_quotes(name),
                                             meant ? fmt::format("did you mean {}?", in_quotes(*meant))
                                                   : "name one that is there"));
}

}  // namespace

std::size_t width_of(const SceneOp& op) {
  switch (op.kind) {
    case SceneOpKind::translate:
    case SceneOpKind::scale:
      return 3;
    case SceneOpKind::quaternion:
      return 4;
    case SceneOpKind::angles:
      return op.axes.size();
    case SceneOpKind::matrix:
      break;
  }
  return matrix_numbers;
}

std::string path_of(const SceneFile& scene, std::size_t node) {
  std::string path;
  for (auto at = static_cast<std::int32_t>(node); at >= 0;
       at = scene.nodes[static_cast<std::size_t>(at)].parent) {
    path.insert(0, "/" + scene.nodes[static_cast<std::size_t>(at)].name);
  }
  return path;
}

bool has_directions(const SceneOp& op) {
  if (op.kind != SceneOpKind::quaternion) return true;
  constexpr double shortest = 1e-6;  // of a rounded quaternion of length 1 nothing is so short
  for (std::size_t key = 0; key < std::max<std::size_t>(op.times.size(), 1); ++key) {
    const std::span<const double> q = value_of(op, key);
    if (std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3])) < shortest) return false;
  }
  return true;
}

Affine operator*(const Affine& outer, const Affine& inner) {
  const auto linear = [&](const Vector3& v) { return outer.x * v.x + outer.y * v.y + outer.z * v.z; };
  return {linear(inner.x), linear(inner.y), linear(inner.z), outer * inner.origin};
}

Affine world_of(const SceneFile& scene, std::size_t node, double code) {
  Affine world;
  for (auto at = static_cast<std::int32_t>(node); at >= 0;) {
    const FileNode& link = scene.nodes[static_cast<std::size_t>(at)];
    Affine local;
    for (const SceneOp& op : link.ops) {
      const Affine map = of_op(op, code);
      const std::optional<Affine> used = op.is_inverse ? inverse_of(map) : map;
      if (!used) throw InputError(link.place, "this node undoes a scale of 0; remove what is scaled so");
      local = local * *used;
    }
    world = local * world;
    at = link.parent;
  }
  return world;
}

std::optional<std::array<double, 2>> moved_codes(const SceneFile& scene, std::size_t node) {
  std::optional<std::array<double, 2>> codes;
  for (auto at = static_cast<std::int32_t>(node); at >= 0;
       at = scene.nodes[static_cast<std::size_t>(at)].parent) {
    for (const SceneOp& op : scene.nodes[static_cast<std::size_t>(at)].ops) {
      if (op.times.empty()) continue;
      if (!codes) codes = {op.times.front(), op.times.back()};
      (*codes)[0] = std::min((*codes)[0], op.times.front());
      (*codes)[1] = std::max((*codes)[1], op.times.back());
    }
  }
  return codes;
}

std::size_t chosen_node(const SceneFile& scene, const std::optional<std::string>& named) {
  if (named) return named_node(scene, *named);
  const auto cameras = nodes_that(scene, [](const FileNode& node) { return node.is_camera; });
  if (cameras.size() == 1) return cameras.front();
  if (cameras.size() > 1) {
    throw InputError({scene.file}, fmt::format("the scene has several cameras; say which with --node: {}",
                                               listed(scene, cameras)));
  }
  const auto moved = nodes_that(scene, moves);
  if (moved.size() == 1) return moved.front();
  if (moved.empty())
    throw InputError({scene.file}, "the scene has no camera, and nothing in it moves; name another file");
  throw InputError({scene.file}, fmt::format("the scene has no camera; say with --node what is taken: {}",
                                             listed(scene, moved)));
}

}  // namespace inbetween
