// One motor of a DMC device, and its outputs.
#include <algorithm>
#include <cstdint>

#include "host_tools/dragonframe/dmc_device.hpp"

namespace inbetween::dragonframe {
namespace {

// The maker's device raises what is slower, and plays with half of the velocity where no acceleration is
// given.
constexpr std::uint32_t min_velocity = 10;
// A jog at speed 1 is an inch, of as many steps as DFMoco's.
constexpr std::uint16_t inch_speed = 1;
constexpr std::int32_t inch_steps = 2;
constexpr std::uint16_t full_speed = 10'000;

}  // namespace

RigAnswer DmcDevice::handle(const DmcPlain& request) {
  switch (request.type) {
    case DmcType::upload_end:
      return end_upload();
    case DmcType::go:
      return stage_ == DmcStage::wait ? go() : RigAnswer::not_in_position;
    case DmcType::stop_loop:
      return stop_loop();
    default:
      return RigAnswer::unsupported;
  }
}

RigAnswer DmcDevice::handle(const DmcGioOut& request) {
  if (facts_.outputs == 0) return RigAnswer::unsupported;
  if (!has_outputs(request.bits)) return RigAnswer::range;
  host_outputs_ = request.bits;
  return show_outputs();
}

RigAnswer DmcDevice::handle(const DmcGioCam& request) {
  return set_camera({.shutter = request.shutter, .meter = request.meter});
}

/// What every order to one motor has to pass.
RigAnswer DmcDevice::may_move(std::uint8_t motor) {
  if (!has_motor(motor)) return RigAnswer::range;
  const bool is_live = settings_of(motor).is_live;
  return is_live || after(stage_, DmcStep::motor_order) ? RigAnswer::ok : RigAnswer::moving;
}

/// A motor that is not live leaves the uploaded frame, and what was prepared is dropped.
void DmcDevice::leave_frame(std::uint8_t motor) {
  if (settings_of(motor).is_live) return;
  position_frame_.reset();
  stops_on_path_ = false;
  run_.reset();
  stage_ = after(stage_, DmcStep::motor_order).value_or(stage_);
}

RigAnswer DmcDevice::move_motor(std::uint8_t motor, std::int32_t target) {
  if (settings_of(motor).upper && target > *settings_of(motor).upper) return RigAnswer::soft_upper;
  if (settings_of(motor).lower && target < *settings_of(motor).lower) return RigAnswer::soft_lower;
  const RigAnswer answer = move_by(MoveMotor{.motor = motor, .target = target}, motor);
  if (answer != RigAnswer::ok) return answer;
  jogs_.forget(motor);
  leave_frame(motor);
  // Hosts ask for STATUS at once; the rig tells when it is no longer so.
  state_.moving |= mask_of(motor);
  return RigAnswer::ok;
}

RigAnswer DmcDevice::handle(const DmcMove& request) {
  const RigAnswer answer = may_move(request.motor);
  return answer == RigAnswer::ok ? move_motor(request.motor, request.target) : answer;
}

RigAnswer DmcDevice::stop_motor(std::uint8_t motor) {
  jogs_.release(motor);
  const RigAnswer answer = order(StopMotor{motor}, motor);
  if ((state_.moving & mask_of(motor)) != 0) leave_frame(motor);
  return answer;
}

/// The maker's device lets a stop of one motor in a move be. A person who asks for a stop gets one here, and
/// as no motor leaves the path by itself, it is that of all.
RigAnswer DmcDevice::handle(const DmcStop& request) {
  if (!has_motor(request.motor)) return RigAnswer::range;
  const bool is_single = stage_ == DmcStage::jog || settings_of(request.motor).is_live ||
                         (stage_ == DmcStage::wait && (state_.moving & mask_of(request.motor)) == 0);
  if (is_single) return stop_motor(request.motor);
  note(PortNotice::Kind::stop_in_play, request.motor);
  static_cast<void>(order(StopAll{}));
  stop_all();
  return RigAnswer::ok;
}

/// What a stop of everything leaves; the rig has its order already.
void DmcDevice::stop_all() {
  if (state_.moving != 0 || stage_ != DmcStage::jog) position_frame_.reset();
  stops_on_path_ = stage_ == DmcStage::all_jog || stage_ == DmcStage::approach || stage_ == DmcStage::shoot;
  jogs_.clear();
  run_.reset();
  has_ended_ = false;
  end_bloop();
  stage_ = DmcStage::jog;
}

RigAnswer DmcDevice::handle(const DmcStopAll& request) {
  const bool is_harder = stopped_ns_ && now_ns_ - *stopped_ns_ <= dmc_harder_stop_ns;
  stopped_ns_ = now_ns_;
  if (!request.is_silent && (moves() || state_.moving != 0)) gated_ns_ = now_ns_;
  const RigAnswer answer = order(StopAll{.harder = is_harder});
  stop_all();
  if (!request.is_silent) disarm(PortNotice::Kind::host_stopped);
  return answer;
}

RigAnswer DmcDevice::handle(const DmcResetPosition& request) {
  if (!has_motor(request.motor)) return RigAnswer::range;
  if (moves() || (state_.moving & mask_of(request.motor)) != 0) return RigAnswer::moving;
  const RigAnswer answer =
      order(PlaceMotor{.motor = request.motor, .position = request.position}, request.motor);
  if (answer != RigAnswer::ok) return answer;
  leave_frame(request.motor);
  state_.positions.at(request.motor - 1U) = request.position;
  return RigAnswer::ok;
}

RigAnswer DmcDevice::handle(const DmcJog& request) {
  const RigAnswer may = may_move(request.motor);
  if (may != RigAnswer::ok) return may;
  if (request.speed < 1 || request.speed > full_speed) return RigAnswer::range;
  const MotorSettings& settings = settings_of(request.motor);
  const std::int32_t here = state_.positions.at(request.motor - 1U);
  const int direction = request.destination > here ? 1 : request.destination < here ? -1 : 0;
  if (direction > 0 && settings.upper && here >= *settings.upper) return RigAnswer::soft_upper;
  if (direction < 0 && settings.lower && here <= *settings.lower) return RigAnswer::soft_lower;
  // Hosts name the ends of what 32 bits can say; a jog goes as far as it may.
  std::int32_t destination = request.destination;
  if (direction > 0 && settings.upper) destination = std::min(destination, *settings.upper);
  if (direction < 0 && settings.lower) destination = std::max(destination, *settings.lower);
  const bool is_moving = (state_.moving & mask_of(request.motor)) != 0;
  if (request.speed == inch_speed) {
    if (is_moving) return stop_motor(request.motor);
    const std::int64_t inch = std::int64_t{here} + direction * inch_steps;
    const auto target = direction > 0   ? std::min<std::int64_t>(inch, destination)
                        : direction < 0 ? std::max<std::int64_t>(inch, destination)
                                        : inch;
    return move_motor(request.motor, static_cast<std::int32_t>(target));
  }
  // The other way round: first a stop, and from rest the jog, which the host repeats.
  const int jogs = jogs_.direction(request.motor);
  if (is_moving && jogs != 0 && direction != jogs) return stop_motor(request.motor);
  const RigAnswer answer = move_by(
      JogMotor{.motor = request.motor, .speed = request.speed, .destination = destination}, request.motor);
  if (answer != RigAnswer::ok) return answer;
  jogs_.press(request.motor, direction, now_ns_);
  leave_frame(request.motor);
  state_.moving |= mask_of(request.motor);
  return RigAnswer::ok;
}

RigAnswer DmcDevice::change(std::uint8_t motor, const MotorSettings& settings) {
  const RigAnswer answer = order(SetMotor{.motor = motor, .settings = settings}, motor);
  if (answer == RigAnswer::ok) settings_of(motor) = settings;
  return answer;
}

RigAnswer DmcDevice::handle(const DmcConfigure& request) {
  if (!has_motor(request.motor)) return RigAnswer::range;
  if (request.couples && (facts_.capabilities & dmc_can::couple) == 0) return RigAnswer::unsupported;
  if (request.couples && request.motor == facts_.motors) return RigAnswer::range;
  if (request.unknown_flags != 0) note(PortNotice::Kind::unknown_flags, request.motor, request.unknown_flags);
  MotorSettings settings = settings_of(request.motor);
  settings.is_enabled = request.is_enabled;
  settings.has_blur = request.has_blur;
  settings.is_live = request.is_live;
  settings.drives_next = request.couples;
  settings.drives_next_reversed = request.is_reversed;
  return change(request.motor, settings);
}

RigAnswer DmcDevice::handle(const DmcSetSpeed& request) {
  if (!has_motor(request.motor)) return RigAnswer::range;
  if (request.max_velocity < min_velocity)
    note(PortNotice::Kind::speed_raised, request.motor, request.max_velocity);
  MotorSettings settings = settings_of(request.motor);
  settings.max_velocity = std::max(request.max_velocity, min_velocity);
  settings.max_acceleration =
      request.max_acceleration > 0 ? request.max_acceleration : settings.max_velocity / 2;
  return change(request.motor, settings);
}

RigAnswer DmcDevice::handle(const DmcSetLimits& request) {
  if (!has_motor(request.motor) || request.hardware_set > facts_.hardware_limit_sets) return RigAnswer::range;
  if (request.lower && request.upper && *request.lower > *request.upper) return RigAnswer::range;
  MotorSettings settings = settings_of(request.motor);
  settings.lower = request.lower;
  settings.upper = request.upper;
  settings.hardware_set = request.hardware_set;
  settings.hardware_swapped = request.hardware_swapped;
  return change(request.motor, settings);
}

}  // namespace inbetween::dragonframe
