// Sixteen axes at 1 kHz in the thread of a real-time loop, with a take and without one, in turns. How late a
// tick is, is the machine's affair, and is printed; what is held is that the take has every tick.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/loop/loop_runner.hpp"
#include "host_tools/takes/take_recorder.hpp"
#include "host_tools/takes/take_store.hpp"
#include "tests/support/sixteen_axes.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace take_latency_test {

constexpr std::int64_t ticks_of_a_stretch = 3000;
constexpr int stretches = 5;

/// The move for so many ticks.
class Stretch final : public LoopTask {
 public:
  explicit Stretch(Transport& of) : transport_(of) {}
  void press(TransportKey key) override { transport_.press(key); }
  void tick(std::int32_t ticks, std::int64_t now_ns) override {
    transport_.tick(ticks, now_ns);
    ++ticks_;
  }
  [[nodiscard]] bool is_over() const override { return ticks_ >= ticks_of_a_stretch; }
  [[nodiscard]] RunSnapshot snapshot() const override { return transport_.snapshot(); }
  [[nodiscard]] std::optional<PlayedPlace> played() const override { return transport_.played(); }

 private:
  Transport& transport_;
  std::int64_t ticks_ = 0;
};

/// What a take has before the act begins and after it, the ticks between acts, depends on when threads wake
/// up.
class OfTheAct final : public TickSink {
 public:
  explicit OfTheAct(TickSink* to) : to_(to) {}
  void take(const RunLoop& loop, const LoopTask* act) override {
    if (act == nullptr) return;
    ++ticks_;
    if (to_ != nullptr) to_->take(loop, act);
  }
  [[nodiscard]] std::int64_t ticks() const { return ticks_; }

 private:
  TickSink* to_;
  std::int64_t ticks_ = 0;
};

/// How late the loop of a rig woke up, every tick of which goes to a recorder too, or nowhere.
WakeLatency latency_with(sixteen_axes::TickedLoop& rig, TickSink* recorder) {
  OfTheAct sink(recorder);
  LoopTrace trace(sixteen_axes::axes, {&sink});
  const LoopAudience audience;
  Stretch stretch(rig.transport());
  TimedRunner runner(rig.loop(), sixteen_axes::rate_hz, audience, trace, Lateness::time_stands_still,
                     RealTimeRequest{});
  for (const RealTimeRight& right : runner.rights())
    EXPECT_FALSE(right.is_needed && right.refusal) << right.name << ": " << right.refusal->what;
  EXPECT_TRUE(runner.run(stretch, std::nullopt).begun);
  EXPECT_EQ(sink.ticks(), ticks_of_a_stretch);
  EXPECT_TRUE(rig.is_running());
  return runner.latency();
}

struct Side {
  const char* name = "";
  std::vector<double> p50_us = {}, p99_us = {}, worst_us = {};

  void add(const WakeLatency& latency) {
    p50_us.push_back(latency.p50_us);
    p99_us.push_back(latency.p99_us);
    worst_us.push_back(latency.max_us);
  }
  void print() const {
    const auto median = [](std::vector<double> values) {
      std::ranges::sort(values);
      return values[values.size() / 2];
    };
    fmt::print("{:<16}{:>10.0f}{:>10.0f}{:>16.0f}{:>10.0f}\n", name, median(p50_us), median(p99_us),
               median(worst_us), *std::ranges::max_element(worst_us));
  }
};

TEST(TakeLatency, ATakeOfSixteenAxesAtOneKilohertzHasEveryTick) {
  std::ofstream("/proc/sys/kernel/sched_rt_runtime_us") << "-1";
  const TemporaryFolder folder;
  const std::string file = folder.path() / "takes.db";
  Side without{"without a take"}, with{"with a take"};
  for (int i = 0; i < stretches; ++i) {
    {
      sixteen_axes::TickedLoop rig;
      without.add(latency_with(rig, nullptr));
    }
    sixteen_axes::TickedLoop rig;
    TakeRecorder recorder({.file = file}, rig.take());
    with.add(latency_with(rig, &recorder));
    const KeptTake kept = recorder.finish("played", false);
    EXPECT_EQ(kept.lost, 0) << kept.why;
    EXPECT_EQ(kept.ticks, ticks_of_a_stretch);
  }
  fmt::print("microseconds after the deadline: {} stretches of {} ticks each\n", stretches,
             ticks_of_a_stretch);
  fmt::print("{:<16}{:>10}{:>10}{:>16}{:>10}\n", "", "median", "99 %", "worst (median)", "worst");
  without.print();
  with.print();
}

}  // namespace take_latency_test
}  // namespace inbetween
