#include "host_tools/motions/sim_drives.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <iterator>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "drivers/can/socket_can.hpp"
#include "drivers/linux/monotonic_clock.hpp"
#include "host_tools/files/diagnostics.hpp"
#include "host_tools/rig/bus_kind.hpp"
#include "host_tools/rig/fault_schedule.hpp"
#include "host_tools/rig/machine_hardware.hpp"
#include "sim/simulated_can_drive.hpp"

namespace inbetween {
namespace {

constexpr std::int64_t ns_between_looks = 1'000'000;

struct DriveOnBus {
  std::string axis;
  std::unique_ptr<SimulatedCanDrive> drive;
};

struct BusOfDrives {
  std::string name;
  can::SocketCan socket;
  std::vector<DriveOnBus> drives;
  std::vector<can::CanFilter> heard;
};

/// The drives hear what has come and answer.
void serve(BusOfDrives& bus, std::int64_t now_ns) {
  std::array<can::Frame, can::SocketCan::max_frames> frames;
  const std::size_t count = bus.socket.receive(frames);
  std::vector<can::Frame> answers;
  for (DriveOnBus& one : bus.drives) {
    one.drive->advance(now_ns);
    for (std::size_t i = 0; i < count; ++i) one.drive->receive(frames[i]);
    for (const can::Frame& frame : one.drive->take_frames()) answers.push_back(frame);
  }
  std::span<const can::Frame> left = answers;
  while (!left.empty()) {
    const auto part = left.first(std::min(left.size(), can::SocketCan::max_frames));
    bus.socket.send(part);
    left = left.subspan(part.size());
  }
}

/// Those since the last call: in memory they would grow as long as the rig moves.
void write_record(std::deque<BusOfDrives>& buses, std::FILE* file) {
  for (BusOfDrives& bus : buses) {
    for (DriveOnBus& one : bus.drives) {
      const DriveRecord record = one.drive->take_record();
      for (const DriveRecord::Applied& applied : record.applied) {
        fmt::print(file, "{},{},{}\n", one.axis, applied.at_ns, applied.target);
      }
      for (const DriveRecord::Entered& entered : record.entered) {
        fmt::print(file, "{},state,{},{},{:.3f}\n", one.axis, entered.at_ns, entered.state, entered.velocity);
      }
      for (const DriveRecord::Reported& reported : record.reported) {
        fmt::print(file, "{},emergency,{},{:04X}\n", one.axis, reported.at_ns, reported.code);
      }
    }
  }
}

void write_end(const std::deque<BusOfDrives>& buses, const FaultSchedule& faults, const RigFile& rig,
               std::FILE* file) {
  for (const FaultSchedule::Begun& fault : faults.begun()) {
    fmt::print(file, "{},fault,{},{}\n", rig.axes[fault.axis].name, fault.at_ns, fault.what);
  }
  for (const BusOfDrives& bus : buses) {
    for (const DriveOnBus& one : bus.drives) {
      fmt::print(file, "{},end,{},{:.6f},{:.6f},{}\n", one.axis, one.drive->state_name(),
                 one.drive->position(), one.drive->velocity(),
                 one.drive->misses_something() ? "misses something" : "misses nothing");
    }
  }
}

}  // namespace

void run_sim_drives(const RigFile& rig, const SimDrivesOptions& options) {
  const MonotonicClock clock;
  std::map<std::string, double> standing = options.standing;
  std::deque<BusOfDrives> buses;
  FaultSchedule faults(options.faults, clock.now_ns());
  for (std::size_t a = 0; a < rig.axes.size(); ++a) {
    const RigAxis& axis = rig.axes[a];
    if (std::holds_alternative<StepDirDrive>(axis.drive)) continue;
    double position = std::clamp(0.0, axis.min, axis.max);
    bool is_on_bus = false;
    with_kind_of(axis, [&]<class Kind>() {
      is_on_bus = true;
      const std::string& name = std::get<typename Kind::InRig>(axis.drive).bus;
      auto bus = std::ranges::find(buses, name, &BusOfDrives::name);
      if (bus == buses.end()) {
        buses.emplace_back().name = name;
        bus = buses.end() - 1;
      }
      if (const auto said = standing.extract(axis.name)) position = said.mapped();
      bus->drives.push_back({axis.name, Kind::simulate(axis, {.position = position,
                                                              .now_ns = clock.now_ns(),
                                                              .keeps_record = options.record != nullptr})});
      std::ranges::copy(Kind::heard_by_drive(axis), std::back_inserter(bus->heard));
      faults.attach(a, *bus->drives.back().drive);
    });
    if (is_on_bus) continue;
    throw InputError(axis.place,
                     fmt::format("axis {} has no drive on a CAN bus; this version simulates those "
                                 "only on a bus",
                                 in_quotes(axis.name)));
  }
  if (buses.empty()) {
    throw InputError({rig.path, 0, 0},
                     fmt::format("the rig {} has no drive on a bus; simulate it with inbetween run --sim",
                                 in_quotes(rig.name)));
  }
  if (!standing.empty()) {
    throw InputError({rig.path, 0, 0},
                     fmt::format("the rig {} has no axis {} on a bus; name one of its axes there",
                                 in_quotes(rig.name), in_quotes(standing.begin()->first)));
  }
  for (BusOfDrives& bus : buses) {
    open_bus_of(rig, bus.name, bus.heard, bus.socket);
  }
  if (options.ready) options.ready();
  while (!options.interrupted()) {
    clock.sleep_until_ns(clock.now_ns() + ns_between_looks);
    faults.advance(clock.now_ns());
    for (BusOfDrives& bus : buses) serve(bus, clock.now_ns());
    if (options.record != nullptr) write_record(buses, options.record);
  }
  if (options.record != nullptr) write_end(buses, faults, rig, options.record);
}

}  // namespace inbetween
