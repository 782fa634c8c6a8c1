#pragma once

#include <cstdint>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/result.hpp"
#include "inbetween/joints/pose.hpp"

/// Joint angles in closed form, for the two mechanisms that every camera rig and puppet has: the arm of two
/// joints in a plane, and the head that pans and tilts.

namespace inbetween {

/// Two links in the plane x y. The shoulder is at the origin; at angles 0 both links lie along x.
struct TwoJointArm {
  double upper = 1;    ///< shoulder to elbow, m, above 0
  double forearm = 1;  ///< elbow to hand, m, above 0
};

/// On which side of the line from the shoulder to the hand the elbow is, seen along that line. With the hand
/// at the right, where x is positive, left is up.
enum class ElbowSide : std::uint8_t { left, right };

/// Both angles are in radians. The shoulder lies between -2 pi and 2 pi, the elbow between -pi and pi. An
/// elbow above 0 is on the right, one below 0 on the left.
struct ArmAngles {
  double shoulder = 0;
  double elbow = 0;
};

/// How far a point at this distance from the shoulder is from what the hand can reach (m): above 0 where it
/// is too far, below 0 where it is too close, 0 within.
double beyond_reach(const TwoJointArm& arm, double distance);

/// The angles that put the hand on (x, y), by the tangent of half the elbow's angle, which keeps its digits
/// where the arm is almost stretched or folded. There the two sides meet, and the angles change as the root
/// of the distance to the edge. Errors: not_finite, out_of_range (a link that is not longer than 0),
/// no_solution (beyond the reach: beyond_reach() tells how far), singular (the hand on the shoulder: every
/// direction of the shoulder is one).
Result<ArmAngles> arm_angles(const TwoJointArm& arm, double x, double y, ElbowSide side);

/// Both angles are in radians. Pan turns about z, from x towards y, and lies between -pi and pi. Tilt rises
/// towards z and lies between -pi/2 and pi/2.
struct PanTilt {
  double pan = 0;
  double tilt = 0;
};

/// The angles at which a head at the origin looks at a point. Errors: not_finite, singular (the point is on
/// the axis of the pan, which then may be anything).
Result<PanTilt> aim_at(const Vector3& point);

}  // namespace inbetween
