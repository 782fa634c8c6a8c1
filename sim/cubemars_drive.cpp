#include "sim/cubemars_drive.hpp"

#include <algorithm>
#include <cmath>

namespace inbetween {
namespace {

constexpr std::int64_t boot_delay_ns = 200'000'000;
constexpr double deg_per_turn = 360;
constexpr std::int16_t holding_centiamperes = 50;  // what keeps the load where it is

}  // namespace

SimulatedCubemars::SimulatedCubemars(const SimulatedCubemarsSettings& settings, std::int64_t now_ns)
    : SimulatedServo(settings, settings.turns, now_ns, boot_delay_ns),
      settings_(settings),
      // Two motors have their own rhythms.
      feedback_ns_(boot_ns_ + settings.motor_number.value() * std::int64_t{70'000}) {}

const char* SimulatedCubemars::state_name() const {
  if (error_ != 0) return "fault";
  return is_on_ ? "position" : "off";
}

void SimulatedCubemars::live(double seconds) {
  if (error_ != 0 && !has_trouble(Kind::emergency)) error_ = 0;
  step(seconds);
  if (now_ns_ >= boot_ns_) report();
}

void SimulatedCubemars::step(double seconds) {
  motor_.hold(has_trouble(Kind::stick));
  if (!is_on_) return coast(seconds);
  if (const auto speed = troubles_.place(Kind::run_away, now_ns_))
    return motor_.follow_speed(*speed, seconds);
  if (told_turns_per_s_) return motor_.follow_speed(*told_turns_per_s_, seconds);
  const double turns_per_count = 1 / settings_.scale.counts_of(1);
  demand_.go_to(turns_of(told_.position) + zero_,
                {.velocity = told_.max_velocity * turns_per_count,
                 .acceleration = told_.max_acceleration * turns_per_count},
                seconds);
  motor_.follow({.position = demand_.position, .velocity = demand_.velocity}, seconds);
}

double SimulatedCubemars::turns_of(std::int32_t counts) const {
  const double taken = counts * troubles_.place(Kind::other_scale, now_ns_).value_or(1);
  return taken / settings_.scale.counts_per_deg / deg_per_turn;
}

/// Tenths of a degree, cut off, in 16 bits that go round.
can::Frame SimulatedCubemars::feedback() const {
  const double decidegrees = std::trunc(10 * deg_per_turn * here());
  const double erpm = 60 * settings_.scale.electric_turns_per_turn * motor_.velocity();
  const double dekaerpm = std::clamp(erpm / 10, -32'767.0, 32'767.0);
  return can::cubemars_feedback_frame(
      settings_.motor_number,
      {.decidegrees = static_cast<std::int16_t>(static_cast<std::int64_t>(decidegrees)),
       .dekaerpm = static_cast<std::int16_t>(dekaerpm),
       .centiamperes = is_on_ ? holding_centiamperes : std::int16_t{0},
       .celsius = 30,
       .error = error_});
}

void SimulatedCubemars::report() {
  for (std::int64_t due = troubles_.flood(now_ns_); due > 0; --due) send(feedback());
  if (now_ns_ < feedback_ns_) return;
  feedback_ns_ += settings_.feedback_period_ns;
  // Where and how it is come in one message.
  if (has_trouble(Kind::lose_feedback) || has_trouble(Kind::lose_heartbeat)) return;
  can::Frame frame = feedback();
  if (takes_frame(Kind::shorten)) --frame.length;
  send(frame);
}

void SimulatedCubemars::set_power(bool is_on) {
  if (is_on == is_on_) return;
  is_on_ = is_on;
  if (is_on_) demand_.start(motor_.position());
  record_entered();
}

void SimulatedCubemars::start_anew() {
  set_power(false);
  feedback_ns_ = boot_ns_;
}

void SimulatedCubemars::meet(const DriveTrouble& trouble) {
  switch (trouble.kind) {
    case Kind::emergency:
      error_ = static_cast<std::uint8_t>(trouble.value);
      record_reported(error_);
      return set_power(false);
    case Kind::foreign_sender: {
      const can::Frame frame = can::cubemars_position_frame(settings_.motor_number, told_);
      send(frame);
      return receive(frame);
    }
    default:
      return;  // while it lasts, something else is done where it would be
  }
}

void SimulatedCubemars::receive(const can::Frame& frame) {
  if (now_ns_ < boot_ns_) return;
  const auto position = can::read_cubemars_position(frame, settings_.motor_number);
  const auto current = can::read_cubemars_current(frame, settings_.motor_number);
  const auto speed = can::read_cubemars_speed(frame, settings_.motor_number);
  const bool is_meant = position || current || speed;
  if (!is_meant || takes_frame(Kind::lose_heard)) return;
  if (position) return take_position(*position);
  if (speed) return take_speed(*speed);
  if (*current == 0 && !has_trouble(Kind::stay_on)) set_power(false);
}

void SimulatedCubemars::take_speed(std::int32_t erpm) {
  if (error_ != 0) return;
  told_turns_per_s_ = erpm / 60.0 / settings_.scale.electric_turns_per_turn;
  set_power(true);
}

void SimulatedCubemars::take_position(const can::CubemarsPosition& position) {
  if (error_ != 0) return;
  if (!has_trouble(Kind::ignore_target)) told_ = position;
  if (told_turns_per_s_) demand_.start(motor_.position());
  told_turns_per_s_.reset();
  set_power(true);
  note_target(position.position);
  record_applied(turns_of(position.position));
}

}  // namespace inbetween
