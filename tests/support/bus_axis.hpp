// One axis with its drive on a simulated bus, of any protocol, under the port that the motion loop has.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/rig/bus_kind.hpp"
#include "inbetween/can/bus_port.hpp"
#include "sim/can_bus.hpp"
#include "sim/simulated_link.hpp"
#include "tests/support/rig_text.hpp"

namespace inbetween {

/// The drive of the axis in the rig file, on node 3 of can0, and that bus. `resolution` is that of its own
/// record, in units of the axis. One that does not stop alone stays at its last position with power.
template <class Kind>
struct DriveInRig;
/// What most of them have.
struct UsualDriveInRig {
  static std::string bus() { return bus_can0; }
  static constexpr double resolution = 1e-5;
  static constexpr const char* on = "position";
  static constexpr bool stops_alone = true;
};
template <>
struct DriveInRig<Cia402Kind> : UsualDriveInRig {
  static std::string text() { return cia402_text(3, 1000); }
  static constexpr double resolution = 0.0005;
  static constexpr const char* on = "operation enabled";
  static constexpr std::int32_t fault = 0x7305;  ///< of a script, and as it is told
  static constexpr const char* fault_words = "7305h";
};
/// The same protocol in mode 7.
struct InterpolatedKind : Cia402Kind {};
template <>
struct DriveInRig<InterpolatedKind> : DriveInRig<Cia402Kind> {
  static std::string text() { return cia402_text(3, 1000) + R"(, mode = "interpolated")"; }
};
template <>
struct DriveInRig<OdriveKind> : UsualDriveInRig {
  static std::string text() {
    return R"(type = "odrive", bus = "can0", node = 3, turns_per_unit = -0.25, firmware = "0.6")";
  }
  static constexpr const char* on = "closed loop";
  static constexpr std::int32_t fault = 0x20;  ///< of a script, and as it is told
  static constexpr const char* fault_words = "gate driver";
};
template <>
struct DriveInRig<RmdKind> : UsualDriveInRig {
  static std::string text() { return R"(type = "rmd", bus = "can0", node = 3, turns_per_unit = -0.05)"; }
  static constexpr double resolution = 0.0003;  // half a hundredth of a degree of the motor
  static constexpr std::int32_t fault = 0x2;    ///< of a script, and as it is told
  static constexpr const char* fault_words = "stalled";
};
template <>
struct DriveInRig<CubemarsKind> : UsualDriveInRig {
  static std::string text() {
    return R"(type = "cubemars", bus = "can0", node = 3, turns_per_unit = -0.05, pole_pairs = 21, )"
           R"(gear = 6, no_watchdog = "accepted")";
  }
  static constexpr std::int32_t fault = 3;  ///< of a script, and as it is told
  static constexpr const char* fault_words = "error 3";
  static constexpr bool stops_alone = false;
};
template <>
struct DriveInRig<MoteusKind> : UsualDriveInRig {
  static std::string text() { return R"(type = "moteus", bus = "can0", node = 3, turns_per_unit = -0.25)"; }
  static std::string bus() { return bus_can0 + "data_bitrate = 5000000\n"; }
  static constexpr std::int32_t fault = 33;  ///< of a script, and as it is told
  static constexpr const char* fault_words = "fault 33";
};

template <class Kind>
class BusAxis {
 public:
  using Bus = typename Kind::Bus;
  using Frame = typename Bus::Frame;
  using Link = SimulatedLinkTo<Frame>;
  using Port = can::BusPort<Bus, Link>;
  static constexpr std::int64_t tick_ns = 4'000'000;
  static constexpr double stands_at = 20;

  explicit BusAxis(const std::string& drive_text = DriveInRig<Kind>::text(), const std::string& more = "",
                   double position = stands_at)
      : rig(parse_rig(rig_text({axis_text("pan", "deg", {-90, 90}, {.velocity = 40, .acceleration = 400},
                                          more, drive_text)},
                               {.rate_hz = 250, .more = DriveInRig<Kind>::bus()}),
                      "rig.toml")),
        drive(Kind::simulate(axis(), {.position = position, .keeps_record = true})) {
    wire.attach(*drive);
    hosts.push_back(Kind::host_of(axis(), rig.rate_hz));
    bus.emplace(Kind::bus_of(hosts, rig.rate_hz, axis()));
    lanes.push_back({&*bus, &link, targets, known, frames});
    axes[0].watch = watch_of(axis());
    port.emplace(*Port::make(lanes, axes));
  }
  BusAxis(const BusAxis&) = delete;
  BusAxis& operator=(const BusAxis&) = delete;

  [[nodiscard]] const RigAxis& axis() const { return rig.axes[0]; }
  [[nodiscard]] const typename Bus::Drive& host() const { return hosts[0]; }
  /// Where the motor is, in units of the axis.
  [[nodiscard]] double truly() const { return drive->position() / Kind::scale_of(axis()); }
  [[nodiscard]] bool has_power() const { return drive->state_name() == std::string(DriveInRig<Kind>::on); }

  /// One tick; no setpoint: none is written.
  void tick(const std::optional<Setpoint>& setpoint = {}) {
    now_ns += tick_ns;
    port->read({&state, 1}, now_ns);
    if (state.condition > worst) worst = state.condition;
    if (setpoint) {
      port->write({&*setpoint, 1}, now_ns);
    } else {
      port->write({}, now_ns);
    }
  }
  void ticks(int count, const std::optional<Setpoint>& setpoint = {}) {
    for (int i = 0; i < count; ++i) tick(setpoint);
  }
  bool tick_until(const std::function<bool()>& holds, int most = 3000) {
    for (int i = 0; i < most && !holds(); ++i) tick();
    return holds();
  }
  /// Set up and switched on.
  bool switch_on() {
    port->enable();
    tick();  // what it told before is of before
    return tick_until([&] { return state.is_on || worst != DriveCondition::fine; }) && state.is_on;
  }
  /// A tick in a motion with its velocity, `s` seconds after it began: there and back, at rest at both ends.
  [[nodiscard]] Setpoint swing(double s) const {
    constexpr double distance = 5;
    constexpr double pi = 3.14159265358979323846;
    const double omega = 2 * pi / swing_s;
    return {.position = from + distance * (1 - std::cos(omega * s)),
            .velocity = distance * omega * std::sin(omega * s)};
  }
  static constexpr double swing_s = 2;

  RigFile rig;
  std::unique_ptr<SimulatedDriveOn<Frame>> drive;
  SimulatedBus<Frame> wire;
  Link link{wire};
  std::vector<typename Bus::Drive> hosts;
  std::optional<Bus> bus;
  std::array<typename Bus::Drive::Target, 1> targets{};
  std::array<can::PortDrive, 1> known{};
  std::array<Frame, can::frames_per_read(1)> frames{};
  std::vector<typename Port::Lane> lanes;
  std::array<typename Port::Axis, 1> axes{{{0, 0, Kind::scale_of(axis())}}};
  std::optional<Port> port;
  DriveState state{};
  DriveCondition worst = DriveCondition::fine;
  double from = stands_at;
  std::int64_t now_ns = 0;
};

}  // namespace inbetween
