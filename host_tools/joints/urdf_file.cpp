#include "host_tools/joints/urdf_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <span>
#include <utility>

#include "host_tools/joints/xml_element.hpp"
#include "host_tools/text/toml_source.hpp"

namespace inbetween {
namespace {

constexpr std::array<std::string_view, 4> kind_names = {"fixed", "revolute", "continuous", "prismatic"};
constexpr std::array<std::string_view, 9> joint_parts = {
    "origin", "parent", "child", "axis", "mimic", "limit", "calibration", "dynamics", "safety_controller"};
/// Programs write limits of 1e16 where there are none.
constexpr double max_limit = std::numeric_limits<double>::max();

/// What a joint says of others by their names, until all are known.
struct JointNames {
  std::string parent, child;
  std::optional<std::string> mimicked;
};

/// Elements by the names that are taken. The place is where it was.
using Names = std::map<std::string, std::size_t, std::less<>>;

std::string name_of(const XmlElement& element, std::string_view example, Names& taken) {
  std::string name = element.text("name", example);
  if (!taken.emplace(name, taken.size()).second) {
    element.refuse(fmt::format("has the name {}, which another has too; give each its own", in_quotes(name)));
  }
  return name;
}

UrdfJointKind read_kind(const XmlElement& joint) {
  const std::string type = joint.text("type", "type=\"revolute\", say");
  const auto found = std::ranges::find(kind_names, type);
  if (found == kind_names.end()) {
    joint.refuse(fmt::format("has the type {}; write {}", in_quotes(type), comma_separated(kind_names)));
  }
  return static_cast<UrdfJointKind>(found - kind_names.begin());
}

/// Words of later versions and of other formats, which say where something is: not to read them would put a
/// link elsewhere.
void refuse_other_placing(const XmlElement& element, std::string_view remedy) {
  constexpr std::array<std::string_view, 11> words = {
      "x", "y", "z", "roll", "pitch", "yaw", "quat", "quat_xyzw", "quat_wxyz", "quaternion", "pose"};
  for (const std::string_view word : words) {
    if (element.has(word)) element.refuse(fmt::format("has {}, which is not read; {}", word, remedy));
  }
}

/// How many of the parts place a link or bound a joint of this kind; the others mean nothing there, and many
/// exporters write zeros into them. The limit of a joint that turns without end has an effort and a velocity.
std::size_t parts_that_count(UrdfJointKind kind) {
  switch (kind) {
    case UrdfJointKind::fixed:
      return 3;
    case UrdfJointKind::continuous:
      return 5;
    default:
      return 6;
  }
}

void read_origin(const XmlElement& element, UrdfJoint& joint, PassedOver& passed) {
  const auto origin = element.child("origin");
  if (!origin) return;
  refuse_other_placing(*origin, "write xyz=\"0 0 1\" rpy=\"0 0 0\", say");
  origin->allow_attributes({"xyz", "rpy"}, passed);
  joint.xyz = origin->numbers("xyz", {}, max_urdf_number);
  joint.rpy = origin->numbers("rpy", {}, max_urdf_number);
}

void read_axis(const XmlElement& element, UrdfJoint& joint, PassedOver& passed) {
  const auto axis = element.child("axis");
  if (!axis) return;
  axis->allow_attributes({"xyz"}, passed);
  if (!axis->has("xyz")) axis->refuse("has no xyz; write xyz=\"0 0 1\", say");
  joint.axis = axis->numbers("xyz", joint.axis, max_urdf_number);
  const bool has_length = std::ranges::any_of(joint.axis, [](double x) { return x != 0; });
  if (!has_length) axis->refuse("has no direction; write xyz=\"0 0 1\", say");
}

void read_limit(const XmlElement& element, UrdfJoint& joint, PassedOver& passed) {
  const auto limit = element.child("limit");
  if (!limit) {
    element.refuse("has no <limit>; add <limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/>, say");
  }
  limit->allow_attributes({"lower", "upper", "velocity"}, passed, {"effort"});
  UrdfLimit& found = joint.limit.emplace();
  found.place = limit->place();
  found.lower = limit->number("lower", 0, max_limit);
  found.upper = limit->number("upper", 0, max_limit);
  found.lower_decimals = limit->decimals("lower");
  found.upper_decimals = limit->decimals("upper");
  found.velocity = limit->number("velocity", std::nullopt, max_limit);
  if (found.lower > found.upper) limit->refuse("has a lower above upper; exchange them");
  if (found.velocity < 0) limit->refuse("has a negative velocity; write its magnitude");
}

std::optional<std::string> read_mimic(const XmlElement& element, UrdfJoint& joint, PassedOver& passed) {
  const auto mimic = element.child("mimic");
  if (!mimic) return std::nullopt;
  mimic->allow_attributes({"joint", "multiplier", "offset"}, passed);
  joint.mimic = UrdfMimic{.joint = 0,
                          .multiplier = mimic->number("multiplier", 1, max_urdf_number),
                          .offset = mimic->number("offset", 0, max_urdf_number),
                          .place = mimic->place()};
  return mimic->text("joint", "joint=\"the joint that it follows\"");
}

std::string linked(const XmlElement& joint, const char* end, PassedOver& passed) {
  const XmlElement element = joint.required_child(end, fmt::format("<{} link=\"...\"/>", end));
  element.allow_attributes({"link"}, passed);
  return element.text("link", "link=\"the name of a link\"");
}

UrdfJoint read_joint(const XmlElement& element, Names& taken, JointNames& names, PassedOver& passed) {
  element.allow_attributes({"name", "type"}, passed);
  UrdfJoint joint;
  joint.place = element.place();
  joint.name = name_of(element, "name=\"swing\", say", taken);
  joint.kind = read_kind(element);
  const std::span parts(joint_parts);
  const std::size_t count = parts_that_count(joint.kind);
  element.allow_children(parts.first(count), passed, parts.subspan(count));
  names.parent = linked(element, "parent", passed);
  names.child = linked(element, "child", passed);
  read_origin(element, joint, passed);
  if (joint.kind == UrdfJointKind::fixed) return joint;
  read_axis(element, joint, passed);
  if (joint.kind != UrdfJointKind::continuous) read_limit(element, joint, passed);
  names.mimicked = read_mimic(element, joint, passed);
  return joint;
}

/// A file as it is written, before its links are in order.
struct ReadParts {
  std::vector<std::string> links;
  std::vector<Place> link_places;
  std::vector<UrdfJoint> joints;
  std::vector<JointNames> names;
  Names link_index, joint_index;
  PassedOver passed;

  explicit ReadParts(const XmlElement& robot) {
    for (const XmlElement& link : robot.children("link")) {
      links.push_back(name_of(link, "name=\"boom\", say", link_index));
      link_places.push_back(link.place());
      if (links.size() > max_urdf_links) {
        link.refuse(fmt::format("is one more than the {} that are allowed; leave out what does not move",
                                max_urdf_links));
      }
    }
    if (links.empty()) robot.refuse("has no <link>; add <link name=\"base\"/>");
    for (const XmlElement& joint : robot.children("joint")) {
      names.emplace_back();
      joints.push_back(read_joint(joint, joint_index, names.back(), passed));
    }
  }
};

std::size_t index_of(const Names& names, const std::string& name, const Place& place, const char* what) {
  const auto found = names.find(name);
  if (found == names.end()) {
    throw InputError(place, fmt::format("there is no {} {}; correct the name", what, in_quotes(name)));
  }
  return found->second;
}

/// The joint that holds each link; nothing for the roots.
std::vector<std::optional<std::size_t>> connect(ReadParts& parts) {
  std::vector<std::optional<std::size_t>> holder(parts.links.size());
  for (std::size_t j = 0; j < parts.joints.size(); ++j) {
    UrdfJoint& joint = parts.joints[j];
    joint.parent = index_of(parts.link_index, parts.names[j].parent, joint.place, "link");
    joint.child = index_of(parts.link_index, parts.names[j].child, joint.place, "link");
    if (parts.names[j].mimicked) {
      joint.mimic->joint = index_of(parts.joint_index, *parts.names[j].mimicked, joint.mimic->place, "joint");
    }
    std::optional<std::size_t>& held = holder[joint.child];
    if (held) {
      throw InputError(joint.place,
                       fmt::format("link {} hangs on joint {} already; a link has one joint",
                                   in_quotes(parts.links[joint.child]), in_quotes(parts.joints[*held].name)));
    }
    held = j;
  }
  return holder;
}

/// The links, each behind its parent: the root, then what hangs on it, and so on.
std::vector<std::size_t> in_order(const ReadParts& parts,
                                  const std::vector<std::optional<std::size_t>>& holder) {
  std::vector<std::size_t> order;
  for (std::size_t link = 0; link < holder.size(); ++link) {
    if (holder[link]) continue;
    if (!order.empty()) {
      throw InputError(parts.link_places[link],
                       fmt::format("link {} hangs on nothing, and so does {}; join them",
                                   in_quotes(parts.links[link]), in_quotes(parts.links[order.front()])));
    }
    order.push_back(link);
  }
  std::vector<std::vector<std::size_t>> held(holder.size());
  for (const UrdfJoint& joint : parts.joints) held[joint.parent].push_back(joint.child);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::vector<std::size_t>& next = held[order[i]];
    order.insert(order.end(), next.begin(), next.end());
  }
  for (std::size_t link = 0; link < holder.size() && order.size() < holder.size(); ++link) {
    if (std::ranges::find(order, link) != order.end()) continue;
    throw InputError(parts.joints[*holder[link]].place,
                     fmt::format("link {} is part of a circle; hang one of its links on the root",
                                 in_quotes(parts.links[link])));
  }
  return order;
}

void refuse_circles_of_mimics(const std::vector<UrdfJoint>& joints) {
  for (const UrdfJoint& joint : joints) {
    const UrdfJoint* followed = &joint;
    for (std::size_t steps = 0; followed->mimic; ++steps) {
      if (steps > joints.size()) {
        throw InputError(joint.mimic->place, fmt::format("joint {} follows itself; let it follow another",
                                                         in_quotes(joint.name)));
      }
      followed = &joints[followed->mimic->joint];
    }
    if (joint.mimic && followed->kind == UrdfJointKind::fixed) {
      throw InputError(joint.mimic->place,
                       fmt::format("joint {} is fixed; follow one that moves", in_quotes(followed->name)));
    }
  }
}

UrdfFile ordered(ReadParts parts, const std::string& file_name) {
  const auto holder = connect(parts);
  refuse_circles_of_mimics(parts.joints);
  const std::vector<std::size_t> order = in_order(parts, holder);
  std::vector<std::size_t> place_of(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) place_of[order[i]] = i;
  UrdfFile file{.path = file_name, .links = {}, .joints = {}, .warnings = {}};
  if (!parts.passed.names.empty()) {
    file.warnings.push_back(
        {parts.passed.first,
         fmt::format("of another program, and passed over wherever it stands in a joint: {}",
                     comma_separated(parts.passed.names))});
  }
  for (const std::size_t link : order) {
    file.links.push_back(parts.links[link]);
    if (!holder[link]) continue;
    UrdfJoint joint = parts.joints[*holder[link]];
    joint.parent = place_of[joint.parent];
    joint.child = place_of[joint.child];
    // Joint i holds link i + 1, in the new order too.
    if (joint.mimic) joint.mimic->joint = place_of[parts.joints[joint.mimic->joint].child] - 1;
    file.joints.push_back(std::move(joint));
  }
  return file;
}

}  // namespace

std::string_view to_string(UrdfJointKind kind) {
  return kind_names.at(static_cast<std::size_t>(kind));
}

UrdfFile parse_urdf(std::string_view text, const std::string& file_name) {
  const XmlDocument document(text, file_name);
  const XmlElement root = document.root();
  if (root.name() != "robot") {
    throw InputError({file_name, 1, 0}, "the file does not begin with <robot>; is it a URDF file?");
  }
  if (const auto unexpanded = document.first_with_prefix("xacro:")) {
    unexpanded->refuse(
        fmt::format("is of xacro, and this file was not expanded; write: xacro {} > robot.urdf", file_name));
  }
  return ordered(ReadParts(root), file_name);
}

}  // namespace inbetween
