// A simulated rig that runs for as long as it likes needs no more memory than one that has just begun.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <vector>

#include "host_tools/rig/rig_drives.hpp"
#include "host_tools/rig/simulated_hardware.hpp"
#include "inbetween/loop/tick_time.hpp"
#include "tests/support/rig_text.hpp"

#ifndef INBETWEEN_SANITIZED  // a sanitizer keeps what has been freed, and takes six times as long
namespace inbetween {
namespace rig_memory_test {

constexpr std::int32_t rate_hz = 2000;

long most_kilobytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

TEST(RigMemory, TenMillionTicksOfASimulatedDriveStayWithin64Megabytes) {
  const RigFile rig =
      parse_rig(rig_text({{.name = "slide", .min = 0, .max_acceleration = 1000, .drive = cia402_text(1)}},
                         {.rate_hz = rate_hz, .more = bus_can0}),
                "rig.toml");
  SimulatedHardware hardware(rig, {50});
  RigDrives drives(rig, hardware);
  std::vector<DriveState<double>> states(1);
  drives.enable();
  std::int64_t tick = 0;
  while (!states[0].is_on) {
    ASSERT_LT(++tick, 2 * rate_hz) << drives.trouble();
    drives.read(states, time_of_tick(tick, rate_hz));
    drives.write({}, time_of_tick(tick, rate_hz));
  }
  const long before = most_kilobytes();
  for (const std::int64_t end = tick + 10'000'000; tick < end;) {
    drives.read(states, time_of_tick(++tick, rate_hz));
    const Setpoint<double> setpoint{.position = 50 + 1e-3 * static_cast<double>(tick % 2)};
    drives.write({&setpoint, 1}, time_of_tick(tick, rate_hz));
  }
  EXPECT_TRUE(states[0].is_on) << drives.trouble();
  EXPECT_LT(most_kilobytes() - before, 64 * 1024);
}

}  // namespace rig_memory_test
}  // namespace inbetween
#endif
