#include "inbetween/play/frame_shoot.hpp"

#include <algorithm>
#include <array>

namespace inbetween {
namespace {

constexpr std::array<const char*, shoot_phases> phase_names{"idle",     "travelling", "settling", "standing",
                                                            "exposing", "waiting",    "done"};

Error not_now(const char* what) {
  return {.code = ErrorCode::wrong_state, .what = what, .remedy = "wait until it rests"};
}

}  // namespace

Exposure FrameShoot::exposure_of(std::int32_t frame) const {
  const FrameTime at{frame, 0};
  return {moved_by(at, spec_.shutter->open), moved_by(at, spec_.shutter->close), spec_.exposure_s};
}

Status FrameShoot::check() const {
  if (!spec_.shutter) return Done{};
  for (std::size_t i = 0; i < frames_.shots.size(); ++i) {
    const std::int32_t frame = frames_.first + static_cast<std::int32_t>(i);
    const Result<ExposureTravel> course = moving_->travel_of(exposure_of(frame));
    if (course && !rest_between(course->from, course->to)) continue;
    Error error = course ? Error{.code = ErrorCode::no_solution,
                                 .what = "the motion steps while the rig exposes it",
                                 .remedy =
                                     "let the speed touch 0 there with ease = true or corners = \"ease\", "
                                     "or shoot with --step"}
                         : course.error();
    error.frame = frame;
    return error;
  }
  return Done{};
}

Status FrameShoot::can_leave(std::int32_t frame) const {
  if (frame < 0 || frame > frames_.last) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "there is no such frame",
                 .remedy = "name one from 0 to the last frame of the move",
                 .frame = frame};
  }
  if (phase_ == ShootPhase::exposing) return not_now("the camera is exposing");
  if (!rests()) return not_now("the rig is on its way");
  return Done{};
}

/// The first rest strictly between two places, seen from `from`.
std::optional<FrameTime> FrameShoot::rest_between(const FrameTime& from, const FrameTime& to) const {
  const bool is_forward = from < to;
  std::optional<FrameTime> first;
  for (const FrameTime& rest : frames_.rests) {
    const bool is_between = is_forward ? from < rest && rest < to : to < rest && rest < from;
    if (!is_between) continue;
    first = rest;
    if (is_forward) break;
  }
  return first;
}

Status FrameShoot::travel(Playhead& playhead, const FrameTime& to, bool is_run_up) {
  if (const auto rest = rest_between(playhead.time(), to)) return playhead.go_to(*rest);
  return is_run_up ? playhead.go_to_run_up(exposure_of(frame_)) : playhead.go_to(to);
}

/// Towards the frame, as far as the next rest. Axes that rest during an exposure go to the frame itself, not
/// to the start of the run-up.
Status FrameShoot::travel() {
  const bool runs_up = spec_.shutter && !only_looks_;
  if (const Status goes = travel(*moving_, stand_, runs_up); !goes) return goes;
  return still_ != nullptr ? travel(*still_, {frame_, 0}, false) : Status(Done{});
}

bool FrameShoot::has_arrived() const {
  return moving_->time() == stand_ && (still_ == nullptr || still_->time() == FrameTime{frame_, 0});
}

Status FrameShoot::shoot(std::int32_t frame) {
  if (const Status possible = can_leave(frame); !possible) return possible;
  if (!is_due(frame)) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "this frame is not one of those that are shot",
                 .remedy = "go on to one that is",
                 .frame = frame};
  }
  FrameTime stand{frame, 0};
  if (spec_.shutter) {
    const Result<ExposureTravel> course = moving_->travel_of(exposure_of(frame));
    if (!course) return course.error();
    stand = course->from;
  }
  frame_ = frame;
  stand_ = stand;
  only_looks_ = false;
  phase_ = ShootPhase::travelling;
  return travel();
}

Status FrameShoot::look_at(std::int32_t frame) {
  if (const Status possible = can_leave(frame); !possible) return possible;
  frame_ = frame;
  stand_ = {frame, 0};
  only_looks_ = true;
  phase_ = ShootPhase::travelling;
  return travel();
}

std::optional<std::int32_t> FrameShoot::next_frame() const {
  const std::int32_t end = frames_.first + static_cast<std::int32_t>(frames_.shots.size());
  for (std::int32_t next = std::max(frame_ + 1, frames_.first); next < end; ++next) {
    if (shots_of(next) == 0) return next;
  }
  return std::nullopt;
}

Status FrameShoot::go_on() {
  if (const auto next = next_frame()) return shoot(*next);
  phase_ = ShootPhase::done;
  return Done{};
}

Status FrameShoot::trigger() {
  switch (phase_) {
    case ShootPhase::standing:
      return is_due(frame_) && shots_of(frame_) == 0 ? shoot(frame_) : go_on();
    case ShootPhase::waiting:
      return go_on();
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
  return Error{.code = ErrorCode::wrong_state, .what = "nothing is being shot", .remedy = "start first"};
}

Status FrameShoot::shoot_again() {
  if (phase_ == ShootPhase::standing || phase_ == ShootPhase::waiting) return shoot(frame_);
  return phase_ == ShootPhase::exposing ? not_now("the camera is exposing")
                                        : not_now("the rig does not stand on a frame");
}

void FrameShoot::interrupt() {
  camera_ = false;
  if (phase_ != ShootPhase::done) phase_ = ShootPhase::idle;
}

void FrameShoot::tick(PlayheadEvent event) {
  switch (phase_) {
    case ShootPhase::travelling:
      if (!rests()) return;
      if (!has_arrived()) {
        if (!travel()) interrupt();  // cannot be: it has got this far by the same arithmetic
        return;
      }
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

void FrameShoot::expose() {
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

void FrameShoot::end_exposure() {
  camera_ = false;
  ++exposures_;
  ++shots_of(frame_);
  phase_ = ShootPhase::waiting;
  if (goes_on_ && !trigger()) interrupt();  // check() has tried every frame
}

const char* name_of(ShootPhase phase) {
  return phase_names[static_cast<std::size_t>(phase)];
}

}  // namespace inbetween
