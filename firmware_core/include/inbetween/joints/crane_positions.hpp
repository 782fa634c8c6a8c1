#pragma once

#include "inbetween/base/precision.hpp"
#include "inbetween/base/result.hpp"
#include "inbetween/joints/pose.hpp"

/// Joint positions of a camera crane in closed form: track, swing and boom from the place of the head, then
/// pan, tilt and roll from the direction of the camera. Each of the two has all solutions that there are.
/// Directions have length 1 and are seen from the world, with every joint at 0.

namespace inbetween {

/// A carriage on a straight track, a column that swings, and a boom that rises. The head does not turn about
/// the boom's axis, or its centre is a point of the boom.
struct CameraCrane {
  Vector3 track;   ///< where the carriage slides to
  Vector3 column;  ///< the axis of the swing, square to the track
  Vector3 boom;    ///< the axis of the boom, square to the column
  Vector3 foot;    ///< a point of the column's axis (m)
  Vector3 level;   ///< what of the vector from the foot to the head swings and does not rise (m)
  Vector3 raised;  ///< what of it turns with the boom (m)
};

/// Which of four solutions. The boom leans forward in the direction column x boom.
struct CraneSides {
  bool leans_back = false;  ///< the boom is raised beyond the upright
  bool is_behind = false;   ///< the head is behind the foot, seen along the track
};

struct CranePositions {
  double track = 0;  ///< m
  double swing = 0;  ///< rad, from -2 pi to 2 pi
  double boom = 0;   ///< rad, from -2 pi to 2 pi
};

/// The positions that put the centre of the head on `head`. The height alone gives the boom, the distance
/// from the track the swing. Errors: not_finite, no_solution (higher, lower or farther from the track than
/// the boom reaches), singular (the head on the axis of the column, or no boom: any angle would do).
/// O(1), about 1000 operations.
Result<CranePositions> crane_positions(const CameraCrane& crane, const Vector3& head, CraneSides sides);

/// Axes through one point: the camera hangs on the roll, the roll on the tilt, the tilt on the pan. The axis
/// of the tilt is square to both others. A head without roll has the direction of the lens in its place.
struct CameraHead {
  Vector3 pan;
  Vector3 tilt;
  Vector3 roll;
};

/// In radians.
struct HeadAngles {
  double pan = 0;
  double tilt = 0;
  double roll = 0;
};

/// The angles that turn the head like this from where it is at 0. `over` is the solution whose tilt goes over
/// the top. Errors: not_finite, singular (the axis of the roll would be that of the pan). O(1), about 1200
/// operations.
Result<HeadAngles> head_angles(const CameraHead& head, const Rotation3& turn, bool over);

/// The same for a direction of the axis of the roll; the roll stays 0.
Result<HeadAngles> head_angles(const CameraHead& head, const Vector3& direction, bool over);

}  // namespace inbetween
