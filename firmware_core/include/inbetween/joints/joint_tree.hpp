#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/result.hpp"
#include "inbetween/joints/pose.hpp"

/// An articulated rig as a tree of links. Each link hangs on its parent by one joint. The coordinates are
/// what drives move; a joint follows one of them.

namespace inbetween {

enum class JointKind : std::uint8_t {
  fixed,
  revolute,   ///< turns about its axis, by an angle in radians
  prismatic,  ///< slides along its axis, by a distance in metres
};

/// A link and the joint by which it hangs on its parent. The value of the joint is factor * coordinate +
/// offset. The factor converts units (pi/180 for an axis in degrees), and several joints with factors of
/// their own may follow one coordinate (mimic joints).
struct Joint {
  JointKind kind = JointKind::fixed;
  /// The link it hangs on, an earlier one; -1 is the world.
  std::int32_t parent = -1;
  /// Which coordinate it follows; -1 exactly for a fixed joint.
  std::int32_t coordinate = -1;
  double factor = 1;
  double offset = 0;
  /// The frame of the link at joint value 0, in the frame of its parent.
  Pose origin = {};
  /// The axis is given in the frame of the link. It may have any length above 0.
  Vector3 axis = {0, 0, 1};
};

/// How a point of a link moves when one coordinate does: metres and radians per unit of the coordinate.
struct JacobianColumn {
  Vector3 linear;
  Vector3 angular;
};

/// The motion of a link in the world: of its origin (m, m/s, m/s^2) and of its turning (rad/s, rad/s^2).
struct LinkMotion {
  Pose pose;
  Vector3 velocity;
  Vector3 acceleration;
  Vector3 angular_velocity;
  Vector3 angular_acceleration;
};

/// A coordinate and its first two derivatives in time.
struct CoordinateMotion {
  double position = 0;
  double velocity = 0;
  double acceleration = 0;
};

/// A tree that exists is valid: parents stand before children, axes have length 1, frames are rotations. A
/// small value that refers to the caller's memory. A span of the wrong size is a defect of the caller and
/// ends the program.
class JointTree {
 public:
  /// Copies `joints` into `memory`, which needs as many places and stays alive as long as the tree.
  ///
  /// Errors, with the joint in Error::axis: not_finite, capacity, wrong_count (no joint, or a negative number
  /// of coordinates), out_of_range (a parent that is not an earlier link, a coordinate that is not there, an
  /// axis without length, an origin whose rotation is none, a place beyond 1e6 m). O(joints).
  static Result<JointTree> make(std::span<const Joint> joints, std::int32_t coordinate_count,
                                std::span<Joint> memory);

  /// Each joint has one link, in the same order.
  [[nodiscard]] std::span<const Joint> joints() const { return joints_; }
  [[nodiscard]] std::size_t coordinate_count() const { return coordinate_count_; }

  /// The pose of every link in the world, by transforms along each branch. `coordinates` has
  /// coordinate_count() entries and `poses` one for each link. Error: out_of_range with the coordinate in
  /// Error::axis, for an angle beyond max_angle or a distance beyond 1e6 m; `poses` is then to be ignored.
  /// O(joints), about 0.15 us a joint on a desktop.
  Status poses(std::span<const double> coordinates, std::span<Pose> poses) const;

  /// The Jacobian of a link's origin, one column for each coordinate, from the poses of all links. O(length
  /// of the branch + coordinates).
  void jacobian(std::int32_t link, std::span<const Pose> poses, std::span<JacobianColumn> columns) const;

  /// The motion of every link in the world: pose, velocity and acceleration, by the recursion from the root
  /// of Luh, Walker and Paul (1980). Errors as for poses(); derivatives are not checked. O(joints).
  Status motion(std::span<const CoordinateMotion> coordinates, std::span<LinkMotion> links) const;

  /// Whether the coordinate moves the link.
  [[nodiscard]] bool moves(std::int32_t coordinate, std::int32_t link) const;

 private:
  JointTree() = default;

  std::span<const Joint> joints_;
  std::size_t coordinate_count_ = 0;
};

/// Memory for a tree of up to `Links` links.
template <std::size_t Links>
using JointStorage = std::array<Joint, Links>;

}  // namespace inbetween
