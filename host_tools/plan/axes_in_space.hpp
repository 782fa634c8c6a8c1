// The axes of a track whose keys are in the world: solved anywhere on its drawn path, and along all of it.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/joints/kinematics.hpp"
#include "host_tools/joints/tip_solver.hpp"
#include "host_tools/move_model/move_file.hpp"
#include "host_tools/plan/followed_path.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "inbetween/timing/track.hpp"

namespace inbetween {

/// Of the length of the path: a tenth of what a move in space may be off, 1e-6, to which
/// SpaceTrack.TheHandGoesWhereItIsDrawnWithItsElbowOnTheSideThatIsAsked holds it.
inline constexpr double off_share = 1e-7;
/// A length that is nothing (m), for paths that stay in one place.
inline constexpr double min_length = 1e-6;
/// So many straight lines tell the length of a path well enough for a tolerance.
inline constexpr int chords_between_keys = 16;

/// The rows of a drawn path in space.
struct SpaceRows {
  explicit SpaceRows(const MoveSpace& space);
  std::vector<std::size_t> at, aim, roll;
  std::size_t count = 0;
};

/// The tip of that name. Throws InputError, which lists those that the rig has.
const Tip& tip_named(const std::string& name, const Place& place, const Kinematics& kinematics);
/// The coordinates of the tree that the axes of a track are, which are all that move the tip.
std::vector<std::size_t> coordinates_for(const MoveTrack& track, const Tip& tip, const Place& place,
                                         const Kinematics& kinematics, const RigFile& rig);
/// `count` rows from `first`.
std::vector<std::size_t> rows_from(std::size_t first, std::size_t count);
/// The path is C2 on centripetal knots.
bool is_c2(const MoveTrack& track);

/// A point that moves (m, m/s).
struct MovingPoint {
  Vector3 position;
  Vector3 velocity;
};

/// `aim` is where the link that is looked at is at first, if it moves. Refers to what it is made of. What is
/// refused throws InputError at the key before the place, with frame, distance along the path and axis.
class AxesInSpace {
 public:
  AxesInSpace(const MoveTrack& track, const Track& drawn, const Kinematics& kinematics, const RigFile& rig,
              const std::optional<Vector3>& aim = {});

  /// The whole path, with an aim that its rows have, if any.
  [[nodiscard]] FollowedPath follow();

  /// The positions at a moment at which the link that is looked at, if there is one, is there. Calls go on
  /// from the one before, and from `near` if this `is_first`.
  const std::vector<double>& at(const FrameTime& time, const std::optional<MovingPoint>& aim, bool is_first);
  /// Their velocities (unit/s), after at().
  [[nodiscard]] std::vector<double> velocities(const FrameTime& time,
                                               const std::optional<MovingPoint>& aim) const;

  [[nodiscard]] const SpaceRows& rows() const { return rows_; }
  [[nodiscard]] const Tip& tip() const { return tip_; }
  [[nodiscard]] const std::vector<std::size_t>& coordinates() const { return coordinates_; }
  /// What is drawn leaves no axis free.
  [[nodiscard]] bool is_determined() const { return rank_ == coordinates_.size(); }
  /// What `check` would refuse too: an inverse solution beyond the range of an axis is none.
  /// `place_of` says where a step of the path is on the drawn one.
  void refuse_beyond_ranges(const FollowedPath& path,
                            const std::function<PathPoint(std::size_t step, double t)>& place_of) const;
  [[noreturn]] void refuse(const PathPoint& place, const std::string& problem) const;

 private:
  [[nodiscard]] std::vector<TipAxis> axes_of_rig() const;
  void set_elbow();
  [[nodiscard]] std::string name_of(std::size_t axis) const;
  [[nodiscard]] TipTarget target(const PathPoint& place) const;
  [[nodiscard]] TipTargetRate rate(const PathPoint& place) const;
  /// `number(row)` is that of a row of the path; `aim` stands in for rows that are not there.
  template <class Number>
  [[nodiscard]] TipTarget target_of(const Number& number, const std::optional<Vector3>& aim) const;
  const std::vector<double>& solve_at(const PathPoint& place, bool is_first);
  /// Of the singular place that lies between two solutions.
  [[nodiscard]] std::size_t weak_axis_between(const TipTarget& wanted, const std::vector<double>& before,
                                              const std::vector<double>& behind) const;
  [[noreturn]] void refuse_singular(const PathPoint& place, std::size_t axis) const;
  /// A place where the solver does not arrive: the worst one near it says how far the path is outside.
  [[noreturn]] void refuse_miss(const PathPoint& place, const std::vector<double>& nearest) const;

  const MoveTrack& track_;
  const MoveSpace& space_;
  const Track& drawn_;
  const RigFile& rig_;
  const Kinematics& kinematics_;
  const Tip& tip_;
  SpaceRows rows_;
  std::vector<std::size_t> coordinates_;
  TipSolver solver_;
  std::size_t rank_ = 0;
  int sign_ = 0;
  std::vector<double> before_;
  std::optional<Vector3> aim_;  // of the link that is looked at, now
};

}  // namespace inbetween
