#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <vector>

#include "inbetween/can/cia402_bus.hpp"
#include "inbetween/can/cia402_drive.hpp"
#include "sim/can_bus.hpp"
#include "sim/cia402_drive.hpp"

namespace inbetween {

/// A host and simulated drives on one bus, on a virtual clock at 250 Hz. Axis i is node i + 1.
class SimulatedCanRig {
 public:
  static constexpr std::int64_t tick_ns = 4'000'000;
  explicit SimulatedCanRig(std::size_t axes, const can::Cia402Setup& common = default_setup());
  static can::Cia402Setup default_setup();

  /// One tick of the host, and what the drives make of it. No targets: none are sent.
  void tick(const std::vector<std::int32_t>& targets = {});
  /// Until it holds; false: it does not within ten seconds.
  bool tick_until(const std::function<bool()>& holds, const std::vector<std::int32_t>& targets = {});
  /// The drives and their bus without the host: it is dead.
  void pass(std::int64_t ns);

  void connect();
  bool enable();
  [[nodiscard]] bool all_are(can::DrivePhase phase) const;
  /// Set up and switched on; false with the findings printed by the caller.
  bool bring_to_following();

  [[nodiscard]] can::Cia402Bus& bus() { return bus_.front(); }
  [[nodiscard]] can::Cia402Drive& host_of(std::size_t axis) { return hosts[axis]; }
  [[nodiscard]] SimulatedCia402Drive& drive(std::size_t axis) { return drives[axis]; }

  std::int64_t now_ns = 0;
  std::vector<can::Cia402Drive> hosts;
  std::deque<SimulatedCia402Drive> drives;
  SimulatedCanBus wire;
  /// What the host has sent in the last tick.
  std::vector<can::Frame> sent;

 private:
  std::vector<can::Cia402Bus> bus_;
};

}  // namespace inbetween
