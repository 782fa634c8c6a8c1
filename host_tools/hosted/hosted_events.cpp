// What the loop of a hosted rig tells, and what of that the host hears.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host_tools/hosted/hosted_rig.hpp"
#include "host_tools/text/diagnostics.hpp"

namespace inbetween {

using namespace dragonframe;

namespace {

/// As long as `jog` waits before it writes where the axes rest.
constexpr std::int64_t rest_before_kept_ns = 500'000'000;

bool is_stopped(SupervisorState state) {
  return state == SupervisorState::stopping || state == SupervisorState::latched ||
         state == SupervisorState::faulted || state == SupervisorState::cut_off;
}

}  // namespace

std::optional<RigEvent> HostedRig::take_event() {
  if (events_.empty()) return std::nullopt;
  const RigEvent event = events_.front();
  events_.pop_front();
  return event;
}

void HostedRig::look() {
  while (const std::optional<MotionState> now = motion_.take_state()) note(*now);
  drop_retired();
  show();
  keep_places();
}

void HostedRig::note(const MotionState& now) {
  const SupervisorState was = now_.state;
  now_ = now;
  if (now.heard == sent_) pending_ = 0;
  note_stop(was);
  note_frames(now);
  if (now.refused != refused_) note_refusal(now);
  const bool rests = pending_ == 0 && now.moving == 0 && !now.plays;
  if (rests) note_rest();
}

void HostedRig::note_stop(SupervisorState was) {
  if (!is_stopped(now_.state) || is_stopped(was)) return;
  if (phase_ == Phase::none && was != SupervisorState::ready && was != SupervisorState::running) return;
  words_.push_back(now_.lost_time
                       ? "a tick came so late that an axis would have jumped, and the rig was stopped"
                       : fmt::format("the rig was stopped: {}", name_of(now_.state)));
  leave_frame();
  drop_prepared();
  begin_phase(Phase::stopping, 0);
  tell(HardStop{.reason = now_.lost_time ? HardStopReason::exception : HardStopReason::general});
}

void HostedRig::note_refusal(const MotionState& now) {
  refused_ = now.refused;
  words_.push_back(fmt::format("the rig did not begin it: {}", now.why));
  if (phase_ == Phase::none || phase_ == Phase::stopping) return;
  leave_frame();
  drop_prepared();
  begin_phase(Phase::stopping, 0);
  tell(HardStop{.reason = HardStopReason::exception});
}

/// Tells every frame that was passed since the last look, in its order.
void HostedRig::note_frames(const MotionState& now) {
  if (!told_frames_ || !now.plays || now.heard != sent_ || now.state == SupervisorState::ready) return;
  const HostFrames& frames = *told_frames_;
  const double time = now.time.frame + now.time.fraction;
  if (now.repeats != told_repeats_ && time < told_time_) told_time_ = -1;  // round again
  told_repeats_ = now.repeats;
  const auto tell_frame = [&](std::int32_t of_line) {
    const std::int32_t k = of_line - frames.before;
    if (frames.are_told && k >= 0 && k <= frames.count)
      tell(FrameReached{frames.first + frames.direction * k});
  };
  if (time > told_time_) {
    for (auto k = static_cast<std::int32_t>(std::floor(told_time_)) + 1; k <= time; ++k) tell_frame(k);
  } else {
    for (auto k = static_cast<std::int32_t>(std::ceil(told_time_)) - 1; k >= time; --k) tell_frame(k);
  }
  told_time_ = time;
  const bool is_behind = phase_ == Phase::running && time >= frames.before + frames.count;
  if (is_behind && !run_.comes_round && !has_ended_) {
    has_ended_ = true;
    tell(MoveEnded{});
  }
}

/// What was under way is over, and what follows begins.
void HostedRig::note_rest() {
  switch (phase_) {
    case Phase::none:
    case Phase::waiting:
      return;
    case Phase::going:
    case Phase::along:
    case Phase::stopping:
      at_frame_ = goal_frame_;
      told_frames_.reset();
      if (at_frame_ && phase_ != Phase::stopping) tell(FrameReached{*at_frame_});
      begin_phase(Phase::none, 0);
      return tell(AtRest{});
    case Phase::approach:
      at_frame_ = goal_frame_;
      told_frames_.reset();
      if (at_frame_) tell(FrameReached{*at_frame_});
      tell(Approached{});
      if (go_to_start() == RigAnswer::ok) return;
      drop_prepared();
      begin_phase(Phase::none, 0);
      return tell(HardStop{.reason = HardStopReason::exception});
    case Phase::to_start:
      begin_phase(Phase::waiting, 0);
      return tell(InPlace{});
    case Phase::running:
      if (!has_ended_) tell(MoveEnded{});
      told_frames_.reset();
      drop_prepared();
      begin_phase(Phase::none, 0);
      return tell(AtRest{});
  }
}

void HostedRig::show() {
  for (std::size_t a = 0; a < scales_.size(); ++a)
    state_.positions.at(a) = scales_[a].whole_steps(commanded(a));
  state_.moving = now_.moving | pending_;
  if (phase_ == Phase::approach || phase_ == Phase::to_start || phase_ == Phase::running)
    state_.moving |= phase_motors_;
  if (told_frames_ && told_frames_->are_told) {
    const HostFrames& frames = *told_frames_;
    const double frame = frames.first + frames.direction * (std::max(told_time_, 0.0) - frames.before);
    state_.move_time = static_cast<std::int32_t>(std::lround(frame * 1000));
  } else if (at_frame_) {
    state_.move_time = *at_frame_ * 1000;
  }
}

void HostedRig::keep_places() {
  const bool rests = state_.moving == 0 && !now_.plays && now_.state == SupervisorState::ready;
  if (!rests) rested_ns_ = now_.now_ns;
  if (!is_marked_ || now_.now_ns - rested_ns_ < rest_before_kept_ns) return;
  is_marked_ = false;
  if (!options_.keep) return;
  try {
    options_.keep({now_.drives.begin(), now_.drives.begin() + static_cast<std::ptrdiff_t>(scales_.size())});
  } catch (const std::runtime_error& error) {
    words_.emplace_back(error.what());
  }
}

}  // namespace inbetween
