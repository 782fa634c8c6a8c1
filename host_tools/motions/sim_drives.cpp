#include "host_tools/motions/sim_drives.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <deque>
#include <iterator>
#include <memory>
#include <span>
#include <tuple>
#include <vector>

#include "drivers/can/socket_can.hpp"
#include "drivers/linux/monotonic_clock.hpp"
#include "host_tools/rig/bus_kind.hpp"
#include "host_tools/rig/fault_schedule.hpp"
#include "host_tools/rig/machine_hardware.hpp"
#include "host_tools/rig_model/rig_motors.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "sim/simulated_can_drive.hpp"

namespace inbetween {
namespace {

constexpr std::int64_t ns_between_looks = 1'000'000;

template <class Frame>
struct BusOfDrives {
  struct DriveOnBus {
    std::string axis;
    std::unique_ptr<SimulatedDriveOn<Frame>> drive;
  };
  std::string name;
  can::CanSocket<Frame> socket;
  std::vector<DriveOnBus> drives;
  std::vector<can::CanFilter> heard;
};

/// A bus carries one kind of frames (rig_file.hpp).
class BusesOfDrives {
 public:
  template <class Frame>
  BusOfDrives<Frame>& at(const std::string& name) {
    auto& buses = std::get<std::deque<BusOfDrives<Frame>>>(buses_);
    const auto known = std::ranges::find(buses, name, &BusOfDrives<Frame>::name);
    if (known != buses.end()) return *known;
    buses.emplace_back().name = name;
    return buses.back();
  }
  template <class Use>
  void for_each(Use&& use) {
    for (auto& bus : std::get<0>(buses_)) use(bus);
    for (auto& bus : std::get<1>(buses_)) use(bus);
  }
  template <class Use>
  void for_each_drive(Use&& use) {
    for_each([&](auto& bus) {
      for (auto& one : bus.drives) use(one.axis, *one.drive);
    });
  }
  [[nodiscard]] bool empty() const { return std::get<0>(buses_).empty() && std::get<1>(buses_).empty(); }

 private:
  std::tuple<std::deque<BusOfDrives<can::Frame>>, std::deque<BusOfDrives<can::FdFrame>>> buses_;
};

/// The drives hear what has come and answer.
template <class Frame>
void serve(BusOfDrives<Frame>& bus, std::int64_t now_ns) {
  std::array<Frame, can::SocketCan::max_frames> frames;
  const std::size_t count = bus.socket.receive(frames);
  std::vector<Frame> answers;
  for (auto& one : bus.drives) {
    one.drive->advance(now_ns);
    for (std::size_t i = 0; i < count; ++i) one.drive->receive(frames[i]);
    for (const Frame& frame : one.drive->take_frames()) answers.push_back(frame);
  }
  std::span<const Frame> left = answers;
  while (!left.empty()) {
    const auto part = left.first(std::min(left.size(), can::SocketCan::max_frames));
    bus.socket.send(part);
    left = left.subspan(part.size());
  }
}

/// Those since the last call: in memory they would grow as long as the rig moves.
void write_record(BusesOfDrives& buses, std::FILE* file) {
  buses.for_each_drive([&](const std::string& axis, SimulatedDrive& drive) {
    const DriveRecord record = drive.take_record();
    for (const DriveRecord::Applied& applied : record.applied) {
      fmt::print(file, "{},{},{}\n", axis, applied.at_ns, applied.target);
    }
    for (const DriveRecord::Entered& entered : record.entered) {
      fmt::print(file, "{},state,{},{},{:.3f}\n", axis, entered.at_ns, entered.state, entered.velocity);
    }
    for (const DriveRecord::Reported& reported : record.reported) {
      fmt::print(file, "{},emergency,{},{:04X}\n", axis, reported.at_ns, reported.code);
    }
  });
}

void write_end(BusesOfDrives& buses, const FaultSchedule& faults, const RigFile& rig, std::FILE* file) {
  for (const FaultSchedule::Begun& fault : faults.begun()) {
    fmt::print(file, "{},fault,{},{}\n", rig.axes[fault.axis].name, fault.at_ns, fault.what);
  }
  buses.for_each_drive([&](const std::string& axis, const SimulatedDrive& drive) {
    fmt::print(file, "{},end,{},{:.6f},{:.6f},{}\n", axis, drive.state_name(), drive.position(),
               drive.velocity(), drive.misses_something() ? "misses something" : "misses nothing");
  });
}

}  // namespace

void run_sim_drives(const RigFile& of, const SimDrivesOptions& options) {
  const RigMotors motors = motors_of(of);
  const RigFile& rig = motors.rig;
  const MonotonicClock clock;
  std::map<std::string, double> standing = options.standing;
  BusesOfDrives buses;
  FaultSchedule faults(options.faults, clock.now_ns());
  for (std::size_t a = 0; a < rig.axes.size(); ++a) {
    const RigAxis& axis = rig.axes[a];
    if (std::holds_alternative<StepDirDrive>(axis.drive)) continue;
    const RigAxis& whole = of.axes[motors.of[a].axis];
    double position = std::clamp(0.0, whole.min, whole.max);
    bool is_on_bus = false;
    with_kind_of(axis, [&]<class Kind>() {
      is_on_bus = true;
      auto& bus = buses.at<typename Kind::Bus::Frame>(std::get<typename Kind::InRig>(axis.drive).bus);
      if (const auto said = options.standing.find(whole.name); said != options.standing.end()) {
        position = said->second;
        standing.erase(whole.name);
      }
      bus.drives.push_back(
          {axis.name, Kind::simulate(axis, {.position = motor_position(whole, motors.of[a], position),
                                            .now_ns = clock.now_ns(),
                                            .keeps_record = options.record != nullptr})});
      std::ranges::copy(Kind::heard_by_drive(axis), std::back_inserter(bus.heard));
      faults.attach(a, *bus.drives.back().drive);
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
  buses.for_each([&](auto& bus) { open_bus_of(rig, bus.name, bus.heard, bus.socket); });
  if (options.ready) options.ready();
  std::int64_t now_ns = clock.now_ns();
  while (!options.interrupted()) {
    clock.sleep_until_ns(now_ns + ns_between_looks);
    now_ns = clock.now_ns();
    faults.advance(now_ns);
    buses.for_each([&](auto& bus) { serve(bus, now_ns); });
    if (options.record != nullptr) write_record(buses, options.record);
  }
  if (options.record != nullptr) write_end(buses, faults, rig, options.record);
}

}  // namespace inbetween
