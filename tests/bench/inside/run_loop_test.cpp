// The whole loop of `run` on a bus with drives in another process: which system calls it makes, and that its
// memory is there.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "drivers/linux/monotonic_clock.hpp"
#include "drivers/linux/real_time.hpp"
#include "drivers/linux/telemetry_ring.hpp"
#include "host_tools/loop/loop_preparations.hpp"
#include "host_tools/loop/loop_runner.hpp"
#include "host_tools/loop/loop_storage.hpp"
#include "host_tools/motions/staged_move.hpp"
#include "host_tools/motions/transport.hpp"
#include "host_tools/plan/plan.hpp"
#include "host_tools/rig/machine_hardware.hpp"
#include "host_tools/takes/take_recorder.hpp"
#include "host_tools/takes/take_store.hpp"
#include "host_tools/takes/taken_motion.hpp"
#include "tests/bench/inside/allowed_calls.hpp"
#include "tests/bench/inside/drives_process.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace run_loop_test {

const std::string there = R"(name = "there"
fps = 25
frames = 100
[[track]]
axes = ["x", "y"]
keys = [ { at = [0, 0] }, { at = [50, 20] } ]
speed = [0, 0, 10, 10, 0, 0]
)";

// Slow enough for drives that are a process of a machine with other work to hear every SYNC in time.
const std::string bench = rig_text({axis_text("x", "mm", {-1, 60}, {.velocity = 100, .acceleration = 1000},
                                              R"(unpowered = "holds")", cia402_text(1)),
                                    axis_text("y", "mm", {-1, 60}, {.velocity = 100, .acceleration = 1000},
                                              R"(unpowered = "holds")", cia402_text(2))},
                                   {.name = "bench", .rate_hz = 25, .more = bus_can0});

/// What a run consists of, without its audience. With a sink every tick goes there.
struct LoopOnBus {
  explicit LoopOnBus(TickSink* take = nullptr) : trace(2, {take}) {}

  Plan plan{parse_move(there, "move.toml"), parse_rig(bench, "rig.toml"), {}};
  StagedMove staged{plan};
  MachineHardware hardware{*plan.rig()};
  RigDrives drives{*plan.rig(), hardware};
  RigInputs lines{*plan.rig(), hardware};
  LoopStorage room{2, 2};
  RunLoop loop{drives, lines, room.memory()};
  LoopTrace trace;
  Arming arming{loop};
  Transport transport{loop, staged, true};
  TelemetryRing<RunSnapshot, 64> shown;
  MonotonicClock clock;
  std::int64_t deadline_ns = 0;

  template <class Act>
  void tick(Act& act) {
    deadline_ns += 40'000'000;
    clock.sleep_until_ns(deadline_ns);
    act.tick(1, clock.now_ns());
    trace.take(loop, &act);
    shown.push(act.snapshot());
  }
  /// Switches the drives on and starts. False: they could not be.
  bool start() {
    deadline_ns = clock.now_ns();
    if (!arming.begin()) return false;
    for (int i = 0; i < 1000 && !arming.is_over(); ++i) tick(arming);
    return loop.state() == SupervisorState::ready && transport.begin().has_value();
  }
};

TEST(RunLoopOnBus, MakesNoOtherSystemCallsThanToSleepToSendAndToReceive) {
  std::unique_ptr<DrivesProcess> drives;
  std::unique_ptr<LoopOnBus> rig;
  const auto prepare = [&] {
    drives = std::make_unique<DrivesProcess>(parse_rig(bench, "rig.toml"));
    rig = std::make_unique<LoopOnBus>();
  };
  const auto loop = [&] {
    if (!rig->start()) ::_exit(1);
    for (int i = 0; i < 60; ++i) rig->tick(rig->transport);
    if (rig->loop.state() != SupervisorState::running) ::_exit(2);
    rig->transport.press(TransportKey::stop);
    for (int i = 0; i < 60; ++i) rig->tick(rig->transport);
    if (rig->loop.state() != SupervisorState::latched) ::_exit(3);
  };
  EXPECT_EQ(only_loop_calls(prepare, loop), "");
}

/// A take of the move before its first tick.
Take take_of_move() {
  const Plan plan(parse_move(there, "move.toml"), parse_rig(bench, "rig.toml"), {});
  Take take;
  take.rate_hz = plan.rig()->rate_hz;
  take.frame_rate = plan.played().frame_rate();
  take.frames = plan.move().frames;
  for (const PlanAxis& axis : plan.axes())
    take.axes.push_back(take_axis_of(plan.rig()->axes[take.axes.size()], axis.move_axis));
  take.trajectory = bytes_of(plan.motion());
  return take;
}

TEST(RunLoopOnBus, MakesNoSystemCallMoreForATake) {
  const TemporaryFolder folder;
  const std::string file = folder.path() / "takes.db";
  constexpr std::int64_t moving_ticks = 60, stopped_ticks = 60;
  std::unique_ptr<DrivesProcess> drives;
  std::unique_ptr<TakeRecorder> recorder;
  std::unique_ptr<LoopOnBus> rig;
  const auto prepare = [&] {
    drives = std::make_unique<DrivesProcess>(parse_rig(bench, "rig.toml"));
    // Its thread is there before the filter, which is of this thread alone.
    recorder = std::make_unique<TakeRecorder>(
        TakeKeeping{.file = file, .pulse_words = [](std::size_t) { return std::string("flash"); }},
        take_of_move());
    rig = std::make_unique<LoopOnBus>(recorder.get());
  };
  const auto loop = [&] {
    if (!rig->start()) ::_exit(1);
    for (int i = 0; i < moving_ticks; ++i) rig->tick(rig->transport);
    if (rig->loop.state() != SupervisorState::running) ::_exit(2);
    recorder->pulse(0);
    rig->trace.press(rig->transport, TransportKey::stop);
    for (int i = 0; i < stopped_ticks; ++i) rig->tick(rig->transport);
    if (rig->loop.state() != SupervisorState::latched) ::_exit(3);
  };
  EXPECT_EQ(only_loop_calls(prepare, loop), "");
  // The process ended as one that is killed: what was written by then is there, all but a second.
  TakeStore store(file, TakeStore::Access::read);
  EXPECT_GE(store.list().at(0).ticks, moving_ticks + stopped_ticks - take_of_move().rate_hz);
  EXPECT_EQ(store.list().at(0).lost_ticks, 0);
}

TEST(RunLoopOnBus, NoPageFaultsAfterTheFirstSecond) {
  const DrivesProcess drives(parse_rig(bench, "rig.toml"));
  LoopOnBus rig;
  const RealTimeThread rights({});
  ASSERT_TRUE(rig.start()) << rig.drives.trouble();
  for (int i = 0; i < 25; ++i) rig.tick(rig.transport);
  // The bench counts the first touch of a page though it is in memory: one stretch of four may have some.
  int stretches_with_faults = 0;
  for (int stretch = 0; stretch < 4; ++stretch) {
    rusage before{};
    rusage after{};
    ASSERT_EQ(::getrusage(RUSAGE_THREAD, &before), 0);
    for (int i = 0; i < 15; ++i) rig.tick(rig.transport);
    ASSERT_EQ(::getrusage(RUSAGE_THREAD, &after), 0);
    EXPECT_EQ(after.ru_majflt, before.ru_majflt);
    if (after.ru_minflt != before.ru_minflt) ++stretches_with_faults;
  }
  EXPECT_LE(stretches_with_faults, 1);
  EXPECT_EQ(rig.loop.state(), SupervisorState::running);
}

}  // namespace run_loop_test
}  // namespace inbetween
