// The drives of a rig file under the motion loop: on its buses, or simulated.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "drivers/can/socket_can.hpp"
#include "drivers/linux/instance_lock.hpp"
#include "host_tools/files/fault_script.hpp"
#include "host_tools/files/rig_file.hpp"
#include "host_tools/rig/counters.hpp"
#include "host_tools/rig/fault_schedule.hpp"
#include "host_tools/rig/step_drives.hpp"
#include "inbetween/can/cia402_port.hpp"
#include "inbetween/loop/motion_loop.hpp"
#include "sim/can_bus.hpp"
#include "sim/cia402_drive.hpp"
#include "sim/simulated_link.hpp"
#include "sim/simulated_rig.hpp"

namespace inbetween {

/// A bus of the machine, or one in this process (can::FrameLink).
class HostLink {
 public:
  explicit HostLink(SimulatedCanBus& bus) : simulated_(bus) {}
  explicit HostLink(std::unique_ptr<can::SocketCan> socket) : socket_(std::move(socket)) {}

  /// Once a link has gone or the controller was bus-off it stays down: nothing resumes by itself.
  [[nodiscard]] bool is_up() const { return is_up_; }
  std::size_t receive(std::span<can::Frame> in, std::int64_t now_ns);
  std::size_t send(std::span<const can::Frame> out);
  std::size_t drain();
  /// Null for a bus in this process.
  [[nodiscard]] const can::CanCounters* counters() const { return socket_ ? &socket_->counters() : nullptr; }

 private:
  void look_at_socket();

  // One of them.
  std::optional<SimulatedLink> simulated_;
  std::unique_ptr<can::SocketCan> socket_;
  bool is_up_ = true;
};

/// The settings that a CiA 402 axis of a rig gets.
can::Cia402Settings settings_of(const RigAxis& axis, std::int32_t rate_hz);
/// A simulated drive for it that stands at `position`, with a motor that was chosen for its axis.
SimulatedCia402Settings simulated_settings_of(const RigAxis& axis, double position);
/// Throws InputError at the place of an axis that falls without power, or does not say what it does then. Not
/// for a simulated rig, which nothing pulls down.
void refuse_falling_axes(const RigFile& rig);
/// Why a drive could not be set up: the object, what it has, and the words of the drive.
std::string words_of(const can::SetupRefusal& refusal);
/// Throws InputError at the place of a bus whose load would be above bus_load_limit_percent, or of an axis
/// that cannot be set up.
void refuse_overloaded_buses(const RigFile& rig);

/// A DrivePort for every axis of a rig. In simulation CiA 402 axes are drives that speak their frames,
/// step-dir axes motors that turn by the edges on their lines, the others ideal ones.
class RigDrives {
 public:
  /// Standing at `positions`, in the order of the rig's axes.
  static std::unique_ptr<RigDrives> simulated(const RigFile& rig, const std::vector<double>& positions);
  /// Opens the buses and chips; what plays steps is in real time if asked for. Throws InputError at the place
  /// of what is not there, or of a drive that this program cannot move.
  static std::unique_ptr<RigDrives> on_rig(const RigFile& rig, bool in_real_time = true);
  RigDrives(const RigDrives&) = delete;
  RigDrives& operator=(const RigDrives&) = delete;

  /// In simulation: what goes wrong with them, from power-on on. Of the same rig.
  void set_faults(const FaultScript& faults);

  void read(std::span<DriveState<double>> states, std::int64_t now_ns);
  void write(std::span<const Setpoint<double>> setpoints, std::int64_t now_ns);
  void enable();
  void disable();
  void quick_stop();

  /// Axis `axis` of the rig stands at `position`, whatever its drive says. Only before the drives are
  /// switched on, or while nothing is sent to them. Throws InputError at an axis whose drive cannot count so
  /// far.
  void place(std::size_t axis, double position);
  /// Steps were lost, so that nobody knows where the axis is.
  [[nodiscard]] bool has_lost_position(std::size_t axis) const;
  /// In simulation: where the axis really is, whatever its drive was told by place().
  [[nodiscard]] double true_position(std::size_t axis) const;
  /// Null where the rig has no stepper.
  [[nodiscard]] const StepDrives* steps() const { return steps_.get(); }

  /// What is wrong with a drive and what to do, the first found; "" for nothing. Not for the loop's thread.
  [[nodiscard]] std::string trouble() const;
  /// Once disable() was over: which drive may have power, or will report that this program is gone, and what
  /// to do; "" for none.
  [[nodiscard]] std::string left_on() const;
  /// Of the buses, the drives on them and the chips that steps go to. Once no tick follows.
  [[nodiscard]] Counters counts() const;

 private:
  struct BusOfRig {
    std::string name;
    std::vector<can::Cia402Drive> hosts;
    std::optional<can::Cia402Bus> bus;
    std::optional<HostLink> link;
    std::vector<std::int32_t> targets;
    std::vector<can::PortDrive> known;
    std::vector<can::Frame> frames;
    InstanceLock lock;
    // in simulation
    std::deque<SimulatedCia402Drive> drives;
    SimulatedCanBus wire;
  };

  /// Some axes of the rig, and what passes between them and their drives.
  struct Part {
    std::vector<std::size_t> axes;
    std::vector<DriveState<double>> states;
    std::vector<Setpoint<double>> setpoints;

    /// Where the axis of the rig is among these.
    [[nodiscard]] std::optional<std::size_t> find(std::size_t axis) const {
      const auto found = std::ranges::find(axes, axis);
      if (found == axes.end()) return std::nullopt;
      return static_cast<std::size_t>(found - axes.begin());
    }
    void make_room() {
      states.resize(axes.size());
      setpoints.resize(axes.size());
    }
    template <class Drives>
    void read(Drives& drives, std::span<DriveState<double>> all, std::int64_t now_ns) {
      drives.read(states, now_ns);
      for (std::size_t i = 0; i < axes.size(); ++i) all[axes[i]] = states[i];
    }
    template <class Drives>
    void write(Drives& drives, std::span<const Setpoint<double>> all, std::int64_t now_ns) {
      if (all.empty()) {
        drives.write({}, now_ns);
        return;
      }
      for (std::size_t i = 0; i < axes.size(); ++i) setpoints[i] = all[axes[i]];
      drives.write(setpoints, now_ns);
    }
  };

  explicit RigDrives(const RigFile& rig) : rig_(rig) {}
  /// All but the links.
  void make_buses();
  void make_port();
  [[nodiscard]] BusOfRig& bus_named(const std::string& name);

  const RigFile& rig_;
  std::deque<BusOfRig> buses_;
  std::vector<can::Cia402Lane<HostLink>> lanes_;
  std::vector<can::Cia402Axis<double>> can_axes_;
  std::optional<can::Cia402Port<double, HostLink>> port_;
  std::optional<SimulatedRig> ideal_;
  std::optional<FaultSchedule> faults_;
  std::unique_ptr<StepDrives> steps_;
  Part on_can_, on_steps_, are_ideal_;  ///< every axis is in one of them
};

}  // namespace inbetween
