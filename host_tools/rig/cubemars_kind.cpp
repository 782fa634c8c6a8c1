#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host_tools/rig/servo_kinds.hpp"
#include "inbetween/can/bus_load.hpp"
#include "sim/cubemars_drive.hpp"

namespace inbetween {
namespace {

constexpr std::uint32_t command_bits = (can::cubemars_commands - 1) << 8;

can::CubemarsMotor cubemars_motor_of(const RigAxis& axis) {
  return value_or_refuse(can::CubemarsMotor::make(std::get<CubemarsDrive>(axis.drive).node), axis.place,
                         named(axis));
}

can::CubemarsScale cubemars_scale_of(const CubemarsDrive& drive) {
  return {.counts_per_deg = drive.counts_per_deg,
          .erpm_per_count = drive.erpm_per_count,
          .electric_turns_per_turn = drive.pole_pairs * drive.gear};
}

can::CubemarsSettings cubemars_settings_of(const RigAxis& axis) {
  // Where it stands already a motor need not hurry: one that counts from another place than it says, or in
  // another scale, is found before it has gone far.
  constexpr double hold_share = 0.05;
  // A ramp well above that of the axis, so that the motor follows, and what its 16 bits hold at most.
  constexpr double ramp_share = 4;
  const CubemarsLimits limits = cubemars_limits_of(axis);
  const double ramp = std::min(ramp_share * limits.stop_acceleration, CubemarsLimits::max);
  return {.motor = cubemars_motor_of(axis),
          .scale = cubemars_scale_of(std::get<CubemarsDrive>(axis.drive)),
          .max_velocity = static_cast<std::int16_t>(limits.velocity),
          .hold_velocity = static_cast<std::int16_t>(std::max(1.0, std::floor(hold_share * limits.velocity))),
          .max_acceleration = static_cast<std::int16_t>(ramp)};
}

}  // namespace

CubemarsKind::Host CubemarsKind::host_of(const RigAxis& axis, std::int32_t rate_hz) {
  can::ServoSettings settings = servo_settings_of(axis, rate_hz);
  set_noise(settings, 2 / cubemars_steps_per_turn);
  const can::Cubemars motor =
      value_or_refuse(can::Cubemars::make(cubemars_settings_of(axis)), axis.place, named(axis));
  return value_or_refuse(Host::make(motor, settings), axis.place, named(axis));
}

std::string CubemarsKind::detail_of(const Host& host, can::DriveFinding /*finding*/) {
  const std::uint32_t error = host.last_errors();
  if (error == 0) return "";
  return fmt::format(" (error {}: {})", error, can::words_of_cubemars_error(error));
}

std::vector<std::string> CubemarsKind::lacks_of(const Host& /*host*/) {
  return {std::string(words_without_watchdog)};
}

std::string CubemarsKind::fitness_of(const Host& host, std::int32_t /*rate_hz*/) {
  return fmt::format("motor {} tells where it is and has no watchdog, which the rig accepts",
                     host.protocol().motor().value());
}

std::vector<can::CanFilter> CubemarsKind::heard_by_host(const RigAxis& axis) {
  const can::CubemarsMotor motor = cubemars_motor_of(axis);
  return {{.id = can::cubemars_id(motor, can::CubemarsPacket::feedback)},
          {.id = can::FrameId::extended(motor.value()), .any_bits = command_bits}};
}

std::vector<can::CanFilter> CubemarsKind::heard_by_drive(const RigAxis& axis) {
  return {{.id = can::FrameId::extended(cubemars_motor_of(axis).value()), .any_bits = command_bits}};
}

/// A position for each, and feedback as often as a motor can send it.
BusShare CubemarsKind::share_of(const RigFile& rig, std::span<const std::size_t> axes) {
  constexpr std::int64_t max_feedback_hz = 500;
  const auto drives = static_cast<std::int64_t>(axes.size());
  const std::int64_t feedback_per_tick = (max_feedback_hz + rig.rate_hz - 1) / rig.rate_hz;
  return {.drives = drives,
          .frames = static_cast<std::int64_t>(Bus::frames_per_tick(axes.size())),
          .bits = (1 + feedback_per_tick) * drives * can::worst_case_bits(8, true)};
}

std::unique_ptr<SimulatedCanDrive> CubemarsKind::simulate(const RigAxis& axis, const SimulatedPower& power) {
  const double scale = scale_of(axis);
  SimulatedCubemarsSettings settings{.motor_number = cubemars_motor_of(axis),
                                     .scale = cubemars_scale_of(std::get<CubemarsDrive>(axis.drive)),
                                     .turns = power.position * scale,
                                     .keeps_record = power.keeps_record};
  settings.motor.max_acceleration =
      std::max(settings.motor.max_acceleration, 4 * std::fabs(scale) * axis.max_acceleration);
  return std::make_unique<SimulatedCubemars>(settings, power.now_ns);
}

}  // namespace inbetween
