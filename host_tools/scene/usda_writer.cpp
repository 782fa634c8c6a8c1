#include "host_tools/scene/usda_writer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <set>
#include <string_view>
#include <vector>

#include "host_tools/scene/scene_bounds.hpp"

namespace inbetween {
namespace {

constexpr Rotation3 z_up_in_y_up{{1, 0, 0}, {0, 0, -1}, {0, 1, 0}};

std::string in_usda_quotes(std::string_view text) {
  std::string quoted = "\"";
  for (const char letter : text) {
    const auto code = static_cast<unsigned char>(letter);
    if (letter == '"' || letter == '\\') {
      quoted += '\\';
      quoted += letter;
    } else if (code < 0x20 || code == 0x7f) {
      quoted += fmt::format("\\x{:02x}", code);
    } else {
      quoted += letter;
    }
  }
  return quoted + '"';
}

/// A letter or _, then letters, digits and _, as prims are called; none of `taken`, which takes it.
std::string identifier_of(std::string_view name, std::set<std::string>& taken) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  std::string word;
  for (const char c : name) word += is_letter(c) || is_digit(c) ? c : '_';
  if (word.empty() || is_digit(word.front())) word.insert(word.begin(), '_');
  std::string chosen = word;
  for (int count = 2; taken.contains(chosen); ++count) chosen = fmt::format("{}_{}", word, count);
  taken.insert(chosen);
  return chosen;
}

std::string text_of(const Vector3& v) {
  return fmt::format("({}, {}, {})", v.x, v.y, v.z);
}
/// The real part first.
std::string text_of(const Quaternion& q) {
  return fmt::format("({}, {}, {}, {})", q.w, q.x, q.y, q.z);
}

class UsdaText {
 public:
  UsdaText(const AnimatedScene& scene, const UsdaChoices& choices) : scene_(scene), choices_(choices) {
    children_.resize(scene.nodes.size() + 1);
    for (std::size_t i = 0; i < scene.nodes.size(); ++i)
      children_[static_cast<std::size_t>(scene.nodes[i].parent) + 1].push_back(i);
  }

  std::string text() {
    std::set<std::string> names;
    root_ = identifier_of(scene_.name, names);
    head();
    open("Xform", root_, scene_.name);
    if (choices_.up == UpAxis::y) {
      line("quatd xformOp:orient = " + text_of(quaternion_of(z_up_in_y_up)));
      line("uniform token[] xformOpOrder = [\"xformOp:orient\"]");
    }
    write_children(0);
    close();
    return std::move(text_);
  }

 private:
  void line(std::string_view words) {
    text_.append(2 * depth_, ' ');
    text_ += words;
    text_ += '\n';
    if (text_.size() <= max_usda_bytes) return;
    throw InputError({scene_.name},
                     fmt::format("the file would have more than {} MiB; write a part of the move, "
                                 "or fewer rows a second",
                                 max_usda_bytes >> 20U));
  }

  void head() {
    const auto last = scene_.first_frame + static_cast<std::int64_t>(scene_.rows) - 1;
    text_ = "#usda 1.0\n(\n";
    ++depth_;
    line("customLayerData = {");
    line("  dictionary inbetween = {");
    line(fmt::format("    double between_frames_m = {}", scene_.between.place_m));
    line(fmt::format("    double between_frames_rad = {}", scene_.between.turn_rad));
    line(fmt::format("    string frames_per_second = \"{}\"", to_string(scene_.fps)));
    line("  }");
    line("}");
    line(fmt::format("defaultPrim = \"{}\"", root_));
    line(fmt::format("endTimeCode = {}", last));
    line(fmt::format("framesPerSecond = {}", scene_.fps.frames_per_second()));
    line(fmt::format("metersPerUnit = {}", choices_.metres_per_unit));
    line(fmt::format("startTimeCode = {}", scene_.first_frame));
    line(fmt::format("timeCodesPerSecond = {}", scene_.fps.frames_per_second()));
    line(fmt::format("upAxis = \"{}\"", choices_.up == UpAxis::y ? 'Y' : 'Z'));
    --depth_;
    text_ += ")\n\n";
  }

  void open(std::string_view type, const std::string& identifier, const std::string& name) {
    if (depth_ > max_scene_depth) {
      throw InputError({scene_.name}, fmt::format("its links hang deeper than {} on each other; write glTF",
                                                  max_scene_depth));
    }
    line(fmt::format("def {} \"{}\"", type, identifier));
    line("{");
    ++depth_;
    if (identifier != name) line("custom string inbetween:name = " + in_usda_quotes(name));
  }
  void close() {
    --depth_;
    line("}");
  }

  void write_children(std::size_t of) {
    std::set<std::string> names;
    for (const std::size_t child : children_[of]) write_node(child, names);
  }

  [[nodiscard]] Vector3 in_units(const Vector3& metres) const {
    const double m = choices_.metres_per_unit;
    return {metres.x / m, metres.y / m, metres.z / m};
  }

  void write_node(std::size_t index, std::set<std::string>& names) {
    const SceneNode& node = scene_.nodes[index];
    const bool is_camera = static_cast<std::int32_t>(index) == scene_.camera.node;
    open(is_camera ? "Camera" : "Xform", identifier_of(node.name, names), node.name);
    if (is_camera && scene_.camera.lens) write_lens(*scene_.camera.lens);
    if (node.positions.empty()) {
      line("double3 xformOp:translate = " + text_of(in_units(node.rest.position)));
    } else {
      write_samples("double3 xformOp:translate", node.positions.size(),
                    [&](std::size_t row) { return text_of(in_units(node.positions[row])); });
    }
    if (node.turns.empty()) {
      line("quatd xformOp:orient = " + text_of(quaternion_of(node.rest.rotation)));
    } else {
      write_samples("quatd xformOp:orient", node.turns.size(),
                    [&](std::size_t row) { return text_of(node.turns[row]); });
    }
    line("uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:orient\"]");
    write_children(index + 1);
    close();
  }

  template <class TextOfRow>
  void write_samples(std::string_view property, std::size_t rows, const TextOfRow& text_of_row) {
    line(fmt::format("{}.timeSamples = {{", property));
    for (std::size_t row = 0; row < rows; ++row) {
      line(fmt::format("  {}: {},", scene_.first_frame + static_cast<std::int64_t>(row), text_of_row(row)));
    }
    line("}");
  }

  void write_lens(const SceneLens& lens) {
    // Tenths of a unit of the scene, of millimetres.
    const double tenths = 1e-2 / choices_.metres_per_unit;
    line(fmt::format("float focalLength = {}", lens.focal_length_mm * tenths));
    line(fmt::format("float focusDistance = {}", lens.focus_m / choices_.metres_per_unit));
    line(fmt::format("float horizontalAperture = {}", lens.sensor_mm[0] * tenths));
    line(fmt::format("float verticalAperture = {}", lens.sensor_mm[1] * tenths));
    line("token projection = \"perspective\"");
  }

  const AnimatedScene& scene_;
  const UsdaChoices& choices_;
  std::vector<std::vector<std::size_t>> children_;
  std::string text_;
  std::string root_;
  std::size_t depth_ = 0;
};

}  // namespace

std::string write_usda(const AnimatedScene& scene, const UsdaChoices& choices) {
  return UsdaText(scene, choices).text();
}

}  // namespace inbetween
