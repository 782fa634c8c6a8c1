#include "host_tools/motions/shooting.hpp"

#include <algorithm>
#include <cmath>

#include "host_tools/files/diagnostics.hpp"

namespace inbetween {

ShootSpec shoot_spec(const ShootOptions& options, const RigFile& rig) {
  const std::int32_t rate_hz = rig.rate_hz;
  // The play of a gear that was being crossed, and back where the axis has turned again meanwhile.
  double take_up_s = 0;
  for (const RigAxis& axis : rig.axes) {
    if (axis.backlash) take_up_s = std::max(take_up_s, 2 * axis.backlash->take_up_s + 2.0 / rate_hz);
  }
  const auto ticks = [&](double seconds) { return static_cast<std::int64_t>(std::ceil(seconds * rate_hz)); };
  return {.settle_ticks = ticks(options.settle_s + take_up_s),
          .exposure_ticks = std::max<std::int64_t>(ticks(options.exposure_s), 1),
          .shutter = options.shutter,
          .exposure_s = options.exposure_s};
}

WholeFrames shot_frames(const MoveFile& move, const ShootOptions& options) {
  const std::int32_t last = options.is_loop ? move.frames - 1 : move.frames;
  return frames_of(options.frames, {0, last}, {move.path, 0, 0});
}

Shooting::Shooting(RunLoop& loop, StagedMove& staged, SimulatedCamera& camera, const ShootOptions& options,
                   bool is_attended, const ShootingLines& lines)
    : loop_(loop),
      spec_(staged.loop_spec()),
      camera_(camera),
      frames_(staged.plan().move().frames),
      due_(shot_frames(staged.plan().move(), options)),
      shots_(static_cast<std::size_t>(due_.last - due_.first) + 1),
      shoot_(shoot_spec(options, *staged.plan().rig()),
             {.last = frames_, .first = due_.first, .shots = shots_, .rests = staged.rests()},
             staged.playhead(), staged.still()),
      keys_(loop, is_attended),
      lines_(lines) {}

Status Shooting::begin() {
  if (const Status loaded = loop_.load(spec_); !loaded) return loaded;
  if (const Status begun = loop_.begin(); !begun) return begun;
  return shoot_.look_at(shoot_.frame());
}

void Shooting::press(TransportKey key) {
  if (keys_.press(key)) return;
  switch (key) {
    case TransportKey::pause:
      keys_.say(shoot_.trigger());
      return;
    case TransportKey::expose:
      keys_.say(shoot_.shoot_again());
      return;
    case TransportKey::start:
      // A key that begins after a stop, pressed once too often, exposes nothing.
      if (keys_.is_running()) {
        keys_.say("it runs already; space shoots");
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
  if (result.state != SupervisorState::running) {
    if (shoot_.camera()) {
      ++cut_off_;
      log(false);
    }
    shoot_.interrupt();
  }
  const std::int64_t before = shoot_.exposures();
  shoot_.tick(result.event);
  if (shoot_.exposures() != before) log(true);
  camera_.signal(shoot_.camera());
  if (lines_.cues != nullptr) lines_.cues->signal(shoot_.camera(), now_ns);
  // One that nobody waits for is dropped, as a key would be: the rig does not start later for it.
  const bool asks = lines_.asks && lines_.asks(now_ns);
  const bool waits = shoot_.phase() == ShootPhase::standing || shoot_.phase() == ShootPhase::waiting;
  if (asks || (waits && camera_.asks())) keys_.say(shoot_.trigger());
  if (is_done() && loop_.state() == SupervisorState::running) keys_.say(loop_.finish());
}

void Shooting::log(bool is_whole) {
  if (lines_.log == nullptr) return;
  lines_.log->take({.frame = shoot_.frame(), .shots = shoot_.shots(shoot_.frame()), .is_whole = is_whole});
}

ShootCount Shooting::count() const {
  ShootCount count{.first = due_.first, .last = due_.last, .cut_off = cut_off_};
  std::int32_t missing = 0;
  for (std::int32_t frame = due_.first; frame <= due_.last; ++frame) {
    const std::int32_t shots = shoot_.shots(frame);
    if (shots == 0) {
      ++missing;
      continue;
    }
    ++count.shot;
    if (shots > 1) ++count.shot_again;
    count.skipped = missing;
    count.last_shot = frame;
  }
  count.left = missing - count.skipped;
  return count;
}

RunSnapshot Shooting::snapshot() const {
  return {.state = loop_.state(),
          .share = static_cast<double>(shoot_.frame()) / std::max(frames_, 1),
          .words = keys_.words(),
          .shoot = ShootSnapshot{.phase = shoot_.phase(),
                                 .frame = shoot_.frame(),
                                 .frames = frames_,
                                 .exposures = shoot_.exposures(),
                                 .is_shot = shoot_.shots(shoot_.frame()) > 0,
                                 .is_due = shoot_.is_due(shoot_.frame()),
                                 .next = shoot_.next_frame(),
                                 .camera = shoot_.camera()}};
}

}  // namespace inbetween
