#pragma once

#include "inbetween/base/precision.hpp"
#include "inbetween/joints/sine_cosine.hpp"

/// Vectors, rotations and poses in space: right-handed, x y z.

namespace inbetween {

struct Vector3 {
  double x = 0, y = 0, z = 0;

  friend constexpr bool operator==(const Vector3&, const Vector3&) = default;
  friend constexpr Vector3 operator+(const Vector3& a, const Vector3& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
  }
  friend constexpr Vector3 operator-(const Vector3& a, const Vector3& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  friend constexpr Vector3 operator*(const Vector3& v, double factor) {
    return {v.x * factor, v.y * factor, v.z * factor};
  }
  constexpr Vector3& operator+=(const Vector3& other) { return *this = *this + other; }
};

constexpr double dot(const Vector3& a, const Vector3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

constexpr Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// A turned frame, by its axes as the frame outside sees them. They are of length 1 and perpendicular.
struct Rotation3 {
  Vector3 x{1, 0, 0};
  Vector3 y{0, 1, 0};
  Vector3 z{0, 0, 1};

  friend constexpr bool operator==(const Rotation3&, const Rotation3&) = default;
  /// A vector of the turned frame, as the frame outside sees it.
  friend constexpr Vector3 operator*(const Rotation3& turned, const Vector3& v) {
    return turned.x * v.x + turned.y * v.y + turned.z * v.z;
  }
  friend constexpr Rotation3 operator*(const Rotation3& outer, const Rotation3& inner) {
    return {outer * inner.x, outer * inner.y, outer * inner.z};
  }
};

/// The frame outside, as the turned frame sees it.
constexpr Rotation3 inverse(const Rotation3& turned) {
  const auto& [x, y, z] = turned;
  return {{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}};
}

/// A frame turned by an angle about an axis of length 1 (Rodrigues' formula).
constexpr Rotation3 turned_about(const Vector3& axis, const SineCosine& angle) {
  const Vector3 s = axis * angle.sine;
  const Vector3 u = axis * (1 - angle.cosine);
  const double c = angle.cosine;
  return {{u.x * axis.x + c, u.x * axis.y + s.z, u.x * axis.z - s.y},
          {u.y * axis.x - s.z, u.y * axis.y + c, u.y * axis.z + s.x},
          {u.z * axis.x + s.y, u.z * axis.y - s.x, u.z * axis.z + c}};
}

/// A frame in space: how it is turned and where its origin is (m).
struct Pose {
  Rotation3 rotation;
  Vector3 position;

  friend constexpr bool operator==(const Pose&, const Pose&) = default;
  /// A point of the frame, as the frame outside sees it.
  friend constexpr Vector3 operator*(const Pose& pose, const Vector3& point) {
    return pose.rotation * point + pose.position;
  }
  friend constexpr Pose operator*(const Pose& outer, const Pose& inner) {
    return {outer.rotation * inner.rotation, outer * inner.position};
  }
};

}  // namespace inbetween
