// The tracks of the page as one move, held against the limits of its rig.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "editor/solver/track_slot.hpp"
#include "inbetween/limits/limits.hpp"
#include "inbetween/limits/move.hpp"
#include "inbetween/limits/move_bounds.hpp"
#include "inbetween/limits/played_motion.hpp"
#include "inbetween/limits/stop_bounds.hpp"
#include "inbetween/limits/verdict.hpp"

namespace inbetween::editor {

inline constexpr std::size_t max_move_axes = 64;  ///< of all tracks
/// So many axes and motors there are together: an axis has one motor behind a calibration at most.
inline constexpr std::size_t max_moved = 2 * max_move_axes;
inline constexpr std::size_t max_cells = max_stop_cells;

/// How a track stands to the limits of its axes in one cell of the time line.
struct CellCeiling {
  /// So many times faster than drawn the cell may be passed with every limit kept; below 1 where it breaks
  /// one. Infinity where nothing moves.
  double rate = 0;
  std::int32_t axis = -1;  ///< whose limit that is, through all tracks, and behind them the motors; -1: none
  std::int32_t quantity = 0;  ///< 0 velocity, 1 acceleration, 2 jerk
};

inline constexpr std::size_t max_steps = 4096;
inline constexpr std::size_t max_trajectory_breaks = 512;
/// Knots of the curve, passings of knots of the path, and standstills between them.
inline constexpr std::size_t max_track_joints = max_values + 3 * max_segments + max_locks + 2;

/// It proves what the move keeps of its limits, in memory of its own. It refers to the tracks and the limits.
class Certificate {
 public:
  /// `limits` has an entry for every axis of all tracks, and behind them one for every motor, or is empty:
  /// then there is a move without rolls, and nothing is proven. All stay where they are as long as the
  /// certificate is used. Errors: those of Move::make, bound_move and StopBounds::make other than
  /// no_solution.
  Status make(std::span<const Track> tracks, std::span<const AxisLimits> limits,
              std::span<const CalibratedMotor> motors, std::int32_t rate_hz);

  [[nodiscard]] const Move& move() const { return *move_; }
  [[nodiscard]] std::span<const Track> tracks() const { return tracks_; }
  /// Writes what the tracks and the rolls ask every axis to do at a time; before and behind them it rests.
  void motion(const FrameTime& time, std::span<AxisMotion> out) const;
  [[nodiscard]] bool has_limits() const { return !limits_.empty(); }
  /// Every axis has an entry, and behind them every motor; the rolls count.
  [[nodiscard]] std::span<const AxisPeaks> peaks() const {
    return std::span(storage_.peaks).first(axes_ + motors_.size());
  }
  [[nodiscard]] std::size_t motor_count() const { return motors_.size(); }
  [[nodiscard]] std::size_t cell_count() const { return cells_; }
  /// Of one track, cell by cell.
  [[nodiscard]] std::span<const CellCeiling> cells(std::size_t track) const {
    return std::span(ceilings_).subspan(track * cells_, cells_);
  }
  [[nodiscard]] std::span<const MoveStep> steps() const {
    return std::span(storage_.steps).first(std::min(step_count_, max_steps));
  }
  /// Steps that max_steps left out.
  [[nodiscard]] std::size_t steps_left_out() const { return step_count_ - steps().size(); }
  /// There are none where a place has no stop that keeps the stop limits of every axis and motor.
  [[nodiscard]] const std::optional<StopBounds>& stops() const { return stops_; }
  /// Of the pre-roll, or where there is none of the post-roll, if one is needed and none keeps the limits.
  [[nodiscard]] const std::optional<RollBreach>& roll_obstacle() const { return roll_obstacle_; }
  [[nodiscard]] double highest_rate() const { return highest_rate_; }
  /// The first thing that is not kept; nothing where the move fits, which is what `check` says of it too.
  [[nodiscard]] std::optional<Breach> first_breach() const;

 private:
  [[nodiscard]] JudgedMove judged() const { return {peaks(), steps(), limits_, axes_}; }
  Status make_rolls(MoveRolls& rolls);
  Status bound();
  Status bound_stops(const MotionCells& motion);
  [[nodiscard]] std::span<const AxisLimits> axis_limits() const { return limits_.first(axes_); }
  void find_ceiling(const MotionCells& motion);
  void lower(CellCeiling& ceiling, const MotionTriple& suprema, std::size_t axis) const;
  [[nodiscard]] double tick_seconds() const { return 1.0 / rate_hz_; }

  std::span<const Track> tracks_;
  std::span<const AxisLimits> limits_;
  std::span<const CalibratedMotor> motors_;
  std::int32_t rate_hz_ = 0;
  std::size_t axes_ = 0;
  std::size_t cells_ = 0;
  std::size_t step_count_ = 0;
  double highest_rate_ = 0;
  std::optional<Move> move_;
  std::optional<StopBounds> stops_;
  std::optional<StopObstacle> stop_obstacle_;
  std::optional<RollBreach> roll_obstacle_;
  std::array<RollAxis, max_move_axes> before_, after_;
  std::array<AxisMotion, max_move_axes> joints_;
  std::array<CellCeiling, max_tracks * max_cells> ceilings_;
  std::array<StopCell, max_cells + 1> stop_cells_;
  TrajectoryStorage<1, 2 * max_motor_joints_at_a_time, max_motor_joints_at_a_time> motor_;
  std::array<MotorJoint, max_motor_joints_at_a_time> motor_joints_;
  MoveBoundsStorage<max_moved, max_track_joints, max_pieces_at_a_time, max_trajectory_breaks, max_cells,
                    max_steps, max_axes>
      storage_;
};

}  // namespace inbetween::editor
