#include "host_tools/plan/bounded_move.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "host_tools/plan/fitted_trajectory.hpp"
#include "host_tools/plan/solved_track.hpp"

namespace inbetween {
namespace {

/// Room for the steps of most moves. Where they are more, their number is told and the move is bounded once
/// more.
constexpr std::size_t usual_steps = 64;

/// What bound_move works in.
class WorkingMemory {
 public:
  WorkingMemory(std::span<const Track> tracks, bool has_motors) {
    std::size_t joints = 0;
    std::size_t axes = 0;
    for (const Track& track : tracks) {
      joints = std::max(joints, max_joints(track));
      axes = std::max(axes, static_cast<std::size_t>(track.path().axis_count()));
    }
    // The joints at both ends of a stretch, and the one behind it.
    const std::size_t stretch = std::min(joints, max_joints_at_a_time + 2);
    room_.reserve(stretch, axes, max_pieces_at_a_time);
    if (has_motors) motor_.emplace(max_motor_joints_at_a_time);
    joints_.resize(joints);
    travel_.resize(axes);
    peaks_.resize(axes);
    steps_.resize(axes);
  }

  void grow() {
    room_.grow();
    if (motor_) motor_->grow();
  }
  [[nodiscard]] MoveBoundsMemory memory() {
    return {.joints = joints_,
            .trajectory = room_.memory(),
            .travel = travel_,
            .peaks = peaks_,
            .steps = steps_,
            .motor_joints = motor_ ? motor_->joints() : std::span<MotorJoint>(),
            .motor = motor_ ? motor_->memory() : TrajectoryMemory{}};
  }

 private:
  TrajectoryRoom room_;
  std::optional<MotorRoom> motor_;
  std::vector<SampledJoint> joints_;
  std::vector<double> travel_;
  std::vector<AxisPeaks> peaks_;
  std::vector<TrajectoryStep> steps_;
};

}  // namespace

BoundedMove::BoundedMove(const Move& move, std::span<const Track> tracks, BoundRequest request)
    : peaks_(move.axis_count() + request.motors.size()), steps_(usual_steps), room_(std::move(request.room)) {
  WorkingMemory memory(tracks, !request.motors.empty());
  const std::size_t axes = move.axis_count();
  if (request.cells > 0) {
    room_.resize(peaks_.size());
    suprema_.resize(request.cells * peaks_.size());
    bounds_.cells = {.line = {move.first_frame(), move.last_frame(), request.cells},
                     .fps = move.frame_rate(),
                     .axes = axes,
                     .motors = request.motors.size(),
                     .room = room_,
                     .suprema = suprema_};
  }
  bounds_.peaks = peaks_;
  while (true) {
    bounds_.steps = steps_;
    const Status bounded = bound_move(move, tracks, request.limits, request.motors, memory.memory(), bounds_);
    if (bounded && bounds_.step_count <= steps_.size()) return;
    if (bounded) {
      steps_.resize(bounds_.step_count);
      continue;
    }
    // Between two joints there may be more pieces than anybody would have expected.
    const bool may_grow =
        bounded.error().code == ErrorCode::capacity && std::ranges::all_of(tracks, [](const Track& track) {
          return track.path().axis_count() <= static_cast<std::int32_t>(max_trajectory_axes);
        });
    if (!may_grow) throw SolverError(bounded.error());
    memory.grow();
  }
}

}  // namespace inbetween
