// A rig of two CiA 402 drives on a simulated bus under the motion loop, on a virtual clock.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <functional>
#include <string>
#include <vector>

#include "host_tools/check/planned_stops.hpp"
#include "host_tools/loop/loop_storage.hpp"
#include "host_tools/plan/plan.hpp"
#include "inbetween/can/cia402_port.hpp"
#include "inbetween/loop/motion_loop.hpp"
#include "sim/can_bus.hpp"
#include "sim/cia402_drive.hpp"
#include "sim/simulated_link.hpp"
#include "sim/simulated_rig.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/simulated_lines.hpp"

namespace inbetween {

inline const char* const glide_of_crane = R"(name = "glide"
fps = 24
frames = 96
[[track]]
axes = ["pan", "track"]
keys = [ { at = [10, 100] }, { at = [20, 180] }, { at = [-5, 260] } ]
speed = [0, 0, 10, 0, 0]
)";

inline const std::string rig_of_crane = rig_text(
    {axis_text("pan", "deg", {-90, 90}, {.velocity = 120, .acceleration = 1000}, "", cia402_text(1)),
     axis_text("track", "mm", {0, 500}, {.velocity = 250, .acceleration = 1000}, "", cia402_text(2))},
    {.rate_hz = 250, .more = bus_can0});

/// Two axes on one bus, standing at the start of the move.
struct CanCrane {
  using State = SupervisorState;
  static constexpr std::int64_t tick_ns = 4'000'000;
  static constexpr double counts_per_unit = 1000;

  Plan plan{parse_move(glide_of_crane, "move.toml"), parse_rig(rig_of_crane, "rig.toml"), {}};
  PlannedStops stops{plan};
  Playhead playhead{plan.played(), *stops.bounds(), 250};
  std::vector<std::size_t> drive_of{0, 1};
  std::deque<SimulatedCia402Drive> drives;
  SimulatedCanBus wire;
  SimulatedLink link{wire};
  std::vector<can::Cia402Drive> hosts;
  std::vector<can::Cia402Bus> bus;
  std::array<std::int32_t, 2> targets{};
  std::array<can::PortDrive, 2> known{};
  std::array<can::Frame, 64> frames{};
  std::vector<can::Cia402Lane<SimulatedLink>> lanes;
  std::array<can::Cia402Axis, 2> axes{{{0, 0, counts_per_unit}, {0, 1, counts_per_unit}}};
  std::vector<can::Cia402Port<SimulatedLink>> port;
  SimulatedLines lines;
  LoopStorage room{2, 2};
  std::vector<MotionLoop<can::Cia402Port<SimulatedLink>, SimulatedLines>> loops;
  std::int64_t now_ns = 0;

  /// The first drive counts from `first_counts` where its axis is at 10.
  explicit CanCrane(std::int32_t first_counts = 10'000,
                    const std::function<void(can::Cia402Settings&)>& change = {}) {
    if (first_counts != 10'000) axes[0].stands_at = 10;
    for (std::uint8_t i = 0; i < 2; ++i) {
      const can::NodeId node = *can::NodeId::make(i + 1);
      can::Cia402Settings settings{.setup = {.node = node, .host = *can::NodeId::make(127)}};
      settings.max_step_counts =
          static_cast<std::int32_t>(1.2 * counts_per_unit * plan.limits()[i].max_velocity() / 250);
      if (change) change(settings);
      hosts.push_back(*can::Cia402Drive::make(settings));
      drives.emplace_back(
          SimulatedCia402Settings{
              .node = node, .position = i == 0 ? first_counts : 100'000, .keeps_record = true},
          0);
      wire.attach(drives.back());
    }
    bus.push_back(*can::Cia402Bus::make(hosts, {.host = *can::NodeId::make(127)}));
    lanes.push_back({&bus.front(), &link, targets, known, frames});
    port.push_back(*can::Cia402Port<SimulatedLink>::make(lanes, axes));
    loops.emplace_back(port.front(), lines, room.memory());
    EXPECT_TRUE(loop().load({&plan.motion(), &playhead, drive_of, plan.limits(), 1.0 / 250}));
  }
  CanCrane(const CanCrane&) = delete;
  CanCrane& operator=(const CanCrane&) = delete;

  [[nodiscard]] MotionLoop<can::Cia402Port<SimulatedLink>, SimulatedLines>& loop() { return loops.front(); }
  void tick(int count = 1) {
    for (int i = 0; i < count; ++i) {
      now_ns += tick_ns;
      loop().tick(1, now_ns);
    }
  }
  /// The drives and their bus without the host: it is gone.
  void pass(std::int64_t ns) {
    for (const std::int64_t end_ns = now_ns + ns; now_ns < end_ns;) {
      now_ns += 1'000'000;
      static_cast<void>(wire.run(now_ns));
    }
  }
  /// Disarms, and ticks until no drive is on its way off. How many ticks that took.
  int switch_off() {
    loop().post(SupervisorEvent::disarm);
    for (int ticks = 1;; ++ticks) {
      tick();
      const bool leaves = std::ranges::any_of(loop().drive_states(), &DriveState::is_leaving);
      if (!leaves || ticks == 10'000) return ticks;
    }
  }
  bool tick_until(State state, int most = 5000) {
    for (int i = 0; i < most && loop().state() != state; ++i) tick();
    return loop().state() == state;
  }
  void start() {
    ASSERT_TRUE(loop().post(SupervisorEvent::arm));
    ASSERT_TRUE(tick_until(State::ready)) << name_of(loop().state());
    ASSERT_TRUE(loop().start(Direction::forward));
  }
  /// Both axes are where the playhead has them, to a count of the setpoint: on the path.
  [[nodiscard]] bool is_on_path() const {
    std::vector<double> at(2);
    plan.motion().positions(playhead.time(), at);
    return at == room.targets();
  }
  /// A controlled stop of all axes along the path, which ends in `last`.
  void expect_controlled_stop(State last) {
    ASSERT_TRUE(tick_until(State::stopping, 100)) << name_of(loop().state());
    for (int i = 0; i < 1000 && loop().state() == State::stopping; ++i) {
      ASSERT_TRUE(is_on_path());
      tick();
    }
    ASSERT_TRUE(tick_until(last, 100)) << name_of(loop().state());
    const std::vector<double> rest = room.targets();
    tick(200);
    EXPECT_EQ(room.targets(), rest) << "no motion after a stop";
    EXPECT_FALSE(loop().post(SupervisorEvent::start)) << "nothing resumes by itself";
  }
  /// Setpoints cease at once, and the drives stop by themselves.
  void expect_ceased_setpoints() {
    ASSERT_TRUE(tick_until(State::faulted, 100)) << name_of(loop().state());
    tick(2);
    const std::size_t first = drives[0].record().applied.size();
    tick(300);
    for (std::size_t i = first; i < drives[0].record().applied.size(); ++i) {
      EXPECT_EQ(drives[0].record().applied[i].target, drives[0].record().applied[first].target)
          << "a target was sent";
    }
    EXPECT_LE(drives[0].record().applied.size(), first + 50) << "its watchdog has ended it";
    for (const SimulatedCia402Drive& drive : drives) EXPECT_NEAR(drive.velocity(), 0, 1);
  }
};

}  // namespace inbetween
