#include "tests/support/simulated_can_rig.hpp"

#include <algorithm>

namespace inbetween {
namespace {

can::NodeId node(std::size_t number) {
  return can::NodeId::make(static_cast<std::int64_t>(number)).value();
}

}  // namespace

can::Cia402Setup SimulatedCanRig::default_setup() {
  return {.node = node(1), .host = node(127), .quick_stop_option = 6};
}

SimulatedCanRig::SimulatedCanRig(std::size_t axes, const can::Cia402Setup& common) {
  for (std::size_t axis = 0; axis < axes; ++axis) {
    can::Cia402Setup setup = common;
    setup.node = node(axis + 1);
    can::Cia402Settings settings{.setup = setup, .max_step_counts = 2000};
    if (setup.homing) {
      settings.homing = {
          .home = setup.homing->offset, .tolerance = 20, .max_step = 20, .timeout_ns = 9'000'000'000};
    }
    hosts.push_back(can::Cia402Drive::make(settings).value());
    drives.emplace_back(SimulatedCia402Settings{.node = setup.node,
                                                .position = static_cast<std::int32_t>(1000 * (axis + 1)),
                                                .keeps_record = true},
                        now_ns);
    wire.attach(drives.back());
  }
  bus_.push_back(
      can::Cia402Bus::make(hosts, {.host = common.host, .sync_overflow = common.sync_overflow}).value());
}

void SimulatedCanRig::tick(const std::vector<std::int32_t>& targets) {
  now_ns += tick_ns;
  std::vector<can::Frame> frames(can::Cia402Bus::frames_per_tick(hosts.size()));
  frames.resize(bus_.front().tick(now_ns, targets, frames).value());
  sent = frames;
  for (const can::Frame& frame : sent) wire.send(frame);
  for (const can::Frame& frame : wire.run(now_ns)) bus_.front().receive(frame, now_ns);
}

bool SimulatedCanRig::tick_until(const std::function<bool()>& holds,
                                 const std::vector<std::int32_t>& targets) {
  for (int i = 0; i < 2500; ++i) {
    if (holds()) return true;
    tick(targets);
  }
  return holds();
}

void SimulatedCanRig::pass(std::int64_t ns) {
  const std::int64_t end_ns = now_ns + ns;
  while (now_ns < end_ns) {
    now_ns = std::min(now_ns + 1'000'000, end_ns);
    wire.run(now_ns);
  }
}

void SimulatedCanRig::connect() {
  for (can::Cia402Drive& host : hosts) host.connect(now_ns);
}

bool SimulatedCanRig::enable() {
  return std::ranges::all_of(hosts, [this](can::Cia402Drive& host) { return host.enable(now_ns); });
}

bool SimulatedCanRig::all_are(can::DrivePhase phase) const {
  return std::ranges::all_of(hosts, [phase](const can::Cia402Drive& host) { return host.phase() == phase; });
}

bool SimulatedCanRig::bring_to_following() {
  connect();
  if (!tick_until([this] { return all_are(can::DrivePhase::idle); })) return false;
  return enable() && tick_until([this] { return all_are(can::DrivePhase::following); });
}

}  // namespace inbetween
