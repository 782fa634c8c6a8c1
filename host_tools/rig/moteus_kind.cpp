#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host_tools/rig/servo_kinds.hpp"
#include "inbetween/can/bus_load.hpp"
#include "inbetween/loop/tick_time.hpp"
#include "sim/moteus_drive.hpp"

namespace inbetween {
namespace {

/// Without a command for so long a drive stops by itself: some ticks, and never so short that a moment's
/// delay ends a shot.
constexpr std::int64_t ticks_waited_for = 5;
constexpr std::int64_t min_wait_ns = 50'000'000;
/// Every frame is answered. What it goes on for when it is not heard is the distance of three ticks.
constexpr std::int64_t answers_waited_for = 3;
constexpr std::int64_t min_answer_wait_ns = 10'000'000;

/// What a position command and its answer take (firmware_core/include/inbetween/can/moteus.hpp).
constexpr std::int32_t command_bytes = 32;
constexpr std::int32_t answer_bytes = 24;

can::MoteusNode moteus_node_of(const RigAxis& axis) {
  return value_or_refuse(can::MoteusNode::make(std::get<MoteusDrive>(axis.drive).node), axis.place,
                         named(axis));
}

std::int64_t moteus_watchdog_ns(std::int32_t rate_hz) {
  return std::max(min_wait_ns, ticks_waited_for * ns_per_s / rate_hz);
}

/// Whatever others send to the drive, or to all, with identifiers of 11 and of 29 bits.
std::vector<can::CanFilter> filters_for(std::uint32_t receiver) {
  constexpr std::uint32_t any_sender = 0xFF80;
  constexpr std::uint32_t any_sender_of_11_bits = any_sender & 0x7FF;
  return {{.id = can::FrameId::extended(receiver), .any_bits = any_sender},
          {.id = can::FrameId::standard(receiver), .any_bits = any_sender_of_11_bits}};
}

}  // namespace

MoteusKind::Host MoteusKind::host_of(const RigAxis& axis, std::int32_t rate_hz) {
  can::ServoSettings settings = servo_settings_of(axis, rate_hz);
  settings.place_timeout_ns = std::max(min_answer_wait_ns, answers_waited_for * ns_per_s / rate_hz);
  settings.status_timeout_ns = settings.place_timeout_ns;
  const double watchdog_s = static_cast<double>(moteus_watchdog_ns(rate_hz)) / static_cast<double>(ns_per_s);
  return value_or_refuse(Host::make(can::Moteus({.node = moteus_node_of(axis),
                                                 .watchdog_s = watchdog_s,
                                                 .must_know_place = axis.reference == Reference::by_drive}),
                                    settings),
                         axis.place, named(axis));
}

std::string MoteusKind::detail_of(const Host& host, can::DriveFinding finding) {
  if (finding == can::DriveFinding::wrong_firmware) {
    return fmt::format(" (its registers are of version {}, and this program knows version {})",
                       host.version(), can::moteus_map_version);
  }
  const std::uint32_t error = host.last_errors();
  if (error == 0) return "";
  const bool is_mode = error >= can::moteus_mode_error;
  return fmt::format(" ({} {}: {})", is_mode ? "mode" : "fault",
                     is_mode ? error - can::moteus_mode_error : error, can::words_of_moteus_error(error));
}

std::string MoteusKind::fitness_of(const Host& host, std::int32_t /*rate_hz*/) {
  const can::Moteus::Settings& its = host.protocol().settings();
  return fmt::format(
      "node {} has registers of version {}, a watchdog of {:.0f} ms with every command, and told "
      "within {} ms that nobody spoke to it",
      its.node.value(), host.version(), its.watchdog_s * 1000, host.proven_watchdog_ns() / 1'000'000);
}

std::vector<can::CanFilter> MoteusKind::heard_by_host(const RigAxis& axis) {
  const std::uint32_t node = moteus_node_of(axis).value();
  const std::uint32_t answer = node << can::moteus_sender_shift;
  std::vector<can::CanFilter> filters{{.id = can::FrameId::extended(answer)}};
  if (answer <= can::FrameId::max_standard) {
    filters.push_back({.id = can::FrameId::standard(answer)});
  }
  for (const std::uint32_t receiver : {node, can::moteus_all_nodes}) {
    std::ranges::copy(filters_for(receiver), std::back_inserter(filters));
  }
  return filters;
}

std::vector<can::CanFilter> MoteusKind::heard_by_drive(const RigAxis& axis) {
  std::vector<can::CanFilter> filters = filters_for(moteus_node_of(axis).value());
  std::ranges::copy(filters_for(can::moteus_all_nodes), std::back_inserter(filters));
  return filters;
}

/// A command and its answer for each; the bits of data in times of one of the arbitration.
BusShare MoteusKind::share_of(const RigFile& rig, std::span<const std::size_t> axes) {
  BusShare share{.drives = static_cast<std::int64_t>(axes.size()),
                 .frames = static_cast<std::int64_t>(Bus::frames_per_tick(axes.size()))};
  for (const std::size_t a : axes) {
    const inbetween::Bus& bus = bus_named(rig, std::get<MoteusDrive>(rig.axes[a].drive).bus);
    const bool is_long = std::uint32_t{moteus_node_of(rig.axes[a]).value()} << can::moteus_sender_shift >
                         can::FrameId::max_standard;
    share.bits += can::bits_of_arbitration(can::worst_case_fd_bits(command_bytes, true), bus.bitrate,
                                           *bus.data_bitrate) +
                  can::bits_of_arbitration(can::worst_case_fd_bits(answer_bytes, is_long), bus.bitrate,
                                           *bus.data_bitrate);
  }
  return share;
}

std::unique_ptr<SimulatedFdDrive> MoteusKind::simulate(const RigAxis& axis, const SimulatedPower& power) {
  const double scale = scale_of(axis);
  SimulatedMoteusSettings settings{
      .node = moteus_node_of(axis), .turns = power.position * scale, .keeps_record = power.keeps_record};
  settings.motor.max_acceleration =
      std::max(settings.motor.max_acceleration, 4 * std::fabs(scale) * axis.max_acceleration);
  return std::make_unique<SimulatedMoteus>(settings, power.now_ns);
}

}  // namespace inbetween
