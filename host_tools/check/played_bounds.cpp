#include "host_tools/check/played_bounds.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <span>

#include "host_tools/plan/fitted_trajectory.hpp"
#include "host_tools/plan/solved_track.hpp"
#include "inbetween/limits/roll_trajectory.hpp"
#include "inbetween/trajectory/bounds.hpp"

namespace inbetween {
namespace {

/// Joints whose trajectory is in memory at a time.
constexpr std::size_t joints_at_a_time = 256;

/// One track of a plan, whose axes are behind each other in the move.
class PlayedTrack {
 public:
  PlayedTrack(const Plan& plan, std::size_t index, std::size_t first_axis, PlayedBounds& out)
      : plan_(plan),
        index_(index),
        first_axis_(first_axis),
        out_(out),
        sampled_(plan.tracks()[index].track()),
        travel_(sampled_->axis_count()),
        motion_(sampled_->axis_count()),
        peaks_(sampled_->axis_count()),
        steps_(sampled_->axis_count()) {
    measure_travel(*sampled_, motion_, travel_);
  }

  void bound() {
    const std::size_t last = sampled_->joints().size() - 1;
    step_from_rest(RollEnd::before);
    for (std::size_t joint = 0; joint < last; joint += joints_at_a_time) {
      // The next joint as well, so that what steps at the last one has both its sides.
      take(joint, std::min(joint + joints_at_a_time, last), std::min(joint + joints_at_a_time + 1, last));
    }
    step_from_rest(RollEnd::after);
  }

 private:
  void take(std::size_t first, std::size_t last, std::size_t behind) {
    const FrameTime<double> from = std::max(time_of(first), FrameTime<double>{plan_.part().first, 0});
    const FrameTime<double> to = std::min(time_of(last), FrameTime<double>{plan_.part().last, 0});
    if (!(from < to)) return;
    const Trajectory trajectory = fitter_.fit(sampled_->between(first, behind), {.travel = travel_});
    out_.loosened = std::max(out_.loosened, trajectory.loosened());
    bound_trajectory(trajectory, from, to, peaks_);
    for (std::size_t d = 0; d < peaks_.size(); ++d) out_.axes[first_axis_ + d].raise(peaks_[d]);
    for (const TrajectoryBreak& at : trajectory.breaks()) {
      const bool is_inside = from < at.time && (at.time < to || (at.time == to && last < behind));
      if (!is_inside || at.time == FrameTime<double>{plan_.part().last, 0}) continue;
      steps_at(trajectory, at, steps_);
      add(at.time, at.key, steps_);
    }
  }
  [[nodiscard]] const FrameTime<double>& time_of(std::size_t joint) const {
    return sampled_->joints()[joint].time;
  }
  /// Where the move begins or ends with a step and no roll: inside the whole it rests or is joined by one.
  void step_from_rest(RollEnd end) {
    const bool is_start = end == RollEnd::before;
    const bool is_end_of_whole =
        is_start ? plan_.part().first == 0 : plan_.part().last == plan_.move().frames;
    if (!is_end_of_whole || plan_.is_moving(index_, end)) return;
    const SampledJoint& joint = is_start ? sampled_->joints().front() : sampled_->joints().back();
    static_cast<void>(is_start ? sampled_->leaving(joint, motion_) : sampled_->arriving(joint, motion_));
    const double sign = is_start ? 1 : -1;
    for (std::size_t d = 0; d < steps_.size(); ++d)
      steps_[d] = {sign * motion_[d].velocity, sign * motion_[d].acceleration};
    add(joint.time, joint.key, steps_);
  }
  void add(const FrameTime<double>& time, std::int32_t key, std::span<const TrajectoryStep> steps) {
    for (std::size_t d = 0; d < steps.size(); ++d) {
      if (steps[d].velocity == 0 && steps[d].acceleration == 0) continue;
      out_.steps.push_back({.key = key < 0 ? std::nullopt : std::optional(key),
                            .frame = time.frame + time.fraction,
                            .axis = first_axis_ + d,
                            .velocity = steps[d].velocity,
                            .acceleration = steps[d].acceleration});
    }
  }

  const Plan& plan_;
  std::size_t index_;
  std::size_t first_axis_;
  PlayedBounds& out_;
  SampledTrack sampled_;
  TrajectoryFitter fitter_;
  std::vector<double> travel_;
  std::vector<AxisMotion<double>> motion_;
  std::vector<AxisPeaks<double>> peaks_;
  std::vector<TrajectoryStep> steps_;
};

void bound_roll(std::span<const RollAxis<double>> rolls, PlayedBounds& out) {
  if (rolls.empty()) return;
  std::array<TrajectoryPiece, 1> piece;
  std::array<std::uint32_t, 1> bucket{};
  std::vector<double> values(6 * rolls.size());
  const Trajectory trajectory = value_or_throw(roll_trajectory(rolls, {.pieces = piece,
                                                                       .values = values,
                                                                       .buckets = bucket,
                                                                       .breaks = {},
                                                                       .unbounded = {},
                                                                       .samples = {},
                                                                       .numbers = {}}));
  std::vector<AxisPeaks<double>> peaks(rolls.size());
  bound_trajectory(trajectory, peaks);
  for (std::size_t d = 0; d < rolls.size(); ++d) out.axes[d].raise(peaks[d]);
}

}  // namespace

PlayedBounds bound_played(const Plan& plan) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  PlayedBounds out;
  out.axes.assign(
      plan.played().axis_count(),
      {.lowest = {infinity, 0}, .highest = {-infinity, 0}, .velocity = {}, .acceleration = {}, .jerk = {}});
  std::size_t first_axis = 0;
  for (std::size_t t = 0; t < plan.tracks().size(); ++t) {
    PlayedTrack(plan, t, first_axis, out).bound();
    first_axis += plan.move().tracks[t].axes.size();
  }
  bound_roll(plan.played().rolls().before, out);
  bound_roll(plan.played().rolls().after, out);
  return out;
}

}  // namespace inbetween
