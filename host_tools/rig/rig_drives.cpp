#include "host_tools/rig/rig_drives.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "host_tools/files/diagnostics.hpp"
#include "inbetween/can/bus_load.hpp"
#include "inbetween/can/canopen_id.hpp"
#include "inbetween/loop/tick_time.hpp"

namespace inbetween {
namespace {

/// The host's node number; no axis may have it.
constexpr std::int64_t host_node = 127;
/// By which a setpoint may be further from the last than max_velocity allows: rounding to counts, and the
/// rates above the drawn one that are certified within it.
constexpr double step_share = 1.2;
/// The host's heartbeat, and how many of them a drive waits for.
constexpr std::int64_t heartbeat_ns = 30'000'000;
constexpr std::int64_t heartbeats_waited_for = 4;
constexpr std::int64_t ns_per_ms = 1'000'000;
/// How long a drive waits for a setpoint: in ticks, of which one may be late, and at least. Meanwhile it
/// holds the last one, which stops the axis as hard as its motor can; then it brakes by its own ramp.
constexpr std::int64_t setpoints_waited_for = 4;
constexpr std::int64_t min_setpoint_wait_ms = 20;

/// Counts that a double has every one of.
constexpr double max_counts = 9'007'199'254'740'992;

const Cia402Drive* cia402_of(const RigAxis& axis) {
  return std::get_if<Cia402Drive>(&axis.drive);
}

std::int64_t tick_ns(std::int32_t rate_hz) {
  return ns_per_s / rate_hz;
}
std::int64_t heartbeat_period_ns(std::int32_t rate_hz) {
  return std::max(heartbeat_ns, tick_ns(rate_hz));
}

template <class T>
const T& value_or_refuse(const Result<T>& result, const RigAxis& axis) {
  if (result) return *result;
  throw InputError(axis.place, fmt::format("axis {}: {}; {}", in_quotes(axis.name), result.error().what,
                                           result.error().remedy));
}

std::vector<can::CanFilter> filters_of(const std::vector<can::Cia402Drive>& drives) {
  const can::NodeId host = *can::NodeId::make(host_node);
  std::vector<can::CanFilter> filters{
      {can::nmt_id, false}, {can::sync_id, false}, {can::heartbeat_id(host), false}};
  for (const can::Cia402Drive& drive : drives) {
    const can::NodeId node = drive.node();
    for (const std::uint32_t id :
         {can::tpdo1_id(node), can::rpdo1_id(node), can::heartbeat_id(node), can::emergency_id(node),
          can::sdo_answer_id(node), can::sdo_request_id(node)}) {
      filters.push_back({id, false});
    }
  }
  return filters;
}

}  // namespace

// --- a link

void HostLink::look_at_socket() {
  if (socket_->link() != can::LinkState::up || socket_->controller() == can::ControllerState::bus_off) {
    is_up_ = false;
  }
}

std::size_t HostLink::receive(std::span<can::Frame> in, std::int64_t now_ns) {
  if (simulated_) return simulated_->receive(in, now_ns);
  const std::size_t count = socket_->receive(in);
  look_at_socket();
  return count;
}

std::size_t HostLink::send(std::span<const can::Frame> out) {
  if (simulated_) return simulated_->send(out);
  if (!is_up_) return 0;
  const std::size_t count = socket_->send(out);
  look_at_socket();
  return count;
}

std::size_t HostLink::drain() {
  return simulated_ ? simulated_->drain() : socket_->drain().stale;
}

// --- what a rig file says

can::Cia402Settings settings_of(const RigAxis& axis, std::int32_t rate_hz) {
  const Cia402Drive& drive = std::get<Cia402Drive>(axis.drive);
  const double scale = drive.counts_per_unit;
  const double ends[] = {axis.min * scale, axis.max * scale};
  const std::int64_t timeout_ms = heartbeats_waited_for * heartbeat_period_ns(rate_hz) / ns_per_ms;
  const std::int64_t setpoint_ms =
      std::max(min_setpoint_wait_ms, setpoints_waited_for * tick_ns(rate_hz) / ns_per_ms);
  can::Cia402Settings settings{
      .setup = {
          .node = value_or_refuse(can::NodeId::make(drive.node), axis),
          .host = *can::NodeId::make(host_node),
          .rate_hz = rate_hz,
          .host_timeout_ms = static_cast<std::uint16_t>(std::min<std::int64_t>(timeout_ms, 65'535)),
          .setpoint_timeout_ms = static_cast<std::uint16_t>(std::min<std::int64_t>(setpoint_ms, 65'535)),
          .position_limits =
              can::CountRange{.min = static_cast<std::int32_t>(std::floor(std::min(ends[0], ends[1]))),
                              .max = static_cast<std::int32_t>(std::ceil(std::max(ends[0], ends[1])))},
          .quick_stop_deceleration = drive.stop_deceleration,
          .coasts = axis.coasts,
          .stops_without_host = axis.stops_without_host}};
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

SimulatedCia402Settings simulated_settings_of(const RigAxis& axis, double position) {
  const Cia402Drive& drive = std::get<Cia402Drive>(axis.drive);
  SimulatedCia402Settings settings{
      .node = value_or_refuse(can::NodeId::make(drive.node), axis),
      .position = static_cast<std::int32_t>(std::floor(position * drive.counts_per_unit + 0.5))};
  settings.motor.max_acceleration =
      std::max(settings.motor.max_acceleration, 4 * std::fabs(drive.counts_per_unit) * axis.max_acceleration);
  return settings;
}

void refuse_falling_axes(const RigFile& rig) {
  for (const RigAxis& axis : rig.axes) {
    if (!axis.unpowered) {
      throw InputError(
          axis.place,
          fmt::format("axis {} does not say what it does without power; write unpowered = \"holds\" if "
                      "it keeps its place (a brake, a self-locking gear, a balanced load), otherwise "
                      "unpowered = \"falls\"",
                      in_quotes(axis.name)));
    }
    if (axis.unpowered->holds) continue;
    throw InputError(
        axis.unpowered->place,
        fmt::format("axis {} falls without power, so no drive is switched on; fit a brake on the brake "
                    "output of its drive, a self-locking gear or a counterweight, then write unpowered = "
                    "\"holds\"",
                    in_quotes(axis.name)));
  }
}

std::string words_of(const can::SetupRefusal& refusal) {
  std::string text = fmt::format("object {:04X}h:{}", refusal.object.index, refusal.object.sub);
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

void refuse_overloaded_buses(const RigFile& rig) {
  for (const Bus& bus : rig.buses) {
    can::BusUse use{.bitrate = bus.bitrate, .rate_hz = rig.rate_hz, .drives = 0};
    for (const RigAxis& axis : rig.axes) {
      if (cia402_of(axis) != nullptr && cia402_of(axis)->bus == bus.name) ++use.drives;
    }
    if (use.drives == 0 || can::check_bus_load(use)) continue;
    throw InputError(
        bus.place,
        fmt::format("the {} drives on bus {} need {:.1f} % of its {} bit/s at {} Hz, and {} % "
                    "may be used; lower rate_hz, or spread them over more buses ({} fit)",
                    use.drives, in_quotes(bus.name), static_cast<double>(can::bus_load_per_mille(use)) / 10,
                    use.bitrate, use.rate_hz, can::bus_load_limit_percent, can::max_drives(use)));
  }
}

// --- the drives

RigDrives::BusOfRig& RigDrives::bus_named(const std::string& name) {
  const auto found = std::ranges::find(buses_, name, &BusOfRig::name);
  if (found != buses_.end()) return *found;
  buses_.emplace_back();
  buses_.back().name = name;
  return buses_.back();
}

void RigDrives::make_buses() {
  refuse_overloaded_buses(rig_);
  for (std::size_t a = 0; a < rig_.axes.size(); ++a) {
    const RigAxis& axis = rig_.axes[a];
    const Cia402Drive* const drive = cia402_of(axis);
    if (drive == nullptr) {
      if (!std::holds_alternative<StepDirDrive>(axis.drive)) are_ideal_.axes.push_back(a);
      continue;
    }
    BusOfRig& bus = bus_named(drive->bus);
    const auto lane =
        static_cast<std::size_t>(std::ranges::find(buses_, drive->bus, &BusOfRig::name) - buses_.begin());
    on_can_.axes.push_back(a);
    can_axes_.push_back({lane, bus.hosts.size(), drive->counts_per_unit});
    bus.hosts.push_back(value_or_refuse(can::Cia402Drive::make(settings_of(axis, rig_.rate_hz)), axis));
  }
}

void RigDrives::make_port() {
  for (BusOfRig& bus : buses_) {
    const RigAxis& first = rig_.axes[on_can_.axes.front()];
    bus.bus = value_or_refuse(
        can::Cia402Bus::make(bus.hosts, {.host = *can::NodeId::make(host_node),
                                         .heartbeat_period_ns = heartbeat_period_ns(rig_.rate_hz)}),
        first);
    bus.targets.resize(bus.hosts.size());
    bus.known.resize(bus.hosts.size());
    bus.frames.resize(can::frames_per_read(bus.hosts.size()));
    lanes_.push_back({&*bus.bus, &*bus.link, bus.targets, bus.known, bus.frames});
  }
  if (steps_) on_steps_.axes.assign(steps_->indices().begin(), steps_->indices().end());
  on_can_.make_room();
  on_steps_.make_room();
  are_ideal_.make_room();
  if (on_can_.axes.empty()) return;
  port_ = value_or_refuse(can::Cia402Port<double, HostLink>::make(lanes_, can_axes_),
                          rig_.axes[on_can_.axes.front()]);
}

std::unique_ptr<RigDrives> RigDrives::simulated(const RigFile& rig, const std::vector<double>& positions) {
  std::unique_ptr<RigDrives> drives(new RigDrives(rig));
  drives->make_buses();
  for (std::size_t i = 0; i < drives->on_can_.axes.size(); ++i) {
    const std::size_t a = drives->on_can_.axes[i];
    const can::Cia402Axis<double>& axis = drives->can_axes_[i];
    BusOfRig& bus = drives->buses_[axis.lane];
    bus.drives.emplace_back(simulated_settings_of(rig.axes[a], positions[a]), 0);
    bus.wire.attach(bus.drives.back());
  }
  for (BusOfRig& bus : drives->buses_) bus.link.emplace(bus.wire);
  std::vector<double> ideal;
  for (const std::size_t a : drives->are_ideal_.axes) ideal.push_back(positions[a]);
  drives->ideal_.emplace(ideal);
  drives->steps_ = StepDrives::simulated(rig, positions);
  drives->make_port();
  return drives;
}

std::unique_ptr<RigDrives> RigDrives::on_rig(const RigFile& rig, bool in_real_time) {
  std::unique_ptr<RigDrives> drives(new RigDrives(rig));
  drives->make_buses();
  if (!drives->are_ideal_.axes.empty()) {
    const RigAxis& axis = rig.axes[drives->are_ideal_.axes.front()];
    throw InputError(axis.place,
                     fmt::format("axis {}: this version moves CiA 402 and step-dir drives; simulate the rig "
                                 "with --sim",
                                 in_quotes(axis.name)));
  }
  for (BusOfRig& bus : drives->buses_) {
    auto socket = std::make_unique<can::SocketCan>();
    std::optional<Refusal> refusal = bus.lock.take("bus " + bus.name);
    if (!refusal) refusal = socket->open(bus.name, filters_of(bus.hosts));
    if (refusal) {
      const auto place = std::ranges::find(rig.buses, bus.name, &Bus::name);
      throw InputError(place != rig.buses.end() ? place->place : Place{rig.path, 0, 0},
                       refusal->what + "; " + refusal->remedy);
    }
    bus.link.emplace(std::move(socket));
  }
  drives->steps_ = StepDrives::on_chips(rig, in_real_time);
  drives->make_port();
  return drives;
}

void RigDrives::set_faults(const FaultScript& faults) {
  faults_.emplace(faults, 0);
  for (std::size_t i = 0; i < on_can_.axes.size(); ++i) {
    faults_->attach(on_can_.axes[i], buses_[can_axes_[i].lane].drives[can_axes_[i].drive]);
  }
}

void RigDrives::read(std::span<DriveState<double>> states, std::int64_t now_ns) {
  if (faults_) faults_->advance(now_ns);
  if (port_) on_can_.read(*port_, states, now_ns);
  if (steps_) on_steps_.read(*steps_, states, now_ns);
  if (ideal_) are_ideal_.read(*ideal_, states, now_ns);
}

void RigDrives::write(std::span<const Setpoint<double>> setpoints, std::int64_t now_ns) {
  if (port_) on_can_.write(*port_, setpoints, now_ns);
  if (steps_) on_steps_.write(*steps_, setpoints, now_ns);
  if (ideal_) are_ideal_.write(*ideal_, setpoints, now_ns);
}

void RigDrives::enable() {
  if (port_) port_->enable();
  if (steps_) steps_->enable();
  if (ideal_) ideal_->enable();
}

void RigDrives::disable() {
  if (port_) port_->disable();
  if (steps_) steps_->disable();
  if (ideal_) ideal_->disable();
}

void RigDrives::quick_stop() {
  if (port_) port_->quick_stop();
  if (steps_) steps_->quick_stop();
  if (ideal_) ideal_->quick_stop();
}

void RigDrives::place(std::size_t axis, double position) {
  if (const auto i = on_can_.find(axis)) {
    const RigAxis& of = rig_.axes[axis];
    if (!(std::fabs(position * can_axes_[*i].counts_per_unit) <= max_counts)) {
      throw InputError(of.place, fmt::format("axis {}: a position is more counts from 0 than a drive tells; "
                                             "put 0 nearer",
                                             in_quotes(of.name)));
    }
    if (port_->drive(*i).phase() == can::DrivePhase::following) {
      port_->place(*i, position);
    } else {
      can_axes_[*i].stands_at = position;
    }
  } else if (const auto step = on_steps_.find(axis)) {
    steps_->place(*step, position);
  } else {
    ideal_->place(are_ideal_.find(axis).value(), position);
  }
}

bool RigDrives::has_lost_position(std::size_t axis) const {
  if (const auto i = on_can_.find(axis)) {
    return port_->drive(*i).findings().has(can::DriveFinding::unexpected_boot);
  }
  const auto i = on_steps_.find(axis);
  return i && steps_->has_lost_steps(*i);
}

double RigDrives::true_position(std::size_t axis) const {
  if (const auto i = on_can_.find(axis)) {
    const can::Cia402Axis<double>& of = can_axes_[*i];
    return buses_[of.lane].drives[of.drive].position() / of.counts_per_unit;
  }
  if (const auto i = on_steps_.find(axis)) return steps_->shaft(*i);
  return ideal_->axes()[are_ideal_.find(axis).value()].actual();
}

Counters RigDrives::counts() const {
  Counters counts;
  for (std::size_t l = 0; l < lanes_.size(); ++l) {
    counts.buses.push_back({buses_[l].name, counts_of(port_->counters(l), buses_[l].link->counters())});
  }
  for (std::size_t i = 0; i < on_can_.axes.size(); ++i) {
    counts.drives.push_back({rig_.axes[on_can_.axes[i]].name, counts_of(port_->drive(i).counters())});
  }
  if (steps_) counts.chips = steps_->counts();
  return counts;
}

std::string RigDrives::trouble() const {
  for (const BusOfRig& bus : buses_) {
    if (!bus.link->is_up()) {
      return fmt::format("bus {} is down or off; look at its cable, supply and termination",
                         in_quotes(bus.name));
    }
  }
  for (std::size_t l = 0; l < lanes_.size(); ++l) {
    if (!port_->is_unsent(l)) continue;
    return fmt::format("bus {} does not take frames ({} lost); are its drives on and its cable plugged in?",
                       in_quotes(buses_[l].name), port_->counters(l).unsent);
  }
  if (steps_ && !steps_->trouble().empty()) return steps_->trouble();
  for (std::size_t i = 0; i < on_can_.axes.size(); ++i) {
    const can::Cia402Drive& drive = port_->drive(i);
    std::optional<can::DriveFinding> finding = drive.first_finding();
    if (!finding) continue;
    // A drive that starts anew is silent first; what it has lost by that is what must be known.
    constexpr can::DriveFinding boot = can::DriveFinding::unexpected_boot;
    if (drive.findings().has(boot)) finding = boot;
    const can::DriveFindingWords words = can::words_of(*finding);
    std::string text = fmt::format("axis {}: {}", in_quotes(rig_.axes[on_can_.axes[i]].name), words.what);
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

std::string RigDrives::left_on() const {
  std::string all;
  for (std::size_t i = 0; i < on_can_.axes.size(); ++i) {
    const can::Cia402Drive& drive = port_->drive(i);
    if (drive.phase() == can::DrivePhase::off) continue;
    can::DriveFinding why = can::DriveFinding::not_switched_off;
    for (const can::DriveFinding end :
         {can::DriveFinding::moves_while_off, can::DriveFinding::watchdog_stays}) {
      if (drive.findings().has(end)) why = end;
    }
    const can::DriveFindingWords words = can::words_of(why);
    all += fmt::format("{}axis {}: {}; {}", all.empty() ? "" : ". And ",
                       in_quotes(rig_.axes[on_can_.axes[i]].name), words.what, words.remedy);
  }
  return all;
}

}  // namespace inbetween
