#include "inbetween/limits/move_bounds.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "inbetween/limits/played_motion.hpp"

namespace inbetween {
namespace {

/// A rate change that is so much lower makes a stop that much longer, and a quarter of it costs twice the
/// time.
constexpr double cell_room = 0.005;

/// Whether something is left of a step without its rounding.
bool is_step(MoveStep& step, const AxisPeaks& peaks, std::span<const AxisLimits> limits) {
  const auto drop = [](double& value, double peak, double limit) {
    if (!(value > step_rounding * std::max(std::isfinite(peak) ? peak : 0, limit))) value = 0;
  };
  const bool has_limits = step.axis < limits.size();
  drop(step.velocity, peaks.velocity.value, has_limits ? limits[step.axis].max_velocity() : 0);
  drop(step.acceleration, peaks.acceleration.value, has_limits ? limits[step.axis].max_acceleration() : 0);
  return step.velocity > 0 || step.acceleration > 0;
}

/// Of an axis or a motor, by its number in the peaks.
void raise_room(std::size_t index, MoveBounds& out) {
  const AxisPeaks& peaks = out.peaks[index];
  MotionTriple& room = out.cells.room[index];
  const auto raise = [](double& value, double peak) {
    if (std::isfinite(peak)) value = std::max(value, cell_room * peak);
  };
  raise(room[0], peaks.velocity.value);
  raise(room[1], peaks.acceleration.value);
  raise(room[2], peaks.jerk.value);
}

/// What a motor does on a part of what it plays, for its number in the peaks.
void take_motor(const Trajectory& motor, const FrameTime& from, const FrameTime& to, std::size_t index,
                MoveBounds& out) {
  AxisPeaks peaks;
  bound_trajectory(motor, from, to, std::span(&peaks, 1));
  out.peaks[index].raise(peaks);
  if (out.cells.line.cells == 0) return;
  raise_room(index, out);
  raise_cells(motor, from, to, index, out.cells);
}

/// One track of a move.
class TrackBounding {
 public:
  TrackBounding(const Move& move, const Track& track, std::size_t index, std::size_t first_axis,
                std::span<const AxisLimits> limits, std::span<const CalibratedMotor> motors,
                const MoveBoundsMemory& memory, MoveBounds& out)
      : move_(move),
        track_(track),
        index_(index),
        first_axis_(first_axis),
        axes_(static_cast<std::size_t>(track_.path().axis_count())),
        limits_(limits),
        motors_(motors),
        memory_(memory),
        out_(out) {}

  Status run() {
    if (memory_.travel.size() < axes_ || memory_.peaks.size() < axes_ || memory_.steps.size() < axes_ ||
        memory_.trajectory.samples.size() < axes_) {
      return Error{.code = ErrorCode::capacity,
                   .what = "a track has more axes than the memory of its bounds",
                   .remedy = "give it a larger capacity; 64 axes at most",
                   .needed = static_cast<std::int64_t>(axes_)};
    }
    const Result<TrackSampler> sampler = TrackSampler::make(track_, memory_.joints);
    if (!sampler) return sampler.error();
    measure_travel(*sampler, memory_.trajectory.samples.first(axes_), memory_.travel.first(axes_));
    step_from_rest(*sampler, RollEnd::before);
    const std::size_t last = sampler->joints().size() - 1;
    for (std::size_t joint = 0; joint < last;) {
      const Result<std::size_t> taken = take(*sampler, joint, std::min(max_joints_at_a_time, last - joint));
      if (!taken) return taken.error();
      joint += *taken;
    }
    step_from_rest(*sampler, RollEnd::after);
    return Done{};
  }

 private:
  [[nodiscard]] FrameTime first_time() const { return {move_.part().first, 0}; }
  [[nodiscard]] FrameTime last_time() const { return {move_.part().last, 0}; }

  /// The stretch behind a joint, of so many joints, or as many as there is room for: these are returned.
  Result<std::size_t> take(const TrackSampler& sampler, std::size_t joint, std::size_t count) {
    const std::span<const SampledJoint> joints = sampler.joints();
    const FrameTime from = std::max(joints[joint].time, first_time());
    while (true) {
      const FrameTime to = std::min(joints[joint + count].time, last_time());
      if (!(from < to)) return count;  // it is not played
      // The next joint as well, so that what steps at the last one has both its sides.
      const std::size_t behind = std::min(joint + count + 1, joints.size() - 1);
      const FitTolerances tolerances{.travel = memory_.travel.first(axes_)};
      const Result<Trajectory> fitted =
          fit_trajectory(sampler.between(joint, behind), tolerances, memory_.trajectory);
      const Status taken = fitted ? take_motors(*fitted, from, to) : Status(fitted.error());
      if (taken) {
        take(*fitted, from, to, joint + count < behind);
        return count;
      }
      if (taken.error().code != ErrorCode::capacity || count == 1) return taken.error();
      count /= 2;
    }
  }
  /// It may be called again for a part of the stretch.
  Status take_motors(const Trajectory& trajectory, const FrameTime& from, const FrameTime& to) {
    for (std::size_t m = 0; m < motors_.size(); ++m) {
      const CalibratedMotor& motor = motors_[m];
      if (motor.axis < first_axis_ || motor.axis - first_axis_ >= axes_) continue;
      const std::size_t d = motor.axis - first_axis_;
      const MotorSource source{&trajectory, d, motor.calibration, memory_.travel[d]};
      const Result<Trajectory> fitted = fit_motor(source, memory_.motor_joints, memory_.motor);
      if (!fitted) return fitted.error();
      take_motor(*fitted, from, to, move_.axis_count() + m, out_);
    }
    return Done{};
  }
  void take(const Trajectory& trajectory, const FrameTime& from, const FrameTime& to, bool has_more) {
    bound_trajectory(trajectory, from, to, memory_.peaks.first(axes_));
    for (std::size_t d = 0; d < axes_; ++d) out_.peaks[first_axis_ + d].raise(memory_.peaks[d]);
    for (const TrajectoryBreak& at : trajectory.breaks()) {
      const bool is_inside = from < at.time && (at.time < to || (at.time == to && has_more));
      // One that is met on the first or the last frame of a part is not between them.
      const bool is_at_end = std::fabs(frames_between(first_time(), at.time)) <= frame_rounding ||
                             std::fabs(frames_between(at.time, last_time())) <= frame_rounding;
      if (!is_inside || is_at_end) continue;
      steps_at(trajectory, at, memory_.steps.first(axes_));
      for (std::size_t d = 0; d < axes_; ++d) add(at.time, at.key, d, memory_.steps[d]);
    }
    if (out_.cells.line.cells == 0) return;
    for (std::size_t d = 0; d < axes_; ++d) raise_room(first_axis_ + d, out_);
    raise_cells(trajectory, from, to, first_axis_, out_.cells);
  }

  /// The whole move begins or ends with a step where it has no roll. Inside the whole a part rests, or a roll
  /// joins it.
  void step_from_rest(const TrackSampler& sampler, RollEnd end) {
    const bool is_start = end == RollEnd::before;
    const bool is_end_of_whole = is_start ? move_.part().first == 0 : move_.part().last == move_.frames();
    if (!is_end_of_whole || is_moving(track_, end)) return;
    const SampledJoint& joint = is_start ? sampler.joints().front() : sampler.joints().back();
    const std::span<AxisMotion> motion = memory_.trajectory.samples.first(axes_);
    static_cast<void>(is_start ? sampler.leaving(joint, motion) : sampler.arriving(joint, motion));
    for (std::size_t d = 0; d < axes_; ++d)
      add(joint.time, joint.key, d, {motion[d].velocity, motion[d].acceleration});
  }

  void add(const FrameTime& time, std::int32_t key, std::size_t d, const TrajectoryStep& step) {
    MoveStep found{.track = index_,
                   .key = key,
                   .frame = time.frame + time.fraction,
                   .axis = first_axis_ + d,
                   .velocity = std::fabs(step.velocity),
                   .acceleration = std::fabs(step.acceleration)};
    const AxisPeaks& peaks = out_.peaks[first_axis_ + d];
    if (!is_step(found, peaks, limits_)) return;
    if (out_.step_count < out_.steps.size()) out_.steps[out_.step_count] = found;
    ++out_.step_count;
  }

  const Move& move_;
  const Track& track_;
  std::size_t index_;
  std::size_t first_axis_;
  std::size_t axes_;
  std::span<const AxisLimits> limits_;
  std::span<const CalibratedMotor> motors_;
  const MoveBoundsMemory& memory_;
  MoveBounds& out_;
};

Status check(const Move& move, std::span<const Track> tracks, std::span<const AxisLimits> limits,
             std::span<const CalibratedMotor> motors, const MoveBounds& out) {
  const std::size_t axes = move.axis_count();
  const Result<MoveLength> length = length_of(tracks);
  if (!length) return length.error();
  if (length->axes != axes || length->frames != move.frames() || length->fps != move.frame_rate()) {
    return Error{.code = ErrorCode::wrong_count,
                 .what = "these are not the tracks of the move",
                 .remedy = "give those that it was made of",
                 .needed = static_cast<std::int64_t>(axes)};
  }
  for (const CalibratedMotor& motor : motors) {
    if (motor.axis < axes) continue;
    return Error{.code = ErrorCode::out_of_range,
                 .what = "a motor follows an axis that the move does not have",
                 .remedy = "count the axes through the tracks, from 0"};
  }
  const MotionCells& cells = out.cells;
  const bool has_cells = cells.line.cells > 0;
  const bool is_complete = (limits.empty() || limits.size() >= axes) &&
                           out.peaks.size() == axes + motors.size() &&
                           (!has_cells || (cells.axes == axes && cells.motors == motors.size() &&
                                           cells.room.size() >= cells.stride() &&
                                           cells.suprema.size() == cells.line.cells * cells.stride()));
  if (is_complete) return Done{};
  return Error{
      .code = ErrorCode::wrong_count,
      .what = "there are not as many limits, peaks or cells as axes and motors",
      .remedy = "give a limit for every axis, a peak for every axis and motor, and each in every cell",
      .needed = static_cast<std::int64_t>(axes + motors.size())};
}

/// The memory of a trajectory holds the rolls of so many axes at a time.
Status take_rolls(std::span<const RollAxis> rolls, const MoveBoundsMemory& memory, MoveBounds& out) {
  for (std::size_t d = 0; d < rolls.size(); ++d) out.peaks[d].raise(rolls[d].peaks());
  if (out.cells.line.cells == 0) return Done{};
  for (std::size_t first = 0; first < rolls.size();) {
    // One at least: where there is no room for it, raise_cells says so.
    const std::size_t room = std::max<std::size_t>(memory.trajectory.values.size() / 6, 1);
    const std::size_t axes = std::min({rolls.size() - first, max_trajectory_axes, room});
    const Status raised = raise_cells(rolls.subspan(first, axes), first, out.cells, memory.trajectory);
    if (!raised) return raised;
    first += axes;
  }
  return Done{};
}

Status take_rolls_of_motors(std::span<const RollAxis> rolls, std::span<const CalibratedMotor> motors,
                            const MoveBoundsMemory& memory, MoveBounds& out) {
  for (std::size_t m = 0; m < motors.size() && !rolls.empty(); ++m) {
    const Result<Trajectory> fitted =
        fit_motor(rolls[motors[m].axis], *motors[m].calibration, memory.motor_joints, memory.motor);
    if (!fitted) return fitted.error();
    take_motor(*fitted, fitted->begin(), fitted->end(), rolls.size() + m, out);
  }
  return Done{};
}

/// A peak that was found later may be one beside which an earlier step is rounding.
void drop_rounding(std::span<const AxisLimits> limits, MoveBounds& out) {
  const std::size_t kept = std::min(out.step_count, out.steps.size());
  std::size_t count = 0;
  for (std::size_t i = 0; i < kept; ++i) {
    MoveStep step = out.steps[i];
    if (is_step(step, out.peaks[step.axis], limits)) out.steps[count++] = step;
  }
  out.step_count -= kept - count;
}

}  // namespace

Status bound_move(const Move& move, std::span<const Track> tracks, std::span<const AxisLimits> limits,
                  std::span<const CalibratedMotor> motors, const MoveBoundsMemory& memory, MoveBounds& out) {
  if (const Status checked = check(move, tracks, limits, motors, out); !checked) return checked;
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (AxisPeaks& axis : out.peaks)
    axis = {
        .lowest = {infinity, 0}, .highest = {-infinity, 0}, .velocity = {}, .acceleration = {}, .jerk = {}};
  std::ranges::fill(out.cells.suprema, MotionTriple{});
  out.step_count = 0;
  std::size_t first_axis = 0;
  for (std::size_t t = 0; t < tracks.size(); ++t) {
    const Status bounded = TrackBounding(move, tracks[t], t, first_axis, limits, motors, memory, out).run();
    if (!bounded) return bounded;
    first_axis += static_cast<std::size_t>(tracks[t].path().axis_count());
  }
  for (const std::span<const RollAxis> rolls : {move.rolls().before, move.rolls().after}) {
    const Status rolled = take_rolls(rolls, memory, out);
    if (!rolled) return rolled;
    const Status moved = take_rolls_of_motors(rolls, motors, memory, out);
    if (!moved) return moved;
  }
  drop_rounding(limits, out);
  return Done{};
}

}  // namespace inbetween
