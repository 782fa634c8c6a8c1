#include "host_tools/dragonframe/dfmoco_device.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "host_tools/dragonframe/go_motion.hpp"

namespace inbetween::dragonframe {
namespace {

constexpr std::int32_t inch_of_dfmoco = 2;
constexpr std::int32_t full_jog = 10'000;
// The sketch jogs no slower.
constexpr std::int32_t min_jog = 4;
// A motor of `bf`: its number, and where it is at the last, this and the next frame.
constexpr std::size_t numbers_of_motor = 4;

int sign_of(std::int64_t difference) {
  return difference > 0 ? 1 : difference < 0 ? -1 : 0;
}

}  // namespace

DfmocoDevice::DfmocoDevice(std::uint8_t motors, RigPort rig) : motors_(motors), rig_(std::move(rig)) {
  if (motors < 1 || motors > max_motors) throw std::invalid_argument("a DFMoco device has 1 to 32 motors");
}

bool DfmocoDevice::connect(std::int64_t now_ns) {
  if (is_connected_) return false;
  now_ns_ = now_ns;
  cycle_ns_ = now_ns;
  is_connected_ = true;
  note(PortNotice::Kind::connected);
  say(fmt::format("hi 2 {} 2.0.0", motors_));
  return true;
}

void DfmocoDevice::disconnect(std::int64_t now_ns) {
  if (!is_connected_) return;
  now_ns_ = now_ns;
  static_cast<void>(order(StopAll{}));
  stop_all();
  static_cast<void>(rig_(ForgetHost{}));
  decoder_.clear();
  settings_ = {};
  to_tell_ = 0;
  text_.clear();
  is_armed_ = false;
  is_connected_ = false;
  note(PortNotice::Kind::disconnected);
}

bool DfmocoDevice::arm() {
  if (is_connected_) is_armed_ = true;
  return is_connected_;
}

void DfmocoDevice::disarm(PortNotice::Kind why) {
  if (is_armed_) note(why);
  is_armed_ = false;
}

void DfmocoDevice::stop(std::int64_t now_ns) {
  now_ns_ = now_ns;
  if (!is_connected_) return;
  static_cast<void>(order(StopAll{}));
  stop_all();
  disarm(PortNotice::Kind::rig_stopped);
}

/// What a stop of everything leaves; the rig has its order already.
void DfmocoDevice::stop_all() {
  jogs_.clear();
  stage_ = Stage::free;
}

void DfmocoDevice::hear(std::span<const std::uint8_t> bytes, std::int64_t now_ns) {
  now_ns_ = now_ns;
  if (!is_connected_ || bytes.empty()) return;
  heard_ns_ = now_ns;
  while (const auto line = decoder_.next(bytes)) hear_line(*line);
}

void DfmocoDevice::hear_line(const DfmocoLine& line) {
  switch (line.kind) {
    case DfmocoLine::Kind::unknown:
      return note(PortNotice::Kind::unknown_line);
    case DfmocoLine::Kind::too_many_numbers:
      return say("error: too many args");
    case DfmocoLine::Kind::malformed:
      return say("parse error");
    case DfmocoLine::Kind::command:
      if (!obey(line)) say("parse error");
  }
}

bool DfmocoDevice::obey(const DfmocoLine& line) {
  switch (line.command) {
    case DfmocoCommand::hi:
      say(fmt::format("hi 2 {} 2.0.0", motors_));
      return true;
    case DfmocoCommand::ms: {
      std::string text = "ms ";
      for (std::uint8_t motor = 1; motor <= motors_; ++motor) text += is_moving(motor) ? '1' : '0';
      say(text);
      return true;
    }
    case DfmocoCommand::sa: {
      const bool did_move = state_.moving != 0 || stage_ == Stage::shooting;
      static_cast<void>(order(StopAll{}));
      stop_all();
      // There is no other word for tidying up: at rest it takes nothing from anybody.
      if (did_move) disarm(PortNotice::Kind::host_stopped);
      say("sa");
      return true;
    }
    case DfmocoCommand::bf:
      return prepare(line.numbers);
    case DfmocoCommand::go:
      return line.numbers.empty() && go();
    default:
      return obey_motor(line);
  }
}

bool DfmocoDevice::obey_motor(const DfmocoLine& line) {
  const std::vector<std::int32_t>& numbers = line.numbers;
  if (numbers.empty() || numbers[0] < 1 || numbers[0] > motors_) return false;
  const auto motor = static_cast<std::uint8_t>(numbers[0]);
  const std::size_t count = numbers.size();
  switch (line.command) {
    case DfmocoCommand::mm:
      return count == 2 && move(motor, numbers[1]);
    case DfmocoCommand::mp:
      if (count != 1) return false;
      say_position(motor);
      return true;
    case DfmocoCommand::sm:
      return count == 1 && halt(motor);
    case DfmocoCommand::jm:
      return count >= 2 && count <= 4 && jog(motor, numbers[1], count > 2 ? numbers[2] : full_jog);
    case DfmocoCommand::im:
      return count == 2 && inch(motor, numbers[1]);
    case DfmocoCommand::pr:
      return count == 2 && set_rate(motor, numbers[1]);
    case DfmocoCommand::zm:
      return count == 1 && place(motor, 0);
    case DfmocoCommand::np:
      return count == 2 && place(motor, numbers[1]);
    default:
      return false;
  }
}

void DfmocoDevice::moved(std::uint8_t motor) {
  // What was prepared begins elsewhere.
  stage_ = Stage::free;
  state_.moving |= mask_of(motor);
  to_tell_ |= mask_of(motor);
}

bool DfmocoDevice::move(std::uint8_t motor, std::int32_t target) {
  if (stage_ == Stage::shooting) return false;
  if (!is_moving(motor) && state_.positions.at(motor - 1U) == target) {
    say_position(motor);
    return true;
  }
  if (!move_by(MoveMotor{.motor = motor, .target = target}, motor)) return false;
  jogs_.forget(motor);
  moved(motor);
  say(fmt::format("mm {} {}", motor, target));
  return true;
}

/// One motor does not leave a shot alone: then all stop.
bool DfmocoDevice::halt(std::uint8_t motor) {
  if (stage_ == Stage::shooting) {
    note(PortNotice::Kind::stop_in_play, motor);
    static_cast<void>(order(StopAll{}));
    stop_all();
  } else {
    jogs_.release(motor);
    static_cast<void>(order(StopMotor{motor}, motor));
    if (is_moving(motor)) stage_ = Stage::free;
  }
  say(fmt::format("sm {}", motor));
  say_position(motor);
  return true;
}

bool DfmocoDevice::jog(std::uint8_t motor, std::int32_t destination, std::int32_t speed) {
  if (stage_ == Stage::shooting || speed < 0 || speed > full_jog) return false;
  const int direction = sign_of(std::int64_t{destination} - state_.positions.at(motor - 1U));
  const int jogs = jogs_.direction(motor);
  if (is_moving(motor) && jogs != 0 && direction != jogs) {
    jogs_.release(motor);
    if (!order(StopMotor{motor}, motor)) return false;
  } else if (direction != 0) {
    const JogMotor what{.motor = motor,
                        .speed = static_cast<std::uint16_t>(std::max(speed, min_jog)),
                        .destination = destination};
    if (!move_by(what, motor)) return false;
    jogs_.press(motor, direction, now_ns_);
    moved(motor);
  }
  say(fmt::format("jm {}", motor));
  return true;
}

bool DfmocoDevice::inch(std::uint8_t motor, std::int32_t destination) {
  if (stage_ == Stage::shooting) return false;
  if (is_moving(motor)) {
    jogs_.release(motor);
    if (!order(StopMotor{motor}, motor)) return false;
    stage_ = Stage::free;
  } else {
    const std::int64_t here = state_.positions.at(motor - 1U);
    const std::int64_t way = std::clamp<std::int64_t>(destination - here, -inch_of_dfmoco, inch_of_dfmoco);
    if (way != 0) {
      if (!move_by(MoveMotor{.motor = motor, .target = static_cast<std::int32_t>(here + way)}, motor))
        return false;
      jogs_.forget(motor);
      moved(motor);
    }
  }
  say(fmt::format("im {}", motor));
  return true;
}

bool DfmocoDevice::set_rate(std::uint8_t motor, std::int32_t rate) {
  const std::int32_t taken = std::clamp(rate, min_dfmoco_rate, max_dfmoco_rate);
  MotorSettings settings = settings_.at(motor - 1U);
  settings.is_enabled = true;
  settings.max_velocity = static_cast<std::uint32_t>(taken);
  // Two seconds to full speed, as the sketch has it.
  settings.max_acceleration = static_cast<std::uint32_t>(taken / 2);
  if (!order(SetMotor{.motor = motor, .settings = settings}, motor)) return false;
  settings_.at(motor - 1U) = settings;
  say(fmt::format("pr {} {}", motor, taken));
  return true;
}

/// The sketch answers with the position, and tells it again in its next cycle.
bool DfmocoDevice::place(std::uint8_t motor, std::int32_t position) {
  if (is_moving(motor) || stage_ == Stage::shooting) return false;
  if (!order(PlaceMotor{.motor = motor, .position = position}, motor)) return false;
  stage_ = Stage::free;
  state_.positions.at(motor - 1U) = position;
  to_tell_ |= mask_of(motor);
  say_position(motor);
  return true;
}

/// Nothing: the numbers are no shot.
std::optional<PrepareShot> DfmocoDevice::shot_of(const std::vector<std::int32_t>& numbers,
                                                 bool& is_too_fast) const {
  if (numbers.size() < 2 + numbers_of_motor || (numbers.size() - 2) % numbers_of_motor != 0) return {};
  if (numbers[0] < 1 || numbers[1] < 0 || numbers[1] > 1000) return {};
  const double exposure_s = numbers[0] / 1000.0;
  const double blur = numbers[1] / 1000.0;
  PrepareShot shot{.open_s = dfmoco_delay_ms / 1000.0, .close_s = dfmoco_delay_ms / 1000.0 + exposure_s};
  MotorMask listed = 0;
  for (std::size_t i = 2; i < numbers.size(); i += numbers_of_motor) {
    if (numbers[i] < 1 || numbers[i] > motors_) return {};
    const auto motor = static_cast<std::uint8_t>(numbers[i]);
    if ((listed & mask_of(motor)) != 0) return {};
    listed |= mask_of(motor);
    const double before = numbers[i + 1];
    const double here = numbers[i + 2];
    const double behind = numbers[i + 3];
    const ShotWay way =
        two_speed_shot(here + blur * (before - here), here, here + blur * (behind - here), exposure_s);
    for (const ShotPiece& piece : way.pieces) is_too_fast |= std::abs(piece.to) > max_dfmoco_rate;
    const double start = std::trunc(way.start);
    is_too_fast |= std::abs(start) > std::numeric_limits<std::int32_t>::max();
    if (is_too_fast) continue;
    shot.motors.push_back({.motor = motor, .start = static_cast<std::int32_t>(start), .pieces = way.pieces});
  }
  return shot;
}

bool DfmocoDevice::prepare(const std::vector<std::int32_t>& numbers) {
  if (state_.moving != 0 || stage_ == Stage::shooting) return false;
  stage_ = Stage::free;
  bool is_too_fast = false;
  const auto shot = shot_of(numbers, is_too_fast);
  if (!shot) return false;
  if (!is_armed_) {
    note(PortNotice::Kind::consent_missing);
    return false;
  }
  if (is_too_fast || !move_by(*shot)) {
    say("bf -1");
    return true;
  }
  stage_ = Stage::prepared;
  for (const ShotMotor& motor : shot->motors) {
    if (state_.positions.at(motor.motor - 1U) == motor.start) continue;
    state_.moving |= mask_of(motor.motor);
    to_tell_ |= mask_of(motor.motor);
  }
  say(fmt::format("bf {}", dfmoco_delay_ms));
  return true;
}

bool DfmocoDevice::go() {
  if (stage_ != Stage::prepared || state_.moving != 0) return false;
  if (!move_by(Go{})) return false;
  stage_ = Stage::shooting;
  say("go");
  return true;
}

void DfmocoDevice::say(const std::string& line) {
  text_ += line + "\r\n";
}

void DfmocoDevice::say_position(std::uint8_t motor) {
  say(fmt::format("mp {} {}", motor, state_.positions.at(motor - 1U)));
}

void DfmocoDevice::note(PortNotice::Kind kind, std::uint8_t motor, std::int64_t value) {
  notices_.push_back({.kind = kind, .motor = motor, .value = value});
}

bool DfmocoDevice::order(const RigOrder& what, std::uint8_t motor) {
  const RigAnswer answer = rig_(what);
  if (answer != RigAnswer::ok) note(PortNotice::Kind::rig_refused, motor, static_cast<std::int64_t>(answer));
  return answer == RigAnswer::ok;
}

bool DfmocoDevice::move_by(const RigOrder& what, std::uint8_t motor) {
  if (is_armed_) return order(what, motor);
  note(PortNotice::Kind::consent_missing, motor);
  return false;
}

void DfmocoDevice::tell(const RigEvent& event, std::int64_t now_ns) {
  now_ns_ = now_ns;
  if (!is_connected_) return;
  if (std::holds_alternative<AtRest>(event) && stage_ == Stage::shooting) stage_ = Stage::free;
  if (!std::holds_alternative<HardStop>(event)) return;
  stop_all();
  disarm(PortNotice::Kind::rig_stopped);
}

void DfmocoDevice::observe(const RigState& state, std::int64_t now_ns) {
  now_ns_ = now_ns;
  to_tell_ |= state_.moving | state.moving;
  state_ = state;
  if (!is_connected_) return;
  if (decoder_.has_half() && now_ns - heard_ns_ >= dfmoco_silence_ns) {
    decoder_.clear();
    note(PortNotice::Kind::half_dropped);
  }
  while (const auto motor = jogs_.take_expired(now_ns)) {
    note(PortNotice::Kind::jog_not_repeated, *motor);
    static_cast<void>(order(StopMotor{*motor}, *motor));
  }
  jogs_.rest(state.moving);
  if (now_ns - cycle_ns_ < dfmoco_cycle_ns) return;
  cycle_ns_ = now_ns;
  for (std::uint8_t motor = 1; motor <= motors_; ++motor) {
    if ((to_tell_ & mask_of(motor)) != 0) say_position(motor);
  }
  to_tell_ = 0;
}

std::string DfmocoDevice::take_text() {
  return std::exchange(text_, {});
}

std::vector<PortNotice> DfmocoDevice::take_notices() {
  return std::exchange(notices_, {});
}

}  // namespace inbetween::dragonframe
