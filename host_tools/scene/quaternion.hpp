// Rotations as quaternions, which is how scenes of other programs have them.
#pragma once

#include "inbetween/joints/pose.hpp"

namespace inbetween {

/// w + xi + yj + zk. One of length 1 is a rotation, and so is its negative: the same one.
struct Quaternion {
  double x = 0, y = 0, z = 0, w = 1;

  friend constexpr bool operator==(const Quaternion&, const Quaternion&) = default;
};

constexpr double dot(const Quaternion& a, const Quaternion& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w;
}
constexpr Quaternion negative(const Quaternion& q) {
  return {-q.x, -q.y, -q.z, -q.w};
}

/// Shepperd's method (1978): no root of a small number, so that it is good to rounding at every angle. Of
/// length 1, with w >= 0.
Quaternion quaternion_of(const Rotation3& rotation);

/// Of a quaternion of any length above 0.
Rotation3 rotation_of(const Quaternion& quaternion);

/// `q` or its negative: the one from which `before` is the shorter way.
Quaternion nearer_sign(const Quaternion& q, const Quaternion& before);

/// Spherical linear interpolation the shorter way round (Shoemake 1985), 0 <= share <= 1, of quaternions of
/// any length above 0. Half a turn goes as the signs say. Those that are nearly the same are interpolated on
/// a straight line.
Quaternion slerp(const Quaternion& first, const Quaternion& last, double share);

/// By which angle one must be turned to be the other (rad, 0 to pi); good to rounding near 0 too.
double rotation_angle(const Rotation3& a, const Rotation3& b);

}  // namespace inbetween
