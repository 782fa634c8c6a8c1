// `run --sim` on the real clock. Nothing here asserts how late a tick may be: that is the machine's affair.
#include "host_tools/motions/run.hpp"

#include <gtest/gtest.h>

#include "drivers/linux/monotonic_clock.hpp"

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

const std::string bench = R"(name = "bench"
rate_hz = 200
[[axis]]
name = "x"
unit = "mm"
min = 2
max = 14
max_velocity = 100
max_acceleration = 10000
drive = { type = "pipe", path = "/dev/null", counts_per_unit = 1 }
)";

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
