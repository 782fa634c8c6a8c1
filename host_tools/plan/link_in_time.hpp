// The path of a link through a move, by the tracks that move it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "host_tools/joints/kinematics.hpp"
#include "host_tools/plan/axes_in_space.hpp"
#include "inbetween/timing/track.hpp"
#include "inbetween/trajectory/axis_peaks.hpp"

namespace inbetween {

/// What drives a coordinate of the joint tree: an axis of a track, or nothing, and it stays where it is.
struct DrivenCoordinate {
  const Track* track = nullptr;
  std::size_t axis = 0;  // of the track
  double held = 0;
};

/// Bounds of velocity, acceleration and jerk of some axes of a track (units and seconds), and whether one of
/// them steps between the ends of the move.
struct TrackBounds {
  std::vector<AxisPeaks> peaks;  // of every axis of the path
  bool steps = false;
};
TrackBounds bounds_of(const Track& track);

/// Refers to the tracks.
class LinkInTime {
 public:
  /// One of `driven` for every coordinate of the tree.
  LinkInTime(const Kinematics& kinematics, std::int32_t link, std::vector<DrivenCoordinate> driven);

  [[nodiscard]] MovingPoint at(const FrameTime& time);
  /// Position, velocity and acceleration, the last two exactly 0 where everything that moves it rests.
  [[nodiscard]] const LinkMotion& motion(const FrameTime& time);
  /// Bounds of its velocity (m/s) and of the third derivative of its place (m/s^3).
  [[nodiscard]] double max_speed() const { return max_speed_; }
  [[nodiscard]] double max_jerk() const { return max_jerk_; }
  /// A velocity or an acceleration of an axis that moves it steps.
  [[nodiscard]] bool steps() const { return steps_; }

 private:
  const Kinematics* kinematics_;
  std::int32_t link_;
  std::vector<DrivenCoordinate> driven_;
  std::vector<CoordinateMotion> coordinates_;
  std::vector<LinkMotion> links_;
  double max_speed_ = 0;
  double max_jerk_ = 0;
  bool steps_ = false;
};

}  // namespace inbetween
