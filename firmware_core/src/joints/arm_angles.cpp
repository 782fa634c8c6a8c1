#include "inbetween/joints/arm_angles.hpp"

#include <array>
#include <cmath>

#include "base/scaled_norm.hpp"
#include "inbetween/joints/angle_of.hpp"
#include "inbetween/joints/sine_cosine.hpp"

namespace inbetween {
namespace {

constexpr Error not_finite{.code = ErrorCode::not_finite,
                           .what = "a place or a length is not finite",
                           .remedy = "use finite numbers"};

double distance_of(double x, double y) {
  const std::array components{x, y};
  return scaled_norm(2, [&](std::size_t i) { return components[i]; });
}

}  // namespace

double beyond_reach(const TwoJointArm& arm, double distance) {
  const double farthest = arm.upper + arm.forearm;
  const double nearest = std::fabs(arm.upper - arm.forearm);
  if (distance > farthest) return distance - farthest;
  return distance < nearest ? distance - nearest : 0;
}

Result<ArmAngles> arm_angles(const TwoJointArm& arm, double x, double y, ElbowSide side) {
  if (!std::isfinite(x) || !std::isfinite(y) || !std::isfinite(arm.upper) || !std::isfinite(arm.forearm)) {
    return not_finite;
  }
  if (arm.upper <= 0 || arm.forearm <= 0) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "a link of the arm has no length",
                 .remedy = "give both links a length above 0"};
  }
  const double distance = distance_of(x, y);
  if (beyond_reach(arm, distance) != 0) {
    return Error{.code = ErrorCode::no_solution,
                 .what = "the place is beyond the reach of the arm",
                 .remedy = "move it nearer, or farther from the shoulder"};
  }
  if (distance == 0) {
    return Error{.code = ErrorCode::singular,
                 .what = "the hand is on the shoulder, whose direction may then be any",
                 .remedy = "lead the path round the shoulder"};
  }
  const double to_farthest = (arm.upper + arm.forearm - distance) * (arm.upper + arm.forearm + distance);
  const double difference = std::fabs(arm.upper - arm.forearm);
  const double to_nearest = (distance - difference) * (distance + difference);
  const double bend = 2 * angle_of(std::sqrt(to_nearest), std::sqrt(to_farthest));
  ArmAngles angles;
  angles.elbow = side == ElbowSide::right ? bend : -bend;
  const SineCosine elbow = sine_cosine(angles.elbow);
  angles.shoulder =
      angle_of(x, y) - angle_of(arm.upper + arm.forearm * elbow.cosine, arm.forearm * elbow.sine);
  return angles;
}

Result<PanTilt> aim_at(const Vector3& point) {
  if (!std::isfinite(point.x) || !std::isfinite(point.y) || !std::isfinite(point.z)) return not_finite;
  const double level = distance_of(point.x, point.y);
  if (level == 0) {
    return Error{.code = ErrorCode::singular,
                 .what = "the point is on the axis of the pan, which may then be anything",
                 .remedy = "aim past the axis"};
  }
  return PanTilt{angle_of(point.x, point.y), angle_of(level, point.z)};
}

}  // namespace inbetween
