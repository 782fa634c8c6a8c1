#include "sim/rmd_drive.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "inbetween/can/little_endian.hpp"

namespace inbetween {
namespace {

using can::RmdCommand;

constexpr std::int64_t boot_delay_ns = 200'000'000;
constexpr double deg_per_turn = 360;
constexpr std::uint8_t write_acceleration = 0x43;
constexpr std::uint8_t motion_status = 0x9C;  // answered as a position is

}  // namespace

SimulatedRmd::SimulatedRmd(const SimulatedRmdSettings& settings, std::int64_t now_ns)
    : SimulatedServo(settings, settings.turns, now_ns, boot_delay_ns), settings_(settings) {}

const char* SimulatedRmd::state_name() const {
  if (errors_ != 0) return "fault";
  return state_ == State::off ? "off" : state_ == State::stopped ? "stopped" : "position";
}

void SimulatedRmd::live(double seconds) {
  step(seconds);
  if (now_ns_ < boot_ns_) return;
  if (watchdog_ns_ > 0 && now_ns_ - fed_ns_ > watchdog_ns_) enter(State::off);
  for (std::int64_t due = troubles_.flood(now_ns_); due > 0; --due) {
    can::Frame frame = can::rmd_motion_frame(settings_.motor_number, {});
    frame.data[0] = motion_status;
    send(frame);
  }
}

void SimulatedRmd::step(double seconds) {
  motor_.hold(has_trouble(Kind::stick));
  const std::optional<double> speed = troubles_.place(Kind::run_away, now_ns_);
  if (state_ != State::off && speed) return motor_.follow_speed(*speed, seconds);
  switch (state_) {
    case State::off:
      return coast(seconds);
    case State::stopped:
      return motor_.follow({.position = demand_.position}, seconds);
    case State::in_position:
      // At most as fast as the position says, and by a ramp where one is planned.
      demand_.go_to(
          target_ + zero_,
          {.velocity = max_turns_per_s_, .acceleration = settings_.planning_acceleration / deg_per_turn},
          seconds);
      return motor_.follow({.position = demand_.position}, seconds);
  }
}

void SimulatedRmd::enter(State state) {
  if (state == state_) return;
  if (state == State::stopped || state_ == State::off) demand_.start(motor_.position());
  state_ = state;
  record_entered();
}

void SimulatedRmd::start_anew() {
  errors_ = 0;
  watchdog_ns_ = 0;
  enter(State::off);
}

void SimulatedRmd::meet(const DriveTrouble& trouble) {
  switch (trouble.kind) {
    case Kind::emergency:
      errors_ |= static_cast<std::uint16_t>(trouble.value);
      record_reported(errors_);
      return enter(State::off);
    case Kind::foreign_sender: {
      const double steps = here() * can::rmd_steps_per_turn;
      const can::Frame frame =
          can::rmd_position_frame(settings_.motor_number, {.steps = static_cast<std::int32_t>(steps)});
      send(frame);
      return receive(frame);
    }
    default:
      return;  // while it lasts, something else is done where it would be
  }
}

void SimulatedRmd::receive(const can::Frame& frame) {
  const bool is_meant =
      !frame.is_remote && frame.length == 8 && frame.id == can::rmd_command_id(settings_.motor_number);
  if (!is_meant || now_ns_ < boot_ns_ || takes_frame(Kind::lose_heard)) return;
  fed_ns_ = now_ns_;
  obey(frame);
}

void SimulatedRmd::obey(const can::Frame& frame) {
  can::Frame echo = frame;
  echo.id = can::rmd_answer_id(settings_.motor_number);
  if (frame.data[0] == write_acceleration ||
      frame.data[0] == static_cast<std::uint8_t>(RmdCommand::read_acceleration)) {
    return answer_acceleration(frame);
  }
  switch (static_cast<RmdCommand>(frame.data[0])) {
    case RmdCommand::shut_down:
      if (has_trouble(Kind::stay_on)) return;
      if (!has_trouble(Kind::emergency)) errors_ = 0;
      enter(State::off);
      return send(echo);
    case RmdCommand::stop:
      if (errors_ == 0) enter(State::stopped);
      return send(echo);
    case RmdCommand::read_angle: {
      if (has_trouble(Kind::lose_feedback)) return;
      const double steps = std::round(here() * can::rmd_steps_per_turn);
      can::Frame angle = can::rmd_angle_frame(settings_.motor_number, static_cast<std::int32_t>(steps));
      if (takes_frame(Kind::shorten)) --angle.length;
      return send(angle);
    }
    case RmdCommand::read_status:
      return answer_status();
    case RmdCommand::position:
      return take_position(*can::read_rmd_position(frame, settings_.motor_number));
    case RmdCommand::host_timeout:
      if (has_trouble(Kind::no_watchdog)) return;  // its firmware does not know the command
      watchdog_ns_ = std::int64_t{can::load<std::uint32_t>(frame.data, 4)} * 1'000'000;
      return send(echo);
    default:
      return;
  }
}

void SimulatedRmd::answer_acceleration(const can::Frame& frame) {
  can::Frame answer = frame;
  answer.id = can::rmd_answer_id(settings_.motor_number);
  const bool is_of_positions = frame.data[1] == 0;
  if (frame.data[0] == write_acceleration && is_of_positions) {
    settings_.planning_acceleration = can::load<std::uint32_t>(frame.data, 4);
  }
  can::store(answer.data, 4, is_of_positions ? settings_.planning_acceleration : 0U);
  send(answer);
}

void SimulatedRmd::answer_status() {
  if (has_trouble(Kind::lose_heartbeat)) return;
  send(can::rmd_status_frame(
      settings_.motor_number,
      {.celsius = 30, .is_brake_open = state_ != State::off, .volts = 48, .errors = errors_}));
}

/// Its answer has whole degrees, of which 16 bits hold 91 turns.
void SimulatedRmd::take_position(const can::RmdPosition& position) {
  if (errors_ == 0) enter(State::in_position);
  if (!has_trouble(Kind::ignore_target)) {
    target_ = position.steps / can::rmd_steps_per_turn;
    max_turns_per_s_ = position.max_deg_per_s / deg_per_turn;
  }
  note_target(position.steps);
  if (state_ == State::in_position) record_applied(position.steps / can::rmd_steps_per_turn);
  const auto degrees = static_cast<std::int64_t>(std::trunc(here() * deg_per_turn));
  const double deg_per_s = std::clamp(motor_.velocity() * deg_per_turn, -32'767.0, 32'767.0);
  send(can::rmd_motion_frame(settings_.motor_number,
                             {.celsius = 30,
                              .deg_per_s = static_cast<std::int16_t>(deg_per_s),
                              .degrees = static_cast<std::int16_t>(degrees % 32'768)}));
}

}  // namespace inbetween
