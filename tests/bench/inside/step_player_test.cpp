#include "drivers/gpio/step_player.hpp"

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <memory>
#include <optional>
#include <ostream>
#include <thread>
#include <vector>

#include "drivers/gpio/step_thread.hpp"
#include "drivers/linux/monotonic_clock.hpp"
#include "tests/bench/inside/allowed_calls.hpp"
#include "tests/bench/inside/simulated_chip.hpp"

namespace inbetween::gpio {
namespace step_player_test {

constexpr std::int64_t us = 1'000;
constexpr std::int64_t ms = 1'000'000;
constexpr std::uint64_t step = 0b001;
constexpr std::uint64_t dir = 0b010;
constexpr std::uint64_t enable = 0b100;

/// On virtual time nobody may watch the clock: it stands still while anything runs.
constexpr StepPlayerSettings asleep_to_the_instant{.watch_ns = 0};

struct StepPlayerTest : ::testing::Test {
  SimulatedChip simulated{"io", 3};
  GpioChip chip;
  GpioOutputs outputs;
  std::unique_ptr<StepPlayer> player;
  const MonotonicClock clock{};

  void SetUp() override {
    ASSERT_FALSE(chip.open("io"));
    const std::array<OutputLine, 3> lines = {OutputLine{.line = 0U}, OutputLine{.line = 1U},
                                             OutputLine{.line = 2U}};
    ASSERT_FALSE(outputs.open(chip, lines));
    player = std::make_unique<StepPlayer>(outputs, asleep_to_the_instant);
  }

  /// `count` instants, the first at a time, which raise STEP and lower it in turn.
  void push_steps(std::int64_t at_ns, std::int64_t spacing_ns, int count) {
    for (int i = 0; i < count; ++i) {
      ASSERT_TRUE(
          player->push({.at_ns = at_ns + i * spacing_ns, .levels = i % 2 == 0 ? step : 0, .mask = step}));
    }
  }
};

struct StepPlayerOnVirtualTime : StepPlayerTest {
  void SetUp() override {
    if (!is_on_virtual_time()) GTEST_SKIP() << "run it alone";
    StepPlayerTest::SetUp();
    // double-time threads wake up when they should, and are not put off by one another.
    std::ofstream("/proc/sys/kernel/sched_rt_runtime_us") << "-1";
    const sched_param priority{.sched_priority = 10};
    ASSERT_EQ(::sched_setscheduler(0, SCHED_FIFO, &priority), 0);
    // A kernel that has just started has timers of 10 ms; after a few of them it has finer ones.
    clock.sleep_until_ns(clock.now_ns() + 1'000 * ms);
  }
  void TearDown() override {
    const sched_param none{.sched_priority = 0};
    ::sched_setscheduler(0, SCHED_OTHER, &none);
  }

  struct Change {
    std::int64_t at_ns = 0;
    unsigned levels = 0;
    bool operator==(const Change&) const = default;
  };
  static constexpr std::int64_t resolution_ns = 500 * us;
  /// What an oscilloscope would show, seen through the kernel at 0.25, 0.75, 1.25... ms after `from_ns`.
  std::vector<Change> changes(std::int64_t from_ns, std::int64_t to_ns) const {
    std::vector<Change> seen;
    unsigned before = simulated.levels();
    for (std::int64_t at_ns = from_ns + resolution_ns / 2; at_ns < to_ns; at_ns += resolution_ns) {
      clock.sleep_until_ns(at_ns);
      const unsigned now = simulated.levels();
      if (now != before) seen.push_back({.at_ns = at_ns - resolution_ns / 2 - from_ns, .levels = now});
      before = now;
    }
    return seen;
  }
};

std::ostream& operator<<(std::ostream& out, const StepPlayerOnVirtualTime::Change& change) {
  return out << change.levels << " at " << change.at_ns;
}

TEST_F(StepPlayerOnVirtualTime, TheEdgesOnTheLinesAreThoseThatWereGivenAtTheirTimes) {
  const StepThread thread(*player, std::nullopt);
  const std::int64_t start_ns = clock.now_ns() + 2 * ms;
  std::vector<Change> given;
  unsigned levels = 0;
  const auto give = [&](std::int64_t after_ns, std::uint64_t now, std::uint64_t mask) {
    ASSERT_TRUE(player->push({.at_ns = start_ns + after_ns, .levels = now, .mask = mask}));
    levels = static_cast<unsigned>((levels & ~mask) | now);
    // A change between two looks is seen at the second.
    given.push_back({.at_ns = after_ns, .levels = levels});
  };
  give(0, enable, enable);
  give(1 * ms, dir, dir);
  for (int i = 0; i < 20; ++i) {
    give(2 * ms + i * 4'500 * us, step, step);
    give(3'500 * us + i * 4'500 * us, 0, step);
  }
  give(100 * ms, step, step | dir);
  give(101 * ms, 0, step | enable);
  EXPECT_EQ(changes(start_ns, start_ns + 150 * ms), given);
  EXPECT_EQ(player->counters().played, given.size());
  EXPECT_EQ(player->counters().late, 0U);
  EXPECT_LE(player->counters().worst_late_ns, 10 * us) << "to read the clock takes a little of this time too";
  EXPECT_EQ(player->waiting(), 0U);
}

TEST_F(StepPlayerOnVirtualTime, LateInstantsAreAllPlayedAtTheirSpacing) {
  const StepThread thread(*player, std::nullopt);
  const std::int64_t start_ns = clock.now_ns();
  push_steps(start_ns - 50 * ms, 5 * ms, 8);
  const std::vector<Change> seen = changes(start_ns, start_ns + 60 * ms);
  ASSERT_EQ(seen.size(), 8U);
  for (std::size_t i = 1; i < seen.size(); ++i) {
    EXPECT_EQ(seen[i].levels, i % 2 == 0 ? step : 0);
    EXPECT_GE(seen[i].at_ns - seen[i - 1].at_ns, 5 * ms - resolution_ns) << i;
    EXPECT_LE(seen[i].at_ns - seen[0].at_ns, static_cast<std::int64_t>(i) * 5 * ms + resolution_ns) << i;
  }
  const StepPlayerCounters counters = player->counters();
  EXPECT_EQ(counters.played, 8U);
  EXPECT_EQ(counters.late, 1U) << "the others are on time after it";
  EXPECT_GE(counters.worst_late_ns, 50 * ms);
  EXPECT_LE(counters.worst_late_ns, 50 * ms + resolution_ns);
  EXPECT_TRUE(player->is_too_late());

  push_steps(start_ns + 100 * ms, 5 * ms, 4);
  const std::vector<Change> later = changes(start_ns + 100 * ms, start_ns + 120 * ms);
  ASSERT_EQ(later.size(), 4U);
  for (std::size_t i = 0; i < later.size(); ++i) {
    EXPECT_EQ(later[i].at_ns, static_cast<std::int64_t>(i) * 5 * ms) << "stood still: on time again";
  }
  EXPECT_EQ(player->counters().late, 1U);
  EXPECT_TRUE(player->is_too_late()) << "it stays true";
}

TEST_F(StepPlayerOnVirtualTime, ALatenessWithinTheLimitIsCountedAndNoMore) {
  const StepThread thread(*player, std::nullopt);
  push_steps(clock.now_ns() - 500 * us, ms, 2);
  clock.sleep_until_ns(clock.now_ns() + 5 * ms);
  EXPECT_EQ(player->counters().played, 2U);
  EXPECT_EQ(player->counters().late, 1U);
  EXPECT_FALSE(player->is_too_late());
}

TEST_F(StepPlayerOnVirtualTime, WhatIsDiscardedIsNotPlayedAndWhatFollowsIs) {
  const StepThread thread(*player, std::nullopt);
  const std::int64_t start_ns = clock.now_ns() + ms;
  push_steps(start_ns, ms, 100);
  clock.sleep_until_ns(start_ns + 2 * ms + 500 * us);
  player->discard();
  EXPECT_TRUE(changes(start_ns + 2 * ms + 500 * us, start_ns + 20 * ms).empty());
  EXPECT_EQ(simulated.levels(), step) << "the pulse that had begun";
  EXPECT_EQ(player->counters().played, 3U);
  EXPECT_EQ(player->counters().discarded, 97U);
  EXPECT_EQ(player->waiting(), 0U);

  ASSERT_TRUE(player->push({.at_ns = start_ns + 30 * ms, .levels = dir, .mask = dir | step}));
  clock.sleep_until_ns(start_ns + 29 * ms);
  EXPECT_EQ(simulated.levels(), step);
  clock.sleep_until_ns(start_ns + 31 * ms);
  EXPECT_EQ(simulated.levels(), dir);
}

// The player sleeps to an instant far away when it is told: what comes instead is not kept waiting by it.
TEST_F(StepPlayerOnVirtualTime, AfterADiscardTheNextInstantMayBeEarlierThanTheOneThatWasAwaited) {
  const StepThread thread(*player, std::nullopt);
  const std::int64_t start_ns = clock.now_ns();
  push_steps(start_ns + 3'600'000 * ms, ms, 2);
  clock.sleep_until_ns(start_ns + 10 * ms);
  player->discard();
  push_steps(start_ns + 12 * ms, ms, 1);
  clock.sleep_until_ns(start_ns + 12 * ms + 10 * us);
  EXPECT_EQ(simulated.levels(), step);
  EXPECT_EQ(player->counters().late, 0U);
}

TEST_F(StepPlayerOnVirtualTime, AnUnpluggedChipEndsIt) {
  const StepThread thread(*player, std::nullopt);
  const std::int64_t start_ns = clock.now_ns() + ms;
  push_steps(start_ns, ms, 10);
  clock.sleep_until_ns(start_ns + 4 * ms + 500 * us);
  EXPECT_FALSE(player->has_ended());
  simulated.unplug();
  clock.sleep_until_ns(start_ns + 20 * ms);
  EXPECT_TRUE(player->has_ended());
  EXPECT_EQ(outputs.state(), ChipState::gone);
  EXPECT_EQ(player->counters().played, 5U);
  EXPECT_FALSE(player->push({.at_ns = start_ns + 30 * ms, .levels = 0, .mask = step}));
  EXPECT_EQ(player->counters().refused, 1U);
}

TEST_F(StepPlayerOnVirtualTime, EndedInTheMiddleOfAPulseItLeavesTheLinesSafe) {
  {
    const StepThread thread(*player, std::nullopt);
    const std::int64_t start_ns = clock.now_ns() + ms;
    ASSERT_TRUE(player->push({.at_ns = start_ns, .levels = enable, .mask = enable}));
    push_steps(start_ns + ms, ms, 10);
    clock.sleep_until_ns(start_ns + ms + 500 * us);
    EXPECT_EQ(simulated.levels(), step | enable);
  }
  EXPECT_EQ(simulated.levels(), 0U);
  EXPECT_TRUE(player->has_ended());
  EXPECT_EQ(player->counters().played, 2U);
  EXPECT_EQ(player->waiting(), 9U);
}

TEST_F(StepPlayerTest, AFullRingRefusesAndCounts) {
  push_steps(0, us, StepPlayer::capacity);
  EXPECT_FALSE(player->push({.at_ns = 0, .levels = 0, .mask = step}));
  EXPECT_EQ(player->counters().refused, 1U);
  EXPECT_EQ(player->waiting(), StepPlayer::capacity);
}

TEST_F(StepPlayerTest, AnInstantForALineThatIsNoneEndsItSafely) {
  ASSERT_TRUE(outputs.set(enable, enable));
  ASSERT_TRUE(player->push({.at_ns = 0, .levels = 0b1000, .mask = 0b1000}));
  player->run();
  EXPECT_EQ(outputs.state(), ChipState::failed);
  EXPECT_TRUE(player->has_ended());
  EXPECT_EQ(simulated.levels(), 0U);
}

std::ptrdiff_t refused_rights(const StepThread& thread) {
  return std::ranges::count_if(thread.rights(),
                               [](const RealTimeRight& right) { return right.is_needed && right.refusal; });
}

TEST_F(StepPlayerTest, ItsThreadIsARealTimeThreadWhereTheMachineAllowsIt) {
  std::ofstream("/proc/sys/kernel/sched_rt_runtime_us") << "-1";
  {
    const StepThread thread(*player, RealTimeRequest{.priority = 85, .locks_memory = false});
    EXPECT_EQ(refused_rights(thread), 0);
    EXPECT_EQ(thread.rights().size(), 4U) << "all but a processor and locked memory";
    EXPECT_EQ(::sched_getscheduler(0), SCHED_OTHER) << "this thread is none";
  }
  EXPECT_TRUE(player->has_ended());
}

TEST_F(StepPlayerTest, WithoutRightsItsThreadSaysSoAndPlaysAllTheSame) {
  const StepThread thread(*player, RealTimeRequest{.priority = 100, .locks_memory = false});
  EXPECT_GT(refused_rights(thread), 0);
  push_steps(clock.now_ns(), us, 3);
  while (player->waiting() > 0) ::sched_yield();
  EXPECT_EQ(player->counters().played, 3U);
}

// It sleeps, watches the clock, is late, discards, naps and sets the safe levels.
TEST_F(StepPlayerTest, ItsSystemCallsAreSleepAndIoctlAlone) {
  StepPlayer watching(outputs, {.watch_ns = 300 * us});
  std::optional<std::thread> feeder;
  const auto prepare = [&] {
    for (int i = 0; i < 100; ++i) {
      const std::int64_t at_ns = clock.now_ns() + 2 * ms + i * 200 * us;
      if (!watching.push({.at_ns = at_ns, .levels = i % 2 == 0 ? step : 0, .mask = step})) ::_exit(1);
    }
    feeder.emplace([&] {
      while (watching.waiting() > 0) ::sched_yield();
      for (int i = 0; i < 10; ++i) {
        if (!watching.push({.at_ns = clock.now_ns() + 3'600'000 * ms, .levels = step, .mask = step}))
          ::_exit(2);
      }
      watching.discard();
      while (watching.waiting() > 0) ::sched_yield();
      watching.end();
    });
  };
  const auto loop = [&] {
    watching.run();
    const StepPlayerCounters counters = watching.counters();
    if (counters.played != 100 || counters.discarded != 10) ::_exit(3);
    ::_exit(0);  // to join the feeder takes another call
  };
  EXPECT_EQ(only_loop_calls(prepare, loop, {SYS_clock_nanosleep, SYS_ioctl}), "");
}

}  // namespace step_player_test
}  // namespace inbetween::gpio
