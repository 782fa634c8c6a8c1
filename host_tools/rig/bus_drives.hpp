// The drives of one protocol on the buses of a rig.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "host_tools/rig/bus_kind.hpp"
#include "host_tools/rig/counters.hpp"
#include "host_tools/rig/rig_hardware.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "inbetween/can/bus_port.hpp"

namespace inbetween {

/// `Kind` is a protocol (bus_kind.hpp).
template <class Kind>
class BusDrives final
    : public PortDrives<can::BusPort<typename Kind::Bus, BusLink<typename Kind::Bus::Frame>>> {
 public:
  using Bus = typename Kind::Bus;
  using Drive = typename Bus::Drive;
  using Frame = typename Bus::Frame;
  using Port = can::BusPort<Bus, BusLink<Frame>>;

  /// `axes` of the rig have such drives; there is one at least. Throws InputError at the place of an axis
  /// that cannot be set up, and what RigHardware::open_bus throws.
  BusDrives(const RigFile& rig, std::span<const std::size_t> axes, RigHardware& hardware)
      : rig_(rig), axes_(axes.begin(), axes.end()) {
    for (const std::size_t a : axes_) add(a);
    const RigAxis& first = rig.axes[axes_.front()];
    for (BusOfRig& bus : buses_) {
      bus.link = hardware.open_bus<Frame>(bus.name, bus.axes);
      bus.bus.emplace(Kind::bus_of(bus.hosts, rig.rate_hz, first));
      bus.targets.resize(bus.hosts.size());
      bus.known.resize(bus.hosts.size());
      bus.frames.resize(can::frames_per_read(bus.hosts.size()));
      lanes_.push_back({&*bus.bus, bus.link.get(), bus.targets, bus.known, bus.frames});
    }
    port_ = value_or_refuse(Port::make(lanes_, ports_), first.place, named(first));
  }
  BusDrives(const BusDrives&) = delete;
  BusDrives& operator=(const BusDrives&) = delete;

  void place(std::size_t drive, double position) override {
    if (!(std::fabs(position * ports_[drive].scale) <= Kind::max_place)) {
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
  [[nodiscard]] std::optional<double> zero(std::size_t drive) const override {
    if (ports_[drive].stands_at) return {};
    return static_cast<double>(ports_[drive].zero) / ports_[drive].scale;
  }
  void set_zero(std::size_t drive, double zero) override {
    typename Port::Axis& of = ports_[drive];
    of.zero = Drive::place_of(zero * of.scale);
    if constexpr (requires(Drive & host) { Kind::count_from(host, rig_.axes[0], of.zero); }) {
      Kind::count_from(lanes_[of.lane].bus->drives()[of.drive], rig_.axes[axes_[drive]], of.zero);
    }
  }
  void stop_one(std::size_t drive, OwnStop how) override { port_->stop_one(drive, how); }
  [[nodiscard]] bool has_lost_position(std::size_t drive) const override {
    return port_->has_forgotten(drive);
  }
  [[nodiscard]] can::Cia402Homing* homing(std::size_t drive) const override {
    if constexpr (requires(Drive & host) { host.homing(); }) {
      const typename Port::Axis& of = ports_[drive];
      return lanes_[of.lane].bus->drives()[of.drive].homing();
    }
    return nullptr;
  }
  void count(Counters& counts) const override {
    for (std::size_t l = 0; l < lanes_.size(); ++l) {
      counts.buses.push_back({buses_[l].name, counts_of(port_->counters(l), buses_[l].link->counters())});
    }
    for (std::size_t i = 0; i < axes_.size(); ++i) {
      counts.drives.push_back({rig_.axes[axes_[i]].name, counts_of(port_->drive(i).counters())});
    }
  }

  [[nodiscard]] std::string bus_trouble() const override;
  [[nodiscard]] std::string drive_trouble() const override;
  [[nodiscard]] std::vector<std::string> notes() const override;
  [[nodiscard]] std::string left_on() const override;

 private:
  using PortDrives<Port>::port_;
  struct BusOfRig {
    std::string name;
    std::vector<std::size_t> axes;
    std::vector<Drive> hosts;
    std::optional<Bus> bus;
    std::unique_ptr<BusLink<Frame>> link;
    std::vector<typename Drive::Target> targets;
    std::vector<can::PortDrive> known;
    std::vector<Frame> frames;
  };
  void add(std::size_t a) {
    const RigAxis& axis = rig_.axes[a];
    const std::string& name = std::get<typename Kind::InRig>(axis.drive).bus;
    auto bus = std::ranges::find(buses_, name, &BusOfRig::name);
    if (bus == buses_.end()) {
      buses_.emplace_back().name = name;
      bus = buses_.end() - 1;
    }
    ports_.push_back({.lane = static_cast<std::size_t>(bus - buses_.begin()),
                      .drive = bus->hosts.size(),
                      .scale = Kind::scale_of(axis),
                      .watch = watch_of(axis)});
    bus->axes.push_back(a);
    bus->hosts.push_back(Kind::host_of(axis, rig_.rate_hz));
  }

  const RigFile& rig_;
  std::vector<std::size_t> axes_;
  std::deque<BusOfRig> buses_;
  std::vector<typename Port::Lane> lanes_;
  std::vector<typename Port::Axis> ports_;
};

template <class Kind>
std::string BusDrives<Kind>::bus_trouble() const {
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

template <class Kind>
std::string BusDrives<Kind>::drive_trouble() const {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const Drive& drive = port_->drive(i);
    std::optional<can::DriveFinding> finding = drive.first_finding();
    if (!finding) continue;
    // A drive that starts anew is silent first; what it has lost by that is what must be known. Where
    // somebody else was heard first, that is why.
    const bool is_by_another = finding == can::DriveFinding::foreign_sender;
    for (const can::DriveFinding boot :
         {can::DriveFinding::silent_for_a_while, can::DriveFinding::unexpected_boot}) {
      if (drive.findings().has(boot) && !is_by_another) finding = boot;
    }
    const can::DriveFindingWords words = can::words_of(*finding);
    const bool has_lost = is_by_another && can::loses_reference(drive.findings());
    const bool was_cut = port_->own_stop(i) == OwnStop::cut;
    return fmt::format("{}: {}{}{}{}; {}{}", named(rig_.axes[axes_[i]]), words.what,
                       Kind::detail_of(drive, *finding),
                       was_cut ? ", and went on when its drive was to stop it: its power was cut" : "",
                       has_lost ? ", and the drive has started anew by it" : "", words.remedy,
                       has_lost ? ", then find its reference again" : "");
  }
  return "";
}

template <class Kind>
std::vector<std::string> BusDrives<Kind>::notes() const {
  std::vector<std::string> notes;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    for (const std::string& lack : Kind::lacks_of(port_->drive(i))) {
      notes.push_back(fmt::format("note: {}: {}", named(rig_.axes[axes_[i]]), lack));
    }
  }
  return notes;
}

template <class Kind>
std::string BusDrives<Kind>::left_on() const {
  std::string all;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const Drive& drive = port_->drive(i);
    const RigAxis& axis = rig_.axes[axes_[i]];
    if (const auto speed = port_->speed_without_power(i)) {
      all += fmt::format(
          "{}{} still moved at {:.3g} {}/s when its power went; see that it has come to rest "
          "before anybody goes near it",
          all.empty() ? "" : ". And ", named(axis), *speed, to_string(axis.unit));
    }
    if (drive.phase() == can::DrivePhase::off) continue;
    can::DriveFinding why = can::DriveFinding::not_switched_off;
    for (const can::DriveFinding end :
         {can::DriveFinding::moves_while_off, can::DriveFinding::watchdog_stays}) {
      if (drive.findings().has(end)) why = end;
    }
    const can::DriveFindingWords words = can::words_of(why);
    all += fmt::format("{}{}: {}; {}", all.empty() ? "" : ". And ", named(axis), words.what, words.remedy);
  }
  return all;
}

}  // namespace inbetween
