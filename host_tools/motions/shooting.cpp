#include "host_tools/motions/shooting.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host_tools/check/check.hpp"

namespace inbetween {

ShootSpec<double> shoot_spec(const ShootOptions& options, std::int32_t rate_hz) {
  const auto ticks = [&](double seconds) { return static_cast<std::int64_t>(std::ceil(seconds * rate_hz)); };
  return {.settle_ticks = ticks(options.settle_s),
          .exposure_ticks = std::max<std::int64_t>(ticks(options.exposure_s), 1),
          .shutter = options.shutter,
          .exposure_s = options.exposure_s};
}

std::int32_t last_shot(const MoveFile& move, const ShootOptions& options) {
  return options.is_loop ? move.frames - 1 : move.frames;
}

void refuse_exposures(StagedMove& staged, const ShootOptions& options) {
  const MoveFile& move = staged.plan().move();
  const ShootSpec<double> spec = shoot_spec(options, staged.plan().rig()->rate_hz);
  const Status possible =
      FrameShoot<double>(spec, last_shot(move, options), staged.playhead(), nullptr).check();
  if (possible) return;
  throw LimitError(move.frames_place,
                   fmt::format("frame {} cannot be exposed in motion: {}; {}", possible.error().frame,
                               possible.error().what, possible.error().remedy));
}

Status Shooting::begin() {
  if (const Status loaded = loop_.load(spec_); !loaded) return loaded;
  if (const Status begun = loop_.begin(); !begun) return begun;
  return shoot_.shoot(shoot_.frame());
}

void Shooting::press(TransportKey key) {
  if (keys_.press(key)) return;
  switch (key) {
    case TransportKey::pause:
      keys_.say(shoot_.trigger());
      return;
    case TransportKey::start:
      if (keys_.is_running()) {
        keys_.say(shoot_.trigger());
        return;
      }
      keys_.say(begin());
      if (keys_.is_running()) keys_.begun();
      return;
    case TransportKey::step_forward:
      return look(1);
    case TransportKey::step_backward:
      return look(-1);
    default:
      keys_.say("not while a move is shot frame by frame");
      return;
  }
}

void Shooting::look(int by) {
  if (!keys_.is_running()) {
    keys_.say("nothing runs");
    return;
  }
  keys_.say(shoot_.look_at(shoot_.frame() + by));
}

void Shooting::tick(std::int32_t ticks, std::int64_t now_ns) {
  const LoopTick result = loop_.tick(ticks, now_ns);
  keys_.note(result);
  if (result.state != SupervisorState::running) shoot_.interrupt();
  shoot_.tick(result.event);
  camera_.signal(shoot_.camera());
  if (lines_.cues != nullptr) lines_.cues->signal(shoot_.camera(), now_ns);
  // One that nobody waits for is dropped, as a key would be: the rig does not start later for it.
  const bool asks = lines_.asks && lines_.asks(now_ns);
  if (camera_.has_triggered() || asks) keys_.say(shoot_.trigger());
  if (is_done() && loop_.state() == SupervisorState::running) keys_.say(loop_.finish());
}

RunSnapshot Shooting::snapshot() const {
  return {.state = loop_.state(),
          .share = static_cast<double>(shoot_.frame()) / std::max(frames_, 1),
          .words = keys_.words(),
          .shoot = ShootSnapshot{.phase = shoot_.phase(),
                                 .frame = shoot_.frame(),
                                 .frames = frames_,
                                 .exposures = shoot_.exposures(),
                                 .camera = shoot_.camera()}};
}

}  // namespace inbetween
