// What is asked of a link in space, and of which axes.
#pragma once

#include <cstddef>
#include <optional>

#include "inbetween/joints/pose.hpp"

namespace inbetween {

/// Where a link is asked to be, in the world (m). Its x axis is the one that looks: the lens of a camera.
struct TipTarget {
  std::optional<Vector3> position = {};
  /// The point at which the link looks.
  std::optional<Vector3> aim = {};
  /// How far the link is turned about its x axis (rad); at 0 its y axis is level and its z axis points up.
  std::optional<double> roll = {};
};

/// How a target moves: of each, its derivative.
using TipTargetRate = TipTarget;

/// An axis that may be moved for it.
struct TipAxis {
  std::size_t axis = 0;  // coordinate of the tree
  double min = 0;
  double max = 0;
  double near = 0;  // where a solution is sought first
};

}  // namespace inbetween
