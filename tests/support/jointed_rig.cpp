#include "tests/support/jointed_rig.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <map>

namespace inbetween {
namespace {

constexpr double far_away = 1000;

UrdfJointKind kind_of(OracleJointKind kind) {
  if (kind == OracleJointKind::fixed) return UrdfJointKind::fixed;
  return kind == OracleJointKind::revolute ? UrdfJointKind::continuous : UrdfJointKind::prismatic;
}

RigAxis axis_of(const std::string& name, UrdfJointKind kind) {
  RigAxis axis;
  axis.name = name;
  axis.unit = kind == UrdfJointKind::prismatic ? AxisUnit::m : AxisUnit::rad;
  axis.min = -far_away;
  axis.max = far_away;
  axis.max_velocity = 1;
  return axis;
}

}  // namespace

Kinematics kinematics_of(const std::vector<OracleJoint>& joints) {
  UrdfFile urdf;
  urdf.links = {"world"};
  RigFile rig;
  rig.kinematics = RigKinematics{};
  std::map<int, std::size_t> first_with;  // by coordinate
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const OracleJoint& from = joints[i];
    urdf.links.push_back(fmt::format("link_{}", i));
    UrdfJoint joint{.name = fmt::format("joint_{}", i),
                    .kind = kind_of(from.kind),
                    .parent = static_cast<std::size_t>(from.parent + 1),
                    .child = i + 1,
                    .xyz = from.xyz,
                    .rpy = from.rpy,
                    .axis = from.axis,
                    .limit = {},
                    .mimic = {},
                    .place = {}};
    if (joint.kind != UrdfJointKind::fixed) {
      const auto [followed, is_new] = first_with.try_emplace(from.coordinate, i);
      if (is_new) rig.axes.push_back(axis_of(joint.name, joint.kind));
      if (!is_new) joint.mimic = UrdfMimic{followed->second, from.factor, from.offset, {}};
    }
    urdf.joints.push_back(joint);
  }
  return {urdf, rig};
}

}  // namespace inbetween
