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

template <Precise Real>
Real distance_of(Real x, Real y) {
  const std::array components{x, y};
  return scaled_norm<Real>(2, [&](std::size_t i) { return components[i]; });
}

}  // namespace

template <Precise Real>
Real beyond_reach(const TwoJointArm<Real>& arm, Real distance) {
  const Real farthest = arm.upper + arm.forearm;
  const Real nearest = std::fabs(arm.upper - arm.forearm);
  if (distance > farthest) return distance - farthest;
  return distance < nearest ? distance - nearest : 0;
}

template <Precise Real>
Result<ArmAngles<Real>> arm_angles(const TwoJointArm<Real>& arm, Real x, Real y, ElbowSide side) {
  if (!std::isfinite(x) || !std::isfinite(y) || !std::isfinite(arm.upper) || !std::isfinite(arm.forearm)) {
    return not_finite;
  }
  if (arm.upper <= 0 || arm.forearm <= 0) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "a link of the arm has no length",
                 .remedy = "give both links a length above 0"};
  }
  const Real distance = distance_of(x, y);
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
  const Real to_farthest = (arm.upper + arm.forearm - distance) * (arm.upper + arm.forearm + distance);
  const Real difference = std::fabs(arm.upper - arm.forearm);
  const Real to_nearest = (distance - difference) * (distance + difference);
  const Real bend = 2 * angle_of(std::sqrt(to_nearest), std::sqrt(to_farthest));
  ArmAngles<Real> angles;
  angles.elbow = side == ElbowSide::right ? bend : -bend;
  const SineCosine<Real> elbow = sine_cosine(angles.elbow);
  angles.shoulder =
      angle_of(x, y) - angle_of(arm.upper + arm.forearm * elbow.cosine, arm.forearm * elbow.sine);
  return angles;
}

template <Precise Real>
Result<PanTilt<Real>> aim_at(const Vector3<Real>& point) {
  if (!std::isfinite(point.x) || !std::isfinite(point.y) || !std::isfinite(point.z)) return not_finite;
  const Real level = distance_of(point.x, point.y);
  if (level == 0) {
    return Error{.code = ErrorCode::singular,
                 .what = "the point is on the axis of the pan, which may then be anything",
                 .remedy = "aim past the axis"};
  }
  return PanTilt<Real>{angle_of(point.x, point.y), angle_of(level, point.z)};
}

template double beyond_reach(const TwoJointArm<double>&, double);
template float beyond_reach(const TwoJointArm<float>&, float);
template Result<ArmAngles<double>> arm_angles(const TwoJointArm<double>&, double, double, ElbowSide);
template Result<ArmAngles<float>> arm_angles(const TwoJointArm<float>&, float, float, ElbowSide);
template Result<PanTilt<double>> aim_at(const Vector3<double>&);
template Result<PanTilt<float>> aim_at(const Vector3<float>&);

}  // namespace inbetween
