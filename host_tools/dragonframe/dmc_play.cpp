// The uploaded move of a DMC device: frames, runs and shots, and what the rig tells of them.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>

#include "host_tools/dragonframe/dmc_device.hpp"

namespace inbetween::dragonframe {
namespace {

/// A position of 32 bits, or nothing.
std::optional<std::int32_t> whole_steps(double position) {
  const double rounded = std::round(position);
  if (!(rounded >= std::numeric_limits<std::int32_t>::min() &&
        rounded <= std::numeric_limits<std::int32_t>::max())) {
    return {};
  }
  return static_cast<std::int32_t>(rounded);
}

bool is_inside(const MotorSettings& settings, double position) {
  return !(settings.lower && position < *settings.lower) && !(settings.upper && position > *settings.upper);
}

RigAnswer judge_way(const MotorSettings& settings, const BlurWay& way) {
  const auto [low, high] = std::minmax(way.from, way.to);
  if (settings.upper && high > *settings.upper) return RigAnswer::soft_upper;
  if (settings.lower && low < *settings.lower) return RigAnswer::soft_lower;
  return RigAnswer::ok;
}

}  // namespace

RigAnswer DmcDevice::handle(const DmcUploadBegin& request) {
  // The rig may be reading the old move.
  if (stage_ != DmcStage::jog) return RigAnswer::moving;
  position_frame_.reset();
  static_cast<void>(order(TakeMove{}));
  return move_.begin(request.start, request.end);
}

RigAnswer DmcDevice::handle(const DmcUploadAxis& request) {
  return move_.put({.motor = request.motor,
                    .index = request.index,
                    .is_last = request.is_last,
                    .positions = request.positions});
}

RigAnswer DmcDevice::handle(const DmcUploadTriggers& request) {
  RigAnswer answer = move_.set_trigger_mask(request.mask);
  for (const DmcTrigger& trigger : request.triggers) {
    if (answer == RigAnswer::ok) answer = move_.put_trigger(trigger.index, trigger.values);
  }
  return answer;
}

RigAnswer DmcDevice::end_upload() {
  RigAnswer answer = move_.finish();
  if (answer != RigAnswer::ok) return answer;
  answer = order(TakeMove{.move = &move_, .motors = move_.motors()});
  if (answer != RigAnswer::ok) move_.clear();
  return answer;
}

/// The motors that go where the move says.
MotorMask DmcDevice::playing_motors() const {
  MotorMask playing = move_.motors();
  for (std::uint8_t motor = 1; motor <= facts_.motors; ++motor) {
    const MotorSettings& settings = settings_.at(motor - 1U);
    if (!settings.is_enabled || settings.is_live) playing &= ~mask_of(motor);
  }
  return playing;
}

RigAnswer DmcDevice::may_play(DmcStep step) const {
  if (!move_.is_loaded()) return RigAnswer::general;
  const bool is_along = stage_ == DmcStage::all_jog || stage_ == DmcStage::approach;
  if (!after(stage_, step) || (moves() && !is_along)) return RigAnswer::moving;
  return RigAnswer::ok;
}

RigAnswer DmcDevice::go_to_frame(std::int32_t frame) {
  const MotorMask motors = playing_motors();
  for (std::uint8_t motor = 1; motor <= facts_.motors; ++motor) {
    if ((motors & mask_of(motor)) == 0) continue;
    const double position = move_.position(motor, frame);
    const RigAnswer answer = judge_way(settings_of(motor), {.from = position, .to = position});
    if (answer != RigAnswer::ok) return answer;
  }
  const RigAnswer answer = move_by(GoToFrame{.frame = frame, .motors = motors});
  if (answer != RigAnswer::ok) return answer;
  run_.reset();
  stops_on_path_ = false;
  stage_ = after(stage_, DmcStep::motor_order).value_or(stage_);
  position_frame_ = frame;
  state_.moving |= motors;
  return RigAnswer::ok;
}

RigAnswer DmcDevice::handle(const DmcPositionFrame& request) {
  if (!move_.is_loaded()) return RigAnswer::general;
  if (!after(stage_, DmcStep::motor_order)) return RigAnswer::moving;
  const std::int32_t frame = std::clamp(request.frame, move_.start(), move_.end());
  if (frame != request.frame) note(PortNotice::Kind::frame_narrowed, 0, frame);
  return go_to_frame(frame);
}

RigAnswer DmcDevice::handle(const DmcJogAll& request) {
  const RigAnswer may = may_play(DmcStep::jog_all);
  if (may != RigAnswer::ok) return may;
  if (!position_frame_) return RigAnswer::not_in_position;
  if (request.frames_per_1000_s == 0 || !move_.has(request.frame)) return RigAnswer::range;
  const RigAnswer answer = move_by(JogAll{
      .frames_per_1000_s = request.frames_per_1000_s, .frame = request.frame, .motors = playing_motors()});
  if (answer != RigAnswer::ok) return answer;
  run_.reset();
  stage_ = DmcStage::all_jog;
  return RigAnswer::ok;
}

RigAnswer DmcDevice::judge_run(const DmcRunMove& request) const {
  const RigAnswer may = may_play(DmcStep::run);
  if (may != RigAnswer::ok) return may;
  if (!position_frame_) return RigAnswer::not_in_position;
  const bool comes_round = request.is_loop || request.is_ping_pong;
  if (comes_round && (facts_.capabilities & dmc_can::loop) == 0) return RigAnswer::unsupported;
  const bool has_camera = request.has_video_camera || request.has_stills_camera;
  if (has_camera && (facts_.capabilities & dmc_can::camera) == 0) return RigAnswer::unsupported;
  if (request.bloop_dmx != 0) return RigAnswer::unsupported;
  if (!has_outputs(request.bloop_bits) || request.frames_per_1000_s == 0) return RigAnswer::range;
  return move_.has(request.start) && move_.has(request.end) ? RigAnswer::ok : RigAnswer::range;
}

/// Where each motor begins and ends, if its limits allow.
RigAnswer DmcDevice::place_rolls(PrepareRun& run) const {
  const RunTimes times{.fps = run.frames_per_1000_s / 1000.0,
                       .start = run.start,
                       .end = run.end,
                       .preroll_s = run.preroll_ms / 1000.0,
                       .postroll_s = run.postroll_ms / 1000.0};
  for (std::uint8_t motor = 1; motor <= facts_.motors; ++motor) {
    if ((run.motors & mask_of(motor)) == 0) continue;
    const MotorSettings& settings = settings_.at(motor - 1U);
    const auto begin = whole_steps(preroll_position(move_, motor, times));
    if (!begin || !is_inside(settings, *begin)) return RigAnswer::preroll;
    const auto end = whole_steps(postroll_position(move_, motor, times));
    if (!end || !is_inside(settings, *end)) return RigAnswer::postroll;
    run.preroll.at(motor - 1U) = *begin;
    run.postroll.at(motor - 1U) = *end;
  }
  return RigAnswer::ok;
}

RigAnswer DmcDevice::handle(const DmcRunMove& request) {
  RigAnswer answer = judge_run(request);
  if (answer != RigAnswer::ok) return answer;
  const bool comes_round = request.is_loop || request.is_ping_pong;
  PrepareRun run{.frames_per_1000_s = request.frames_per_1000_s,
                 .start = request.start,
                 .end = request.end,
                 .preroll_ms = request.preroll_ms,
                 .postroll_ms = comes_round ? 0 : request.postroll_ms,
                 .is_loop = request.is_loop,
                 .is_ping_pong = request.is_ping_pong,
                 .motors = playing_motors()};
  if (request.has_video_camera) run.camera = CameraKind::video;
  if (request.has_stills_camera) {
    const bool is_shutter = request.open_deg < request.close_deg;
    run.camera = CameraKind::stills;
    run.open_deg = is_shutter ? request.open_deg : 90;
    run.close_deg = is_shutter ? request.close_deg : 180;
  }
  answer = place_rolls(run);
  if (answer != RigAnswer::ok) return answer;
  answer = move_by(run);
  if (answer != RigAnswer::ok) return answer;
  run_ = run;
  is_synced_ = request.is_synced;
  has_ended_ = false;
  bloop_bits_ = request.bloop_bits;
  bloop_for_ns_ = request.bloop_ms == 0 ? dmc_bloop_ns : request.bloop_ms * std::int64_t{1'000'000};
  state_.moving |= run.motors;
  stage_ = DmcStage::approach;
  return RigAnswer::ok;
}

/// What two kinds of shots have apart.
struct DmcDevice::ShotMath {
  std::function<BlurWay(std::uint8_t)> drawn;      ///< what is exposed, from the uploaded move
  std::function<BlurWay(const BlurWay&)> exposed;  ///< and of a way that the host gives
  std::function<ShotWay(const BlurWay&)> motion;
  double open_s = 0;
  double close_s = 0;
};

RigAnswer DmcDevice::add_to_shot(PrepareShot& shot, std::uint8_t motor, const BlurWay& way,
                                 const ShotMath& math) const {
  const MotorSettings& settings = settings_.at(motor - 1U);
  const RigAnswer answer = judge_way(settings, way);
  if (answer != RigAnswer::ok) return answer;
  const ShotWay motion = math.motion(way);
  const auto start = whole_steps(motion.start);
  if (!start || !is_inside(settings, *start)) return RigAnswer::preroll;
  if (!is_inside(settings, end_of(motion))) return RigAnswer::postroll;
  shot.motors.push_back({.motor = motor, .start = *start, .pieces = motion.pieces});
  return RigAnswer::ok;
}

RigAnswer DmcDevice::prepare_shot(std::int32_t frame, const std::vector<DmcOverride>& overrides,
                                  const ShotMath& math) {
  for (const DmcOverride& given : overrides) {
    if (!has_motor(given.motor)) note(PortNotice::Kind::override_ignored, given.motor);
  }
  PrepareShot shot{.open_s = math.open_s, .close_s = math.close_s};
  for (std::uint8_t motor = 1; motor <= facts_.motors; ++motor) {
    const MotorSettings& settings = settings_of(motor);
    if (!settings.is_enabled || settings.is_live) continue;
    const auto given = std::find_if(overrides.begin(), overrides.end(),
                                    [&](const DmcOverride& candidate) { return candidate.motor == motor; });
    const bool is_uploaded = (move_.motors() & mask_of(motor)) != 0;
    RigAnswer answer = RigAnswer::ok;
    if (given != overrides.end()) {
      const BlurWay whole{.from = static_cast<double>(given->from), .to = static_cast<double>(given->to)};
      answer = add_to_shot(shot, motor, math.exposed(whole), math);
    } else if (is_uploaded && settings.has_blur) {
      answer = add_to_shot(shot, motor, math.drawn(motor), math);
    } else if (is_uploaded) {
      const double rest = move_.position(motor, frame);
      answer = judge_way(settings, {.from = rest, .to = rest});
      shot.resting |= mask_of(motor);
      shot.rest.at(motor - 1U) = static_cast<std::int32_t>(rest);
    }
    if (answer != RigAnswer::ok) return answer;
  }
  const RigAnswer answer = move_by(shot);
  if (answer != RigAnswer::ok) return answer;
  position_frame_.reset();
  run_.reset();
  is_synced_ = false;
  has_ended_ = false;
  bloop_bits_ = 0;
  state_.moving |= shot.resting;
  for (const ShotMotor& motor : shot.motors) state_.moving |= mask_of(motor.motor);
  stage_ = DmcStage::preroll;
  return RigAnswer::ok;
}

RigAnswer DmcDevice::handle(const DmcShootFrame& request) {
  if (!move_.is_loaded()) return RigAnswer::general;
  if (!move_.has(request.frame) || request.exposure_ms == 0 || request.blur_permille > 1000)
    return RigAnswer::range;
  const RigAnswer may = may_play(DmcStep::shot);
  if (may != RigAnswer::ok) return may;
  const double blur = request.blur_permille == 0 ? 1 : request.blur_permille / 1000.0;
  const double exposure_s = request.exposure_ms / 1000.0;
  const int direction = request.is_forward ? 1 : -1;
  return prepare_shot(
      request.frame, request.overrides,
      {.drawn = [&](std::uint8_t motor) { return blur_way(move_, motor, request.frame, direction, blur); },
       .exposed = [&](const BlurWay& way) { return shortened(way, blur); },
       .motion = [&](const BlurWay& way) { return constant_speed_shot(way, exposure_s); },
       .open_s = 1,
       .close_s = 1 + exposure_s});
}

RigAnswer DmcDevice::handle(const DmcShootFrame2& request) {
  if (!move_.is_loaded()) return RigAnswer::general;
  if (!move_.has(request.frame) || request.close_deg <= request.open_deg) return RigAnswer::range;
  const RigAnswer may = may_play(DmcStep::shot);
  if (may != RigAnswer::ok) return may;
  const double exposure_s = (request.exposure_ms == 0 ? 1000 : request.exposure_ms) / 1000.0;
  const double s_per_deg = exposure_s / (request.close_deg - request.open_deg);
  const ShutterTurn turn{.turn_s = 360 * s_per_deg,
                         .wait_s = std::max(0, -request.open_deg) * s_per_deg,
                         .hold_s = std::max(0, request.close_deg - 360) * s_per_deg};
  const double open_s = std::max<int>(0, request.open_deg) * s_per_deg;
  return prepare_shot(
      request.frame, request.overrides,
      {.drawn = [&](std::uint8_t motor) { return blur_way(move_, motor, request.frame, 1, 1); },
       .exposed = [](const BlurWay& way) { return way; },
       .motion = [&](const BlurWay& way) { return shutter_turn_shot(way, turn); },
       .open_s = open_s,
       .close_s = open_s + exposure_s});
}

RigAnswer DmcDevice::go() {
  const RigAnswer answer = move_by(Go{});
  if (answer != RigAnswer::ok) return answer;
  stage_ = DmcStage::shoot;
  begin_bloop(bloop_for_ns_);
  return RigAnswer::ok;
}

RigAnswer DmcDevice::stop_loop() {
  if (run_) {
    const RigAnswer answer = order(StopLoop{});
    if (answer != RigAnswer::ok) return answer;
    run_->is_loop = false;
    run_->is_ping_pong = false;
  }
  return RigAnswer::ok;
}

void DmcDevice::handle_event(const FrameReached& event) {
  if (!move_.has(event.frame)) return;
  // A motor that was sent elsewhere meanwhile is on no frame, whatever comes late.
  const bool is_along =
      stage_ == DmcStage::all_jog || stage_ == DmcStage::approach || stage_ == DmcStage::shoot;
  if (is_along || stops_on_path_) position_frame_ = event.frame;
  push_positions();
  if (stage_ != DmcStage::shoot || !is_synced_) return;
  const std::uint32_t mask = move_.trigger_mask() & output_bits();
  host_outputs_ = (host_outputs_ & ~mask) | (move_.triggers_at(event.frame) & output_bits());
  static_cast<void>(show_outputs());
}

void DmcDevice::handle_event(const Approached& /*event*/) {
  stage_ = after(stage_, DmcStep::approached).value_or(stage_);
  if (stage_ == DmcStage::preroll) position_frame_.reset();
}

void DmcDevice::handle_event(const InPlace& /*event*/) {
  const auto next = after(stage_, DmcStep::in_place);
  if (!next) return;
  stage_ = *next;
  push_positions();
}

/// Also of a shot: the sheet says so, and the maker's device keeps silent then.
void DmcDevice::handle_event(const MoveEnded& /*event*/) {
  if (stage_ != DmcStage::shoot || has_ended_) return;
  has_ended_ = true;
  push_positions();
  send(DmcType::end, 0, {});
  begin_bloop(dmc_bloop_ns);
}

/// Behind a run the rig stands at the frame behind the last, as far as there is one.
void DmcDevice::handle_event(const AtRest& /*event*/) {
  const bool has_played = stage_ == DmcStage::shoot && has_ended_ && run_;
  if (stage_ == DmcStage::preroll || stage_ == DmcStage::approach || stage_ == DmcStage::shoot) {
    position_frame_.reset();
  }
  stops_on_path_ = false;
  stage_ = after(stage_, DmcStep::at_rest).value_or(stage_);
  push_positions();
  if (stage_ != DmcStage::jog) return;
  if (has_played && is_armed_) {
    const RunTimes times{.start = run_->start, .end = run_->end};
    const auto frame = std::clamp<std::int64_t>(times.behind(), move_.start(), move_.end());
    static_cast<void>(go_to_frame(static_cast<std::int32_t>(frame)));
  }
  run_.reset();
  has_ended_ = false;
}

void DmcDevice::handle_event(const HardStop& event) {
  if (moves() || state_.moving != 0) gated_ns_ = now_ns_;
  position_frame_.reset();
  stop_all();
  stops_on_path_ = false;
  disarm(PortNotice::Kind::rig_stopped);
  send(DmcType::hard_stop, 0, write_dmc_hard_stop(static_cast<std::uint8_t>(event.reason), event.motor));
}

void DmcDevice::handle_event(const StartSwitch& /*event*/) {
  if (stage_ == DmcStage::wait && go() == RigAnswer::ok) send(DmcType::go, 0, {});
}

}  // namespace inbetween::dragonframe
