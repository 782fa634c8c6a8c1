#include "inbetween/homing/homing.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace inbetween {
namespace {

HomingSignal signal_of(SwitchChange change) {
  switch (change) {
    case SwitchChange::noise:
      return HomingSignal::noise;
    case SwitchChange::activated:
      return HomingSignal::activated;
    case SwitchChange::released:
      return HomingSignal::released;
    case SwitchChange::edge:
    case SwitchChange::none:
      break;
  }
  return HomingSignal::edge;
}

Error refusal(const char* what, const char* remedy) {
  return {.code = ErrorCode::out_of_range, .what = what, .remedy = remedy};
}

Error not_now(const char* what, const char* remedy) {
  return {.code = ErrorCode::wrong_state, .what = what, .remedy = remedy};
}

}  // namespace

Result<AxisHoming> AxisHoming::make(const HomingSpec& spec, FreeAxis& axis) {
  for (const double number : {spec.at, spec.fast, spec.slow, spec.search, spec.leave, spec.back_off}) {
    if (!std::isfinite(number)) {
      return Error{.code = ErrorCode::not_finite,
                   .what = "a number of the homing is not finite",
                   .remedy = "give numbers"};
    }
  }
  for (const double magnitude : {spec.fast, spec.slow, spec.search, spec.leave, spec.back_off}) {
    if (!(magnitude > 0)) {
      return refusal("a distance or a speed of the homing is not above 0",
                     "give distances and speeds as magnitudes");
    }
  }
  if (spec.slow > spec.fast || spec.fast > axis.limits().velocity) {
    return refusal("a speed of the homing is too high",
                   "give a slow one up to the fast one, and that up to the velocity of the axis");
  }
  const Result<SwitchInput> input = SwitchInput::make(spec.home);
  if (!input) return input.error();
  return AxisHoming(spec, *input, axis);
}

/// The furthest that any phase may bring the axis from its start.
double AxisHoming::reach() const {
  const FreeAxisLimits& limits = axis_->limits();
  // A stop from `fast` takes at most velocity / acceleration + acceleration / jerk seconds.
  const double stop = spec_.fast * (spec_.fast / limits.acceleration + limits.acceleration / limits.jerk);
  return spec_.search + spec_.leave + 4 * (spec_.back_off + spike_distance() + stop);
}

/// A spike or a bounce that counted as the first edge of the fast search makes it early by at most this
/// distance.
double AxisHoming::spike_distance() const {
  constexpr double second = 1'000'000'000;
  return spec_.fast * 4 * (static_cast<double>(spec_.home.quiet_ns) / second);
}

Status AxisHoming::can_begin(const HomingInput& input) const {
  if (is_moving() || !axis_->is_resting()) return not_now("an axis moves already", "stop it first");
  if (input.limit_hit) {
    return not_now("an axis stands on a limit switch",
                   "drive it off the switch, slowly, and look where it goes");
  }
  if (input.drive_fault) return not_now("the drive of an axis has a fault", "see what the drive tells");
  const double here = axis_->position();
  // A position far from 0 resolves no short distance: the axis would back off by nothing, for ever.
  if (!(std::fabs(here) + reach() <= Precision::largest && here - spec_.back_off < here &&
        here + spec_.back_off > here)) {
    return refusal("the distances of the homing are too far to be computed",
                   "shorten them, or begin with a position near 0");
  }
  return Done{};
}

bool AxisHoming::is_moving() const {
  return phase_ != HomingPhase::waiting && phase_ != HomingPhase::referenced && phase_ != HomingPhase::failed;
}

void AxisHoming::begin(std::int64_t now_ns, const HomingInput& input) {
  start_ = axis_->position();
  failure_ = HomingFailure::none;
  phase_ = HomingPhase::waiting;
  is_located_ = false;
  shift_ = 0;
  trail_.clear();
  // The trail must have a setpoint before the first tick: an edge may come at once.
  trail_.push(now_ns, axis_->state());
  switch_.start(now_ns, input.level);
  // The soft limits of the rig mean nothing yet, because nobody knows where the axis is. The longest distance
  // bounds it.
  if (!axis_->set_range(start_ - reach(), start_ + reach())) __builtin_trap();
  apply(HomingSignal::begin);
}

void AxisHoming::observe(std::int64_t now_ns, const HomingInput& input, std::span<const LineEvent> events) {
  if (!is_moving()) return;
  const SwitchChange change = switch_.update(now_ns, input.level, events);
  // This comes before the phases, because a stop may begin in this tick and the trail forgets.
  if (change != SwitchChange::none || switch_.is_changing()) locate_edge();
  if (phase_ == HomingPhase::stopping) {
    if (axis_->is_resting()) apply(HomingSignal::rested_off);
    return;
  }
  // A fault comes before the switch: the edge of a chattering switch must not become the reference.
  if (const HomingFailure found = fault(input); found != HomingFailure::none) {
    fail(found);
    return;
  }
  if (change != SwitchChange::none) apply(signal_of(change));
  // An axis at rest tells nothing while its switch bounces: the level may still be either.
  if (axis_->is_resting() && !switch_.is_changing()) {
    apply(switch_.is_active() ? HomingSignal::rested_on : HomingSignal::rested_off);
  }
}

HomingFailure AxisHoming::fault(const HomingInput& input) const {
  if (input.drive_fault) return HomingFailure::drive_fault;
  if (input.limit_hit) return HomingFailure::limit_hit;
  if (switch_.has_lost_events()) return HomingFailure::events_lost;
  if (switch_.is_chattering()) return HomingFailure::chattering;
  return HomingFailure::none;
}

/// Looks up the position of an edge as soon as its time is known, because the trail is short.
void AxisHoming::locate_edge() {
  if (is_located_ && switch_.edge_ns() == located_ns_) return;
  located_ns_ = switch_.edge_ns();
  const std::optional<double> position = trail_.position_at(located_ns_);
  is_located_ = switch_.is_timed() && position.has_value();
  edge_ = position.value_or(axis_->position());
}

void AxisHoming::apply(HomingSignal signal) {
  const HomingStep step = homing_step(phase_, signal);
  phase_ = step.phase;
  if (step.failure != HomingFailure::none) failure_ = step.failure;
  act(step.action);
}

void AxisHoming::act(HomingAction action) {
  switch (action) {
    case HomingAction::leave:
      go_to(start_ - towards(spec_.leave), spec_.fast);
      break;
    case HomingAction::search:
      go_to(start_ + towards(spec_.search), spec_.fast);
      break;
    case HomingAction::stop:
      axis_->stop();
      break;
    case HomingAction::mark_stop:
      axis_->stop();
      [[fallthrough]];
    case HomingAction::mark:
      mark();
      break;
    case HomingAction::clear:
      mark_ = edge_;
      [[fallthrough]];
    case HomingAction::back_off:
      go_to(mark_ - towards(spec_.back_off), spec_.fast);
      break;
    case HomingAction::approach:
      go_to(mark_ + towards(spec_.back_off + spike_distance()), spec_.slow);
      break;
    case HomingAction::refer:
      shift_ = spec_.at - mark_;
      break;
    case HomingAction::none:
      break;
  }
}

/// The slow approach is only as good as the time of its edge.
void AxisHoming::mark() {
  mark_ = edge_;
  if (phase_ == HomingPhase::latching && !is_located_) fail(HomingFailure::events_lost);
}

void AxisHoming::fail(HomingFailure failure) {
  if (homing_step(phase_, HomingSignal::abort).phase == phase_) return;
  failure_ = failure;
  apply(HomingSignal::abort);
}

/// The range has room for every distance, so that nothing is refused.
void AxisHoming::go_to(double position, double speed) {
  if (!axis_->go_to(position, speed)) __builtin_trap();
}

void AxisHoming::halt() {
  axis_->halt();
  if (!is_moving()) return;
  if (failure_ == HomingFailure::none) failure_ = HomingFailure::stopped;
  apply(HomingSignal::cut);
}

Status Homing::start(std::int64_t now_ns, std::span<const HomingInput> inputs) {
  if (inputs.size() != axes_.size()) {
    return Error{.code = ErrorCode::wrong_count,
                 .what = "the homing has not an input for every axis",
                 .remedy = "give one for each",
                 .needed = static_cast<std::int64_t>(axes_.size())};
  }
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const Status possible = axes_[i].can_begin(inputs[i]);
    if (possible) continue;
    Error error = possible.error();
    error.axis = static_cast<std::int32_t>(i);
    return error;
  }
  failed_axis_ = -1;
  for (std::size_t i = 0; i < axes_.size(); ++i) axes_[i].begin(now_ns, inputs[i]);
  return Done{};
}

HomingState Homing::tick(std::int64_t now_ns, std::span<const HomingInput> inputs,
                         std::span<const LineEvent> events, std::span<Setpoint> out) {
  if (inputs.size() < axes_.size() || out.size() < axes_.size()) __builtin_trap();
  for (std::size_t i = 0; i < axes_.size(); ++i) axes_[i].observe(now_ns, inputs[i], events);
  // The first failure stops the others. Their own failure is then `other_axis`, so the operator sees the
  // cause.
  for (std::size_t i = 0; i < axes_.size() && failed_axis_ < 0; ++i) {
    const HomingFailure failure = axes_[i].failure();
    if (failure == HomingFailure::none || failure == HomingFailure::stopped) continue;
    failed_axis_ = static_cast<std::int32_t>(i);
    stop_all_for(HomingFailure::other_axis);
  }
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    out[i] = axes_[i].axis_->tick();
    axes_[i].trail_.push(now_ns + delay_ns_, out[i]);
  }
  return state();
}

void Homing::stop() {
  stop_all_for(HomingFailure::stopped);
}

void Homing::stop_all_for(HomingFailure failure) {
  for (AxisHoming& axis : axes_) axis.fail(failure);
}

void Homing::halt() {
  for (AxisHoming& axis : axes_) axis.halt();
}

HomingState Homing::state() const {
  const auto is = [](HomingPhase phase) {
    return [phase](const AxisHoming& axis) { return axis.phase() == phase; };
  };
  if (std::ranges::all_of(axes_, is(HomingPhase::waiting))) return HomingState::waiting;
  if (std::ranges::any_of(axes_, &AxisHoming::is_moving)) return HomingState::moving;
  return std::ranges::any_of(axes_, is(HomingPhase::failed)) ? HomingState::failed : HomingState::done;
}

}  // namespace inbetween
