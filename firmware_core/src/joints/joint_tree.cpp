#include "inbetween/joints/joint_tree.hpp"

#include <algorithm>
#include <cmath>

#include "base/scaled_norm.hpp"

namespace inbetween {
namespace {

/// Nothing that people build reaches farther (m). It keeps every product far from overflow.
constexpr double max_distance = 1e6;

/// How far the axes of an origin may be from length 1 and from perpendicular. Matrices made from angles
/// are within 1e-15; what is farther off is not a rotation.
constexpr double rotation_tolerance = 1e-9;

bool is_finite(const Vector3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

bool is_finite(const Joint& joint) {
  const Rotation3& rotation = joint.origin.rotation;
  return std::isfinite(joint.factor) && std::isfinite(joint.offset) && is_finite(joint.axis) &&
         is_finite(joint.origin.position) && is_finite(rotation.x) && is_finite(rotation.y) &&
         is_finite(rotation.z);
}

double length(const Vector3& v) {
  const std::array components{v.x, v.y, v.z};
  return scaled_norm(3, [&](std::size_t i) { return components[i]; });
}

bool is_rotation(const Rotation3& rotation) {
  const Vector3 z = cross(rotation.x, rotation.y);
  const auto within = [](double error) { return std::fabs(error) <= rotation_tolerance; };
  return within(dot(rotation.x, rotation.x) - 1) && within(dot(rotation.y, rotation.y) - 1) &&
         within(dot(rotation.x, rotation.y)) && within(z.x - rotation.z.x) && within(z.y - rotation.z.y) &&
         within(z.z - rotation.z.z);
}

Error wrong_joint(std::size_t joint, ErrorCode code, const char* what, const char* remedy) {
  return {.code = code, .what = what, .remedy = remedy, .axis = static_cast<std::int32_t>(joint)};
}

Status check(const Joint& joint, std::size_t index, std::int32_t coordinate_count) {
  if (!is_finite(joint)) {
    return wrong_joint(index, ErrorCode::not_finite, "a joint has a number that is not finite",
                       "use finite numbers");
  }
  if (joint.parent < -1 || joint.parent >= static_cast<std::int32_t>(index)) {
    return wrong_joint(index, ErrorCode::out_of_range, "the parent of a link does not stand before it",
                       "put parents before their children");
  }
  const bool is_fixed = joint.kind == JointKind::fixed;
  if (is_fixed ? joint.coordinate != -1 : joint.coordinate < 0 || joint.coordinate >= coordinate_count) {
    return wrong_joint(index, ErrorCode::out_of_range, "a joint follows a coordinate that is not there",
                       "use coordinates from 0 to their number less one, and -1 for a fixed joint");
  }
  if (!is_fixed && length(joint.axis) == 0) {
    return wrong_joint(index, ErrorCode::out_of_range, "the axis of a joint has no length",
                       "give it a direction, such as 0 0 1");
  }
  if (!is_rotation(joint.origin.rotation)) {
    return wrong_joint(index, ErrorCode::out_of_range, "the rotation of an origin is none",
                       "use right-handed perpendicular axes of length 1");
  }
  if (length(joint.origin.position) > max_distance) {
    return wrong_joint(index, ErrorCode::out_of_range, "a link is more than 1e6 m from its parent",
                       "use metres");
  }
  return Done{};
}

Vector3 with_length_1(const Vector3& v) {
  // The largest component first: the length of a tiny vector would lose digits.
  const double largest = std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
  const Vector3 scaled{v.x / largest, v.y / largest, v.z / largest};
  const double norm = std::sqrt(dot(scaled, scaled));
  return {scaled.x / norm, scaled.y / norm, scaled.z / norm};
}

/// A joint value, in radians or metres.
Result<double> value_of(const Joint& joint, double coordinate) {
  if (joint.kind == JointKind::fixed) return 0.0;
  const double value = joint.factor * coordinate + joint.offset;
  const double limit = joint.kind == JointKind::revolute ? max_angle : max_distance;
  // Negated, so that a value that is not a number is refused too.
  if (!(std::fabs(value) <= limit)) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "a joint is farther from its zero than can be computed",
                 .remedy = "keep it within max_angle radians and 1e6 m",
                 .axis = joint.coordinate};
  }
  return value;
}

/// The frame of the link in the frame of its parent.
Pose local_pose(const Joint& joint, double value) {
  switch (joint.kind) {
    case JointKind::revolute:
      return {joint.origin.rotation * turned_about(joint.axis, sine_cosine(value)), joint.origin.position};
    case JointKind::prismatic:
      return {joint.origin.rotation, joint.origin * (joint.axis * value)};
    case JointKind::fixed:
      break;
  }
  return joint.origin;
}

/// What holds the links that hang on nothing.
template <class Link>
Link parent_of(std::span<const Link> links, std::int32_t parent) {
  return parent < 0 ? Link{} : links[static_cast<std::size_t>(parent)];
}

/// The motion of a link whose frame turns and moves with its parent, at `pose`.
LinkMotion carried(const LinkMotion& parent, const Pose& pose) {
  const Vector3 arm = pose.position - parent.pose.position;
  const Vector3 turning = cross(parent.angular_velocity, arm);
  return {
      pose, parent.velocity + turning,
      parent.acceleration + cross(parent.angular_acceleration, arm) + cross(parent.angular_velocity, turning),
      parent.angular_velocity, parent.angular_acceleration};
}

/// Adds what the link's own joint does, whose value has these derivatives.
void add_joint(const Joint& joint, double first, double second, LinkMotion& link) {
  if (joint.kind == JointKind::fixed) return;
  // A turn about the axis leaves the axis where it is: the frame of the link has it at any value.
  const Vector3 axis = link.pose.rotation * joint.axis;
  const Vector3 carried_along = cross(link.angular_velocity, axis * first);
  if (joint.kind == JointKind::revolute) {
    link.angular_acceleration += axis * second + carried_along;
    link.angular_velocity += axis * first;
  } else {
    link.velocity += axis * first;
    link.acceleration += axis * second + carried_along * 2;
  }
}

}  // namespace

Result<JointTree> JointTree::make(std::span<const Joint> joints, std::int32_t coordinate_count,
                                  std::span<Joint> memory) {
  if (joints.empty() || coordinate_count < 0) {
    return Error{.code = ErrorCode::wrong_count,
                 .what = "a tree has no link or a negative number of coordinates",
                 .remedy = "give it a link"};
  }
  if (memory.size() < joints.size()) {
    return Error{.code = ErrorCode::capacity,
                 .what = "the memory of a joint tree is too small",
                 .remedy = "give it a place for every link",
                 .needed = static_cast<std::int64_t>(joints.size())};
  }
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (const Status checked = check(joints[i], i, coordinate_count); !checked) return checked.error();
    memory[i] = joints[i];
    if (joints[i].kind != JointKind::fixed) memory[i].axis = with_length_1(joints[i].axis);
  }
  JointTree tree;
  tree.joints_ = memory.first(joints.size());
  tree.coordinate_count_ = static_cast<std::size_t>(coordinate_count);
  return tree;
}

Status JointTree::poses(std::span<const double> coordinates, std::span<Pose> poses) const {
  if (coordinates.size() != coordinate_count_ || poses.size() != joints_.size()) __builtin_trap();
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const Joint& joint = joints_[i];
    const double coordinate =
        joint.coordinate < 0 ? 0 : coordinates[static_cast<std::size_t>(joint.coordinate)];
    const Result<double> value = value_of(joint, coordinate);
    if (!value) return value.error();
    poses[i] = parent_of<Pose>(poses, joint.parent) * local_pose(joint, *value);
  }
  return Done{};
}

void JointTree::jacobian(std::int32_t link, std::span<const Pose> poses,
                         std::span<JacobianColumn> columns) const {
  if (columns.size() != coordinate_count_ || poses.size() != joints_.size()) __builtin_trap();
  std::ranges::fill(columns, JacobianColumn{});
  const Vector3 tip = poses[static_cast<std::size_t>(link)].position;
  for (std::int32_t i = link; i >= 0; i = joints_[static_cast<std::size_t>(i)].parent) {
    const Joint& joint = joints_[static_cast<std::size_t>(i)];
    if (joint.kind == JointKind::fixed) continue;
    const Pose& pose = poses[static_cast<std::size_t>(i)];
    JacobianColumn& column = columns[static_cast<std::size_t>(joint.coordinate)];
    const Vector3 per_unit = (pose.rotation * joint.axis) * joint.factor;
    if (joint.kind == JointKind::revolute) {
      column.linear += cross(per_unit, tip - pose.position);
      column.angular += per_unit;
    } else {
      column.linear += per_unit;
    }
  }
}

Status JointTree::motion(std::span<const CoordinateMotion> coordinates, std::span<LinkMotion> links) const {
  if (coordinates.size() != coordinate_count_ || links.size() != joints_.size()) __builtin_trap();
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const Joint& joint = joints_[i];
    const CoordinateMotion coordinate =
        joint.coordinate < 0 ? CoordinateMotion{} : coordinates[static_cast<std::size_t>(joint.coordinate)];
    const Result<double> value = value_of(joint, coordinate.position);
    if (!value) return value.error();
    const LinkMotion parent = parent_of<LinkMotion>(links, joint.parent);
    links[i] = carried(parent, parent.pose * local_pose(joint, *value));
    add_joint(joint, joint.factor * coordinate.velocity, joint.factor * coordinate.acceleration, links[i]);
  }
  return Done{};
}

bool JointTree::moves(std::int32_t coordinate, std::int32_t link) const {
  for (std::int32_t i = link; i >= 0; i = joints_[static_cast<std::size_t>(i)].parent) {
    if (joints_[static_cast<std::size_t>(i)].coordinate == coordinate) return coordinate >= 0;
  }
  return false;
}

}  // namespace inbetween
