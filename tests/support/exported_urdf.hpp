// Random robots as text, in the manner of six programs that write URDF files: the order of their elements and
// attributes, how they print numbers, what they leave out, and what else they put into a file. And what goes
// wrong with such files when people edit them.
#pragma once

#include <array>
#include <cstddef>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace inbetween {

enum class UrdfExporter { solidworks, fusion, onshape, xacro, phobos, gazebo };
inline constexpr std::array urdf_exporters = {UrdfExporter::solidworks, UrdfExporter::fusion,
                                              UrdfExporter::onshape,    UrdfExporter::xacro,
                                              UrdfExporter::phobos,     UrdfExporter::gazebo};

struct UrdfElement {
  std::string name;
  std::vector<std::pair<std::string, std::string>> attributes = {};
  std::vector<UrdfElement> children = {};
  std::string text = {};  // where it has no children
};

/// How a file is put down, whatever it says.
struct UrdfStyle {
  bool has_byte_order_mark = false;
  std::string before = {};       // the declaration
  std::string declaration = {};  // empty: none
  std::string header = {};       // comments behind it
  std::string indent = {};
  std::string newline = {};
  std::string empty_end = {};
  std::string comment = {};  // between the elements of the robot
  bool has_attributes_on_lines = false;
  char quote = '"';
};

/// A robot of so many joints. Some are fixed, some mimic others, and no limit excludes another.
UrdfElement random_robot(std::mt19937_64& random, UrdfExporter exporter, std::size_t joints);
UrdfStyle random_style(std::mt19937_64& random, UrdfExporter exporter);
std::string text_of(const UrdfElement& robot, const UrdfStyle& style);

struct UrdfMistake {
  std::string what;     // for whoever reads of a failure
  bool places = false;  // whether it is about something that places a link or bounds a joint that moves
};

/// Changes one thing.
UrdfMistake make_mistake(std::mt19937_64& random, UrdfElement& robot);

}  // namespace inbetween
