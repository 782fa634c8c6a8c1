#include "editor/solver/certificate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace inbetween::editor {
Status Certificate::make(std::span<const Track<double>> tracks, std::span<const AxisLimits<double>> limits,
                         std::span<const CalibratedMotor> motors, std::int32_t rate_hz) {
  tracks_ = tracks;
  limits_ = limits;
  motors_ = motors;
  rate_hz_ = rate_hz;
  axes_ = 0;
  for (const Track<double>& track : tracks) axes_ += static_cast<std::size_t>(track.path().axis_count());
  cells_ = step_count_ = 0;
  highest_rate_ = 0;
  move_.reset();
  stops_.reset();
  stop_obstacle_.reset();
  roll_obstacle_.reset();
  MoveRolls<double> rolls;
  if (has_limits()) {
    if (const Status rolled = make_rolls(rolls); !rolled) return rolled;
  }
  const auto move = Move<double>::make(tracks, rolls);
  if (!move) return move.error();
  move_ = *move;
  if (!has_limits()) return Done{};
  if (const Status bounded = bound(); !bounded) return bounded;
  find_highest_rate();
  return Done{};
}

void Certificate::motion(const FrameTime<double>& time, std::span<AxisMotion<double>> out) const {
  const std::span<const RollAxis<double>> rolls = move_->rolls_at(time);
  for (std::size_t d = 0; d < rolls.size(); ++d) out[d] = rolls[d].motion(time);
  if (!rolls.empty()) return;
  for (const Track<double>& track : tracks_) {
    const std::span<AxisMotion<double>> axes = out.first(static_cast<std::size_t>(track.path().axis_count()));
    out = out.subspan(axes.size());
    static_cast<void>(track.motion(move_->within_part(time), axes));
    if (!move_->rests_at(time)) continue;
    for (AxisMotion<double>& axis : axes) axis = {.position = axis.position};
  }
}

Status Certificate::make_rolls(MoveRolls<double>& rolls) {
  const std::span<AxisMotion<double>> joints = std::span(joints_).first(axes_);
  for (const RollEnd end : {RollEnd::before, RollEnd::after}) {
    if (!joints_of(tracks_, end, joints)) continue;
    const bool is_before = end == RollEnd::before;
    const RollRequest<double> request{.end = end,
                                      .joint_frame = is_before ? 0 : tracks_.front().frames(),
                                      .fps = tracks_.front().frame_rate(),
                                      .joints = joints,
                                      .limits = axis_limits()};
    const auto obstacle = inbetween::roll_obstacle(request);
    if (!obstacle) return obstacle.error();
    if (*obstacle) {
      if (!roll_obstacle_) roll_obstacle_ = **obstacle;
      continue;
    }
    const auto frames = roll_frames(request);
    if (!frames) return frames.error();
    const RollSpan span{end, request.joint_frame, *frames, request.fps};
    const std::span<RollAxis<double>> axes = std::span(is_before ? before_ : after_).first(joints.size());
    for (std::size_t d = 0; d < joints.size(); ++d) {
      const auto roll = RollAxis<double>::make(span, joints[d]);
      if (!roll) return roll.error();
      axes[d] = *roll;
    }
    (is_before ? rolls.before : rolls.after) = axes;
  }
  return Done{};
}

Status Certificate::bound() {
  cells_ = stop_cells(*move_, rate_hz_, 1);
  write_room<double>(limits_, 1, tick_seconds(), storage_.room);
  MoveBounds bounds = storage_.bounds(*move_, cells_, motors_.size());
  MoveBoundsMemory memory = storage_.memory();
  memory.motor_joints = motor_joints_;
  memory.motor = motor_.memory();
  const Status bounded = bound_move(*move_, tracks_, axis_limits(), motors_, memory, bounds);
  if (!bounded) return bounded;
  step_count_ = bounds.step_count;
  find_ceiling(bounds.cells);
  return bound_stops(bounds.cells);  // it widens the cells
}

Status Certificate::bound_stops(const MotionCells& motion) {
  const StopRequest<double> request{.motion = motion, .limits = limits_, .tick_seconds = tick_seconds()};
  const auto bounds =
      StopBounds<double>::make(request, std::span(stop_cells_).first(cells_ + 1), {}, &stop_obstacle_);
  if (bounds) {
    stops_ = *bounds;
  } else if (!stop_obstacle_) {
    return bounds.error();
  }
  return Done{};
}

void Certificate::find_ceiling(const MotionCells& motion) {
  std::size_t first = 0;
  for (std::size_t t = 0; t < tracks_.size(); ++t) {
    const std::size_t end = first + static_cast<std::size_t>(tracks_[t].path().axis_count());
    for (std::size_t cell = 0; cell < cells_; ++cell) {
      CellCeiling ceiling{.rate = std::numeric_limits<double>::infinity()};
      for (std::size_t d = first; d < end; ++d) lower(ceiling, motion.of_cell(cell)[d], d);
      for (std::size_t m = 0; m < motors_.size(); ++m) {
        const bool is_of_track = motors_[m].axis >= first && motors_[m].axis < end;
        if (is_of_track) lower(ceiling, motion.of_cell(cell)[axes_ + m], axes_ + m);
      }
      ceilings_[t * cells_ + cell] = ceiling;
    }
    first = end;
  }
}

void Certificate::lower(CellCeiling& ceiling, const MotionTriple& suprema, std::size_t axis) const {
  const AxisLimits<double>& limits = limits_[axis];
  const double jerk = limits.max_jerk().value_or(std::numeric_limits<double>::infinity());
  // A magnitude of 0 gives an infinite rate: nothing of this axis is in the way.
  const std::array rates{limits.max_velocity() / suprema[0],
                         std::sqrt(limits.max_acceleration() / suprema[1]), std::cbrt(jerk / suprema[2])};
  for (std::size_t i = 0; i < rates.size(); ++i) {
    if (!(rates[i] < ceiling.rate)) continue;
    ceiling = {rates[i], static_cast<std::int32_t>(axis), static_cast<std::int32_t>(i)};
  }
}

void Certificate::find_highest_rate() {
  std::array<PlayedAxis<double>, max_moved> played;
  for (std::size_t d = 0; d < peaks().size(); ++d) played[d] = {.peaks = peaks()[d]};
  bool steps = false;
  for (const MoveStep& step : this->steps()) {
    double& largest = played[step.axis].acceleration_step;
    largest = std::max(largest, step.acceleration);
    steps = steps || step.velocity > 0;
  }
  highest_rate_ =
      steps ? 0 : inbetween::highest_rate<double>(std::span(played).first(peaks().size()), limits_);
}

std::optional<Breach> Certificate::first_breach() const {
  for (std::size_t moved = 0; moved < peaks().size(); ++moved) {
    if (const std::optional<Breach> found = breach_of(moved)) return found;
  }
  if (roll_obstacle_) {
    const RollBreach<double>& roll = *roll_obstacle_;
    return Breach{BreachKind::roll, roll.axis,  static_cast<std::int32_t>(roll.quantity),
                  roll.value,       roll.limit, roll.frame};
  }
  if (stop_obstacle_) {
    const StopObstacle<double>& stop = *stop_obstacle_;
    return Breach{BreachKind::stop, stop.axis,  static_cast<std::int32_t>(stop.quantity),
                  stop.value,       stop.limit, stop.frame};
  }
  return std::nullopt;
}

std::optional<Breach> Certificate::breach_of(std::size_t moved) const {
  const AxisPeaks<double>& peak = peaks()[moved];
  const AxisLimits<double>& limits = limits_[moved];
  const auto breach = [&](BreachKind kind, double value, double limit, double frame) {
    return Breach{kind, static_cast<std::int32_t>(moved), 0, value, limit, frame};
  };
  // The range of a motor is that of its axis.
  if (const double rounding = position_rounding(limits.min(), limits.max()); moved < axes_) {
    if (peak.lowest.value < limits.min() - rounding)
      return breach(BreachKind::below_range, peak.lowest.value, limits.min(), peak.lowest.frame);
    if (peak.highest.value > limits.max() + rounding)
      return breach(BreachKind::above_range, peak.highest.value, limits.max(), peak.highest.frame);
  }
  constexpr double none = std::numeric_limits<double>::infinity();
  constexpr std::array kinds{BreachKind::velocity, BreachKind::acceleration, BreachKind::jerk};
  const std::array<const Peak<double>*, 3> found{&peak.velocity, &peak.acceleration, &peak.jerk};
  const std::array most{limits.max_velocity(), limits.max_acceleration(), limits.max_jerk().value_or(none)};
  for (std::size_t q = 0; q < found.size(); ++q) {
    if (!(found[q]->value <= most[q])) return breach(kinds[q], found[q]->value, most[q], found[q]->frame);
  }
  for (const MoveStep& step : steps()) {
    if (step.axis != moved) continue;
    if (step.velocity > 0) return breach(BreachKind::velocity_step, step.velocity, 0, step.frame);
    const double allowed = limits.max_jerk() ? limits.max_acceleration_step() : none;
    if (step.acceleration > allowed)
      return breach(BreachKind::acceleration_step, step.acceleration, allowed, step.frame);
  }
  return std::nullopt;
}

}  // namespace inbetween::editor
