#include "tests/support/exported_urdf.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <numbers>
#include <optional>

namespace inbetween {
namespace {

using Attributes = std::vector<std::pair<std::string, std::string>>;

double between(std::mt19937_64& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

std::size_t index_below(std::mt19937_64& random, std::size_t count) {
  return std::uniform_int_distribution<std::size_t>(0, count - 1)(random);
}

bool one_in(std::mt19937_64& random, std::size_t count) {
  return index_below(random, count) == 0;
}

template <class Choices>
auto one_of(std::mt19937_64& random, const Choices& choices) {
  return *std::next(std::begin(choices),
                    static_cast<std::ptrdiff_t>(index_below(random, std::size(choices))));
}

/// As Python prints a float.
std::string python_number(double value) {
  const std::string text = fmt::format("{}", value);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

/// Writes the links and joints of one robot.
class Writer {
 public:
  Writer(std::mt19937_64& random, UrdfExporter exporter) : random_(random), exporter_(exporter) {}

  UrdfElement robot(std::size_t joints) {
    UrdfElement robot{.name = "robot", .attributes = {{"name", "random robot"}}};
    if (is(UrdfExporter::phobos)) robot.attributes.emplace_back("version", "1.0");
    if (is(UrdfExporter::xacro))
      robot.attributes.emplace_back("xmlns:xacro", "http://www.ros.org/wiki/xacro");
    if (is(UrdfExporter::gazebo)) robot.attributes.emplace_back("xmlns:drake", "http://drake.mit.edu");
    robot.children.push_back(link(0));
    for (std::size_t i = 1; i <= joints; ++i) {
      robot.children.push_back(link(i));
      robot.children.push_back(joint(i));
    }
    add_rest(robot);
    if (is(UrdfExporter::phobos)) {  // sorted
      std::ranges::stable_sort(robot.children, {}, [](const UrdfElement& one) { return one.name; });
    }
    return robot;
  }

 private:
  struct Moving {
    std::string name;
    bool slides = false;
  };

  [[nodiscard]] bool is(UrdfExporter exporter) const { return exporter_ == exporter; }

  std::string number(double value) {
    switch (exporter_) {
      case UrdfExporter::solidworks: {
        std::string text = fmt::format("{:.5g}", value);
        std::ranges::replace(text, 'e', 'E');
        return text;
      }
      case UrdfExporter::fusion:
        return python_number(std::round(value * 1e6) / 1e6);
      case UrdfExporter::onshape:
        return long_numbers_ ? fmt::format("{:.20g}", value) : fmt::format("{:.6g}", value);
      case UrdfExporter::xacro:
        return value == std::round(value) && one_in(random_, 2) ? fmt::format("{:.0f}", value)
                                                                : python_number(value);
      case UrdfExporter::phobos:
        return python_number(value);
      case UrdfExporter::gazebo:
        return fmt::format("{}", value);
    }
    return "";
  }

  std::string numbers(const std::array<double, 3>& values) {
    return fmt::format("{} {} {}", number(values[0]), number(values[1]), number(values[2]));
  }

  /// What comes out of matrices and of people.
  double angle() {
    constexpr double pi = std::numbers::pi;
    constexpr std::array often = {0.0,   0.0,  -0.0,       pi / 2,   -pi / 2,
                                  pi,    -pi,  1.5708,     -3.1416,  0.7,
                                  1.571, 1.57, 6.1232e-17, -2.2e-16, 1.5707963267949};
    return one_in(random_, 3) ? between(random_, -pi, pi) : one_of(random_, often);
  }

  double length() {
    constexpr std::array often = {0.0, -0.0, 0.1, -0.05, 1.2e-17, 3.5e-6, 1.0};
    return one_in(random_, 2) ? between(random_, -2, 2) : one_of(random_, often);
  }

  std::string axis() {
    const std::array<std::array<double, 3>, 8> often = {{{0, 0, 1},
                                                         {0, 0, -1},
                                                         {0, 1, 0},
                                                         {1, 0, 0},
                                                         {-1, 0, -0.0},
                                                         {0, 1, 6.1232e-17},
                                                         {0, 0, 2},
                                                         {0.6, 0, 0.8}}};
    if (!one_in(random_, 4)) return numbers(one_of(random_, often));
    return numbers({between(random_, -1, 1), between(random_, -1, 1), between(random_, 0.1, 1)});
  }

  UrdfElement origin() {
    const std::string xyz = numbers({length(), length(), length()});
    const std::string rpy = is(UrdfExporter::fusion) ? "0 0 0" : numbers({angle(), angle(), angle()});
    if (is(UrdfExporter::phobos) || is(UrdfExporter::gazebo)) {
      return {.name = "origin", .attributes = {{"rpy", rpy}, {"xyz", xyz}}};
    }
    return {.name = "origin", .attributes = {{"xyz", xyz}, {"rpy", rpy}}};
  }

  std::string link_name(std::size_t i) const {
    if (i == 0) return "base_link";
    switch (exporter_) {
      case UrdfExporter::fusion:
        return fmt::format("part_v{}_1", i);
      case UrdfExporter::onshape:
        return fmt::format("part_{} <{}>", i, i % 3);  // escaped where it is written
      case UrdfExporter::xacro:
        return fmt::format("left/arm_link_{}", i);
      case UrdfExporter::solidworks:
        return fmt::format("Stütze {}", i);
      default:
        return fmt::format("link_{}", i);
    }
  }

  UrdfElement shape(const char* name) {
    UrdfElement shape{.name = name, .children = {origin()}};
    UrdfElement geometry{.name = "geometry"};
    if (one_in(random_, 3)) {
      geometry.children.push_back({.name = "box", .attributes = {{"size", "0.1 0.2 0.3"}}});
    } else {
      geometry.children.push_back(
          {.name = "mesh", .attributes = {{"filename", "package://robot/meshes/a part.STL"}}});
      if (is(UrdfExporter::fusion))
        geometry.children.back().attributes.emplace_back("scale", "0.001 0.001 0.001");
    }
    shape.children.push_back(geometry);
    if (shape.name != "visual") return shape;
    const char* material = is(UrdfExporter::solidworks) ? "" : "silver";
    shape.children.push_back({.name = "material",
                              .attributes = {{"name", material}},
                              .children = {{.name = "color", .attributes = {{"rgba", "0.75 0.75 0.75 1"}}}}});
    return shape;
  }

  UrdfElement link(std::size_t i) {
    UrdfElement link{.name = "link", .attributes = {{"name", link_name(i)}}};
    if (one_in(random_, 4)) return link;
    link.children.push_back(
        {.name = "inertial",
         .children = {origin(),
                      {.name = "mass", .attributes = {{"value", number(between(random_, 0, 3))}}},
                      {.name = "inertia",
                       .attributes = {{"ixx", number(1e-3)},
                                      {"ixy", number(-1.2e-9)},
                                      {"ixz", number(0)},
                                      {"iyy", number(1e-3)},
                                      {"iyz", number(-0.0)},
                                      {"izz", number(2e-3)}}}}});
    link.children.push_back(shape("visual"));
    link.children.push_back(shape("collision"));
    if (is(UrdfExporter::gazebo)) link.children.push_back({.name = "gravity", .text = "true"});
    return link;
  }

  /// Wide enough for a joint that follows another.
  UrdfElement limit(const std::string& type, bool mimics) {
    UrdfElement limit{.name = "limit"};
    const double reach = mimics ? 100 : 1;
    std::string lower = number(-reach * between(random_, 0.5, 3.2));
    std::string upper = number(reach * between(random_, 0.5, 3.2));
    if (is(UrdfExporter::gazebo) && one_in(random_, 3)) {
      lower = "-1e+16";
      upper = "1e+16";
    } else if (!mimics && one_in(random_, 8)) {
      lower = number(0.25);
    } else if (one_in(random_, 8)) {
      lower = upper = number(0);
    }
    const std::string velocity = one_in(random_, 4) ? number(0) : number(reach * 3.14);
    const std::string effort = one_in(random_, 4) ? number(0) : number(100);
    const bool has_ends = type != "continuous" || one_in(random_, 3);
    const auto add = [&](const char* name, const std::string& value) {
      if (has_ends || value == velocity || value == effort) limit.attributes.emplace_back(name, value);
    };
    switch (exporter_) {
      case UrdfExporter::fusion:
        add("upper", upper);
        add("lower", lower);
        break;
      case UrdfExporter::onshape:
        limit.attributes = {{"effort", effort}, {"velocity", velocity}};
        add("lower", lower);
        add("upper", upper);
        return limit;
      case UrdfExporter::xacro:
      case UrdfExporter::gazebo:
        limit.attributes.emplace_back("effort", effort);
        add("lower", lower);
        add("upper", upper);
        limit.attributes.emplace_back("velocity", velocity);
        return limit;
      default:
        add("lower", lower);
        add("upper", upper);
    }
    limit.attributes.emplace_back("effort", effort);
    limit.attributes.emplace_back("velocity", velocity);
    return limit;
  }

  void add_axis(const std::string& type, UrdfElement& joint) {
    if (type != "fixed") {
      // What is not written is x.
      if (is(UrdfExporter::xacro) && one_in(random_, 5)) return;
      joint.children.push_back({.name = "axis", .attributes = {{"xyz", axis()}}});
      if (is(UrdfExporter::gazebo) && one_in(random_, 3)) {
        joint.children.back().attributes.emplace_back("expressed_in", "__model__");
      }
    } else if (is(UrdfExporter::solidworks) || is(UrdfExporter::onshape)) {
      joint.children.push_back({.name = "axis", .attributes = {{"xyz", "0 0 0"}}});
    }
  }

  void add_limit(const std::string& type, bool mimics, UrdfElement& joint) {
    const bool needs_one = type == "revolute" || type == "prismatic";
    const bool writes_one = type == "continuous" ? !is(UrdfExporter::fusion) && one_in(random_, 2)
                                                 : is(UrdfExporter::gazebo) && one_in(random_, 2);
    if (needs_one || writes_one) joint.children.push_back(limit(type, mimics));
  }

  void add_mimic(bool slides, UrdfElement& joint) {
    UrdfElement mimic{.name = "mimic", .attributes = {{"joint", one_of(random_, moving_).name}}};
    // Metres of radians, or radians of metres.
    const double most = slides ? 0.5 : 2;
    if (!one_in(random_, 4))
      mimic.attributes.emplace_back("multiplier", number(between(random_, -most, most)));
    if (!one_in(random_, 3)) mimic.attributes.emplace_back("offset", number(between(random_, -0.5, 0.5)));
    joint.children.push_back(mimic);
  }

  void add_control(const std::string& type, UrdfElement& joint) {
    const auto add = [&](const char* name, const Attributes& attributes) {
      joint.children.push_back({.name = name, .attributes = attributes});
    };
    switch (exporter_) {
      case UrdfExporter::solidworks:
        if (one_in(random_, 3)) add("calibration", {{"rising", "0"}, {"falling", "0"}});
        if (one_in(random_, 3)) add("dynamics", {{"damping", "0"}, {"friction", "0"}});
        if (one_in(random_, 3)) {
          add("safety_controller",
              {{"soft_upper", "0"}, {"soft_lower", "0"}, {"k_position", "0"}, {"k_velocity", "0"}});
        }
        break;
      case UrdfExporter::onshape:
        add("joint_properties", {{"friction", "0.0"}});
        break;
      case UrdfExporter::xacro:
        if (type == "fixed") break;
        add("dynamics", {{"damping", "0.0"}, {"friction", "0.0"}});
        if (one_in(random_, 2)) {
          add("safety_controller", {{"k_position", "100"},
                                    {"k_velocity", "40"},
                                    {"soft_lower_limit", "-6.13"},
                                    {"soft_upper_limit", "6.13"}});
        }
        break;
      case UrdfExporter::gazebo:
        if (one_in(random_, 2)) add("drake:rotor_inertia", {{"value", "0.1"}});
        if (one_in(random_, 2)) add("isaac_drive_api", {{"strength", "0"}, {"target", "position"}});
        break;
      default:
        break;
    }
  }

  void arrange(UrdfElement& joint) {
    if (is(UrdfExporter::gazebo)) std::ranges::shuffle(joint.children, random_);
    if (!is(UrdfExporter::phobos)) return;
    const auto limit = std::ranges::find(joint.children, "limit", &UrdfElement::name);
    if (limit != joint.children.end()) std::rotate(joint.children.begin(), limit, std::next(limit));
  }

  UrdfElement joint(std::size_t i) {
    constexpr std::array types = {"fixed",    "fixed",    "fixed",     "revolute",  "revolute",
                                  "revolute", "revolute", "prismatic", "prismatic", "continuous"};
    const std::string type = one_of(random_, types);
    UrdfElement joint{.name = "joint", .attributes = {{"name", fmt::format("joint_{}", i)}, {"type", type}}};
    if (is(UrdfExporter::gazebo) && one_in(random_, 4)) joint.attributes.emplace_back("preserve", "true");
    // Long branches are as frequent as bushes.
    const std::size_t parent = one_in(random_, 2) ? i - 1 : index_below(random_, i);
    const bool mimics = type != "fixed" && !moving_.empty() && one_in(random_, 4);
    const bool has_origin = !(is(UrdfExporter::xacro) && one_in(random_, 4));
    if (has_origin) joint.children.push_back(origin());
    joint.children.push_back({.name = "parent", .attributes = {{"link", link_name(parent)}}});
    joint.children.push_back({.name = "child", .attributes = {{"link", link_name(i)}}});
    add_axis(type, joint);
    add_limit(type, mimics, joint);
    if (mimics) add_mimic(type == "prismatic", joint);
    add_control(type, joint);
    arrange(joint);
    if (type != "fixed" && (!mimics || one_in(random_, 3)))
      moving_.push_back({joint.attributes[0].second, type == "prismatic"});
    return joint;
  }

  void add_rest(UrdfElement& robot) {
    const auto add = [&](UrdfElement element) { robot.children.push_back(std::move(element)); };
    if (is(UrdfExporter::phobos)) {
      add({.name = "material",
           .attributes = {{"name", "blue"}},
           .children = {{.name = "color", .attributes = {{"rgba", "0 0 1 1"}}}}});
      add({.name = "sensor",
           .attributes = {{"name", "camera"}},
           .children = {origin(), {.name = "parent", .attributes = {{"link", "base_link"}}}}});
    }
    if (!is(UrdfExporter::fusion) && !is(UrdfExporter::xacro) && !is(UrdfExporter::gazebo)) return;
    add({.name = "gazebo",
         .attributes = {{"reference", "base_link"}},
         .children = {{.name = "mu1", .text = "0.2"}, {.name = "selfCollide", .text = "true"}}});
    for (const Moving& one : moving_) {
      add({.name = "transmission",
           .attributes = {{"name", one.name + "_tran"}},
           .children = {{.name = "type", .text = "transmission_interface/SimpleTransmission"},
                        {.name = "joint",
                         .attributes = {{"name", one.name}},
                         .children = {{.name = "hardwareInterface",
                                       .text = "hardware_interface/EffortJointInterface"}}},
                        {.name = "actuator", .attributes = {{"name", one.name + "_actr"}}}}});
    }
    if (!is(UrdfExporter::xacro)) return;
    UrdfElement control{.name = "ros2_control", .attributes = {{"name", "arm"}, {"type", "system"}}};
    for (const Moving& one : moving_) {
      control.children.push_back(
          {.name = "joint",
           .attributes = {{"name", one.name}},
           .children = {{.name = "command_interface", .attributes = {{"name", "position"}}}}});
    }
    add(control);
  }

  std::mt19937_64& random_;
  UrdfExporter exporter_;
  bool long_numbers_ = one_in(random_, 2);
  std::vector<Moving> moving_;
};

std::string escaped(std::string_view text, char quote) {
  std::string result;
  for (const char c : text) {
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '>')
      result += "&gt;";
    else if (c == quote)
      result += quote == '"' ? "&quot;" : "&apos;";
    else
      result += c;
  }
  return result;
}

void write(const UrdfElement& element, const UrdfStyle& style, const std::string& indent, std::string& text) {
  text += indent + "<" + element.name;
  for (const auto& [name, value] : element.attributes) {
    text += style.has_attributes_on_lines ? style.newline + indent + style.indent : " ";
    text += name + "=" + style.quote + escaped(value, style.quote) + style.quote;
  }
  if (element.children.empty() && element.text.empty()) {
    text += style.empty_end + style.newline;
    return;
  }
  text += ">" + element.text;
  if (!element.children.empty()) text += style.newline;
  for (const UrdfElement& child : element.children) {
    if (indent.empty()) text += style.comment;
    write(child, style, indent + style.indent, text);
  }
  if (!element.children.empty()) text += indent;
  text += "</" + element.name + ">" + style.newline;
}

UrdfElement& element_at(UrdfElement& robot, const std::vector<std::size_t>& path) {
  UrdfElement* element = &robot;
  for (const std::size_t i : path) element = &element->children[i];
  return *element;
}

/// Mostly in a joint.
std::vector<std::size_t> random_path(std::mt19937_64& random, const UrdfElement& robot) {
  std::vector<std::size_t> path = {index_below(random, robot.children.size())};
  for (int tries = 0; tries < 3 && robot.children[path[0]].name != "joint"; ++tries) {
    path[0] = index_below(random, robot.children.size());
  }
  const UrdfElement* element = &robot.children[path[0]];
  while (!element->children.empty() && !one_in(random, 4)) {
    path.push_back(index_below(random, element->children.size()));
    element = &element->children[path.back()];
  }
  return path;
}

std::string_view value_of(const UrdfElement& element, std::string_view attribute) {
  for (const auto& [name, value] : element.attributes) {
    if (name == attribute) return value;
  }
  return {};
}

bool is_one_of(std::string_view word, std::initializer_list<std::string_view> words) {
  return std::ranges::find(words, word) != words.end();
}

/// Whether an element, or one of its attributes, places a link or bounds a joint that moves.
bool places(UrdfElement& robot, const std::vector<std::size_t>& path, std::string_view attribute) {
  const UrdfElement& top = robot.children[path[0]];
  if (top.name == "link") return path.size() == 1 && is_one_of(attribute, {"", "name"});
  if (top.name != "joint") return false;
  if (path.size() == 1) return is_one_of(attribute, {"", "name", "type"});
  if (path.size() > 2) return false;
  const std::string& name = element_at(robot, path).name;
  const std::string_view type = value_of(top, "type");
  if (is_one_of(name, {"parent", "child"})) return is_one_of(attribute, {"", "link"});
  if (name == "origin") return is_one_of(attribute, {"", "xyz", "rpy"});
  if (type == "fixed") return false;
  if (name == "axis") return is_one_of(attribute, {"", "xyz"});
  if (name == "mimic") return is_one_of(attribute, {"", "joint", "multiplier", "offset"});
  return name == "limit" && type != "continuous" && is_one_of(attribute, {"", "lower", "upper", "velocity"});
}

std::string misspelt(std::mt19937_64& random, std::string word) {
  const std::size_t at = index_below(random, word.size());
  switch (index_below(random, 4)) {
    case 0:
      if (word.size() > 1) std::swap(word[at], word[at == 0 ? 1 : at - 1]);
      break;
    case 1:
      word[0] = static_cast<char>(word[0] & ~0x20);
      break;
    case 2:
      if (word.size() > 3) word.erase(at == 0 ? 1 : at, 1);
      break;
    default:
      word.insert(at, 1, word[at]);
  }
  return word;
}

/// Blanks that mean nothing, or another value.
std::string other_value(std::mt19937_64& random, const std::string& attribute, const std::string& value) {
  if (attribute == "type") {
    return one_of(random, std::array{"floating", "planar", "Revolute", "hinge", "fixed", "continuous", ""});
  }
  if (is_one_of(attribute, {"name", "link", "joint", "reference"})) {
    return one_of(random, std::array<std::string, 4>{"", "nobody", std::string(300, 'n'), value + " "});
  }
  switch (index_below(random, 4)) {
    case 0:
      return " " + value;
    case 1:
      return value + " ";
    case 2: {
      std::string wider = value;
      const std::size_t blank = wider.find(' ');
      if (blank != std::string::npos) wider.insert(blank, 1, ' ');
      return wider;
    }
    default:
      break;
  }
  const std::string one =
      one_of(random, std::array{"nan", "inf", "1,5", "", "1e16", "-1e7", "1e400", "0x10", "1.0f", "${x}",
                                "1.", ".5", "+2", "--1", "1e-300", "1E3", "one", "-5", "0"});
  const auto others = value.find(' ');
  return others == std::string::npos ? one : one + value.substr(others);
}

UrdfMistake mistake_in_attribute(std::mt19937_64& random, UrdfElement& robot,
                                 const std::vector<std::size_t>& path) {
  UrdfElement& element = element_at(robot, path);
  const std::size_t at = index_below(random, element.attributes.size());
  auto& [name, value] = element.attributes[at];
  UrdfMistake mistake{.what = fmt::format("{} of <{}>", name, element.name),
                      .places = places(robot, path, name)};
  switch (index_below(random, 4)) {
    case 0:
      element.attributes.erase(element.attributes.begin() + static_cast<std::ptrdiff_t>(at));
      mistake.what += " left out";
      break;
    case 1:
      name = misspelt(random, name);
      mistake.what += " misspelt: " + name;
      // Two of one name would not be XML.
      if (std::ranges::count(element.attributes, name, [](const auto& one) { return one.first; }) > 1)
        name += "_";
      break;
    default:
      value = other_value(random, name, value);
      mistake.what += " changed to \"" + value + "\"";
  }
  return mistake;
}

UrdfElement foreign_element(std::mt19937_64& random) {
  const std::array names = {"hardware",
                            "drake:effort_limit",
                            "isaac_sim",
                            "controller_gains",
                            "encoder",
                            "motor",
                            "gear_ratio",
                            "preserveFixedJoint",
                            "verbose",
                            "contact",
                            "self_collision_checking"};
  return {.name = one_of(random, names), .attributes = {{"value", "1"}}};
}

UrdfMistake mistake_in_element(std::mt19937_64& random, UrdfElement& robot,
                               const std::vector<std::size_t>& path) {
  UrdfElement& element = element_at(robot, path);
  UrdfElement& parent = element_at(robot, {path.begin(), std::prev(path.end())});
  UrdfMistake mistake{.what = fmt::format("<{}>", element.name), .places = places(robot, path, "")};
  const auto place = parent.children.begin() + static_cast<std::ptrdiff_t>(path.back());
  switch (index_below(random, 6)) {
    case 0:
      mistake.what += " left out";
      parent.children.erase(place);
      break;
    case 1:
      mistake.what += " twice";
      parent.children.insert(place, UrdfElement(element));
      break;
    case 2:
      element.name = misspelt(random, element.name);
      mistake.what += " misspelt: " + element.name;
      break;
    case 3:
      mistake = {.what = mistake.what + " has foreign children"};
      element.children.push_back(foreign_element(random));
      element.text.clear();
      break;
    case 4:
      mistake = {.what = mistake.what + " has a foreign attribute"};
      element.attributes.emplace_back(
          one_of(random, std::array{"units", "gz:expressed_in", "comment", "id", "acceleration", "jerk",
                                    "safety", "collapse"}),
          "0");
      break;
    default:
      mistake = {.what = mistake.what + " has its elements in another order"};
      std::ranges::shuffle(element.children, random);
  }
  return mistake;
}

}  // namespace

UrdfElement random_robot(std::mt19937_64& random, UrdfExporter exporter, std::size_t joints) {
  return Writer(random, exporter).robot(joints);
}

UrdfStyle random_style(std::mt19937_64& random, UrdfExporter exporter) {
  UrdfStyle style{.indent = "  ", .newline = "\n", .empty_end = "/>"};
  switch (exporter) {
    case UrdfExporter::solidworks:
      style.has_byte_order_mark = one_in(random, 2);
      style.declaration = R"(<?xml version="1.0" encoding="utf-8"?>)";
      style.header =
          "<!-- This URDF was written by an exporter! Written first by Somebody (a@b.c) \r\n"
          "     Version: 1.6.0-4-g7f85cfe -->\r\n";
      style.newline = "\r\n";
      style.empty_end = " />";
      style.has_attributes_on_lines = true;
      break;
    case UrdfExporter::onshape:
      style.declaration = R"(<?xml version="1.0" ?>)";
      style.header = "<!-- Written by a program -->\n";
      style.comment = "  <!-- Part <1> & others -->\n";
      style.empty_end = one_in(random, 2) ? "/>" : " />";
      break;
    case UrdfExporter::fusion:
    case UrdfExporter::xacro:
      style.declaration =
          one_in(random, 4) ? R"(<?xml version="1.0" encoding="us-ascii"?>)" : R"(<?xml version="1.0" ?>)";
      style.header =
          "<!-- ======================================= -->\n<!-- |    Made by xacro from a.urdf.xacro  | "
          "-->\n";
      style.comment = one_in(random, 4) ? "  <!-- -------- links -------- -->\n" : "  <!--***-->\n";
      if (one_in(random, 4)) style.indent = "\t";
      if (one_in(random, 4)) style.quote = '\'';
      break;
    case UrdfExporter::phobos:
      break;
    case UrdfExporter::gazebo:
      style.declaration = R"(<?xml version="1.0"?>)";
      style.header =
          R"(<?xml-model href="https://raw.githubusercontent.com/ros/urdfdom/master/xsd/urdf.xsd"?>)";
      style.header += "\n";
      break;
  }
  if (one_in(random, 6)) style.before = one_of(random, std::array{"\n", "  ", "<!-- found in a log -->\n"});
  if (style.has_byte_order_mark) style.before.clear();
  return style;
}

std::string text_of(const UrdfElement& robot, const UrdfStyle& style) {
  std::string text = style.has_byte_order_mark ? "\xef\xbb\xbf" : "";
  text += style.before;
  if (!style.declaration.empty()) text += style.declaration + style.newline;
  text += style.header;
  write(robot, style, "", text);
  return text;
}

UrdfMistake make_mistake(std::mt19937_64& random, UrdfElement& robot) {
  const std::vector<std::size_t> path = random_path(random, robot);
  const bool has_attributes = !element_at(robot, path).attributes.empty();
  return has_attributes && !one_in(random, 3) ? mistake_in_attribute(random, robot, path)
                                              : mistake_in_element(random, robot, path);
}

}  // namespace inbetween
