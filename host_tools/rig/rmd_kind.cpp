#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host_tools/rig/servo_kinds.hpp"
#include "inbetween/can/bus_load.hpp"
#include "inbetween/loop/tick_time.hpp"
#include "sim/rmd_drive.hpp"

namespace inbetween {
namespace {

can::RmdMotor rmd_motor_of(const RigAxis& axis) {
  return value_or_refuse(can::RmdMotor::make(std::get<RmdDrive>(axis.drive).node), axis.place, named(axis));
}

can::RmdSettings rmd_settings_of(const RigAxis& axis, std::int32_t rate_hz) {
  const RmdDrive& drive = std::get<RmdDrive>(axis.drive);
  // Where it stands already a motor need not hurry: one that counts from another place than it says is found
  // before it has gone far.
  constexpr double hold_share = 0.05;
  const double limit = max_rmd_deg_per_s_of(axis);
  const std::int64_t four_ticks_ms = 4000 / rate_hz;
  return {.motor = rmd_motor_of(axis),
          .max_deg_per_s = static_cast<std::uint16_t>(limit),
          .hold_deg_per_s = static_cast<std::uint16_t>(std::max(1.0, std::floor(hold_share * limit))),
          .host_timeout_ms = static_cast<std::uint32_t>(std::max<std::int64_t>(100, four_ticks_ms)),
          .has_no_watchdog = drive.has_no_watchdog};
}

}  // namespace

RmdKind::Host RmdKind::host_of(const RigAxis& axis, std::int32_t rate_hz) {
  can::ServoSettings settings = servo_settings_of(axis, rate_hz);
  set_noise(settings, 2 / can::rmd_steps_per_turn);
  // Of four answers one tells how it is.
  settings.status_timeout_ns = std::max(settings.status_timeout_ns, 12 * ns_per_s / rate_hz);
  const can::Rmd motor =
      value_or_refuse(can::Rmd::make(rmd_settings_of(axis, rate_hz)), axis.place, named(axis));
  return value_or_refuse(Host::make(motor, settings), axis.place, named(axis));
}

std::string RmdKind::detail_of(const Host& host, can::DriveFinding /*finding*/) {
  return words_of_error_bits(host.last_errors(), can::words_of_rmd_error);
}

std::vector<std::string> RmdKind::lacks_of(const Host& host) {
  if (host.protocol().watch() != can::ServoWatch::accepted) return {};
  return {std::string(words_without_watchdog)};
}

std::string RmdKind::fitness_of(const Host& host, std::int32_t /*rate_hz*/) {
  const can::Rmd& motor = host.protocol();
  const std::string number = fmt::format("motor {} follows positions at once and ", motor.motor().value());
  if (motor.watch() == can::ServoWatch::accepted) return number + "has no watchdog, which the rig accepts";
  return fmt::format("{}has confirmed a watchdog of {} ms", number, motor.host_timeout_ms());
}

std::vector<can::CanFilter> RmdKind::heard_by_host(const RigAxis& axis) {
  const can::RmdMotor motor = rmd_motor_of(axis);
  return {{.id = can::rmd_answer_id(motor)},
          {.id = can::rmd_command_id(motor)},
          {.id = can::rmd_motion_id(motor)},
          {.id = can::rmd_all_motors_id}};
}

std::vector<can::CanFilter> RmdKind::heard_by_drive(const RigAxis& axis) {
  return {{.id = can::rmd_command_id(rmd_motor_of(axis))}};
}

/// A position and a question for each, and an answer to both.
BusShare RmdKind::share_of(const RigFile& /*rig*/, std::span<const std::size_t> axes) {
  const auto drives = static_cast<std::int64_t>(axes.size());
  return {.drives = drives,
          .frames = static_cast<std::int64_t>(Bus::frames_per_tick(axes.size())),
          .bits = 4 * drives * can::worst_case_bits(8, false)};
}

std::unique_ptr<SimulatedCanDrive> RmdKind::simulate(const RigAxis& axis, const SimulatedPower& power) {
  const double scale = scale_of(axis);
  SimulatedRmdSettings settings{.motor_number = rmd_motor_of(axis),
                                .turns = power.position * scale,
                                .keeps_record = power.keeps_record};
  settings.motor.max_acceleration =
      std::max(settings.motor.max_acceleration, 4 * std::fabs(scale) * axis.max_acceleration);
  return std::make_unique<SimulatedRmd>(settings, power.now_ns);
}

}  // namespace inbetween
