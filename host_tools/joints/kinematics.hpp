// The geometry of a rig: the joint tree of its URDF file, driven by its axes.
//
// A joint has the name of the axis that moves it, or mimics one that has; any other stays where it is. The
// axis' unit says in what it counts: degrees, radians or turns for a joint that turns, millimetres or metres
// for one that slides.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host_tools/joints/urdf_file.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "host_tools/text/text_file.hpp"
#include "inbetween/joints/joint_tree.hpp"

namespace inbetween {

/// A link that somebody asks for: the camera, a hand.
struct Tip {
  std::string name;
  std::int32_t link = 0;
};

/// Movable.
class Kinematics {
 public:
  /// `rig` has a section [kinematics]. Throws InputError, in the rig's file or the URDF file, where an axis
  /// has a unit that its joint cannot have, or may go farther or faster than the joint, a tip is no link, or
  /// a joint that is to stay somewhere is none or has an axis.
  Kinematics(const UrdfFile& urdf, const RigFile& rig);

  /// Coordinate i is axis i of the rig, in its unit; the world is the root link, in metres.
  [[nodiscard]] const JointTree& tree() const { return tree_; }
  [[nodiscard]] const std::vector<Tip>& tips() const { return tips_; }
  /// The name of each link of tree().
  [[nodiscard]] const std::vector<std::string>& links() const { return links_; }
  /// What was passed over, and which joints stay where they are.
  [[nodiscard]] const std::vector<Warning>& warnings() const { return warnings_; }

 private:
  std::vector<Warning> warnings_;
  std::vector<Joint> memory_;
  JointTree tree_;
  std::vector<Tip> tips_;
  std::vector<std::string> links_;
};

/// The URDF file that the rig names, in the folder of the rig's file, read by `read`. `rig` has a section
/// [kinematics].
Kinematics read_kinematics(const RigFile& rig, const TextReader& read = read_text_file);

}  // namespace inbetween
