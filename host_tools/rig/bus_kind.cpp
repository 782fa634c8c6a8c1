#include "host_tools/rig/bus_kind.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <type_traits>

#include "drivers/can/socket_can.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "inbetween/can/bus_load.hpp"

namespace inbetween {
namespace {

/// A tick in which every drive gets a target and a question is sent at once, or not at all.
void refuse_long_ticks(const Bus& bus, const BusShare& share) {
  constexpr std::int64_t sent_at_once = can::SocketCan::max_frames;
  if (share.frames <= sent_at_once) return;
  throw InputError(bus.place, fmt::format("the {} on bus {}{} need {} frames in a tick, and {} are sent at "
                                          "once; spread them over more buses",
                                          counted(share.drives, "drive"), in_quotes(bus.name), share.because,
                                          share.frames, sent_at_once));
}

bool meet(const can::CanFilter& one, const can::CanFilter& other) {
  return one.id.is_extended() == other.id.is_extended() &&
         ((one.id.number() ^ other.id.number()) & ~(one.any_bits | other.any_bits)) == 0;
}

template <class Kind>
std::vector<can::CanFilter> identifiers_of(const RigAxis& axis) {
  std::vector<can::CanFilter> all = Kind::heard_by_host(axis);
  std::ranges::copy(Kind::heard_by_drive(axis), std::back_inserter(all));
  return all;
}

/// Within a protocol, different nodes have different identifiers.
template <class Kind, class Other>
void refuse_common_identifiers(const RigFile& rig, const Bus& bus) {
  for (const std::size_t a : axes_of_kind<Kind>(rig, bus.name)) {
    for (const std::size_t b : axes_of_kind<Other>(rig, bus.name)) {
      for (const can::CanFilter& one : identifiers_of<Kind>(rig.axes[a])) {
        for (const can::CanFilter& other : identifiers_of<Other>(rig.axes[b])) {
          if (!meet(one, other)) continue;
          throw InputError(
              rig.axes[b].place,
              fmt::format("{}: its drive and that of {} would both use identifier {:X}h on bus {}; "
                          "give it another node, or another bus",
                          named(rig.axes[b]), named(rig.axes[a]), one.id.number() | other.id.number(),
                          in_quotes(bus.name)));
        }
      }
    }
  }
}

void refuse_common_identifiers(const RigFile& rig, const Bus& bus) {
  for_each_bus_kind([&]<class Kind>() {
    for_each_bus_kind([&]<class Other>() {
      if constexpr (!std::is_same_v<Kind, Other>) refuse_common_identifiers<Kind, Other>(rig, bus);
    });
  });
}

}  // namespace

AxisWatch watch_of(const RigAxis& axis) {
  const FollowLimits follow = follow_limits_of(axis.drive).value_or(FollowLimits{});
  return AxisWatch({.min = axis.min,
                    .max = axis.max,
                    .max_velocity = axis.max_velocity,
                    .stop_acceleration = stop_acceleration_of(axis),
                    .max_following_error = follow.max_following_error,
                    .in_position = follow.in_position,
                    .rest = rest_distance_of(axis)});
}

BusShare share_of_bus(const RigFile& rig, const Bus& bus) {
  BusShare all;
  for_each_bus_kind([&]<class Kind>() {
    const std::vector<std::size_t> axes = axes_of_kind<Kind>(rig, bus.name);
    if (axes.empty()) return;
    const BusShare share = Kind::share_of(rig, axes);
    all.drives += share.drives;
    all.frames += share.frames;
    all.bits += share.bits;
    all.bits_of_bus += share.bits_of_bus;
    all.because += share.because;
  });
  return all;
}

void refuse_overloaded_buses(const RigFile& rig) {
  for (const Bus& bus : rig.buses) {
    const BusShare share = share_of_bus(rig, bus);
    refuse_common_identifiers(rig, bus);
    refuse_long_ticks(bus, share);
    const std::int64_t bits_per_s = share.bits * rig.rate_hz;
    if (100 * bits_per_s <= can::bus_load_limit_percent * bus.bitrate) continue;
    const std::int64_t usable = can::bus_load_limit_percent * bus.bitrate / (100 * rig.rate_hz);
    const std::int64_t of_drives = share.bits - share.bits_of_bus;
    const std::int64_t fit = std::max<std::int64_t>(0, usable - share.bits_of_bus) * share.drives / of_drives;
    const std::int64_t per_mille = (1000 * bits_per_s + bus.bitrate - 1) / bus.bitrate;
    throw InputError(
        bus.place, fmt::format("the {} on bus {} need {:.1f} % of its {} bit/s{} at {} Hz, and {} % "
                               "may be used; lower rate_hz, or spread them over more buses ({} "
                               "fit)",
                               counted(share.drives, "drive"), in_quotes(bus.name),
                               static_cast<double>(per_mille) / 10, bus.bitrate,
                               bus.data_bitrate ? fmt::format(" ({} bit/s of data)", *bus.data_bitrate) : "",
                               rig.rate_hz, can::bus_load_limit_percent, fit));
  }
}

}  // namespace inbetween
