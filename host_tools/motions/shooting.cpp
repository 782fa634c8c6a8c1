#include "host_tools/motions/shooting.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "host_tools/text/diagnostics.hpp"

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

std::vector<std::int32_t> shots_before(const MoveFile& move, const ShootOptions& options) {
  const WholeFrames due = shot_frames(move, options);
  std::vector<std::int32_t> shots(static_cast<std::size_t>(due.last - due.first) + 1);
  for (const LoggedShot& shot : options.before) {
    const bool is_due = shot.frame >= due.first && shot.frame <= due.last;
    if (is_due && shot.is_whole) ++shots[static_cast<std::size_t>(shot.frame - due.first)];
  }
  return shots;
}

std::int32_t first_frame_of(const MoveFile& move, const ShootOptions& options) {
  const std::vector<std::int32_t> shots = shots_before(move, options);
  const auto missing = std::ranges::find(shots, 0);
  const std::int32_t first = shot_frames(move, options).first;
  return missing == shots.end() ? first : first + static_cast<std::int32_t>(missing - shots.begin());
}

Shooting::Shooting(RunLoop& loop, StagedMove& staged, SimulatedCamera& camera, const ShootOptions& options,
                   bool is_attended, const ShootingLines& lines)
    : loop_(loop),
      spec_(staged.loop_spec()),
      camera_(camera),
      frames_(staged.plan().move().frames),
      due_(shot_frames(staged.plan().move(), options)),
      shots_(shots_before(staged.plan().move(), options)),
      shoot_(shoot_spec(options, *staged.plan().rig()),
             {.last = frames_, .first = due_.first, .shots = shots_, .rests = staged.rests()},
             staged.playhead(), staged.still()),
      shot_before_(std::accumulate(shots_.begin(), shots_.end(), std::int64_t{0})),
      begins_on_(first_frame_of(staged.plan().move(), options)),
      keys_(loop, is_attended),
      lines_(lines) {}

Status Shooting::begin() {
  if (const Status loaded = loop_.load(spec_); !loaded) return loaded;
  if (const Status begun = loop_.begin(); !begun) return begun;
  const std::int32_t frame = begins_on_.value_or(shoot_.frame());
  begins_on_.reset();
  return shoot_.look_at(frame);
}

void Shooting::press(TransportKey key) {
  const bool is_of_entry = entry_.press(key);
  if (is_of_entry) keys_.say("");
  if (const auto place = entry_.take()) {
    place->is_key ? keys_.say("frames are shot: g goes to one") : look_at(place->number);
  }
  if (is_of_entry || keys_.press(key)) return;
  if (const int direction = direction_of(key); direction != 0) return look_at(shoot_.frame() + direction);
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
    case TransportKey::tells_releases:
    case TransportKey::still_held:
    case TransportKey::let_go:
      return;
    default:
      keys_.say("not while a move is shot frame by frame");
      return;
  }
}

void Shooting::look_at(std::int32_t frame) {
  if (!keys_.is_running()) {
    keys_.say("nothing runs");
    return;
  }
  keys_.say(shoot_.look_at(frame));
}

void Shooting::tick(std::int32_t ticks, std::int64_t now_ns) {
  const bool moves = loop_.state() == SupervisorState::running || loop_.state() == SupervisorState::stopping;
  const LoopTick result = loop_.tick(ticks, now_ns);
  played_.reset();
  if (moves && loop_.sends_setpoints()) played_ = {place_of(*spec_.playhead), 0};
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
  ShootCount count = ShootCount::of(due_.first, shots_);
  count.cut_off = cut_off_;
  return count;
}

RunSnapshot Shooting::snapshot() const {
  return {.state = loop_.state(),
          .share = static_cast<double>(shoot_.frame()) / std::max(frames_, 1),
          .words = keys_.words(),
          .entry = entry_.shown(),
          .shoot = ShootSnapshot{.phase = shoot_.phase(),
                                 .frame = shoot_.frame(),
                                 .frames = frames_,
                                 .exposures = shot_before_ + shoot_.exposures(),
                                 .is_shot = shoot_.shots(shoot_.frame()) > 0,
                                 .is_due = shoot_.is_due(shoot_.frame()),
                                 .next = shoot_.next_frame(),
                                 .camera = shoot_.camera()}};
}

}  // namespace inbetween
