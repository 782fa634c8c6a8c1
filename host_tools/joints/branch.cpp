#include "host_tools/joints/branch.hpp"

#include "host_tools/joints/vector_length.hpp"

namespace inbetween {

double Branch::length() const {
  double sum = base;
  for (const BranchJoint& one : joints) sum += one.arm;
  return sum;
}

Branch branch_to(const JointTree& tree, std::int32_t link) {
  Branch branch;
  Pose held;  // from the frame at hand to the last that moves, or to the link
  const auto joints = tree.joints();
  for (std::int32_t i = link; i >= 0; i = joints[static_cast<std::size_t>(i)].parent) {
    const Joint& joint = joints[static_cast<std::size_t>(i)];
    if (joint.kind == JointKind::fixed) {
      held = joint.origin * held;
      continue;
    }
    branch.joints.push_back({joint, inbetween::length(held.position)});
    held = joint.origin;
  }
  branch.base = inbetween::length(held.position);
  return branch;
}

}  // namespace inbetween
