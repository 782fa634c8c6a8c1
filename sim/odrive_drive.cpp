#include "sim/odrive_drive.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace inbetween {
namespace {

using can::OdriveFamily;
using can::OdriveMessage;

constexpr std::int64_t boot_delay_ns = 50'000'000;
constexpr std::uint8_t busy = 1;
constexpr std::uint8_t disarmed = 3;

constexpr std::uint32_t velocity_error(OdriveFamily family) {
  return family == OdriveFamily::firmware_05 ? 0x200U : 0x8000U;
}
constexpr std::uint32_t stopped_error(OdriveFamily family) {
  return family == OdriveFamily::firmware_05 ? 0x4000U : 0x200'0000U;
}

}  // namespace

SimulatedOdrive::SimulatedOdrive(const SimulatedOdriveSettings& settings, std::int64_t now_ns)
    : SimulatedServo(settings, settings.turns, now_ns, boot_delay_ns),
      settings_(settings),
      heartbeat_ns_(boot_ns_),
      // Two drives have their own rhythms.
      estimates_ns_(boot_ns_ + settings.node.value() * std::int64_t{700'000}),
      fed_ns_(boot_ns_) {}

const char* SimulatedOdrive::state_name() const {
  if (is_on()) return "closed loop";
  return (errors_ & ~can::odrive_watchdog_error(settings_.family)) != 0 ? "fault" : "idle";
}

void SimulatedOdrive::live(double seconds) {
  if (on_ns_ && now_ns_ >= *on_ns_) enter(can::odrive_closed_loop);
  step(seconds);
  if (now_ns_ < boot_ns_) return;
  const bool is_watched = settings_.watchdog_ns > 0;
  if (is_watched && now_ns_ - fed_ns_ > settings_.watchdog_ns) {
    fail(can::odrive_watchdog_error(settings_.family));
  }
  report();
}

void SimulatedOdrive::step(double seconds) {
  motor_.hold(has_trouble(Kind::stick));
  if (!is_on()) return coast(seconds);
  if (const auto speed = troubles_.place(Kind::run_away, now_ns_))
    return motor_.follow_speed(*speed, seconds);
  motor_.follow({.position = static_cast<double>(input_.turns) + zero_, .velocity = input_.turns_per_s},
                seconds);
  if (std::fabs(motor_.velocity()) > settings_.velocity_limit) fail(velocity_error(settings_.family));
}

void SimulatedOdrive::report() {
  if (now_ns_ >= heartbeat_ns_) {
    heartbeat_ns_ += settings_.heartbeat_period_ns;
    if (!has_trouble(Kind::lose_heartbeat)) send(heartbeat());
  }
  if (now_ns_ >= estimates_ns_) {
    estimates_ns_ += settings_.estimates_period_ns;
    if (!has_trouble(Kind::lose_feedback)) {
      can::Frame frame = estimates();
      if (takes_frame(Kind::shorten)) --frame.length;
      send(frame);
    }
  }
  for (std::int64_t due = troubles_.flood(now_ns_); due > 0; --due) {
    send(can::odrive_error_frame(settings_.node, {.active = errors_}));
  }
}

can::Frame SimulatedOdrive::heartbeat() const {
  can::OdriveHeartbeat told{.errors = errors_, .state = state_};
  if (settings_.family == OdriveFamily::firmware_06) {
    told.result = on_ns_ ? busy : errors_ != 0 ? disarmed : std::uint8_t{0};
  } else if ((errors_ & velocity_error(settings_.family)) != 0) {
    told.sub_errors = 4;
  }
  return can::odrive_heartbeat_frame(settings_.node, settings_.family, told);
}

can::Frame SimulatedOdrive::estimates() const {
  return can::odrive_estimates_frame(settings_.node, static_cast<float>(here()),
                                     static_cast<float>(motor_.velocity()));
}

void SimulatedOdrive::enter(std::uint8_t state) {
  on_ns_.reset();
  if (state == state_) return;
  state_ = state;
  if (is_on()) input_.turns = static_cast<float>(here());
  record_entered();
}

void SimulatedOdrive::fail(std::uint32_t errors) {
  if ((errors_ & errors) == errors) return;
  errors_ |= errors;
  const bool is_of_silence = errors == can::odrive_watchdog_error(settings_.family);
  // A drive without power that nobody speaks to complains of nothing that anybody waits for.
  if (is_on() || !is_of_silence) record_reported(errors);
  enter(can::odrive_idle);
}

void SimulatedOdrive::start_anew() {
  errors_ = 0;
  input_ = {};
  enter(can::odrive_idle);
  heartbeat_ns_ = estimates_ns_ = fed_ns_ = boot_ns_;
}

void SimulatedOdrive::meet(const DriveTrouble& trouble) {
  switch (trouble.kind) {
    case Kind::emergency:
      return fail(static_cast<std::uint32_t>(trouble.value));
    case Kind::switched_off:
      return enter(can::odrive_idle);
    case Kind::no_watchdog:
      settings_.watchdog_ns = 0;
      return;
    case Kind::foreign_sender: {
      const can::Frame frame =
          *can::odrive_position_frame(settings_.node, {.turns = static_cast<float>(here())});
      send(frame);
      return receive(frame);
    }
    default:
      return;  // while it lasts, something else is done where it would be
  }
}

void SimulatedOdrive::receive(const can::Frame& frame) {
  const bool is_meant = !frame.id.is_extended() && frame.id.number() >> 5 == settings_.node.value();
  if (!is_meant || now_ns_ < boot_ns_ || takes_frame(Kind::lose_heard)) return;
  fed_ns_ = now_ns_;
  if (frame.is_remote) return answer(frame);
  switch (static_cast<OdriveMessage>(frame.id.number() & can::odrive_message_bits)) {
    case OdriveMessage::emergency_stop:
      if (!has_trouble(Kind::stay_on)) fail(stopped_error(settings_.family));
      return;
    case OdriveMessage::axis_state:
      return obey_state(std::uint32_t{frame.data[0]});
    case OdriveMessage::controller_mode:
      input_.turns = static_cast<float>(here());
      return;
    case OdriveMessage::input_position:
      if (const auto position = can::read_odrive_position(frame, settings_.node)) take_position(*position);
      return;
    case OdriveMessage::clear_errors:
      if (!has_trouble(Kind::emergency)) errors_ = 0;
      return;
    default:
      return;
  }
}

/// The gate driver, the encoder that does not answer, the overspeed: whatever part has failed (0.5).
std::uint32_t SimulatedOdrive::part_errors(std::size_t part) const {
  constexpr std::array<std::uint32_t, 3> of_axis{0x40, 0x100, 0x200};
  constexpr std::array<std::uint32_t, 3> of_part{0x8, 0x4, 0x1};
  return (errors_ & of_axis.at(part)) != 0 ? of_part.at(part) : 0;
}

void SimulatedOdrive::obey_state(std::uint32_t state) {
  if (state == can::odrive_idle && !has_trouble(Kind::stay_on)) enter(can::odrive_idle);
  if (state != can::odrive_closed_loop || errors_ != 0) return;
  if (is_on()) enter(can::odrive_idle);  // it leaves the loop for a moment
  on_ns_ = now_ns_ + settings_.enable_delay_ns;
}

void SimulatedOdrive::take_position(const can::OdrivePosition& position) {
  if (!has_trouble(Kind::ignore_target)) input_ = position;
  if (!is_on()) return;
  const auto turns = static_cast<double>(position.turns);
  note_target(turns);
  record_applied(turns);
}

void SimulatedOdrive::answer(const can::Frame& question) {
  const bool is_06 = settings_.family == OdriveFamily::firmware_06;
  switch (static_cast<OdriveMessage>(question.id.number() & can::odrive_message_bits)) {
    case OdriveMessage::version:
      if (is_06) {
        send(can::odrive_version_frame(settings_.node,
                                       {.protocol = 2, .hardware = {5, 2, 0}, .firmware = {0, 6, 8}}));
      }
      return;
    case OdriveMessage::heartbeat:
      return send(heartbeat());
    case OdriveMessage::estimates:
      return send(estimates());
    case OdriveMessage::error:
      send(is_06 ? can::odrive_error_frame(settings_.node, {.active = errors_, .disarm_reason = errors_})
                 : can::odrive_part_frame(settings_.node, can::OdrivePart::motor, part_errors(0)));
      return;
    case OdriveMessage::address:
      if (is_06) return send(can::odrive_address_frame(settings_.node, settings_.serial));
      return;
    case OdriveMessage::parameter_order:
      if (!is_06) send(can::odrive_part_frame(settings_.node, can::OdrivePart::encoder, part_errors(1)));
      return;
    case OdriveMessage::controller_error:
      if (!is_06) send(can::odrive_part_frame(settings_.node, can::OdrivePart::controller, part_errors(2)));
      return;
    default:
      return;
  }
}

}  // namespace inbetween
