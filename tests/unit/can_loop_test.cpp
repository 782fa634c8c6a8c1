// The motion loop over CiA 402 drives on a simulated bus: what each fault does to the whole rig
// (docs/faults.md).
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <deque>
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

namespace inbetween {
namespace can_loop_test {

using State = SupervisorState;

constexpr std::int64_t tick_ns = 4'000'000;
constexpr double counts_per_unit = 1000;

const std::string glide = R"(name = "glide"
fps = 24
frames = 96
[[track]]
axes = ["pan", "track"]
keys = [ { at = [10, 100] }, { at = [20, 180] }, { at = [-5, 260] } ]
speed = [0, 0, 10, 0, 0]
)";

const std::string crane_rig = R"(name = "crane"
rate_hz = 250
[bus.can0]
bitrate = 1000000
[[axis]]
name = "pan"
unit = "deg"
min = -90
max = 90
max_velocity = 120
max_acceleration = 1000
drive = { type = "cia402", bus = "can0", node = 1, counts_per_unit = 1000 }
[[axis]]
name = "track"
unit = "mm"
min = 0
max = 500
max_velocity = 250
max_acceleration = 1000
drive = { type = "cia402", bus = "can0", node = 2, counts_per_unit = 1000 }
)";

/// Two axes on one bus, standing at the start of the move.
struct Crane {
  Plan plan{parse_move(glide, "move.toml"), parse_rig(crane_rig, "rig.toml"), {}};
  PlannedStops stops{plan};
  Playhead<double> playhead{plan.played(), *stops.bounds(), 250};
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
  std::array<can::Cia402Axis<double>, 2> axes{{{0, 0, counts_per_unit}, {0, 1, counts_per_unit}}};
  std::vector<can::Cia402Port<double, SimulatedLink>> port;
  SimulatedLines lines;
  LoopStorage room{2, 2};
  std::vector<MotionLoop<double, can::Cia402Port<double, SimulatedLink>, SimulatedLines>> loops;
  std::int64_t now_ns = 0;

  /// The first drive counts from `first_counts` where its axis is at 10.
  explicit Crane(std::int32_t first_counts = 10'000) {
    if (first_counts != 10'000) axes[0].stands_at = 10;
    for (std::uint8_t i = 0; i < 2; ++i) {
      const can::NodeId node = *can::NodeId::make(i + 1);
      can::Cia402Settings settings{.setup = {.node = node, .host = *can::NodeId::make(127)}};
      settings.max_step_counts =
          static_cast<std::int32_t>(1.2 * counts_per_unit * plan.limits()[i].max_velocity() / 250);
      hosts.push_back(*can::Cia402Drive::make(settings));
      drives.emplace_back(
          SimulatedCia402Settings{
              .node = node, .position = i == 0 ? first_counts : 100'000, .records_targets = true},
          0);
      wire.attach(drives.back());
    }
    bus.push_back(*can::Cia402Bus::make(hosts, {.host = *can::NodeId::make(127)}));
    lanes.push_back({&bus.front(), &link, targets, known, frames});
    port.push_back(*can::Cia402Port<double, SimulatedLink>::make(lanes, axes));
    loops.emplace_back(port.front(), lines, room.memory());
    EXPECT_TRUE(loop().load({&plan.played(), &playhead, drive_of, plan.limits(), 1.0 / 250}));
  }
  Crane(const Crane&) = delete;
  Crane& operator=(const Crane&) = delete;

  [[nodiscard]] MotionLoop<double, can::Cia402Port<double, SimulatedLink>, SimulatedLines>& loop() {
    return loops.front();
  }
  void tick(int count = 1) {
    for (int i = 0; i < count; ++i) {
      now_ns += tick_ns;
      loop().tick(1, now_ns);
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
    plan.played().positions(playhead.time(), at);
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
    const std::size_t first = drives[0].applied().size();
    tick(300);
    for (std::size_t i = first; i < drives[0].applied().size(); ++i) {
      EXPECT_EQ(drives[0].applied()[i].target, drives[0].applied()[first].target) << "a target was sent";
    }
    EXPECT_LE(drives[0].applied().size(), first + 50) << "its watchdog has ended it";
    for (const SimulatedCia402Drive& drive : drives) EXPECT_NEAR(drive.velocity(), 0, 1);
  }
};

void add(SimulatedCia402Drive& drive, DriveTrouble::Kind kind, std::int64_t at_ns, std::int32_t value = 0) {
  drive.add_trouble({.kind = kind, .at_ns = at_ns, .value = value});
}

TEST(CanLoop, PlaysAMoveAndTheDrivesOwnRecordIsThePlan) {
  Crane crane;
  crane.start();
  const std::size_t before = crane.drives[0].applied().size();
  ASSERT_TRUE(crane.tick_until(State::ready));
  crane.tick(100);
  const std::int64_t last = last_tick(96, {24, 1}, 250);
  std::array<double, 2> expected{};
  for (std::size_t d = 0; d < 2; ++d) {
    const auto& applied = crane.drives[d].applied();
    ASSERT_GT(applied.size(), before + static_cast<std::size_t>(last) + 2);
    for (std::int64_t tick = 1; tick <= last; ++tick) {
      crane.plan.played().positions(frame_time_of_tick<double>(tick, {24, 1}, 250), expected);
      // A target acts one tick after it was given, and the bus is heard in the tick after.
      const std::int32_t target = applied[before + static_cast<std::size_t>(tick) + 1].target;
      ASSERT_NEAR(target, expected[d] * counts_per_unit, 0.5001) << "axis " << d << ", tick " << tick;
    }
  }
  EXPECT_NEAR(crane.drives[0].position(), -5'000, 1.5);
  EXPECT_NEAR(crane.drives[1].position(), 260'000, 1.5);
}

// docs/faults.md 13
TEST(CanLoop, AFullQueueIsCountedAndSeveralInARowAreAControlledStop) {
  Crane crane;
  crane.start();
  crane.tick(200);
  crane.link.set_room(1);
  crane.tick();
  crane.link.set_room(64);
  crane.tick(20);
  EXPECT_EQ(crane.loop().state(), State::running) << "one is counted";
  EXPECT_GT(crane.port.front().counters(0).unsent, 0U);
  crane.link.set_room(1);
  crane.tick(4);
  EXPECT_EQ(crane.loop().state(), State::stopping);
}

// docs/faults.md 15
TEST(CanLoop, FramesThatWaitedBeforeAreThrownAwayBeforeTheDrivesAreSwitchedOn) {
  Crane crane;
  const can::Frame stale =
      can::feedback_frame(*can::NodeId::make(1), {.statusword = 0x1237, .actual = 77'000});
  for (int i = 0; i < 500; ++i) crane.link.put_stale(stale);
  crane.start();
  EXPECT_GE(crane.port.front().counters(0).drained, 400U);
  EXPECT_EQ(crane.loop().state(), State::running);
}

// docs/faults.md 16
TEST(CanLoop, ALinkThatGoesDownCeasesSetpointsAndDoesNotReconnectAndGo) {
  Crane crane;
  crane.start();
  crane.tick(400);
  crane.link.set_up(false);
  crane.expect_ceased_setpoints();
  crane.link.set_up(true);
  crane.tick(200);
  EXPECT_EQ(crane.loop().state(), State::cut_off);
  EXPECT_FALSE(crane.loop().post(SupervisorEvent::start));
  ASSERT_TRUE(crane.loop().post(SupervisorEvent::acknowledge));
  ASSERT_TRUE(crane.tick_until(State::ready)) << name_of(crane.loop().state());
  EXPECT_FALSE(crane.loop().start(Direction::forward)) << "it is not where the playhead is";
}

// docs/faults.md 17
TEST(CanLoop, AForeignSenderOnOurIdentifiersIsAControlledStop) {
  Crane crane;
  crane.start();
  crane.tick(400);
  crane.wire.inject(can::command_frame(*can::NodeId::make(2), {.controlword = 0x000F, .target = 0}));
  crane.expect_controlled_stop(State::latched);
}

// docs/faults.md 18
TEST(CanLoop, AFloodOfFramesIsBoundedAndCountedAndTheMoveGoesOn) {
  Crane crane;
  crane.start();
  const can::Frame noise{.id = 0x123, .length = 8};
  for (int tick = 0; tick < 100; ++tick) {
    for (int i = 0; i < 40; ++i) crane.wire.inject(noise);
    crane.tick();
  }
  EXPECT_EQ(crane.loop().state(), State::running);
  for (int i = 0; i < 100; ++i) crane.wire.inject(noise);
  crane.tick();
  EXPECT_GT(crane.port.front().counters(0).floods, 0U);
}

// docs/faults.md 20
TEST(CanLoop, LostFramesOfOneAxisStopAllOnThePath) {
  Crane crane;
  crane.start();
  crane.tick(400);
  add(crane.drives[1], DriveTrouble::Kind::lose_feedback, crane.now_ns);
  crane.expect_controlled_stop(State::faulted);
}

// docs/faults.md 21
TEST(CanLoop, ALostHeartbeatStopsAllWithinItsTimeout) {
  Crane crane;
  crane.start();
  crane.tick(400);
  add(crane.drives[0], DriveTrouble::Kind::lose_heartbeat, crane.now_ns);
  const std::int64_t from_ns = crane.now_ns;
  ASSERT_TRUE(crane.tick_until(State::stopping, 200));
  EXPECT_LE(crane.now_ns - from_ns, 150'000'000 + 2 * tick_ns);
}

// docs/faults.md 23
TEST(CanLoop, AnEmergencyInMotionSlowsTheOthersDownAndIsThere) {
  Crane crane;
  crane.start();
  crane.tick(400);
  add(crane.drives[0], DriveTrouble::Kind::emergency, crane.now_ns, 0x2310);
  crane.expect_controlled_stop(State::latched);
  EXPECT_EQ(crane.hosts[0].last_emergency().code, 0x2310);
  EXPECT_GE(crane.hosts[0].counters().emergencies, 1U);
}

// docs/faults.md 24
TEST(CanLoop, AnUnexpectedBootUpIsAControlledStopAndLosesTheReference) {
  Crane crane;
  crane.start();
  crane.tick(400);
  add(crane.drives[1], DriveTrouble::Kind::reboot, crane.now_ns + tick_ns);
  crane.tick(2);
  ASSERT_TRUE(crane.tick_until(State::stopping, 200)) << name_of(crane.loop().state());
  crane.tick(200);
  EXPECT_TRUE(crane.hosts[1].findings().has(can::DriveFinding::unexpected_boot));
  EXPECT_TRUE(can::words_of(can::DriveFinding::unexpected_boot).loses_reference);
}

// docs/faults.md 25
TEST(CanLoop, AFollowingErrorStopsAllOnThePathAndThenTheDriveByItself) {
  Crane crane;
  crane.start();
  crane.tick(300);
  add(crane.drives[1], DriveTrouble::Kind::stick, crane.now_ns);
  ASSERT_TRUE(crane.tick_until(State::stopping, 500)) << name_of(crane.loop().state());
  while (crane.loop().state() == State::stopping) {
    ASSERT_TRUE(crane.is_on_path());
    crane.tick();
  }
  crane.tick(100);
  EXPECT_NE(crane.loop().state(), State::running);
  EXPECT_FALSE(crane.loop().post(SupervisorEvent::start));
}

// docs/faults.md 26
TEST(CanLoop, ADriveThatIgnoresItsTargetMakesTimeStandStill) {
  for (const auto kind : {DriveTrouble::Kind::ignore_target, DriveTrouble::Kind::wrong_mode}) {
    Crane crane;
    crane.start();
    crane.tick(400);
    add(crane.drives[0], kind, crane.now_ns, 1);
    ASSERT_TRUE(crane.tick_until(State::stopping, 200)) << name_of(crane.loop().state());
    while (crane.loop().state() == State::stopping) {
      ASSERT_TRUE(crane.is_on_path());
      crane.tick();
    }
    EXPECT_NE(crane.loop().state(), State::running);
  }
}

// docs/faults.md 28
TEST(CanLoop, AnEmergencyStopIsNotUndoneByItsRelease) {
  Crane crane;
  crane.start();
  crane.tick(400);
  crane.lines.is_pressed = true;
  crane.expect_ceased_setpoints();
  add(crane.drives[0], DriveTrouble::Kind::move_by_hand, crane.now_ns, 5'000);
  crane.tick(10);
  crane.lines.is_pressed = false;
  crane.tick(100);
  EXPECT_EQ(crane.loop().state(), State::cut_off);
  ASSERT_TRUE(crane.loop().post(SupervisorEvent::acknowledge));
  ASSERT_TRUE(crane.tick_until(State::ready)) << name_of(crane.loop().state());
  EXPECT_NEAR(crane.room.targets()[0] * counts_per_unit, crane.drives[0].position(), 3)
      << "positions were read again";
  EXPECT_FALSE(crane.loop().start(Direction::forward)) << "it has been moved";
  crane.tick(100);
  EXPECT_NEAR(crane.drives[0].velocity(), 0, 1);
}

// docs/faults.md 29
TEST(CanLoop, WhenTheHostFallsSilentTheDrivesStopByThemselves) {
  Crane crane;
  crane.start();
  crane.tick(400);
  ASSERT_GT(std::fabs(crane.drives[1].velocity()), 1000);
  for (int i = 0; i < 100; ++i) {
    crane.now_ns += tick_ns;
    static_cast<void>(crane.wire.run(crane.now_ns));
  }
  for (const SimulatedCia402Drive& drive : crane.drives) EXPECT_NEAR(drive.velocity(), 0, 1);
}

TEST(CanLoop, ADriveThatNeverBootsIsNamedAndNothingIsSwitchedOn) {
  Crane crane;
  crane.wire.set_fate(
      [](const can::Frame& frame, std::int64_t) { return FrameFate{.copies = frame.id == 0x702 ? 0 : 1}; });
  ASSERT_TRUE(crane.loop().post(SupervisorEvent::arm));
  ASSERT_TRUE(crane.tick_until(State::faulted)) << name_of(crane.loop().state());
  EXPECT_EQ(crane.hosts[1].first_finding(), can::DriveFinding::never_booted);
  EXPECT_NE(crane.drives[0].state(), can::Cia402State::operation_enabled);
}

// A drive that counts from wherever it was switched on: where its axis stands is known from before.
TEST(CanLoop, AnAxisStandsWhereItIsKnownToWhateverItsDriveCounts) {
  Crane crane(-777);
  ASSERT_NO_FATAL_FAILURE(crane.start());
  EXPECT_EQ(crane.room.targets()[0], 10);
  EXPECT_NEAR(crane.drives[0].position(), -777, 1) << "it has not moved to where its count would be 10'000";
  ASSERT_TRUE(crane.tick_until(State::ready, 2000));
  crane.tick(50);
  const double end = crane.room.targets()[0];
  EXPECT_NEAR(crane.drives[0].position(), -777 + (end - 10) * counts_per_unit, 2);
}

}  // namespace can_loop_test
}  // namespace inbetween
