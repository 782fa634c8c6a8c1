#include "sim/simulated_stepper.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace inbetween {
namespace {

bool is_curve(const SimulatedStepper::Settings& settings) {
  double last = -1;
  for (const TorquePoint& point : settings.torque) {
    if (!std::isfinite(point.steps_per_s) || point.steps_per_s <= last) return false;
    if (!std::isfinite(point.torque_nm) || point.torque_nm < 0) return false;
    last = point.steps_per_s;
  }
  if (settings.torque.empty()) return true;
  return settings.start_rate > 0 && settings.torque[0].steps_per_s <= settings.start_rate;
}

bool is_amount(double number) {
  return std::isfinite(number) && number >= 0;
}

}  // namespace

Result<SimulatedStepper> SimulatedStepper::make(const Settings& settings, double position) {
  const bool is_scaled = std::isfinite(settings.steps_per_unit) && settings.steps_per_unit != 0 &&
                         std::isfinite(settings.steps_per_turn) && settings.steps_per_turn > 0;
  const bool is_body = is_amount(settings.inertia_kg_m2) && is_amount(settings.friction_nm) &&
                       is_amount(settings.start_rate) && std::isfinite(position);
  const bool has_lines = StepMerge::make({&settings.lines, 1}).has_value();
  if (!is_scaled || !is_body || !has_lines || !is_curve(settings)) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "the figures are not those of a stepper motor",
                 .remedy =
                     "give a scale other than 0, nothing negative, and a curve whose rates grow from "
                     "the start rate or below"};
  }
  return SimulatedStepper(settings, position);
}

Status SimulatedStepper::take(const EdgeInstant& instant) {
  if (instant.at_ns < last_ns_) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "an instant lies before the last one",
                 .remedy = "give them in the order of time"};
  }
  const std::int64_t at_ns = last_ns_ = instant.at_ns;
  const auto level_after = [&](std::int32_t line, bool before) {
    const std::uint64_t bit = std::uint64_t{1} << line;
    return (instant.mask & bit) != 0 ? (instant.levels & bit) != 0 : before;
  };
  const StepTiming& timing = settings_.lines.timing;
  const bool step = level_after(settings_.lines.step, step_level_);
  const bool dir = level_after(settings_.lines.dir, dir_level_);

  // Which of two lines that change at once is first is not known: DIR is not settled at a rising edge then.
  if (dir != dir_level_) {
    if (step_level_ || at_ns - fall_ns_ < timing.dir_hold_ns) ++violations_.dir_hold;
    dir_level_ = dir;
    dir_ns_ = at_ns;
  }
  if (step && !step_level_) {
    if (at_ns - fall_ns_ < timing.pause_ns) ++violations_.pause;
    if (at_ns - dir_ns_ < timing.dir_setup_ns) ++violations_.dir_setup;
    rise_ns_ = at_ns;
    this->step(at_ns);
  } else if (!step && step_level_) {
    if (at_ns - rise_ns_ < timing.pulse_ns) ++violations_.pulse;
    fall_ns_ = at_ns;
  }
  step_level_ = step;
  return Done{};
}

void SimulatedStepper::step(std::int64_t at_ns) {
  const std::int64_t step = dir_level_ ? 1 : -1;
  count_ += step;

  const double period_ns = static_cast<double>(at_ns - step_ns_);
  step_ns_ = at_ns;
  const bool is_slow = period_ns * settings_.start_rate >= 1e9;
  if (is_slow || run_up_ != dir_level_) run_ = 0;
  run_up_ = dir_level_;
  std::shift_right(run_ns_.begin(), run_ns_.end(), 1);
  run_ns_[0] = at_ns;
  run_ = std::min(run_ + 1, run_ns_.size());

  if (is_stalled_) {
    is_stalled_ = !is_slow;
  } else if (!follows()) {
    is_stalled_ = true;
    ++stalls_;
  }
  if (is_stalled_) {
    ++lost_;
  } else {
    made_ += step;
  }
}

/// Whether the motor has the torque for the last steps.
bool SimulatedStepper::follows() const {
  if (settings_.torque.empty() || run_ < 2) return true;
  const auto seconds = [&](std::size_t newer, std::size_t older) {
    return static_cast<double>(std::max<std::int64_t>(1, run_ns_.at(newer) - run_ns_.at(older))) * 1e-9;
  };
  double rate = 1 / seconds(0, 1);
  double acceleration = (rate - settings_.start_rate) / (seconds(0, run_ - 1) - seconds(0, 1) / 2);
  if (run_ == run_ns_.size()) {
    rate = 2 / seconds(0, 2);
    acceleration = (rate - 2 / seconds(2, 4)) / (seconds(0, 4) / 2);
  }
  const double radians_per_step = 2 * std::numbers::pi / settings_.steps_per_turn;
  return std::fabs(settings_.inertia_kg_m2 * acceleration * radians_per_step + settings_.friction_nm) <=
         available_nm(rate);
}

double SimulatedStepper::available_nm(double steps_per_s) const {
  const auto& curve = settings_.torque;
  if (steps_per_s <= curve[0].steps_per_s) return curve[0].torque_nm;
  for (std::size_t i = 1; i < curve.size(); ++i) {
    if (steps_per_s > curve[i].steps_per_s) continue;
    const double share =
        (steps_per_s - curve[i - 1].steps_per_s) / (curve[i].steps_per_s - curve[i - 1].steps_per_s);
    return std::lerp(curve[i - 1].torque_nm, curve[i].torque_nm, share);
  }
  return 0;
}

}  // namespace inbetween
