#include "editor/solver/certificate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "inbetween/limits/motion_steps.hpp"

namespace inbetween::editor {
namespace {

/// `check` has the same bounds: it refines nothing that is further from its limit than this share of it, and
/// takes a step below this share of the peak or the limit for rounding.
constexpr double slack_share = 1e-6;
constexpr double step_rounding = 1e-9;
/// `check` takes as many cells, up to max_cells: one for a frame, and none shorter than two ticks.
std::size_t cells_for(const Move<double>& move, double tick_seconds) {
  constexpr double min_cells = 64;
  const double frames = move.last_frame() - move.first_frame();
  const double ticks = std::ceil(frames / move.frame_rate().frames_per_second() / tick_seconds);
  const double wanted = std::clamp(frames, min_cells, static_cast<double>(max_cells));
  return static_cast<std::size_t>(std::max(std::floor(std::min(wanted, ticks / 2)), 1.0));
}

MotionTriple<double> slack_of(const AxisLimits<double>& axis, double share) {
  return {share * axis.max_velocity(), share * axis.max_acceleration(), share * axis.max_jerk().value_or(0)};
}

void raise(Peak<double>& peak, const Peak<double>& found) {
  if (found.value > peak.value) peak = found;
}

void raise(AxisPeaks<double>& axis, const AxisPeaks<double>& found) {
  if (found.lowest.value < axis.lowest.value) axis.lowest = found.lowest;
  raise(axis.highest, found.highest);
  raise(axis.velocity, found.velocity);
  raise(axis.acceleration, found.acceleration);
  raise(axis.jerk, found.jerk);
}

double without_rounding(double step, const Peak<double>& peak, double limit) {
  const double largest = std::max(std::isfinite(peak.value) ? peak.value : 0, limit);
  return step > step_rounding * largest ? step : 0;
}

}  // namespace

Status Certificate::make(std::span<const Track<double>> tracks, std::span<const AxisLimits<double>> limits,
                         double tick_seconds) {
  limits_ = limits;
  cells_ = step_count_ = steps_left_out_ = 0;
  highest_rate_ = 0;
  move_.reset();
  stops_.reset();
  stop_obstacle_.reset();
  roll_obstacle_.reset();
  MoveRolls<double> rolls;
  if (has_limits()) {
    if (const Status rolled = make_rolls(tracks, rolls); !rolled) return rolled;
  }
  const auto move = Move<double>::make(tracks, rolls);
  if (!move) return move.error();
  move_ = *move;
  axes_ = move->axis_count();
  if (!has_limits()) return Done{};
  if (const Status bounded = bound_peaks(); !bounded) return bounded;
  list_steps();
  if (const Status stopped = bound_stops(tick_seconds); !stopped) return stopped;
  find_ceiling();
  find_highest_rate();
  return Done{};
}

Status Certificate::make_rolls(std::span<const Track<double>> tracks, MoveRolls<double>& rolls) {
  const std::span<AxisMotion<double>> joints = std::span(joints_).first(limits_.size());
  for (const RollEnd end : {RollEnd::before, RollEnd::after}) {
    if (!joints_of(tracks, end, joints)) continue;
    const bool is_before = end == RollEnd::before;
    const RollRequest<double> request{.end = end,
                                      .joint_frame = is_before ? 0 : tracks.front().frames(),
                                      .fps = tracks.front().frame_rate(),
                                      .joints = joints,
                                      .limits = limits_};
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

Status Certificate::bound_peaks() {
  std::size_t first = 0;
  for (const Track<double>& track : move_->tracks()) {
    const auto axes = static_cast<std::size_t>(track.path().axis_count());
    const std::span<MotionTriple<double>> slack = std::span(storage_.slack).first(axes);
    for (std::size_t d = 0; d < axes; ++d) slack[d] = slack_of(limits_[first + d], slack_share);
    const Status bounded =
        bound_motion<double>(track, slack, {storage_.turns}, std::span(peaks_).subspan(first, axes));
    if (!bounded) return bounded;
    first += axes;
  }
  for (const std::span<const RollAxis<double>> roll : {move_->rolls().before, move_->rolls().after}) {
    for (std::size_t d = 0; d < roll.size(); ++d) raise(peaks_[d], roll[d].peaks());
  }
  return Done{};
}

void Certificate::add_step(const KeyStep& step) {
  if (!(step.velocity > 0 || step.acceleration > 0)) return;
  if (step_count_ == max_steps) {
    ++steps_left_out_;
  } else {
    steps_[step_count_++] = step;
  }
}

void Certificate::list_steps() {
  std::array<AxisStep<double>, max_axes> out;
  std::int32_t first = 0;
  std::int32_t index = 0;
  for (const Track<double>& track : move_->tracks()) {
    const std::int32_t axes = track.path().axis_count();
    const std::span<AxisStep<double>> found = std::span(out).first(static_cast<std::size_t>(axes));
    const auto add = [&](std::int32_t key, double frame) {
      for (std::int32_t d = 0; d < axes; ++d) {
        const auto a = static_cast<std::size_t>(first + d);
        const AxisStep<double>& step = found[static_cast<std::size_t>(d)];
        add_step(
            {index, key, frame, first + d,
             without_rounding(step.velocity, peaks_[a].velocity, limits_[a].max_velocity()),
             without_rounding(step.acceleration, peaks_[a].acceleration, limits_[a].max_acceleration())});
      }
    };
    for (std::int32_t i = 0; i <= track.path().segment_count(); ++i) {
      const double frame = steps_at_key<double>(track, i, found);
      const bool is_joined = (frame <= 0 && is_moving(track, RollEnd::before)) ||
                             (frame >= track.frames() && is_moving(track, RollEnd::after));
      if (!is_joined) add(track.path().key_at(i).value_or(-1), frame);
      if (i == track.path().segment_count()) break;
      const Standstills<double> standstills = standstills_within(track, i);
      for (std::size_t k = 0; k < standstills.count; ++k) {
        const double turn = steps_at_standstill<double>(track, {i, standstills.t[k]}, found);
        add(-1, turn);
      }
    }
    first += axes;
    ++index;
  }
}

Status Certificate::bound_stops(double tick_seconds) {
  cells_ = cells_for(*move_, tick_seconds);
  const StopRequest<double> request{.move = *move_, .limits = limits_, .tick_seconds = tick_seconds};
  const StopBoundsMemory<double> memory{.cells = std::span(storage_.cells).first(cells_ + 1),
                                        .suprema = storage_.suprema,
                                        .slack = storage_.slack,
                                        .turns = storage_.turns};
  const auto bounds = StopBounds<double>::make(request, memory, {});
  if (bounds) {
    stops_ = *bounds;
    return Done{};
  }
  if (bounds.error().code != ErrorCode::no_solution) return bounds.error();
  const auto obstacle = inbetween::stop_obstacle(request, memory);
  if (!obstacle) return obstacle.error();
  stop_obstacle_ = *obstacle;
  return Done{};
}

void Certificate::find_ceiling() {
  constexpr double closeness = 1e-3;  // less than a pixel of a picture
  const std::span<MotionTriple<double>> slack = std::span(storage_.slack).first(axes_);
  for (std::size_t d = 0; d < axes_; ++d) slack[d] = slack_of(limits_[d], closeness);
  const MotionCells<double> cells{
      .cells = cells_, .slack = slack, .suprema = std::span(storage_.suprema).first(cells_ * axes_)};
  bound_cells<double>(*move_, storage_.turns, cells);
  std::size_t first = 0;
  for (std::size_t t = 0; t < move_->tracks().size(); ++t) {
    const std::size_t end = first + static_cast<std::size_t>(move_->tracks()[t].path().axis_count());
    for (std::size_t cell = 0; cell < cells_; ++cell) {
      CellCeiling ceiling{.rate = std::numeric_limits<double>::infinity()};
      for (std::size_t d = first; d < end; ++d) lower(ceiling, cells.suprema[cell * axes_ + d], d);
      ceilings_[t * cells_ + cell] = ceiling;
    }
    first = end;
  }
}

void Certificate::lower(CellCeiling& ceiling, const MotionTriple<double>& suprema, std::size_t axis) const {
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
  std::array<PlayedAxis<double>, max_move_axes> played;
  for (std::size_t d = 0; d < axes_; ++d) played[d] = {.peaks = peaks_[d]};
  bool steps = false;
  for (const KeyStep& step : this->steps()) {
    double& largest = played[static_cast<std::size_t>(step.axis)].acceleration_step;
    largest = std::max(largest, step.acceleration);
    steps = steps || step.velocity > 0;
  }
  highest_rate_ = steps ? 0 : inbetween::highest_rate<double>(std::span(played).first(axes_), limits_);
}

}  // namespace inbetween::editor
