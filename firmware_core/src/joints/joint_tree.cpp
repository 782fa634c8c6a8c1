#include "inbetween/joints/joint_tree.hpp"

#include <algorithm>
#include <cmath>

#include "base/scaled_norm.hpp"

namespace inbetween {
namespace {

/// Nothing that people build reaches farther (m). It keeps every product far from overflow.
template <Precise Real>
constexpr Real max_way = static_cast<Real>(1e6);

/// How far the axes of an origin may be from length 1 and from perpendicular. Matrices made from angles in
/// the same precision are within 1e-15 or 1e-6; what is farther off is not a rotation.
template <Precise Real>
constexpr Real rotation_tolerance = static_cast<Real>(1e-9);
template <>
constexpr float rotation_tolerance<float> = 1e-5F;

template <Precise Real>
bool is_finite(const Vector3<Real>& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

template <Precise Real>
bool is_finite(const Joint<Real>& joint) {
  const Rotation3<Real>& rotation = joint.origin.rotation;
  return std::isfinite(joint.factor) && std::isfinite(joint.offset) && is_finite(joint.axis) &&
         is_finite(joint.origin.position) && is_finite(rotation.x) && is_finite(rotation.y) &&
         is_finite(rotation.z);
}

template <Precise Real>
Real length(const Vector3<Real>& v) {
  const std::array components{v.x, v.y, v.z};
  return scaled_norm<Real>(3, [&](std::size_t i) { return components[i]; });
}

template <Precise Real>
bool is_rotation(const Rotation3<Real>& rotation) {
  const Vector3<Real> z = cross(rotation.x, rotation.y);
  const auto within = [](Real error) { return std::fabs(error) <= rotation_tolerance<Real>; };
  return within(dot(rotation.x, rotation.x) - 1) && within(dot(rotation.y, rotation.y) - 1) &&
         within(dot(rotation.x, rotation.y)) && within(z.x - rotation.z.x) && within(z.y - rotation.z.y) &&
         within(z.z - rotation.z.z);
}

Error wrong_joint(std::size_t joint, ErrorCode code, const char* what, const char* remedy) {
  return {.code = code, .what = what, .remedy = remedy, .axis = static_cast<std::int32_t>(joint)};
}

template <Precise Real>
Status check(const Joint<Real>& joint, std::size_t index, std::int32_t coordinate_count) {
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
  if (length(joint.origin.position) > max_way<Real>) {
    return wrong_joint(index, ErrorCode::out_of_range, "a link is more than 1e6 m from its parent",
                       "use metres");
  }
  return Done{};
}

template <Precise Real>
Vector3<Real> with_length_1(const Vector3<Real>& v) {
  // The largest component first: the length of a tiny vector would lose digits.
  const Real largest = std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
  const Vector3<Real> scaled{v.x / largest, v.y / largest, v.z / largest};
  const Real norm = std::sqrt(dot(scaled, scaled));
  return {scaled.x / norm, scaled.y / norm, scaled.z / norm};
}

/// A joint value, in radians or metres.
template <Precise Real>
Result<Real> value_of(const Joint<Real>& joint, Real coordinate) {
  if (joint.kind == JointKind::fixed) return Real(0);
  const Real value = joint.factor * coordinate + joint.offset;
  const Real limit = joint.kind == JointKind::revolute ? max_angle<Real> : max_way<Real>;
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
template <Precise Real>
Pose<Real> local_pose(const Joint<Real>& joint, Real value) {
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
template <Precise Real>
LinkMotion<Real> carried(const LinkMotion<Real>& parent, const Pose<Real>& pose) {
  const Vector3<Real> arm = pose.position - parent.pose.position;
  const Vector3<Real> turning = cross(parent.angular_velocity, arm);
  return {
      pose, parent.velocity + turning,
      parent.acceleration + cross(parent.angular_acceleration, arm) + cross(parent.angular_velocity, turning),
      parent.angular_velocity, parent.angular_acceleration};
}

/// Adds what the link's own joint does, whose value has these derivatives.
template <Precise Real>
void add_joint(const Joint<Real>& joint, Real first, Real second, LinkMotion<Real>& link) {
  if (joint.kind == JointKind::fixed) return;
  // A turn about the axis leaves the axis where it is: the frame of the link has it at any value.
  const Vector3<Real> axis = link.pose.rotation * joint.axis;
  const Vector3<Real> carried_along = cross(link.angular_velocity, axis * first);
  if (joint.kind == JointKind::revolute) {
    link.angular_acceleration += axis * second + carried_along;
    link.angular_velocity += axis * first;
  } else {
    link.velocity += axis * first;
    link.acceleration += axis * second + carried_along * 2;
  }
}

}  // namespace

template <Precise Real>
Result<JointTree<Real>> JointTree<Real>::make(std::span<const Joint<Real>> joints,
                                              std::int32_t coordinate_count, std::span<Joint<Real>> memory) {
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

template <Precise Real>
Status JointTree<Real>::poses(std::span<const Real> coordinates, std::span<Pose<Real>> poses) const {
  if (coordinates.size() != coordinate_count_ || poses.size() != joints_.size()) __builtin_trap();
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const Joint<Real>& joint = joints_[i];
    const Real coordinate =
        joint.coordinate < 0 ? 0 : coordinates[static_cast<std::size_t>(joint.coordinate)];
    const Result<Real> value = value_of(joint, coordinate);
    if (!value) return value.error();
    poses[i] = parent_of<Pose<Real>>(poses, joint.parent) * local_pose(joint, *value);
  }
  return Done{};
}

template <Precise Real>
void JointTree<Real>::jacobian(std::int32_t link, std::span<const Pose<Real>> poses,
                               std::span<JacobianColumn<Real>> columns) const {
  if (columns.size() != coordinate_count_ || poses.size() != joints_.size()) __builtin_trap();
  std::ranges::fill(columns, JacobianColumn<Real>{});
  const Vector3<Real> tip = poses[static_cast<std::size_t>(link)].position;
  for (std::int32_t i = link; i >= 0; i = joints_[static_cast<std::size_t>(i)].parent) {
    const Joint<Real>& joint = joints_[static_cast<std::size_t>(i)];
    if (joint.kind == JointKind::fixed) continue;
    const Pose<Real>& pose = poses[static_cast<std::size_t>(i)];
    JacobianColumn<Real>& column = columns[static_cast<std::size_t>(joint.coordinate)];
    const Vector3<Real> per_unit = (pose.rotation * joint.axis) * joint.factor;
    if (joint.kind == JointKind::revolute) {
      column.linear += cross(per_unit, tip - pose.position);
      column.angular += per_unit;
    } else {
      column.linear += per_unit;
    }
  }
}

template <Precise Real>
Status JointTree<Real>::motion(std::span<const CoordinateMotion<Real>> coordinates,
                               std::span<LinkMotion<Real>> links) const {
  if (coordinates.size() != coordinate_count_ || links.size() != joints_.size()) __builtin_trap();
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const Joint<Real>& joint = joints_[i];
    const CoordinateMotion<Real> coordinate = joint.coordinate < 0
                                                  ? CoordinateMotion<Real>{}
                                                  : coordinates[static_cast<std::size_t>(joint.coordinate)];
    const Result<Real> value = value_of(joint, coordinate.position);
    if (!value) return value.error();
    const LinkMotion<Real> parent = parent_of<LinkMotion<Real>>(links, joint.parent);
    links[i] = carried(parent, parent.pose * local_pose(joint, *value));
    add_joint(joint, joint.factor * coordinate.velocity, joint.factor * coordinate.acceleration, links[i]);
  }
  return Done{};
}

template <Precise Real>
bool JointTree<Real>::moves(std::int32_t coordinate, std::int32_t link) const {
  for (std::int32_t i = link; i >= 0; i = joints_[static_cast<std::size_t>(i)].parent) {
    if (joints_[static_cast<std::size_t>(i)].coordinate == coordinate) return coordinate >= 0;
  }
  return false;
}

template class JointTree<double>;
template class JointTree<float>;

}  // namespace inbetween
