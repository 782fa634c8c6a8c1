// Any text is a tree of links that keeps every promise of host_tools/joints/urdf_file.hpp, or is refused in
// one line.
#include "host_tools/joints/urdf_file.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <set>
#include <string_view>

#include "tests/fuzz/targets/refusal.hpp"

namespace inbetween {
namespace {

void require_numbers(const std::array<double, 3>& numbers) {
  for (const double number : numbers) {
    fuzz_require(std::fabs(number) <= max_urdf_number, "a number is in its range");
  }
}

void require_joint(const UrdfFile& file, std::size_t index) {
  const UrdfJoint& joint = file.joints[index];
  fuzz_require(joint.child == index + 1 && joint.parent < joint.child, "a link is behind its parent");
  require_numbers(joint.xyz);
  require_numbers(joint.rpy);
  require_numbers(joint.axis);
  fuzz_require(joint.axis != std::array<double, 3>{}, "an axis has a direction");
  const bool needs_limit = joint.kind == UrdfJointKind::revolute || joint.kind == UrdfJointKind::prismatic;
  fuzz_require(joint.limit.has_value() == needs_limit, "a joint with ends has limits");
  if (joint.limit) {
    fuzz_require(joint.limit->lower <= joint.limit->upper && joint.limit->velocity >= 0,
                 "limits are in order");
  }
  std::size_t steps = 0;
  for (const UrdfJoint* followed = &joint; followed->mimic; followed = &file.joints[followed->mimic->joint]) {
    fuzz_require(followed->mimic->joint < file.joints.size(), "a mimic follows a joint");
    fuzz_require(++steps <= file.joints.size(), "mimics are in no circle");
  }
}

void require_tree(const UrdfFile& file) {
  fuzz_require(!file.links.empty() && file.links.size() <= max_urdf_links, "links fit");
  fuzz_require(file.joints.size() + 1 == file.links.size(), "every link but the root has a joint");
  fuzz_require(std::set<std::string_view>(file.links.begin(), file.links.end()).size() == file.links.size(),
               "a link has a name of its own");
  for (std::size_t i = 0; i < file.joints.size(); ++i) require_joint(file, i);
}

}  // namespace
}  // namespace inbetween

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  return inbetween::fuzz_text(bytes, size, "any.urdf", [](std::string_view text, const char* file) {
    inbetween::require_tree(inbetween::parse_urdf(text, file));
  });
}
