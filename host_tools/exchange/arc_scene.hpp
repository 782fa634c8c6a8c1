// Scenes of Dragonframe's Arc workspace: the set-up of axes (.arcx), and their curves as well (.arcm).
//
// Sources: what BlenderMoco and a writer for eMotimo make, and a scene that Dragonframe saved (DFMoco2UR,
// XYZRXRYRZ.arcx); no schema is public. A curve is a row of cubic Bezier segments: all its points, then two
// control points for each segment, in frames and in the unit of the axis. Elements are known by their
// namespace, whatever its prefix is.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/exchange/baked_table.hpp"

namespace inbetween {

inline constexpr std::string_view arc_namespace = "http://caliri.com/motion/scene";
inline constexpr std::size_t max_arc_bytes = std::size_t{8} << 20U;  // a document of XML is held in memory

struct ArcAttribute {
  std::string name, value;
};

struct ArcPoint {
  double frame = 0;
  double value = 0;
  std::string type = {};  // "5" on points of eMotimo's writer; what it means is not known
};

struct ArcAxis {
  std::string name;  // "axis 3" where it has none
  std::optional<MoveUnit> unit = {};
  std::vector<ArcAttribute> attributes = {};  // all, in the order of the file
  std::vector<ArcPoint> points = {};          // frames ascend
  std::vector<ArcPoint> controls = {};        // two for each segment: behind its first point, before its last
  std::vector<std::string> others = {};       // elements that mean nothing here, as they are written
  Place place = {};

  [[nodiscard]] const std::string* attribute(std::string_view wanted) const;
  /// Throws InputError at the axis where it is there and no number.
  [[nodiscard]] std::optional<double> number(std::string_view wanted) const;
};

struct ArcScene {
  std::string file;
  std::string prefix = "scen:";  // of the namespace, with its colon
  std::vector<ArcAttribute> attributes = {};
  std::vector<ArcAxis> axes = {};
  std::vector<std::string> others = {};  // as they are written

  [[nodiscard]] bool has_motion() const;
};

/// Only direct children of the root are axes: `virtualConfiguration` has elements of the same name. Throws
/// InputError at the line where it is no such XML, where a curve has not two control points a segment, where
/// points do not ascend, or where a unit is none of m, cm, mm, in, deg. O(bytes).
ArcScene read_arc_scene(std::string_view text, const std::string& file);

/// What was read comes back: attributes and elements that mean nothing here, too. Numbers are written with
/// `decimals` decimals.
std::string write_arc_scene(const ArcScene& scene, std::int32_t decimals = 6);

/// The value of a curve at a frame; before its first point and behind its last it holds (inferred). Control
/// points are held between the points of their segment, so that frames ascend. Found to a last bit or so in
/// 64 halvings at most. The axis has a point.
double arc_value(const ArcAxis& axis, double frame);

}  // namespace inbetween
