#include "host_tools/scene/quaternion.hpp"

#include <algorithm>
#include <cmath>

namespace inbetween {
namespace {

Quaternion of_length_one(const Quaternion& q) {
  const double length = std::sqrt(dot(q, q));
  return {q.x / length, q.y / length, q.z / length, q.w / length};
}

}  // namespace

Quaternion quaternion_of(const Rotation3& rotation) {
  const auto& [x, y, z] = rotation;  // columns of the matrix
  // The largest of four squares is at least a quarter of their sum, and what is divided by is its root.
  const double of_w = x.x + y.y + z.z;
  const double largest = std::max({of_w, x.x, y.y, z.z});
  Quaternion q;
  if (largest == of_w) {
    q = {y.z - z.y, z.x - x.z, x.y - y.x, 1 + of_w};
  } else if (largest == x.x) {
    q = {1 + x.x - y.y - z.z, x.y + y.x, z.x + x.z, y.z - z.y};
  } else if (largest == y.y) {
    q = {x.y + y.x, 1 - x.x + y.y - z.z, y.z + z.y, z.x - x.z};
  } else {
    q = {z.x + x.z, y.z + z.y, 1 - x.x - y.y + z.z, x.y - y.x};
  }
  q = of_length_one(q);
  return q.w < 0 ? negative(q) : q;
}

Rotation3 rotation_of(const Quaternion& quaternion) {
  const auto [x, y, z, w] = of_length_one(quaternion);
  return {{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
          {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
          {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)}};
}

Quaternion nearer_sign(const Quaternion& q, const Quaternion& before) {
  return dot(q, before) < 0 ? negative(q) : q;
}

Quaternion slerp(const Quaternion& first, const Quaternion& last, double share) {
  const Quaternion from = of_length_one(first);
  const Quaternion end = nearer_sign(of_length_one(last), from);
  const double cosine = std::min(1.0, dot(from, end));
  // Below this angle the sine that is divided by has lost digits, and a straight line is off by less.
  constexpr double nearly_one = 1 - 1e-10;
  double a = 1 - share;
  double b = share;
  if (cosine < nearly_one) {
    const double angle = std::acos(cosine);
    a = std::sin((1 - share) * angle) / std::sin(angle);
    b = std::sin(share * angle) / std::sin(angle);
  }
  return of_length_one(
      {a * from.x + b * end.x, a * from.y + b * end.y, a * from.z + b * end.z, a * from.w + b * end.w});
}

double rotation_angle(const Rotation3& a, const Rotation3& b) {
  const auto [x, y, z] = inverse(a) * b;
  const double sine = std::hypot(y.z - z.y, z.x - x.z, x.y - y.x) / 2;
  const double cosine = (x.x + y.y + z.z - 1) / 2;
  return std::atan2(sine, cosine);
}

}  // namespace inbetween
