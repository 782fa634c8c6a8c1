// What ticks a motion loop, and whoever watches it.
#include "host_tools/loop/loop_runner.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>

#include "host_tools/loop/loop_storage.hpp"
#include "host_tools/rig/gpio_inputs.hpp"
#include "host_tools/rig/rig_drives.hpp"
#include "host_tools/rig/simulated_hardware.hpp"
#include "tests/support/rig_text.hpp"

namespace inbetween {
namespace loop_runner_test {

/// A move that takes some ticks to rest once somebody wants to leave.
class SlowToRest final : public LoopTask {
 public:
  void press(TransportKey key) override { leaves_ = leaves_ || key == TransportKey::quit; }
  void tick(std::int32_t, std::int64_t) override {
    if (leaves_) ++ticks_to_rest_;
  }
  [[nodiscard]] bool is_over() const override { return ticks_to_rest_ >= 20; }
  [[nodiscard]] RunSnapshot snapshot() const override { return {}; }

 private:
  std::atomic<bool> leaves_{false};
  std::atomic<int> ticks_to_rest_{0};
};

/// A simulated stepper and its loop.
struct Rig {
  RigFile file = parse_rig(
      rig_text({{.name = "slide",
                 .drive = R"(type = "step-dir", chip = "gpio", step = 17, dir = 27, steps_per_unit = 40)"}},
               {.rate_hz = 1000}),
      "rig.toml");
  SimulatedHardware hardware{file, {0}};
  RigDrives drives{file, hardware};
  RigInputs lines{file, hardware};
  LoopStorage room{1, 1};
  RunLoop loop{drives, lines, room.memory()};
  LoopTrace trace{1};
};

TEST(TimedRunner, WhatTheAudienceThrowsIsHeardOnlyOnceTheMoveRests) {
  Rig rig;
  const LoopAudience audience{
      .status = [](const RunSnapshot&) { throw std::runtime_error("the terminal is lost"); }};
  TimedRunner runner(rig.loop, 1000, audience, rig.trace, Lateness::time_stands_still, std::nullopt);
  SlowToRest move;
  EXPECT_THROW(runner.run(move, std::nullopt), std::runtime_error);
  EXPECT_TRUE(move.is_over()) << "the loop would go on with a move that is gone";
}

/// Over once it is told that the terminal tells when a key is let go.
class WaitsForReleases final : public LoopTask {
 public:
  void press(TransportKey key) override { is_told_ = is_told_ || key == TransportKey::tells_releases; }
  void tick(std::int32_t, std::int64_t) override {}
  [[nodiscard]] bool is_over() const override { return is_told_; }
  [[nodiscard]] RunSnapshot snapshot() const override { return {}; }

 private:
  std::atomic<bool> is_told_{false};
};

// A terminal answers once, while whatever runs first.
TEST(LoopRunner, EveryTaskIsToldThatTheTerminalTellsReleases) {
  Rig fast_rig, timed_rig;
  int reads = 0;
  const LoopAudience audience{.keys = [&] { return ++reads == 3 ? std::string("\x1b[?2u") : std::string(); }};
  FastRunner fast(fast_rig.loop, 1000, audience, fast_rig.trace);
  TimedRunner timed(timed_rig.loop, 1000, audience, timed_rig.trace, Lateness::time_stands_still,
                    std::nullopt);
  for (int i = 0; i < 2; ++i) {
    WaitsForReleases task;
    EXPECT_TRUE(fast.run(task, std::nullopt).begun);
  }
  reads = 0;
  for (int i = 0; i < 2; ++i) {
    WaitsForReleases task;
    EXPECT_TRUE(timed.run(task, std::nullopt).begun);
  }
}

}  // namespace loop_runner_test
}  // namespace inbetween
