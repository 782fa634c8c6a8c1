#include "editor/solver/certificate.hpp"

#include <cmath>
#include <limits>

namespace inbetween::editor {
Status Certificate::make(std::span<const Track> tracks, std::span<const AxisLimits> limits,
                         std::span<const CalibratedMotor> motors, std::int32_t rate_hz) {
  tracks_ = tracks;
  limits_ = limits;
  motors_ = motors;
  rate_hz_ = rate_hz;
  axes_ = 0;
  for (const Track& track : tracks) axes_ += static_cast<std::size_t>(track.path().axis_count());
  cells_ = step_count_ = 0;
  highest_rate_ = 0;
  move_.reset();
  stops_.reset();
  stop_obstacle_.reset();
  roll_obstacle_.reset();
  MoveRolls rolls;
  if (has_limits()) {
    if (const Status rolled = make_rolls(rolls); !rolled) return rolled;
  }
  const auto move = Move::make(tracks, rolls);
  if (!move) return move.error();
  move_ = *move;
  if (!has_limits()) return Done{};
  if (const Status bounded = bound(); !bounded) return bounded;
  highest_rate_ = inbetween::highest_rate(judged()).whole;
  return Done{};
}

void Certificate::motion(const FrameTime& time, std::span<AxisMotion> out) const {
  const std::span<const RollAxis> rolls = move_->rolls_at(time);
  for (std::size_t d = 0; d < rolls.size(); ++d) out[d] = rolls[d].motion(time);
  if (!rolls.empty()) return;
  for (const Track& track : tracks_) {
    const std::span<AxisMotion> axes = out.first(static_cast<std::size_t>(track.path().axis_count()));
    out = out.subspan(axes.size());
    static_cast<void>(track.motion(move_->within_part(time), axes));
    if (!move_->rests_at(time)) continue;
    for (AxisMotion& axis : axes) axis = {.position = axis.position};
  }
}

Status Certificate::make_rolls(MoveRolls& rolls) {
  const auto of_axes = [&](auto& memory) { return std::span(memory).first(axes_); };
  const WholeFrames whole{0, tracks_.front().frames()};
  const auto joined =
      join_rolls(tracks_, {}, axis_limits(), whole, {of_axes(joints_), of_axes(before_), of_axes(after_)});
  if (!joined) return joined.error();
  rolls = joined->rolls;
  for (const std::optional<RollObstacle>& obstacle : joined->obstacles) {
    if (obstacle && !roll_obstacle_) roll_obstacle_ = obstacle->breach;
  }
  return Done{};
}

Status Certificate::bound() {
  cells_ = stop_cells(*move_, rate_hz_, 1);
  write_room(limits_, 1, tick_seconds(), storage_.room);
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
  const StopRequest request{.motion = motion, .limits = limits_, .tick_seconds = tick_seconds()};
  const auto bounds =
      StopBounds::make(request, std::span(stop_cells_).first(cells_ + 1), {}, &stop_obstacle_);
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
  const AxisLimits& limits = limits_[axis];
  const double jerk = limits.max_jerk().value_or(std::numeric_limits<double>::infinity());
  // A magnitude of 0 gives an infinite rate: this axis does not hold the ceiling down.
  const std::array rates{limits.max_velocity() / suprema[0],
                         std::sqrt(limits.max_acceleration() / suprema[1]), std::cbrt(jerk / suprema[2])};
  for (std::size_t i = 0; i < rates.size(); ++i) {
    if (!(rates[i] < ceiling.rate)) continue;
    ceiling = {rates[i], static_cast<std::int32_t>(axis), static_cast<std::int32_t>(i)};
  }
}

std::optional<Breach> Certificate::first_breach() const {
  if (const std::optional<Breach> found = inbetween::first_breach(judged())) return found;
  if (roll_obstacle_) {
    const RollBreach& roll = *roll_obstacle_;
    return Breach{BreachKind::roll, roll.axis,  static_cast<std::int32_t>(roll.quantity),
                  roll.value,       roll.limit, roll.frame};
  }
  if (stop_obstacle_) {
    const StopObstacle& stop = *stop_obstacle_;
    return Breach{BreachKind::stop, stop.axis,  static_cast<std::int32_t>(stop.quantity),
                  stop.value,       stop.limit, stop.frame};
  }
  return std::nullopt;
}

}  // namespace inbetween::editor
