// How fast this machine steps, against how fast it could if stepping were all it did. A number to read:
// nothing here fails for being slow.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>

#include "drivers/gpio/gpio_outputs.hpp"
#include "drivers/gpio/step_player.hpp"
#include "drivers/linux/monotonic_clock.hpp"
#include "tests/bench/inside/simulated_chip.hpp"

namespace inbetween::gpio {
namespace step_rate_test {

constexpr int instants = 4'000;
constexpr std::uint64_t lines_of_an_instant = 0b0011;

double ns_each(std::int64_t ns) {
  return static_cast<double>(ns) / instants;
}

/// The same system call, and nothing else.
double bare_call_ns(GpioOutputs& outputs) {
  const MonotonicClock clock;
  const std::int64_t begun_ns = clock.now_ns();
  for (int i = 0; i < instants; ++i) outputs.set(i % 2 == 0 ? lines_of_an_instant : 0, lines_of_an_instant);
  return ns_each(clock.now_ns() - begun_ns);
}

/// All at once: each is played when the one before it is.
double played_ns(GpioOutputs& outputs) {
  StepPlayer player(outputs, {});
  const std::int64_t begun_ns = MonotonicClock().now_ns();
  for (int i = 0; i < instants; ++i) {
    const std::uint64_t levels = i % 2 == 0 ? lines_of_an_instant : 0;
    EXPECT_TRUE(player.push({.at_ns = begun_ns, .levels = levels, .mask = lines_of_an_instant}));
  }
  // A line that is none ends it.
  EXPECT_TRUE(player.push({.at_ns = begun_ns, .levels = 0, .mask = 1U << 31}));
  const std::int64_t run_ns = MonotonicClock().now_ns();
  player.run();
  const std::int64_t ended_ns = MonotonicClock().now_ns();
  EXPECT_EQ(player.counters().played, instants);
  return ns_each(ended_ns - run_ns);
}

double clock_ns() {
  const MonotonicClock clock;
  const std::int64_t begun_ns = clock.now_ns();
  std::int64_t now_ns = begun_ns;
  for (int i = 0; i < instants; ++i) now_ns = clock.now_ns();
  return ns_each(now_ns - begun_ns);
}

TEST(StepRate, TheHighestAsAShareOfTheBareSystemCallIsReported) {
  const SimulatedChip simulated("io", 4);
  GpioChip chip;
  ASSERT_FALSE(chip.open("io"));
  const std::array<OutputLine, 4> lines = {OutputLine{.line = 0U}, OutputLine{.line = 1U},
                                           OutputLine{.line = 2U}, OutputLine{.line = 3U}};
  GpioOutputs outputs;
  // The best of several: what is slower was held up by something else.
  double call_ns = 1e9;
  double play_ns = 1e9;
  double reading_ns = 1e9;
  for (int round = 0; round < 5; ++round) {
    ASSERT_FALSE(outputs.open(chip, lines));
    call_ns = std::min(call_ns, bare_call_ns(outputs));
    play_ns = std::min(play_ns, played_ns(outputs));
    reading_ns = std::min(reading_ns, clock_ns());
  }
  std::printf(
      "highest step rate: %.1f kHz, %.0f %% of the bare call's %.1f kHz; a call takes %.2f us, an instant "
      "%.2f "
      "us, of which reading the clock takes %.2f us (without that: %.0f %%)\n",
      1e6 / play_ns, 100 * call_ns / play_ns, 1e6 / call_ns, call_ns / 1e3, play_ns / 1e3, reading_ns / 1e3,
      100 * call_ns / (play_ns - reading_ns));
}

}  // namespace step_rate_test
}  // namespace inbetween::gpio
