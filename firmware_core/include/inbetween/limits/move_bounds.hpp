#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "inbetween/limits/limits.hpp"
#include "inbetween/limits/motion_cells.hpp"
#include "inbetween/limits/motor_trajectory.hpp"
#include "inbetween/limits/move.hpp"
#include "inbetween/trajectory/fit.hpp"

/// How far, how fast and how hard a move goes and where it steps, proven for every moment of what plays: of
/// its trajectories and its rolls.

namespace inbetween {

/// A jump of the velocity or the acceleration of an axis, as magnitudes, in axis units and seconds. At either
/// end of the whole move against the rest outside.
struct MoveStep {
  std::size_t track = 0;
  std::int32_t key = -1;  ///< that is passed there; -1 between keys, where the path turns on the spot
  double frame = 0;       ///< it need not be a whole one
  std::size_t axis = 0;   ///< counted through the tracks
  double velocity = 0;    ///< 0 where it does not step
  double acceleration = 0;
};

/// A step below this share of the peak, or of the limit, is rounding.
inline constexpr double step_rounding = 1e-9;

/// This holds what is proven of a move, in the caller's memory.
struct MoveBounds {
  /// One for every axis, and behind them one for every motor, in its unit.
  std::span<AxisPeaks> peaks;
  std::span<MoveStep> steps;
  std::size_t step_count = 0;  ///< of all steps; those for which `steps` has no room are left out
  MotionCells cells = {};      ///< none where CellLine::cells is 0
};

/// So many stretches from joint to joint are fitted at a time, if there is room: more need memory, and fewer
/// fit the joints at their ends twice.
inline constexpr std::size_t max_joints_at_a_time = 256;
/// And whoever gives room for so many pieces of them, and for so many joints and twice the pieces of a motor,
/// has the bits of whoever else does: where a stretch ends, the last bits of a bound may depend on it.
inline constexpr std::size_t max_pieces_at_a_time = 8192;
inline constexpr std::size_t max_motor_joints_at_a_time = max_pieces_at_a_time + 64;

/// The memory that bound_move works in, owned by the caller. It is free again behind it.
struct MoveBoundsMemory {
  std::span<SampledJoint> joints;  ///< max_joints() of the track that has most
  /// A track is fitted in as many stretches as are needed for one to fit in here: from one joint to the next
  /// but one it must.
  TrajectoryMemory trajectory;
  std::span<double> travel;         ///< axes of the track that has most
  std::span<AxisPeaks> peaks;       ///< the same
  std::span<TrajectoryStep> steps;  ///< the same
  /// Motors are fitted in here, one after the other: a motor has the joints and pieces of its axis, and those
  /// that its passings of marks make.
  std::span<MotorJoint> motor_joints = {};
  TrajectoryMemory motor = {};
};

/// Both for tracks of up to `Axes` axes and `Joints` joints, a move of as many axes and motors in all, in up
/// to `Cells` cells. Where there are motors the caller gives memory for them. TrajectoryStorage says what
/// Pieces and Breaks are: of a stretch, as long as there is room for.
template <std::size_t Axes, std::size_t Joints, std::size_t Pieces, std::size_t Breaks, std::size_t Cells,
          std::size_t Steps = 64, std::size_t TrackAxes = Axes>
struct MoveBoundsStorage {
  std::array<SampledJoint, Joints> joints;
  TrajectoryStorage<TrackAxes, Pieces, Breaks> trajectory;
  std::array<double, TrackAxes> travel;
  std::array<AxisPeaks, TrackAxes> stretch_peaks;
  std::array<TrajectoryStep, TrackAxes> stretch_steps;
  std::array<AxisPeaks, Axes> peaks;
  std::array<MoveStep, Steps> steps;
  std::array<MotionTriple, Axes> room;
  std::array<MotionTriple, Axes * Cells> suprema;

  [[nodiscard]] MoveBoundsMemory memory() {
    return {joints, trajectory.memory(), travel, stretch_peaks, stretch_steps};
  }
  /// bound_move puts what it finds here. The caller writes `room` where there are cells (write_room).
  [[nodiscard]] MoveBounds bounds(const Move& move, std::size_t cells, std::size_t motors = 0) {
    const std::size_t all = move.axis_count() + motors;
    return {.peaks = std::span(peaks).first(all),
            .steps = steps,
            .cells = {.line = {move.first_frame(), move.last_frame(), cells},
                      .fps = move.frame_rate(),
                      .axes = move.axis_count(),
                      .motors = motors,
                      .room = std::span(room).first(all),
                      .suprema = std::span(suprema).first(cells * all)}};
  }
};

/// Bounds of the frames Move::part() and of the rolls: true <= peak <= 1.00001 true, lowest and highest
/// within 1e-9 of the distance (bound_trajectory); steps beyond rounding; the suprema of the cells
/// (bound_cells; 0.5 % of the peak are room as well). Motors are bounded as axes are, by what they play
/// (fit_motor). `limits`, one for every axis or none, say what a step is compared with, beside the peak.
///
/// Errors: wrong_count (tracks, limits, peaks, cells), out_of_range (a motor of no axis), capacity (memory),
/// those of fit_trajectory. No allocation. Cost: the fit, and O((pieces + cells) * axes).
Status bound_move(const Move& move, std::span<const Track> tracks, std::span<const AxisLimits> limits,
                  std::span<const CalibratedMotor> motors, const MoveBoundsMemory& memory, MoveBounds& out);

}  // namespace inbetween
