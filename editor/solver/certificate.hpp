// The tracks of the page as one move, held against the limits of its rig.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "editor/solver/track_slot.hpp"
#include "inbetween/limits/limits.hpp"
#include "inbetween/limits/motion_bounds.hpp"
#include "inbetween/limits/motion_cells.hpp"
#include "inbetween/limits/move.hpp"
#include "inbetween/limits/roll.hpp"
#include "inbetween/limits/stop_bounds.hpp"

namespace inbetween::editor {

inline constexpr std::size_t max_move_axes = 64;  ///< of all tracks
inline constexpr std::size_t max_cells = 512;

/// How a track stands to the limits of its axes in one cell of the time line.
struct CellCeiling {
  /// So many times faster than drawn the cell may be passed with every limit kept; below 1 where it breaks
  /// one. Infinity where nothing moves.
  double rate = 0;
  std::int32_t axis = -1;     ///< whose limit that is, through all tracks; -1: none
  std::int32_t quantity = 0;  ///< 0 velocity, 1 acceleration, 2 jerk
};

/// A jump of the velocity or the acceleration of an axis at a key.
struct KeyStep {
  std::int32_t track = 0;
  std::int32_t key = -1;  ///< -1: between keys
  double frame = 0;
  std::int32_t axis = 0;  ///< through all tracks
  double velocity = 0;
  double acceleration = 0;
};
inline constexpr std::size_t max_steps = 256;

/// It proves what the move keeps of its limits, in memory of its own. It refers to the tracks and the limits.
class Certificate {
 public:
  /// `limits` has an entry for every axis of all tracks, or is empty: then there is a move without rolls, and
  /// nothing is proven. The tracks stay where they are as long as the certificate is used.
  /// Errors: those of Move::make, bound_motion and StopBounds::make other than no_solution.
  Status make(std::span<const Track<double>> tracks, std::span<const AxisLimits<double>> limits,
              double tick_seconds);

  [[nodiscard]] const Move<double>& move() const { return *move_; }
  [[nodiscard]] bool has_limits() const { return !limits_.empty(); }
  /// Every axis has an entry; the rolls count.
  [[nodiscard]] std::span<const AxisPeaks<double>> peaks() const { return std::span(peaks_).first(axes_); }
  [[nodiscard]] std::size_t cell_count() const { return cells_; }
  /// Of one track, cell by cell.
  [[nodiscard]] std::span<const CellCeiling> cells(std::size_t track) const {
    return std::span(ceilings_).subspan(track * cells_, cells_);
  }
  [[nodiscard]] std::span<const KeyStep> steps() const { return std::span(steps_).first(step_count_); }
  /// Steps that max_steps left out.
  [[nodiscard]] std::size_t steps_left_out() const { return steps_left_out_; }
  /// Nothing where there is a place from which no stop keeps the stop limits.
  [[nodiscard]] const std::optional<StopBounds<double>>& stops() const { return stops_; }
  [[nodiscard]] const std::optional<StopObstacle<double>>& stop_obstacle() const { return stop_obstacle_; }
  /// Of the pre-roll, or where there is none of the post-roll, if one is needed and none keeps the limits.
  [[nodiscard]] const std::optional<RollBreach<double>>& roll_obstacle() const { return roll_obstacle_; }
  [[nodiscard]] double highest_rate() const { return highest_rate_; }

 private:
  Status make_rolls(std::span<const Track<double>> tracks, MoveRolls<double>& rolls);
  Status bound_peaks();
  void list_steps();
  void add_step(const KeyStep& step);
  Status bound_stops(double tick_seconds);
  void find_ceiling();
  void lower(CellCeiling& ceiling, const MotionTriple<double>& suprema, std::size_t axis) const;
  void find_highest_rate();

  std::span<const AxisLimits<double>> limits_;
  std::size_t axes_ = 0;
  std::size_t cells_ = 0;
  std::size_t step_count_ = 0;
  std::size_t steps_left_out_ = 0;
  double highest_rate_ = 0;
  std::optional<Move<double>> move_;
  std::optional<StopBounds<double>> stops_;
  std::optional<StopObstacle<double>> stop_obstacle_;
  std::optional<RollBreach<double>> roll_obstacle_;
  std::array<RollAxis<double>, max_move_axes> before_, after_;
  std::array<AxisMotion<double>, max_move_axes> joints_;
  std::array<AxisPeaks<double>, max_move_axes> peaks_;
  std::array<CellCeiling, max_tracks * max_cells> ceilings_;
  std::array<KeyStep, max_steps> steps_;
  StopBoundsStorage<double, max_cells, max_move_axes> storage_;
};

}  // namespace inbetween::editor
