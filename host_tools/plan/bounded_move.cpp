#include "host_tools/plan/bounded_move.hpp"

#include <algorithm>
#include <memory>
#include <utility>

#include "host_tools/plan/solved_track.hpp"

namespace inbetween {
namespace {

/// A longer track is fitted in stretches: 16 pieces a joint are more than most take.
constexpr std::size_t max_stretch = 257;
constexpr std::size_t pieces_per_joint = 16;
/// Of one stretch between two joints, which must fit.
constexpr std::size_t min_pieces = 64;

constexpr std::size_t usual_steps = 64;

/// What bound_move works in. Most of it is not touched, so it is not set to 0.
class WorkingMemory {
 public:
  explicit WorkingMemory(const Move<double>& move) {
    for (const Track<double>& track : move.tracks()) {
      joints_ = std::max(joints_, max_joints(track));
      axes_ = std::max(axes_, static_cast<std::size_t>(track.path().axis_count()));
    }
    const std::size_t stretch = std::min(joints_, max_stretch);
    pieces_ = std::max(pieces_per_joint * stretch, min_pieces);
    joint_memory_.resize(joints_);
    travel_.resize(axes_);
    peaks_.resize(axes_);
    steps_.resize(axes_);
    places_.resize(move.axis_count());
    samples_.resize(3 * axes_);
    numbers_.resize(5 * axes_);
    breaks_.resize(stretch + 1);
    unbounded_.resize(3 * axes_ * (stretch + 1));
    grow(1);
  }

  /// Room for so many times as many pieces.
  void grow(std::size_t times) {
    pieces_ *= times;
    piece_memory_ = std::make_unique_for_overwrite<TrajectoryPiece[]>(pieces_);
    value_memory_ = std::make_unique_for_overwrite<double[]>(4 * axes_ * (pieces_ + breaks_.size() + 1));
    bucket_memory_ = std::make_unique_for_overwrite<std::uint32_t[]>(pieces_);
  }
  [[nodiscard]] MoveBoundsMemory memory() {
    return {.joints = joint_memory_,
            .trajectory = {.pieces = {piece_memory_.get(), pieces_},
                           .values = {value_memory_.get(), 4 * axes_ * (pieces_ + breaks_.size() + 1)},
                           .buckets = {bucket_memory_.get(), pieces_},
                           .breaks = breaks_,
                           .unbounded = unbounded_,
                           .samples = samples_,
                           .numbers = numbers_},
            .travel = travel_,
            .peaks = peaks_,
            .steps = steps_,
            .places = places_};
  }

 private:
  std::size_t joints_ = 0;
  std::size_t axes_ = 0;
  std::size_t pieces_ = 0;
  std::vector<SampledJoint> joint_memory_;
  std::unique_ptr<TrajectoryPiece[]> piece_memory_;
  std::unique_ptr<double[]> value_memory_;
  std::unique_ptr<std::uint32_t[]> bucket_memory_;
  std::vector<TrajectoryBreak> breaks_;
  std::vector<UnboundedSide> unbounded_;
  std::vector<AxisMotion<double>> samples_;
  std::vector<double> numbers_;
  std::vector<double> travel_;
  std::vector<AxisPeaks<double>> peaks_;
  std::vector<TrajectoryStep> steps_;
  std::vector<double> places_;
};

}  // namespace

BoundedMove::BoundedMove(const Move<double>& move, BoundRequest request)
    : peaks_(move.axis_count() + request.motors.size()), steps_(usual_steps), room_(std::move(request.room)) {
  WorkingMemory memory(move);
  const std::size_t axes = move.axis_count();
  if (request.cells > 0) {
    room_.resize(axes);
    suprema_.resize(request.cells * peaks_.size());
    bounds_.cells = {.line = {move.first_frame(), move.last_frame(), request.cells},
                     .fps = move.frame_rate(),
                     .axes = axes,
                     .motors = request.motors.size(),
                     .room = room_,
                     .suprema = suprema_};
  } else {
    bounds_.cells.line.cells = 0;
  }
  bounds_.peaks = peaks_;
  while (true) {
    bounds_.steps = steps_;
    const Status bounded = bound_move(move, request.limits, request.motors, memory.memory(), bounds_);
    if (bounded && bounds_.step_count <= steps_.size()) return;
    if (bounded) {
      steps_.resize(bounds_.step_count);
      continue;
    }
    // Between two joints there may be more pieces than anybody would have expected.
    const bool may_grow =
        bounded.error().code == ErrorCode::capacity &&
        std::ranges::all_of(move.tracks(), [](const Track<double>& track) {
          return track.path().axis_count() <= static_cast<std::int32_t>(max_trajectory_axes);
        });
    if (!may_grow) throw SolverError(bounded.error());
    memory.grow(2);
  }
}

}  // namespace inbetween
