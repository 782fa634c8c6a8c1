// The links and joints of a URDF file (Unified Robot Description Format). docs/formats.md says what is read.
//
// Everything that places a link is checked: what is misspelt or doubled there would put a link where nobody
// expects it. What else a URDF file holds (shapes, masses, sensors, colours) is passed over; words of other
// programs inside a joint with a warning.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/text/diagnostics.hpp"

namespace inbetween {

/// Several times what a humanoid has, whose joints are hundreds. The fuzz target urdf_file holds the reader
/// to it, and UrdfFile.ThousandsOfLinksAreRead reads as many.
inline constexpr std::size_t max_urdf_links = 4096;
/// Largest magnitude of a number: metres and radians of anything that people build.
inline constexpr double max_urdf_number = 1e6;

enum class UrdfJointKind { fixed, revolute, continuous, prismatic };
std::string_view to_string(UrdfJointKind kind);

/// Radians or metres, and those per second.
struct UrdfLimit {
  double lower = 0;
  double upper = 0;
  double velocity = 0;                         // 0: not known
  int lower_decimals = 0, upper_decimals = 0;  // as they are written
  Place place;
};

/// The value of the joint is multiplier * value of the joint `joint` + offset.
struct UrdfMimic {
  std::size_t joint = 0;  // index in UrdfFile::joints
  double multiplier = 1;
  double offset = 0;
  Place place;
};

struct UrdfJoint {
  std::string name;
  UrdfJointKind kind = UrdfJointKind::fixed;
  std::size_t parent = 0;  // indices in UrdfFile::links
  std::size_t child = 0;
  std::array<double, 3> xyz{};          // m
  std::array<double, 3> rpy{};          // rad, about the parent's x, then y, then z
  std::array<double, 3> axis{1, 0, 0};  // not 0
  std::optional<UrdfLimit> limit;       // of a revolute or prismatic joint always
  std::optional<UrdfMimic> mimic;       // never in a circle
  Place place;
};

struct UrdfFile {
  std::string path;
  std::vector<std::string> links;  // the root first, each link behind its parent
  std::vector<UrdfJoint> joints;   // joint i holds link i + 1
  std::vector<Warning> warnings;
};

/// Reads and checks the text of a URDF file. `file_name` stands in places and in UrdfFile::path. Throws
/// InputError with the line of the first thing that is wrong.
UrdfFile parse_urdf(std::string_view text, const std::string& file_name);

}  // namespace inbetween
