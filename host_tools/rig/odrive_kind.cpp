#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "host_tools/rig/servo_kinds.hpp"
#include "inbetween/can/bus_load.hpp"
#include "sim/odrive_drive.hpp"

namespace inbetween {
namespace {

can::OdriveNode odrive_node_of(const RigAxis& axis) {
  return value_or_refuse(can::OdriveNode::make(std::get<OdriveDrive>(axis.drive).node), axis.place,
                         named(axis));
}

/// The first of the identifiers of a drive: its message bits are 0.
can::FrameId first_odrive_id(const RigAxis& axis) {
  return can::FrameId::standard(std::uint32_t{odrive_node_of(axis).value()} << 5);
}

can::OdriveFamily family_of(const RigAxis& axis) {
  const bool is_old = std::get<OdriveDrive>(axis.drive).firmware == OdriveFirmware::v0_5;
  return is_old ? can::OdriveFamily::firmware_05 : can::OdriveFamily::firmware_06;
}

const char* words_of_error_05(std::uint32_t bit) {
  return can::words_of_odrive_error(can::OdriveFamily::firmware_05, bit);
}
const char* words_of_error_06(std::uint32_t bit) {
  return can::words_of_odrive_error(can::OdriveFamily::firmware_06, bit);
}

}  // namespace

OdriveKind::Host OdriveKind::host_of(const RigAxis& axis, std::int32_t rate_hz) {
  return value_or_refuse(
      Host::make(can::Odrive(odrive_node_of(axis), family_of(axis)), servo_settings_of(axis, rate_hz)),
      axis.place, named(axis));
}

std::string OdriveKind::detail_of(const Host& host, can::DriveFinding /*finding*/) {
  const bool is_old = host.protocol().family() == can::OdriveFamily::firmware_05;
  std::string words = words_of_error_bits(host.last_errors(), is_old ? words_of_error_05 : words_of_error_06);
  if (words.empty()) return words;
  constexpr std::array<const char* (*)(std::uint32_t), can::odrive_parts.size()> words_of_parts{
      [](std::uint32_t bit) { return can::words_of_odrive_part(can::OdrivePart::motor, bit); },
      [](std::uint32_t bit) { return can::words_of_odrive_part(can::OdrivePart::encoder, bit); },
      [](std::uint32_t bit) { return can::words_of_odrive_part(can::OdrivePart::controller, bit); }};
  constexpr std::array names{"motor", "encoder", "controller"};
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::uint32_t errors = host.protocol().part_errors().at(i);
    if (errors != 0)
      words += fmt::format(", of its {}{}", names.at(i), words_of_error_bits(errors, words_of_parts.at(i)));
  }
  const std::uint32_t reason = host.protocol().disarm_reason();
  if (reason != 0 && reason != host.last_errors()) {
    words += fmt::format(", switched off by{}", words_of_error_bits(reason, words_of_error_06));
  }
  return words;
}

std::string OdriveKind::fitness_of(const Host& host, std::int32_t /*rate_hz*/) {
  const bool is_old = host.protocol().family() == can::OdriveFamily::firmware_05;
  return fmt::format("node {} has firmware {} and told within {} ms that nobody spoke to it",
                     host.protocol().node().value(), is_old ? "0.5" : "0.6",
                     host.proven_watchdog_ns() / 1'000'000);
}

std::vector<can::CanFilter> OdriveKind::heard_by_host(const RigAxis& axis) {
  return {{.id = first_odrive_id(axis), .any_bits = can::odrive_message_bits}};
}

std::vector<can::CanFilter> OdriveKind::heard_by_drive(const RigAxis& axis) {
  const can::FrameId id = first_odrive_id(axis);
  return {{.id = id, .any_bits = can::odrive_message_bits},
          {.id = id, .is_remote = true, .any_bits = can::odrive_message_bits}};
}

/// A position and an estimate for each; a drive reports in its own rhythm, which is not faster than ours.
BusShare OdriveKind::share_of(const RigFile& /*rig*/, std::span<const std::size_t> axes) {
  const auto drives = static_cast<std::int64_t>(axes.size());
  return {.drives = drives,
          .frames = static_cast<std::int64_t>(Bus::frames_per_tick(axes.size())),
          .bits = 2 * drives * can::worst_case_bits(8, false)};
}

std::unique_ptr<SimulatedCanDrive> OdriveKind::simulate(const RigAxis& axis, const SimulatedPower& power) {
  const double scale = scale_of(axis);
  SimulatedOdriveSettings settings{.node = odrive_node_of(axis),
                                   .family = family_of(axis),
                                   .turns = power.position * scale,
                                   .keeps_record = power.keeps_record};
  settings.motor.max_acceleration =
      std::max(settings.motor.max_acceleration, 4 * std::fabs(scale) * axis.max_acceleration);
  return std::make_unique<SimulatedOdrive>(settings, power.now_ns);
}

}  // namespace inbetween
