// What moves a link: the joints between it and the world. Fixed joints in a row are one, however many a file
// has: exporters make a link of every screw.
#pragma once

#include <cstdint>
#include <vector>

#include "inbetween/joints/joint_tree.hpp"

namespace inbetween {

struct BranchJoint {
  Joint joint;
  double arm = 0;  ///< m from its frame to that of the joint before it here, or of the link
};

struct Branch {
  std::vector<BranchJoint> joints;  ///< those that move it, from the link to the world
  double base = 0;                  ///< m from the world to the last of them, or to the link
  /// m from the world to the link along all of them, where none slides
  [[nodiscard]] double length() const;
};

Branch branch_to(const JointTree& tree, std::int32_t link);

}  // namespace inbetween
