// One move on drives of three protocols on two buses: how far they are apart in time.
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "host_tools/rig/rig_drives.hpp"
#include "host_tools/rig/simulated_hardware.hpp"
#include "tests/support/rig_text.hpp"

namespace inbetween {
namespace mixed_drives_test {

constexpr std::size_t axes = 4;
constexpr std::int64_t tick_ns = 4'000'000;
constexpr double tick_s = 0.004;

/// CiA 402 and two ODrives share can0, a moteus is on can1.
RigFile mixed_rig() {
  std::vector<AxisText> texts;
  for (const std::string& drive :
       {cia402_text(1, 4000),
        std::string(R"(type = "odrive", bus = "can0", node = 8, turns_per_unit = 0.125, firmware = "0.6")"),
        std::string(R"(type = "odrive", bus = "can0", node = 9, turns_per_unit = -0.2, firmware = "0.5")"),
        std::string(R"(type = "moteus", bus = "can1", node = 1, turns_per_unit = 0.1)")}) {
    texts.push_back(axis_text(fmt::format("a{}", texts.size()), "deg", {-90, 90},
                              {.velocity = 60, .acceleration = 400}, "", drive));
  }
  return parse_rig(
      rig_text(texts, {.rate_hz = 250,
                       .more = bus_can0 + "[bus.can1]\nbitrate = 1000000\ndata_bitrate = 5000000\n"}),
      "rig.toml");
}

/// There and back in two seconds, at rest at both ends.
Setpoint swing(double s) {
  constexpr double way = 10;
  constexpr double omega = 3.14159265358979323846;
  return {.position = way * (1 - std::cos(omega * s)), .velocity = way * omega * std::sin(omega * s)};
}

/// By how much each axis is behind the plan, in seconds, by least squares over the swing.
std::array<double, axes> lags_of_a_swing() {
  const RigFile rig = mixed_rig();
  SimulatedHardware hardware(rig, std::vector<double>(axes, 0));
  RigDrives drives(rig, hardware);
  std::vector<DriveState> states(axes);
  drives.enable();
  std::int64_t now_ns = 0;
  const auto is_on = [](const DriveState& state) { return state.is_on; };
  for (int tick = 0; tick < 3000 && !std::ranges::all_of(states, is_on); ++tick) {
    drives.read(states, now_ns += tick_ns);
    drives.write({}, now_ns);
  }
  EXPECT_TRUE(std::ranges::all_of(states, is_on)) << drives.trouble();
  std::array<double, axes> behind{}, squares{};
  for (int tick = 0; tick < 500; ++tick) {
    drives.read(states, now_ns += tick_ns);
    const Setpoint planned = swing(tick * tick_s);
    for (std::size_t a = 0; a < axes; ++a) {
      behind[a] += planned.velocity * (planned.position - hardware.true_position(a));
      squares[a] += planned.velocity * planned.velocity;
      EXPECT_EQ(states[a].condition, DriveCondition::fine) << drives.trouble();
    }
    const std::vector<Setpoint> next(axes, swing((tick + 1) * tick_s));
    drives.write(next, now_ns);
  }
  for (std::size_t a = 0; a < axes; ++a) behind[a] /= squares[a];
  return behind;
}

// An ODrive holds a position from when it comes. A CiA 402 drive goes to it in the tick after SYNC, and a
// moteus by the velocity that came with the last one. So the motors of these are together, and those of
// ODrives half a tick before them, which docs/drives.md says.
TEST(MixedDrives, TheMotorsOfThreeProtocolsAreAtMostHalfATickApart) {
  const std::array<double, axes> lags = lags_of_a_swing();
  for (std::size_t a = 0; a < axes; ++a) {
    RecordProperty(fmt::format("lag_of_axis_{}_us", a), static_cast<int>(lags[a] * 1e6));
  }
  SCOPED_TRACE(fmt::format("behind the plan by {:.5f} s", fmt::join(lags, ", ")));
  EXPECT_NEAR(lags[0] - lags[1], 0.5 * tick_s, 0.15 * tick_s);
  EXPECT_NEAR(lags[1], lags[2], 0.05 * tick_s) << "two ODrives of two families";
  EXPECT_NEAR(lags[0], lags[3], 0.1 * tick_s) << "CiA 402 and moteus";
  EXPECT_LT(lags[0], 3 * tick_s);
}

}  // namespace mixed_drives_test
}  // namespace inbetween
