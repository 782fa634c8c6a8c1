#include "host_tools/rig/can_drives.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "host_tools/files/diagnostics.hpp"
#include "inbetween/can/bus_load.hpp"
#include "inbetween/can/canopen_id.hpp"
#include "inbetween/can/pdo.hpp"
#include "inbetween/loop/tick_time.hpp"

namespace inbetween {
namespace {

/// By which a setpoint may be further from the last than max_velocity allows: rounding to counts, and the
/// rates above the drawn one that are certified within it.
constexpr double step_share = 1.2;
/// The host's heartbeat, and how many of them a drive waits for.
constexpr std::int64_t heartbeat_ns = 30'000'000;
constexpr std::int64_t heartbeats_waited_for = can::life_time_factor;
constexpr std::int64_t ns_per_ms = 1'000'000;
/// How long a drive waits for a setpoint: in ticks, of which one may be late, and at least. Meanwhile it
/// holds the last one, which stops the axis as hard as its motor can; then it brakes by its own ramp.
constexpr std::int64_t setpoints_waited_for = 4;
constexpr std::int64_t min_setpoint_wait_ms = 20;

/// Counts that a double has every one of.
constexpr double max_counts = 9'007'199'254'740'992;

std::int64_t tick_ns(std::int32_t rate_hz) {
  return ns_per_s / rate_hz;
}
std::int64_t heartbeat_period_ns(std::int32_t rate_hz) {
  return std::max(heartbeat_ns, tick_ns(rate_hz));
}

/// What a drive may lack that its owner should know.
struct Lack {
  std::uint16_t index;
  const char* words;
};
constexpr std::array lacks{
    Lack{0x6502, "the drive does not list its modes (no 6502); it is moved once 6061 shows mode 8"},
    Lack{0x60C2, "the drive is not told how long a tick is (no 60C2); it goes by the period of SYNC (1006)"},
    Lack{0x607D,
         "the drive has no soft limits (no 607D); only this program keeps the axis between min and max"},
    Lack{0x605A, "the drive does not say how it brakes in a quick stop (no 605A); its manual must"},
    Lack{0x6085, "the drive is not told how hard it brakes in a quick stop (no 6085); set that in the drive"},
    Lack{0x605E, "the drive does not say how it brakes in a fault (no 605E); its manual must"},
    Lack{0x1016,
         "the drive does not watch this program's heartbeat (no 1016); its setpoint timeout (1400:5) stops "
         "it"}};

/// A length of an axis in counts of its drive, at least one.
std::int32_t whole_counts(double length, double counts_per_unit) {
  return static_cast<std::int32_t>(std::clamp(std::round(length * std::fabs(counts_per_unit)), 1.0, 1e9));
}

/// A tick in which every drive gets a target and a question is sent at once, or not at all.
void refuse_long_ticks(const Bus& bus, std::int64_t drives, std::int64_t guarded) {
  constexpr std::int64_t sent_at_once = can::SocketCan::max_frames;
  const std::int64_t frames = frames_of_bus_per_tick + drives + guarded;
  if (frames <= sent_at_once) return;
  throw InputError(
      bus.place,
      fmt::format("the {} on bus {}, {} of them guarded, need {} frames in a tick, and {} are sent "
                  "at once; spread them over more buses",
                  counted(drives, "drive"), in_quotes(bus.name), guarded, frames, sent_at_once));
}

}  // namespace

// --- what a rig file says

can::NodeId host_node() {
  return *can::NodeId::make(127);
}

can::NodeId node_of(const RigAxis& axis) {
  return value_or_refuse(can::NodeId::make(std::get<Cia402Drive>(axis.drive).node), axis.place, named(axis));
}

can::Cia402Settings settings_of(const RigAxis& axis, std::int32_t rate_hz) {
  const Cia402Drive& drive = std::get<Cia402Drive>(axis.drive);
  const double scale = drive.counts_per_unit;
  const double ends[] = {axis.min * scale, axis.max * scale};
  const std::int64_t timeout_ms = heartbeats_waited_for * heartbeat_period_ns(rate_hz) / ns_per_ms;
  const std::int64_t setpoint_ms =
      std::max(min_setpoint_wait_ms, setpoints_waited_for * tick_ns(rate_hz) / ns_per_ms);
  can::Cia402Settings settings{
      .setup = {
          .node = node_of(axis),
          .host = host_node(),
          .rate_hz = rate_hz,
          .host_timeout_ms = static_cast<std::uint16_t>(std::min<std::int64_t>(timeout_ms, 65'535)),
          .is_guarded = drive.is_guarded,
          .setpoint_timeout_ms = static_cast<std::uint16_t>(std::min<std::int64_t>(setpoint_ms, 65'535)),
          .position_limits =
              can::CountRange{.min = static_cast<std::int32_t>(std::floor(std::min(ends[0], ends[1]))),
                              .max = static_cast<std::int32_t>(std::ceil(std::max(ends[0], ends[1])))},
          .quick_stop_deceleration = drive.stop_deceleration,
          .coasts = axis.coasts,
          .stops_without_host = axis.stops_without_host,
          .watches_following_error = drive.watches_following_error}};
  if (drive.resets_node) settings.reset = can::NmtCommand::reset_node;
  settings.enable_timeout_ns =
      static_cast<std::int64_t>(drive.enable_timeout_s * static_cast<double>(ns_per_s));
  // What the axis covers at max_velocity in half a millisecond is a place that it holds, whatever its scale.
  constexpr double hold_s = 0.0005;
  settings.hold_tolerance_counts = whole_counts(hold_s * axis.max_velocity, scale);
  const double tick_s = 1.0 / rate_hz;
  settings.first_step_counts = whole_counts(0.5 * axis.max_acceleration * tick_s * tick_s, scale);
  // The ramp of the drive is not known; that of the axis, twice, is long enough.
  settings.disable_timeout_ns += static_cast<std::int64_t>(2 * axis.max_velocity / axis.max_acceleration *
                                                           static_cast<double>(ns_per_s));
  // A thousandth of max_velocity is rest, and a count to either side.
  const double rest_s = static_cast<double>(settings.rest_ns) / static_cast<double>(ns_per_s);
  settings.rest_counts = static_cast<std::int32_t>(std::ceil(
                             std::min(0.001 * std::fabs(scale) * axis.max_velocity * rest_s, 1e9))) +
                         1;
  settings.max_step_counts =
      static_cast<std::int32_t>(std::ceil(step_share * std::fabs(scale) * axis.max_velocity / rate_hz)) + 1;
  return settings;
}

std::string words_of(const can::SetupRefusal& refusal) {
  std::string text = fmt::format("object {:04X}h:{}", refusal.object.index, refusal.object.sub);
  const unsigned group = refusal.object.index & 0xFE00U;
  const bool is_mapping = (group == 0x1600 || group == 0x1A00) && refusal.object.sub != 0;
  if (is_mapping && !refusal.found) {
    const can::ObjectAddress mapped = can::read_mapping_value(refusal.expected).object;
    text += fmt::format(" for {:04X}h:{}", mapped.index, mapped.sub);
  }
  if (refusal.found) {
    text += fmt::format(" is {} ({:X}h), not {} ({:X}h)", *refusal.found, *refusal.found, refusal.expected,
                        refusal.expected);
  }
  if (refusal.abort_code != 0) {
    text += fmt::format("; {:04X} {:04X}h: {}", refusal.abort_code >> 16, refusal.abort_code & 0xFFFF,
                        can::words_of_abort(refusal.abort_code));
  }
  return text;
}

std::vector<std::string> words_of_lacks(const can::SetupRunner& setup) {
  std::vector<std::string> words;
  for (const Lack& lack : lacks) {
    if (std::ranges::find(setup.absent(), lack.index) != setup.absent().end()) words.emplace_back(lack.words);
  }
  return words;
}

void refuse_overloaded_buses(const RigFile& rig) {
  for (const Bus& bus : rig.buses) {
    can::BusUse use{.bitrate = bus.bitrate, .rate_hz = rig.rate_hz, .drives = 0};
    std::int64_t guarded = 0;
    for (const RigAxis& axis : rig.axes) {
      const auto* const drive = std::get_if<Cia402Drive>(&axis.drive);
      if (drive == nullptr || drive->bus != bus.name) continue;
      ++use.drives;
      if (drive->is_guarded) ++guarded;
    }
    refuse_long_ticks(bus, use.drives, guarded);
    if (use.drives == 0 || can::check_bus_load(use)) continue;
    throw InputError(bus.place,
                     fmt::format("the {} on bus {} need {:.1f} % of its {} bit/s at {} Hz, and {} % "
                                 "may be used; lower rate_hz, or spread them over more buses ({} fit)",
                                 counted(use.drives, "drive"), in_quotes(bus.name),
                                 static_cast<double>(can::bus_load_per_mille(use)) / 10, use.bitrate,
                                 use.rate_hz, can::bus_load_limit_percent, can::max_drives(use)));
  }
}

// --- the drives

CanDrives::CanDrives(const RigFile& rig, std::span<const std::size_t> axes, RigHardware& hardware)
    : rig_(rig), axes_(axes.begin(), axes.end()) {
  for (const std::size_t a : axes_) {
    const RigAxis& axis = rig.axes[a];
    const auto& drive = std::get<Cia402Drive>(axis.drive);
    auto bus = std::ranges::find(buses_, drive.bus, &BusOfRig::name);
    if (bus == buses_.end()) {
      buses_.emplace_back().name = drive.bus;
      bus = buses_.end() - 1;
    }
    ports_.push_back(
        {static_cast<std::size_t>(bus - buses_.begin()), bus->hosts.size(), drive.counts_per_unit});
    bus->axes.push_back(a);
    bus->hosts.push_back(
        value_or_refuse(can::Cia402Drive::make(settings_of(axis, rig.rate_hz)), axis.place, named(axis)));
  }
  const RigAxis& first = rig.axes[axes_.front()];
  for (BusOfRig& bus : buses_) {
    bus.link = hardware.open_bus(bus.name, bus.axes);
    bus.bus = value_or_refuse(
        can::Cia402Bus::make(bus.hosts,
                             {.host = host_node(), .heartbeat_period_ns = heartbeat_period_ns(rig.rate_hz)}),
        first.place, named(first));
    bus.targets.resize(bus.hosts.size());
    bus.known.resize(bus.hosts.size());
    bus.frames.resize(can::frames_per_read(bus.hosts.size()));
    lanes_.push_back({&*bus.bus, bus.link.get(), bus.targets, bus.known, bus.frames});
  }
  port_ = value_or_refuse(can::Cia402Port<double, BusLink>::make(lanes_, ports_), first.place, named(first));
}

void CanDrives::place(std::size_t drive, double position) {
  if (!(std::fabs(position * ports_[drive].counts_per_unit) <= max_counts)) {
    const RigAxis& axis = rig_.axes[axes_[drive]];
    throw InputError(axis.place, fmt::format("{}: a position is more counts from 0 than a drive tells; "
                                             "put 0 nearer",
                                             named(axis)));
  }
  if (port_->drive(drive).phase() == can::DrivePhase::following) {
    port_->place(drive, position);
  } else {
    ports_[drive].stands_at = position;
  }
}

bool CanDrives::has_lost_position(std::size_t drive) const {
  return can::loses_reference(port_->drive(drive).findings());
}

void CanDrives::count(Counters& counts) const {
  for (std::size_t l = 0; l < lanes_.size(); ++l) {
    counts.buses.push_back({buses_[l].name, counts_of(port_->counters(l), buses_[l].link->counters())});
  }
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    counts.drives.push_back({rig_.axes[axes_[i]].name, counts_of(port_->drive(i).counters())});
  }
}

std::string CanDrives::bus_trouble() const {
  for (const BusOfRig& bus : buses_) {
    if (!bus.link->is_up()) {
      return fmt::format("bus {} is down or off; look at its cable, supply and termination",
                         in_quotes(bus.name));
    }
  }
  for (std::size_t l = 0; l < lanes_.size(); ++l) {
    if (!port_->is_unsent(l)) continue;
    return fmt::format(
        "bus {} does not take frames ({} lost); look whether its drives are on and its cable is "
        "plugged in",
        in_quotes(buses_[l].name), counted(port_->counters(l).unsent, "frame"));
  }
  return "";
}

std::string CanDrives::drive_trouble() const {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const can::Cia402Drive& drive = port_->drive(i);
    std::optional<can::DriveFinding> finding = drive.first_finding();
    if (!finding) continue;
    // A drive that starts anew is silent first; what it has lost by that is what must be known.
    constexpr can::DriveFinding boot = can::DriveFinding::unexpected_boot;
    if (drive.findings().has(boot)) finding = boot;
    const can::DriveFindingWords words = can::words_of(*finding);
    std::string text = fmt::format("{}: {}", named(rig_.axes[axes_[i]]), words.what);
    if (drive.last_emergency().code != 0) {
      text += fmt::format(" (EMCY {:04X}, {})", drive.last_emergency().code,
                          can::words_of_emergency(drive.last_emergency().code));
    }
    const bool is_of_setup = drive.setup().state() == can::SetupState::refused;
    if (is_of_setup && *finding == drive.refusal().finding) {
      text += fmt::format(" ({})", words_of(drive.refusal()));
    }
    return text + "; " + words.remedy;
  }
  return "";
}

std::vector<std::string> CanDrives::notes() const {
  std::vector<std::string> notes;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    for (const std::string& lack : words_of_lacks(port_->drive(i).setup())) {
      notes.push_back(fmt::format("note: {}: {}", named(rig_.axes[axes_[i]]), lack));
    }
  }
  return notes;
}

std::string CanDrives::left_on() const {
  std::string all;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const can::Cia402Drive& drive = port_->drive(i);
    if (drive.phase() == can::DrivePhase::off) continue;
    can::DriveFinding why = can::DriveFinding::not_switched_off;
    for (const can::DriveFinding end :
         {can::DriveFinding::moves_while_off, can::DriveFinding::watchdog_stays}) {
      if (drive.findings().has(end)) why = end;
    }
    const can::DriveFindingWords words = can::words_of(why);
    all += fmt::format("{}{}: {}; {}", all.empty() ? "" : ". And ", named(rig_.axes[axes_[i]]), words.what,
                       words.remedy);
  }
  return all;
}

}  // namespace inbetween
