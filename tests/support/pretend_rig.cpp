#include "tests/support/pretend_rig.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

namespace inbetween::dragonframe {

constexpr double pretend_tick_s = 0.02;

RigAnswer PretendRig::take(const RigOrder& order) {
  orders.push_back(order);
  const RigAnswer answer = judge ? judge(order) : RigAnswer::ok;
  if (answer == RigAnswer::ok) std::visit([&](const auto& what) { apply(what); }, order);
  return answer;
}

bool PretendRig::was_moved() const {
  return std::any_of(orders.begin(), orders.end(), [](const RigOrder& order) {
    return std::holds_alternative<MoveMotor>(order) || std::holds_alternative<JogMotor>(order) ||
           std::holds_alternative<GoToFrame>(order) || std::holds_alternative<JogAll>(order) ||
           std::holds_alternative<PrepareRun>(order) || std::holds_alternative<PrepareShot>(order) ||
           std::holds_alternative<Go>(order);
  });
}

void PretendRig::begin(Phase phase) {
  phase_ = phase;
  phase_s_ = 0;
}

void PretendRig::apply(const MoveMotor& order) {
  const std::size_t i = order.motor - 1U;
  targets_.at(i) = order.target;
  speeds_.at(i) = settings_.at(i).max_velocity;
  if (!settings_.at(i).is_live) phase_ = Phase::none;
}

void PretendRig::apply(const JogMotor& order) {
  apply(MoveMotor{.motor = order.motor, .target = order.destination});
  speeds_.at(order.motor - 1U) *= order.speed / 10'000.0;
}

void PretendRig::apply(const StopAll& /*order*/) {
  targets_ = {};
  says_rest_ = true;
  phase_ = Phase::none;
}

void PretendRig::apply(const GoToFrame& order) {
  frame_ = order.frame;
  state_.move_time = order.frame * 1000;
  for (std::uint8_t motor = 1; motor <= max_motors; ++motor) {
    if ((order.motors & mask_of(motor)) == 0) continue;
    apply(
        MoveMotor{.motor = motor, .target = static_cast<std::int32_t>(move_->position(motor, order.frame))});
  }
}

void PretendRig::apply(const JogAll& order) {
  motors_ = order.motors;
  fps_ = order.frames_per_1000_s / 1000.0;
  frame_to_ = order.frame;
  begin(Phase::along);
}

void PretendRig::apply(const PrepareRun& order) {
  run_ = order;
  shot_.reset();
  motors_ = order.motors;
  fps_ = order.frames_per_1000_s / 1000.0;
  frame_to_ = order.start;
  begin(Phase::approach);
}

void PretendRig::apply(const PrepareShot& order) {
  shot_ = order;
  run_.reset();
  for (const ShotMotor& motor : order.motors) apply(MoveMotor{.motor = motor.motor, .target = motor.start});
  for (std::uint8_t motor = 1; motor <= max_motors; ++motor) {
    if ((order.resting & mask_of(motor)) == 0) continue;
    apply(MoveMotor{.motor = motor, .target = order.rest.at(motor - 1U)});
  }
  begin(Phase::to_start);
}

void PretendRig::apply(const Go& /*order*/) {
  if (run_) {
    frame_from_ = run_->start;
    frame_to_ = run_->end + (run_->end >= run_->start ? 1 : -1);
    begin(Phase::preroll);
    return;
  }
  begin(Phase::shot);
}

void PretendRig::apply(const StopLoop& /*order*/) {
  run_->is_loop = false;
  run_->is_ping_pong = false;
}

void PretendRig::follow_targets() {
  for (std::size_t i = 0; i < max_motors; ++i) {
    if (!targets_[i]) continue;
    const double way = static_cast<double>(*targets_[i]) - state_.positions[i];
    const double step = std::clamp(way, -speeds_[i] * pretend_tick_s, speeds_[i] * pretend_tick_s);
    if (way == step) targets_[i].reset();
    state_.positions[i] += static_cast<std::int32_t>(std::trunc(step));
    state_.moving |= MotorMask{1} << i;
  }
}

void PretendRig::stand_at(double frame) {
  frame_ = frame;
  state_.move_time = static_cast<std::int32_t>(std::lround(frame * 1000));
  for (std::uint8_t motor = 1; motor <= max_motors; ++motor) {
    if ((motors_ & mask_of(motor)) == 0) continue;
    state_.positions.at(motor - 1U) = static_cast<std::int32_t>(std::lround(move_->position(motor, frame)));
  }
  state_.moving |= motors_;
}

/// To frame_to_, with every frame that is crossed.
void PretendRig::tick_along(std::vector<RigEvent>& events) {
  const double before = frame_;
  const double way = frame_to_ - before;
  const double step = fps_ * pretend_tick_s;
  stand_at(std::abs(way) <= step ? frame_to_ : before + std::copysign(step, way));
  if (std::floor(frame_) != std::floor(before) || frame_ == frame_to_) {
    events.emplace_back(FrameReached{static_cast<std::int32_t>(std::lround(frame_))});
  }
  if (frame_ != frame_to_) return;
  events.emplace_back(Approached{});
  if (phase_ == Phase::along) return begin(Phase::none);
  for (std::uint8_t motor = 1; motor <= max_motors; ++motor) {
    if ((motors_ & mask_of(motor)) != 0)
      apply(MoveMotor{.motor = motor, .target = run_->preroll.at(motor - 1U)});
  }
  begin(Phase::to_start);
}

void PretendRig::tick_playing(std::vector<RigEvent>& events) {
  const double direction = frame_to_ > frame_from_ ? 1 : -1;
  const double played = std::min(phase_s_ * fps_, std::abs(frame_to_ - frame_from_));
  const double before = frame_;
  stand_at(frame_from_ + direction * played);
  const bool is_first = phase_s_ <= pretend_tick_s;
  const double last = direction > 0 ? frame_to_ - 1 : frame_to_ + 1;
  const double shown = direction > 0 ? std::floor(frame_) : std::ceil(frame_);
  const double shown_before = direction > 0 ? std::floor(before) : std::ceil(before);
  if ((is_first || shown != shown_before) && direction * (last - shown) >= 0) {
    events.emplace_back(FrameReached{static_cast<std::int32_t>(shown)});
  }
  if (frame_ != frame_to_) return;
  if (run_->is_ping_pong) std::swap(frame_from_, frame_to_);
  if (run_->is_ping_pong || run_->is_loop) return begin(Phase::playing);
  events.emplace_back(MoveEnded{});
  begin(Phase::postroll);
}

/// What follows Go.
void PretendRig::tick_go(std::vector<RigEvent>& events) {
  phase_s_ += pretend_tick_s;
  if (phase_ == Phase::preroll) {
    state_.moving |= motors_;
    const double before_start_s = run_->preroll_ms / 1000.0 - phase_s_;
    state_.move_time =
        static_cast<std::int32_t>(std::lround((run_->start - before_start_s * fps_) * 1000)) - 1;
    if (before_start_s <= 0) begin(Phase::playing);
  } else if (phase_ == Phase::playing) {
    tick_playing(events);
  } else if (phase_ == Phase::postroll) {
    state_.moving |= motors_;
    if (phase_s_ * 1000 < run_->postroll_ms) return;
    says_rest_ = true;
    begin(Phase::none);
  } else {
    bool is_over = true;
    for (const ShotMotor& motor : shot_->motors) {
      double position = motor.start;
      double left = phase_s_;
      for (const ShotPiece& piece : motor.pieces) {
        const double in = std::clamp(left, 0.0, piece.seconds);
        const double share = piece.seconds > 0 ? in / piece.seconds : 0;
        position += in * (piece.from + (piece.to - piece.from) * share / 2);
        left -= piece.seconds;
      }
      if (left < 0) is_over = false;
      state_.positions.at(motor.motor - 1U) = static_cast<std::int32_t>(std::lround(position));
      state_.moving |= mask_of(motor.motor);
    }
    if (!is_over) return;
    events.emplace_back(MoveEnded{});
    says_rest_ = true;
    begin(Phase::none);
  }
}

std::vector<RigEvent> PretendRig::tick() {
  std::vector<RigEvent> events;
  state_.moving = 0;
  follow_targets();
  if (phase_ == Phase::along || phase_ == Phase::approach) {
    tick_along(events);
  } else if (phase_ == Phase::to_start) {
    if (state_.moving == 0) {
      events.emplace_back(InPlace{});
      begin(Phase::waiting);
    }
  } else if (phase_ != Phase::none && phase_ != Phase::waiting) {
    tick_go(events);
  } else if (says_rest_ && state_.moving == 0) {
    events.emplace_back(AtRest{});
    says_rest_ = false;
  }
  return events;
}

}  // namespace inbetween::dragonframe
