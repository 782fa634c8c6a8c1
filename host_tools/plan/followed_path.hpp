// A path of axes together with the path of a link in space: one of the two is drawn, the other follows. The
// distance along it is that of the link, so that the drawn speed is the speed in space.
//
// What follows is known at the places where somebody solves for it, and interpolated between them by cubics
// that join as smoothly as what is drawn. The places are made denser until the bounds of tip_deviation.hpp
// are small.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "host_tools/joints/kinematics.hpp"
#include "inbetween/path/path.hpp"

namespace inbetween {

/// Proven everywhere on the path, up to the rounding of double.
struct FollowAccuracy {
  double off_m = 0;  // between the link and where it is drawn
  /// Of the drawn speed, or of a hundredth of the fastest between the keys if that is more.
  double speed_share = 0;
  bool is_share_of_fastest = false;  // it is of the fastest of the whole path
  double aim_rad = 0;                // between where the link looks and the point it is aimed at
};

/// Bounds that are good enough.
struct FollowTolerance {
  double off_m = 0;
  double speed_share = 2e-5;
  double aim_rad = 2e-5;
};

struct FollowedPath {
  std::vector<Cubic> cubics;  // segment after segment: the axes, then the guides
  std::vector<double> weights;
  std::vector<FrameKnot> knots;
  FollowAccuracy accuracy;
};

/// The rows that are not drawn.
struct Follower {
  using Row = std::vector<double>;
  /// Called at places in the order of the path, again from its start when they are made denser.
  std::function<Row(const PathPoint&)> at;
  /// Their derivatives by t there, after at().
  std::function<Row(const PathPoint&)> slope;
  /// The derivatives of what follows are not known by slope(): it goes on by what is natural to it.
  bool has_slopes = true;
};

/// How the rows of the two make a path: indexes of drawn rows, and behind them of those that follow.
struct FollowLayout {
  std::vector<std::size_t> axes;
  std::vector<std::size_t> guides;    // x, y, z of what the distance is measured on
  std::vector<std::size_t> position;  // x, y, z where the link is drawn to be; empty: nowhere
  std::vector<std::size_t> aim;       // x, y, z; empty: nowhere
};

/// A part of a segment on which the bounds do not become small enough.
struct FollowObstacle {
  PathPoint where;      // of the drawn path
  std::size_t row = 0;  // of those that follow, the one that turns most there
};

/// `is_smooth`: what is drawn is C2 over centripetal knots, and so is what follows; otherwise it is C1 where
/// the drawn path is. Calls `refuse`, which throws, where the bounds stay too large.
FollowedPath followed_path(const Path& drawn, bool is_smooth, const Follower& follower,
                           const FollowLayout& layout, const Kinematics& kinematics, std::int32_t link,
                           const std::vector<std::size_t>& coordinates, const FollowTolerance& tolerance,
                           const std::function<void(const FollowObstacle&)>& refuse);

}  // namespace inbetween
