#include "inbetween/play/frame_shoot.hpp"

#include <array>

namespace inbetween {
namespace {

constexpr std::array<const char*, shoot_phases> phase_names{"idle",     "travelling", "settling", "standing",
                                                            "exposing", "waiting",    "done"};

Error not_now(const char* what) {
  return {.code = ErrorCode::out_of_range, .what = what, .remedy = "wait until it rests"};
}

}  // namespace

template <Precise Real>
Exposure<Real> FrameShoot<Real>::exposure_of(std::int32_t frame) const {
  const FrameTime<Real> at{frame, 0};
  return {moved_by(at, spec_.shutter->open), moved_by(at, spec_.shutter->close), spec_.exposure_s};
}

template <Precise Real>
Status FrameShoot<Real>::check() const {
  if (!spec_.shutter) return Done{};
  // The trial works on a copy, so that a check moves nothing and leaves no event behind.
  Playhead<Real> trial = *moving_;
  for (std::int32_t frame = 0; frame <= frames_; ++frame) {
    // The run-up to each frame starts at rest, wherever the trial before left the playhead.
    trial.halt();
    const Status possible = trial.go_to_run_up(exposure_of(frame));
    if (possible) continue;
    Error error = possible.error();
    error.frame = frame;
    return error;
  }
  return Done{};
}

template <Precise Real>
Status FrameShoot<Real>::can_leave(std::int32_t frame) const {
  if (frame < 0 || frame > frames_) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "there is no such frame",
                 .remedy = "name one from 0 to the last frame of the move",
                 .frame = frame};
  }
  if (phase_ == ShootPhase::exposing) return not_now("the camera is exposing");
  if (!rests()) return not_now("the rig is on its way");
  return Done{};
}

template <Precise Real>
Status FrameShoot<Real>::shoot(std::int32_t frame) {
  if (const Status possible = can_leave(frame); !possible) return possible;
  const Status goes = spec_.shutter ? moving_->go_to_run_up(exposure_of(frame)) : moving_->go_to(frame);
  if (!goes) return goes;
  // Axes that rest during the exposure go to the frame itself, not to the start of the run-up.
  if (still_ != nullptr) {
    if (const Status follows = still_->go_to(frame); !follows) return follows;
  }
  frame_ = frame;
  only_looks_ = false;
  phase_ = ShootPhase::travelling;
  return Done{};
}

template <Precise Real>
Status FrameShoot<Real>::look_at(std::int32_t frame) {
  if (const Status possible = can_leave(frame); !possible) return possible;
  if (const Status goes = moving_->go_to(frame); !goes) return goes;
  if (still_ != nullptr) {
    if (const Status follows = still_->go_to(frame); !follows) return follows;
  }
  frame_ = frame;
  only_looks_ = true;
  phase_ = ShootPhase::travelling;
  return Done{};
}

template <Precise Real>
Status FrameShoot<Real>::trigger() {
  switch (phase_) {
    case ShootPhase::standing:
      return shoot(frame_);
    case ShootPhase::waiting:
      if (frame_ < frames_) return shoot(frame_ + 1);
      phase_ = ShootPhase::done;
      return Done{};
    case ShootPhase::exposing:
      if (!is_exposed_) return not_now("the camera is exposing");
      // The shutter has closed already, so this trigger can only mean the next frame.
      goes_on_ = true;
      return Done{};
    case ShootPhase::travelling:
    case ShootPhase::settling:
      return not_now("the rig is on its way");
    case ShootPhase::idle:
    case ShootPhase::done:
      break;
  }
  return Error{.code = ErrorCode::out_of_range, .what = "nothing is being shot", .remedy = "start first"};
}

template <Precise Real>
void FrameShoot<Real>::interrupt() {
  camera_ = false;
  if (phase_ != ShootPhase::done) phase_ = ShootPhase::idle;
}

template <Precise Real>
void FrameShoot<Real>::tick(PlayheadEvent event) {
  switch (phase_) {
    case ShootPhase::travelling:
      if (!rests()) return;
      // Both playheads rest. A time of 0 ticks exposes in this very tick, without a tick of waiting.
      ticks_left_ = spec_.settle_ticks;
      phase_ = ShootPhase::settling;
      [[fallthrough]];
    case ShootPhase::settling:
      if (ticks_left_-- > 0) return;
      if (only_looks_) {
        phase_ = ShootPhase::standing;
      } else {
        expose();
      }
      return;
    case ShootPhase::exposing:
      if (!spec_.shutter) {
        if (--ticks_left_ == 0) end_exposure();
        return;
      }
      // The playhead tells the exact ticks. This class only passes them on to the camera.
      if (event == PlayheadEvent::opened) camera_ = true;
      if (event == PlayheadEvent::closed) {
        camera_ = false;
        is_exposed_ = true;
      }
      if (event == PlayheadEvent::arrived) end_exposure();
      return;
    case ShootPhase::idle:
    case ShootPhase::standing:
    case ShootPhase::waiting:
    case ShootPhase::done:
      return;
  }
}

template <Precise Real>
void FrameShoot<Real>::expose() {
  phase_ = ShootPhase::exposing;
  is_exposed_ = false;
  goes_on_ = false;
  if (!spec_.shutter) {
    camera_ = true;
    ticks_left_ = spec_.exposure_ticks;
  } else if (!moving_->expose(exposure_of(frame_))) {
    interrupt();  // cannot be: it stands where its run-up starts, which was found by the same arithmetic
  }
}

template <Precise Real>
void FrameShoot<Real>::end_exposure() {
  camera_ = false;
  ++exposures_;
  phase_ = ShootPhase::waiting;
  if (goes_on_ && !trigger()) interrupt();  // check() has tried every frame
}

const char* name_of(ShootPhase phase) {
  return phase_names[static_cast<std::size_t>(phase)];
}

template class FrameShoot<double>;
template class FrameShoot<float>;

}  // namespace inbetween
