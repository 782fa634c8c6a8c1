#include "inbetween/can/rmd.hpp"

#include <array>
#include <cmath>

#include "inbetween/can/little_endian.hpp"
#include "words.hpp"

namespace inbetween::can {
namespace {

using enum RmdCommand;

constexpr std::uint8_t acceleration_of_positions = 0;  // the index in read_acceleration
constexpr double volts_per_raw = 0.1;
constexpr double amperes_per_raw = 0.01;

Frame frame_of(FrameId id, RmdCommand command) {
  Frame frame{.id = id, .length = 8};
  frame.data[0] = static_cast<std::uint8_t>(command);
  return frame;
}
bool is_whole(const Frame& frame, FrameId id) {
  return !frame.is_remote && frame.id == id && frame.length == 8;
}
bool is_answer(const Frame& frame, RmdMotor motor, RmdCommand command) {
  return is_whole(frame, rmd_answer_id(motor)) && frame.data[0] == static_cast<std::uint8_t>(command);
}
std::uint16_t raw_of(double value, double per_raw) {
  return static_cast<std::uint16_t>(static_cast<std::int16_t>(std::lround(value / per_raw)));
}

constexpr std::array words{Words{0x2, "its motor has stalled"},
                           Words{0x4, "its supply voltage is too low"},
                           Words{0x8, "its supply voltage is too high"},
                           Words{0x10, "it takes too much current"},
                           Words{0x40, "it takes too much power"},
                           Words{0x100, "it was faster than it may be"},
                           Words{0x1000, "it is too hot"},
                           Words{0x2000, "its encoder is not calibrated"}};

}  // namespace

Frame rmd_command_frame(RmdMotor motor, RmdCommand command) {
  return frame_of(rmd_command_id(motor), command);
}

Frame rmd_acceleration_question(RmdMotor motor) {
  Frame frame = rmd_command_frame(motor, read_acceleration);
  frame.data[1] = acceleration_of_positions;
  return frame;
}

Frame rmd_host_timeout_frame(RmdMotor motor, std::uint32_t ms) {
  Frame frame = rmd_command_frame(motor, host_timeout);
  store(frame.data, 4, ms);
  return frame;
}

Frame rmd_position_frame(RmdMotor motor, const RmdPosition& told) {
  Frame frame = rmd_command_frame(motor, position);
  store(frame.data, 2, told.max_deg_per_s);
  store(frame.data, 4, static_cast<std::uint32_t>(told.steps));
  return frame;
}

std::optional<RmdPosition> read_rmd_position(const Frame& frame, RmdMotor motor) {
  const bool is_position =
      is_whole(frame, rmd_command_id(motor)) && frame.data[0] == static_cast<std::uint8_t>(position);
  if (!is_position) return {};
  return RmdPosition{.steps = static_cast<std::int32_t>(load<std::uint32_t>(frame.data, 4)),
                     .max_deg_per_s = load<std::uint16_t>(frame.data, 2)};
}

Frame rmd_angle_frame(RmdMotor motor, std::int32_t steps) {
  Frame frame = frame_of(rmd_answer_id(motor), read_angle);
  store(frame.data, 4, static_cast<std::uint32_t>(steps));
  return frame;
}

std::optional<std::int32_t> read_rmd_angle(const Frame& frame, RmdMotor motor) {
  if (!is_answer(frame, motor, read_angle)) return {};
  return static_cast<std::int32_t>(load<std::uint32_t>(frame.data, 4));
}

Frame rmd_status_frame(RmdMotor motor, const RmdStatus& told) {
  Frame frame = frame_of(rmd_answer_id(motor), read_status);
  frame.data[1] = static_cast<std::uint8_t>(told.celsius);
  frame.data[3] = told.is_brake_open ? 1 : 0;
  store(frame.data, 4, raw_of(told.volts, volts_per_raw));
  store(frame.data, 6, told.errors);
  return frame;
}

std::optional<RmdStatus> read_rmd_status(const Frame& frame, RmdMotor motor) {
  if (!is_answer(frame, motor, read_status)) return {};
  return RmdStatus{.celsius = static_cast<std::int8_t>(frame.data[1]),
                   .is_brake_open = frame.data[3] != 0,
                   .volts = load<std::uint16_t>(frame.data, 4) * volts_per_raw,
                   .errors = load<std::uint16_t>(frame.data, 6)};
}

Frame rmd_motion_frame(RmdMotor motor, const RmdMotion& told) {
  Frame frame = frame_of(rmd_answer_id(motor), position);
  frame.data[1] = static_cast<std::uint8_t>(told.celsius);
  store(frame.data, 2, raw_of(told.amperes, amperes_per_raw));
  store(frame.data, 4, static_cast<std::uint16_t>(told.deg_per_s));
  store(frame.data, 6, static_cast<std::uint16_t>(told.degrees));
  return frame;
}

const char* words_of_rmd_error(std::uint32_t bit) {
  return words_in(words, bit, "an error that its maker does not explain");
}

Result<Rmd> Rmd::make(const RmdSettings& settings) {
  const bool is_limited = settings.hold_deg_per_s > 0 && settings.hold_deg_per_s <= settings.max_deg_per_s;
  if (!is_limited || settings.host_timeout_ms == 0) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "a velocity limit or timeout of an RMD motor is 0, which is none",
                 .remedy = "give positive limits, that of holding not above the other"};
  }
  return Rmd(settings);
}

bool Rmd::is_concerned(const Frame& frame) const {
  const RmdMotor motor = settings_.motor;
  return frame.id == rmd_answer_id(motor) || frame.id == rmd_command_id(motor) ||
         frame.id == rmd_all_motors_id || frame.id == rmd_motion_id(motor);
}

ServoReport Rmd::read(const Frame& frame) {
  const RmdMotor motor = settings_.motor;
  if (frame.id != rmd_answer_id(motor)) return {.is_of_a_host = true};
  if (!is_whole(frame, rmd_answer_id(motor))) return {.is_bad = true};
  switch (static_cast<RmdCommand>(frame.data[0])) {
    case read_angle:
      return {.place = ServoPlace{.turns = *read_rmd_angle(frame, motor) / rmd_steps_per_turn}};
    case read_status:
      errors_ = read_rmd_status(frame, motor)->errors;
      return {.status = ServoStatus{.is_on = may_have_power_, .is_off = !may_have_power_, .errors = errors_}};
    case RmdCommand::position:
    case stop:
      may_have_power_ = true;
      return {};
    case shut_down:
      may_have_power_ = false;
      return {};
    case read_acceleration: {
      const bool is_of_positions = frame.data[1] == acceleration_of_positions;
      if (!is_of_positions) return {};
      return {.is_expected_device = load<std::uint32_t>(frame.data, 4) == 0};
    }
    case host_timeout:
      return {.has_watchdog = load<std::uint32_t>(frame.data, 4) == settings_.host_timeout_ms};
  }
  return {};  // an answer to somebody's tool
}

std::optional<Frame> Rmd::order(ServoOrder order) const {
  switch (order) {
    case ServoOrder::say_what_you_are:
      return rmd_acceleration_question(settings_.motor);
    case ServoOrder::set_watchdog:
      return rmd_host_timeout_frame(settings_.motor, settings_.host_timeout_ms);
    case ServoOrder::clear_errors:
      // A shutdown clears the state. One that holds its axis, and is well, keeps its power.
      if (errors_ == 0) return {};
      [[fallthrough]];
    case ServoOrder::switch_off:
    case ServoOrder::stop_at_once:
      return rmd_command_frame(settings_.motor, shut_down);
    case ServoOrder::take_positions:
    case ServoOrder::switch_on:
      return {};  // a position does both
  }
  return {};
}

std::optional<Frame> Rmd::question() {
  constexpr std::uint32_t status_every = 4;
  return rmd_command_frame(settings_.motor, ++questions_ % status_every == 0 ? read_status : read_angle);
}

bool Rmd::fits(const ServoTarget& target) {
  return std::fabs(target.turns) <= rmd_max_turns;
}

std::optional<Frame> Rmd::position(double turns, std::uint16_t max_deg_per_s) const {
  if (!fits({.turns = turns})) return {};
  const double steps = std::floor(turns * rmd_steps_per_turn + 0.5);
  return rmd_position_frame(settings_.motor,
                            {.steps = static_cast<std::int32_t>(steps), .max_deg_per_s = max_deg_per_s});
}

std::optional<Frame> Rmd::command(const ServoTarget& target) const {
  return position(target.turns, settings_.max_deg_per_s);
}

std::optional<Frame> Rmd::hold(ServoHold how, double turns) const {
  switch (how) {
    case ServoHold::off:
    case ServoHold::watched:
      return {};  // a position would switch it on
    case ServoHold::switching_on:
      return position(turns, settings_.hold_deg_per_s);
    case ServoHold::stopping:
      return rmd_command_frame(settings_.motor, stop);
  }
  return {};
}

}  // namespace inbetween::can
