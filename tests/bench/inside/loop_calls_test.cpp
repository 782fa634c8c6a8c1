#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cstdint>

#include "drivers/can/socket_can.hpp"
#include "drivers/linux/monotonic_clock.hpp"
#include "drivers/linux/telemetry_ring.hpp"
#include "tests/bench/inside/allowed_calls.hpp"
#include "tests/bench/inside/raw_bus.hpp"

namespace inbetween {
namespace loop_calls_test {

TEST(LoopCalls, AnyOtherSystemCallIsFound) {
  EXPECT_EQ(only_loop_calls([] {}, [] { ::getppid(); }), "Bad system call");
  EXPECT_EQ(only_loop_calls([] {}, [] {}), "");
}

// What a tick is made of, without what is computed in between.
TEST(LoopCalls, ClockBusAndTelemetryMakeNoOtherThanSleepSendAndReceive) {
  can::SocketCan bus;
  RawBus other("can0");
  TelemetryRing<std::int64_t, 4> ring;
  const MonotonicClock clock;
  const auto prepare = [&] {
    const std::array<can::CanFilter, 1> answers = {can::CanFilter{.id = 0x181}};
    if (bus.open("can0", answers)) ::_exit(1);
    for (std::uint8_t i = 0; i < 10; ++i) other.send(0x181, {i});
  };
  const auto loop = [&] {
    std::array<can::Frame, 4> in;
    std::array<can::Frame, 2> out;
    std::int64_t deadline_ns = clock.now_ns();
    bus.drain();
    for (int tick = 0; tick < 20; ++tick) {
      deadline_ns += 1'000'000;
      clock.sleep_until_ns(deadline_ns);
      bus.receive(in);
      bus.send(out);
      ring.push(deadline_ns);
    }
    if (bus.counters().sent != 40 || ring.dropped() != 16) ::_exit(2);
  };
  EXPECT_EQ(only_loop_calls(prepare, loop), "");
}

}  // namespace loop_calls_test
}  // namespace inbetween
