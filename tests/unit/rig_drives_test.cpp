// What a rig file says of its CAN drives, and what is refused before a bus is opened.
#include "host_tools/rig/rig_drives.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "host_tools/rig/simulated_hardware.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "tests/support/rig_text.hpp"

namespace inbetween {
namespace rig_drives_test {

using testing::HasSubstr;
using testing::StartsWith;

RigFile rig_of(int count, int rate_hz, int bitrate, double scale = -1000,
               const std::string& watchdog = "heartbeat") {
  std::vector<AxisText> axes;
  for (int i = 1; i <= count; ++i) {
    axes.push_back(axis_text(fmt::format("a{}", i), "mm", {-10.5, 200}, {.velocity = 250}, "",
                             fmt::format(R"({}, watchdog = "{}")", cia402_text(i, scale), watchdog)));
  }
  return parse_rig(
      rig_text(axes, {.rate_hz = rate_hz, .more = fmt::format("[bus.can0]\nbitrate = {}\n", bitrate)}),
      "rig.toml");
}

// docs/faults.md 12
TEST(RigDrives, ABusThatWouldBeTooFullIsRefusedWithItsLoad) {
  EXPECT_NO_THROW(refuse_overloaded_buses(rig_of(5, 500, 1'000'000)));
  try {
    refuse_overloaded_buses(rig_of(6, 500, 1'000'000));
    FAIL() << "taken";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), StartsWith("rig.toml:3:"));
    EXPECT_THAT(error.what(),
                HasSubstr("the 6 drives on bus \"can0\" need 74.8 % of its 1000000 bit/s at 500 Hz"));
    EXPECT_THAT(error.what(), HasSubstr("(5 fit)"));
  }
}

TEST(RigDrives, ABusWithMoreFramesInATickThanAreSentAtOnceIsRefused) {
  const auto guarded = [](int axes) { return rig_of(axes, 50, 1'000'000, 1000, "life-guarding"); };
  EXPECT_NO_THROW(refuse_overloaded_buses(guarded(30)));
  EXPECT_NO_THROW(refuse_overloaded_buses(rig_of(58, 50, 1'000'000)));
  EXPECT_THAT([&] { refuse_overloaded_buses(guarded(31)); },
              testing::ThrowsMessage<InputError>(
                  testing::AllOf(StartsWith("rig.toml:3:"),
                                 HasSubstr("the 31 drives on bus \"can0\", 31 of them "
                                           "guarded, need 65 frames in a tick"),
                                 HasSubstr("64 are sent at once; spread them over more buses"))));
  EXPECT_THAT([&] { refuse_overloaded_buses(rig_of(62, 40, 1'000'000)); },
              testing::ThrowsMessage<InputError>(HasSubstr("need 65 frames")));
}

TEST(RigDrives, AnAxisTellsItsDriveItsRangeAndItsStep) {
  RigFile rig = rig_of(1, 250, 1'000'000);
  rig.axes[0].reference = Reference::by_drive;
  const can::Cia402Settings settings = settings_of(rig.axes[0], rig.rate_hz);
  ASSERT_TRUE(settings.setup.position_limits);
  EXPECT_EQ(settings.setup.position_limits->min, -200'000) << "the scale turns the direction round";
  EXPECT_EQ(settings.setup.position_limits->max, 10'500);
  EXPECT_EQ(settings.max_step_counts, 1'201) << "1.2 times 250 mm/s in 4 ms, and a count for rounding";
  EXPECT_GE(settings.setup.host_timeout_ms, 90);
}

// Its drive would clip the targets wherever its own limits happen to lie.
TEST(RigDrives, AnAxisWhoseCountsBeginElsewhereHasNoSoftLimitsInItsDrive) {
  for (const char* const more :
       {R"(reference = "operator")",
        R"(home = { by = "drive", method = 17, fast = 20, slow = 5, acceleration = 200 })"}) {
    const RigFile rig = parse_rig(rig_text({{.name = "slide", .more = more, .drive = cia402_text(1, 1000)}},
                                           {.more = "[bus.can0]\nbitrate = 1_000_000\n"}),
                                  "rig.toml");
    const can::Cia402Settings settings = settings_of(rig.axes[0], rig.rate_hz);
    ASSERT_TRUE(settings.setup.position_limits) << more;
    EXPECT_EQ(settings.setup.position_limits->min, std::numeric_limits<std::int32_t>::min()) << more;
    EXPECT_EQ(settings.setup.position_limits->max, std::numeric_limits<std::int32_t>::max()) << more;
  }
}

TEST(RigDrives, ASlowRigGivesItsDrivesTheTimeOfSeveralTicks) {
  const RigFile rig = rig_of(1, 10, 1'000'000);
  const can::Cia402Settings settings = settings_of(rig.axes[0], rig.rate_hz);
  EXPECT_GE(settings.setup.host_timeout_ms, 300);
  EXPECT_GE(settings.setup.setpoint_timeout_ms, 300);
}

// --- drives that are told where their axes stand

const std::string one_of_each = rig_text(
    {axis_text("steps", "mm", {0, 500}, {.velocity = 50, .acceleration = 100}, R"(reference = "operator")",
               R"(type = "step-dir", chip = "gpio", step = 17, dir = 27, steps_per_unit = 40)"),
     axis_text("can", "deg", {-90, 90}, {.velocity = 12, .acceleration = 70}, R"(reference = "operator")",
               cia402_text(1)),
     axis_text("odrive", "deg", {-30, 30}, {.velocity = 60, .acceleration = 100}, R"(reference = "operator")",
               R"(type = "odrive", bus = "can0", node = 2, turns_per_unit = 0.1, firmware = "0.6")"),
     axis_text("pipe", "deg", {-30, 30}, {.velocity = 60, .acceleration = 100}, "",
               R"(type = "pipe", path = "/tmp/pipe", counts_per_unit = 10)")},
    {.name = "each", .rate_hz = 250, .more = bus_can0});

TEST(RigDrives, EveryKindOfDriveTakesWhereItsAxisStandsAndGoesFromThere) {
  const RigFile rig = parse_rig(one_of_each, "rig.toml");
  const std::vector<double> truly{100, 5, 6, 7};
  SimulatedHardware hardware(rig, truly);
  RigDrives drives(rig, hardware);
  for (std::size_t a = 0; a < 4; ++a) drives.place(a, 20 + static_cast<double>(a));
  drives.enable();
  std::vector<DriveState> states(4);
  std::vector<Setpoint> setpoints;
  const auto is_on = [](const DriveState& state) { return state.is_on; };
  std::int64_t now_ns = 0;
  int ticks_on = 0;
  for (int tick = 0; tick < 3000 && ticks_on < 100; ++tick) {
    drives.read(states, now_ns += 4'000'000);
    if (std::ranges::all_of(states, is_on) && ++ticks_on == 1) {
      for (std::size_t a = 0; a < 4; ++a) {
        EXPECT_NEAR(states[a].actual, 20 + static_cast<double>(a), 1e-9) << a;
        EXPECT_NEAR(hardware.true_position(a), truly[a], 1e-6) << a;
        setpoints.push_back({.position = states[a].actual});
      }
    }
    // Slowly to 0.125 further.
    if (ticks_on > 1 && ticks_on <= 51) {
      for (Setpoint& setpoint : setpoints) setpoint.position += 0.0025;
    }
    drives.write(setpoints, now_ns);
  }
  for (std::size_t a = 0; a < 4; ++a) {
    EXPECT_NEAR(states[a].actual, 20.125 + static_cast<double>(a), 1e-3) << a;
    EXPECT_NEAR(hardware.true_position(a), truly[a] + 0.125, 1e-3) << a;
  }
  const Counters counts = drives.counts();
  ASSERT_EQ(counts.drives.size(), 3U);
  EXPECT_EQ(counts.drives[0].of, "can");
  EXPECT_EQ(counts.drives[1].of, "odrive");
  EXPECT_EQ(counts.drives[2].of, "steps");
}

TEST(RigDrives, APlaceThatADriveCannotCountToIsRefusedAtItsAxis) {
  const RigFile rig = parse_rig(one_of_each, "rig.toml");
  SimulatedHardware hardware(rig, {0, 0, 0, 0});
  RigDrives drives(rig, hardware);
  for (const std::size_t axis : {0U, 1U}) {
    EXPECT_THAT([&] { drives.place(axis, 1e15); },
                testing::ThrowsMessage<InputError>(
                    testing::AllOf(StartsWith("rig.toml:"), HasSubstr("from 0"), HasSubstr("put 0 nearer"))));
  }
}

}  // namespace rig_drives_test
}  // namespace inbetween
