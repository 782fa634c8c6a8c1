// A scene of another program as it stands in its file: nodes that hang on each other, each by a row of
// transformations that may move.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/exchange/baked_table.hpp"
#include "host_tools/scene/quaternion.hpp"
#include "host_tools/text/diagnostics.hpp"

namespace inbetween {

/// One transformation of a node in its parent. How many numbers a value has: a translation or a scale 3, a
/// quaternion (x, y, z, w) 4, angles (deg) as many as axes, a matrix 16, column after column.
enum class SceneOpKind : std::uint8_t { translate, scale, quaternion, angles, matrix };
enum class SceneCurve : std::uint8_t { linear, step, cubic };

struct SceneOp {
  SceneOpKind kind = SceneOpKind::translate;
  std::string axes = {};  ///< of angles: "xyz" turns about x, then the fixed y, then z
  bool is_inverse = false;
  SceneCurve curve = SceneCurve::linear;  ///< cubic (Hermite): a value has its two tangents around it
  std::vector<double> times = {};  ///< ascending, in SceneFile::codes_per_second; empty: it does not move
  std::vector<double> values = {};
};
/// Numbers of one value of it, tangents not counted.
std::size_t width_of(const SceneOp& op);

struct FileNode {
  std::string name;
  std::int32_t parent = -1;  ///< an earlier node
  std::size_t depth = 0;     ///< below a node that hangs on none
  bool is_camera = false;
  std::vector<SceneOp> ops = {};  ///< the outermost first
  Place place = {};
};

struct SceneFile {
  std::string file;
  double metres_per_unit = 1;
  UpAxis up = UpAxis::y;
  double codes_per_second = 1;                   ///< in what times count
  bool has_frames = false;                       ///< a time code is a frame
  std::optional<FrameRate> fps = {};             ///< exactly, where the file says it
  std::optional<double> first = {}, last = {};   ///< the time codes of the whole, where the file says them
  std::optional<std::int64_t> first_frame = {};  ///< the number of the first row, where codes are no frames
  std::vector<FileNode> nodes = {};
  std::vector<Warning> warnings = {};
};

/// "/set/crane/camera".
std::string path_of(const SceneFile& scene, std::size_t node);

/// Whether each of its values is one, of quaternions that have a direction.
bool has_directions(const SceneOp& op);

/// A linear map and a place: its columns, and where its origin is.
struct Affine {
  Vector3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  Vector3 origin;

  friend Vector3 operator*(const Affine& map, const Vector3& v) {
    return map.x * v.x + map.y * v.y + map.z * v.z + map.origin;
  }
  friend Affine operator*(const Affine& outer, const Affine& inner);
};

/// The node in the world of its file, at a time code; before its first time a curve has its first value, and
/// behind its last the last. Throws InputError where an inverse has none. O(depth * log times).
Affine world_of(const SceneFile& scene, std::size_t node, double code);

/// The time codes at which the node or one above it moves; nothing where none does.
std::optional<std::array<double, 2>> moved_codes(const SceneFile& scene, std::size_t node);

/// The node that is meant: by its name or path, or else the only camera, or the only node that moves by
/// itself. Throws InputError, which lists those that may be meant.
std::size_t chosen_node(const SceneFile& scene, const std::optional<std::string>& named);

}  // namespace inbetween
