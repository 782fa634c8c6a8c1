#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>

#include "inbetween/base/result.hpp"
#include "inbetween/limits/move.hpp"
#include "inbetween/trajectory/trajectory.hpp"

namespace inbetween {

/// A break of a trajectory so near to a frame is met on it.
inline constexpr double frame_rounding = 1e-9;

/// The motion of every axis where a roll would join the frames `part`, of the whole move or inside it, track
/// after track: joints_of() the whole at its ends; inside it the motion with which the trajectory leaves the
/// first frame, or arrives on the last: position, velocity and acceleration, and no jerk. The two differ
/// where a key on which the motion steps is met there, within what a lock promises. Returns whether any axis
/// moves beyond rounding. There are as many trajectories, of whole tracks, as tracks, or none for a whole
/// move. `out` has an entry for every axis of all tracks. O(axes + log pieces).
bool joints_of_part(std::span<const Track> tracks, std::span<const Trajectory> trajectories,
                    const WholeFrames& part, RollEnd end, std::span<AxisMotion> out);

/// A move that is moving at one end and has no roll there, and the limit that is the obstacle.
struct RollObstacle {
  RollEnd end = RollEnd::before;
  RollBreach breach;          ///< its axis counts through the tracks
  double joint_position = 0;  ///< of that axis, where the roll would join the move
};

/// These rolls join a part of a move. An obstacle says why there is none at an end that needs one.
struct JoinedRolls {
  MoveRolls rolls;
  std::array<std::optional<RollObstacle>, 2> obstacles;  ///< before it, behind it
};

/// An entry for every axis each, owned by the caller. The rolls stay in it.
struct RollMemory {
  std::span<AxisMotion> joints;
  std::span<RollAxis> before, after;
};

/// The shortest rolls that keep the limits, `limits` track after track, of the frames `part`; trajectories as
/// for joints_of_part(). Each end has its own number of frames. Errors: wrong_count (limits, memory), those
/// of roll_frames and RollAxis::make. No allocation. Cost: that of roll_frames.
Result<JoinedRolls> join_rolls(std::span<const Track> tracks, std::span<const Trajectory> trajectories,
                               std::span<const AxisLimits> limits, const WholeFrames& part,
                               const RollMemory& memory);

/// The motor of an axis behind a calibration plays trajectories of its own (fit_motor).
struct PlayedMotor {
  std::size_t axis = 0;                  ///< counted through the tracks
  const Trajectory* whole = nullptr;     ///< of the whole move
  const Trajectory* pre_roll = nullptr;  ///< of the move's rolls, where it has them
  const Trajectory* post_roll = nullptr;
};

/// This is what plays: a move with the trajectories of its tracks, and of motors behind a calibration. They
/// decide on the frames Move::part(), to the last bit; a part of a move is on its frames the whole, bit for
/// bit. Refers to the caller's memory.
class PlayedMotion {
 public:
  /// Trajectories of the whole move. Errors: wrong_count (they have not as many axes as the move together; a
  /// motor without a trajectory of the move or of each of its rolls, or of another axis), out_of_range (they
  /// do not last from frame 0 to the last of the whole, or as long as the roll). O(trajectories + motors).
  static Result<PlayedMotion> make(const Move& move, std::span<const Trajectory> trajectories,
                                   std::span<const PlayedMotor> motors = {});

  [[nodiscard]] const Move& move() const { return move_; }
  [[nodiscard]] std::span<const Trajectory> trajectories() const { return trajectories_; }
  [[nodiscard]] std::size_t axis_count() const { return move_.axis_count(); }
  [[nodiscard]] std::span<const PlayedMotor> motors() const { return motors_; }

  /// The position of every axis. Before Move::first_frame() and after Move::last_frame() the axes rest where
  /// they are on it. `out` has axis_count() entries. O(axes), no allocation.
  void positions(const FrameTime& time, std::span<double> out) const;
  /// Position, velocity, acceleration and jerk of every axis; at a joint those with which the motion leaves
  /// it. Resting outside the time line: derivatives 0. O(axes), no allocation.
  void motion(const FrameTime& time, std::span<AxisMotion> out) const;
  /// The same of one of the motors, in units of the motor. O(log pieces).
  [[nodiscard]] AxisMotion motion_of(const PlayedMotor& motor, const FrameTime& time) const;

 private:
  PlayedMotion(const Move& move, std::span<const Trajectory> trajectories,
               std::span<const PlayedMotor> motors)
      : move_(move), trajectories_(trajectories), motors_(motors) {}

  Move move_;
  std::span<const Trajectory> trajectories_;
  std::span<const PlayedMotor> motors_;
};

/// Whether a move may be played again and again from its start. Errors: no_solution, with axis, if it would
/// step because an axis has different positions at the two ends of the time line. O(axes).
Status can_loop(const PlayedMotion& motion);

}  // namespace inbetween
