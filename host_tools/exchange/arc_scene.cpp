#include "host_tools/exchange/arc_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "host_tools/exchange/table_text.hpp"
#include "host_tools/joints/xml_element.hpp"
#include "host_tools/text/toml_value.hpp"

namespace inbetween {
namespace {

/// The units that are written in such files.
constexpr std::array<MoveUnit, 5> arc_units = {MoveUnit::m, MoveUnit::cm, MoveUnit::mm, MoveUnit::inch,
                                               MoveUnit::deg};

std::optional<MoveUnit> arc_unit(const ArcAxis& axis) {
  const std::string* const word = axis.attribute("units");
  if (word == nullptr) return std::nullopt;
  for (const MoveUnit unit : arc_units) {
    if (to_string(unit) == *word) return unit;
  }
  throw InputError(axis.place, fmt::format("units is {}; write m, cm, mm, in or deg", in_quotes(*word)));
}

std::vector<ArcAttribute> attributes_of(const XmlElement& element) {
  std::vector<ArcAttribute> attributes;
  for (const XmlAttribute& attribute : element.attributes())
    attributes.push_back({attribute.name, attribute.value});
  return attributes;
}

/// Of the root, which declares it.
std::string arc_prefix(const XmlElement& root) {
  for (const XmlAttribute& attribute : root.attributes()) {
    if (attribute.value != arc_namespace) continue;
    constexpr std::string_view declares = "xmlns:";
    if (attribute.name == "xmlns") return "";
    if (attribute.name.starts_with(declares)) return attribute.name.substr(declares.size()) + ":";
  }
  root.refuse(
      fmt::format("is not of the namespace {}; name a scene of Dragonframe's Arc workspace", arc_namespace));
}

ArcPoint arc_point(const XmlElement& element) {
  ArcPoint point{.frame = element.number("x", std::nullopt, static_cast<double>(max_table_frame)),
                 .value = element.number("y", std::nullopt, max_magnitude)};
  if (element.has("type")) point.type = element.text("type", "type=\"5\"");
  return point;
}

void check_curve(const ArcAxis& axis) {
  const std::size_t needed = axis.points.empty() ? 0 : 2 * axis.points.size() - 2;
  if (axis.controls.size() != needed) {
    throw InputError(axis.place,
                     fmt::format("axis {} has {} and {}; there are two control points between any two points",
                                 in_quotes(axis.name), counted(std::ssize(axis.points), "point"),
                                 counted(std::ssize(axis.controls), "control point")));
  }
}

ArcAxis read_arc_axis(const XmlElement& element, const ArcScene& scene, std::string_view text) {
  ArcAxis axis{.name = fmt::format("axis {}", scene.axes.size() + 1)};
  axis.place = element.place();
  axis.attributes = attributes_of(element);
  if (element.has("name")) axis.name = element.text("name", "name=\"PAN\"");
  axis.unit = arc_unit(axis);
  for (const XmlElement& child : element.children()) {
    if (child.name() == scene.prefix + "points") {
      ArcPoint point = arc_point(child);
      if (!axis.points.empty() && !(point.frame > axis.points.back().frame)) {
        child.refuse(fmt::format("is at frame {}, and the point before it at {}; sort them, each frame once",
                                 point.frame, axis.points.back().frame));
      }
      axis.points.push_back(std::move(point));
    } else if (child.name() == scene.prefix + "controlPoints") {
      axis.controls.push_back(arc_point(child));
    } else {
      axis.others.emplace_back(child.written_in(text));
    }
  }
  check_curve(axis);
  return axis;
}

/// A value as an attribute has it, between quotes.
std::string arc_escaped(std::string_view value) {
  std::string text;
  for (const char c : value) {
    switch (c) {
      case '&':
        text += "&amp;";
        break;
      case '<':
        text += "&lt;";
        break;
      case '"':
        text += "&quot;";
        break;
      case '\n':
      case '\r':
      case '\t':
        text += fmt::format("&#{};", static_cast<int>(c));
        break;
      default:
        text += c;
    }
  }
  return text;
}

std::string attributes_text(const std::vector<ArcAttribute>& attributes) {
  std::string text;
  for (const ArcAttribute& attribute : attributes) {
    text += fmt::format(" {}=\"{}\"", attribute.name, arc_escaped(attribute.value));
  }
  return text;
}

std::string point_text(const ArcPoint& point, const std::string& name, std::int32_t decimals) {
  // Frames are mostly whole; a control point is a third of a frame behind one.
  const bool is_whole = point.frame == std::floor(point.frame);
  return fmt::format("    <{} x=\"{}\" y=\"{}\"{}/>\n", name,
                     fixed_number(point.frame, is_whole ? 0 : decimals), fixed_number(point.value, decimals),
                     point.type.empty() ? "" : fmt::format(" type=\"{}\"", arc_escaped(point.type)));
}

struct BezierEnds {
  double begin = 0, behind = 0, before = 0, end = 0;
};
double bezier(const BezierEnds& ends, double u) {
  const double v = 1 - u;
  return v * v * v * ends.begin + 3 * u * v * (v * ends.behind + u * ends.before) + u * u * u * ends.end;
}

}  // namespace

const std::string* ArcAxis::attribute(std::string_view wanted) const {
  const auto found = std::ranges::find(attributes, wanted, &ArcAttribute::name);
  return found == attributes.end() ? nullptr : &found->value;
}

std::optional<double> ArcAxis::number(std::string_view wanted) const {
  const std::string* const text = attribute(wanted);
  if (text == nullptr) return std::nullopt;
  return table_number(*text, place);
}

bool ArcScene::has_motion() const {
  return std::ranges::any_of(axes, [](const ArcAxis& axis) { return !axis.points.empty(); });
}

ArcScene read_arc_scene(std::string_view text, const std::string& file) {
  if (text.size() > max_arc_bytes) {
    throw InputError({file}, fmt::format("the file has {} bytes; Dragonframe writes none above {}",
                                         text.size(), max_arc_bytes));
  }
  const XmlDocument document(text, file);
  const XmlElement root = document.root();
  ArcScene scene{.file = file};
  scene.prefix = arc_prefix(root);
  if (root.name() != scene.prefix + "scene") {
    root.refuse("is no scene; name a file that Dragonframe's Arc workspace has written");
  }
  scene.attributes = attributes_of(root);
  for (const XmlElement& child : root.children()) {
    if (child.name() == scene.prefix + "axis") {
      scene.axes.push_back(read_arc_axis(child, scene, text));
      if (scene.axes.size() > max_table_columns) {
        child.refuse(fmt::format("is one too many; a scene has at most {} axes", max_table_columns));
      }
    } else {
      scene.others.emplace_back(child.written_in(text));
    }
  }
  return scene;
}

std::string write_arc_scene(const ArcScene& scene, std::int32_t decimals) {
  std::string text = fmt::format("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<{}scene{}>\n", scene.prefix,
                                 attributes_text(scene.attributes));
  for (const ArcAxis& axis : scene.axes) {
    text += fmt::format("  <{}axis{}", scene.prefix, attributes_text(axis.attributes));
    if (axis.points.empty() && axis.others.empty()) {
      text += "/>\n";
      continue;
    }
    text += ">\n";
    for (const ArcPoint& point : axis.points) text += point_text(point, scene.prefix + "points", decimals);
    for (const ArcPoint& point : axis.controls)
      text += point_text(point, scene.prefix + "controlPoints", decimals);
    for (const std::string& other : axis.others) text += "    " + other + "\n";
    text += fmt::format("  </{}axis>\n", scene.prefix);
  }
  for (const std::string& other : scene.others) text += "  " + other + "\n";
  return text + fmt::format("</{}scene>\n", scene.prefix);
}

double arc_value(const ArcAxis& axis, double frame) {
  const auto& points = axis.points;
  const auto behind = std::ranges::upper_bound(points, frame, {}, &ArcPoint::frame);
  if (behind == points.begin()) return points.front().value;
  if (behind == points.end()) return points.back().value;
  const auto segment = static_cast<std::size_t>(behind - points.begin()) - 1;
  const ArcPoint& begin = points[segment];
  const ArcPoint& end = points[segment + 1];
  if (frame == begin.frame) return begin.value;
  const ArcPoint& first = axis.controls[2 * segment];
  const ArcPoint& second = axis.controls[2 * segment + 1];
  const BezierEnds frames{begin.frame, std::clamp(first.frame, begin.frame, end.frame),
                          std::clamp(second.frame, begin.frame, end.frame), end.frame};
  double low = 0;
  double high = 1;
  // Monotone, so that halving ends beside the one place; 64 times reach the last bit of any u.
  for (int i = 0; i < 64 && low < high; ++i) {
    const double middle = 0.5 * (low + high);
    if (middle == low || middle == high) break;
    (bezier(frames, middle) < frame ? low : high) = middle;
  }
  return bezier({begin.value, first.value, second.value, end.value}, high);
}

}  // namespace inbetween
