// `run --sim` on the real clock. Nothing here asserts how late a tick may be: that is the machine's affair.
#include "host_tools/motions/run.hpp"

#include <gtest/gtest.h>

#include "drivers/linux/monotonic_clock.hpp"
#include "host_tools/loop/rig_session.hpp"
#include "host_tools/motions/staged_move.hpp"
#include "host_tools/motions/transport.hpp"
#include "tests/support/rig_text.hpp"

namespace inbetween {
namespace run_test {

const std::string there = R"(name = "there"
fps = 50
frames = 20
[[track]]
axes = ["x"]
keys = [ { at = [2] }, { at = [14] } ]
speed = [0, 0, 10, 0, 0]
)";

const std::string bench =
    rig_text({{.name = "x", .min = 2, .max = 14, .max_velocity = 100, .max_acceleration = 10000}},
             {.name = "bench", .rate_hz = 200});

TEST(RealTimeRun, TakesAsLongAsTheMoveAndArrivesWhereTheFastOneDoes) {
  const Plan plan(parse_move(there, "move.toml"), parse_rig(bench, "rig.toml"), {});
  const MonotonicClock clock;
  const std::int64_t start_ns = clock.now_ns();
  const RunReport report = run(plan, {.simulated = true, .fast = false});
  EXPECT_GE(clock.now_ns() - start_ns, 400'000'000);
  EXPECT_EQ(report.ticks, 81);
  EXPECT_LE(report.late_ticks, 82);
  EXPECT_EQ(report.axes[0].last_actual, 14);
  EXPECT_EQ(report.axes[0].following_error_peak,
            run(plan, {.simulated = true, .fast = true}).axes[0].following_error_peak);
}

TEST(RealTimeRun, TellsHowLateItWokeUp) {
  const Plan plan(parse_move(there, "move.toml"), parse_rig(bench, "rig.toml"), {});
  const WakeLatency latency = run(plan, {.simulated = true, .fast = false}).wake_latency;
  EXPECT_GT(latency.p50_us, 0);
  EXPECT_LE(latency.p50_us, latency.p99_us);
  EXPECT_LE(latency.p99_us, latency.p99_9_us);
  EXPECT_LE(latency.p99_9_us, latency.max_us);
}

/// Plays a move, and takes its time once, as a program does that is suspended.
struct Suspended final : public LoopTask {
  Suspended(Transport& of, std::int64_t suspended_ns) : transport(of), for_ns(suspended_ns) {}
  Transport& transport;
  std::int64_t for_ns;
  int ticks = 0;

  Status begin() override { return transport.begin(); }
  void press(TransportKey key) override { transport.press(key); }
  void tick(std::int32_t count, std::int64_t now_ns) override {
    transport.tick(count, now_ns);
    const MonotonicClock clock;
    if (++ticks == 40) clock.sleep_until_ns(clock.now_ns() + for_ns);
  }
  [[nodiscard]] bool is_over() const override { return transport.is_over(); }
  [[nodiscard]] RunSnapshot snapshot() const override { return transport.snapshot(); }
};

/// Where the axis came to rest, after a tick of `for_ns` in the middle of its travel from 2 to 14.
double end_after(std::int64_t for_ns, bool& has_lost_time) {
  const Plan plan(parse_move(there, "move.toml"), parse_rig(bench, "rig.toml"), {});
  RigReference reference(*plan.rig());
  StagedMove staged(plan);
  RigSession session(*plan.rig(), reference, {.simulated = true});
  const DisarmAtEnd disarm(session);
  EXPECT_TRUE(session.arm());
  Transport transport(session.loop(), staged, false);
  Suspended suspended(transport, for_ns);
  EXPECT_TRUE(session.perform(suspended).begun);
  has_lost_time = transport.keys().has_lost_time();
  session.rest();
  return session.positions()[0];
}

// docs/faults.md 36
TEST(RealTimeRun, ASimulationThatWasSuspendedStopsOnItsPathAndDoesNotGoOn) {
  bool has_lost_time = false;
  const double end = end_after(1'200'000'000, has_lost_time);
  EXPECT_TRUE(has_lost_time);
  EXPECT_GT(end, 3);
  EXPECT_LT(end, 13);
}

TEST(MonotonicClock, NeverWakesUpTooEarly) {
  const MonotonicClock clock;
  const std::int64_t deadline_ns = clock.now_ns() + 2'000'000;
  clock.sleep_until_ns(deadline_ns);
  EXPECT_GE(clock.now_ns(), deadline_ns);
}

TEST(MonotonicClock, DoesNotWaitForWhatHasPassed) {
  const MonotonicClock clock;
  clock.sleep_until_ns(clock.now_ns() - 1'000'000'000);
  SUCCEED();
}

}  // namespace run_test
}  // namespace inbetween
